//! Arbitrary bytes as a font, TrueType or OpenType by their first bytes.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::named("font.ttf", data));
