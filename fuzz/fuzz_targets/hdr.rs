//! Arbitrary bytes as a Radiance HDR image.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::picture("a.hdr", data));
