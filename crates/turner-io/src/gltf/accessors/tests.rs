use crate::gltf::testing::{floats, open};

const VIEW: &str = r#""buffers":[{"byteLength":64}],"bufferViews":[{"buffer":0,"byteLength":64}]"#;

fn said(members: &str) -> String {
    let opened = open(members, &[0; 64]);
    let result = opened.and_then(|o| o.elements(0).map(|_| "opened".to_owned()));
    result.unwrap_or_else(|fault| fault.in_file("a.glb").message)
}

fn accessor(json: &str) -> String {
    format!("{VIEW},\"accessors\":[{{\"bufferView\":0,{json}}}]")
}

#[test]
fn every_component_type_is_read() {
    let bytes = [0x80u8, 0xff, 0x01, 0x7f, 0x00, 0x00, 0x80, 0x3f];
    let expected: [(u32, bool, &[f32]); 10] = [
        (5120, false, &[-128.0, -1.0, 1.0, 127.0]),
        (5120, true, &[-1.0, -1.0 / 127.0, 1.0 / 127.0, 1.0]),
        (5121, false, &[128.0, 255.0, 1.0, 127.0]),
        (5121, true, &[128.0 / 255.0, 1.0, 1.0 / 255.0, 127.0 / 255.0]),
        (5122, false, &[-128.0, 32513.0, 0.0, 16256.0]),
        (5122, true, &[-128.0 / 32767.0, 32513.0 / 32767.0, 0.0, 16256.0 / 32767.0]),
        (5123, false, &[65408.0, 32513.0, 0.0, 16256.0]),
        (5123, true, &[65408.0 / 65535.0, 32513.0 / 65535.0, 0.0, 16256.0 / 65535.0]),
        (5125, false, &[2_130_837_376.0, 1_065_353_216.0]),
        (5126, false, &[f32::from_bits(0x7f01_ff80), 1.0]),
    ];
    for (component, normalized, values) in expected {
        let json = accessor(&format!(
            r#""componentType":{component},"normalized":{normalized},"count":{},"type":"SCALAR""#,
            values.len()
        ));
        let opened = open(&json, &[&bytes[..], &[0; 56]].concat()).unwrap();
        let elements = opened.elements(0).unwrap();
        for (i, value) in values.iter().enumerate() {
            assert_eq!(elements.get::<1>(i)[0].to_bits(), value.to_bits(), "{component} {normalized} {i}");
        }
    }
}

#[test]
fn strides_and_offsets_interleave() {
    let bin = floats(&[1.0, 2.0, 3.0, 10.0, 20.0, 4.0, 5.0, 6.0, 30.0, 40.0]);
    let members = r#""buffers":[{"byteLength":40}],"bufferViews":[{"buffer":0,"byteLength":40,"byteStride":20}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":2,"type":"VEC3"},
                     {"bufferView":0,"byteOffset":12,"componentType":5126,"count":2,"type":"VEC2"}]"#;
    let opened = open(members, &bin).unwrap();
    let (a, b) = (opened.elements(0).unwrap(), opened.elements(1).unwrap());
    assert_eq!([a.get(0), a.get(1)], [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    assert_eq!([b.get(0), b.get(1)], [[10.0, 20.0], [30.0, 40.0]]);
    // Missing components are zero.
    assert_eq!(b.get::<3>(1), [30.0, 40.0, 0.0]);
}

#[test]
fn sparse_elements_replace_those_of_the_view_or_zeros() {
    let bin = [floats(&[1.0, 2.0, 3.0, 4.0, 9.0, 8.0]), vec![1, 0, 3, 0]].concat();
    let sparse = r#""sparse":{"count":2,"indices":{"bufferView":1,"byteOffset":8,"componentType":5123},"values":{"bufferView":1}}"#;
    let members = format!(
        r#""buffers":[{{"byteLength":28}}],
        "bufferViews":[{{"buffer":0,"byteLength":16}},{{"buffer":0,"byteOffset":16,"byteLength":12}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"SCALAR",{sparse}}},
                     {{"componentType":5126,"count":4,"type":"SCALAR",{sparse}}}]"#
    );
    let opened = open(&members, &bin).unwrap();
    let read = |a| (0..4).map(|i| opened.elements(a).unwrap().get::<1>(i)[0]).collect::<Vec<_>>();
    assert_eq!(read(0), [1.0, 9.0, 3.0, 8.0]);
    assert_eq!(read(1), [0.0, 9.0, 0.0, 8.0]);
    // Not increasing, or out of range.
    for bad in [[3u8, 0, 1, 0], [1, 0, 1, 0], [1, 0, 4, 0]] {
        let mut bin = bin.clone();
        bin[24..].copy_from_slice(&bad);
        let opened = open(&members, &bin).unwrap();
        let message = opened.elements(0).unwrap().check_sparse().unwrap_err().in_file("a.glb").message;
        assert!(message.contains("/accessors/0/sparse/indices"), "{message}");
    }
}

#[test]
fn what_reaches_beyond_its_view_is_refused() {
    let good = r#""componentType":5126,"count":5,"type":"VEC3""#;
    assert_eq!(said(&accessor(good)), "opened");
    assert_eq!(
        said(&accessor(r#""componentType":5126,"count":6,"type":"VEC3""#)),
        "a.glb: /accessors/0: 6 elements of 12 bytes reach byte 72, but buffer view 0 ends at 64"
    );
    let huge = r#""componentType":5126,"count":18446744073709551615,"type":"MAT4""#;
    assert!(said(&accessor(huge)).contains("an address that overflows"), "{}", said(&accessor(huge)));
    let offset = r#""byteOffset":18446744073709551615,"componentType":5121,"count":2,"type":"SCALAR""#;
    assert!(said(&accessor(offset)).contains("an address that overflows"));
    assert!(
        said(&accessor(r#""componentType":5127,"count":1,"type":"VEC3""#))
            .contains("/componentType: is 5127")
    );
    assert!(
        said(&accessor(r#""componentType":5126,"count":1,"type":"VEC5""#)).contains("/type: is \"VEC5\"")
    );
    assert!(said(&accessor(r#""componentType":5126,"type":"VEC3""#)).contains("/count: is missing"));
    let zeros = format!(r#"{VIEW},"accessors":[{{"componentType":5126,"count":99999999,"type":"VEC3"}}]"#);
    assert!(said(&zeros).contains("without a buffer view"));
    let overlapping = r#""buffers":[{"byteLength":64}],"bufferViews":[{"buffer":0,"byteLength":64,"byteStride":4}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":2,"type":"VEC3"}]"#;
    assert!(said(overlapping).contains("overlap"));
    let view = r#""buffers":[{"byteLength":64}],"bufferViews":[{"buffer":0,"byteOffset":60,"byteLength":8}]"#;
    assert!(said(view).starts_with("a.glb: /bufferViews/0: 8 bytes from byte 60,"), "{}", said(view));
    let buffer = r#""buffers":[{"byteLength":65000}]"#;
    assert!(said(buffer).contains("/buffers/0: says 65000 bytes, but there are 64"));
    assert!(
        said(r#""accessors":[{"bufferView":3,"componentType":5126,"count":2,"type":"VEC3"}]"#)
            .contains("buffer view 3, but there are 0")
    );
}

#[test]
fn columns_of_small_matrices_are_padded() {
    let fits = |component: u32, kind: &str, count: usize| {
        let json = format!(r#""componentType":{component},"count":{count},"type":"{kind}""#);
        said(&accessor(&json)) == "opened"
    };
    // 2 columns of 4 bytes, 3 of 4, 3 of 8, 4 of 8.
    for (component, kind, count) in
        [(5121, "MAT2", 8), (5120, "MAT3", 5), (5123, "MAT3", 2), (5122, "MAT4", 2)]
    {
        assert!(fits(component, kind, count) && !fits(component, kind, count + 1), "{component} {kind}");
    }
}
