//! Any bytes as a film.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::film(data));
