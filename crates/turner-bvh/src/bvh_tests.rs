use proptest::prelude::*;

use super::*;
use crate::generate::{Random, SceneKind, rays};
use crate::{Aabb, Bvh2, Bvh2Options, InstructionSet, Quality, oracle};

/// Runs a check on the BVH with each instruction set that this machine has.
fn each_set(bvh: &Bvh, mut check: impl FnMut(&Bvh, InstructionSet)) {
    for instruction_set in InstructionSet::available() {
        check(&Bvh { instruction_set, ..bvh.clone() }, instruction_set);
    }
}

/// The hits of brute force, in the units of the BVH.
fn expected(mesh: &Triangles<'_>, space: &Space, rays: &[Ray]) -> Vec<Hit> {
    let finite = |p: &[f32; 3]| p.iter().all(|x| x.is_finite());
    let all: Vec<(u32, [[f32; 3]; 3])> = (0..)
        .zip(mesh.triangles)
        .map(|(id, t)| (id, t.map(|i| mesh.positions[i as usize].map(|x| x * space.scale))))
        .filter(|(_, p)| p.iter().all(finite) && p[0] != p[1] && p[1] != p[2] && p[2] != p[0])
        .collect();
    rays.iter().map(|ray| oracle::closest(&all, ray, space)).collect()
}

/// Every quality, instruction set and query gives the hits of brute force, bit for bit.
fn check(mesh: &Triangles<'_>, rays: &[Ray]) {
    let bits = |hit: &Hit| (hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.primitive);
    for quality in [Quality::Fast, Quality::Balanced, Quality::High] {
        let options = BuildOptions { quality, threads: 2, ..BuildOptions::default() };
        // High quality even where it does not pay.
        let bvh = Bvh::of(mesh, &options, wide::build).unwrap();
        let wanted = expected(mesh, &bvh.space, rays);
        each_set(&bvh, |bvh, set| {
            let same = |what: &str, found: &[Hit]| {
                for ((ray, wanted), found) in rays.iter().zip(&wanted).zip(found) {
                    assert_eq!(bits(wanted), bits(found), "{quality:?} {set} {what}: {ray:?}");
                }
            };
            let any_same = |what: &str, found: &[bool]| {
                for ((ray, wanted), found) in rays.iter().zip(&wanted).zip(found) {
                    assert_eq!(wanted.is_hit(), *found, "{quality:?} {set} {what}: {ray:?}");
                }
            };
            let mut hits = vec![Hit { t: 1.0, primitive: 7, ..Hit::MISS }; rays.len()];
            let mut any = vec![false; rays.len()];
            for (ray, hit) in rays.iter().zip(&mut hits) {
                *hit = bvh.intersect(ray).unwrap_or(Hit::MISS);
            }
            same("single", &hits);
            // Interleaved traversal, even for small BVHs.
            crate::search::interleaved(bvh.tree(&bvh.all()), rays, &mut hits);
            same("interleaved", &hits);
            bvh.intersect_batch(rays, &mut hits);
            same("batch", &hits);
            bvh.intersect_batch_filtered(rays, &mut hits, |_, _| true);
            same("batch with a filter", &hits);
            for (ray, any) in rays.iter().zip(&mut any) {
                *any = bvh.occluded(ray);
            }
            any_same("any, single", &any);
            crate::search::any_interleaved(bvh.tree(&bvh.all()), rays, &mut any);
            any_same("any, interleaved", &any);
            bvh.occluded_batch(rays, &mut any);
            any_same("any, batch", &any);
            bvh.occluded_batch_filtered(rays, &mut any, |ray, hit| {
                // The filter gets the ray's index and the hit in the caller's units.
                assert!(rays[ray as usize].t_min <= hit.t && hit.t <= rays[ray as usize].t_max);
                true
            });
            any_same("any, batch with a filter", &any);
        });
    }
}

/// The examples of the documentation.
#[test]
fn examples() -> Result<(), BuildError> {
    let positions = [[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]];
    let bvh =
        Bvh::build(&Triangles { positions: &positions, triangles: &[[0, 1, 2]] }, &BuildOptions::default())?;
    let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]);
    let hit = bvh.intersect(&ray).unwrap();
    assert_eq!((hit.t, hit.u, hit.v, hit.primitive), (5.0, 0.25, 0.25, 0));
    let mut hits = [Hit::MISS; 2];
    bvh.intersect_batch(&[ray, Ray { t_max: 4.0, ..ray }], &mut hits);
    assert_eq!(hits.map(|hit| hit.is_hit()), [true, false]);

    let positions = [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0], [0.0, 1.0, 0.0]];
    let triangles = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [0, 2, 1], [0, 3, 2]];
    let bvh =
        Bvh::build(&Triangles { positions: &positions, triangles: &triangles }, &BuildOptions::default())?;
    let down = Ray::new([0.5, 3.0, 0.1], [0.0, -1.0, 0.0]);
    let hit = bvh.intersect(&down).expect("the pyramid is below");
    assert_eq!((hit.t, hit.primitive), (2.5, 1));
    assert!(!bvh.occluded(&Ray { t_max: 2.0, ..down }));
    Ok(())
}

#[test]
fn scenes_equal_brute_force() {
    for kind in [SceneKind::Cornell, SceneKind::Architecture, SceneKind::Scan, SceneKind::Sticks] {
        let scene = kind.generate(3000);
        let mesh = &scene.meshes[0];
        let mesh = Triangles { positions: &mesh.positions, triangles: &mesh.triangles };
        let primary = rays::primary(&scene.camera, 16);
        let extent = scene.extent();
        let bvh = Bvh::build(&mesh, &BuildOptions::default()).unwrap();
        let points: Vec<_> = primary
            .iter()
            .filter_map(|r| {
                bvh.intersect(r).and_then(|h| rays::point(&scene, extent, r, h.t, 0, h.primitive))
            })
            .collect();
        let sets = [
            primary,
            rays::shadow(&points, scene.light),
            rays::diffuse(&points),
            rays::ambient(&points, 0.1 * extent),
        ];
        check(&mesh, &sets.concat());
    }
}

/// A height field on integer coordinates: rays hit edges and vertices exactly.
fn field(side: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let height = |x: u32, y: u32| ((x * 7 + y * 13) % 5) as f32 - 2.0;
    let positions =
        (0..=side).flat_map(|y| (0..=side).map(move |x| [x as f32, y as f32, height(x, y)])).collect();
    let row = side + 1;
    let cell = |x: u32, y: u32| {
        let a = y * row + x;
        [[a, a + 1, a + row], [a + 1, a + row + 1, a + row]]
    };
    let triangles = (0..side).flat_map(|y| (0..side).flat_map(move |x| cell(x, y))).collect();
    (positions, triangles)
}

#[test]
fn rays_along_axes_planes_edges_and_from_vertices() {
    let (positions, triangles) = field(12);
    let mesh = Triangles { positions: &positions, triangles: &triangles };
    let mut rays = Vec::new();
    for i in 0..25 {
        for j in 0..25 {
            let (x, y) = (0.5 * i as f32, 0.5 * j as f32);
            rays.push(Ray::new([x, y, 10.0], [0.0, 0.0, -1.0]));
            rays.push(Ray::new([x, y, -10.0], [0.0, -0.0, 3.0]));
            rays.push(Ray::new([x - 20.0, y, 0.0], [1.0, 0.0, 0.0]));
            rays.push(Ray::new([x, y - 20.0, -1.0], [0.0, 0.25, 0.0]));
            rays.push(Ray::new([x, y, 0.0], [1.0, 1.0, 0.0]));
            rays.push(Ray::new([x, y, 1.0], [-1.0, 0.5, 1e-30]));
        }
    }
    // From vertex to vertex, along edges and past them.
    for (i, a) in positions.iter().enumerate() {
        let b = positions[(i * 37 + 11) % positions.len()];
        let direction = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
        rays.push(Ray::new(*a, direction));
        rays.push(Ray { t_min: 1.0, t_max: 1.0, ..Ray::new(*a, direction) });
        rays.push(Ray { t_max: 0.5, ..Ray::new(*a, direction) });
        rays.push(Ray::new(
            [a[0] - 1e4 * direction[0], a[1] - 1e4 * direction[1], a[2] - 1e4 * direction[2]],
            direction,
        ));
    }
    check(&mesh, &rays);
}

#[test]
fn tiny_and_huge_sizes_and_distant_rays() {
    let (positions, triangles) = field(6);
    let mut random = Random::new(5);
    for scale in [1e-30_f32, 1e-15, 1e-6, 1.0, 1e9, 1e18, 1e30] {
        let positions: Vec<[f32; 3]> = positions.iter().map(|p| p.map(|x| x * scale)).collect();
        let mesh = Triangles { positions: &positions, triangles: &triangles };
        let mut rays = Vec::new();
        for i in 0..200 {
            let distance = [1.0, 1e3, 1e6, 1e9][i % 4];
            let direction = random.direction();
            let at = [6.0 * random.unit(), 6.0 * random.unit(), random.unit()];
            let origin = [0, 1, 2].map(|k| (at[k] - distance * direction[k]) * scale);
            let length = [1.0, scale, 1e-20, 1e20][i / 4 % 4];
            rays.push(Ray::new(origin, direction.map(|x| x * length)));
        }
        check(&mesh, &rays);
        let bvh = Bvh::build(&mesh, &BuildOptions::default()).unwrap();
        let near: Vec<Ray> = rays.iter().step_by(4).copied().collect();
        let hits = near.iter().filter(|ray| bvh.occluded(ray)).count();
        assert!(hits > near.len() / 2, "scale {scale}: {hits} of {} rays hit", near.len());
    }
}

#[test]
fn no_ray_slips_through_edges_and_vertices() {
    // A closed surface around the origin: every ray hits it.
    let scene = SceneKind::Scan.generate(25_000);
    let mesh = &scene.meshes[0];
    let bvh = Bvh::build(
        &Triangles { positions: &mesh.positions, triangles: &mesh.triangles },
        &BuildOptions::default(),
    )
    .unwrap();
    let mut random = Random::new(3);
    let mut rays = Vec::new();
    for round in 0..8 {
        // From near the centre, exactly to vertices and to points on edges as close as floats can represent.
        let from = [random.unit() * 0.1, random.unit() * 0.1, random.unit() * 0.1];
        for triangle in &mesh.triangles {
            let [a, b] = [triangle[round % 3], triangle[(round + 1) % 3]].map(|i| mesh.positions[i as usize]);
            let w = random.unit();
            let p = [0, 1, 2].map(|i| a[i] + w * (b[i] - a[i]));
            for to in [a, p] {
                rays.push(Ray::new(from, [0, 1, 2].map(|i| to[i] - from[i])));
            }
        }
    }
    assert!(rays.len() > 300_000);
    each_set(&bvh, |bvh, set| {
        let mut hits = vec![Hit::MISS; rays.len()];
        bvh.intersect_batch(&rays, &mut hits);
        let leaks = hits.iter().filter(|hit| !hit.is_hit()).count();
        assert_eq!(leaks, 0, "{set}: {leaks} of {} rays leave a closed surface", rays.len());
        assert!(hits.iter().all(|hit| (hit.t - 1.0).abs() < 1e-2));
    });
}

#[test]
fn invalid_rays_hit_nothing_and_terminate() {
    let (positions, triangles) = field(12);
    let mesh = Triangles { positions: &positions, triangles: &triangles };
    let good = Ray::new([6.1, 6.2, 10.0], [0.0, 0.0, -1.0]);
    let mut rays = Vec::new();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in 0..3 {
            let (mut a, mut b) = (good, good);
            a.origin[axis] = bad;
            b.direction[axis] = bad;
            rays.extend([a, b]);
        }
        rays.push(Ray { t_max: bad, ..good });
    }
    rays.retain(|ray| ray.t_max != f32::INFINITY || !ray.is_valid());
    rays.push(Ray { t_min: f32::NAN, ..good });
    rays.push(Ray { t_min: 30.0, t_max: 20.0, ..good });
    rays.push(Ray { t_min: -2.0, t_max: -1.0, ..good });
    rays.push(Ray { direction: [0.0; 3], ..good });
    rays.push(Ray { direction: [1e-45; 3], ..good });
    rays.push(Ray { origin: [1e30, 0.0, 0.0], ..good });
    let bvh = Bvh::build(&mesh, &BuildOptions::default()).unwrap();
    assert!(bvh.occluded(&good));
    assert!(rays.iter().all(|ray| !bvh.occluded(ray)), "{:?}", rays.iter().find(|r| bvh.occluded(r)));
    // Also mixed with valid rays, in packets and batches.
    let mixed: Vec<Ray> = rays.iter().flat_map(|bad| [good, *bad]).collect();
    check(&mesh, &mixed);
}

#[test]
fn filters_see_hits_in_the_callers_units() {
    // Squares one behind the other, at sizes that the BVH rescales.
    for scale in [1.0_f32, 1e-25, 1e25] {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let positions: Vec<[f32; 3]> =
            (0..20).flat_map(|z| corners.map(|[x, y]| [x * scale, y * scale, z as f32 * scale])).collect();
        let triangles: Vec<[u32; 3]> =
            (0..20).flat_map(|i| [[4 * i, 4 * i + 1, 4 * i + 2], [4 * i, 4 * i + 2, 4 * i + 3]]).collect();
        let mesh = Triangles { positions: &positions, triangles: &triangles };
        let bvh = Bvh::build(&mesh, &BuildOptions::default()).unwrap();
        let ray = Ray::new([0.5 * scale, 0.25 * scale, -scale], [0.0, 0.0, scale]);
        each_set(&bvh, |bvh, _| {
            // The filter ignores squares 0 to 7.
            let solid = |hit: &Hit| hit.primitive >= 16;
            let hit = bvh.intersect_filtered(&ray, solid).unwrap();
            assert!((hit.t - 9.0).abs() < 1e-5 && hit.primitive == 16);
            assert!(bvh.intersect_filtered(&ray, |_| false).is_none());
            assert!(!bvh.occluded_filtered(&ray, |hit| hit.t > 20.5));
            assert!(bvh.occluded_filtered(&ray, |hit| hit.t > 19.5));
            let rays = [ray; 40];
            let mut hits = [Hit::MISS; 40];
            let own = |i: u32, hit: &Hit| hit.primitive >= 2 * (i % 20);
            bvh.intersect_batch_filtered(&rays, &mut hits, own);
            for (i, hit) in hits.iter().enumerate() {
                assert!((hit.t - 1.0 - (i % 20) as f32).abs() < 1e-5);
            }
        });
    }
}

#[test]
fn the_binary_bvh_agrees() {
    let scene = SceneKind::Architecture.generate(30_000);
    let mesh = &scene.meshes[0];
    let triangles = Triangles { positions: &mesh.positions, triangles: &mesh.triangles };
    let bvh = Bvh::build(&triangles, &BuildOptions::default()).unwrap();
    // Boxes padded as the rays of the wide BVH pad them.
    let pad = 1e-5 * scene.extent();
    let boxes: Vec<Aabb> = (0..mesh.triangles.len())
        .map(|i| {
            let b = mesh.triangle(i).into_iter().fold(Aabb::EMPTY, Aabb::grow);
            Aabb::new(b.min.map(|x| x - pad), b.max.map(|x| x + pad))
        })
        .collect();
    let binary = Bvh2::build(&boxes, &Bvh2Options::default()).unwrap();
    for ray in rays::primary(&scene.camera, 40) {
        let mut best = Hit::MISS;
        binary.closest(&ray, |range, t_max| {
            let ids = &binary.order()[range.start as usize..range.end as usize];
            let leaf: Vec<_> = ids.iter().map(|&i| (i, mesh.triangle(i as usize))).collect();
            let hit = oracle::closest(&leaf, &Ray { t_max, ..ray }, &bvh.space);
            if hit.is_hit() && (hit.t < best.t || hit.t == best.t && hit.primitive < best.primitive) {
                best = hit;
            }
            best.t.min(t_max)
        });
        assert_eq!(bvh.intersect(&ray).unwrap_or(Hit::MISS), best, "{ray:?}");
    }
}

#[test]
fn high_quality_is_kept_where_it_pays() {
    for (kind, count, cut) in [(SceneKind::Sticks, 100_000, true), (SceneKind::Scan, 10_000, false)] {
        let scene = kind.generate(count);
        let mesh = &scene.meshes[0];
        let mesh = Triangles { positions: &mesh.positions, triangles: &mesh.triangles };
        let [balanced, high] = [Quality::Balanced, Quality::High].map(|quality| {
            *Bvh::build(&mesh, &BuildOptions { quality, ..BuildOptions::default() }).unwrap().stats()
        });
        assert_eq!(high.references > high.primitives, cut, "{kind:?}: {high:?} {balanced:?}");
        assert!(high.sah_cost < 0.9 * balanced.sah_cost || high == balanced, "{kind:?}");
    }
}

#[test]
fn empty_and_degenerate_meshes() {
    let ray = Ray::new([0.0; 3], [1.0; 3]);
    let nothing = Bvh::build(&Triangles::default(), &BuildOptions::default()).unwrap();
    let mut hits = [Hit { primitive: 3, ..Hit::MISS }; 20];
    nothing.intersect_batch(&[ray; 20], &mut hits);
    assert!(hits.iter().all(|h| *h == Hit::MISS) && !nothing.occluded(&ray));

    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [f32::NAN; 3], [2.0, 0.0, 0.0]];
    let triangles = [[0, 1, 2], [0, 1, 3], [1, 1, 2], [0, 1, 4], [0, 0, 0]];
    let mesh = Triangles { positions: &positions, triangles: &triangles };
    let stats = *Bvh::build(&mesh, &BuildOptions::default()).unwrap().stats();
    assert_eq!((stats.primitives, stats.non_finite, stats.degenerate), (2, 1, 2));
    check(
        &mesh,
        &[Ray::new([0.2, 0.2, 1.0], [0.0, 0.0, -1.0]), Ray::new([0.5, 0.0, 1.0], [0.0, 0.0, -1.0]), ray],
    );

    let error = Bvh::build(
        &Triangles { positions: &positions, triangles: &[[0, 1, 2], [0, 1, 9]] },
        &BuildOptions::default(),
    )
    .unwrap_err();
    assert_eq!(error, BuildError::VertexOutOfRange { triangle: 1, vertex: 9, vertices: 5 });
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    /// Arbitrary input: coordinates on a coarse grid coincide often, others are any float.
    #[test]
    fn any_triangles_and_any_rays(
        grid in prop::collection::vec(prop::array::uniform3(-4_i8..=4), 3..40),
        wild in prop::collection::vec(prop::array::uniform3(any::<f32>()), 0..4),
        corners in prop::collection::vec(prop::array::uniform3(any::<prop::sample::Index>()), 1..60),
        directions in prop::collection::vec((prop::array::uniform3(-5_i8..=5), prop::array::uniform3(-3_i8..=3)), 1..40),
        arbitrary in prop::collection::vec((prop::array::uniform3(any::<f32>()), prop::array::uniform3(any::<f32>())), 0..4),
    ) {
        let mut positions: Vec<[f32; 3]> = grid.iter().map(|p| p.map(|x| f32::from(x) * 0.37)).collect();
        positions.extend(&wild);
        let triangles: Vec<[u32; 3]> =
            corners.iter().map(|t| [0, 1, 2].map(|i| t[i].index(positions.len()) as u32)).collect();
        let mut rays: Vec<Ray> = directions
            .iter()
            .map(|(o, d)| Ray::new(o.map(|x| f32::from(x) * 0.37), d.map(f32::from)))
            .collect();
        rays.extend(arbitrary.iter().map(|(o, d)| Ray::new(*o, *d)));
        check(&Triangles { positions: &positions, triangles: &triangles }, &rays);
    }
}
