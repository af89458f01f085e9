use turner::description::SceneDesc;
use turner::schema::WarningKind;

use crate::gltf::testing::{floats, glb, import, import_with};
use crate::import::ImportOptions;

/// The warnings about a triangle whose document has these additions.
fn doubts(node: &str, primitive: &str, accessor: &str, members: &str) -> Vec<String> {
    let json = format!(
        r#""scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0{node}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}{primitive}}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"{accessor}}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],"buffers":[{{"byteLength":36}}]{members}"#
    );
    said(&import(glb(&json, &floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]))).unwrap())
}

fn said(scene: &SceneDesc) -> Vec<String> {
    let doubtful = scene.warnings.iter().filter(|w| w.kind == WarningKind::Doubtful);
    doubtful.map(|w| w.message.clone()).collect()
}

const BOUNDS: &str = r#","min":[0,0,0],"max":[1,1,0]"#;

#[test]
fn a_valid_document_has_no_faults() {
    assert_eq!(doubts("", "", BOUNDS, ""), Vec::<String>::new());
}

/// Each case violates one rule of the specification or of its schema; the JSON pointer names the place.
#[test]
fn faults_are_named_by_json_pointers() {
    let cases = [
        ("", "", "", "", "/meshes/0/primitives/0/attributes/POSITION: has no min and max"),
        ("", "", r#","min":[0,0,0],"max":[1,2,0]"#, "", "/accessors/0/max: has 2, but of the values it is 1"),
        ("", "", r#","min":[0,0],"max":[1,1,0]"#, "", "/accessors/0/min: has 2 numbers; expected 3"),
        (r#","rotation":[0,0,0,0.5]"#, "", BOUNDS, "", "/nodes/0/rotation: has length 0.5"),
        (r#","weights":[]"#, "", BOUNDS, "", "/nodes/0/weights: has 0 elements; expected at least 1"),
        (
            "",
            r#","material":0"#,
            BOUNDS,
            r#","materials":[{"alphaCutoff":-1}]"#,
            "/materials/0/alphaCutoff: is -1; expected 0 or more",
        ),
        ("", "", BOUNDS, r#","cameras":[]"#, "/cameras: has 0 elements; expected at least 1"),
        (
            "",
            "",
            BOUNDS,
            r#","cameras":[{"type":"perspective","perspective":{"yfov":1,"znear":2,"zfar":1}}]"#,
            "/cameras/0: has zfar 1; expected more than znear, 2",
        ),
        ("", "", BOUNDS, r#","images":[{}]"#, "/images/0: has 0 of uri, bufferView; expected one"),
        (
            "",
            "",
            BOUNDS,
            r#","textures":[{"source":1}]"#,
            "/textures/0/source: refers to image 1, but there are 0",
        ),
        (
            "",
            "",
            BOUNDS,
            r#","extensions":{"EXT_x":{}}"#,
            "/extensions/EXT_x: is an extension that is missing in extensionsUsed",
        ),
        (
            "",
            "",
            BOUNDS,
            r#","extensionsUsed":["KHR_materials_unlit"],"samplers":[{"extensions":{"KHR_materials_unlit":{}}}]"#,
            "/samplers/0/extensions/KHR_materials_unlit: is not an extension of a sampler",
        ),
        ("", "", BOUNDS, r#","images":[[]]"#, "/images/0: is an array; expected an object"),
        (
            "",
            r#","mode":4,"targets":[{"NORMAL":0}]"#,
            BOUNDS,
            "",
            "/meshes/0/primitives/0/targets/0/NORMAL: has no attribute",
        ),
    ];
    for (node, primitive, accessor, members, expected) in cases {
        let found = doubts(node, primitive, accessor, members);
        assert!(found.iter().any(|m| m.starts_with(expected)), "expected {expected}, found {found:?}");
    }
}

#[test]
fn faults_of_one_kind_are_counted() {
    let materials = vec![r#"{"alphaCutoff":-2}"#; 1000].join(",");
    let json = format!(r#""materials":[{materials}]"#);
    let scene = import(glb(&json, &[])).unwrap();
    let found: Vec<_> = scene.warnings.iter().filter(|w| w.message.starts_with("/materials")).collect();
    assert_eq!(found.len(), 1);
    assert_eq!((found[0].count, &found[0].message[..21]), (1000, "/materials/0/alphaCut"));
}

/// glTF 2.0 §3.6.1.1: a buffer without uri may stand for data that comes from elsewhere; §3.6.2.4: the last element of
/// a matrix accessor needs no padding.
#[test]
fn placeholders_and_short_last_matrices_are_valid() {
    let placeholder = r#""accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
        "bufferViews":[{"buffer":1,"byteLength":36}],"buffers":[{"byteLength":1},{"byteLength":36}]"#;
    assert!(import(glb(placeholder, &[0])).is_ok());
    // Two columns of two bytes, each padded to four: 2 × 8 − 2 bytes.
    let matrices = |length: u32| {
        let json = format!(
            r#""accessors":[{{"bufferView":0,"componentType":5120,"count":2,"type":"MAT2"}}],
            "bufferViews":[{{"buffer":0,"byteLength":{length}}}],"buffers":[{{"byteLength":16}}]"#
        );
        import(glb(&json, &[0; 16]))
    };
    assert!(matrices(14).is_ok());
    assert!(matrices(13).unwrap_err().message.contains("reach byte 14"));
}

/// Linear keys 0 and 1 at 0 and 1 seconds.
fn animated(members: &str, kind: &str, values: &[f32], pointer: &str) -> Vec<u8> {
    let width = values.len() / 2;
    let bytes = 4 * values.len();
    let json = format!(
        r#""extensionsUsed":["KHR_animation_pointer"],"scenes":[{{"nodes":[0]}}],
        "nodes":[{{"mesh":0,"translation":[5,0,0]}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"material":0}}]}}],{members},
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},
            {{"bufferView":1,"componentType":5126,"count":2,"type":"SCALAR"}},
            {{"bufferView":2,"componentType":5126,"count":2,"type":"{kind}"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":8}},
            {{"buffer":0,"byteOffset":44,"byteLength":{bytes}}}],
        "buffers":[{{"byteLength":{}}}],"animations":[{{"samplers":[{{"input":1,"output":2}}],"channels":[{{"sampler":0,
            "target":{{"path":"pointer","extensions":{{"KHR_animation_pointer":{{"pointer":"{pointer}"}}}}}}}}]}}]"#,
        44 + bytes
    );
    assert!(width > 0);
    let triangle = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0];
    glb(&json, &floats(&[&triangle[..], values].concat()))
}

#[test]
fn pointers_animate_any_property() {
    let at = |bytes: Vec<u8>, animation: Option<&str>| {
        let options =
            ImportOptions { time: 0.25, animation: animation.map(str::to_owned), ..ImportOptions::default() };
        import_with(bytes, &options).unwrap()
    };
    let material = r#""materials":[{"pbrMetallicRoughness":{"roughnessFactor":0.5}}]"#;
    let roughness = |animation| {
        let pointer = "/materials/0/pbrMetallicRoughness/roughnessFactor";
        let scene = at(animated(material, "SCALAR", &[0.0, 1.0], pointer), animation);
        format!("{:?}", scene.materials[0].value.principled().unwrap().specular_roughness)
    };
    assert!(roughness(None).contains("0.25"), "{}", roughness(None));
    // The pose without animation.
    assert!(roughness(Some("none")).contains("0.5"));
    // A property with its default value is not in the document.
    let color = animated(
        material,
        "VEC4",
        &[0.0, 0.0, 0.0, 1.0, 1.0, 0.5, 0.0, 1.0],
        "/materials/0/pbrMetallicRoughness/baseColorFactor",
    );
    let color = format!("{:?}", at(color, None).materials[0].value.principled().unwrap().base_color);
    assert!(color.contains("0.25") && color.contains("0.125"), "{color}");
    let moved = at(animated(material, "VEC3", &[0.0, 0.0, 0.0, 8.0, 0.0, 0.0], "/nodes/0/translation"), None);
    assert_eq!(moved.objects[0].transform.0.translation.x, 2.0);
    let lost = at(animated(material, "VEC3", &[0.0; 6], "/nodes/7/translation"), None);
    assert!(said(&lost).iter().any(|m| m.contains("not in the document")), "{:?}", said(&lost));
}
