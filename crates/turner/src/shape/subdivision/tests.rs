//! Subdivision: closed forms of limits, creases, and meshes that are no surfaces.

use super::*;
use crate::math::DVec3;
use crate::shape::solid::csg::open_edges;

use SubdivisionScheme::{CatmullClark, Loop};

/// A mesh of polygons, with (u, v) like x and y.
fn mesh(points: &[[f64; 3]], polygons: &[&[u32]]) -> MeshData {
    let fans = polygons.iter().flat_map(|p| (1..p.len() - 1).map(|i| [p[0], p[i], p[i + 1]]));
    MeshData {
        positions: points.iter().map(|p| p.map(|v| v as f32)).collect(),
        uvs: points.iter().map(|p| [p[0] as f32, p[1] as f32]).collect(),
        triangles: fans.collect(),
        polygons: polygons.iter().map(|p| p.len() as u32 - 2).collect(),
        ..MeshData::default()
    }
}

/// The cube of edges 2 around the origin.
fn cube() -> MeshData {
    let corner = |i: u32| [0, 1, 2].map(|k| if i >> k & 1 == 1 { 1.0 } else { -1.0 });
    let points: Vec<[f64; 3]> = (0..8).map(corner).collect();
    let faces: [&[u32]; 6] =
        [&[0, 2, 3, 1], &[4, 5, 7, 6], &[0, 1, 5, 4], &[2, 6, 7, 3], &[0, 4, 6, 2], &[1, 3, 7, 5]];
    mesh(&points, &faces)
}

fn tetrahedron() -> MeshData {
    let points = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    mesh(&points, &[&[0, 1, 2], &[0, 3, 1], &[0, 2, 3], &[1, 3, 2]])
}

/// A grid of n by n cells over the unit square, of quadrilaterals or triangles.
fn grid(n: u32, height: impl Fn(f64, f64) -> f64, triangles: bool) -> MeshData {
    let side = |i: u32| f64::from(i) / f64::from(n);
    let points: Vec<[f64; 3]> = (0..=n)
        .flat_map(|y| (0..=n).map(move |x| (side(x), side(y))))
        .map(|(x, y)| [x, y, height(x, y)])
        .collect();
    let mut polygons: Vec<Vec<u32>> = Vec::new();
    for (x, y) in (0..n).flat_map(|y| (0..n).map(move |x| (x, y))) {
        let a = y * (n + 1) + x;
        let [b, c, d] = [a + 1, a + n + 2, a + n + 1];
        match triangles {
            true => polygons.extend([vec![a, b, c], vec![a, c, d]]),
            false => polygons.push(vec![a, b, c, d]),
        }
    }
    let lists: Vec<&[u32]> = polygons.iter().map(Vec::as_slice).collect();
    mesh(&points, &lists)
}

fn run(data: &MeshData, by: &Subdivision) -> MeshData {
    let made = subdivide(data, by, &Limits::default()).unwrap();
    made.mesh.check().unwrap();
    assert!(made.mesh.normals.iter().all(|n| (at(*n).length() - 1.0).abs() < 1e-6));
    made.mesh
}

fn plain(data: &MeshData, scheme: SubdivisionScheme, levels: u32) -> MeshData {
    run(data, &Subdivision::new(scheme, levels))
}

fn at(p: [f32; 3]) -> DVec3 {
    DVec3::from(p.map(f64::from))
}

fn has(mesh: &MeshData, p: DVec3) -> bool {
    mesh.positions.iter().any(|q| (at(*q) - p).length() < 1e-6)
}

/// The number of distinct positions.
fn distinct(mesh: &MeshData) -> usize {
    let set: std::collections::BTreeSet<_> =
        mesh.positions.iter().map(|p| p.map(|v| (v + 0.0).to_bits())).collect();
    set.len()
}

fn volume(mesh: &MeshData) -> f64 {
    let six = |[a, b, c]: [u32; 3]| {
        let [a, b, c] = [a, b, c].map(|i| at(mesh.positions[i as usize]));
        a.dot(b.cross(c))
    };
    mesh.triangles.iter().map(|t| six(*t)).sum::<f64>() / 6.0
}

#[test]
fn the_limit_of_a_cube() {
    let (one, four) = (plain(&cube(), CatmullClark, 1), plain(&cube(), CatmullClark, 4));
    // By hand: the first level has face vertices at 1, edge vertices at 3/4 and corners at 5/9. The limit stencil of
    // n = 3 is (9 v + 4 Σe + Σf) / 24, of n = 4 it is (16 v + 4 Σe + Σf) / 36.
    let corner = (9.0 * 5.0 / 9.0 + 4.0 * 1.5 + 1.0) / 24.0;
    let face = (16.0 + 4.0 * 4.0 * 0.75 + 4.0 * 5.0 / 9.0) / 36.0;
    for made in [&one, &four] {
        assert_eq!(open_edges(made), 0);
        assert!(has(made, DVec3::splat(corner)), "the limit does not depend on the levels");
        assert!(has(made, DVec3::new(0.0, 0.0, face)) && has(made, DVec3::new(-face, 0.0, 0.0)));
        // Euler's characteristic of a sphere: V − E + F with E = 3/2 F.
        assert_eq!(distinct(made) as i64 - made.triangles.len() as i64 / 2, 2);
    }
    assert_eq!((one.triangles.len(), four.triangles.len()), (48, 48 * 64));
    // Normals at the symmetric places.
    for (p, n) in four.positions.iter().zip(&four.normals) {
        let (p, n) = (at(*p), at(*n));
        if (p - DVec3::splat(corner)).length() < 1e-6 || (p - DVec3::new(0.0, 0.0, face)).length() < 1e-6 {
            assert!(p.normalize().dot(n) > 1.0 - 1e-7, "{p} {n}");
        }
        assert!(p.normalize().dot(n) > 0.97);
    }
}

#[test]
fn the_limit_of_a_tetrahedron_by_loop() {
    // n = 3: β = 3/16 and γ = 1/5; the sum of the neighbours of a vertex v of the tetrahedron is −v.
    let one = plain(&tetrahedron(), Loop, 1);
    let five = plain(&tetrahedron(), Loop, 5);
    let limit = DVec3::ONE * (1.0 - 3.0 / 5.0 - 1.0 / 5.0);
    assert!(has(&one, limit) && has(&five, limit), "{:?}", one.positions);
    assert_eq!((one.triangles.len(), five.triangles.len()), (16, 4096));
    assert_eq!((open_edges(&one), open_edges(&five)), (0, 0));
    assert_eq!(distinct(&five) as i64 - five.triangles.len() as i64 / 2, 2);
    // An octahedron's vertices have four neighbours: β = 3/32, γ = 1/8; opposite neighbours cancel.
    let points = [
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -1.0],
    ];
    let faces: [&[u32]; 8] =
        [&[0, 2, 4], &[2, 1, 4], &[1, 3, 4], &[3, 0, 4], &[2, 0, 5], &[1, 2, 5], &[3, 1, 5], &[0, 3, 5]];
    assert!(has(&plain(&mesh(&points, &faces), Loop, 4), DVec3::X * 0.5));
}

#[test]
fn flat_grids_stay() {
    for (scheme, triangles) in [(CatmullClark, false), (CatmullClark, true), (Loop, true)] {
        // Two of the corners of the grid of triangles have two faces.
        let corners = [0.0, 4.0, 20.0, 24.0].map(|v| [v, v, 10.0]).to_vec();
        let creases = if triangles { corners } else { Vec::new() };
        let by = Subdivision { keep_corners: !triangles, creases, ..Subdivision::new(scheme, 3) };
        let made = run(&grid(4, |_, _| 0.25, triangles), &by);
        // Area and border of the unit square; interior vertices of a regular grid are on the finer grid.
        let area = |[a, b, c]: [u32; 3]| {
            let [a, b, c] = [a, b, c].map(|i| at(made.positions[i as usize]));
            0.5 * (b - a).cross(c - a).z
        };
        let areas: Vec<f64> = made.triangles.iter().map(|t| area(*t)).collect();
        assert!(
            (areas.iter().sum::<f64>() - 1.0).abs() < 1e-6 && areas.iter().all(|a| *a > 0.0),
            "{scheme:?}"
        );
        assert!(made.normals.iter().all(|n| n[2] > 0.999_999), "{scheme:?}");
        assert!(made.positions.iter().all(|p| p[2] == 0.25));
        if !(scheme == CatmullClark && triangles) {
            // Far from the border, a linear function is reproduced: (u, v) are x and y.
            for (p, uv) in made.positions.iter().zip(&made.uvs) {
                let inner = p[0] > 0.26 && p[0] < 0.74 && p[1] > 0.26 && p[1] < 0.74;
                assert!(
                    !inner || (p[0] - uv[0]).abs() + (p[1] - uv[1]).abs() < 1e-5,
                    "{scheme:?} {p:?} {uv:?}"
                );
            }
            assert!(has(&made, DVec3::new(0.5, 0.5, 0.25)) && has(&made, DVec3::new(0.53125, 0.5, 0.25)));
        }
        // Without `keep_corners` the corners are rounded: those of the border curve move.
        let rounded = plain(&grid(4, |_, _| 0.25, triangles), scheme, 3);
        assert!(!has(&rounded, DVec3::new(0.0, 0.0, 0.25)) && has(&made, DVec3::new(0.0, 0.0, 0.25)));
    }
}

/// A quadratic function on a regular grid has a known limit: Catmull–Clark is the uniform bicubic B-spline, whose
/// blending of f(x) = x² with spacing h is x² + h²/3.
#[test]
fn regular_grids_are_splines() {
    let n = 8;
    let h = 1.0 / f64::from(n);
    let made = plain(&grid(n, |x, y| x * x - 2.0 * x * y, false), CatmullClark, 3);
    let mut tested = 0;
    for (p, normal) in made.positions.iter().zip(&made.normals) {
        let (p, normal) = (at(*p), at(*normal));
        if p.x > 2.0 * h && p.x < 1.0 - 2.0 * h && p.y > 2.0 * h && p.y < 1.0 - 2.0 * h {
            let z = p.x * p.x - 2.0 * p.x * p.y + h * h / 3.0;
            assert!((p.z - z).abs() < 1e-6, "{p} {z}");
            let exact = DVec3::new(-(2.0 * p.x - 2.0 * p.y), 2.0 * p.x, 1.0).normalize();
            assert!((normal - exact).length() < 2e-6, "{p} {normal} {exact}");
            tested += 1;
        }
    }
    assert!(tested > 500);
    // Loop: the box spline of three directions is exact for quadratics up to a constant; the normals are exact.
    let made = plain(&grid(n, |x, y| x * x - 2.0 * x * y, true), Loop, 3);
    let mut shift = None;
    for (p, normal) in made.positions.iter().zip(&made.normals) {
        let (p, normal) = (at(*p), at(*normal));
        if p.x > 2.0 * h && p.x < 1.0 - 2.0 * h && p.y > 2.0 * h && p.y < 1.0 - 2.0 * h {
            let own = p.z - (p.x * p.x - 2.0 * p.x * p.y);
            assert!((own - *shift.get_or_insert(own)).abs() < 1e-6, "{p} {own}");
            let exact = DVec3::new(-(2.0 * p.x - 2.0 * p.y), 2.0 * p.x, 1.0).normalize();
            assert!((normal - exact).length() < 2e-6, "{p} {normal} {exact}");
        }
    }
}

/// Normals against those of the triangles of a much finer level around the same limit point, everywhere: at borders,
/// creases, and vertices of any number of faces.
#[test]
fn normals_are_those_of_finer_levels() {
    let pyramid = {
        let around = |i: u32| {
            let (s, c) = crate::math::elementary::sin_cos(std::f64::consts::TAU * f64::from(i) / 7.0);
            [c, s, 0.2 * f64::from(i % 3)]
        };
        let mut points: Vec<[f64; 3]> = (0..7).map(around).collect();
        points.push([0.0, 0.1, 1.0]);
        let faces: Vec<[u32; 3]> = (0..7).map(|i| [i, (i + 1) % 7, 7]).collect();
        let lists: Vec<&[u32]> = faces.iter().map(|f| &f[..]).collect();
        mesh(&points, &lists)
    };
    let bent = |triangles| grid(3, |x, y| x * x * y - 0.5 * y * y + 0.3 * x, triangles);
    let creased = |data: MeshData, scheme| {
        (
            data,
            Subdivision {
                creases: vec![[5.0, 6.0, 20.0], [6.0, 10.0, 20.0], [5.0, 4.0, 20.0], [10.0, 14.0, 20.0]],
                keep_corners: true,
                ..Subdivision::new(scheme, 1)
            },
        )
    };
    // At rounded corners of one quadrilateral the normals of finer levels converge only like 1 / levels.
    let smooth = |data: MeshData, scheme| {
        (data, Subdivision { keep_corners: scheme == CatmullClark, ..Subdivision::new(scheme, 1) })
    };
    let cases = [
        smooth(cube(), CatmullClark),
        smooth(tetrahedron(), Loop),
        smooth(pyramid.clone(), CatmullClark),
        smooth(pyramid, Loop),
        smooth(bent(false), CatmullClark),
        smooth(bent(true), CatmullClark),
        smooth(bent(true), Loop),
        creased(bent(false), CatmullClark),
        creased(bent(true), Loop),
    ];
    // The normals of finer triangles around a place, the nearest to `n`: one for each side of a crease.
    let seen = |data: &MeshData, by: &Subdivision, levels: u32| {
        let fine = run(data, &Subdivision { levels, ..by.clone() });
        let mut flat = vec![DVec3::ZERO; fine.positions.len()];
        for t in &fine.triangles {
            let [a, b, c] = t.map(|i| at(fine.positions[i as usize]));
            let normal = (b - a).cross(c - a).normalize();
            t.iter().for_each(|i| flat[*i as usize] += normal);
        }
        move |p: DVec3, n: DVec3| {
            let same = (0..flat.len()).filter(|k| (at(fine.positions[*k]) - p).length() < 1e-6);
            let own = same.map(|k| flat[k].normalize());
            own.max_by(|a, b| a.dot(n).total_cmp(&b.dot(n))).unwrap()
        }
    };
    for (i, (data, by)) in cases.into_iter().enumerate() {
        let coarse = run(&data, &by);
        let [near, nearer] = [4, 7].map(|levels| seen(&data, &by, levels));
        for (p, n) in coarse.positions.iter().zip(&coarse.normals) {
            let (p, n) = (at(*p), at(*n));
            let degrees = |of: DVec3| crate::math::elementary::acos(of.dot(n).min(1.0)).to_degrees();
            let (before, after) = (degrees(near(p, n)), degrees(nearer(p, n)));
            // Where a crease turns at a vertex, the error is proportional to 1 / levels: from 4 to 7 it falls to 4 / 7.
            let turning = !by.creases.is_empty() && after < 4.0 && after < 0.71 * before;
            assert!(after < 2.5 || turning, "case {i}: {p:?} {n:?}: {before}, then {after} degrees");
        }
    }
}

#[test]
fn creases_keep_edges() {
    // All edges for ever: a cube stays a cube, with the normals of its faces.
    let all = Subdivision { crease_angle: Some(80.0), ..Subdivision::new(CatmullClark, 3) };
    let made = run(&cube(), &all);
    assert!((volume(&made) - 8.0).abs() < 1e-6 && open_edges(&made) == 0);
    for n in &made.normals {
        assert!((n.map(f32::abs).iter().sum::<f32>() - 1.0).abs() < 1e-6, "{n:?}");
    }
    // One ring of edges: the top stays in its plane, and its border is the spline curve of the square.
    let ring = |s: f64| Subdivision {
        creases: vec![[4.0, 5.0, s], [5.0, 7.0, s], [7.0, 6.0, s], [6.0, 4.0, s]],
        ..Subdivision::new(CatmullClark, 4)
    };
    let top = |mesh: &MeshData| mesh.positions.iter().map(|p| p[2]).fold(f32::MIN, f32::max);
    let sharp = run(&cube(), &ring(10.0));
    assert!((top(&sharp) - 1.0).abs() < 1e-6);
    // The corner (1, 1) of the square moves to (4 v + a + b) / 6 = 2/3.
    assert!(has(&sharp, DVec3::new(2.0 / 3.0, 2.0 / 3.0, 1.0)));
    let crease = |p: &[f32; 3]| (at(*p) - DVec3::new(2.0 / 3.0, 2.0 / 3.0, 1.0)).length() < 1e-6;
    let sides = sharp.positions.iter().filter(|p| crease(p)).count();
    assert!(sides >= 2, "two sides have their own normals: {sides}");
    // Sharpness in between gives volumes in between, in order.
    let volumes = [0.0, 0.5, 1.0, 1.7, 2.0, 3.0, 10.0].map(|s| volume(&run(&cube(), &ring(s))));
    assert!(volumes.is_sorted() && volumes.windows(2).all(|v| v[1] > v[0] + 1e-4), "{volumes:?}");
    assert!((volumes[0] - volume(&plain(&cube(), CatmullClark, 4))).abs() < 1e-9);
    // A sharpness of 1 is the sharp rule once, then the smooth one: the vertex is at (6 v + Σe) / 8 after one level.
    let near = run(&cube(), &ring(1e-9));
    assert!((volume(&near) - volumes[0]).abs() < 1e-6, "continuous at 0");
    // A sharp corner stays.
    let corner = Subdivision { creases: vec![[7.0, 7.0, 10.0]], ..Subdivision::new(CatmullClark, 3) };
    assert!(has(&run(&cube(), &corner), DVec3::ONE) && !has(&run(&cube(), &corner), DVec3::NEG_ONE));
    for bad in [[0.0, 7.0, 1.0], [0.0, 8.0, 1.0], [0.5, 1.0, 1.0], [0.0, 1.0, -1.0], [0.0, 1.0, f64::NAN]] {
        let by = Subdivision { creases: vec![bad], ..Subdivision::new(CatmullClark, 1) };
        assert!(subdivide(&cube(), &by, &Limits::default()).is_err(), "{bad:?}");
    }
}

#[test]
fn attributes_and_materials_follow_the_faces() {
    // Faces with vertices of their own at the same positions: one surface, but a seam of (u, v).
    let joined = cube();
    let corners: Vec<u32> = joined.fans().unwrap().concat();
    let mut split = MeshData {
        positions: corners.iter().map(|i| joined.positions[*i as usize]).collect(),
        uvs: [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].repeat(6),
        colors: vec![[0.5, 0.25, 1.0, 1.0]; 24],
        triangles: (0..6)
            .flat_map(|f| [[4 * f, 4 * f + 1, 4 * f + 2], [4 * f, 4 * f + 2, 4 * f + 3]])
            .collect(),
        polygons: vec![2; 6],
        face_materials: (0..12).map(|i| i / 2).collect(),
        ..MeshData::default()
    };
    split.more_uvs = vec![split.uvs.clone()];
    let made = plain(&split, CatmullClark, 3);
    assert_eq!(open_edges(&made), 0);
    assert!((volume(&made) - volume(&plain(&joined, CatmullClark, 3))).abs() < 1e-9);
    assert_eq!(made.colors[17], [0.5, 0.25, 1.0, 1.0]);
    // Each face covers the square of (u, v) once, and one material in six.
    let area = |[a, b, c]: [u32; 3]| {
        let [a, b, c] = [a, b, c].map(|i| made.uvs[i as usize].map(f64::from));
        0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
    };
    for material in 0..6 {
        let of_it = made.triangles.iter().zip(&made.face_materials).filter(|(_, m)| **m == material);
        let (count, sum) = of_it.fold((0, 0.0), |(n, sum), (t, _)| (n + 1, sum + area(*t)));
        assert!(count == 128 && (sum - 1.0).abs() < 1e-6, "{count} {sum}");
    }
    assert_eq!(made.uvs, made.more_uvs[0]);
    // Without polygons, triangles are divided: another surface.
    let triangles = MeshData { polygons: Vec::new(), ..joined };
    assert_eq!(plain(&triangles, CatmullClark, 1).triangles.len(), 72);
}

#[test]
fn odd_meshes_do_no_harm() {
    let point = |i: u32| [f64::from(i), f64::from(i * i % 7), f64::from(i % 3)];
    let points: Vec<[f64; 3]> = (0..10).map(point).collect();
    let odd = [
        // Three faces at one edge, a repeated face, one turned over, a face that is an edge, vertices without a face.
        mesh(&points, &[&[0, 1, 2], &[0, 1, 3], &[1, 0, 4], &[0, 1, 2], &[2, 1, 0], &[5, 6, 6]]),
        // Two parts that meet in a vertex; a quadrilateral that meets itself.
        mesh(&points, &[&[0, 1, 2], &[0, 3, 4], &[5, 6, 5, 7]]),
        mesh(&[[0.0; 3]; 10], &[&[0, 1, 2], &[3, 4, 5, 6]]),
        MeshData::default(),
        MeshData {
            positions: vec![[f32::NAN; 3], [1.0; 3], [2.0, 0.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            ..MeshData::default()
        },
        MeshData {
            positions: vec![[f32::MAX; 3], [-f32::MAX, 0.0, 1.0], [2.0, 0.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            ..MeshData::default()
        },
    ];
    for data in &odd {
        for scheme in [CatmullClark, Loop] {
            for by in [
                Subdivision::new(scheme, 3),
                Subdivision { crease_angle: Some(0.0), ..Subdivision::new(scheme, 2) },
            ] {
                let made = run(data, &by);
                assert!(made.positions.as_flattened().iter().all(|v| v.is_finite()));
            }
        }
    }
    // A polygon of 1000 sides around a cone.
    let round = |i: u32| {
        let (s, c) = crate::math::elementary::sin_cos(std::f64::consts::TAU * f64::from(i) / 1000.0);
        [c, s, 0.0]
    };
    let mut points: Vec<[f64; 3]> = (0..1000).map(round).collect();
    points.push([0.0, 0.0, -1.0]);
    let base: Vec<u32> = (0..1000).collect();
    let sides: Vec<[u32; 3]> = (0..1000).map(|i| [(i + 1) % 1000, i, 1000]).collect();
    let mut lists: Vec<&[u32]> = vec![&base];
    lists.extend(sides.iter().map(|s| &s[..]));
    let made = plain(&mesh(&points, &lists), CatmullClark, 2);
    assert_eq!((open_edges(&made), made.triangles.len()), (0, 2 * 4 * 4000));
    // Limits are checked before anything is allocated.
    let few = Limits { max_triangles: 1000, ..Limits::default() };
    assert!(subdivide(&cube(), &Subdivision::new(CatmullClark, 3), &few).is_ok());
    let error = subdivide(&cube(), &Subdivision::new(CatmullClark, 4), &few).unwrap_err();
    assert!(error.message.contains("3072 triangles; expected at most 1000"), "{}", error.message);
    let big = grid(100, |_, _| 0.0, false);
    assert!(
        subdivide(&big, &Subdivision::new(Loop, 10), &Limits::default())
            .unwrap_err()
            .message
            .contains("levels")
    );
}
