//! Arbitrary bytes as a TGA image.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::picture("a.tga", data));
