//! Arbitrary bytes as a KTX2 image.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::picture("a.ktx2", data));
