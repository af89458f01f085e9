//! Any bytes as a scene of Mitsuba.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| turner_fuzz::model("scene.xml", data));
