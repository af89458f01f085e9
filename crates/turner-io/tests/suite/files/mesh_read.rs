//! Meshes in every layout, damaged meshes, and meshes by other programs.

use std::fmt::Write;

use turner_io::mesh::{ReadMesh, decode};

const CORNERS: [[f32; 8]; 4] = [
    [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
    [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0],
    [1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0],
    [0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0],
];

fn data(name: &str) -> Vec<u8> {
    std::fs::read(format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn number(out: &mut Vec<u8>, format: &str, kind: &str, v: f64) {
    let mut bytes = match kind {
        "uchar" => vec![v as u8],
        "short" => (v as i16).to_le_bytes().to_vec(),
        "int" => (v as i32).to_le_bytes().to_vec(),
        "float" => (v as f32).to_le_bytes().to_vec(),
        _ => v.to_le_bytes().to_vec(),
    };
    match format {
        "ascii" => return out.extend_from_slice(format!("{v} ").as_bytes()),
        "binary_big_endian" => bytes.reverse(),
        _ => {}
    }
    out.extend(bytes);
}

/// A square as a quad or as two triangles; `real` and `int` are the types of its numbers.
fn square(format: &str, real: &str, count: &str, int: &str, quad: bool, extra: bool, eol: &str) -> Vec<u8> {
    let mut h = format!("ply{eol}format {format} 1.0{eol}comment a b{eol}");
    let faces = if quad { 1 } else { 2 };
    if extra {
        write!(h, "element thing 2{eol}property list uchar short a{eol}property double b{eol}").unwrap();
    }
    write!(h, "element vertex 4{eol}").unwrap();
    for name in ["x", "y", "z", "nx", "ny", "nz"] {
        write!(h, "property {real} {name}{eol}").unwrap();
    }
    if extra {
        write!(h, "property uchar red{eol}").unwrap();
    }
    write!(h, "property {real} s{eol}property {real} t{eol}element face {faces}{eol}").unwrap();
    if extra {
        write!(h, "property int flags{eol}").unwrap();
    }
    write!(h, "property list {count} {int} vertex_index{eol}end_header{eol}").unwrap();
    let mut out = h.into_bytes();
    if extra {
        for n in [0, 3] {
            number(&mut out, format, "uchar", f64::from(n));
            (0..n).for_each(|i| number(&mut out, format, "short", f64::from(i)));
            number(&mut out, format, "double", 0.5);
        }
    }
    for corner in CORNERS {
        corner[..6].iter().for_each(|&v| number(&mut out, format, real, f64::from(v)));
        if extra {
            number(&mut out, format, "uchar", 200.0);
        }
        corner[6..].iter().for_each(|&v| number(&mut out, format, real, f64::from(v)));
    }
    let lists: &[&[u8]] = if quad { &[&[0, 1, 2, 3]] } else { &[&[0, 1, 2], &[0, 2, 3]] };
    for list in lists {
        if extra {
            number(&mut out, format, "int", -1.0);
        }
        number(&mut out, format, count, list.len() as f64);
        list.iter().for_each(|&i| number(&mut out, format, int, f64::from(i)));
    }
    out
}

#[test]
fn every_layout_of_a_ply_gives_the_same_mesh() {
    let mut tried = 0;
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        for (real, count, int) in [
            ("float", "uchar", "int"),
            ("double", "int", "int"),
            ("short", "uchar", "uchar"),
            ("float", "short", "short"),
        ] {
            for (quad, extra) in [(false, false), (true, false), (true, true), (false, true)] {
                for eol in ["\n", "\r\n"] {
                    let bytes = square(format, real, count, int, quad, extra, eol);
                    let ReadMesh { mesh, warnings, .. } = decode(&bytes, "a.ply").unwrap();
                    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
                    assert_eq!(mesh.positions, CORNERS.map(|c| [c[0], c[1], c[2]]));
                    assert_eq!(mesh.normals, CORNERS.map(|c| [c[3], c[4], c[5]]));
                    assert_eq!(mesh.uvs, CORNERS.map(|c| [c[6], c[7]]));
                    // An unknown element is reported as ignored.
                    assert_eq!(warnings.len(), usize::from(extra));
                    tried += 1;
                }
            }
        }
    }
    assert_eq!(tried, 96);
}

#[test]
fn bad_plys_say_where() {
    let head = "ply\nformat ascii 1.0\n";
    let xyz = "property float x\nproperty float y\nproperty float z\n";
    let faces = "property list uchar int vertex_indices\nend_header\n";
    for (text, words) in [
        ("ply\n".to_owned(), "line 2: the header does not end"),
        (format!("{head}element vertex 4000000000\n{xyz}end_header\n"), "holds at most"),
        (format!("{head}element vertex 99999999999999999999\n"), "line 3: expected a number"),
        (format!("{head}property float x\n"), "before the first element"),
        (format!("{head}element vertex 1\nproperty flaot x\n"), "line 4: expected `property TYPE NAME`"),
        ("ply\nformat ascii2 1.0\n".to_owned(), "binary_big_endian"),
        ("ply\nend_header\n".to_owned(), "is missing"),
        (format!("{head}element vertex 5\nend_header\n"), "no properties"),
        (format!("{head}element vertex 1\nproperty float x\nproperty float y\nend_header\n1 2\n"), "\"z\""),
        (format!("{head}element vertex 1\n{xyz}end_header\n1 2 3\n"), "point cloud with"),
        (
            format!("{head}element vertex 1\n{xyz}end_header\n1 2 q\n"),
            "line 8: expected a number, found \"q\"",
        ),
        (
            format!("{head}element vertex 3\n{xyz}element face 1\n{faces}0 0 0 1 0 0 0 1 0\n3 0 1 3\n"),
            "line 11: face 1 refers to vertex 3, but there are 3 (0 to 2)",
        ),
        (
            format!("{head}element vertex 3\n{xyz}element face 1\n{faces}0 0 0 1 0 0 0 1 0\n3 0 1 -1\n"),
            "refers to vertex -1",
        ),
        (
            format!("{head}element vertex 3\n{xyz}element face 1\n{faces}0 0 0 1 0 0 0 1 0\n200 0 1\n"),
            "a list of 200",
        ),
        (format!("{head}element thing 4000000000\nelement vertex 0\n{xyz}end_header\n"), "no faces"),
    ] {
        let error = decode(text.as_bytes(), "a.ply").unwrap_err().to_string();
        assert!(error.starts_with("a.ply: ") && error.contains(words), "{text}\n{error}");
    }
    let mut cut = square("binary_little_endian", "float", "uchar", "int", false, false, "\n");
    let at = cut.len() - 4;
    cut[at] = 9;
    let error = decode(&cut, "a.ply").unwrap_err().to_string();
    assert!(
        error.contains("face 2 refers to vertex 9, but there are 4") && error.contains("byte "),
        "{error}"
    );
}

#[test]
fn obj_polygons_negative_indices_and_partial_attributes() {
    let read = |text: &str| decode(text.as_bytes(), "a.obj").unwrap();
    let square = "v 0 0 0\r\nv 1 0 0 # b\nv 1 1 0 1 0 0\nv 0 2 0 2\n";
    let plain = read(&format!("mtllib x.mtl\n{square}f 1 2 \\\n3 -1\nl 1 2\n"));
    assert_eq!(plain.mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(plain.mesh.positions[3], [0.0, 1.0, 0.0]);
    assert_eq!(plain.warnings.len(), 2);
    let partial = read(&format!("{square}vt 0.5\nvn 1 0 0\nf 1/1/1 2/1/1 3/1/1\nf 1//1 3 4\n"));
    assert_eq!(partial.mesh.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(partial.mesh.uvs[..4], [[0.5, 0.0], [0.5, 0.0], [0.5, 0.0], [0.0, 0.0]]);
    assert_eq!(partial.mesh.normals[3..], [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]]);
    let ahead = read("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n");
    assert_eq!(ahead.mesh.triangles, [[0, 1, 2]]);
    // Many variants of one position must not take quadratic time.
    let mut text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_owned();
    for i in 1..=20_000 {
        write!(text, "vt {i} 0\nf 1/{i} 2/{i} 3/{i}\nf 1/{i} 2/{i} 3/{i}\n").unwrap();
    }
    assert_eq!(read(&text).mesh.positions.len(), 60_000);
}

#[test]
fn bad_objs_say_where() {
    for (text, words) in [
        ("v 0 0\n", "line 1: expected `v x y z`, found 2 numbers"),
        ("v 0 0 a\n", "found \"a\""),
        ("v 0 0 0\nf 1 1 0\n", "line 2: face 1 refers to vertex 0"),
        ("v 0 0 0\nf 1 1 -2\n", "face 1 refers to vertex -2, but there are 1 (1 to 1)"),
        ("v 0 0 0\nf 1 1 1\n\nf 1 1/3 2\n", "line 4: face 2 refers to vertex 2"),
        ("v 0 0 0\nf 1/1/1/1 1 1\n", "expected a vertex"),
        ("v 0 0 0\nf 1 1 99999999999999999999\n", "expected a vertex"),
        ("v 0 0 0\nf\n", "without vertices"),
        ("v 0 0 0\n", "1 vertices but no faces"),
        ("", "no faces"),
        (
            "v 0 0 0\nv 1 0 0\nl 1 2\nl 2 1\n",
            "no faces; expected a mesh of polygons, found 2 × `l` elements (lines)",
        ),
        ("v 0 0 0\np 1\n", "polygons, found 1 × `p` elements (points)"),
        ("v nan 0 0\nf 1 1 1\n", "no faces"),
    ] {
        let error = decode(text.as_bytes(), "a.obj").unwrap_err().to_string();
        assert!(error.starts_with("a.obj: ") && error.contains(words), "{text}\n{error}");
    }
}

/// What programs write against the specification, or beside it.
#[test]
fn unusual_lines_of_objs_are_read() {
    let text = "# a # b\no x # not a name\nv 0 0 0 # first\nv 1 0 0\nv 1 1 0\nv 0 1 0 #\nvt 0 0\nvn 0 0 1\n\
                s 1 # smooth\nf 1 2 3 # a triangle\n\tf -4/1 -2//1 -1/1/1\ns off\nf 1/ 2/ 3/\n";
    let read = decode(text.as_bytes(), "a.obj").unwrap();
    assert_eq!(read.mesh.triangles.len(), 3);
    assert!(read.mesh.normals.iter().all(|n| *n == [0.0, 0.0, 1.0]), "{:?}", read.mesh.normals);
}

/// Two faces of a roof: smooth in a group, flat without one.
#[test]
fn smoothing_groups_of_objs_are_smooth() {
    let read = |groups: [&str; 2]| {
        let [a, b] = groups;
        let text = format!("v 0 0 0\nv 0 1 0\nv 1 0 -1\nv -1 0 -1\n{a}\nf 1 3 2\n{b}\nf 1 2 4\n");
        decode(text.as_bytes(), "a.obj").unwrap().mesh
    };
    let s = std::f32::consts::FRAC_1_SQRT_2;
    let near = |n: [f32; 3], e: [f32; 3]| n.iter().zip(e).all(|(n, e)| (n - e).abs() < 1e-6);
    // The ridge has the mean of both normals, (±s, 0, s).
    let smooth = read(["s 1", ""]);
    let ridge = smooth.positions.iter().zip(&smooth.normals).filter(|(p, _)| p[0] == 0.0);
    assert!({ ridge }.all(|(_, n)| near(*n, [0.0, 0.0, 1.0])), "{:?}", smooth.normals);
    assert_eq!(smooth.positions.len(), 4);
    for groups in [["s 1", "s 2"], ["s 1", "s off"], ["s 1", "s 0"]] {
        let flat = read(groups);
        assert_eq!(flat.positions.len(), 6);
        assert!(flat.normals.iter().all(|n| near(*n, [n[0].signum() * s, 0.0, s])), "{:?}", flat.normals);
    }
    assert!(read(["", ""]).normals.is_empty());
}

#[test]
fn unknown_lines_of_ply_headers_are_ignored_with_a_warning() {
    let head = "ply\nformat ascii 1.0\nobj_info anything here\ncamera 1 2 3\nelement vertex 3\nproperty float x\n\
                property float y\nproperty float z\nproperty int label\nelement extra 1\n\
                property list uchar int values\nunits mm\nelement face 1\nproperty list uchar int vertex_indices\n\
                end_header\n";
    let text = format!("{head}0 0 0 7\n1 0 0 7\n0 1 0 7\n2 5 5\n3 0 1 2\n");
    let read = decode(text.as_bytes(), "a.ply").unwrap();
    assert_eq!((read.mesh.positions.len(), read.mesh.triangles.len()), (3, 1));
    let messages: Vec<&str> = read.warnings.iter().map(|w| w.message.as_str()).collect();
    assert!(
        messages.contains(&"a.ply: lines of the header are ignored, the first is \"camera 1 2 3\""),
        "{messages:?}"
    );
    let error =
        decode(b"ply\nformat ascii 1.0\nelement vertex\nend_header\n", "a.ply").unwrap_err().to_string();
    assert!(error.contains("line 3: expected `element NAME COUNT`"), "{error}");
}

#[test]
fn files_by_other_programs() {
    for (name, vertices, triangles) in [
        ("multi.ply", 4, 2),
        ("cube_blender_uv.ply", 24, 12),
        ("cube.obj", 8, 12),
        ("negative_indices.obj", 0, 0),
        ("polygonfaces.obj", 0, 0),
        ("test-nan.obj", 0, 0),
    ] {
        let read = decode(&data(name), name).unwrap();
        if vertices > 0 {
            assert_eq!(
                (read.mesh.positions.len(), read.mesh.triangles.len()),
                (vertices, triangles),
                "{name}"
            );
        }
        assert!(read.mesh.positions.as_flattened().iter().all(|v| v.is_finite()));
    }
    let error = decode(&data("points_ascii.ply"), "points_ascii.ply").unwrap_err().to_string();
    assert!(error.contains("5 vertices but no faces"), "{error}");
}
