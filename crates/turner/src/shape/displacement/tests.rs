use super::*;
use crate::image::Pixels;
use crate::shape::solid::csg::open_edges;
use crate::shape::subdivision::{Subdivision, SubdivisionScheme, subdivide};

fn at(mesh: &MeshData, v: u32) -> DVec3 {
    DVec3::from(mesh.positions[v as usize].map(f64::from))
}

fn image(width: u32, height: u32, value: impl Fn(u32, u32) -> f32) -> Image {
    let all = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let pixels = Pixels::F32(all.map(|(x, y)| value(x, y)).collect());
    Image { width, height, channels: 1, pixels }
}

fn by(scale: f64, midlevel: f64) -> Displacement {
    Displacement { image: ImageId(0), scale, midlevel }
}

fn refined(data: &MeshData, image: &Image, displacement: Displacement, edge_length: f64) -> MeshData {
    let displacement = Some((displacement, image));
    let refinement = Refinement { displacement, edge_length: Some(edge_length), curved: false, smooth: true };
    let mesh = refinement.apply(data, &Limits::default()).unwrap();
    mesh.check().unwrap();
    mesh
}

/// The square from 0 to 1 in x and y, facing +z, with (u, v) = (x, y).
fn square() -> MeshData {
    MeshData {
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
        uvs: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..MeshData::default()
    }
}

/// A cube from −1 to 1 with a square of (u, v) and, perhaps, a normal for each face.
fn cube(normals: bool) -> MeshData {
    let mut mesh = MeshData::default();
    for axis in 0..3 {
        for side in [-1.0f32, 1.0] {
            let first = mesh.positions.len() as u32;
            for (a, b) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                let mut p = [side; 3];
                (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (a * side, b);
                mesh.positions.push(p);
                mesh.uvs.push([0.5 * (a + 1.0), 0.5 * (b + 1.0)]);
                let mut n = [0.0; 3];
                n[axis] = side;
                mesh.normals.extend(normals.then_some(n));
            }
            let [a, b, c, d] = [0, 1, 2, 3].map(|i| first + i);
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

fn volume(mesh: &MeshData) -> f64 {
    let six = |[a, b, c]: &[u32; 3]| at(mesh, *a).dot(at(mesh, *b).cross(at(mesh, *c)));
    mesh.triangles.iter().map(six).sum::<f64>() / 6.0
}

#[test]
fn a_slope_is_a_slope() {
    // From 0 at the left to 1 at the right; beyond the centres of the outer pixels the image repeats.
    let slope = image(64, 1, |x, _| x as f32 / 63.0);
    let mesh = refined(&square(), &slope, by(0.5, 0.25), 0.02);
    let mut inner = 0;
    for (i, p) in mesh.positions.iter().enumerate() {
        let x = f64::from(p[0]);
        if !(0.05..0.95).contains(&x) {
            continue;
        }
        inner += 1;
        let height = 0.5 * ((x * 64.0 - 0.5) / 63.0 - 0.25);
        assert!((f64::from(p[2]) - height).abs() < 1e-6, "{p:?} {height}");
        let n = DVec3::from(mesh.normals[i].map(f64::from));
        assert!((n - DVec3::new(-0.5 * 64.0 / 63.0, 0.0, 1.0).normalize()).length() < 1e-5, "{n}");
        assert!((mesh.uvs[i][0] - p[0]).abs() < 1e-6 && (mesh.uvs[i][1] - p[1]).abs() < 1e-6);
    }
    assert!(inner > 3000, "{inner}");
}

#[test]
fn v_runs_up_the_image() {
    let halves = image(1, 64, |_, y| if y < 32 { 1.0 } else { 0.0 });
    let mesh = refined(&square(), &halves, by(1.0, 0.0), 0.1);
    let height = |y: f32| {
        let near = |p: &&[f32; 3]| (p[1] - y).abs() < 0.04;
        mesh.positions.iter().filter(near).map(|p| p[2]).fold(0.0, f32::max)
    };
    assert!(height(0.75) > 0.99 && height(0.25) < 0.01);
}

/// Hard edges and seams of the (u, v) do not tear a closed mesh, whatever the image says on both sides.
#[test]
fn closed_meshes_stay_closed() {
    let noise = image(16, 16, |x, y| ((x * 7 + y * 13 + x * y) % 11) as f32 / 10.0);
    for normals in [false, true] {
        for (scale, length) in [(0.2, 0.13), (1.5, 0.3), (-0.4, 0.21)] {
            let mesh = refined(&cube(normals), &noise, by(scale, 0.5), length);
            assert_eq!(open_edges(&mesh), 0, "{normals} {scale}");
            assert!(mesh.triangles.len() > 500);
        }
    }
}

/// Each point of a face moves along the normal of the face, those of an edge along the mean of both: a cube within 1 − h to
/// 1 + h, with the volume of the cube moved out by h but for its edges.
#[test]
fn hard_edges_stay_hard() {
    let one = image(1, 1, |_, _| 1.0);
    let mesh = refined(&cube(true), &one, by(0.25, 0.0), 0.1);
    let mut flat = 0;
    for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
        let p = DVec3::from(p.map(f64::from));
        let most = p.abs().max_element();
        assert!(most <= 1.25 + 1e-6 && most > 1.0, "{p}");
        let n = DVec3::from(n.map(f64::from)).abs().max_element();
        flat += usize::from((most - 1.25).abs() < 1e-6 && n > 1.0 - 1e-6);
    }
    assert!(flat * 2 > mesh.positions.len(), "{flat} of {}", mesh.positions.len());
    assert!((12.5..15.625).contains(&volume(&mesh)), "{}", volume(&mesh));
}

#[test]
fn edges_are_short_and_steep_places_get_more() {
    let step = image(64, 1, |x, _| if (16..48).contains(&x) { 1.0 } else { 0.0 });
    let (length, scale) = (0.05, 0.5);
    let mesh = refined(&square(), &step, by(scale, 0.0), length);
    let flat = |v: u32| DVec3::new(at(&mesh, v).x, at(&mesh, v).y, 0.0);
    for [a, b, c] in &mesh.triangles {
        for (a, b) in [(*a, *b), (*b, *c), (*c, *a)] {
            let short = (flat(a) - flat(b)).length() <= length / 8.0 * 1.001;
            assert!(short || (at(&mesh, a) - at(&mesh, b)).length() <= length * 1.0001);
        }
    }
    let within = |low: f64, high: f64| {
        mesh.triangles.iter().filter(|t| t.iter().all(|v| (low..high).contains(&at(&mesh, *v).x))).count()
    };
    assert!(within(0.2, 0.3) > 10 * within(0.4, 0.5), "{} {}", within(0.2, 0.3), within(0.4, 0.5));
}

#[test]
fn divided_subdivision_surfaces_stay_smooth() {
    let scheme = SubdivisionScheme::CatmullClark;
    let cage = MeshData { polygons: vec![2; 6], ..cube(false) };
    let limits = Limits::default();
    let of = |levels: u32| subdivide(&cage, &Subdivision::new(scheme, levels), &limits).unwrap().mesh;
    let fine = volume(&of(6));
    let coarse = of(2);
    let divided = |curved: bool| {
        let refinement = Refinement { displacement: None, edge_length: Some(0.05), curved, smooth: true };
        refinement.apply(&coarse, &limits).unwrap()
    };
    let (curved, straight) = (divided(true), divided(false));
    assert_eq!(open_edges(&curved), 0);
    assert!((volume(&straight) - volume(&coarse)).abs() < 1e-5);
    let (error, before) = ((volume(&curved) - fine).abs(), (volume(&coarse) - fine).abs());
    assert!(error < 0.05 * before, "{error} {before} of {fine}");
}

#[test]
fn colors_materials_and_sets_of_uv_are_kept() {
    let mut data = square();
    data.colors = data.uvs.iter().map(|[u, v]| [*u, *v, 0.5, 1.0]).collect();
    data.more_uvs = vec![data.uvs.iter().map(|[u, v]| [2.0 * u, 3.0 * v]).collect()];
    data.face_materials = vec![4, 7];
    let mesh = refined(&data, &image(1, 1, |_, _| 0.0), by(1.0, 0.0), 0.11);
    for (i, p) in mesh.positions.iter().enumerate() {
        assert!((mesh.colors[i][0] - p[0]).abs() < 1e-6 && (mesh.colors[i][1] - p[1]).abs() < 1e-6);
        assert!((mesh.more_uvs[0][i][1] - 3.0 * p[1]).abs() < 1e-5);
    }
    for (triangle, material) in mesh.triangles.iter().zip(&mesh.face_materials) {
        let middle: DVec3 = triangle.iter().map(|v| at(&mesh, *v)).sum();
        assert_eq!(*material, if middle.x > middle.y { 4 } else { 7 });
    }
}

#[test]
fn what_cannot_be_done_is_said() {
    let white = image(1, 1, |_, _| 1.0);
    let bare = MeshData { uvs: Vec::new(), ..square() };
    let with = |edge_length, limits: &Limits, data: &MeshData| {
        let displacement = Some((by(1.0, 0.0), &white));
        Refinement { displacement, edge_length, curved: false, smooth: true }.apply(data, limits)
    };
    assert!(with(None, &Limits::default(), &bare).unwrap_err().message.contains("(u, v)"));
    let few = Limits { max_triangles: 10_000, ..Limits::default() };
    let error = with(Some(1e-3), &few, &square()).unwrap_err();
    assert!(error.help.is_some_and(|help| help.contains("edge_length")), "{}", error.message);
    // Nothing to divide, and nothing finite.
    assert_eq!(with(None, &Limits::default(), &MeshData::default()).unwrap().triangles.len(), 0);
    let mut broken = square();
    broken.positions[1] = [f32::NAN, 0.0, f32::INFINITY];
    assert!(with(Some(0.5), &Limits::default(), &broken).is_ok());
    broken.positions = vec![[1.0; 3]; 4];
    assert_eq!(with(None, &Limits::default(), &broken).unwrap().triangles.len(), 2);
}
