//! Any bytes as a mesh that a scene of Mitsuba names.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::named("mesh.serialized", data));
