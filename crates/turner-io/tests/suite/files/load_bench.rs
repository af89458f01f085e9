//! Times and memory of large inputs: `cargo test --release -p turner-io --test suite load_bench -- --ignored
//! --nocapture`.

use std::fmt::Write;
use std::time::Instant;

use turner_io::assets::MemoryAssets;
use turner_io::mesh::decode;
use turner_io::scene::{LoadOptions, load_text};

fn peak() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    status.lines().find(|l| l.starts_with("VmHWM")).unwrap_or("no figure").to_owned()
}

#[test]
#[ignore = "a measurement"]
fn ten_million_triangles_of_ply() {
    let (v, f) = (5_000_000_u32, 10_000_000_u32);
    let mut bytes = format!("ply\nformat binary_little_endian 1.0\nelement vertex {v}\nproperty float x\nproperty float y\nproperty float z\nelement face {f}\nproperty list uchar int vertex_indices\nend_header\n").into_bytes();
    (0..v * 3).for_each(|i| bytes.extend((i as f32).to_le_bytes()));
    for i in 0..f {
        bytes.push(3);
        (0..3).for_each(|k| bytes.extend(((i + k) % v).to_le_bytes()));
    }
    let start = Instant::now();
    let read = decode(&bytes, "a.ply").unwrap();
    println!(
        "{} triangles, {} bytes: {:?}, {}",
        read.mesh.triangles.len(),
        bytes.len(),
        start.elapsed(),
        peak()
    );
}

#[test]
#[ignore = "a measurement"]
fn a_million_faces_of_obj() {
    let n = 700;
    let mut text = String::new();
    for i in 0..n * n {
        writeln!(text, "v {}.25 {}.5 0.125\nvt 0.{i} 0.5\nvn 0 0 1", i / n, i % n).unwrap();
    }
    for i in 1..n * (n - 1) {
        let (a, b, c, d) = (i, i + 1, i + n, i + n + 1);
        writeln!(text, "f {a}/{a}/{a} {b}/{b}/{b} {d}/{d}/{d}\nf {a}/{a}/1 {d}/{d}/1 {c}/{c}/1").unwrap();
    }
    let start = Instant::now();
    let read = decode(text.as_bytes(), "a.obj").unwrap();
    println!(
        "{} triangles, {} bytes: {:?}, {}",
        read.mesh.triangles.len(),
        text.len(),
        start.elapsed(),
        peak()
    );
}

#[test]
#[ignore = "a measurement"]
fn a_million_objects_of_toml() {
    let mut text = String::new();
    for i in 0..1_000_000 {
        writeln!(text, "[[object]]\ntype = \"sphere\"\ncenter = [{i}.5, 1.25, -3.125]\nradius = 0.25\nmaterial = \"m{}\"\n", i % 100_000).unwrap();
    }
    for i in 0..100_000 {
        writeln!(text, "[material.m{i}]\nkd = 0.5").unwrap();
    }
    let (len, start) = (text.len(), Instant::now());
    let value = turner_io::scene::parse(&text, turner::schema::value::FileId(0)).unwrap();
    println!("parsed in {:?}, {}", start.elapsed(), peak());
    drop(value);
    let start = Instant::now();
    let loaded = load_text(text, "a.toml", &MemoryAssets::default(), &LoadOptions::default()).unwrap();
    println!("{} objects, {len} bytes: {:?}, {}", loaded.desc.objects.len(), start.elapsed(), peak());
}
