//! Arbitrary bytes as a TOML scene.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::scene(data));
