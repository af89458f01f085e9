//! Damaged Mitsuba scenes: the importer returns a scene or an error, quickly, and reads nothing outside its folder.

use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use turner_io::assets::MemoryAssets;
use turner_io::import::{ImportOptions, import};

use super::hostile::{Random, Watched, memory};

fn folder() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/assets/mitsuba")
}

fn sample() -> Vec<u8> {
    std::fs::read(folder().join("every-plugin.xml")).unwrap()
}

/// The files that the sample refers to.
fn files() -> Vec<(String, Vec<u8>)> {
    let mut out: Vec<_> = ["picture.png", "around.exr", "tent.obj", "tent.ply", "part.xml"]
        .iter()
        .map(|name| ((*name).to_owned(), std::fs::read(folder().join(name)).unwrap()))
        .collect();
    let mut grid = b"VOL\x03".to_vec();
    [1i32, 2, 2, 2, 1].iter().for_each(|v| grid.extend(v.to_le_bytes()));
    [0.0f32, 0.0, 0.0, 1.0, 1.0, 1.0].iter().for_each(|v| grid.extend(v.to_le_bytes()));
    (0..8).for_each(|v| grid.extend((v as f32).to_le_bytes()));
    out.push(("smoke.vol".into(), grid));
    out.push(("curves.txt".into(), b"0 0 0 .1\n1 0 0 .1\n2 1 0 .1\n3 1 0 .2\n".to_vec()));
    out
}

/// Imports a scene; returns whether that succeeded.
fn try_import(bytes: Vec<u8>, files: &[(String, Vec<u8>)]) -> bool {
    let shown = String::from_utf8_lossy(&bytes[..bytes.len().min(200)]).into_owned();
    let mut inner = MemoryAssets::default();
    inner.files.extend(files.iter().cloned());
    inner.files.insert("a.xml".into(), bytes.clone());
    let assets = Watched { inner, asked: Mutex::new(Vec::new()) };
    let start = Instant::now();
    let result = import(bytes, "a.xml", &assets, &ImportOptions::default());
    assert!(start.elapsed() < Duration::from_secs(10), "{shown}");
    for name in assets.asked.into_inner().unwrap() {
        assert!(!name.split(['/', '\\']).any(|part| part == ".."), "asked for {name}");
    }
    match result {
        Ok(scene) => {
            assert!(memory(&scene) < 1 << 30, "{shown}");
            scene.meshes.iter().for_each(|m| m.data.check().unwrap());
            true
        }
        Err(error) => {
            assert!(error.message.contains(": "), "{}", error.message);
            assert!(!error.message.contains(|c: char| c.is_control()), "{:?}", error.message);
            false
        }
    }
}

#[test]
fn truncated_scenes() {
    let (whole, files) = (sample(), files());
    assert!(try_import(whole.clone(), &files));
    for end in (0..whole.len()).step_by(23) {
        try_import(whole[..end].to_vec(), &files);
    }
}

#[test]
fn flipped_and_moved_bytes_of_scenes() {
    let (whole, files) = (sample(), files());
    let mut random = Random(12);
    let words: Vec<&[u8]> = vec![
        b"1e999",
        b"-1",
        b"nan",
        b"99999999999999999999",
        b"1e-320",
        b"<",
        b"/>",
        b"\"",
        b"&#0;",
        b"\0",
        b"\xff\xfe",
        b"<include filename=\"a.xml\"/>",
        b"<include filename=\"../a.xml\"/>",
        b"$x",
        b"<scene>",
        b"0 0 0",
        b"1e308",
        b"<ref id=\"glass\"/>",
        b"<!DOCTYPE a>",
        b"type=\"mask\"",
        b"type=\"instance\"",
    ];
    for _ in 0..700 {
        let mut bytes = whole.clone();
        for _ in 0..1 + random.below(4) {
            let at = random.below(bytes.len());
            match random.below(5) {
                0 => bytes[at] ^= 1 << random.below(8),
                1 => bytes[at] = random.next() as u8,
                2 => {
                    let end = (at + random.below(80)).min(bytes.len());
                    bytes.drain(at..end);
                }
                3 => {
                    let from = random.below(bytes.len());
                    let part = bytes[from..(from + random.below(300)).min(bytes.len())].to_vec();
                    bytes.splice(at..at, part);
                }
                _ => {
                    let word = words[random.below(words.len())];
                    let end = bytes[at..].iter().position(|b| *b == b'"').map_or(at, |n| at + n);
                    bytes.splice(at..end, word.iter().copied());
                }
            }
            if bytes.is_empty() {
                break;
            }
        }
        try_import(bytes, &files);
    }
}

#[test]
fn damaged_files_that_scenes_name() {
    let (whole, files) = (sample(), files());
    let mut random = Random(13);
    for _ in 0..150 {
        let mut files = files.clone();
        let which = random.below(files.len());
        let bytes = &mut files[which].1;
        for _ in 0..1 + random.below(3) {
            let at = random.below(bytes.len());
            match random.below(3) {
                0 => bytes[at] ^= 1 << random.below(8),
                1 => bytes[at] = 0xff,
                _ => bytes.truncate(at.max(1)),
            }
        }
        try_import(whole.clone(), &files);
    }
}

#[test]
fn what_would_take_all_memory_or_time_in_scenes() {
    let scene = |inner: &str| format!("<scene version=\"3.0.0\">{inner}</scene>").into_bytes();
    let refused = |inner: &str| assert!(!try_import(scene(inner), &[]), "{}", &inner[..inner.len().min(200)]);
    // Entities, exponentially growing names, files that include themselves, too deep nesting.
    assert!(!try_import(b"<!DOCTYPE s [<!ENTITY a \"b\">]><scene version=\"3.0.0\"/>".to_vec(), &[]));
    let mut doubling = String::from("<default name=\"a0\" value=\"xxxxxxxxxxxxxxxx\"/>");
    for i in 0..40 {
        doubling += &format!("<default name=\"a{}\" value=\"$a{i}$a{i}\"/>", i + 1);
    }
    refused(&doubling);
    refused("<include filename=\"a.xml\"/>");
    refused("<include filename=\"../other.xml\"/>");
    refused(&"<bsdf type=\"twosided\">".repeat(5000));
    refused(
        "<bsdf type=\"twosided\" id=\"a\"><ref id=\"a\"/></bsdf><shape type=\"sphere\"><ref id=\"a\"/></shape>",
    );
    refused(
        "<texture type=\"checkerboard\" id=\"t\"><ref name=\"color0\" id=\"t\"/></texture><shape type=\"sphere\"><bsdf type=\"diffuse\"><ref name=\"reflectance\" id=\"t\"/></bsdf></shape>",
    );
    refused(
        "<shape type=\"shapegroup\" id=\"g\"><shape type=\"instance\"><ref id=\"g\"/></shape></shape><shape type=\"instance\"><ref id=\"g\"/></shape>",
    );
    // Blends of blends: 2^40 materials.
    let mut blends = String::from("<bsdf type=\"diffuse\" id=\"b0\"/>");
    for i in 0..40 {
        blends += &format!(
            "<bsdf type=\"blendbsdf\" id=\"b{}\"><ref id=\"b{i}\"/><ref id=\"b{i}\"/></bsdf>",
            i + 1
        );
    }
    try_import(scene(&(blends + "<shape type=\"sphere\"><ref id=\"b40\"/></shape>")), &[]);
    try_import(scene(&"<shape type=\"sphere\"/>".repeat(100_000)), &[]);
    try_import(scene(&format!("<spectrum name=\"a\" value=\"{}\"/>", "1,".repeat(1_000_000))), &[]);
}
