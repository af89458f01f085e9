//! Arbitrary bytes as a binary USD layer.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::model("model.usdc", data));
