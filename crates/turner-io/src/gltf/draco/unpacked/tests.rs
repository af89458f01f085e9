use turner::description::SceneDesc;
use turner::schema::Warning;

use crate::gltf::testing::{floats, glb, import};

/// A Draco mesh with sequential connectivity: a square of two triangles, with positions (number 7), and as unsigned
/// bytes colours (number 2, normalised) and joints (number 3).
fn square() -> Vec<u8> {
    let mut bytes = b"DRACO\x02\x02\x01\x00\x00\x00".to_vec();
    // Two faces, four points, indices that are not compressed.
    bytes.extend([2, 4, 1, 0, 1, 2, 2, 1, 3]);
    // One group of three attributes: use, type, components, normalised, number; then how each is stored: as it is.
    bytes.extend([1, 3, 0, 9, 3, 0, 7, 2, 2, 4, 1, 2, 4, 2, 4, 0, 3, 0, 0, 0]);
    bytes.extend(floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0]));
    bytes.extend([255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 51, 51, 51, 255]);
    bytes.extend([1, 2, 3, 200, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    bytes
}

const ACCESSORS: &str = r#"{"componentType":5123,"count":6,"type":"SCALAR"},
    {"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},{"componentType":5121,"normalized":true,"count":4,"type":"VEC4"},
    {"bufferView":1,"componentType":5126,"count":4,"type":"VEC2"},
    {"bufferView":2,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[0,0,0]}"#;

/// The accessor of the positions.
const POSITIONS: &str = r#"{"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}"#;

const MAP: &str = r#"{"POSITION":7,"COLOR_0":2}"#;

/// A file with the square. The accessors are: 0 the indices, 1 the positions, 2 the colours, 3 texture coordinates that
/// are not compressed, 4 zeros. `primitive` has further members of the primitive, `map` the Draco attributes.
fn file(primitive: &str, map: &str, accessors: &str) -> Vec<u8> {
    let draco = square();
    let uvs = floats(&[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
    let padded = draco.len().next_multiple_of(4);
    let mut bin = draco.clone();
    bin.resize(padded, 0);
    bin.extend(uvs);
    bin.resize(padded + 32 + 48, 0);
    let json = format!(
        r#""nodes":[{{"mesh":0}}],"extensionsRequired":["KHR_draco_mesh_compression"],
        "extensionsUsed":["KHR_draco_mesh_compression"],
        "meshes":[{{"primitives":[{{{primitive},"extensions":{{"KHR_draco_mesh_compression":{{"bufferView":0,"attributes":{map}}}}}}}]}}],
        "accessors":[{accessors}],"buffers":[{{"byteLength":{}}}],
        "bufferViews":[{{"buffer":0,"byteLength":{}}},{{"buffer":0,"byteOffset":{padded},"byteLength":32}},
        {{"buffer":0,"byteOffset":{},"byteLength":48}}]"#,
        bin.len(),
        draco.len(),
        padded + 32
    );
    glb(&json, &bin)
}

const PRIMITIVE: &str = r#""indices":0,"attributes":{"POSITION":1,"COLOR_0":2,"TEXCOORD_0":3}"#;

fn check_square(scene: &SceneDesc) {
    let mesh = &scene.meshes[0].data;
    assert_eq!(mesh.positions, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]]);
    assert_eq!(mesh.triangles, [[0, 1, 2], [2, 1, 3]]);
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

#[test]
fn decoded_attributes_take_the_place_of_the_accessors_data() {
    let scene = import(file(PRIMITIVE, MAP, ACCESSORS)).unwrap();
    check_square(&scene);
    let mesh = &scene.meshes[0].data;
    assert_eq!(mesh.colors[0], [1.0, 0.0, 0.0, 1.0]);
    assert_eq!(mesh.colors[3], [0.2, 0.2, 0.2, 1.0]);
    // Not compressed; v points up.
    assert_eq!(mesh.uvs, [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0], [1.0, 0.0]]);
    // A strip has the same triangles, and indices may be missing.
    check_square(&import(file(&format!(r#""mode":5,{PRIMITIVE}"#), MAP, ACCESSORS)).unwrap());
    check_square(&import(file(r#""attributes":{"POSITION":1}"#, MAP, ACCESSORS)).unwrap());
    // A fallback is not read: accessor 4 has zeros.
    check_square(&import(file(r#""attributes":{"POSITION":4}"#, MAP, ACCESSORS)).unwrap());
}

#[test]
fn sparse_elements_replace_decoded_ones() {
    // Element 0 (the zeros are the index) becomes (1, 0, 0): three floats of the texture coordinates.
    let sparse = r#"{"componentType":5126,"count":4,"type":"VEC3","sparse":{"count":1,
        "indices":{"bufferView":2,"componentType":5121},"values":{"bufferView":1,"byteOffset":8}}}"#;
    let accessors = ACCESSORS.replacen(POSITIONS, sparse, 1);
    let scene = import(file(r#""attributes":{"POSITION":1}"#, MAP, &accessors)).unwrap();
    assert_eq!(scene.meshes[0].data.positions[..2], [[1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
}

/// As in a truck of the sample models, whose accessors have the counts of the mesh before it was compressed.
#[test]
fn the_mesh_has_the_last_word_on_counts() {
    for (from, to) in [(r#""count":6"#, r#""count":9"#), (r#"5126,"count":4"#, r#"5126,"count":5"#)] {
        let scene = import(file(PRIMITIVE, MAP, &ACCESSORS.replacen(from, to, 1))).unwrap();
        assert_eq!((scene.meshes[0].data.positions.len(), scene.meshes[0].data.triangles.len()), (4, 2));
        let told =
            |w: &&Warning| w.message.starts_with("a Draco mesh with another number of vertices or indices");
        assert_eq!(scene.warnings.iter().filter(told).count(), 1, "{:?}", scene.warnings);
    }
    // Attributes that are not compressed have no other count.
    let accessors = ACCESSORS.replacen(r#""count":4,"type":"VEC2""#, r#""count":3,"type":"VEC2""#, 1);
    let message = import(file(PRIMITIVE, MAP, &accessors)).unwrap_err().message;
    assert!(message.contains("/accessors/3: has 3 elements; expected 4"), "{message}");
}

#[test]
fn what_disagrees_is_refused_where_it_stands() {
    let changed = |from: &str, to: &str| ACCESSORS.replacen(from, to, 1);
    let cases = [
        (
            file(PRIMITIVE, MAP, &changed("VEC4", "VEC3")),
            "/accessors/2: has 3 components per element; expected 4 for its Draco attribute",
        ),
        (
            file(PRIMITIVE, r#"{"POSITION":6}"#, ACCESSORS),
            "KHR_draco_mesh_compression/attributes/POSITION: refers to Draco attribute 6",
        ),
        (file(&format!(r#""mode":6,{PRIMITIVE}"#), MAP, ACCESSORS), "/mode: is 6; expected 4 or 5"),
        (
            file(PRIMITIVE, MAP, &changed("5126", "5121")),
            "/accessors/1: has component type U8, but its Draco attribute has floats",
        ),
        (
            file(PRIMITIVE, r#"{"POSITION":7,"COLOR_0":3}"#, &changed("5121", "5120")),
            "/accessors/2: has component type I8, but its Draco attribute has 200 at point 0",
        ),
    ];
    for (bytes, expected) in cases {
        let message = import(bytes).unwrap_err().message;
        assert!(message.contains(expected), "{message}");
    }
}
