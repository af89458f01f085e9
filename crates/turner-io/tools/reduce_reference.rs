//! Downscales images by averaging blocks of 8 × 8 pixels: `cargo run -p turner-io --features tools --example
//! reduce_reference FROM.exr TO.exr …`, in pairs.

use std::path::Path;

use turner::testing::Reference;
use turner_io::image::{DecodeLimits, ImageFormat, Metadata, OutputImage, Transfer, decode, encode};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let names: Vec<String> = std::env::args().skip(1).collect();
    for pair in names.chunks_exact(2) {
        let image = decode(&std::fs::read(&pair[0])?, &pair[0], &DecodeLimits::default())?;
        let row = |y: u32| (0..image.width).map(move |x| (x, y));
        let mean = (0..image.height).flat_map(row).map(|(x, y)| image.rgb(x, y).map(f64::from)).collect();
        let small = Reference::with_noise(image.width, image.height, mean, 0.0).reduced(8);
        let rgba = |p: &[f64; 3]| [p[0] as f32, p[1] as f32, p[2] as f32, 1.0];
        let pixels: Vec<[f32; 4]> = small.mean.iter().map(rgba).collect();
        let picture = OutputImage {
            width: small.width,
            height: small.height,
            alpha: false,
            linear: Some(&pixels),
            transfer: Transfer::Unstated,
            metadata: &Metadata::new(),
            threads: 1,
            ..OutputImage::default()
        };
        std::fs::write(Path::new(&pair[1]), encode(&picture, ImageFormat::Exr)?)?;
    }
    Ok(())
}
