//! Pictures written strip by strip.

use std::borrow::Cow;
use std::io::Cursor;
use std::ops::Range;
use std::sync::atomic::AtomicBool;

use turner::color::DisplaySpace;
use turner::film::{Antialias, DisplayTransform};
use turner::render::{PassOptions, Renderer};
use turner::schema::PrepareOptions;
use turner_io::assets::MemoryAssets;
use turner_io::image::{DecodeLimits, ImageFormat, Metadata, OutputImage, Strip, StripImage, decode, write};
use turner_io::scene::{LoadOptions, load_text};
use turner_io::{DisplayOptions, Rounding, SaveOptions, to_bytes};

const SCENE: &str = r#"
[film]
width = 150
height = 83
samples = 2
auto_exposure = true
[background]
transparent = true
[camera]
position = [0, 1, 6]
look_at = [0, 0, 0]
fov = 40
[[light]]
type = "point"
position = [2, 4, 3]
intensity = 30
[[object]]
type = "sphere"
"#;

#[test]
fn a_film_is_saved_like_its_picture() {
    let loaded = load_text(SCENE.to_owned(), "s.toml", &MemoryAssets::default(), &LoadOptions::default());
    let scene = loaded.unwrap().desc.prepare(&PrepareOptions::default()).unwrap();
    let mut renderer = Renderer::new(scene).unwrap();
    let cancel = AtomicBool::new(false);
    let pass = PassOptions { threads: 2, cancel: &cancel, progress: None };
    assert!(renderer.pass(u32::MAX, &pass).unwrap());
    let film = &renderer.prepared().view.film;
    assert_ne!(film.antialias, Antialias::Mean);
    let picture = renderer.develop();
    let developed = renderer.film.developed(film, 2);
    assert!(picture.has_alpha && developed.has_alpha);
    assert_eq!((developed.exposure, developed.missing), (picture.exposure, 0));
    let special = DisplayOptions {
        transform: DisplayTransform { space: DisplaySpace::DisplayP3, ..picture.transform(film) },
        rounding: Rounding::Dithered,
    };
    for display in [None, Some(special)] {
        for format in ImageFormat::all().filter(|f| f.can_write()) {
            let options = SaveOptions { display, threads: 2, ..SaveOptions::default() };
            if display.is_some() && !matches!(format, ImageFormat::Png) {
                continue;
            }
            let expected = to_bytes(&picture, format, &options).unwrap();
            assert!(to_bytes(&developed, format, &options).unwrap() == expected, "{}", format.name());
        }
    }
}

/// The picture is too large to be compressed all at once. It compresses well, so that the test is quick.
#[test]
fn large_pictures_have_all_their_rows() {
    let (width, height) = (6000u32, 4000u32);
    let value = |x: u32, y: u32| [(x / 24) as u8, (y / 16) as u8, (x ^ y) as u8, 255];
    let metadata = Metadata::new();
    let image = OutputImage { width, height, threads: 2, metadata: &metadata, ..OutputImage::default() };
    let rows = |rows: Range<u32>, _: usize| {
        let pixels = rows.flat_map(|y| (0..width).map(move |x| value(x, y)));
        Strip::Display(Cow::Owned(pixels.collect()))
    };
    let mut out = Cursor::new(Vec::new());
    write(&StripImage { image: &image, is_deep: false, rows: &rows }, ImageFormat::Png, &mut out).unwrap();
    let bytes = out.into_inner();
    assert!(bytes.windows(4).filter(|w| w == b"IDAT").count() > 1, "not in chunks");
    let read = decode(&bytes, "large.png", &DecodeLimits::default()).unwrap();
    assert_eq!((read.width, read.height), (width, height));
    for (x, y) in [(0, 0), (5999, 3999), (17, 2000), (5999, 1), (3000, 174), (3000, 175), (1, 3999)] {
        let expected = value(x, y).map(|v| f32::from(v) / 255.0);
        assert_eq!(read.rgb(x, y), [expected[0], expected[1], expected[2]], "{x} {y}");
    }
}

/// Rows that are missing are an error, not black.
#[test]
fn missing_rows_are_an_error() {
    let image = OutputImage { width: 4, height: 4, ..OutputImage::default() };
    for format in ImageFormat::all().filter(|f| f.can_write()) {
        for rows in [
            &(|_: Range<u32>, _: usize| Strip::Display(Cow::Borrowed(&[]))) as &(dyn Fn(_, _) -> _ + Sync),
            &|_, _| Strip::Linear(Cow::Borrowed(&[])),
            &|_, _| Strip::Display16(Cow::Borrowed(&[])),
        ] {
            let strips = StripImage { image: &image, is_deep: false, rows };
            assert!(write(&strips, format, &mut Cursor::new(Vec::new())).is_err(), "{}", format.name());
        }
    }
}
