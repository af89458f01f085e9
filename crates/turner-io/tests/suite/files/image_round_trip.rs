//! Images read back exactly from PNG, WebP and EXR, and within the quantisation step from HDR and JPEG.

use turner::image::{Image, Pixels};
use turner_io::image::{
    DecodeLimits, Display, ImageFormat, MetaValue, Metadata, OutputImage, Transfer, decode, encode, exr,
    read_metadata,
};

/// A small deterministic random number generator (SplitMix64).
struct Rng(u64);

impl Rng {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
}

struct Picture {
    width: u32,
    height: u32,
    linear: Vec<[f32; 4]>,
    eight: Vec<[u8; 4]>,
    sixteen: Vec<[u16; 4]>,
    metadata: Metadata,
}

impl Picture {
    /// Half smooth, half noise; values over 24 powers of two; alpha 0, 1 and powers of two, so that division is
    /// exact.
    fn new(width: u32, height: u32) -> Self {
        let mut rng = Rng(7);
        let mut value = |x: u32| {
            let noise = rng.next();
            let scale = f32::from_bits(((115 + (noise % 24)) as u32) << 23);
            if x < width / 2 {
                x as f32 / width as f32
            } else {
                scale * (1.0 + (noise >> 41) as f32 / 8388608.0)
            }
        };
        let linear: Vec<[f32; 4]> = (0..width * height)
            .map(|i| {
                [value(i % width), value(i % width), value(i % width), [1.0, 0.5, 0.25, 0.0][i as usize % 4]]
            })
            .collect();
        let eight = linear.iter().map(|p| p.map(|v| (v.clamp(0.0, 1.0) * 255.0) as u8)).collect();
        let sixteen = linear.iter().map(|p| p.map(|v| (v.clamp(0.0, 1.0) * 65535.0) as u16)).collect();
        Self { width, height, linear, eight, sixteen, metadata: Metadata::new() }
    }

    fn output(&self, alpha: bool) -> OutputImage<'_> {
        OutputImage {
            width: self.width,
            height: self.height,
            alpha,
            linear: Some(&self.linear),
            display: Some(Display::U8(&self.eight)),
            transfer: Transfer::Srgb,
            metadata: &self.metadata,
            threads: 1,
            ..OutputImage::default()
        }
    }
}

/// 1 x 1, odd sizes, one more than a block of 16 rows, and widths around the limits of HDR's run lengths.
const SIZES: &[(u32, u32)] = &[(1, 1), (7, 3), (8, 17), (33, 16), (130, 40), (1, 50)];

fn read(bytes: &[u8]) -> Image {
    decode(bytes, "test", &DecodeLimits::default()).expect("a file just written is valid")
}

fn channels<T: Copy>(pixels: &[[T; 4]], n: usize) -> Vec<T> {
    pixels.iter().flat_map(|p| p[..n].iter().copied()).collect()
}

#[test]
fn png_and_webp_come_back_exactly() {
    for &(w, h) in SIZES {
        let picture = Picture::new(w, h);
        for (alpha, n) in [(false, 3), (true, 4)] {
            let mut output = picture.output(alpha);
            let image = read(&encode(&output, ImageFormat::Png).unwrap());
            assert_eq!((image.width, image.height, usize::from(image.channels)), (w, h, n));
            assert_eq!(image.pixels, Pixels::U8(channels(&picture.eight, n)));
            let webp = read(&encode(&output, ImageFormat::WebP).unwrap());
            assert_eq!(webp, image);
            output.display = Some(Display::U16(&picture.sixteen));
            let image = read(&encode(&output, ImageFormat::Png).unwrap());
            assert_eq!(image.pixels, Pixels::U16(channels(&picture.sixteen, n)));
        }
    }
}

#[test]
fn exr_comes_back_exactly() {
    for &(w, h) in SIZES {
        let picture = Picture::new(w, h);
        let bytes = encode(&picture.output(false), ImageFormat::Exr).unwrap();
        assert_eq!(read(&bytes).pixels, Pixels::F32(channels(&picture.linear, 3)));
        let bytes = encode(&picture.output(true), ImageFormat::Exr).unwrap();
        let stored = exr::decode_as_stored(&bytes, "test", &DecodeLimits::default()).unwrap();
        assert_eq!(stored.pixels, Pixels::F32(channels(&picture.linear, 4)));
        // Straight alpha: colours divided by alpha, and kept where alpha is 0.
        let straight =
            |p: &[f32; 4]| if p[3] > 0.0 { [p[0] / p[3], p[1] / p[3], p[2] / p[3], p[3]] } else { *p };
        assert_eq!(read(&bytes).pixels, Pixels::F32(picture.linear.iter().flat_map(straight).collect()));
    }
}

#[test]
fn exr_keeps_nan_infinity_and_every_bit() {
    let mut picture = Picture::new(4, 1);
    picture.linear[0] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.0];
    picture.linear[1] = [-0.0, f32::MIN_POSITIVE / 2.0, f32::MAX, 1.0];
    let image = read(&encode(&picture.output(false), ImageFormat::Exr).unwrap());
    let Pixels::F32(samples) = image.pixels else { panic!("EXR is float") };
    let bits: Vec<u32> = samples.iter().map(|v| v.to_bits()).collect();
    assert_eq!(bits, channels(&picture.linear, 3).iter().map(|v| v.to_bits()).collect::<Vec<_>>());
}

#[test]
fn hdr_comes_back_within_its_step() {
    for &(w, h) in SIZES {
        let picture = Picture::new(w, h);
        let image = read(&encode(&picture.output(false), ImageFormat::Hdr).unwrap());
        for (i, p) in picture.linear.iter().enumerate() {
            let back = image.rgb(i as u32 % w, i as u32 / w);
            let max = p[0].max(p[1]).max(p[2]);
            for c in 0..3 {
                // Mantissas have 8 bits, and the largest is at least 128, so half a step is max /
                // 256; 255 covers rounding up to the next exponent.
                assert!((back[c] - p[c]).abs() <= max / 255.0, "pixel {i}: {p:?} {back:?}");
            }
        }
    }
}

#[test]
fn jpeg_keeps_flat_colours_and_smooth_ramps() {
    let (w, h) = (64, 48);
    let mut picture = Picture::new(w, h);
    picture.eight = (0..w * h).map(|i| [(i % w * 4) as u8, 128, (i / w * 5) as u8, 255]).collect();
    let bytes = encode(&picture.output(false), ImageFormat::Jpeg).unwrap();
    let image = read(&bytes);
    assert_eq!((image.width, image.height, image.channels), (w, h, 3));
    // Quality 95 quantises the lowest frequencies of luma and chroma in steps of 2. With YCbCr rounding and gains
    // up to 1.8 a smooth image stays within 6 of 255.
    for (i, p) in picture.eight.iter().enumerate() {
        let back = image.rgb(i as u32 % w, i as u32 / w);
        for c in 0..3 {
            assert!((back[c] * 255.0 - f32::from(p[c])).abs() <= 6.0, "pixel {i}: {p:?} {back:?}");
        }
    }
}

#[test]
fn metadata_comes_back_and_does_not_touch_pixels() {
    let mut picture = Picture::new(9, 5);
    let plain = read(&encode(&picture.output(true), ImageFormat::Png).unwrap());
    picture.metadata = [
        ("turner:sceneHash", MetaValue::from("9f86d081884c7d65")),
        ("turner:scene", MetaValue::from("Küche – 厨房.toml")),
        ("turner:seed", MetaValue::from(-42)),
        ("turner:empty", MetaValue::from("")),
        ("turner:a-name-longer-than-the-31-bytes-of-old-EXR-files", MetaValue::from(1)),
    ]
    .into_iter()
    .map(|(k, v)| (k.to_owned(), v))
    .collect();
    let exr = encode(&picture.output(true), ImageFormat::Exr).unwrap();
    assert_eq!(read_metadata(&exr, "a.exr").unwrap(), picture.metadata);
    read(&exr);
    let png = encode(&picture.output(true), ImageFormat::Png).unwrap();
    let found = read_metadata(&png, "a.png").unwrap();
    let texts = |m: &Metadata| m.iter().map(|(k, v)| (k.clone(), v.to_string())).collect::<Vec<_>>();
    assert_eq!(texts(&found), texts(&picture.metadata));
    assert_eq!(read(&png), plain);
}

#[test]
fn impossible_metadata_is_refused() {
    for (name, format) in [
        ("", ImageFormat::Png),
        ("name\nwith a line", ImageFormat::Png),
        ("é", ImageFormat::Exr),
        ("channels", ImageFormat::Exr),
        (&"x".repeat(80) as &str, ImageFormat::Exr),
    ] {
        let mut picture = Picture::new(2, 2);
        picture.metadata.insert(name.to_owned(), "value".into());
        assert!(encode(&picture.output(false), format).is_err(), "{name:?}");
    }
    let mut picture = Picture::new(2, 2);
    picture.metadata.insert("key".to_owned(), "a\0b".into());
    assert!(encode(&picture.output(false), ImageFormat::Exr).is_err());
}

#[test]
fn bytes_depend_on_nothing_but_the_picture() {
    let mut picture = Picture::new(60, 100);
    for i in 0..20 {
        picture.metadata.insert(format!("turner:{i}"), i.into());
    }
    for format in ImageFormat::all().filter(|f| f.can_write()) {
        let first = encode(&picture.output(true), format).unwrap();
        for threads in [1, 2, 3, 64, 0] {
            let output = OutputImage { threads, ..picture.output(true) };
            assert_eq!(encode(&output, format).unwrap(), first, "{format:?} with {threads} threads");
        }
    }
}

#[test]
fn missing_or_short_samples_are_errors() {
    let picture = Picture::new(4, 4);
    for format in ImageFormat::all().filter(|f| f.can_write()) {
        let none = OutputImage { linear: None, display: None, ..picture.output(false) };
        assert!(encode(&none, format).is_err());
        let short = OutputImage { height: 5, ..picture.output(false) };
        let message = encode(&short, format).unwrap_err().to_string();
        assert!(message.contains("found 16") && message.contains("4 x 5"), "{message}");
        let empty = OutputImage { width: 0, ..picture.output(false) };
        assert!(encode(&empty, format).is_err());
        let huge = OutputImage { width: u32::MAX, height: u32::MAX, ..picture.output(false) };
        assert!(encode(&huge, format).is_err());
    }
}

#[test]
fn png_states_its_transfer() {
    let picture = Picture::new(2, 2);
    let has = |transfer, chunk: &[u8]| {
        let bytes = encode(&OutputImage { transfer, ..picture.output(false) }, ImageFormat::Png).unwrap();
        bytes.windows(chunk.len()).any(|w| w == chunk)
    };
    assert!(has(Transfer::Srgb, b"sRGB"));
    // 1 / 2.2 in units of 10^-5.
    assert!(has(Transfer::Gamma(2.2), b"gAMA\x00\x00\xb1\x8f"));
    assert!(!has(Transfer::Unstated, b"gAMA") && !has(Transfer::Unstated, b"sRGB"));
    let wrong = OutputImage { transfer: Transfer::Gamma(f32::NAN), ..picture.output(false) };
    assert!(encode(&wrong, ImageFormat::Png).is_err());
}
