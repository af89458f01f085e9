//! Arbitrary bytes as an IES profile.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::named("lamp.ies", data));
