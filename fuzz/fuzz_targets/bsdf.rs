//! Arbitrary bytes as a file of a measured BRDF.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::named("paint.bsdf", data));
