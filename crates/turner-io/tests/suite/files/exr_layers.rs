//! EXR files with further channels: what is written comes back, in every compression and sample kind.

use ::exr as exr_crate;
use turner::image::Pixels;
use turner_io::image::{
    ChannelValues, DecodeLimits, ExrCompression, ExrOptions, ExtraChannel, OutputImage, SampleKind, decode,
    exr,
};

const SIZE: (u32, u32) = (37, 41);

/// Waves with noise in the low bits, over several orders of magnitude.
fn waves(seed: u32) -> Vec<f32> {
    let pixels = SIZE.0 * SIZE.1;
    let noise = |i: u32| i.wrapping_mul(2_654_435_769).wrapping_add(seed.wrapping_mul(40_503)) >> 8;
    (0..pixels).map(|i| (i % SIZE.0) as f32 * 0.125 + noise(i) as f32 * 1e-7).collect()
}

fn color() -> Vec<[f32; 4]> {
    let (r, g, b) = (waves(1), waves(2), waves(3));
    (0..r.len()).map(|i| [r[i], g[i], b[i], 1.0 / (1 + i % 3) as f32]).collect()
}

fn layers() -> Vec<ExtraChannel<'static>> {
    let float = |name: &'static str, seed| ExtraChannel::new(name, SampleKind::Float, waves(seed));
    let half = |name: &'static str, seed| ExtraChannel::new(name, SampleKind::Half, waves(seed));
    let ids: Vec<u32> = (0..SIZE.0 * SIZE.1).map(|i| i.wrapping_mul(2_654_435_769)).collect();
    vec![
        float("N.X", 4),
        float("N.Y", 5),
        float("N.Z", 6),
        half("albedo.R", 7),
        half("albedo.G", 8),
        half("albedo.B", 9),
        float("Z", 10),
        ExtraChannel::new("id", SampleKind::Uint, ids),
        float("a layer with a name longer than the 31 bytes of OpenEXR 1.value", 11),
    ]
}

fn written(options: ExrOptions, threads: usize) -> Vec<u8> {
    let (linear, channels) = (color(), layers());
    let image = OutputImage {
        width: SIZE.0,
        height: SIZE.1,
        alpha: true,
        linear: Some(&linear),
        channels: &channels,
        exr: options,
        threads,
        ..OutputImage::default()
    };
    exr::encode(&image).unwrap()
}

const COMPRESSIONS: [ExrCompression; 3] = [ExrCompression::None, ExrCompression::Zip, ExrCompression::Piz];

#[test]
fn the_colour_is_found_among_layers() {
    for compression in COMPRESSIONS {
        let bytes = written(ExrOptions { compression, half: false }, 1);
        let found = exr::decode_as_stored(&bytes, "a.exr", &DecodeLimits::default()).unwrap();
        assert_eq!(found.pixels, Pixels::F32(color().into_flattened()), "{compression:?}");
    }
}

#[test]
fn every_channel_comes_back() {
    for compression in COMPRESSIONS {
        let bytes = written(ExrOptions { compression, half: false }, 1);
        let parts = exr::parts(&bytes, "a.exr").unwrap();
        let [part] = parts.as_slice() else { panic!("one part") };
        assert_eq!((part.width, part.height, part.data), (37, 41, [0, 0, 37, 41]));
        let word = ["none", "zip", "piz"][compression as usize];
        assert_eq!(
            (part.compression, part.tiles, part.deep, part.name.as_deref()),
            (word, None, false, None)
        );
        let mut expected = layers();
        for (i, name) in ["R", "G", "B", "A"].into_iter().enumerate() {
            let values: Vec<f32> = color().iter().map(|p| p[i]).collect();
            expected.push(ExtraChannel::new(name, SampleKind::Float, values));
        }
        expected.sort_by(|a, b| a.name.cmp(&b.name));
        for channel in &mut expected {
            if let (SampleKind::Half, ChannelValues::Float(values)) = (channel.kind, &mut channel.values) {
                values.to_mut().iter_mut().for_each(|v| *v = exr_crate::prelude::f16::from_f32(*v).to_f32());
            }
        }
        let found = exr::read_channels(&bytes, "a.exr", 0, |_| true, &DecodeLimits::default()).unwrap();
        assert!(found == expected, "{compression:?}");
        let listed: Vec<_> = part.channels.iter().map(|c| (c.name.as_str(), c.kind, c.subsampled)).collect();
        let all: Vec<_> = expected.iter().map(|c| (c.name.as_ref(), c.kind, false)).collect();
        assert_eq!(listed, all);
        let some = exr::read_channels(&bytes, "a.exr", 0, |n| n == "Z", &DecodeLimits::default()).unwrap();
        assert!(some.len() == 1 && some[0].values == ChannelValues::from(waves(10)));
    }
}

#[test]
fn a_layer_is_an_image() {
    let bytes = written(ExrOptions::default(), 1);
    let layer = |name: &str| exr::decode_layer(&bytes, "a.exr", name, &DecodeLimits::default());
    for name in ["N", "n"] {
        let found = layer(name).unwrap();
        assert_eq!((found.width, found.height, found.channels), (37, 41, 3), "{name}");
        let expected: Vec<f32> =
            (0..waves(4).len()).flat_map(|i| [waves(4)[i], waves(5)[i], waves(6)[i]]).collect();
        assert_eq!(found.pixels, Pixels::F32(expected), "{name}");
    }
    let expected = exr_crate::prelude::f16::from_f32(waves(7)[2 * 37 + 3]).to_f32();
    assert_eq!(layer("albedo").unwrap().rgb(3, 2)[0], expected);
    assert_eq!(layer("Z").unwrap().pixels, Pixels::F32(waves(10)));
    assert_eq!(layer("id").unwrap().channels, 1);
    // The only channel of its layer, with a name that says nothing.
    assert_eq!(layer("a layer with a name longer than the 31 bytes of OpenEXR 1").unwrap().channels, 1);
    let error = layer("normal").unwrap_err().to_string();
    assert!(
        error.contains("no layer \"normal\"") && error.contains("albedo") && error.contains('N'),
        "{error}"
    );
}

#[test]
fn channels_of_several_parts_have_the_name_of_their_part() {
    use exr_crate::prelude::*;
    let part = |name: &str, channels: &[&str], v: f32| {
        let list = channels.iter().map(|c| AnyChannel::new(*c, FlatSamples::F32(vec![v; 6]))).collect();
        Layer::new((3, 2), LayerAttributes::named(name), Encoding::FAST_LOSSLESS, AnyChannels::sort(list))
    };
    let layers =
        [part("main", &["R", "G", "B"], 1.0), part("albedo", &["albedo.R", "albedo.G", "albedo.B"], 2.0)];
    let mut bytes = std::io::Cursor::new(Vec::new());
    let size = IntegerBounds::from_dimensions((3, 2));
    let image = Image::from_layers(ImageAttributes::new(size), Vec::from(layers));
    image.write().to_buffered(&mut bytes).unwrap();
    let bytes = bytes.into_inner();
    let parts = exr::parts(&bytes, "a.exr").unwrap();
    let names: Vec<Vec<_>> =
        parts.iter().map(|p| p.channels.iter().map(|c| c.name.as_str()).collect()).collect();
    assert_eq!(names, [["main.B", "main.G", "main.R"], ["albedo.B", "albedo.G", "albedo.R"]]);
    for (layer, v) in [("main", 1.0), ("albedo", 2.0)] {
        let found = exr::decode_layer(&bytes, "a.exr", layer, &DecodeLimits::default()).unwrap();
        assert_eq!(found.pixels, Pixels::F32(vec![v; 18]));
    }
    assert!(exr::read_channels(&bytes, "a.exr", 2, |_| true, &DecodeLimits::default()).is_err());
}

#[test]
fn limits_hold_for_channels() {
    let bytes = written(ExrOptions::default(), 1);
    // 46 bytes per pixel are stored, and 13 channels become 52.
    let limits = DecodeLimits { max_bytes: u64::from(SIZE.0 * SIZE.1) * 48, ..DecodeLimits::default() };
    assert!(exr::decode_layer(&bytes, "a.exr", "N", &limits).is_ok());
    let error = exr::read_channels(&bytes, "a.exr", 0, |_| true, &limits).unwrap_err().to_string();
    assert!(error.contains("exceeds"), "{error}");
}

#[test]
fn threads_do_not_change_a_byte() {
    for compression in COMPRESSIONS {
        let options = ExrOptions { compression, half: true };
        let one = written(options, 1);
        assert!([2, 3, 64].iter().all(|threads| written(options, *threads) == one), "{compression:?}");
    }
}

#[test]
fn halves_are_rounded_and_stay_finite() {
    let linear = [[1.0, 1e6, -1e6, 1.0], [f32::INFINITY, f32::NAN, 1.0 + 1.0 / 1024.0, 0.5]];
    let exr = ExrOptions { half: true, ..ExrOptions::default() };
    let image = OutputImage {
        width: 2,
        height: 1,
        alpha: true,
        linear: Some(&linear),
        exr,
        ..OutputImage::default()
    };
    let bytes = exr::encode(&image).unwrap();
    let found = exr::decode_as_stored(&bytes, "a.exr", &DecodeLimits::default()).unwrap();
    let Pixels::F32(v) = found.pixels else { panic!("floats") };
    assert_eq!(v[..5], [1.0, 65504.0, -65504.0, 1.0, f32::INFINITY]);
    assert!(v[5].is_nan());
    assert_eq!(v[6..], [1.0 + 1.0 / 1024.0, 0.5]);
}

#[test]
fn long_names_are_declared_and_short_names_are_not() {
    // Bit 10 of the version field.
    assert_eq!(written(ExrOptions::default(), 1)[4..8], [2, 4, 0, 0]);
    let linear = [[0.0; 4]];
    let image = OutputImage { width: 1, height: 1, linear: Some(&linear), ..OutputImage::default() };
    assert_eq!(exr::encode(&image).unwrap()[4..8], [2, 0, 0, 0]);
}

#[test]
fn impossible_channels_are_refused() {
    let linear = [[0.0; 4]; 2];
    let encode = |channels: &[ExtraChannel<'_>]| {
        let linear = Some(&linear[..]);
        exr::encode(&OutputImage { width: 2, height: 1, linear, channels, ..OutputImage::default() })
            .map_err(|e| e.to_string())
    };
    let channel = |name: &'static str, n: usize| ExtraChannel::new(name, SampleKind::Float, vec![0.0; n]);
    assert!(encode(&[channel("Z", 2)]).is_ok());
    for (channels, expected) in [
        (vec![channel("Z", 3)], "3 samples; expected 2"),
        (vec![channel("A", 2)], "two channels are named \"A\""),
        (vec![channel("Z", 2), channel("N.X", 2), channel("Z", 2)], "two channels are named \"Z\""),
        (vec![channel("", 2)], "expected a name"),
        (vec![channel("a\0b", 2)], "expected a name"),
    ] {
        let error = encode(&channels).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn other_formats_do_not_store_channels() {
    let linear = color();
    let (width, height) = SIZE;
    let plain = OutputImage { width, height, linear: Some(&linear), ..OutputImage::default() };
    let channels = layers();
    let with = OutputImage { channels: &channels, ..plain.clone() };
    let hdr = turner_io::image::ImageFormat::Hdr;
    let bytes = turner_io::image::encode(&with, hdr).unwrap();
    assert_eq!(bytes, turner_io::image::encode(&plain, hdr).unwrap());
    assert_eq!(decode(&bytes, "a.hdr", &DecodeLimits::default()).unwrap().channels, 3);
}
