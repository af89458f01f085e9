//! Arbitrary bytes as a USD package.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::model("model.usdz", data));
