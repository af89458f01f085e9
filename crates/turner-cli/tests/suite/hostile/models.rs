//! Inconsistent models: glTF, USD, OBJ, PLY, STL.

use super::run::{Case, Expected};
use turner_io::testing::seeds::{glb_of, seeds};

fn gltf(name: &str, members: String) -> Case {
    Case::one(format!("glTF: {name}"), "a.gltf", format!("{{\"asset\":{{\"version\":\"2.0\"}},{members}}}"))
}

/// The seed document with a part of its text replaced.
fn changed(name: &str, from: &str, to: &str) -> Case {
    let seed = seeds().into_iter().find(|s| s.name == "model.gltf").unwrap().bytes;
    let text = String::from_utf8(seed).unwrap();
    assert!(text.contains(from), "{from}");
    Case::one(format!("glTF: {name}"), "a.gltf", text.replacen(from, to, 1))
}

pub(super) fn cases() -> Vec<Case> {
    use Expected::{Error, Picture};
    let triangle = |nodes: String, roots: &str| {
        format!(
            r#""scene":0,"scenes":[{{"nodes":[{roots}]}}],"nodes":[{nodes}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}],"bufferViews":[{{"buffer":0,"byteLength":36}}],
"buffers":[{{"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA","byteLength":36}}]"#
        )
    };
    let deep: String = (0..100_000).map(|i| format!("{{\"children\":[{}]}},", i + 1)).collect();
    let twice: String = (0..40).map(|i| format!("{{\"children\":[{0},{0}]}},", i + 1)).collect();
    let shared: String =
        (0..80).map(|i| format!("{{\"children\":[{},{}]}},", i / 2 * 2 + 2, i / 2 * 2 + 3)).collect();
    let nested =
        |open: &str, close: &str| format!("\"extras\":{}0{}", open.repeat(200_000), close.repeat(200_000));
    let mut all = vec![
        gltf("a chain of nodes", triangle(format!("{deep}{{\"mesh\":0}}"), "0")).must(Picture),
        gltf("a node in itself", triangle("{\"mesh\":0,\"children\":[0]}".into(), "0")).must(Error),
        gltf("a circle", triangle("{\"children\":[1]},{\"children\":[2]},{\"children\":[0],\"mesh\":0}".into(), "0"))
            .must(Error),
        gltf("nodes that double", triangle(format!("{twice}{{\"mesh\":0}}"), "0")).must(Error),
        gltf("a lattice of nodes", triangle(format!("{shared}{{\"mesh\":0}},{{\"mesh\":0}}"), "0")).must(Error),
        gltf("a million empty nodes", format!("\"nodes\":[{}{{}}]", "{},".repeat(1_000_000))),
        gltf("a million empty accessors", format!("\"accessors\":[{}{{}}]", "{},".repeat(1_000_000))),
        gltf("a million commas", format!("\"nodes\":[{}]", ",".repeat(1_000_000))).must(Error),
        gltf("deep lists", nested("[", "]")),
        gltf("deep objects", nested("{\"a\":", "}")),
        gltf("open lists", nested("[", "")).must(Error),
        gltf("the same member again", "\"nodes\":[],".repeat(100_000) + "\"nodes\":[]"),
        gltf("an unknown extension that is needed", "\"extensionsRequired\":[\"EXT_\\u001b[31m\"]".into()).must(Error),
        gltf("a buffer of 2^53 bytes", "\"buffers\":[{\"byteLength\":9007199254740992,\"uri\":\"data:;base64,AAAA\"}]".into())
            .must(Error),
        gltf("a view beyond its buffer", "\"buffers\":[{\"byteLength\":3,\"uri\":\"data:;base64,AAAA\"}],\"bufferViews\":[{\"buffer\":0,\"byteOffset\":18446744073709551615,\"byteLength\":2}]".into())
            .must(Error),
        changed("accessors beyond their view", "\"count\":3,\"type\":\"VEC3\"", "\"count\":4000000000,\"type\":\"VEC3\"").must(Error),
        changed("indices as numbers with a fraction", "5123", "5126").must(Error),
        changed("an unknown type of component", "5123", "5124").must(Error),
        changed("a camera that sees nothing", "\"yfov\":0.7", "\"yfov\":0"),
        changed("a camera that sees all", "\"yfov\":0.7", "\"yfov\":3.15"),
        changed("a matrix of zeros", "[1,0,0,0,0,1,0,0,0,0,1,0,0,0,4,1]", "[0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0]"),
        changed("a rotation of nothing", "[0,0,0,1]", "[0,0,0,0]"),
        changed("a huge translation", "[0,1,0]", "[1e300,1e300,1e300]"),
        changed("colours of any size", "[0.8,0.2,0.1,1]", "[1e39,-1e39,0,1e300]"),
        changed("an index of refraction of 0", "\"ior\":1.4", "\"ior\":0"),
        changed("an index of refraction of -1e30", "\"ior\":1.4", "\"ior\":-1e30"),
        Case::one("GLB: a length of 0", "a.glb", [&b"glTF"[..], &2u32.to_le_bytes(), &0u32.to_le_bytes()].concat()).must(Error),
        Case::one("GLB: 12 bytes that say 4 GB", "a.glb", [&b"glTF"[..], &2u32.to_le_bytes(), &u32::MAX.to_le_bytes()].concat())
            .must(Error),
        Case::one("GLB: a chunk of 4 GB", "a.glb", [&b"glTF"[..], &2u32.to_le_bytes(), &28u32.to_le_bytes(), &u32::MAX.to_le_bytes(), b"JSON{}  "].concat())
            .must(Error),
        Case::one("GLB: version 1", "a.glb", [&b"glTF"[..], &1u32.to_le_bytes(), &12u32.to_le_bytes()].concat()).must(Error),
        Case::one("GLB: JSON alone", "a.glb", glb_of("{\"asset\":{\"version\":\"2.0\"}}", &[])),
    ];
    all.extend(stages());
    all.extend(meshes());
    all
}

fn stages() -> Vec<Case> {
    use Expected::{Error, Picture};
    let usd =
        |name: &str, text: String| Case::one(format!("USD: {name}"), "a.usda", format!("#usda 1.0\n{text}"));
    let nested = |open: &str, close: &str| open.repeat(200_000) + &close.repeat(200_000);
    let pairs: String = (0..46)
        .map(|i| {
            let next = i + 1;
            format!("def \"A{i}\" {{ def \"L\" (references = </A{next}>) {{}}\n def \"R\" (references = </A{next}>) {{}} }}\n")
        })
        .collect();
    let binary = seeds().into_iter().find(|s| s.name == "model.usdc").unwrap().bytes;
    let mut large = binary.clone();
    let toc = u64::from_le_bytes(*large[16..].first_chunk().unwrap()) as usize;
    large[toc..toc + 8].copy_from_slice(&(1_u64 << 60).to_le_bytes());
    vec![
        usd("prims in prims", nested("def \"a\" {", "}")).must(Error),
        usd(
            "dictionaries in dictionaries",
            format!("def \"a\" (customData = {}) {{}}", nested("{ dictionary d = ", "}")),
        )
        .must(Error),
        usd("brackets", format!("(x = {})", nested("[", "]"))).must(Error),
        usd("references that double", pairs + "def \"A46\" { def Sphere \"S\" {} }").must(Error),
        usd("a reference to itself", "def Sphere \"A\" (references = </A>) {}".into()).must(Picture),
        usd("a million prims", "def Sphere \"A\" {}\n".repeat(1_000_000)),
        usd("an open string", format!("def \"A\" {{ string x = \"\"\"{} }}", "\"\" ".repeat(1_000_000)))
            .must(Error),
        Case::one("USD: 2^60 sections", "a.usdc", large).must(Error),
        Case::one("USD: half a file", "a.usdc", binary[..binary.len() / 2].to_vec()).must(Error),
        Case::one("USD: an empty package", "a.usdz", [&b"PK\x05\x06"[..], &[0; 18]].concat()).must(Error),
    ]
}

#[expect(clippy::too_many_lines, reason = "a table")]
fn meshes() -> Vec<Case> {
    use Expected::{Error, Picture};
    let one = |name: &str, file: &str, text: String| Case::one(name, file, text);
    let ply = |elements: &str, data: &str| format!("ply\nformat ascii 1.0\n{elements}end_header\n{data}");
    let xyz = "property float x\nproperty float y\nproperty float z\n";
    let binary = |elements: String, data: &[u8]| {
        [format!("ply\nformat binary_little_endian 1.0\n{elements}end_header\n").as_bytes(), data].concat()
    };
    let points: String = (0..200_000).map(|i| format!("v {i} 0 1\n")).collect();
    let corners: String = (1..=200_000).map(|i| format!(" {i}")).collect();
    vec![
        one("OBJ: empty", "a.obj", String::new()).must(Error),
        one(
            "OBJ: indices that lie",
            "a.obj",
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9999999999999999999\n".into(),
        )
        .must(Error),
        one("OBJ: an index of 0", "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n".into()).must(Error),
        one("OBJ: far below", "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -9223372036854775808\n".into())
            .must(Error),
        one("OBJ: one polygon of all", "a.obj", format!("{points}f{corners}\n")),
        one(
            "OBJ: numbers of any size",
            "a.obj",
            "v 1e39 0 0\nv nan 0 0\nv inf 1 1\nv 0 0 0\nf 1 2 3\nf 2 3 4\n".into(),
        ),
        one("OBJ: a very long line", "a.obj", format!("v 0 0 0\n# {}\n", "x".repeat(5_000_000))).must(Error),
        one("OBJ: a very long line", "a.obj", format!("v 0 0 0\nf {}\n", "1 \\\n".repeat(500_000))),
        one("OBJ: NUL bytes", "a.obj", format!("v 0 0 0\n{}\nf 1 1 1\n", "\0".repeat(100_000))),
        one(
            "OBJ: names of materials",
            "a.obj",
            (0..70_000).map(|i| format!("usemtl m{i}\nv 0 0 {i}\nf -1 -1 -1\n")).collect(),
        ),
        one(
            "PLY: 10^18 vertices",
            "a.ply",
            ply(&format!("element vertex 1000000000000000000\n{xyz}"), "0 0 0\n"),
        )
        .must(Error),
        one(
            "PLY: 10^30 vertices",
            "a.ply",
            ply(&format!("element vertex 1000000000000000000000000000000\n{xyz}"), ""),
        )
        .must(Error),
        one("PLY: elements of nothing", "a.ply", ply("element air 4000000000\nelement vertex 0\n", ""))
            .must(Error),
        one("PLY: vertices of nothing", "a.ply", ply("element vertex 4000000000\n", "")).must(Error),
        one(
            "PLY: a list of -1",
            "a.ply",
            ply(
                &format!("element vertex 3\n{xyz}element face 1\nproperty list int int vertex_indices\n"),
                "0 0 0\n1 0 0\n0 1 0\n-1 0 1 2\n",
            ),
        )
        .must(Error),
        one(
            "PLY: a list of half",
            "a.ply",
            ply(
                &format!("element vertex 3\n{xyz}element face 1\nproperty list float int vertex_indices\n"),
                "0 0 0\n1 0 0\n0 1 0\n2.5 0 1 2\n",
            ),
        )
        .must(Error),
        one(
            "PLY: a heading without an end",
            "a.ply",
            "ply\nformat ascii 1.0\n".to_owned() + &"comment x\n".repeat(500_000),
        )
        .must(Error),
        one(
            "PLY: a name that drives a terminal",
            "a.ply",
            ply("element \u{1b}[31m 1\nproperty float x\n", "1\n"),
        )
        .must(Error),
        Case::one(
            "PLY: a list of 2^31",
            "a.ply",
            binary(
                format!("element vertex 1\n{xyz}element face 1\nproperty list int int vertex_indices\n"),
                &[&[0; 12][..], &[0xff, 0xff, 0xff, 0x7f], &[0; 8]].concat(),
            ),
        )
        .must(Error),
        Case::one("PLY: points", "a.ply", binary(format!("element vertex 2\n{xyz}"), &[0; 24])).must(Picture),
        Case::one(
            "STL: 2^32 triangles",
            "a.stl",
            [&[b' '; 80][..], &u32::MAX.to_le_bytes(), &[0; 50]].concat(),
        )
        .must(Error),
        Case::one(
            "STL: numbers that are none",
            "a.stl",
            [&[b' '; 80][..], &1u32.to_le_bytes(), &[0xff; 50]].concat(),
        )
        .must(Error),
        Case::one(
            "STL: binary that begins like text",
            "a.stl",
            [&b"solid"[..], &[b' '; 75], &0u32.to_le_bytes()].concat(),
        )
        .must(Error),
        one(
            "STL: without an end",
            "a.stl",
            "solid a\n".to_owned() + &"facet normal 0 0 1\nouter loop\n".repeat(100_000),
        )
        .must(Error),
    ]
}
