//! Arbitrary bytes as a USD text layer.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::model("model.usda", data));
