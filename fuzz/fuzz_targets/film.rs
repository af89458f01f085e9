//! Arbitrary bytes as a saved film.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::film(data));
