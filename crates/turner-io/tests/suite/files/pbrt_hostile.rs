//! Damaged pbrt files: the importer returns a scene or an error, quickly, and reads nothing outside its folder.

use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use turner_io::assets::MemoryAssets;
use turner_io::import::{ImportOptions, import};

use super::hostile::{Random, Watched, memory};

/// Imports a scene; returns whether that succeeded.
fn try_import(bytes: Vec<u8>) -> bool {
    let shown = String::from_utf8_lossy(&bytes[..bytes.len().min(200)]).into_owned();
    let mut inner = MemoryAssets::default();
    inner.files.insert("part.pbrt".into(), b"Shape \"disk\"".to_vec());
    inner.files.insert("a.pbrt".into(), bytes.clone());
    let assets = Watched { inner, asked: Mutex::new(Vec::new()) };
    let start = Instant::now();
    let result = import(bytes, "a.pbrt", &assets, &ImportOptions::default());
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

fn sample() -> Vec<u8> {
    std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/assets/pbrt/every-directive.pbrt"))
        .unwrap()
}

#[test]
fn truncated_files() {
    let whole = sample();
    assert!(try_import(whole.clone()));
    for end in (0..whole.len()).step_by(7) {
        try_import(whole[..end].to_vec());
    }
}

#[test]
fn flipped_and_moved_bytes() {
    let whole = sample();
    let mut random = Random(11);
    let words: Vec<&[u8]> = vec![
        b"1e999",
        b"-1",
        b"nan",
        b"2147483647",
        b"-2147483648",
        b"99999999999999999999",
        b"1e-320",
        b"[",
        b"]",
        b"\"",
        b"#",
        b"\n",
        b"\0",
        b"\xff\xfe",
        b"Include \"a.pbrt\"",
        b"AttributeBegin",
        b"ObjectBegin \"o\"",
        b"Scale 0 0 0",
        b"1e308",
        b"\"integer levels\" 30",
    ];
    for _ in 0..1500 {
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
                    // In place of a word, or inside one.
                    let end = bytes[at..].iter().position(|b| b.is_ascii_whitespace()).map_or(at, |n| at + n);
                    bytes.splice(at..end, word.iter().copied());
                }
            }
            if bytes.is_empty() {
                break;
            }
        }
        try_import(bytes);
    }
}

#[test]
fn what_would_take_all_memory_or_time() {
    let world = |text: String| try_import(format!("WorldBegin\n{text}").into_bytes());
    // Deep nesting, closed and unclosed.
    assert!(!world("AttributeBegin ".repeat(1_000_000)));
    assert!(world("AttributeBegin AttributeEnd ".repeat(100_000)));
    // Subdivision surfaces and swept curves that a few bytes request.
    let cube = "\"point3 P\" [0 0 0 1 0 0 0 1 0 0 0 1] \"integer indices\" [0 1 2 0 1 3 0 2 3 1 2 3]";
    assert!(!world(format!("Shape \"loopsubdiv\" \"integer levels\" 2000000000 {cube}")));
    assert!(world(format!("Shape \"loopsubdiv\" \"integer levels\" -5 {cube}")));
    assert!(world("Shape \"sphere\" \"float zmin\" 0\n".repeat(20_000)));
    let parts: String =
        (0..20_000).map(|i| format!("Shape \"sphere\" \"float zmin\" {}\n", f64::from(i) * 1e-5)).collect();
    assert!(!world(parts));
    // Grids larger than their lists, and lists of the wrong length or type.
    assert!(world("MakeNamedMedium \"m\" \"string type\" \"uniformgrid\" \"integer nx\" 2000000000 \"integer ny\" 2000000000 \"float density\" [1]".into()));
    for bad in ["[0 1 -1]", "[0 1 3]", "[0 1]", "[2147483647 0 1]", "[0.5 1 2]", "[1e10 0 1]"] {
        assert!(
            !world(format!(
                "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" {bad}"
            )),
            "{bad}"
        );
    }
    assert!(!world("Shape \"trianglemesh\" \"point3 P\" [0 0]".into()));
    // Unterminated strings and words.
    assert!(!world(format!("Shape \"{}", "a".repeat(10_000_000))));
    assert!(!world("a".repeat(10_000_000)));
    assert!(world(format!("# {}", "a".repeat(10_000_000))));
    // Mixes of mixes.
    let mut mixes = String::from("MakeNamedMaterial \"m0\" \"string type\" \"diffuse\"\n");
    for i in 1..5000 {
        let last = i - 1;
        mixes += &format!(
            "MakeNamedMaterial \"m{i}\" \"string type\" \"mix\" \"string materials\" [\"m{last}\" \"m{last}\"]\n"
        );
    }
    assert!(world(mixes + "NamedMaterial \"m4999\" Shape \"disk\""));
    // A file that includes itself, also under other names.
    for name in ["a.pbrt", "./a.pbrt", "b/../a.pbrt", "%61.pbrt"] {
        assert!(!world(format!("Include \"{name}\"")), "{name}");
    }
    // Numbers of all magnitudes.
    for v in ["0", "-1", "1e-300", "1e300", "-1e300", "1e38", "1e-45"] {
        world(format!(
            "Translate {v} {v} {v} Scale {v} 1 1 Rotate {v} {v} 0 0 LightSource \"point\" \"float scale\" {v} LightSource \"spot\" \"float coneangle\" {v} \
             LightSource \"infinite\" \"float scale\" {v} \"float illuminance\" {v} AreaLightSource \"diffuse\" \"float power\" {v} \"blackbody L\" {v} \
             Material \"dielectric\" \"float eta\" {v} \"float roughness\" {v} Shape \"sphere\" \"float radius\" {v} Shape \"disk\" \"float height\" {v} \
             Shape \"cylinder\" \"float zmin\" {v} Shape \"sphere\" \"float phimax\" {v}"
        ));
    }
}
