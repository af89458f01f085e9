//! Damaged and malicious meshes: bounded time and memory, and no panic.

use std::path::Path;
use std::time::{Duration, Instant};

use turner_io::assets::MemoryAssets;
use turner_io::import::{ImportOptions, import};

/// Most bytes of memory of a mesh per byte of its file.
const MOST_PER_BYTE: usize = 64;

fn file(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/assets/mesh");
    std::fs::read(folder.join(name)).unwrap()
}

fn try_import(name: &str, bytes: &[u8], library: &[u8]) -> bool {
    let mut assets = MemoryAssets::default();
    for name in ["cube.mtl", "texture-options-issue-85.mtl", "cornell_box.mtl"] {
        assets.files.insert(name.into(), library.to_vec());
    }
    let options = ImportOptions { threads: 2, ..Default::default() };
    match import(bytes.to_vec(), name, &assets, &options) {
        Ok(scene) => {
            let data = &scene.meshes[0].data;
            data.check().unwrap();
            assert!(data.positions.as_flattened().iter().all(|v| v.is_finite()), "{name}");
            let most = MOST_PER_BYTE * bytes.len() + (1 << 16);
            assert!(data.memory() < most, "{name}: {} for {}", data.memory(), bytes.len());
            assert!(scene.warnings.len() < 100, "{name}: {} warnings", scene.warnings.len());
            assert!(
                scene.warnings.iter().all(|w| w.message.chars().count() < 400),
                "{name}: {:?}",
                scene.warnings
            );
            true
        }
        Err(error) => {
            assert!(error.message.chars().count() < 400, "{error}");
            assert!(!error.message.contains(|c: char| c.is_control()), "{error:?}");
            false
        }
    }
}

struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % n.max(1)
    }
}

/// Flips bits, replaces bytes by significant ones, and removes, duplicates or moves parts.
fn mutate(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    const WORDS: [&[u8]; 22] = [
        b"4294967295",
        b"-1",
        b"99999999999999999999",
        b"nan",
        b"1e400",
        b"\\\n",
        b"\n",
        b"\0\0\0\x80",
        b"\xff\xff\xff\xff",
        b"/",
        b"//",
        b" ",
        b"f ",
        b"v ",
        b"usemtl x\n",
        b"s 1\n",
        b"-0",
        b"1.#IND",
        b"end_header\n",
        b"list",
        b"solid ",
        b"\xc0\x80",
    ];
    let mut out = bytes.to_vec();
    for _ in 0..1 + random.below(4) {
        let at = random.below(out.len());
        match random.below(6) {
            0 | 1 => {
                if let Some(byte) = out.get_mut(at) {
                    *byte ^= 1 << random.below(8);
                }
            }
            2 => {
                let word = WORDS[random.below(WORDS.len())];
                let end = (at + random.below(word.len() + 1)).min(out.len());
                out.splice(at..end, word.iter().copied());
            }
            3 => out.truncate(at),
            4 => {
                let end = (at + random.below(40)).min(out.len());
                out.drain(at..end);
            }
            _ => {
                let end = (at + random.below(60)).min(out.len());
                let part = out[at..end].to_vec();
                let to = random.below(out.len() + 1);
                out.splice(to..to, part);
            }
        }
    }
    out
}

/// PLY files in big-endian order, or with doubles and other list types.
fn binary_plys() -> Vec<Vec<u8>> {
    let mut out = Vec::new();
    for (format, big) in [("binary_little_endian", false), ("binary_big_endian", true)] {
        let mut bytes = format!(
            "ply\nformat {format} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n\
             property uchar green\nproperty uchar blue\nelement face 2\nproperty list uchar int vertex_indices\nelement tristrips 1\n\
             property list int int vertex_indices\nend_header\n"
        )
        .into_bytes();
        let mut body: Vec<u8> = Vec::new();
        let put =
            |body: &mut Vec<u8>, v: u32| body.extend(if big { v.to_be_bytes() } else { v.to_le_bytes() });
        for i in 0..4_u8 {
            put(&mut body, f32::from(i % 2).to_bits());
            put(&mut body, f32::from(i / 2).to_bits());
            put(&mut body, 0);
            body.extend([i, 200, 9]);
        }
        for face in [&[0, 1, 2][..], &[1, 3, 2, 0]] {
            body.push(face.len() as u8);
            face.iter().for_each(|&i| put(&mut body, i));
        }
        [5_u32, 0, 1, 2, u32::MAX, 3].iter().for_each(|&v| put(&mut body, v));
        bytes.extend(body);
        out.push(bytes);
    }
    out
}

#[test]
fn mutations_of_every_format() {
    let start = Instant::now();
    let library = [file("texture-options-issue-85.mtl"), file("cube.mtl")].concat();
    let mut bases: Vec<(&str, Vec<u8>)> = Vec::new();
    for name in [
        "cube.obj",
        "cube-vertexcol.obj",
        "texture-options-issue-85.obj",
        "negative_indices.obj",
        "smoothing-normal.obj",
        "polygonfaces.obj",
    ] {
        bases.push((name, file(name)));
    }
    for name in ["multi.ply", "plane_tri.ply", "points_ascii.ply"] {
        bases.push((name, file(name)));
    }
    bases.extend(binary_plys().into_iter().map(|b| ("binary.ply", b)));
    bases.push(("multibody.stl", file("multibody.stl")[..2200].to_vec()));
    let cube = file("20mm-xyz-cube.stl");
    let mut small = cube[..84 + 50 * 20].to_vec();
    small[80..84].copy_from_slice(&20_u32.to_le_bytes());
    bases.push(("20mm-xyz-cube.stl", small));
    let mut random = Random(1);
    let (mut tried, mut read) = (0, 0);
    for (name, bytes) in &bases {
        for i in 0..500 {
            let damaged = mutate(bytes, &mut random);
            let library = if i % 3 == 0 { mutate(&library, &mut random) } else { Vec::new() };
            tried += 1;
            read += u32::from(try_import(name, &damaged, &library));
        }
    }
    // Some results are valid meshes, most are not.
    assert!(read > 400 && read < tried, "{read} of {tried}");
    assert!(start.elapsed() < Duration::from_secs(60), "{:?}", start.elapsed());
}

#[test]
fn every_truncation() {
    let library = file("cube.mtl");
    let mut bases = vec![("cube.obj", file("cube.obj")), ("multi.ply", file("multi.ply"))];
    bases.extend(binary_plys().into_iter().map(|b| ("binary.ply", b)));
    bases.push(("a.stl", file("20mm-xyz-cube.stl")[..300].to_vec()));
    for (name, bytes) in bases {
        for len in 0..bytes.len() {
            try_import(name, &bytes[..len], &library[..len.min(library.len())]);
        }
    }
}

#[test]
fn lying_counts_and_bombs() {
    let start = Instant::now();
    let mut stl = vec![b' '; 84];
    stl[80..].copy_from_slice(&u32::MAX.to_le_bytes());
    stl.extend([0; 500]);
    assert!(!try_import("a.stl", &stl, b""));
    for line in [
        "element vertex 4000000000",
        "element face 4294967294",
        "element tristrips 3000000000",
        "element other 4294967294",
    ] {
        for format in ["ascii", "binary_little_endian"] {
            let text = format!(
                "ply\nformat {format} 1.0\n{line}\nproperty list uchar int vertex_indices\nproperty float x\nproperty float y\nproperty float z\n\
                 property float q\nend_header\n"
            );
            assert!(!try_import("a.ply", text.as_bytes(), b""), "{line}");
        }
    }
    let many = |count: usize, text: &str| text.repeat(count).into_bytes();
    let head = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n".to_vec();
    let after_head = |tail: Vec<u8>| [head.clone(), tail].concat();
    // Endlessly continued lines, alone and inside a face.
    try_import("a.obj", &many(1_000_000, "\\\n"), b"");
    try_import("a.obj", &after_head([b"f 1 2 3".to_vec(), many(500_000, "\\\r\n")].concat()), b"");
    try_import("a.obj", &after_head([b"f".to_vec(), many(400_000, " \\\n 1")].concat()), b"");
    // A zigzag polygon of half a million corners, and many of a few thousand.
    try_import("a.obj", &after_head([b"f".to_vec(), many(125_000, " 1 2 4 3")].concat()), b"");
    let spikes: String = (0..3000)
        .map(|i| format!("v {} {} 0\n", i % 1500, if i % 2 == 0 { i % 7 } else { 20 + i % 11 }))
        .collect();
    let polygon: String = "f".to_owned() + &(1..=3000).map(|i| format!(" {i}")).collect::<String>() + "\n";
    try_import("a.obj", &[spikes.into_bytes(), polygon.repeat(20).into_bytes()].concat(), b"");
    // Unterminated names, groups and libraries.
    let names: String =
        (0..60_000).map(|i| format!("usemtl m{i}\nf 1 2 3\no o{i}\ng g{i}\ns {i}\n")).collect();
    try_import("a.obj", &after_head(names.into_bytes()), b"");
    let too_many: String = (0..70_000).map(|i| format!("usemtl m{i}\nf 1 2 3\n")).collect();
    assert!(!try_import("a.obj", &after_head(too_many.into_bytes()), b""));
    try_import(
        "a.obj",
        &after_head([many(200_000, "usemtl a\ns 1\ng b\n"), b"f 1 2 3\n".to_vec()].concat()),
        b"",
    );
    let same: String = "mtllib cube.mtl".to_owned() + &" x.mtl".repeat(20_000) + "\nf 1 2 3\n";
    assert!(try_import(
        "a.obj",
        &after_head(same.into_bytes()),
        &many(50_000, "newmtl a\nmap_Kd a.png\nKd 1 1 1\nhuh 1\n")
    ));
    // All corners at one position, each with its own index.
    let variants: String = (1..=60_000).map(|i| format!("vt {i} 0\nf 1/{i} 1/{i} 2/{i}\n")).collect();
    assert!(try_import("a.obj", &after_head(variants.into_bytes()), b""));
    let solids: String = (0..60_000).map(|i| format!("solid {i}\n")).collect();
    assert!(!try_import("a.stl", solids.as_bytes(), b""));
    try_import(
        "a.stl",
        &[
            b"solid\nouter loop\n".to_vec(),
            many(300_000, "vertex 0 0 0\nvertex 1 2 3\n"),
            b"endloop\n".to_vec(),
        ]
        .concat(),
        b"",
    );
    assert!(start.elapsed() < Duration::from_secs(60), "{:?}", start.elapsed());
}
