//! PngSuite (a selection, see data/CREDITS.md): all kinds of PNG, and damaged ones.

use std::path::Path;

use turner::image::{Image, Pixels};
use turner_io::image::{DecodeLimits, ImageError, decode};

fn load(name: &str) -> Result<Image, ImageError> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name).with_extension("png");
    decode(&std::fs::read(path).unwrap(), name, &DecodeLimits::default())
}

/// The samples of a pixel as stored.
fn pixel(image: &Image, x: usize, y: usize) -> Vec<u16> {
    let n = usize::from(image.channels);
    let at = (y * image.width as usize + x) * n;
    match &image.pixels {
        Pixels::U8(v) => v[at..at + n].iter().map(|&v| v.into()).collect(),
        Pixels::U16(v) => v[at..at + n].to_vec(),
        Pixels::F32(_) => panic!("PNG is not float"),
    }
}

/// The expected values come from an independent, minimal decoder.
#[test]
fn pixels_are_those_of_the_file() {
    let cases: &[(&str, [&[u16]; 2])] = &[
        ("basn0g01", [&[0], &[255]]),
        ("basn2c08", [&[255, 255, 26], &[203, 203, 203]]),
        ("basn4a08", [&[197, 41], &[49, 164]]),
        ("basn6a08", [&[255, 223, 7, 41], &[1, 224, 255, 164]]),
        ("basn0g16", [&[15104], &[58880]]),
        ("tbbn3p08", [&[117, 117, 117, 255], &[7, 7, 64, 255]]),
        ("tbbn2c16", [&[30069, 30069, 30069, 65535], &[3341, 3341, 17219, 65535]]),
    ];
    for (name, [first, second]) in cases {
        let image = load(name).unwrap();
        assert_eq!((image.width, image.height), (32, 32), "{name}");
        assert_eq!(pixel(&image, 5, 7), *first, "{name}");
        assert_eq!(pixel(&image, 20, 25), *second, "{name}");
    }
}

#[test]
fn depth_and_channels_are_kept() {
    let cases = [
        ("basn0g01", 1, false),
        ("basn0g16", 1, true),
        ("basn4a08", 2, false),
        ("basi3p04", 3, false),
        ("basi6a16", 4, true),
        ("tbbn2c16", 4, true),
        ("tbbn3p08", 4, false),
        ("s01n3p01", 3, false),
        ("s40i3p04", 3, false),
    ];
    for (name, channels, deep) in cases {
        let image = load(name).unwrap();
        assert_eq!(image.channels, channels, "{name}");
        assert_eq!(matches!(image.pixels, Pixels::U16(_)), deep, "{name}");
    }
}

#[test]
fn damaged_files_are_refused_with_a_reason() {
    for (name, reason) in [
        ("xcsn0g01", "checksum"),
        ("xhdn0g08", "checksum"),
        ("xdtn0g01", "IDAT"),
        ("xd3n2c08", "bit depth 3"),
        ("xs1n0g01", "expected an image in one of PNG"),
    ] {
        let message = load(name).unwrap_err().to_string();
        assert!(message.starts_with(name) && message.contains(reason), "{message}");
        assert!(message.lines().count() <= 3, "{message}");
    }
}
