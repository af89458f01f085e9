//! Arbitrary bytes as a spectrum file.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::named("metal.spd", data));
