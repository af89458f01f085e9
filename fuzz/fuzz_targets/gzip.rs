//! Arbitrary gzip-compressed bytes, and arbitrary bytes in place of compressed ones, as a pbrt scene.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    turner_fuzz::model("scene.pbrt", &[&[0x1f, 0x8b], data].concat());
    turner_fuzz::model("scene.pbrt", &turner_io::testing::seeds::gzip(data));
});
