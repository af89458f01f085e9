//! Arbitrary bytes as an OpenEXR image.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::picture("a.exr", data));
