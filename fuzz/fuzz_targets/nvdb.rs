//! Arbitrary bytes as a NanoVDB file.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::named("cloud.nvdb", data));
