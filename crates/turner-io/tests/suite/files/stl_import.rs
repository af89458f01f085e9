//! STL files as scenes.

use turner::schema::WarningKind;
use turner_io::import::ImportOptions;

use super::mesh_import::{constant, import_with, material, mesh, said};

/// A binary STL with the given header, facets (normal, corners) and attribute bytes.
fn stl(header: &[u8], flat_triangles: &[([f32; 12], u16)]) -> Vec<u8> {
    let mut out = header.to_vec();
    out.resize(80, b' ');
    out.extend((flat_triangles.len() as u32).to_le_bytes());
    for (numbers, spare) in flat_triangles {
        numbers.iter().for_each(|v| out.extend(v.to_le_bytes()));
        out.extend(spare.to_le_bytes());
    }
    out
}

#[test]
fn stl_of_both_kinds() {
    let up = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let down = [0.0, 0.0, -1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0];
    let import = |bytes: Vec<u8>| import_with(&[("a.stl", bytes)], &ImportOptions::default());
    let scene = import(stl(b"solid but binary", &[(up, 0), (down, 0)])).unwrap();
    assert_eq!((mesh(&scene).positions.len(), &mesh(&scene).triangles[..]), (4, &[[0, 1, 2], [1, 3, 2]][..]));
    assert_eq!(said(&scene, WarningKind::Doubtful, "opposes the order"), 1);
    // VisCAM: red 31, then a facet without colour. Magics: the same bits in reverse order, in a blue object.
    let scene = import(stl(b"", &[(up, 0x8000 | 31 << 10), (up, 0)])).unwrap();
    assert_eq!(mesh(&scene).face_materials, [0, 1]);
    assert_eq!(constant(material(&scene, "#ff0000").base_color), [1.0, 0.0, 0.0]);
    let scene = import(stl(b"COLOR=\x00\x00\xff\xff", &[(up, 31), (up, 0x8000)])).unwrap();
    assert_eq!(constant(material(&scene, "#ff0000").base_color), [1.0, 0.0, 0.0]);
    assert_eq!(constant(material(&scene, "plain#0000ff").base_color), [0.0, 0.0, 1.0]);
    for cut in [10, 83, 84, 100, 183] {
        let bytes = stl(b"x", &[(up, 0), (down, 0)]);
        let error = import(bytes[..cut].to_vec()).unwrap_err();
        assert!(error.message.starts_with("a.stl: damaged STL: byte"), "{error}");
    }
    let text = "solid one\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nVERTEX 0 1e0 -0\nendloop\nendfacet\nendsolid one\n\
                solid two\nfacet normal 0 0 -1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";
    let scene = import(text.replace('\n', "\r\n").into_bytes()).unwrap();
    assert_eq!((mesh(&scene).positions.len(), mesh(&scene).triangles.len()), (4, 3));
    assert_eq!((&mesh(&scene).face_materials[..], scene.materials.len()), (&[0, 1, 1][..], 2));
    assert_eq!(said(&scene, WarningKind::Doubtful, "opposes the order"), 1);
    let options = ImportOptions { nodes: vec!["two".into()], ..Default::default() };
    let picked = import_with(&[("a.stl", text.as_bytes().to_vec())], &options).unwrap();
    assert_eq!(mesh(&picked).triangles.len(), 2);
    for (bad, words) in [
        ("solid\nfacet normal 0 0\nouter loop\n", "line 3: expected `facet normal x y z`, found \"outer\""),
        (
            "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0",
            "expected `vertex x y z`, found the end of the file",
        ),
        ("solid\nhello\n", "line 2: expected `facet`"),
        ("solid\n", "no faces"),
    ] {
        let error = import(bad.as_bytes().to_vec()).unwrap_err();
        assert!(error.message.contains(words), "{error}");
    }
}
