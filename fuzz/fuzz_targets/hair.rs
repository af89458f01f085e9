//! Arbitrary bytes as a HAIR file of curves.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::named("fur.hair", data));
