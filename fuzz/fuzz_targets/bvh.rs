//! Arbitrary triangles and rays: no panic, no endless traversal, and the same hits with every builder and traversal.
#![no_main]

#[path = "../../crates/turner-bvh/tests/suite/bytes.rs"]
mod bytes;

libfuzzer_sys::fuzz_target!(|data: &[u8]| bytes::check(data));
