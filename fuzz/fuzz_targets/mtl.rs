//! Arbitrary bytes as an MTL library.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::named("model.mtl", data));
