//! Any triangles and any rays: no panic, no endless search, and the same hits however a tree is built and asked.
#![no_main]

#[path = "../../crates/turner-bvh/tests/suite/bytes.rs"]
mod bytes;

libfuzzer_sys::fuzz_target!(|data: &[u8]| bytes::check(data));
