//! Display values: bit depths, dither, colour spaces and how files declare them.

use turner::color::{DisplaySpace, Tonemap, Transfer};
use turner::film::DisplayTransform;
use turner::image::{Image, Pixels};
use turner_io::image::{DecodeLimits, ImageFormat, decode};
use turner_io::{DisplayOptions, Rounding, SaveOptions, to_bytes};

/// A smooth dark gradient of 64 x 8 pixels.
fn gradient() -> Image {
    let samples = (0..64 * 8).flat_map(|i| {
        let v = (i % 64) as f32 * 1e-3;
        [v, v * 0.5, 0.25]
    });
    Image { width: 64, height: 8, channels: 3, pixels: Pixels::F32(samples.collect()) }
}

fn written(space: DisplaySpace, rounding: Rounding, format: ImageFormat) -> Result<Vec<u8>, String> {
    let transform =
        DisplayTransform { space, tonemap: Tonemap::Neutral, exposure: 0.5, ..Default::default() };
    let display = Some(DisplayOptions { transform, rounding });
    let options = SaveOptions { display, ..SaveOptions::default() };
    to_bytes(&gradient(), format, &options).map_err(|e| e.to_string())
}

/// The data of a chunk of a PNG.
fn chunk<'a>(png: &'a [u8], kind: &[u8; 4]) -> Option<&'a [u8]> {
    let mut rest = &png[8..];
    while rest.len() > 8 {
        let length = u32::from_be_bytes(rest[..4].try_into().unwrap()) as usize;
        if &rest[4..8] == kind {
            return Some(&rest[8..8 + length]);
        }
        rest = &rest[length + 12..];
    }
    None
}

#[test]
fn png_declares_its_colour_space() {
    let png = |space| written(space, Rounding::SixteenBits, ImageFormat::Png).unwrap();
    let srgb = png(DisplaySpace::Srgb);
    assert!(chunk(&srgb, b"sRGB").is_some() && chunk(&srgb, b"cICP").is_none());
    let p3 = png(DisplaySpace::DisplayP3);
    assert_eq!(chunk(&p3, b"cICP"), Some(&[12, 13, 0, 1][..]));
    let profile = chunk(&p3, b"iCCP").unwrap();
    assert!(profile.starts_with(b"Display P3\0\0"));
    let profile = miniz_oxide::inflate::decompress_to_vec_zlib(&profile[12..]).unwrap();
    assert_eq!(&profile[12..24], b"mntrRGB XYZ ");
    let pq = png(DisplaySpace::Rec2100Pq);
    assert_eq!(chunk(&pq, b"cICP"), Some(&[9, 16, 0, 1][..]));
    assert!(chunk(&pq, b"sRGB").is_none() && chunk(&pq, b"iCCP").is_none());
    // Colour spaces are declared before the pixels.
    let position = |kind: &[u8]| pq.windows(4).position(|w| w == kind).unwrap();
    assert!(position(b"cICP") < position(b"IDAT"));
}

#[test]
fn display_values_are_those_of_the_transform() {
    let Pixels::F32(samples) = gradient().pixels else { panic!("floats") };
    let linear: Vec<[f32; 4]> = samples.chunks(3).map(|p| [p[0], p[1], p[2], 1.0]).collect();
    for space in [DisplaySpace::Srgb, DisplaySpace::DisplayP3, DisplaySpace::Rec2100Pq] {
        let transform =
            DisplayTransform { space, tonemap: Tonemap::Neutral, exposure: 0.5, transfer: Transfer::Srgb };
        let read = |rounding| {
            let bytes = written(space, rounding, ImageFormat::Png).unwrap();
            decode(&bytes, "a.png", &DecodeLimits::default()).unwrap().pixels
        };
        let rgb8 = |v: Vec<[u8; 4]>| Pixels::U8(v.iter().flat_map(|p| [p[0], p[1], p[2]]).collect());
        assert_eq!(read(Rounding::EightBits), rgb8(transform.to_8_bits(&linear, 1)));
        assert_eq!(read(Rounding::Dithered), rgb8(transform.to_8_bits_dithered(&linear, 64, 0, 2)));
        let sixteen = transform.to_16_bits(&linear, 2);
        assert_eq!(
            read(Rounding::SixteenBits),
            Pixels::U16(sixteen.iter().flat_map(|p| [p[0], p[1], p[2]]).collect())
        );
    }
}

#[test]
fn webp_is_lossless_with_and_without_alpha() {
    let mut image = gradient();
    for channels in [3, 4] {
        if channels == 4 {
            let Pixels::F32(samples) = image.pixels else { panic!("floats") };
            let with =
                samples.chunks(3).enumerate().flat_map(|(i, p)| [p[0], p[1], p[2], (i % 9) as f32 / 8.0]);
            image = Image { channels: 4, pixels: Pixels::F32(with.collect()), ..image };
        }
        let read = |format: ImageFormat| {
            let bytes = to_bytes(&image, format, &SaveOptions::default()).unwrap();
            decode(&bytes, "a", &DecodeLimits::default()).unwrap()
        };
        assert_eq!(read(ImageFormat::WebP), read(ImageFormat::Png));
        assert_eq!(read(ImageFormat::WebP).channels, channels);
    }
}

#[test]
fn formats_without_colour_spaces_hold_srgb_alone() {
    for format in [ImageFormat::Jpeg, ImageFormat::WebP] {
        assert!(written(DisplaySpace::Srgb, Rounding::SixteenBits, format).is_ok());
        let error = written(DisplaySpace::Rec2100Pq, Rounding::EightBits, format).unwrap_err();
        assert!(error.contains("use PNG"), "{error}");
    }
    // Formats of linear values do not mind.
    assert!(written(DisplaySpace::Rec2100Pq, Rounding::EightBits, ImageFormat::Exr).is_ok());
}
