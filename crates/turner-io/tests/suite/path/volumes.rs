//! Participating media from text and files.

use turner::schema::{ErrorCode, PrepareOptions};

use crate::classic::common::render_with;

/// A wall at z = −10 that emits 1.
const WALL: &str = "{ type = \"rectangle\", center = [0, 0, -10], edge_u = [9, 0, 0], edge_v = [0, 9, 0], material = { type = \"emissive\" } }";

#[test]
fn nonsense_is_an_error_at_its_place() {
    let load = |medium: &str| {
        let text =
            format!("object = [{{ type = \"sphere\", medium = {medium} }}]\nintegrator.type = \"path\"\n");
        let assets = turner_io::assets::MemoryAssets::default();
        let loaded = turner_io::scene::load_text(text, "t.toml", &assets, &Default::default());
        match loaded {
            Ok(loaded) => loaded.desc.prepare(&PrepareOptions::default()).err().map(|e| e.code.as_str()),
            Err(e) => Some(e.code()),
        }
    };
    for (medium, code) in [
        ("{ extinction = -1 }", ErrorCode::OutOfRange),
        ("{ extinction = nan }", ErrorCode::OutOfRange),
        ("{ scattering = inf }", ErrorCode::OutOfRange),
        ("{ albedo = 1.5 }", ErrorCode::OutOfRange),
        ("{ anisotropy = 1 }", ErrorCode::OutOfRange),
        ("{ emission = [0, -1, 0] }", ErrorCode::OutOfRange),
        ("{ density = -2 }", ErrorCode::OutOfRange),
        ("{ extinction = 1, absorption = 1 }", ErrorCode::Conflict),
        ("{ exctinction = 1 }", ErrorCode::UnknownKey),
        ("\"smoke\"", ErrorCode::UnknownName),
        ("{ type = \"smoke\", radius = 0 }", ErrorCode::OutOfRange),
        ("{ type = \"smoke\", resolution = 100000 }", ErrorCode::OutOfRange),
        ("{ type = \"smoke\", size = inf }", ErrorCode::OutOfRange),
        ("{ type = \"grid\", file = \"none.grid\" }", ErrorCode::File),
        ("{ type = \"steam\" }", ErrorCode::UnknownName),
        ("3", ErrorCode::WrongType),
        ("\"x\", material = { color = \"red\" }", ErrorCode::Conflict),
    ] {
        assert_eq!(load(medium), Some(code.as_str()), "{medium}");
    }
    assert_eq!(load("{ extinction = 1e29, emission = 1e14 }"), None);
}

/// An OpenVDB file lies where its transform places it, unless the scene gives a box.
#[test]
fn openvdb_files_are_grids() {
    let mut assets = turner_io::assets::MemoryAssets::default();
    let seed = turner_io::testing::seeds::seeds().into_iter().find(|s| s.name == "cloud.vdb").unwrap();
    assets.files.insert("cloud.vdb".into(), seed.bytes);
    let load = |keys: &str| {
        let text = format!("[medium.m]\ntype = \"grid\"\n{keys}\n");
        turner_io::scene::load_text(text, "t.toml", &assets, &Default::default())
    };
    let bounds = |keys: &str| match &load(keys).unwrap().desc.media[0].value {
        turner::medium::MediumDesc::Grid(grid) => grid.bounds().map(|p| p.to_array()),
        other => panic!("{other:?}"),
    };
    // The voxels -4..=5, 0..=6 and 1, one cell around them, and cells of 0.5 units.
    let own = [[-2.75, -0.75, -0.25], [3.25, 3.75, 1.25]];
    assert_eq!(bounds("file = \"cloud.vdb\""), own);
    assert_eq!(bounds("file = \"cloud.vdb#density\"\nmin = [-3, -1, -1]"), [[-3.0, -1.0, -1.0], own[1]]);
    let error = load("file = \"cloud.vdb#heat\"").err().unwrap();
    assert_eq!((error.code(), error.line()), ("E0206", Some(3)));
    assert!(error.to_string().contains("no grid \"heat\"; its grids: \"density\" (float)"), "{error}");
}

/// A grid of constant density is a homogeneous medium; a damaged grid is an error at its name.
#[test]
fn grids_come_from_files() {
    let mut assets = turner_io::assets::MemoryAssets::default();
    let even = turner_io::grid::encode([5, 9, 4], &[0.5; 180], Some(&[2.0; 180]));
    assets.files.insert("short.grid".into(), even[..even.len() - 3].to_vec());
    assets.files.insert("even.grid".into(), even);
    let scene = |medium: &str| {
        format!(
            "film = {{ width = 4, height = 4, antialias = \"monte-carlo\", samples = 4096 }}\n\
             camera = {{ position = [0, 0, 10], look_at = [0, 0, 0], fov = 0.001 }}\nintegrator.type = \"path\"\n\
             object = [{{ type = \"box\", min = [-3, -3, -2], max = [3, 3, 2], medium = {{ {medium} }} }}, {WALL}]\n"
        )
    };
    let load = |text: String| turner_io::scene::load_text(text, "t.toml", &assets, &Default::default());
    let grid = "type = \"grid\", file = \"even.grid\", min = [-2, -2, -1], max = [2, 2, 1], absorption = [1, 2, 0], emission = 0.3";
    let picture = render_with(&load(scene(grid)).unwrap().desc, 2, u32::MAX).0;
    for band in 0..3 {
        let sigma = [0.5, 1.0, 0.0][band];
        let left = f64::exp(-2.0 * sigma);
        let emitted = 0.3 * if sigma > 0.0 { (1.0 - left) / sigma } else { 2.0 };
        let mean = picture.linear.iter().map(|p| f64::from(p[band])).sum::<f64>() / 16.0;
        assert!((mean - left - emitted).abs() < 0.01, "{band}: {mean}, not {}", left + emitted);
    }
    let error = load(scene("type = \"grid\", file = \"short.grid\"")).err().unwrap();
    assert_eq!((error.code(), error.line()), ("E0206", Some(4)));
    let empty = grid.replace("max = [2, 2, 1]", "max = [2, -2, 1]");
    let desc = load(scene(&empty)).unwrap().desc;
    assert_eq!(desc.prepare(&PrepareOptions::default()).unwrap_err().code, ErrorCode::OutOfRange);
}
