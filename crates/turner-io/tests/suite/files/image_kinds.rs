//! WebP, TGA and BMP: the pixels of another decoder, depth and channels preserved, damage rejected.

use std::path::Path;

use turner::image::{Image, Pixels};
use turner_io::image::{ColorOrData, DecodeLimits, ImageError, decode, decode_all};

fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)).unwrap()
}

fn load(name: &str) -> Result<Image, ImageError> {
    decode(&bytes(name), name, &DecodeLimits::default())
}

fn pixel(image: &Image, x: u32, y: u32) -> &[u8] {
    let n = usize::from(image.channels);
    let at = (y * image.width + x) as usize * n;
    match &image.pixels {
        Pixels::U8(v) => &v[at..at + n],
        _ => panic!("8 bits stay 8 bits"),
    }
}

/// The formula that the test files were generated from.
fn source(x: u32, y: u32) -> [u8; 4] {
    [(x * 10) as u8, (y * 14) as u8, (x * 7 + y * 3) as u8, (255 - x * 5) as u8]
}

/// The palette of some of the files.
fn palette(i: u8) -> [u8; 3] {
    [i, 255 - i, i / 2]
}

#[test]
fn lossless_files_have_every_pixel() {
    type Expected = fn(u32, u32) -> Vec<u8>;
    let rgb: Expected = |x, y| source(x, y)[..3].to_vec();
    let rgba: Expected = |x, y| source(x, y).to_vec();
    let five_six_five: Expected = |x, y| {
        let [r, g, b, _] = source(x, y).map(f32::from);
        let step = |v: f32, shift: f32, most: f32| ((v / shift).floor() * 255.0 / most).round() as u8;
        vec![step(r, 8.0, 31.0), step(g, 4.0, 63.0), step(b, 8.0, 31.0)]
    };
    let cases: &[(&str, Expected)] = &[
        ("lossless.webp", rgb),
        ("lossless_alpha.webp", rgba),
        ("rgb.tga", rgb),
        ("rgb_rle.tga", rgb),
        ("rgba_rle.tga", rgba),
        ("grey.tga", |x, y| vec![source(x, y)[0]]),
        ("palette_rle.tga", |x, _| palette((x * 10) as u8).to_vec()),
        ("rgb.bmp", rgb),
        ("rgba.bmp", rgba),
        ("rgb565.bmp", five_six_five),
        ("palette.bmp", |x, _| palette((x * 10) as u8).to_vec()),
        ("rle8.bmp", |x, y| palette(if x < 8 { y as u8 } else { (x * 10) as u8 }).to_vec()),
    ];
    for (name, expected) in cases {
        let image = load(name).unwrap();
        assert_eq!((image.width, image.height), (24, 18), "{name}");
        for (x, y) in (0..18).flat_map(|y| (0..24).map(move |x| (x, y))) {
            assert_eq!(pixel(&image, x, y), expected(x, y), "{name} at {x}, {y}");
        }
    }
}

/// The values are those of libwebp, whose colour conversion may round differently in the last bit.
#[test]
fn lossy_webp_is_as_the_reference_decoder_has_it() {
    let places = [(0, 0), (5, 7), (20, 11), (23, 17)];
    let cases: [(&str, [&[u8]; 4]); 2] = [
        ("lossy.webp", [&[0, 5, 6], &[46, 94, 50], &[201, 152, 173], &[227, 238, 214]]),
        (
            "lossy_alpha.webp",
            [&[1, 3, 4, 255], &[43, 93, 51, 230], &[198, 151, 172, 155], &[226, 237, 212, 140]],
        ),
    ];
    for (name, expected) in cases {
        let image = load(name).unwrap();
        for ((x, y), expected) in places.into_iter().zip(expected) {
            let found = pixel(&image, x, y);
            assert_eq!(found.len(), expected.len(), "{name}");
            let near = found.iter().zip(expected).all(|(a, b)| a.abs_diff(*b) <= 1);
            assert!(near, "{name} at {x}, {y}: {found:?}, expected {expected:?}");
        }
    }
}

#[test]
fn an_animation_is_refused() {
    let message = load("animated.webp").unwrap_err().to_string();
    assert!(message.contains("animation") && message.contains("still"), "{message}");
}

/// A TGA of 2 x 1 pixels with this data.
fn tga(kind: u8, depth: u8, attributes: u8, data: &[u8]) -> Vec<u8> {
    let header = [0, 0, kind, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 1, 0, depth, attributes];
    [&header[..], data].concat()
}

#[test]
fn tga_without_alpha_bits_is_opaque_only_where_all_are_zero() {
    let read = |data: &[u8], attributes| {
        decode(&tga(2, 32, attributes, data), "x.tga", &DecodeLimits::default()).unwrap()
    };
    let unused = read(&[1, 2, 3, 0, 4, 5, 6, 0], 0);
    assert_eq!((unused.channels, unused.pixels), (3, Pixels::U8(vec![3, 2, 1, 6, 5, 4])));
    let used = read(&[1, 2, 3, 0, 4, 5, 6, 9], 0);
    assert_eq!((used.channels, used.pixels), (4, Pixels::U8(vec![3, 2, 1, 0, 6, 5, 4, 9])));
    // Alpha bits are declared: everything is transparent, as the file states.
    assert_eq!(read(&[1, 2, 3, 0, 4, 5, 6, 0], 8).channels, 4);
    // Right to left, 5 bits per channel.
    let five = decode(&tga(2, 16, 0x10, &[31, 0, 0, 0x7c]), "x.tga", &DecodeLimits::default()).unwrap();
    assert_eq!(five.pixels, Pixels::U8(vec![255, 0, 0, 0, 0, 255]));
}

#[test]
fn a_tga_needs_its_extension_or_its_footer() {
    let plain = tga(3, 8, 0, &[7, 8]);
    let limits = DecodeLimits::default();
    assert!(decode(&plain, "x.TGA", &limits).is_ok());
    assert!(decode(&plain, "x", &limits).unwrap_err().to_string().contains("expected an image in"));
    let footed = [&plain[..], b"\0\0\0\0\0\0\0\0TRUEVISION-XFILE.\0"].concat();
    assert_eq!(decode(&footed, "x.png", &limits).unwrap().pixels, Pixels::U8(vec![7, 8]));
    let message = decode(b"some text, some more of it", "x.tga", &limits).unwrap_err().to_string();
    assert!(message.contains("TGA") && message.lines().count() <= 3, "{message}");
}

#[test]
fn many_pictures_come_in_order_on_any_number_of_threads() {
    let names = ["lossy.webp", "rgb.tga", "animated.webp", "basi6a16.png", "rle8.bmp", "xd3n2c08.png"];
    let files: Vec<_> = names.iter().map(|name| bytes(name)).collect();
    for max_size in [None, Some(12), Some(5)] {
        let pictures: Vec<_> = (0..30)
            .map(|i| {
                let used_as = if i % 4 == 0 { ColorOrData::Data } else { ColorOrData::Color };
                (&files[i % 6][..], names[i % 6], used_as)
            })
            .collect();
        let once = decode_all(&pictures, &DecodeLimits::default(), 1, max_size);
        assert_eq!(once.len(), pictures.len());
        for (result, name) in once.iter().zip(names.iter().cycle()) {
            match result {
                Ok(image) => {
                    assert!(image.is_consistent(), "{name}");
                    let side = image.width.max(image.height);
                    assert!(max_size.is_none_or(|max| side <= max && 2 * max >= side), "{name}");
                }
                Err(e) => assert!(e.to_string().starts_with(name), "{e}"),
            }
        }
        assert_eq!(once.iter().filter(|r| r.is_err()).count(), 10);
        assert!(matches!(once[3].as_ref().unwrap().pixels, Pixels::U16(_)));
        for threads in [0, 2, 3, 64] {
            assert!(once == decode_all(&pictures, &DecodeLimits::default(), threads, max_size), "{threads}");
        }
    }
    assert!(decode_all(&[], &DecodeLimits::default(), 0, None).is_empty());
}
