//! Any bytes as stl.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::model("model.stl", data));
