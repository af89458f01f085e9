//! Environment maps from files: a colour in one part of the image arrives from the matching direction.

use std::sync::Arc;

use turner::color::Spectrum;
use turner::light::EnvironmentDesc;
use turner::math::DVec3;
use turner::schema::{Asset, ImageId};
use turner_io::image::{DecodeLimits, Display, ImageFormat, Metadata, OutputImage, Transfer, decode, encode};

/// An image of 8 x 4: red along −z, green along +x, blue along +z, white above, black elsewhere. Its values are exact
/// in every format.
fn picture() -> Vec<[f32; 4]> {
    let mut pixels = vec![[0.0, 0.0, 0.0, 1.0]; 32];
    let mut set = |x: usize, y: usize, color: [f32; 3]| pixels[y * 8 + x][..3].copy_from_slice(&color);
    for y in [1, 2] {
        set(3, y, [1.0, 0.0, 0.0]);
        set(4, y, [1.0, 0.0, 0.0]);
        set(5, y, [0.0, 1.0, 0.0]);
        set(6, y, [0.0, 1.0, 0.0]);
        set(7, y, [0.0, 0.0, 1.0]);
        set(0, y, [0.0, 0.0, 1.0]);
    }
    (0..8).for_each(|x| set(x, 0, [1.0; 3]));
    pixels
}

#[test]
fn every_format_lies_the_same_way() {
    let linear = picture();
    let eight: Vec<[u8; 4]> = linear.iter().map(|p| p.map(|v| (v * 255.0) as u8)).collect();
    let output = OutputImage {
        width: 8,
        height: 4,
        alpha: false,
        linear: Some(&linear),
        display: Some(Display::U8(&eight)),
        transfer: Transfer::Srgb,
        metadata: &Metadata::new(),
        threads: 1,
        ..OutputImage::default()
    };
    for (format, strength) in [(ImageFormat::Exr, 1.0), (ImageFormat::Hdr, 3.0), (ImageFormat::Png, 0.5)] {
        let image = decode(&encode(&output, format).unwrap(), "sky", &DecodeLimits::default()).unwrap();
        let images = [Asset { uri: "sky".into(), data: Arc::new(image) }];
        let desc = EnvironmentDesc { file: Some(ImageId(0)), strength, ..EnvironmentDesc::default() };
        let light = desc.prepare(&images, false).unwrap();
        let cases = [
            (DVec3::NEG_Z, [1.0, 0.0, 0.0]),
            (DVec3::X, [0.0, 1.0, 0.0]),
            (DVec3::Z, [0.0, 0.0, 1.0]),
            (DVec3::NEG_X, [0.0; 3]),
            (DVec3::Y, [1.0; 3]),
            (DVec3::NEG_Y, [0.0; 3]),
        ];
        for (direction, expected) in cases {
            let found = light.radiance(direction);
            let expected = Spectrum::from(expected) * strength as f32;
            assert!(
                (found - expected).map(f32::abs).max_component() < 1e-5,
                "{format:?} {direction}: {found:?}"
            );
        }
        let sample = light.sample([0.5, 0.3]).unwrap();
        assert!((light.pdf(sample.direction) - sample.pdf).abs() < 1e-9 * sample.pdf);
    }
}
