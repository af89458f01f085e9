//! Damaged glTF files: the importer returns a scene or an error, takes memory in proportion to the file, and reads
//! nothing outside its folder.

use std::path::Path;
use std::sync::Mutex;

use turner::description::SceneDesc;
use turner_io::assets::{AssetError, AssetSource, MemoryAssets};
use turner_io::gltf::import;
use turner_io::import::ImportOptions;
use turner_io::testing::seeds::seeds;

/// A small deterministic random number generator.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }
}

/// Files that a model may read, with a record of the names requested.
#[derive(Default)]
struct Watched {
    inner: MemoryAssets,
    asked: Mutex<Vec<String>>,
}

impl AssetSource for Watched {
    fn read(&self, uri: &str, limit: u64) -> Result<Vec<u8>, AssetError> {
        self.asked.lock().unwrap().push(uri.to_owned());
        self.inner.read(uri, limit)
    }
    fn describe(&self, uri: &str) -> String {
        uri.to_owned()
    }
}

fn file(name: &str) -> Vec<u8> {
    std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/assets/gltf").join(name)).unwrap()
}

/// Bytes of memory of a scene.
fn memory(scene: &SceneDesc) -> usize {
    let meshes: usize = scene.meshes.iter().map(|m| m.data.memory()).sum();
    let images: usize = scene.images.iter().map(|i| i.data.memory()).sum();
    meshes + images + size_of_val(&scene.objects[..])
}

/// Imports a file; returns whether that gave a scene.
fn try_import(bytes: Vec<u8>, options: &ImportOptions) -> bool {
    let size = bytes.len();
    let assets = Watched::default();
    let result = import(bytes, "a.glb", &assets, options);
    for name in assets.asked.into_inner().unwrap() {
        assert!(!name.split(['/', '\\']).any(|part| part == ".."), "asked for {name}");
    }
    match result {
        Ok(scene) => {
            // A deflated image may expand a thousandfold.
            assert!(memory(&scene) <= (1 << 20) + 2000 * size, "{} bytes of {size}", memory(&scene));
            if let Err(e) = scene.prepare(&Default::default()) {
                assert!(!e.message.is_empty());
            }
            true
        }
        Err(error) => {
            assert!(error.message.starts_with("a.glb: "), "{}", error.message);
            assert!(!error.message.contains(|c: char| c.is_control()), "{:?}", error.message);
            false
        }
    }
}

/// The JSON text of a GLB file, and the bytes after it.
fn parts(bytes: &[u8]) -> (String, Vec<u8>) {
    let size = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    (String::from_utf8(bytes[20..20 + size].to_vec()).unwrap(), bytes[20 + size..].to_vec())
}

fn join(json: &str, rest: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = 20 + json.len() + rest.len();
    let mut out = [&b"glTF"[..], &2u32.to_le_bytes(), &(length as u32).to_le_bytes()].concat();
    out.extend_from_slice(&(json.len() as u32).to_le_bytes());
    out.extend_from_slice(b"JSON");
    out.extend_from_slice(&json);
    out.extend_from_slice(rest);
    out
}

const MODELS: [&str; 5] =
    ["Box.glb", "BoxVertexColors.glb", "SimpleInstancing.glb", "UnlitTest.glb", "VertexColorTest.glb"];

#[test]
fn flipped_bits_and_cut_files() {
    let mut random = Random(1);
    let options = ImportOptions::default();
    let draco = seeds().into_iter().find(|seed| seed.name == "draco.glb").unwrap().bytes;
    for whole in MODELS.map(file).into_iter().chain([draco]) {
        for _ in 0..150 {
            let mut bytes = whole.clone();
            for _ in 0..=random.below(4) {
                let at = random.below(bytes.len());
                bytes[at] ^= 1 << random.below(8);
            }
            try_import(bytes, &options);
        }
        for _ in 0..60 {
            try_import(whole[..random.below(whole.len())].to_vec(), &options);
        }
    }
}

/// The numbers of a text, as ranges.
fn numbers(text: &str) -> Vec<(usize, usize)> {
    let bytes = text.as_bytes();
    let (mut found, mut at) = (Vec::new(), 0);
    let mut quoted = false;
    while at < bytes.len() {
        let start = at;
        quoted ^= bytes[at] == b'"';
        while !quoted && at < bytes.len() && (bytes[at].is_ascii_digit() || b"-+.eE".contains(&bytes[at])) {
            at += 1;
        }
        if at > start && bytes[start..at].iter().any(u8::is_ascii_digit) {
            found.push((start, at));
        }
        at = at.max(start + 1);
    }
    found
}

#[test]
fn lying_numbers() {
    let mut random = Random(2);
    let lies = [
        "0",
        "1",
        "2",
        "3",
        "-1",
        "7",
        "255",
        "256",
        "65535",
        "65536",
        "4294967295",
        "4294967296",
        "18446744073709551615",
        "18446744073709551616",
        "1e308",
        "-1e308",
        "1e-320",
        "0.5",
        "1e999",
        "null",
        "\"a\"",
        "[]",
        "{}",
        "true",
        "5120",
        "5121",
        "5123",
        "5125",
        "5126",
        "34963",
        "9007199254740993",
    ];
    let mut read = 0;
    for name in
        ["Box.glb", "SimpleInstancing.glb", "VertexColorTest.glb", "Fox.glb", "TextureSettingsTest.glb"]
    {
        let (json, rest) = parts(&file(name));
        let places = numbers(&json);
        assert!(places.len() > 20, "{name}");
        for _ in 0..250 {
            let (start, end) = places[random.below(places.len())];
            let lie = lies[random.below(lies.len())];
            let text = format!("{}{lie}{}", &json[..start], &json[end..]);
            let options = ImportOptions { time: random.below(5) as f64, ..ImportOptions::default() };
            read += usize::from(try_import(join(&text, &rest), &options));
        }
    }
    // The test must also cover files that are read.
    assert!(read > 200, "{read}");
}

#[test]
fn words_that_change_places() {
    let mut random = Random(3);
    let (json, rest) = parts(&file("VertexColorTest.glb"));
    let words: Vec<&str> = json.split('"').collect();
    for _ in 0..300 {
        let mut words = words.clone();
        let (a, b) = (random.below(words.len()), random.below(words.len()));
        words.swap(a, b);
        try_import(join(&words.join("\""), &rest), &ImportOptions::default());
    }
}

/// A GLB file with these members of the document and no binary chunk.
fn document(members: &str) -> Vec<u8> {
    join(&format!("{{\"asset\":{{\"version\":\"2.0\"}},{members}}}"), b"")
}

#[test]
fn bombs() {
    let options = ImportOptions::default();
    let import = |bytes: Vec<u8>| try_import(bytes, &options);
    // Lists of empty elements: read, but small.
    for member in ["nodes", "meshes", "materials", "accessors", "textures", "images", "samplers", "skins"] {
        import(document(&format!("\"{member}\":[{}{{}}]", "{},".repeat(100_000))));
    }
    // A million primitives of zeros without a buffer view.
    let primitives = r#"{"attributes":{"POSITION":0}},"#.repeat(20_000);
    let shared = format!(
        r#""nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{primitives}{{"attributes":{{"POSITION":0}}}}]}}],
        "accessors":[{{"componentType":5126,"count":65536,"type":"VEC3"}}]"#
    );
    assert!(import(document(&shared)));
    // The same, each slightly different: rejected before memory runs out.
    let attributes: Vec<String> =
        (0..3_000).map(|i| format!(r#"{{"attributes":{{"POSITION":0,"_{i}":0}}}}"#)).collect();
    let different = format!(
        r#""nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{}]}}],
        "accessors":[{{"componentType":5126,"count":65535,"type":"VEC3"}}]"#,
        attributes.join(",")
    );
    assert!(!import(document(&different)));
    // Instances of instances: 3000 nodes with 60 000 each.
    let node = r#"{"mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":0}}}},"#;
    let many = format!(
        r#""nodes":[{}{{}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":1}}}}]}}],
        "buffers":[{{"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA","byteLength":36}}],"bufferViews":[{{"buffer":0,"byteLength":36}}],
        "accessors":[{{"componentType":5126,"count":60000,"type":"VEC3"}},{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}]"#,
        node.repeat(3_000)
    );
    assert!(!import(document(&many)));
    // Deep nesting, closed and unclosed.
    let deep = |open: &str, close: &str| {
        document(&format!("\"extras\":{}0{}", open.repeat(200_000), close.repeat(200_000)))
    };
    import(deep("[", "]"));
    import(deep("{\"a\":", "}"));
    import(deep("[", ""));
    // Compressed data that claims many elements.
    let meshopt = r#""buffers":[{"uri":"data:;base64,4QAAAAAAAAAAAAAAAAAAAAAAAAAAAA==","byteLength":20}],
        "bufferViews":[{"buffer":0,"byteLength":1,"extensions":{"EXT_meshopt_compression":{"buffer":0,"byteLength":20,
        "byteStride":4,"count":3000000000,"mode":"TRIANGLES"}}}]"#;
    assert!(!import(document(meshopt)));
}

#[test]
fn names_lead_nowhere_else() {
    for uri in [
        "../secret.bin",
        "%2e%2e/secret.bin",
        "a/../../secret.bin",
        "/etc/passwd",
        "file:///etc/passwd",
        "\\\\host\\share",
        "C:\\secret.bin",
        "..%2fsecret.bin",
        "%2e%2e%5csecret.bin",
        "\\u0000",
        "",
    ] {
        let uri = uri.replace('\\', "\\\\").replace("\\\\u0000", "\\u0000");
        let bytes = document(&format!(r#""buffers":[{{"uri":"{uri}","byteLength":4}}]"#));
        let mut assets = Watched::default();
        assets.inner.files.insert("secret.bin".to_owned(), vec![0; 4]);
        let error = import(bytes, "models/a.glb", &assets, &ImportOptions::default());
        // The parent folder is allowed if the model lies in a subfolder of the scene's folder, but not
        // further up.
        match error {
            Ok(_) => assert!(uri.contains("secret"), "{uri}"),
            Err(e) => assert!(e.message.starts_with("models/a.glb: /buffers/0: "), "{uri}: {}", e.message),
        }
        let bytes = document(&format!(r#""buffers":[{{"uri":"{uri}","byteLength":4}}]"#));
        assert!(import(bytes, "a.glb", &assets, &ImportOptions::default()).is_err(), "{uri}");
    }
}

/// A buffer at a network address is refused where its data is needed, and named where it is not.
#[test]
fn network_addresses_are_not_followed() {
    let buffer = r#""buffers":[{"uri":"http://example.com/a.bin","byteLength":36}]"#;
    let of =
        |members: String| import(document(&members), "a.glb", &Watched::default(), &ImportOptions::default());
    let unused = of(buffer.to_owned()).unwrap();
    assert!(unused.warnings.iter().any(|w| w.message.starts_with("/buffers/0: ")), "{:?}", unused.warnings);
    let used = of(format!(
        r#"{buffer},"bufferViews":[{{"buffer":0,"byteLength":36}}],"nodes":[{{"mesh":0}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}]"#
    ));
    let message = used.unwrap_err().message;
    assert!(message.contains("/buffers/0: ") && message.contains("network"), "{message}");
}

#[test]
fn names_cannot_drive_the_terminal() {
    let bytes = document("\"extensionsRequired\":[\"\\u001b[31mRED\\u202e\"]");
    let error = import(bytes, "a\u{1b}.glb", &Watched::default(), &ImportOptions::default()).unwrap_err();
    let text = format!("{}{}", error.message, error.help.unwrap_or_default());
    assert!(!text.contains(['\u{1b}', '\u{202e}']) && text.contains("RED"), "{text:?}");
}
