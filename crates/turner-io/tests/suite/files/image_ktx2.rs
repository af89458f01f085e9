//! KTX2: pixels of the reference transcoder of Basis Universal, containers built here, features that are refused.

use std::path::Path;

use turner::image::{Image, Pixels};
use turner_io::image::{ColorOrData, DecodeLimits, ImageError, decode, decode_all};

fn data(name: &str) -> Vec<u8> {
    std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)).unwrap()
}

fn load(bytes: &[u8]) -> Result<Image, ImageError> {
    decode(bytes, "a.ktx2", &DecodeLimits::default())
}

fn refused(bytes: &[u8]) -> String {
    load(bytes).unwrap_err().to_string()
}

fn eight_bit(image: &Image) -> &[u8] {
    match &image.pixels {
        Pixels::U8(samples) => samples,
        other => panic!("{other:?}"),
    }
}

/// FNV-1a with 64 bits.
fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3))
}

/// Size, channels and hash of what the reference transcoder (basis_universal 2.2) writes as RGBA; RGB for files without
/// alpha. `uastc_modes.ktx2` has 16 blocks of random bits for each of the 19 modes.
#[test]
fn basis_universal_has_the_pixels_of_the_reference_transcoder() {
    for (name, size, channels, expected) in [
        ("etc1s.ktx2", (24, 18), 3, 0x2f91_6df3_a9a7_d615),
        ("etc1s_alpha.ktx2", (99, 74), 4, 0x34aa_77d5_589e_4009),
        ("uastc.ktx2", (24, 18), 4, 0xc32e_d904_4038_f719),
        ("uastc_zstd.ktx2", (99, 74), 4, 0xf303_1c87_6d12_6bd1),
        ("uastc_modes.ktx2", (64, 76), 4, 0xeb5e_27b1_c9d3_b942),
    ] {
        let bytes = data(name);
        let stored = decode_all(&[(&bytes, name, ColorOrData::Color)], &DecodeLimits::default(), 1, None);
        let image = stored.into_iter().next().unwrap().unwrap();
        assert_eq!(((image.width, image.height), image.channels), (size, channels), "{name}");
        assert_eq!(hash(eight_bit(&image)), expected, "{name}: {:#x}", hash(eight_bit(&image)));
    }
}

/// What a container says.
#[derive(Clone, Default)]
struct File {
    format: u32,
    /// Width, height, depth, layers, faces, levels.
    size: [u32; 6],
    scheme: u32,
    /// Colour model, primaries, transfer function, flags.
    descriptor: [u8; 4],
    /// The channels of its samples.
    channels: Vec<u8>,
    pairs: Vec<(&'static str, &'static [u8])>,
    level: Vec<u8>,
    decompressed: u64,
}

/// The model of uncompressed samples, and transfer functions.
const RGBSDA: u8 = 1;
const LINEAR: u8 = 1;
const SRGB: u8 = 2;

impl File {
    /// An uncompressed image of 2 x 3 pixels whose bytes count up.
    fn counting(format: u32, transfer: u8, pixel_bytes: u8) -> File {
        let level: Vec<u8> = (0..6 * pixel_bytes).collect();
        File {
            format,
            size: [2, 3, 0, 0, 1, 1],
            descriptor: [RGBSDA, 1, transfer, 0],
            channels: vec![0, 1],
            decompressed: level.len() as u64,
            level,
            ..File::default()
        }
    }

    fn bytes(&self) -> Vec<u8> {
        let block = 24 + 16 * self.channels.len() as u16;
        let mut descriptor = [&(u32::from(block) + 4).to_le_bytes()[..], &[0, 0, 0, 0, 2, 0]].concat();
        descriptor.extend(block.to_le_bytes());
        descriptor.extend(self.descriptor);
        descriptor.extend([0; 12]);
        for channel in &self.channels {
            descriptor.extend([0, 0, 7, *channel]);
            descriptor.extend([0; 12]);
        }
        let mut pairs = Vec::new();
        for (key, value) in &self.pairs {
            let pair = [key.as_bytes(), b"\0", value, b"\0"].concat();
            pairs.extend((pair.len() as u32).to_le_bytes());
            pairs.extend(pair);
            pairs.resize(pairs.len().next_multiple_of(4), 0);
        }
        let start = 80 + 24;
        let mut out = b"\xabKTX 20\xbb\r\n\x1a\n".to_vec();
        let mut numbers = vec![self.format, 1];
        numbers.extend(self.size);
        numbers.extend([self.scheme, start, descriptor.len() as u32]);
        numbers.extend([start + descriptor.len() as u32, pairs.len() as u32, 0, 0, 0, 0]);
        out.extend(numbers.iter().flat_map(|n| n.to_le_bytes()));
        let at = start as usize + descriptor.len() + pairs.len();
        for number in [at as u64, self.level.len() as u64, self.decompressed] {
            out.extend(number.to_le_bytes());
        }
        [out, descriptor, pairs, self.level.clone()].concat()
    }
}

#[test]
fn uncompressed_samples_keep_their_depth_and_order() {
    let image = load(&File::counting(43, SRGB, 4).bytes()).unwrap();
    assert_eq!((image.width, image.height, image.channels), (2, 3, 4));
    assert_eq!(eight_bit(&image), (0..24).collect::<Vec<u8>>());
    let image = load(&File::counting(36, SRGB, 3).bytes()).unwrap();
    assert_eq!((image.channels, &eight_bit(&image)[..6]), (3, &[2, 1, 0, 5, 4, 3][..]));
    // Without sRGB in its name, the format leaves the decision to the transfer function.
    let grey = File::counting(9, SRGB, 1);
    assert_eq!(eight_bit(&load(&grey.bytes()).unwrap()), [0, 1, 2, 3, 4, 5]);
    let image = load(&File::counting(70, SRGB, 2).bytes()).unwrap();
    assert_eq!(image.pixels, Pixels::U16(vec![0x100, 0x302, 0x504, 0x706, 0x908, 0xb0a]));
    let halves = File { level: [0, 0x3c, 0, 0xc0].repeat(9), ..File::counting(90, LINEAR, 6) };
    assert_eq!(load(&halves.bytes()).unwrap().pixels, Pixels::F32([1.0, -2.0].repeat(9)));
}

#[test]
fn linear_samples_are_floats_unless_the_user_knows_better() {
    let bytes = File::counting(9, LINEAR, 1).bytes();
    let image = load(&bytes).unwrap();
    assert_eq!(image.pixels, Pixels::F32((0..6).map(|v| v as f32 / 255.0).collect()));
    let known = decode_all(&[(&bytes, "a.ktx2", ColorOrData::Data)], &DecodeLimits::default(), 1, None);
    assert_eq!(eight_bit(known[0].as_ref().unwrap()), [0, 1, 2, 3, 4, 5]);
}

#[test]
fn zlib_holds_all_layers() {
    let plain = File { size: [2, 3, 0, 2, 1, 1], scheme: 3, ..File::counting(43, SRGB, 4) };
    let both: Vec<u8> = (0..48).collect();
    let level = miniz_oxide::deflate::compress_to_vec_zlib(&both, 6);
    let packed = File { level, decompressed: 48, ..plain };
    assert_eq!(eight_bit(&load(&packed.bytes()).unwrap()), &both[..24]);
    let short = File { decompressed: 12, ..packed.clone() };
    assert!(refused(&short.bytes()).contains("level 0 has 12 bytes; 2 x 3 pixels need 24"));
    let damaged = File { level: packed.level[..9].to_vec(), ..packed };
    assert!(refused(&damaged.bytes()).contains("level 0 its compressed data is damaged"));
}

#[test]
fn orientation_swizzle_and_premultiplied_alpha() {
    let with =
        |key, value| File { pairs: vec![("KTXwriter", b"x"), (key, value)], ..File::counting(15, SRGB, 1) };
    let pixels = |file: &File| eight_bit(&load(&file.bytes()).unwrap()).to_vec();
    assert_eq!(pixels(&with("KTXorientation", b"rd")), [0, 1, 2, 3, 4, 5]);
    assert_eq!(pixels(&with("KTXorientation", b"ru")), [4, 5, 2, 3, 0, 1]);
    assert_eq!(pixels(&with("KTXorientation", b"lu")), [5, 4, 3, 2, 1, 0]);
    assert!(refused(&with("KTXorientation", b"du").bytes()).contains("expected rd, ru, ld or lu"));
    let alpha = load(&with("KTXswizzle", b"000r").bytes()).unwrap();
    assert_eq!((alpha.channels, &eight_bit(&alpha)[..4]), (2, &[0, 0, 0, 1][..]));
    assert!(refused(&with("KTXswizzle", b"rgbx").bytes()).contains("KTXswizzle"));
    let luminance = File { pairs: vec![("KTXswizzle", b"rrrg")], ..File::counting(22, SRGB, 2) };
    let luminance = load(&luminance.bytes()).unwrap();
    assert_eq!((luminance.channels, &eight_bit(&luminance)[..4]), (2, &[0, 1, 2, 3][..]));
    let level = [100, 50, 0, 200].repeat(6);
    let premultiplied = File { descriptor: [RGBSDA, 1, SRGB, 1], level, ..File::counting(43, SRGB, 4) };
    assert_eq!(pixels(&premultiplied)[..4], [128, 64, 0, 200]);
}

#[test]
fn two_channels_of_uastc_are_red_and_green() {
    // A block of one colour, mode 8: red 200, alpha 77.
    let block = 0x17_u128 | 200 << 5 | 200 << 13 | 200 << 21 | 77 << 29;
    let file = |channel| File {
        format: 0,
        size: [3, 2, 0, 0, 1, 1],
        descriptor: [166, 1, SRGB, 0],
        channels: vec![channel],
        level: block.to_le_bytes().to_vec(),
        decompressed: 16,
        ..File::default()
    };
    for (channel, pixel) in [
        (0, &[200, 200, 200][..]),
        (3, &[200, 200, 200, 77]),
        (4, &[200]),
        (5, &[200, 77, 0]),
        (6, &[200, 200, 0]),
    ] {
        let image = load(&file(channel).bytes()).unwrap();
        assert_eq!(eight_bit(&image), pixel.repeat(6), "{channel}");
    }
    // No mode has the code 0x45; the block has the error colour of the specification.
    let invalid = File { level: [0x45; 16].to_vec(), ..file(3) };
    assert_eq!(eight_bit(&load(&invalid.bytes()).unwrap())[..4], [255, 0, 255, 255]);
}

#[test]
fn what_is_not_a_picture_is_refused_by_name() {
    let plain = File::counting(43, SRGB, 4);
    let sized = |size| File { size, ..plain.clone() };
    let model = |format, model| File { format, descriptor: [model, 1, SRGB, 0], ..plain.clone() };
    for (file, expected) in [
        (sized([2, 2, 0, 0, 6, 1]), "a cube map is not supported"),
        (sized([2, 2, 2, 0, 1, 1]), "a 3-D texture is not supported"),
        (sized([2, 2, 0, 0, 3, 1]), "3 faces"),
        (sized([0, 2, 0, 0, 1, 1]), "is empty"),
        (sized([40_000, 2, 0, 0, 1, 1]), "exceeds 32768 on a side"),
        (sized([8000, 8000, 0, 0, 1, 1]), "cannot be held in a file of"),
        (model(0, 167), "UASTC HDR"),
        (model(145, 134), "BC (S3TC, RGTC or BPTC)"),
        (model(157, 162), "ASTC"),
        (File { scheme: 1, ..plain.clone() }, "BasisLZ with a format other than ETC1S"),
        (File { scheme: 7, ..plain.clone() }, "supercompression scheme 7"),
        (File { pairs: vec![("KTXanimData", &[0; 11])], ..plain.clone() }, "an animation is not supported"),
    ] {
        let message = refused(&file.bytes());
        assert!(message.contains(expected) && message.starts_with("a.ktx2: "), "{message}");
    }
    // The flag of a frame that refers to the one before it.
    let mut video = data("etc1s.ktx2");
    let global = u64::from_le_bytes(video[64..72].try_into().unwrap()) as usize;
    video[global + 20] |= 2;
    assert!(refused(&video).contains("video is not supported"));
}
