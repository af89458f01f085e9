//! Measures how long images take to decode: `cargo run --release -p turner-io --features tools --example
//! decode_pictures -- THREADS MAX FILE…`, where MAX is the longest side, or 0 for no limit.

use std::time::Instant;

use turner_io::image::{ColorOrData, DecodeLimits, decode_all};

fn main() {
    let mut arguments = std::env::args().skip(1);
    let mut number = || arguments.next().and_then(|a| a.parse::<u32>().ok()).unwrap_or(0);
    let (threads, max) = (number() as usize, number());
    let files: Vec<_> = arguments.map(|name| (std::fs::read(&name).unwrap_or_default(), name)).collect();
    let pictures: Vec<_> =
        files.iter().map(|(bytes, name)| (&bytes[..], name.as_str(), ColorOrData::Color)).collect();
    let start = Instant::now();
    let images = decode_all(&pictures, &DecodeLimits::default(), threads, (max > 0).then_some(max));
    let seconds = start.elapsed().as_secs_f64();
    let mut bytes = 0;
    for result in images {
        match result {
            Ok(image) => bytes += image.memory(),
            Err(e) => println!("{e}"),
        }
    }
    println!("{} images, {bytes} bytes of samples, {seconds:.3} s", files.len());
}
