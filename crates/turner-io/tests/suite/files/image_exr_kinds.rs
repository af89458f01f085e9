//! EXR files of luminance and chroma, and of deep pixels, made with NumPy and OpenEXR: `tests/data/CREDITS.md` has the formulas.

use turner::image::{Image, Pixels};
use turner_io::image::{ChannelValues, DecodeLimits, decode, exr};

const SIZE: [usize; 2] = [12, 10];

fn data(name: &str) -> Vec<u8> {
    std::fs::read(format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn pixels(image: &Image) -> &[f32] {
    assert_eq!([image.width as usize, image.height as usize], SIZE);
    let Pixels::F32(values) = &image.pixels else { panic!("floats") };
    values
}

#[test]
fn luminance_and_chroma_become_colours() {
    let mut first: Option<Vec<f32>> = None;
    for name in ["none", "zips", "zip"] {
        let bytes = data(&format!("chroma_{name}.exr"));
        let limits = DecodeLimits::default();
        let list = exr::read_channels(&bytes, name, 0, |_| true, &limits).unwrap();
        let channel = |name: &str| {
            let ChannelValues::Float(v) = &list.iter().find(|c| c.name == name).unwrap().values else {
                panic!()
            };
            v.to_vec()
        };
        let (luminance, red) = (channel("Y"), channel("RY"));
        let image = decode(&bytes, name, &limits).unwrap();
        assert_eq!(image.channels, 3);
        let values = pixels(&image);
        for y in 0..SIZE[1] {
            for x in 0..SIZE[0] {
                let i = y * SIZE[0] + x;
                let expected = (1 + x + 16 * y) as f32 / 64.0;
                assert_eq!(luminance[i], expected, "{name}");
                // The sample of an even pixel counts for its neighbours.
                assert_eq!(red[i], (x & !1) as f32 / 16.0, "{name}");
                let [r, g, b] = [values[3 * i], values[3 * i + 1], values[3 * i + 2]];
                let found = 0.2126 * r + 0.7152 * g + 0.0722 * b;
                assert!((found / expected - 1.0).abs() < 1e-3, "{name} {x} {y}: {found} {expected}");
                if x % 2 == 0 && y % 2 == 0 && x < 4 && y < 6 {
                    // Not saturated enough to be limited.
                    let (ry, by) = (x as f32 / 16.0, y as f32 / 16.0 - 0.25);
                    let near =
                        |found: f32, chroma: f32| (found / ((1.0 + chroma) * expected) - 1.0).abs() < 1e-4;
                    assert!(near(r, ry) && near(b, by), "{name} {x} {y}: {r} {g} {b}");
                }
            }
        }
        assert_eq!(first.get_or_insert_with(|| values.to_vec()), values, "{name}");
    }
}

#[test]
fn deep_pixels_are_flattened_from_front_to_back() {
    for kind in ["scanline", "tile"] {
        for name in ["none", "rle", "zips"] {
            let bytes = data(&format!("deep_{kind}_{name}.exr"));
            let image = exr::decode_as_stored(&bytes, name, &DecodeLimits::default()).unwrap();
            assert_eq!(image.channels, 4);
            for (i, pixel) in pixels(&image).chunks_exact(4).enumerate() {
                let (x, y) = (i % SIZE[0], i / SIZE[0]);
                let mut expected = [0.0f32; 4];
                let mut passes = 1.0;
                // The last sample is nearest; each has an alpha of one half.
                for k in (0..(x + y) % 4).rev() {
                    let sample = [(k + 1) as f32 / 8.0, x as f32 / 16.0, y as f32 / 16.0, 0.5];
                    (0..4).for_each(|c| expected[c] += passes * sample[c]);
                    passes *= 0.5;
                }
                assert_eq!(pixel, expected, "{kind} {name} {x} {y}");
            }
            for cut in (0..bytes.len()).step_by(13) {
                let _ = decode(&bytes[..cut], name, &DecodeLimits::default());
            }
            for at in (0..bytes.len()).step_by(3) {
                let mut bad = bytes.clone();
                bad[at] ^= 0x81;
                let _ = decode(&bad, name, &DecodeLimits::default());
            }
        }
    }
}
