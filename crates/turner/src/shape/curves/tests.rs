use super::*;
use crate::math::{DVec3, Ray};
use crate::schema::PrepareOptions;
use crate::shape::testing::Random;
use std::sync::Arc;

fn curves(points: &[[f32; 3]], strands: &[u32], width: f64, basis: CurveBasis, kind: CurveKind) -> Curves {
    let data = MeshData { positions: points.to_vec(), strands: strands.to_vec(), ..MeshData::default() };
    let desc = CurvesDesc { width: Some(width), basis, kind, ..CurvesDesc::default() };
    desc.check(&data).unwrap();
    Curves::build(&Arc::new(data), &desc, &PrepareOptions::default()).unwrap()
}

/// A straight tube is a cylinder, closed at both ends, from outside.
#[test]
fn a_straight_tube_is_a_cylinder() {
    let points = [[-1.0, 0.5, 0.0], [0.0, 0.5, 0.0], [1.0, 0.5, 0.0], [3.0, 0.5, 0.0]];
    let desc = crate::shape::CylinderDesc {
        from: DVec3::new(-1.0, 0.5, 0.0),
        to: DVec3::new(3.0, 0.5, 0.0),
        radius: 0.25,
        ..Default::default()
    };
    let cylinder = desc.prepare().unwrap();
    for basis in [CurveBasis::CatmullRom, CurveBasis::Linear, CurveBasis::Bezier] {
        let tube = curves(&points, &[], 0.5, basis, CurveKind::Tube);
        let mut random = Random::new(1);
        let (mut hits, mut caps) = (0, 0);
        for _ in 0..20_000 {
            let origin = 4.0 * random.direction() + DVec3::X;
            let ray = Ray::new(origin, random.in_cube() * DVec3::new(2.5, 0.5, 0.5) + DVec3::X - origin);
            if cylinder.intersect(&Ray { t_max: 0.0, t_min: -1e9, ..ray }).is_some() {
                continue;
            }
            let (found, expected) = (tube.intersect(&ray), cylinder.intersect(&ray));
            assert_eq!(tube.occludes_where(&ray, &|_| true), found.is_some());
            match (found, expected) {
                (Some(a), Some(b)) => {
                    let (s, c) = (tube.surface(&ray, &a), cylinder.surface(&ray, &b));
                    // Grazing hits are found less exactly.
                    let cosine = c.ng.dot(ray.direction.normalize()).abs();
                    if cosine > 0.05 {
                        assert!(s.p.distance(c.p) < 1e-6, "{basis:?} {} {}", s.p, c.p);
                        assert!(s.ng.distance(c.ng) < 1e-5, "{} {}", s.ng, c.ng);
                    }
                    hits += 1;
                    caps += i32::from(a.u == 0.0 || a.u == 1.0);
                }
                (None, None) => {}
                (a, b) => {
                    let own = a.map(|a| tube.surface(&ray, &a).ng);
                    let ng = own.or(b.map(|b| cylinder.surface(&ray, &b).ng)).unwrap();
                    let cosine = ng.dot(ray.direction.normalize()).abs();
                    assert!(cosine < 0.05, "{basis:?} {a:?} {b:?} {cosine}");
                }
            }
        }
        assert!(hits > 5_000 && caps > 100, "{hits} {caps}");
    }
}

/// The nearest distance from a point to the curves, and the radius there, by brute force.
fn nearest(curves: &Curves, p: DVec3) -> f64 {
    let mut least = f64::INFINITY;
    for segment in 0..curves.count() as u32 {
        let cubic = curves.cubic(segment);
        for i in 0..=400 {
            let at = cubic.at(f64::from(i) / 400.0);
            least = least.min(p.distance(at.c) - at.r);
        }
    }
    least
}

fn wavy() -> Curves {
    let points = [
        [-1.2, -0.3, 0.2],
        [-0.6, 0.2, -0.1],
        [0.0, 0.1, 0.2],
        [0.6, 0.4, 0.0],
        [1.1, 0.0, -0.2],
        [1.2, -0.6, 0.1],
    ];
    let data = MeshData {
        positions: points.to_vec(),
        widths: vec![0.16, 0.2, 0.24, 0.2, 0.14, 0.06],
        ..MeshData::default()
    };
    let desc = CurvesDesc { basis: CurveBasis::CatmullRom, kind: CurveKind::Tube, ..CurvesDesc::default() };
    Curves::build(&Arc::new(data), &desc, &PrepareOptions::default()).unwrap()
}

/// Ray marching with the distance from the curve finds the same surface, without gaps.
#[test]
fn a_bent_tube_agrees_with_ray_marching() {
    let tube = wavy();
    let mut random = Random::new(5);
    let (mut hits, mut missed) = (0, 0);
    for _ in 0..600 {
        let origin = 3.0 * random.direction();
        let ray = Ray::new(origin, (0.8 * random.in_cube() - origin).normalize());
        let found = tube.intersect(&ray);
        let (mut t, mut least) = (0.0, f64::INFINITY);
        let marched = loop {
            let distance = nearest(&tube, ray.at(t));
            least = least.min(distance);
            if distance < 2e-4 {
                break Some(t);
            }
            t += 0.9 * distance;
            if t > 6.0 {
                break None;
            }
        };
        match (found, marched) {
            (Some(hit), Some(t)) => {
                let surface = tube.surface(&ray, &hit);
                let cosine = surface.ng.dot(ray.direction).abs();
                let off = (hit.t - t).abs() * cosine;
                // The ends are flat, not round.
                if hit.u > 0.0 && hit.u < 1.0 {
                    assert!(nearest(&tube, surface.p).abs() < 3e-3, "{}", nearest(&tube, surface.p));
                    assert!(off < 0.01, "{off} {cosine} {hit:?} {t}");
                }
                hits += 1;
            }
            (None, Some(_)) => missed += 1,
            (Some(hit), None) => {
                let surface = tube.surface(&ray, &hit);
                assert!(surface.ng.dot(ray.direction).abs() < 0.1, "{least} {hit:?}");
            }
            (None, None) => {}
        }
    }
    // Grazing rays, and those that marching stops at the round ends.
    assert!(hits > 120 && missed <= 4, "{hits} {missed}");
}

/// A ray that leaves a tube, or a flat curve, does not meet it again.
#[test]
fn no_hit_follows_where_a_ray_leaves() {
    let tube = wavy();
    let mut random = Random::new(6);
    let mut hits = 0;
    for _ in 0..3000 {
        let origin = 3.0 * random.direction();
        let ray = Ray::new(origin, 0.8 * random.in_cube() - origin);
        let Some(hit) = tube.intersect(&ray) else { continue };
        hits += 1;
        let s = tube.surface(&ray, &hit);
        let out = random.direction();
        let out = if out.dot(s.ng) < 0.0 { -out } else { out };
        let leaving = Ray::new(s.p + 4.0 * s.error * s.ng, out);
        // On the inner side of a bend, grazing rays do meet the tube again.
        if let Some(again) = tube.intersect(&leaving).filter(|_| out.dot(s.ng) > 0.1) {
            assert!(again.t > 0.02, "{again:?} {}", out.dot(s.ng));
        }
        // Into the tube: its inner side is not hit.
        let inwards = Ray::new(s.p - 4.0 * s.error * s.ng, -s.ng);
        assert!(tube.intersect(&inwards).is_none_or(|h| h.t > 0.1));
    }
    assert!(hits > 400, "{hits}");
    let line = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
    let flat = curves(&line, &[], 0.2, CurveBasis::Linear, CurveKind::Flat);
    for _ in 0..3000 {
        let target = random.in_cube() * DVec3::new(0.9, 0.09, 0.0);
        let ray = Ray::new(DVec3::new(0.3, 0.2, 4.0), target - DVec3::new(0.3, 0.2, 4.0));
        let Some(hit) = flat.intersect(&ray) else { continue };
        let s = flat.surface(&ray, &hit);
        let out = random.direction();
        let side = if out.dot(s.ng) < 0.0 { -4.0 } else { 4.0 };
        assert!(flat.intersect(&Ray::new(s.p + side * s.error * s.ng, out)).is_none());
    }
}

/// A flat curve covers the fraction of a line of rays that its width gives; v grows across it, u along it.
#[test]
fn a_flat_curve_faces_the_ray() {
    let line = [[-1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
    let flat = curves(&line, &[], 0.2, CurveBasis::CatmullRom, CurveKind::Flat);
    for (from, up) in [(DVec3::Z, DVec3::Y), (DVec3::Y, DVec3::NEG_Z), (DVec3::NEG_Z, DVec3::NEG_Y)] {
        let mut hits = 0;
        for i in 0..1000 {
            let y = -0.2 + 0.4 * (f64::from(i) + 0.5) / 1000.0;
            let ray = Ray::new(5.0 * from + y * up + 0.5 * DVec3::X, -from);
            let Some(hit) = flat.intersect(&ray) else { continue };
            hits += 1;
            let uv = flat.uv(&hit);
            assert!((uv.x - 0.75).abs() < 1e-6, "{uv}");
            assert!((uv.y - (0.5 + y / 0.2)).abs() < 1e-6, "{uv} {y}");
            assert!(flat.surface(&ray, &hit).ng.distance(from) < 1e-9);
            assert!((flat.tangent(&hit) - DVec3::X).length() < 1e-9);
        }
        assert_eq!(hits, 500);
    }
}

#[test]
fn a_ribbon_is_seen_by_its_normal() {
    let data = MeshData {
        positions: vec![[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
        normals: vec![[0.0, 0.0, 1.0]; 2],
        ..MeshData::default()
    };
    let desc = CurvesDesc {
        width: Some(0.2),
        basis: CurveBasis::Linear,
        kind: CurveKind::Ribbon,
        ..CurvesDesc::default()
    };
    let ribbon = Curves::build(&Arc::new(data), &desc, &PrepareOptions::default()).unwrap();
    let from = DVec3::new(0.0, 0.6, 0.8);
    let up = DVec3::new(0.0, 0.8, -0.6);
    let hits = (0..1000).filter(|i| {
        let y = -0.2 + 0.4 * (f64::from(*i) + 0.5) / 1000.0;
        ribbon.intersect(&Ray::new(5.0 * from + y * up, -from)).is_some()
    });
    // Foreshortened by the cosine.
    assert_eq!(hits.count(), 400);
}

#[test]
fn the_tree_finds_the_nearest_segment_and_is_small() {
    let mut random = Random::new(9);
    let (mut points, mut strands) = (Vec::new(), Vec::new());
    for _ in 0..2000 {
        let root = random.in_cube();
        let (a, b) = (0.2 * random.direction(), 0.1 * random.direction());
        for i in 0..5 {
            let t = f64::from(i) / 4.0;
            points.push((root + t * a + t * t * b).as_vec3().to_array());
        }
        strands.push(5);
    }
    for kind in [CurveKind::Tube, CurveKind::Flat] {
        for basis in [CurveBasis::CatmullRom, CurveBasis::BSpline] {
            let hair = curves(&points, &strands, 0.004, basis, kind);
            let mut hits = 0;
            for i in 0..400 {
                let origin = if i % 3 == 0 { 1e5 } else { 2.0 } * random.direction();
                let ray = Ray::new(origin, random.in_cube() - origin);
                let seen = cubic::SeenAlong::new(&ray).unwrap();
                let all = (0..hair.count() as u32).filter_map(|s| {
                    let section = match (kind, basis) {
                        (CurveKind::Flat, _) => cubic::Section::Flat,
                        (_, CurveBasis::BSpline) => cubic::Section::Tube([s % 2 == 0, s % 2 == 1]),
                        _ => cubic::Section::Tube([s % 4 == 0, s % 4 == 3]),
                    };
                    seen.hit(&hair.cubic(s), section, [0, 0])
                });
                let expected = all.map(|f| f.t).min_by(f64::total_cmp);
                let found = hair.intersect(&ray).map(|h| h.t);
                match (found, expected) {
                    (Some(a), Some(b)) => assert!((a - b).abs() < 1e-7 * b.max(1.0), "{a} {b}"),
                    (a, b) => assert_eq!(a, b, "{kind:?}"),
                }
                hits += i32::from(found.is_some());
            }
            assert!(hits > 30, "{hits}");
            let own = hair.memory() - hair.data_memory();
            assert!(own <= 100 * hair.count(), "{}", own / hair.count());
        }
    }
}

#[test]
fn faulty_curves_are_errors_or_left_out() {
    let data = |positions: usize, strands: &[u32]| MeshData {
        positions: vec![[0.0; 3]; positions],
        strands: strands.to_vec(),
        ..MeshData::default()
    };
    let check = |basis: CurveBasis, data: MeshData| {
        data.check()?;
        CurvesDesc { basis, ..CurvesDesc::default() }.check(&data)
    };
    assert!(check(CurveBasis::Bezier, data(7, &[])).is_ok());
    let message = check(CurveBasis::Bezier, data(6, &[])).unwrap_err().to_string();
    assert!(message.contains("curve 0 has 6 points") && message.contains("4, 7, 10"), "{message}");
    assert!(check(CurveBasis::BSpline, data(6, &[3, 3])).is_err());
    assert!(check(CurveBasis::Linear, data(6, &[3, 2])).is_err());
    assert!(check(CurveBasis::Linear, data(6, &[u32::MAX, 7])).is_err());
    assert!(check(CurveBasis::Linear, data(0, &[])).is_ok());
    let broken = [[f32::NAN, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0; 3], [0.0; 3], [f32::INFINITY, 0.0, 0.0]];
    for kind in [CurveKind::Tube, CurveKind::Flat] {
        let made = curves(&broken, &[], 0.1, CurveBasis::CatmullRom, kind);
        assert!(made.bounds().is_finite() || made.bounds().is_empty());
        let ray = Ray::new(DVec3::new(0.0, 0.0, 3.0), DVec3::NEG_Z);
        if let Some(hit) = made.intersect(&ray) {
            assert!(made.surface(&ray, &hit).ng.is_finite());
        }
        assert!(made.intersect(&Ray::new(DVec3::NAN, DVec3::X)).is_none());
    }
}

#[test]
fn triangles_are_near_the_tube() {
    let mesh = wavy().tubes().unwrap();
    mesh.check().unwrap();
    assert!(mesh.triangles.len() > 200);
    for p in &mesh.positions {
        assert!(nearest(&wavy(), DVec3::from(p.map(f64::from))).abs() < 0.01);
    }
}
