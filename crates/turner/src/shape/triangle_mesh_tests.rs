use std::collections::HashMap;
use std::sync::Arc;

use turner_bvh::RayBlock;
use turner_bvh::lanes::LANES;

use super::*;
use crate::description::{ModelDesc, SceneAssets, SceneDesc, read_scene};
use crate::image::Image;
use crate::schema::value::{Data, FileId, Span, Table, Value};
use crate::schema::{Asset, MeshId};
use crate::shape::testing::Random;
use crate::shape::{BlockRays, MeshCache, MeshDesc, MeshRays, NO_TRIANGLE};

/// A unit sphere around the origin: an icosahedron whose triangles are divided in four `levels` times.
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
    // Faces: triples of nearest neighbours, oriented outwards.
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
        let mut midpoints = HashMap::new();
        let mut center = |a: u32, b: u32| {
            *midpoints.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]).normalize());
                points.len() as u32 - 1
            })
        };
        triangles = triangles
            .into_iter()
            .flat_map(|[a, b, c]| {
                let (ab, bc, ca) = (center(a, b), center(b, c), center(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    let positions = points.iter().map(|p| p.as_vec3().to_array()).collect();
    MeshData { positions, triangles, ..MeshData::default() }
}

fn build(data: &MeshData, smooth: bool) -> (TriangleMesh, SkippedTriangles) {
    TriangleMesh::build(&Arc::new(data.clone()), smooth, &PrepareOptions::default()).unwrap()
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
    let (mesh, skipped) = build(&data, false);
    assert_eq!((mesh.triangle_count(), skipped), (1280, SkippedTriangles::default()));
    let mut random = Random::new(5);
    for i in 0..1_000_000_u32 {
        let t = data.triangles[(random.unit() * 1280.0) as usize];
        let [a, b, _] = t.map(|i| wide(data.positions[i as usize]));
        let target = if i % 2 == 0 { a } else { a + random.unit() * (b - a) };
        // Every ray from inside must hit; a ray from outside aimed at an edge must not pass between its two triangles.
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
        let center = DVec3::new(offset, -offset, 0.5 * offset);
        for p in &mut data.positions {
            *p = (wide(*p) * scale + center).as_vec3().to_array();
        }
        let (mesh, _) = build(&data, false);
        let (mut hits, mut equal, mut unlike) = (0, 0, 0);
        for i in 0..2500 {
            let distance = scale * [0.3, 3.0, 1e7][i % 3];
            let origin = center + distance * random.direction();
            let t = data.triangles[i % data.triangles.len()];
            let target = if i % 2 == 0 {
                wide(data.positions[t[0] as usize])
            } else {
                center + scale * 1.1 * random.in_cube()
            };
            let ray = Ray::new(origin, (target - origin) * (0.1 + random.unit()));
            let expected = brute(&data, &ray);
            let found = mesh.intersect(&ray);
            // A ray aimed at a vertex hits one of the triangles around it. Other rays hit the same triangle bit for
            // bit, unless they pass an edge within the precision of the search.
            let length = ray.direction.length();
            let same = |a: Option<ShapeHit>, b: Option<ShapeHit>| match (a, b) {
                (Some(a), Some(b)) => a == b || (a.t - b.t).abs() * length < 1e-5 * scale + 1e-15 * distance,
                (None, None) => true,
                _ => i % 2 == 0,
            };
            assert!(same(found, expected), "{ray:?} {found:?} {expected:?}");
            equal += usize::from(found == expected);
            assert_eq!(mesh.occludes(&ray), found.is_some(), "{ray:?} {found:?}");
            let Some(hit) = found else { continue };
            hits += 1;
            for range in
                [(0.0, hit.t), (hit.t, f64::INFINITY), (hit.t, hit.t), (hit.t * 1.000_001, f64::INFINITY)]
            {
                let ray = Ray { t_min: range.0, t_max: range.1, ..ray };
                let again = mesh.intersect(&ray);
                if range.0 <= hit.t {
                    // The second search starts elsewhere and may choose another triangle around the vertex.
                    unlike += usize::from(i % 2 == 1 && !same(again, Some(hit)));
                } else {
                    assert!(again.is_none_or(|h| h.t >= range.0), "{ray:?}");
                }
                assert!(mesh.occludes(&ray) || again.is_none(), "{ray:?}");
            }
            let s = mesh.surface(&hit);
            let v = data.triangles[hit.part as usize].map(|i| wide(data.positions[i as usize]));
            assert!((s.p - v[0]).dot(s.ng).abs() <= s.error && (s.ng.length() - 1.0).abs() < 1e-14);
            assert!(s.p.distance(ray.at(hit.t)) < 1e-6 * scale + 1e-8 * offset);
            let b = mesh.bounds();
            assert!(s.p.cmpge(b.min - s.error).all() && s.p.cmple(b.max + s.error).all());
        }
        assert!(hits > 1000 && equal > 1700 && unlike < 3, "{hits} {equal} {unlike}");
    }
}

#[test]
fn broken_rays_hit_nothing() {
    let (mesh, _) = build(&icosphere(1), false);
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
    let empty = build(&MeshData::default(), true).0;
    assert!(empty.bounds().is_empty() && empty.intersect(&Ray::new(DVec3::ZERO, DVec3::X)).is_none());
}

#[test]
fn smooth_normals_follow_the_sphere_and_keep_their_side() {
    let mut data = icosphere(3);
    let (smooth, _) = build(&data, true);
    let (flat, _) = build(&data, false);
    for n in &mut data.positions {
        *n = n.map(|x| -x);
    }
    data.normals = data.positions.clone();
    for n in &mut data.positions {
        *n = n.map(|x| -x);
    }
    // The file's normals point inwards.
    let (inward, _) = build(&data, true);
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
    assert!(flat.tree_bytes() < 1280 * 70, "{}", flat.tree_bytes() / 1280);
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
        let mesh = build(data, false).0;
        mesh.uv(&mesh.intersect(&ray).unwrap())
    };
    assert_eq!(uv(&data), DVec2::new(0.25, 0.5));
    data.uvs = vec![[2.0, 0.0], [6.0, 0.0], [2.0, 1.0]];
    assert_eq!(uv(&data), DVec2::new(3.0, 0.5));
}

/// Reads one `[[object]]` with these keys.
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
        fn model(&mut self, model: &ModelDesc, _: FileId) -> Result<Arc<SceneDesc>, SceneError> {
            Err(SceneError::new(ErrorCode::File, model.file.as_str()))
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

/// Nested lists of integers.
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
    let crate::description::ObjectContent::Shape(shape) = &scene.objects[0].content else {
        panic!("a shape")
    };
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
    let desc = MeshDesc { mesh: MeshId(0), ..MeshDesc::default() };
    let a = cache.get(&desc).unwrap();
    let b = cache.get(&MeshDesc { smooth: Some(false), ..desc.clone() }).unwrap();
    let c = cache.get(&MeshDesc { smooth: Some(true), ..desc.clone() }).unwrap();
    assert!(Arc::ptr_eq(&a, &b) && !Arc::ptr_eq(&a, &c));
    assert_eq!(a.triangle_count(), 1);
    assert_eq!(
        cache.warnings(),
        [
            "1 triangle with a vertex that is not finite omitted from the mesh \"a.obj\"",
            "1 triangle without area omitted from the mesh \"a.obj\""
        ]
    );
    assert!(cache.get(&MeshDesc { mesh: MeshId(1), ..desc.clone() }).is_err());
    let twice = [asset(&data), asset(&data)].concat();
    let mut cache = MeshCache::new(&twice);
    for mesh in [MeshId(0), MeshId(1)] {
        cache.get(&MeshDesc { mesh, ..desc.clone() }).unwrap();
    }
    let flat = "2 triangles without area omitted from 2 meshes, the first of them the mesh \"a.obj\"";
    assert_eq!(cache.warnings()[1], flat);
    data.triangles.push([0, 1, 4]);
    let error = data.check().unwrap_err();
    assert_eq!(error.message, "triangle 3 of a mesh names vertex 4, but it has 4 vertices");
    data.triangles.pop();
    data.uvs = vec![[0.0; 2]; 3];
    assert_eq!(data.check().unwrap_err().message, "3 uvs for 4 vertices of a mesh");
}

/// A height field: a grid of squares with uneven heights.
fn terrain(cells: u32) -> MeshData {
    let mut random = Random::new(9);
    let side = cells + 1;
    let mut data = MeshData::default();
    for i in 0..side * side {
        let [x, z] = [i % side, i / side].map(|n| 2.0 * n as f32 / cells as f32 - 1.0);
        let y = 0.2 * (5.0 * f64::from(x) + 3.0 * f64::from(z)).fract().abs() + 0.01 * random.unit();
        data.positions.push([x, y as f32, z]);
    }
    for j in 0..cells {
        for i in 0..cells {
            let a = j * side + i;
            data.triangles.extend([[a, a + side, a + 1], [a + 1, a + side, a + side + 1]]);
        }
    }
    data
}

/// Rays that leave a surface, most of them at grazing angles, must not hit the triangle they leave. On a convex
/// surface they must hit nothing.
fn leaving(data: &MeshData, center: DVec3, size: f64, convex: bool, rays: u32) {
    let (mesh, _) = build(data, false);
    let mut random = Random::new(10);
    let (mut own, mut others, mut left) = (0, 0, 0);
    while left < rays {
        let origin =
            center + size * if convex { 3.0 * random.direction() } else { DVec3::new(0.0, 2.0, 0.0) };
        let t = data.triangles[(random.unit() * data.triangles.len() as f64) as usize];
        let [a, b, c] = t.map(|i| wide(data.positions[i as usize]));
        let (u, v) = (random.unit(), random.unit());
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        // Some points lie on edges and vertices.
        let target = match left % 8 {
            0 => a + u * (b - a),
            1 => a,
            _ => a + u * (b - a) + v * (c - a),
        };
        let Some(hit) = mesh.intersect(&Ray::new(origin, target - origin)) else {
            left += 1;
            continue;
        };
        let s = mesh.surface(&hit);
        let back = s.ng.dot(target - origin) > 0.0;
        if convex && back {
            // At a vertex of the silhouette; behind it is the inside.
            left += 1;
            continue;
        }
        let ng = if back { -s.ng } else { s.ng };
        for _ in 0..4 {
            let flat = s.ng.cross(random.direction()).normalize();
            let steep = [1e-6, 1e-4, 1e-2, 1.0][left as usize % 4] * random.unit().max(1e-3);
            let direction = (flat + steep * ng).normalize();
            let p = s.p + ng * (4.0 * s.error);
            let found = mesh.intersect(&Ray::new(p, direction));
            own += u32::from(found.is_some_and(|h| h.part == hit.part));
            others += u32::from(found.is_some());
            left += 1;
        }
    }
    assert_eq!(own, 0, "of {left}, {others} hit another");
    assert!(!convex || others == 0, "{others} of {left}");
}

#[test]
fn rays_do_not_hit_the_surface_they_leave() {
    let rays = if cfg!(debug_assertions) { 20_000 } else { 1_000_000 };
    leaving(&icosphere(4), DVec3::ZERO, 1.0, true, rays);
    leaving(&terrain(100), DVec3::ZERO, 1.0, false, rays);
    let sizes = [(1e-6, 0.0), (1e6, 0.0), (1.0, 1e5), (1e-3, 1.0), (100.0, 1e5)];
    for (size, offset) in sizes {
        let center = DVec3::new(offset, -0.5 * offset, 2.0 * offset);
        let mut data = icosphere(2);
        for p in &mut data.positions {
            *p = (wide(*p) * size + center).as_vec3().to_array();
        }
        // Rounded to the coarser f32 grid far from 0, a sphere has dents.
        leaving(&data, center, size, offset == 0.0, rays / 5);
    }
}

#[test]
fn far_from_its_origin_a_mesh_loses_nothing_more() {
    let mut data = icosphere(3);
    // Multiples of 1/64, which f32 represents exactly at 1e5.
    for p in &mut data.positions {
        *p = p.map(|x| (x * 6400.0).round() / 64.0);
    }
    let (near, _) = build(&data, false);
    let center = DVec3::new(100_000.0, -50_000.0, 70_000.0);
    for p in &mut data.positions {
        *p = (wide(*p) + center).as_vec3().to_array();
    }
    let (far, _) = build(&data, false);
    let mut random = Random::new(11);
    for _ in 0..10_000 {
        let origin = 300.0 * random.direction();
        let direction = 90.0 * random.in_cube() - origin;
        let (a, b) = (
            near.intersect(&Ray::new(origin, direction)),
            far.intersect(&Ray::new(origin + center, direction)),
        );
        assert_eq!(a.is_some(), b.is_some());
        if let (Some(a), Some(b)) = (a, b) {
            assert!(a.part == b.part && (a.t - b.t).abs() < 1e-11, "{a:?} {b:?}");
        }
    }
}

#[test]
fn batches_find_what_single_rays_find() {
    let data = terrain(60);
    let (mesh, _) = build(&data, false);
    let mut random = Random::new(12);
    let rays: Vec<Ray> = (0..5000)
        .map(|i| {
            let origin = 2.0 * random.in_cube();
            let t = data.triangles[i % data.triangles.len()];
            let target = if i % 3 == 0 { wide(data.positions[t[0] as usize]) } else { random.in_cube() };
            let ray = Ray::new(origin, target - origin);
            match i % 5 {
                0 => Ray { t_max: 1.0, ..ray },
                1 => Ray { t_min: 0.9, ..ray },
                2 => Ray { direction: DVec3::ZERO, ..ray },
                _ => ray,
            }
        })
        .collect();
    let mut scratch = MeshRays::default();
    for count in [0, 1, 63, 64, 65, 5000] {
        let (mut hits, mut occluded) = (vec![None; count], vec![false; count]);
        let mut blocks = vec![RayBlock::NOTHING; count.div_ceil(LANES)];
        for (i, r) in rays[..count].iter().enumerate() {
            let (o, d) = (r.origin.to_array(), r.direction.to_array());
            blocks[i / LANES].set(i % LANES, o, d, r.t_min, r.t_max);
        }
        let ends: Vec<_> = blocks.iter().map(|b| b.t_max).collect();
        let asked =
            BlockRays { offset: DVec3::ZERO, blocks: &blocks, ends: &ends, skipped: |_| [NO_TRIANGLE; 2] };
        mesh.intersect_blocks(&asked, &mut scratch, |i, hit| hits[i] = Some(hit));
        mesh.occluded_blocks(&asked, &mut scratch, |i| occluded[i] = true);
        for ((ray, hit), occluded) in rays.iter().zip(hits).zip(occluded) {
            assert_eq!(hit, mesh.intersect(ray));
            assert_eq!(occluded, mesh.occludes(ray));
        }
    }
}

#[test]
fn vertex_attributes_are_interpolated() {
    let mut data = MeshData {
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        ..MeshData::default()
    };
    let hit = ShapeHit { t: 1.0, part: 0, u: 0.25, v: 0.5 };
    let (mesh, _) = build(&data, false);
    assert_eq!((mesh.color(&hit), mesh.tangent(&hit), mesh.face_material(0)), (None, None, 0));
    data.colors = vec![[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0]];
    data.tangents = vec![[2.0, 0.0, 0.0, -1.0]; 3];
    data.uvs = vec![[0.0; 2]; 3];
    data.more_uvs = vec![vec![[0.0; 2], [4.0, 0.0], [0.0, 2.0]]];
    data.face_materials = vec![3];
    let (mesh, _) = build(&data, false);
    assert_eq!(mesh.color(&hit), Some([0.25, 0.25, 0.5, 0.75]));
    assert_eq!(mesh.tangent(&hit), Some((DVec3::X, -1.0)));
    assert_eq!(mesh.uv_set(&hit, 1), DVec2::new(1.0, 1.0));
    assert_eq!(mesh.uv_set(&hit, 2), DVec2::ZERO);
    assert_eq!((mesh.face_material(0), data.material_count()), (3, 4));
    data.face_materials.push(0);
    assert_eq!(data.check().unwrap_err().message, "2 materials for 1 triangles of a mesh");
    data.face_materials.clear();
    data.more_uvs[0].pop();
    assert_eq!(data.check().unwrap_err().message, "2 uvs for 3 vertices of a mesh");
}
