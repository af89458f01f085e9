//! Arbitrary bytes as a density grid.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::named("cloud.grid", data));
