//! Arbitrary bytes as a checkpoint.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::checkpoint(data));
