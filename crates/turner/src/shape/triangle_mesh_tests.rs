use std::collections::HashMap;
use std::sync::Arc;

use super::*;
use crate::image::Image;
use crate::scene::value::{Data, FileId, Span, Table, Value};
use crate::scene::{Asset, MeshId, SceneAssets, SceneDesc, read_scene};
use crate::shape::mesh::{MeshCache, MeshDesc};
use crate::shape::testing::Random;

/// A sphere of radius 1 about the origin: an icosahedron, each triangle divided in four `levels` times.
fn icosphere(levels: u32) -> MeshData {
    let g = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut points: Vec<DVec3> = Vec::new();
    for i in 0..3 {
        for (a, b) in [(-1.0, -g), (-1.0, g), (1.0, -g), (1.0, g)] {
            let mut p = DVec3::ZERO;
            (p[i], p[(i + 1) % 3]) = (a, b);
            points.push(p.normalize());
        }
    }
    // Faces: triples of mutually nearest points, turned outwards.
    let side = points.iter().map(|p| p.distance(points[0])).filter(|&d| d > 0.1).fold(9.0, f64::min);
    let near = |a: usize, b: usize| (points[a].distance(points[b]) - side).abs() < 1e-6;
    let mut triangles = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(a, c) {
                    let out = (points[b] - points[a]).cross(points[c] - points[a]).dot(points[a]) > 0.0;
                    triangles.push(if out {
                        [a as u32, b as u32, c as u32]
                    } else {
                        [a as u32, c as u32, b as u32]
                    });
                }
            }
        }
    }
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]).normalize());
                points.len() as u32 - 1
            })
        };
        triangles = triangles
            .into_iter()
            .flat_map(|[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    let positions = points.iter().map(|p| p.as_vec3().to_array()).collect();
    MeshData { positions, triangles, ..MeshData::default() }
}

fn brute(data: &MeshData, ray: &Ray) -> Option<ShapeHit> {
    let shear = RayShear::new(ray);
    let mut best: Option<ShapeHit> = None;
    for (part, t) in (0..).zip(&data.triangles) {
        let Some(hit) = shear.triangle(&t.map(|i| data.positions[i as usize])) else { continue };
        if ray.contains(hit.t) && best.is_none_or(|b| hit.t < b.t) {
            best = Some(ShapeHit { t: hit.t, part, u: hit.u, v: hit.v });
        }
    }
    best
}

#[test]
fn nothing_leaks_through_edges_and_vertices() {
    let data = icosphere(3);
    let (mesh, left_out) = TriangleMesh::build(&data, false).unwrap();
    assert_eq!((mesh.triangle_count(), left_out), (1280, LeftOut::default()));
    let mut random = Random::new(5);
    for i in 0..1_000_000_u32 {
        let t = data.triangles[(random.unit() * 1280.0) as usize];
        let [a, b, _] = t.map(|i| wide(data.positions[i as usize]));
        let target = if i % 2 == 0 { a } else { a + random.unit() * (b - a) };
        // From inside every ray must hit; from outside one aimed at an edge must not pass both sides.
        let origin = 0.5 * random.in_cube();
        let ray = if i % 3 == 0 {
            Ray { t_max: 1.0 + 1e-9, ..Ray::new(target * 1e3, target * -1e3) }
        } else {
            Ray::new(origin, target - origin)
        };
        let hit = mesh.intersect(&ray).is_some();
        assert!(hit, "{ray:?}");
        if i % 16 == 0 {
            assert!(mesh.occludes(&ray));
        }
    }
}

#[test]
fn the_tree_finds_what_brute_force_finds() {
    let mut random = Random::new(6);
    for (scale, offset) in [(1.0, 0.0), (1e-6, 0.0), (1e6, 0.0), (1.0, 1e4), (1e3, 1e6)] {
        let mut data = icosphere(2);
        let middle = DVec3::new(offset, -offset, 0.5 * offset);
        for p in &mut data.positions {
            *p = (wide(*p) * scale + middle).as_vec3().to_array();
        }
        let (mesh, _) = TriangleMesh::build(&data, false).unwrap();
        let mut hits = 0;
        for i in 0..2500 {
            let origin = middle + scale * [0.3, 3.0, 1e7][i % 3] * random.direction();
            let t = data.triangles[i % data.triangles.len()];
            let target = if i % 2 == 0 {
                wide(data.positions[t[0] as usize])
            } else {
                middle + scale * 1.1 * random.in_cube()
            };
            let ray = Ray::new(origin, (target - origin) * (0.1 + random.unit()));
            let expected = brute(&data, &ray);
            let found = mesh.intersect(&ray);
            assert_eq!(found, expected, "{ray:?}");
            assert_eq!(mesh.occludes(&ray), expected.is_some());
            let Some(hit) = found else { continue };
            hits += 1;
            for range in
                [(0.0, hit.t), (hit.t, f64::INFINITY), (hit.t, hit.t), (hit.t * 1.000_001, f64::INFINITY)]
            {
                let ray = Ray { t_min: range.0, t_max: range.1, ..ray };
                assert_eq!(mesh.intersect(&ray), brute(&data, &ray), "{ray:?}");
            }
            let s = mesh.surface(&hit);
            let v = data.triangles[hit.part as usize].map(|i| wide(data.positions[i as usize]));
            assert!((s.p - v[0]).dot(s.ng).abs() <= s.error && (s.ng.length() - 1.0).abs() < 1e-14);
            assert!(s.p.distance(ray.at(hit.t)) < 1e-6 * scale + 1e-8 * offset);
            let b = mesh.bounds();
            assert!(s.p.cmpge(b.min - s.error).all() && s.p.cmple(b.max + s.error).all());
        }
        assert!(hits > 1000, "{hits}");
    }
}

#[test]
fn broken_rays_hit_nothing() {
    let (mesh, _) = TriangleMesh::build(&icosphere(1), false).unwrap();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for axis in 0..3 {
            let mut ray = Ray::new(DVec3::splat(0.1), DVec3::ONE);
            ray.origin[axis] = bad;
            assert!(mesh.intersect(&ray).is_none() && !mesh.occludes(&ray));
            let mut ray = Ray::new(DVec3::splat(0.1), DVec3::ONE);
            ray.direction[axis] = bad;
            assert!(mesh.intersect(&ray).is_none() && !mesh.occludes(&ray));
        }
    }
    assert!(mesh.intersect(&Ray::new(DVec3::ZERO, DVec3::ZERO)).is_none());
    let empty = TriangleMesh::build(&MeshData::default(), true).unwrap().0;
    assert!(empty.bounds().is_empty() && empty.intersect(&Ray::new(DVec3::ZERO, DVec3::X)).is_none());
}

#[test]
fn smooth_normals_follow_the_sphere_and_keep_their_side() {
    let mut data = icosphere(3);
    let (smooth, _) = TriangleMesh::build(&data, true).unwrap();
    let (flat, _) = TriangleMesh::build(&data, false).unwrap();
    for n in &mut data.positions {
        *n = n.map(|x| -x);
    }
    data.normals = data.positions.clone();
    for n in &mut data.positions {
        *n = n.map(|x| -x);
    }
    // Normals of the file that point inwards.
    let (inward, _) = TriangleMesh::build(&data, true).unwrap();
    let mut random = Random::new(7);
    for _ in 0..1000 {
        let ray = Ray::new(DVec3::ZERO, random.direction());
        let hit = smooth.intersect(&ray).unwrap();
        let s = smooth.surface(&hit);
        assert!(s.ns.dot(ray.direction) > 0.9999 && s.ng.dot(ray.direction) > 0.98);
        assert_eq!(flat.surface(&hit).ns, flat.surface(&hit).ng);
        let inward = inward.surface(&hit);
        assert!(inward.ns.dot(inward.ng) > 0.9);
    }
    // 1,280 triangles, 642 vertices.
    assert!(flat.memory() < 1280 * 108 + 1000, "{}", flat.memory() / 1280);
}

#[test]
fn uvs_are_interpolated() {
    let mut data = MeshData {
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        ..MeshData::default()
    };
    let ray = Ray::new(DVec3::new(0.25, 0.5, 1.0), DVec3::NEG_Z);
    let uv = |data: &MeshData| {
        let mesh = TriangleMesh::build(data, false).unwrap().0;
        mesh.uv(&mesh.intersect(&ray).unwrap())
    };
    assert_eq!(uv(&data), DVec2::new(0.25, 0.5));
    data.uvs = vec![[2.0, 0.0], [6.0, 0.0], [2.0, 1.0]];
    assert_eq!(uv(&data), DVec2::new(3.0, 0.5));
}

/// Reads one `[[object]]` made of these keys.
fn read_object(keys: &[(&str, Data)]) -> Result<SceneDesc, SceneError> {
    struct NoFiles;
    impl SceneAssets for NoFiles {
        fn image(&mut self, _: &str, _: FileId) -> Result<Arc<Image>, SceneError> {
            unreachable!()
        }
        fn mesh(&mut self, uri: &str, _: FileId) -> Result<Arc<MeshData>, SceneError> {
            assert_eq!(uri, "ball.ply");
            Ok(Arc::new(icosphere(0)))
        }
    }
    let span = Span { file: FileId(0), start: 0, end: 0 };
    let mut object = Table::default();
    for (key, data) in keys {
        object.set(key, span, Value { data: data.clone(), span });
    }
    let value = |data| Value { data, span };
    let mut root = Table::default();
    root.set("object", span, value(Data::Array(vec![value(Data::Table(object))])));
    read_scene(&value(Data::Table(root)), &mut NoFiles)
}

/// Nested lists of numbers.
fn rows(rows: &[[i64; 3]]) -> Data {
    let span = Span { file: FileId(0), start: 0, end: 0 };
    let row = |r: &[i64; 3]| Data::Array(r.map(|x| Value { data: Data::Integer(x), span }).to_vec());
    Data::Array(rows.iter().map(|r| Value { data: row(r), span }).collect())
}

#[test]
fn meshes_are_read_from_files_or_in_place() {
    let kind = ("type", Data::String("mesh".into()));
    let file = ("file", Data::String("ball.ply".into()));
    let positions = ("positions", rows(&[[0, 0, 0], [1, 0, 0], [0, 1, 0]]));
    let triangles = ("triangles", rows(&[[0, 1, 2]]));
    let scene = read_object(&[kind.clone(), file.clone()]).unwrap();
    assert_eq!((scene.meshes[0].uri.as_str(), scene.meshes[0].data.triangles.len()), ("ball.ply", 20));
    let scene = read_object(&[kind.clone(), positions.clone(), triangles.clone()]).unwrap();
    assert_eq!(scene.meshes[0].data.positions[1], [1.0, 0.0, 0.0]);
    let mut cache = MeshCache::new(&scene.meshes);
    let crate::scene::ObjectContent::Shape(shape) = &scene.objects[0].content else { panic!("a shape") };
    assert!(matches!(shape.prepare(&mut cache), Ok(crate::shape::Shape::Mesh(_))));
    let code = |keys: &[(&str, Data)]| read_object(keys).unwrap_err().code;
    assert_eq!(code(&[kind.clone(), file, positions.clone()]), ErrorCode::Conflict);
    assert_eq!(code(&[kind.clone(), positions.clone()]), ErrorCode::MissingKey);
    assert_eq!(code(&[kind.clone(), positions, ("triangles", rows(&[[0, 1, 3]]))]), ErrorCode::Mesh);
    assert_eq!(code(&[kind, ("fil", Data::Bool(true)), triangles]), ErrorCode::MissingKey);
}

#[test]
fn bad_data_is_refused_or_counted_and_meshes_are_shared() {
    let mut data = MeshData {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [f32::NAN; 3]],
        triangles: vec![[0, 1, 2], [0, 1, 1], [0, 1, 3]],
        ..MeshData::default()
    };
    let asset = |data: &MeshData| [Asset { uri: "a.obj".into(), data: Arc::new(data.clone()) }];
    let assets = asset(&data);
    let mut cache = MeshCache::new(&assets);
    let desc = MeshDesc { mesh: MeshId(0), smooth: None };
    let a = cache.get(&desc).unwrap();
    let b = cache.get(&MeshDesc { smooth: Some(false), ..desc.clone() }).unwrap();
    let c = cache.get(&MeshDesc { smooth: Some(true), ..desc.clone() }).unwrap();
    assert!(Arc::ptr_eq(&a, &b) && !Arc::ptr_eq(&a, &c));
    assert_eq!(a.triangle_count(), 1);
    assert_eq!(
        cache.warnings,
        [
            "1 triangles with a vertex that is not finite left out of the mesh \"a.obj\"",
            "1 triangles without area left out of the mesh \"a.obj\""
        ]
    );
    assert!(cache.get(&MeshDesc { mesh: MeshId(1), smooth: None }).is_err());
    data.triangles.push([0, 1, 4]);
    let error = data.check().unwrap_err();
    assert_eq!(error.message, "triangle 3 of a mesh names vertex 4, but it has 4 vertices");
    data.triangles.pop();
    data.uvs = vec![[0.0; 2]; 3];
    assert_eq!(data.check().unwrap_err().message, "3 uvs for 4 vertices of a mesh");
}
