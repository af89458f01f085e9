//! Tests of all textures, and helpers for the tests of single ones.

use std::sync::Arc;

use super::prepare::{MAX_DEPTH, MAX_LOOKUPS};
use super::*;
use crate::color::Transfer;
use crate::description::{ModelDesc, SceneAssets, SceneDesc, read_scene};
use crate::image::{Image, Pixels};
use crate::schema::value::{Data, Entry, FileId, Span, Table, Value};
use crate::schema::{ErrorCode, MeshData, Named};

pub(super) const NOWHERE: Span = Span { file: FileId(0), start: 0, end: 0 };

pub(super) fn text(s: &str) -> Data {
    Data::String(s.to_owned())
}

pub(super) fn list(items: &[f64]) -> Data {
    Data::Array(items.iter().map(|v| value(Data::Number(*v))).collect())
}

pub(super) fn value(data: Data) -> Value {
    Value { data, span: NOWHERE }
}

pub(super) fn table(entries: &[(&str, Data)]) -> Data {
    let entry = |(key, data): &(&str, Data)| Entry {
        key: (*key).to_owned(),
        key_span: NOWHERE,
        value: value(data.clone()),
    };
    Data::Table(Table { entries: entries.iter().map(entry).collect() })
}

/// Stands for every image file: 4 × 2 texels, with the column in red and the row in green.
pub(super) fn picture() -> Image {
    let samples = (0..8u8).flat_map(|i| [(i % 4) * 60, (i / 4) * 200, 40]).collect();
    Image { width: 4, height: 2, channels: 3, pixels: Pixels::U8(samples) }
}

struct OnePicture(Arc<Image>);

impl SceneAssets for OnePicture {
    fn image(&mut self, _: &str, _: FileId) -> Result<Arc<Image>, SceneError> {
        Ok(self.0.clone())
    }
    fn mesh(&mut self, uri: &str, _: FileId) -> Result<Arc<MeshData>, SceneError> {
        Err(SceneError::new(ErrorCode::File, uri))
    }
    fn model(&mut self, model: &ModelDesc, _: FileId) -> Result<Arc<SceneDesc>, SceneError> {
        Err(SceneError::new(ErrorCode::File, model.file.as_str()))
    }
}

/// The scene of some `[texture.NAME]` tables.
pub(super) fn scene(textures: &[(&str, Data)]) -> Result<SceneDesc, SceneError> {
    let root = value(table(&[("texture", table(textures))]));
    read_scene(&root, &mut OnePicture(Arc::new(picture())))
}

/// A scene with one texture.
pub(super) fn read(kind: &str, keys: &[(&str, Data)]) -> Result<SceneDesc, SceneError> {
    let mut entries = vec![("type", text(kind))];
    entries.extend_from_slice(keys);
    scene(&[("t", table(&entries))])
}

/// One prepared texture, with display values unchanged.
pub(super) fn prepare_texture(kind: &str, keys: &[(&str, Data)]) -> Textures {
    prepared(&read(kind, keys).unwrap())
}

pub(super) fn prepared(scene: &SceneDesc) -> Textures {
    Textures::prepare(&scene.textures, &scene.images, Transfer::None, false).unwrap()
}

/// The colour at texture coordinates (s, t), and at (s, t, 0) in space.
pub(super) fn at(textures: &Textures, s: f64, t: f64) -> Spectrum {
    let uv = DVec2::new(0.5 + 0.5 * s, 0.5 + 0.5 * t);
    textures.eval(TextureId(0), &TexturePoint::new(uv, DVec3::new(s, t, 0.0)))
}

/// A checkerboard of two colours, each a colour name or a texture.
fn board(even: &str, odd: &str) -> Data {
    table(&[("type", text("checkerboard")), ("even", text(even)), ("odd", text(odd))])
}

fn refused(scene: &SceneDesc) -> SceneError {
    Textures::prepare(&scene.textures, &scene.images, Transfer::None, false).unwrap_err()
}

#[test]
fn every_texture_is_finite_everywhere() {
    let odd =
        [0.0, -0.0, -1e-300, 0.5, 1e9, -1e18, 1e300, f64::MAX, f64::INFINITY, f64::NEG_INFINITY, f64::NAN];
    let everything = TextureDesc::DOC.entries.iter().flat_map(|doc| {
        let keys = match doc.name {
            "multiply" | "mix" => vec![("a", Data::Number(1e30)), ("b", Data::Number(-1e30))],
            kind => needed(kind),
        };
        let huge = match doc.name {
            "constant" | "vertex-color" | "multiply" | "mix" => vec![],
            _ => vec![("density", Data::Number(-1e300))],
        };
        let turned = match doc.name {
            "constant" | "vertex-color" | "multiply" | "mix" => vec![],
            _ => vec![("transform", table(&[("rotate", list(&[10.0, 20.0, 30.0]))]))],
        };
        [vec![], huge, turned].map(|more| (doc.name, [keys.clone(), more].concat()))
    });
    for (name, keys) in everything {
        let textures = prepare_texture(name, &keys);
        for x in odd {
            for y in odd {
                for z in odd {
                    let point = TexturePoint::new(DVec2::new(x, y), DVec3::new(z, x, y));
                    let c = textures.eval(TextureId(0), &point);
                    assert!(c.is_finite(), "{name} at {point:?}: {c:?}");
                }
            }
        }
    }
}

#[test]
fn defaults_stay_between_their_colours() {
    for name in ["checkerboard", "stripes", "gradient", "wood", "marble", "noise"] {
        let textures = prepare_texture(name, &[]);
        for i in 0..2000 {
            let c = at(&textures, f64::from(i % 50) * 0.11 - 2.0, f64::from(i / 50) * 0.13 - 2.0);
            assert!(c.to_array().iter().all(|v| (0.0..=1.0).contains(v)), "{name}: {c:?}");
        }
    }
}

#[test]
fn checkerboard_squares_alternate_across_zero() {
    let board = prepare_texture("checkerboard", &[("density", Data::Integer(4))]);
    for i in -12..12 {
        for j in -12..12 {
            let c = at(&board, (f64::from(i) + 0.5) / 4.0, (f64::from(j) + 0.25) / 4.0);
            let even = (i + j) % 2 == 0;
            assert_eq!(c, if even { Spectrum::WHITE } else { Spectrum::BLACK }, "square {i}, {j}");
        }
    }
    // The lower and left edges belong to a square.
    assert_eq!(at(&board, 0.0, 0.0), Spectrum::WHITE);
    assert_eq!(at(&board, 0.25, 0.0), Spectrum::BLACK);
    assert_eq!(at(&board, -1.0, -1.0), Spectrum::WHITE);
}

#[test]
fn hex_defaults_follow_the_transfer_curve() {
    let scene = read("wood", &[("grain", Data::Integer(0)), ("rings", Data::Integer(0))]).unwrap();
    let shown = |transfer: Transfer| {
        let c = at(&Textures::prepare(&scene.textures, &[], transfer, false).unwrap(), 0.1, 0.2);
        c.map(|v| transfer.encode(v))
    };
    let (a, b) = (shown(Transfer::None), shown(Transfer::Srgb));
    assert!((a.g - b.g).abs() < 0.05, "{a:?} and {b:?}");
}

#[test]
fn textures_nest() {
    let scene = scene(&[
        ("a", board("b", "red")),
        ("b", table(&[("type", text("gradient")), ("from", text("lime")), ("to", board("blue", "b2"))])),
        ("b2", table(&[("type", text("constant")), ("color", text("white"))])),
    ])
    .unwrap();
    let textures = prepared(&scene);
    assert_eq!(at(&textures, 0.25, -0.5), Spectrum::new(1.0, 0.0, 0.0));
    // Half-way from lime to blue at s = 0, in an even square.
    assert_eq!(at(&textures, 0.0, 0.5), Spectrum::new(0.0, 0.5, 0.5));
    assert!(textures.uses_uv(ColorSource::Texture(TextureId(0))));
    assert!(!textures.uses_uv(ColorSource::Texture(TextureId(2))));
    assert!(!textures.uses_uv(ColorSource::Constant(Spectrum::WHITE)));
}

#[test]
fn cycles_are_refused_with_their_names() {
    let error = refused(&scene(&[("a", board("red", "b")), ("b", board("a", "red"))]).unwrap());
    assert_eq!(error.code, ErrorCode::Cycle);
    assert_eq!(error.message, "a texture contains itself: a -> b -> a");
    assert!(error.span.is_some());

    let error = refused(&scene(&[("x", board("me", "red")), ("me", board("me", "me"))]).unwrap());
    assert_eq!(error.message, "a texture contains itself: me -> me");

    let inner = board("a", "red");
    let a = table(&[("type", text("stripes")), ("even", inner)]);
    let error = refused(&scene(&[("a", a)]).unwrap());
    assert_eq!(error.message, "a texture contains itself: a -> { checkerboard } -> a");
}

/// The keys that a texture type requires, with any values.
fn needed(kind: &str) -> Vec<(&'static str, Data)> {
    match kind {
        "image" => vec![("file", text("picture.png"))],
        "multiply" | "mix" => vec![("a", text("red")), ("b", text("blue"))],
        _ => vec![],
    }
}

/// What a texture type reports agrees with its keys: its input textures, and its mapping.
#[test]
fn kinds_know_all_their_keys() {
    for entry in TextureDesc::DOC.entries {
        for field in entry.fields {
            let with = |value: Data| {
                let others = needed(entry.name).into_iter().filter(|(key, _)| *key != field.name);
                let mut keys = vec![("type", text(entry.name)), (field.name, value)];
                keys.extend(others);
                scene(&[("t", table(&keys))])
            };
            match (field.kind)().as_str() {
                "color | texture" => {
                    let error = refused(&with(text("t")).unwrap());
                    assert_eq!(error.code, ErrorCode::Cycle, "`{}` of {}", field.name, entry.name);
                }
                _ if field.name == "mapping" => {
                    let of = |mapping: &str| with(text(mapping)).unwrap().textures[0].value.clone();
                    assert!(of("uv").uses_uv() && !of("solid").uses_uv(), "{}", entry.name);
                    assert!(of("uv").triplanar().is_none(), "{}", entry.name);
                    assert!(of("triplanar").triplanar().is_some(), "{}", entry.name);
                }
                _ => {}
            }
        }
    }
}

/// Checkerboards t0, t1, …, each nested in the one before; the last is plain.
fn chained(n: u32, odd: impl Fn(u32) -> String) -> SceneDesc {
    let names: Vec<String> = (0..=n).map(|i| format!("t{i}")).collect();
    let texture = |i: u32| {
        if i + 1 == n {
            return board("red", "blue");
        }
        board(&names[i as usize + 1], &odd(i + 1))
    };
    let list: Vec<(&str, Data)> = (0..n).map(|i| (names[i as usize].as_str(), texture(i))).collect();
    scene(&list).unwrap()
}

#[test]
fn nesting_has_a_limit() {
    let at_limit = chained(MAX_DEPTH, |i| format!("t{i}"));
    assert!(Textures::prepare(&at_limit.textures, &[], Transfer::None, false).is_ok());
    let error = refused(&chained(MAX_DEPTH + 1, |_| "red".into()));
    assert_eq!(error.code, ErrorCode::Cycle);
    assert!(error.message.starts_with("textures nest deeper than 64: t0 -> t1 -> "), "{}", error.message);
    // Too many for a recursion; the message stays short.
    let error = refused(&chained(20_000, |_| "red".into()));
    assert_eq!(error.code, ErrorCode::Cycle);
    assert!(error.message.len() < 300);
}

#[test]
fn textures_that_would_take_forever_are_refused() {
    let names: Vec<String> = (0..40).map(|i| format!("t{i}")).collect();
    let list: Vec<(&str, Data)> = (0..40)
        .map(|i| {
            // A texture mixed with itself is evaluated once; with the next but one, exponentially often.
            let inner = |i: usize| names.get(i).map_or("red", String::as_str);
            let keys = [("type", text("noise")), ("low", text(inner(i + 1))), ("high", text(inner(i + 2)))];
            (names[i].as_str(), table(&keys))
        })
        .collect();
    let error = refused(&scene(&list).unwrap());
    assert_eq!(error.code, ErrorCode::TooLarge);
    assert!(error.message.contains(&MAX_LOOKUPS.to_string()));
}

#[test]
fn dangling_references_are_errors_not_panics() {
    let mut scene = read("image", &[("file", text("p.png"))]).unwrap();
    scene.images.clear();
    assert_eq!(refused(&scene).code, ErrorCode::Internal);
    let missing = ColorSource::Texture(TextureId(7));
    let constant = ColorSource::Constant(Spectrum::BLACK);
    let mut descs: Vec<Named<TextureDesc>> = read("checkerboard", &[]).unwrap().textures;
    let TextureDesc::Checkerboard(board) = &mut descs[0].value else { panic!("expected a checkerboard") };
    (board.even, board.odd) = (missing, constant);
    assert_eq!(Textures::prepare(&descs, &[], Transfer::None, false).unwrap_err().code, ErrorCode::Internal);
}

#[test]
fn memory_counts_a_shared_picture_once() {
    let image = table(&[("type", text("image")), ("file", text("p.png"))]);
    let one = prepared(&scene(&[("a", image.clone())]).unwrap());
    let two = prepared(&scene(&[("a", image.clone()), ("b", image)]).unwrap());
    assert_eq!(one.image_memory, picture().memory());
    assert_eq!(two.image_memory, one.image_memory);
    assert!(two.memory() > one.memory());
}
