//! Damaged and malicious image files: bounded time and memory, and no panic.

use std::path::Path;
use std::time::{Duration, Instant};

use turner_io::image::{
    DecodeLimits, Display, ExtraChannel, ImageFormat, Metadata, OutputImage, SampleKind, Transfer, decode,
    encode, exr, read_metadata, silence_contained_panics,
};

/// A valid file of each format, and the small files of PngSuite.
fn valid_files() -> Vec<(String, Vec<u8>)> {
    let (width, height) = (40_u32, 36_u32);
    let linear: Vec<[f32; 4]> =
        (0..width * height).map(|i| [i as f32 * 0.01, (i % 7) as f32, 0.5, 0.75]).collect();
    let eight: Vec<[u8; 4]> = (0..width * height).map(|i| [i as u8, (i / 3) as u8, 9, 200]).collect();
    let metadata: Metadata = [("turner:seed".to_owned(), 5.into())].into();
    let image = OutputImage {
        width,
        height,
        alpha: true,
        linear: Some(&linear),
        display: Some(Display::U8(&eight)),
        transfer: Transfer::Srgb,
        metadata: &metadata,
        threads: 1,
        ..OutputImage::default()
    };
    let mut files: Vec<_> = ImageFormat::all()
        .filter(|f| f.can_write())
        .map(|f| (format!("valid.{}", f.extensions()[0]), encode(&image, f).unwrap()))
        .collect();
    files.extend(exr_files());
    let layers = ["N.X", "N.Y", "N.Z", "id"].map(|name| {
        let kind = if name == "id" { SampleKind::Uint } else { SampleKind::Half };
        ExtraChannel::new(name, kind, vec![0.25_f32; linear.len()])
    });
    files.push(("layers.exr".to_owned(), exr::encode(&OutputImage { channels: &layers, ..image }).unwrap()));
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    for name in ["basi6a16", "tbbn3p08", "basn0g01"] {
        files.push((name.to_owned(), std::fs::read(data.join(name).with_extension("png")).unwrap()));
    }
    for name in [
        "lossy.webp",
        "lossy_alpha.webp",
        "lossless_alpha.webp",
        "animated.webp",
        "rgba_rle.tga",
        "palette_rle.tga",
        "rgb.tga",
        "rgb565.bmp",
        "rgba.bmp",
        "rle8.bmp",
        "palette.bmp",
        "etc1s.ktx2",
        "etc1s_alpha.ktx2",
        "uastc.ktx2",
        "uastc_zstd.ktx2",
    ] {
        files.push((name.to_owned(), std::fs::read(data.join(name)).unwrap()));
    }
    files
}

/// EXR files in compressions and layouts that Turner does not write.
fn exr_files() -> Vec<(String, Vec<u8>)> {
    use ::exr::prelude::*;
    let size = Vec2(20, 18);
    let half = FlatSamples::F16((0..size.area()).map(|i| f16::from_f32(i as f32 * 0.5)).collect());
    let list: AnyChannels<FlatSamples> =
        AnyChannels::sort(["R", "G", "B"].map(|n| AnyChannel::new(n, half.clone())).into_iter().collect());
    let kinds = [
        (Compression::PIZ, Blocks::ScanLines),
        (Compression::RLE, Blocks::Tiles(Vec2(8, 8))),
        (Compression::B44, Blocks::ScanLines),
        (Compression::PXR24, Blocks::ScanLines),
    ];
    kinds
        .into_iter()
        .map(|(compression, blocks)| {
            let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
            let layer = Layer::new(size, LayerAttributes::named("x"), encoding, list.clone());
            let mut bytes = std::io::Cursor::new(Vec::new());
            Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
            (format!("{compression}.exr"), bytes.into_inner())
        })
        .collect()
}

/// Limits so small that a damaged size field cannot make a test slow.
fn limits() -> DecodeLimits {
    DecodeLimits { max_side: 4096, max_pixels: 1 << 20, max_bytes: 32 << 20, meant_side: 0 }
}

/// Decodes a file. Success or failure is allowed, but it must be fast, and an error must be printable.
fn try_file(bytes: &[u8], what: &str) -> bool {
    let start = Instant::now();
    // The extension matters only if no other format is recognised.
    let result = decode(bytes, "hostile.tga", &limits());
    // Layers of EXR files have their own readers.
    if bytes.starts_with(b"\x76\x2f\x31\x01") {
        let listed = exr::parts(bytes, what);
        let read = exr::read_channels(bytes, what, 0, |_| true, &limits());
        assert!(result.is_ok() || read.is_err() || listed.is_ok(), "{what}");
        let _ = exr::decode_layer(bytes, what, "N", &limits());
    }
    let metadata = read_metadata(bytes, "hostile.tga");
    assert!(start.elapsed() < Duration::from_secs(5), "{what} took {:?}", start.elapsed());
    for message in [result.as_ref().err(), metadata.as_ref().err()].into_iter().flatten() {
        let message = message.to_string();
        assert!(message.lines().count() <= 3 && !message.contains('\x1b'), "{what}: {message}");
    }
    result.is_ok()
}

#[test]
fn truncated_files() {
    silence_contained_panics();
    for (name, bytes) in valid_files() {
        assert!(try_file(&bytes, &name) || name == "animated.webp");
        let step = (bytes.len() / 400).max(1);
        for length in (0..bytes.len()).step_by(step) {
            let whole = try_file(&bytes[..length], &format!("{name} cut to {length}"));
            // Half a file is never accepted, except by JPEG decoders, which show what is there.
            assert!(!whole || length > bytes.len() / 2 || name.ends_with("jpg"), "{name} cut to {length}");
        }
    }
}

#[test]
fn flipped_bits() {
    silence_contained_panics();
    let mut seed = 1_u64;
    let mut random = |below: usize| {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 33) as usize % below
    };
    for (name, bytes) in valid_files() {
        for round in 0..400 {
            let mut damaged = bytes.clone();
            for _ in 0..1 + round % 4 {
                // Half of the flips are in the headers.
                let region = if random(2) == 0 { bytes.len().min(400) } else { bytes.len() };
                damaged[random(region)] ^= 1 << random(8);
            }
            try_file(&damaged, &format!("{name}, round {round}"));
        }
        // Extreme bytes at every position of the header: sizes, counts, types.
        for at in 0..bytes.len().min(400) {
            for value in [0, 0x7f, 0x80, 0xff] {
                let mut damaged = bytes.clone();
                damaged[at] = value;
                try_file(&damaged, &format!("{name}, byte {at} = {value}"));
            }
        }
    }
}

/// Asserts that a file is rejected quickly, with a message about its size.
fn assert_refused(bytes: &[u8], expected: &str) {
    let start = Instant::now();
    let message = decode(bytes, "big", &DecodeLimits::default()).unwrap_err().to_string();
    assert!(start.elapsed() < Duration::from_millis(200), "{message}");
    assert!(message.contains(expected), "{message}");
}

/// CRC-32 as in PNG, bit by bit.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, &b| {
        (0..8).fold(crc ^ u32::from(b), |c, _| if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 })
    })
}

fn png_claiming(width: u32, height: u32) -> Vec<u8> {
    let mut header = b"IHDR".to_vec();
    header.extend(width.to_be_bytes());
    header.extend(height.to_be_bytes());
    header.extend([16, 6, 0, 0, 0]);
    let mut bytes = b"\x89PNG\r\n\x1a\n\0\0\0\x0d".to_vec();
    bytes.extend(&header);
    bytes.extend(crc(&header).to_be_bytes());
    bytes
}

#[test]
fn png_with_an_impossible_size() {
    assert_refused(&png_claiming(0x7fff_ffff, 0x7fff_ffff), "exceeds 32768 on a side");
    assert_refused(&png_claiming(32768, 32768), "exceeds 268435456 pixels");
    assert_refused(&png_claiming(16384, 16384), "cannot be held in a file of");
    assert_refused(&png_claiming(0, 4), "damaged PNG");
}

#[test]
fn hdr_with_an_impossible_size() {
    let claim =
        |size: &str| format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{size}\n\x02\x02\x02\x02").into_bytes();
    assert_refused(&claim("-Y 1000000000 +X 1000000000"), "exceeds 32768 on a side");
    assert_refused(&claim("-Y 16384 +X 16384"), "bytes");
    assert_refused(&claim("-Y 8192 +X 8192"), "becomes 805306368 bytes from 55");
    assert_refused(&claim("-Y 4096 +X 4096"), "cannot hold 4096 rows");
    assert_refused(&claim("-Y 99999999999999999999 +X 1"), "expected a size");
    assert_refused(&claim("-Y -5 +X 1"), "expected a size");
    assert_refused(&claim("+X 5 -Y 1"), "orientation");
    assert_refused(b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n1234", "xyze");
    assert_refused(&[b"#?RADIANCE\n".to_vec(), vec![b'x'; 1 << 20]].concat(), "header does not end");
}

#[test]
fn hdr_runs_that_exceed_their_line() {
    let file = |data: &[u8]| [b"#?RGBE\n\n-Y 1 +X 9\n", data].concat();
    for data in [
        &[2, 2, 0, 9, 128 + 10, 5][..],
        &[2, 2, 0, 9, 10, 5],
        &[2, 2, 0, 8, 128 + 9, 5],
        &[1, 1, 1, 5],
        &[5, 5, 5, 5, 1, 1, 1, 255],
        &[5, 5, 5, 5, 1, 1, 1, 0, 1, 1, 1, 0, 1, 1, 1, 0, 1, 1, 1, 0, 1, 1, 1, 0, 1, 1, 1, 0, 1, 1, 1, 0],
    ] {
        assert_refused(&file(data), "row 0 of 1");
    }
    // A valid run is accepted, so the rejections above are due to the runs.
    assert!(decode(&file(&[5, 5, 5, 5, 1, 1, 1, 8]), "x", &limits()).is_ok());
}

#[test]
fn exr_and_jpeg_with_an_impossible_size() {
    let (_, mut jpeg) = valid_files().into_iter().find(|(n, _)| n == "valid.jpg").unwrap();
    let frame = jpeg.windows(2).position(|w| w == [0xff, 0xc0]).unwrap();
    jpeg[frame + 5..frame + 9].copy_from_slice(&[0x20, 0, 0x20, 0]);
    assert_refused(&jpeg, "cannot be held in a file of");
    let (_, exr) = valid_files().into_iter().find(|(n, _)| n == "valid.exr").unwrap();
    for window in ["dataWindow", "displayWindow"] {
        let at = exr.windows(window.len()).position(|w| w == window.as_bytes()).unwrap() + window.len() + 11;
        for (x, y) in [(i32::MAX, i32::MAX), (1 << 20, 1 << 20), (30000, 8000), (-5, -5)] {
            let mut damaged = exr.clone();
            damaged[at + 8..at + 12].copy_from_slice(&x.to_le_bytes());
            damaged[at + 12..at + 16].copy_from_slice(&y.to_le_bytes());
            let start = Instant::now();
            let result = decode(&damaged, "big.exr", &DecodeLimits::default());
            // The exr crate accepts the display window's corners in either order: an image of 6 x 6.
            assert!(result.is_err() || (window, x) == ("displayWindow", -5), "{window} {x} {y}");
            assert!(start.elapsed() < Duration::from_secs(5));
        }
    }
}

fn data(name: &str) -> Vec<u8> {
    std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)).unwrap()
}

#[test]
fn webp_tga_and_bmp_with_an_impossible_size() {
    // A lossy frame of 16383 x 16383, alone and in a small canvas.
    for name in ["lossy.webp", "lossy_alpha.webp"] {
        let mut bytes = data(name);
        let at = bytes.windows(3).position(|w| w == [0x9d, 0x01, 0x2a]).unwrap();
        bytes[at + 3..at + 7].fill(0xff);
        assert_refused(&bytes, if name == "lossy.webp" { "cannot be held" } else { "its canvas" });
    }
    let mut lossless = data("lossless.webp");
    lossless[21..25].copy_from_slice(&[0xff, 0xff, 0xff, 0x0f]);
    let tight = DecodeLimits { max_side: 8192, ..DecodeLimits::default() };
    let message = decode(&lossless, "big", &tight).unwrap_err().to_string();
    assert!(message.contains("16384 x 16384") && message.contains("exceeds 8192"), "{message}");
    for name in ["rgba_rle.tga", "rgb.tga"] {
        let mut bytes = data(name);
        bytes[12..16].copy_from_slice(&[0, 0x20, 0, 0x20]);
        assert_refused(&bytes, "cannot be held");
    }
    for name in ["rle8.bmp", "rgba.bmp", "palette.bmp"] {
        let mut bytes = data(name);
        bytes[18..26].copy_from_slice(&[0, 0x20, 0, 0, 0, 0x20, 0, 0]);
        assert_refused(&bytes, "cannot be held");
        bytes[18..26].copy_from_slice(&[0, 0, 0, 0, 0, 0x20, 0, 0]);
        assert_refused(&bytes, "is empty");
    }
}

#[test]
fn limits_are_kept_for_every_format() {
    for name in ["lossy.webp", "lossless.webp", "rgb_rle.tga", "palette.bmp", "etc1s.ktx2", "uastc.ktx2"] {
        for tight in [
            DecodeLimits { max_side: 23, ..DecodeLimits::default() },
            DecodeLimits { max_pixels: 24 * 18 - 1, ..DecodeLimits::default() },
            DecodeLimits { max_bytes: 24 * 18 * 3 - 1, ..DecodeLimits::default() },
        ] {
            let message = decode(&data(name), name, &tight).unwrap_err().to_string();
            assert!(message.contains("24 x 18") && message.contains("exceeds"), "{message}");
        }
    }
    for (name, bytes) in valid_files().into_iter().filter(|(n, _)| n.starts_with("valid")) {
        for tight in [
            DecodeLimits { max_side: 39, ..DecodeLimits::default() },
            DecodeLimits { max_pixels: 40 * 36 - 1, ..DecodeLimits::default() },
            DecodeLimits { max_bytes: 40 * 36 * 3 - 1, ..DecodeLimits::default() },
        ] {
            let message = decode(&bytes, &name, &tight).unwrap_err().to_string();
            assert!(message.contains("40 x 36") && message.contains("exceeds"), "{message}");
        }
    }
}

#[test]
fn names_in_messages_cannot_steer_a_terminal() {
    let message = decode(b"??", "a\x1b[2J\u{202e}b.png", &limits()).unwrap_err().to_string();
    assert!(!message.contains('\x1b') && !message.contains('\u{202e}'), "{message:?}");
}
