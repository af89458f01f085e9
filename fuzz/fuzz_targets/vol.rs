//! Any bytes as a volume that a scene of Mitsuba names.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::named("cloud.vol", data));
