//! Damaged scenes and meshes: an error or a scene, quickly, and no panic.

use std::time::{Duration, Instant};

use proptest::prelude::*;
use turner_io::assets::MemoryAssets;
use turner_io::mesh::decode;
use turner_io::scene::{LoadOptions, Override, load_text};

const SCENE: &str = "include = \"b.toml\"\n[film]\nwidth = 0x10\nheight = 1_0\n[camera]\nfov = 4.5e1\neye = [1, -2.5, 3]\n\
[texture.a]\ntype = \"checkerboard\"\n[material.m]\ncolor = 'a'\n[[object]]\ntype = \"sphere\"\nmaterial = \"m\"\n\
transform = [{ scale = 2 }, { rotate = { axis = [0, 1, 0], angle = 30 } },]\n[[light]]\ntype = \"point\"\n\
[[group.g.object]]\ntype = \"sphere\"\n\"radius\" = 0.5 # \u{e9}\n";

fn try_scene(bytes: &[u8]) {
    let assets = MemoryAssets { files: [("b.toml".to_owned(), bytes.to_vec())].into() };
    let start = Instant::now();
    let options = LoadOptions::default();
    let shown = |r: Result<_, turner_io::scene::LoadError>| {
        if let Err(e) = r {
            drop((e.to_string(), e.location()))
        }
    };
    shown(load_text(String::from_utf8_lossy(bytes).into_owned(), "a.toml", &assets, &options).map(|_| ()));
    shown(load_text("include = 'b.toml'".to_owned(), "a.toml", &assets, &options).map(|_| ()));
    assert!(start.elapsed() < Duration::from_secs(5));
}

fn try_mesh(bytes: &[u8], name: &str) {
    let start = Instant::now();
    if let Ok(read) = decode(bytes, name) {
        let n = read.mesh.positions.len();
        assert!(read.mesh.triangles.as_flattened().iter().all(|&i| (i as usize) < n));
        assert!(read.mesh.normals.is_empty() || read.mesh.normals.len() == n);
        assert!(read.mesh.uvs.is_empty() || read.mesh.uvs.len() == n);
    }
    assert!(start.elapsed() < Duration::from_secs(5));
}

fn data(name: &str) -> Vec<u8> {
    std::fs::read(format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn binary_ply() -> Vec<u8> {
    let mut bytes =
        b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
property float z\nelement face 2\nproperty list uchar int vertex_index\nend_header\n"
            .to_vec();
    (0..9_u8).for_each(|i| bytes.extend(f32::from(i).to_le_bytes()));
    for face in [[0_i32, 1, 2], [2, 1, 0]] {
        bytes.push(3);
        face.iter().for_each(|i| bytes.extend(i.to_le_bytes()));
    }
    bytes
}

#[test]
fn truncated_anywhere() {
    (0..SCENE.len()).for_each(|n| try_scene(&SCENE.as_bytes()[..n]));
    for name in ["multi.ply", "cube.obj", "negative_indices.obj"] {
        let bytes = data(name);
        (0..bytes.len()).for_each(|n| try_mesh(&bytes[..n], name));
    }
    let bytes = binary_ply();
    assert!(decode(&bytes, "a.ply").is_ok());
    (0..bytes.len()).for_each(|n| try_mesh(&bytes[..n], "a.ply"));
}

#[test]
fn every_bit_flipped() {
    let flip = |bytes: &[u8], try_it: &dyn Fn(&[u8])| {
        let mut bytes = bytes.to_vec();
        for bit in 0..bytes.len() * 8 {
            bytes[bit / 8] ^= 1 << (bit % 8);
            try_it(&bytes);
            bytes[bit / 8] ^= 1 << (bit % 8);
        }
    };
    flip(SCENE.as_bytes(), &try_scene);
    flip(&data("cube.obj"), &|b| try_mesh(b, "a.obj"));
    flip(&data("multi.ply"), &|b| try_mesh(b, "a.ply"));
    flip(&binary_ply(), &|b| try_mesh(b, "a.ply"));
}

#[test]
fn nesting_never_overflows_the_stack() {
    for text in [
        format!("a = {}", "[".repeat(1_000_000)),
        format!("a = {}", "{a=".repeat(1_000_000)),
        format!("{}a = 1", "a.".repeat(1_000_000)),
        format!("[{}a]", "a.".repeat(1_000_000)),
        format!("a = {}1{}", "[".repeat(60), "]".repeat(60)),
        format!("a = {{ {}", "a.a.a.a.a.a.a.a\n={".repeat(10_000)),
        "[[".repeat(1_000_000),
    ] {
        let thread = std::thread::Builder::new().stack_size(512 << 10);
        thread.spawn(move || try_scene(text.as_bytes())).unwrap().join().unwrap();
    }
    let deep = Override { path: "a.".repeat(100_000) + "a", value: "[".repeat(100_000) };
    let options = LoadOptions { overrides: vec![deep], ..LoadOptions::default() };
    assert!(load_text(String::new(), "a.toml", &MemoryAssets::default(), &options).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        try_scene(&bytes);
        try_mesh(&bytes, "a.obj");
        try_mesh(&[b"ply\n", bytes.as_slice()].concat(), "a.ply");
    }

    #[test]
    fn any_override(path in "[a-c.0-9\"' =\\[\\]{}#\n]{0,12}", value in "\\PC{0,20}") {
        let options = LoadOptions { overrides: vec![Override { path, value }], ..LoadOptions::default() };
        drop(load_text(SCENE.replace("include", "#"), "a.toml", &MemoryAssets::default(), &options).map_err(|e| e.to_string()));
    }
}
