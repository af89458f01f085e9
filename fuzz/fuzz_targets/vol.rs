//! Arbitrary bytes as a grid volume of a Mitsuba scene.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::named("cloud.vol", data));
