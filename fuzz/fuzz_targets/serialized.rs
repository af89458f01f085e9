//! Arbitrary bytes as a serialized mesh of a Mitsuba scene.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::named("mesh.serialized", data));
