//! Arbitrary bytes as a GLB model.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::model("model.glb", data));
