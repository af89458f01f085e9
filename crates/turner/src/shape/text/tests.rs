use super::testing::text;
use super::*;
use crate::math::Ray;
use crate::math::elementary::sin_cos;
use crate::schema::{Asset, PrepareOptions};
use crate::shape::solid::csg::open_edges;
use crate::shape::{MeshCache, Shape, ShapeDesc};

fn set(desc: &TextDesc) -> MeshData {
    let set = desc.mesh(&Limits::default()).unwrap();
    set.mesh.check().unwrap();
    assert_eq!(open_edges(&set.mesh), 0, "{}", desc.text);
    assert_eq!(set.missing, Vec::<char>::new());
    set.mesh
}

fn at(p: [f32; 3]) -> DVec3 {
    DVec3::from(p.map(f64::from))
}

/// Area and volume.
fn measures(mesh: &MeshData) -> [f64; 2] {
    mesh.triangles.iter().fold([0.0; 2], |[area, volume], t| {
        let [a, b, c] = t.map(|i| at(mesh.positions[i as usize]));
        [area + 0.5 * (b - a).cross(c - a).length(), volume + a.dot(b.cross(c)) / 6.0]
    })
}

fn box_of(mesh: &MeshData) -> [DVec3; 2] {
    let points = || mesh.positions.iter().map(|p| at(*p));
    [points().fold(DVec3::INFINITY, DVec3::min), points().fold(DVec3::NEG_INFINITY, DVec3::max)]
}

fn near(a: f64, b: f64, within: f64) {
    assert!((a - b).abs() <= within, "{a} {b}");
}

/// The error of areas and volumes by rounding to the grid.
const GRID: f64 = 4e-6;
const PI: f64 = std::f64::consts::PI;

#[test]
fn areas_and_volumes_are_those_of_the_outlines() {
    let mesh = set(&TextDesc { size: 2.0, depth: 0.3, ..text("I") });
    assert_eq!((mesh.triangles.len(), mesh.positions.len()), (12, 24));
    let [area, volume] = measures(&mesh);
    // .4 x 1.4, to the rounding of the grid: half of 2^-20 em at each corner.
    near(volume, 0.4 * 1.4 * 0.3, GRID);
    near(area, 2.0 * 0.4 * 1.4 + 3.6 * 0.3, GRID);
    let [min, max] = box_of(&mesh);
    near((min - DVec3::new(0.1, 0.0, 0.0)).length(), 0.0, 1e-6);
    near((max - DVec3::new(0.5, 1.4, 0.3)).length(), 0.0, 1e-6);
    // A ring: π (R² - r²). Chords lie inside a circle by at most the tolerance.
    for tolerance in [1e-2, 1e-3, 2e-4] {
        let [area, volume] = measures(&set(&TextDesc { tolerance, depth: 0.5, ..text("o") }));
        near(volume, PI * (0.0625 - 0.0225) * 0.5, 0.5 * tolerance);
        near(area, 2.0 * PI * 0.04 + 2.0 * PI * 0.4 * 0.5, 4.0 * tolerance);
    }
    // Two rings that overlap, with holes that stay holes where the other ring does not reach: by circular segments. The
    // union of R-circles at distance d, less what of each r-circle the other R-circle does not contain.
    let lens = |r: f64, s: f64, d: f64| {
        let acos = crate::math::elementary::acos;
        let (x, y) = ((d * d + r * r - s * s) / (2.0 * d), (d * d + s * s - r * r) / (2.0 * d));
        let part = |r: f64, x: f64| r * r * acos(x / r) - x * (r * r - x * x).sqrt();
        part(r, x) + part(s, y)
    };
    let union = 2.0 * PI * 0.0625 - lens(0.25, 0.25, 0.35);
    let hole = PI * 0.0225 - lens(0.15, 0.25, 0.35);
    let [_, volume] = measures(&set(&TextDesc { depth: 1.0, ..text("8") }));
    near(volume, union - 2.0 * hole, 4e-4);
}

#[test]
fn normals_are_smooth_on_curves_and_flat_elsewhere() {
    let mesh = set(&TextDesc { tolerance: 5e-3, ..text("o") });
    let mut walls = 0;
    for (p, n) in mesh.positions.iter().zip(&mesh.normals).map(|(p, n)| (at(*p), at(*n))) {
        near(n.length(), 1.0, 1e-6);
        if n.z == 0.0 {
            let out = DVec2::new(p.x - 0.3, p.y - 0.25);
            let sign = if out.length() > 0.2 { 1.0 } else { -1.0 };
            near((DVec2::new(n.x, n.y) - sign * out.normalize()).length(), 0.0, 2e-4);
            walls += 1;
        } else {
            assert!(n.z.abs() == 1.0 && p.z == if n.z > 0.0 { f64::from(0.2f32) } else { 0.0 });
        }
    }
    assert!(walls > 80, "{walls}");
    // Corners are creases: all normals of a box are along the axes.
    let mesh = set(&text("I"));
    assert!(mesh.normals.iter().all(|n| n.iter().filter(|v| **v != 0.0).count() == 1), "{:?}", mesh.normals);
    // Triangles face the side of their normals.
    for mesh in [set(&text("8I o=")), mesh] {
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|i| at(mesh.positions[i as usize]));
            let face = (b - a).cross(c - a);
            assert!(face.length() > 0.0);
            assert!(t.iter().all(|i| face.normalize().dot(at(mesh.normals[*i as usize])) > 0.9));
        }
    }
}

#[test]
fn the_front_has_uv_over_the_rectangle_around_the_text() {
    let mesh = set(&TextDesc { size: 3.0, ..text("II") });
    let [min, max] = box_of(&mesh);
    for (p, uv) in mesh.positions.iter().zip(&mesh.uvs) {
        let expected = (at(*p) - min) / (max - min);
        near(f64::from(uv[0]), expected.x, 1e-6);
        near(f64::from(uv[1]), expected.y, 1e-6);
    }
}

#[test]
fn lines_are_aligned_spaced_and_kerned() {
    let range = |desc: &TextDesc| {
        let [min, max] = box_of(&set(desc));
        [min.x, max.x, min.y, max.y]
    };
    let same = |found: [f64; 4], expected: [f64; 4]| {
        found.iter().zip(expected).for_each(|(a, b)| near(*a, b, 1e-4));
    };
    same(range(&text("II")), [0.05, 0.55, 0.0, 0.7]);
    same(range(&TextDesc { align: TextAlign::Center, ..text("II") }), [-0.25, 0.25, 0.0, 0.7]);
    same(range(&TextDesc { align: TextAlign::Right, ..text("II") }), [-0.55, -0.05, 0.0, 0.7]);
    // Spacing is between characters, not after the last one.
    let spaced = TextDesc { letter_spacing: 0.1, ..text("II") };
    same(range(&spaced), [0.05, 0.65, 0.0, 0.7]);
    same(range(&TextDesc { align: TextAlign::Right, ..spaced }), [-0.65, -0.05, 0.0, 0.7]);
    // The pair is kerned; the other order is not.
    same(range(&text("Io")), [0.05, 0.3 - 0.05 + 0.55, 0.0, 0.7]);
    same(range(&text("oI")), [0.05, 0.85, 0.0, 0.7]);
    // Lines below the first; an empty one keeps its place; Windows' ends of lines are no characters.
    same(range(&text("I\nI")), [0.05, 0.25, -1.2, 0.7]);
    same(range(&TextDesc { line_spacing: 2.0, ..text("I\r\n\r\nI") }), [0.05, 0.25, -4.0, 0.7]);
    same(range(&TextDesc { align: TextAlign::Right, ..text("I I\nI") }), [-0.8, -0.05, -1.2, 0.7]);
}

#[test]
fn letters_that_overlap_are_one_body() {
    // The second rectangle covers half of the first.
    let [area, volume] = measures(&set(&TextDesc { depth: 1.0, letter_spacing: -0.2, ..text("II") }));
    near(volume, 0.3 * 0.7, GRID);
    near(area, 2.0 * 0.3 * 0.7 + 2.0, GRID);
    // Exactly on each other, and side by side.
    near(measures(&set(&TextDesc { depth: 1.0, letter_spacing: -0.3, ..text("II") }))[1], 0.14, GRID);
    let [area, _] = measures(&set(&TextDesc { depth: 1.0, letter_spacing: -0.1, ..text("II") }));
    near(area, 2.0 * 0.28 + 2.2, GRID);
}

fn shape(desc: TextDesc) -> (Shape, Vec<String>) {
    let meshes: [Asset<MeshData>; 0] = [];
    let mut cache = MeshCache::new(&meshes);
    let shape = ShapeDesc::Text(desc).prepare(&mut cache).unwrap();
    (shape, cache.warnings())
}

#[test]
fn rays_pass_through_holes() {
    let (shape, warnings) = shape(text("o"));
    assert_eq!(warnings, Vec::<String>::new());
    let Shape::Mesh(mesh) = &shape else { panic!() };
    mesh.build_tree(&PrepareOptions::default()).unwrap();
    let hits = |x: f64, y: f64| shape.intersect(&Ray::new(DVec3::new(x, y, 5.0), DVec3::NEG_Z)).map(|h| h.t);
    assert_eq!(hits(0.3, 0.25), None, "the middle of the ring");
    for i in 0..40 {
        let (s, c) = sin_cos(0.157 * f64::from(i));
        for (r, is_hit) in [(0.14, false), (0.16, true), (0.24, true), (0.26, false)] {
            let t = hits(0.3 + r * c, 0.25 + r * s);
            assert_eq!(t.is_some(), is_hit, "{i} {r}");
            assert!(t.is_none_or(|t| (t - 4.8).abs() < 1e-6));
        }
    }
}

#[test]
fn what_is_missing_is_a_warning() {
    let (_, warnings) = shape(text("IxI\u{202e}xo"));
    assert_eq!(warnings, ["the font of a text lacks characters, left out: x (U+0078), U+202E"]);
    let (_, warnings) = shape(text(" \n"));
    assert_eq!(warnings, ["a text has no outlines to show"]);
    let many: String = ('A'..'\u{60}').filter(|c| *c != 'I').collect();
    assert!(
        shape(text(&many)).1[0].ends_with("T (U+0054), U (U+0055) and 10 more"),
        "{:?}",
        shape(text(&many)).1
    );
}

#[test]
fn faults_have_a_remedy() {
    let fault = |desc: TextDesc| desc.mesh(&Limits::default()).err().unwrap();
    let no_font = fault(TextDesc::default());
    assert_eq!((no_font.code, no_font.message.as_str()), (ErrorCode::Font, "a text has no font"));
    assert!(no_font.help.unwrap().contains("font = "));
    assert_eq!(fault(TextDesc { face: 1, ..text("I") }).code, ErrorCode::Font);
    assert_eq!(fault(text(&"I".repeat(MOST_CHARACTERS + 1))).code, ErrorCode::TooLarge);
    assert_eq!(fault(TextDesc { letter_spacing: 100.0, ..text(&"I".repeat(200)) }).code, ErrorCode::TooLarge);
    let few = Limits { max_triangles: 100, ..Limits::default() };
    assert_eq!(text("o").mesh(&few).err().unwrap().code, ErrorCode::TooLarge);
}

/// A page of text keeps its exact volume, and takes no time that grows with the square of its length.
#[test]
fn long_texts() {
    let line = "I=".repeat(100);
    let page = [line.as_str(); 60].join("\n");
    let [_, volume] = measures(&set(&TextDesc { depth: 1.0, ..text(&page) }));
    near(volume / (6000.0 * (0.14 + 0.08)), 1.0, 1e-3);
}
