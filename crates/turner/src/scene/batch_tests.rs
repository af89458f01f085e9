use turner_bvh::InstructionSet;

use super::*;
use crate::math::DVec3;
use crate::shape::Sphere;
use crate::shape::testing::Random;

/// Every instruction set agrees with the scalar sphere test bit by bit: random rays, tangents, rays from inside, at
/// all scales, and invalid rays.
#[test]
fn eight_rays_hit_what_one_ray_hits() {
    let mut random = Random::new(7);
    let strange = [0.0, -0.0, f64::NAN, f64::INFINITY, 1e-310, 1e200, -1e-200];
    let mut found = 0;
    for n in 0..3000 {
        let scale = [1.0, 1e-6, 1e6, 1e-150, 1e150][n % 5];
        let spheres: Vec<Sphere> = (0..1 + n % 9)
            .map(|i| {
                let center: DVec3 = 3.0 * random.in_cube() * scale;
                let radius: f64 = [0.4, 1.0, 5000.0][(n / 5 + i) % 3] * scale;
                // Now and then a duplicate: the first one counts.
                if i % 4 == 3 { (DVec3::ZERO, scale) } else { (center, radius) }
            })
            .map(|(center, radius)| Sphere { center, radius })
            .collect();
        let mut list = Spheres::default();
        for s in &spheres {
            list.push(s.center.to_array(), s.radius);
        }
        let mut batch = RayBatch::default();
        let rays: Vec<Ray> = (0..1 + n % 20)
            .map(|i| {
                let target = &spheres[i % spheres.len()];
                let normal = random.direction();
                let across = normal.cross(random.direction());
                let surface = target.center + target.radius * normal;
                let (origin, direction) = match i % 5 {
                    0 => (6.0 * scale * random.in_cube(), random.direction()),
                    1 => (surface - across * scale, across),
                    2 => (surface, random.direction() * scale),
                    3 => (target.center, random.direction() * 1e-3),
                    _ => (DVec3::splat(strange[(n + i) % 7]), DVec3::new(0.0, strange[n % 7], 1.0)),
                };
                let mut ray = Ray::new(origin, direction);
                if n % 3 == 0 {
                    ray.t_min = 0.3 * random.unit();
                    ray.t_max = random.unit() * 2.0 * scale;
                }
                batch.push(&ray);
                ray
            })
            .collect();
        for set in InstructionSet::available() {
            let (mut nearest, mut any) = (Vec::new(), Vec::new());
            list.closest(set, batch.blocks(), &mut nearest);
            list.any(set, batch.blocks(), &mut any);
            for (i, ray) in rays.iter().enumerate() {
                let (block, lane) = (i / LANES, i % LANES);
                let mut best: Option<(f64, usize)> = None;
                let mut searched = *ray;
                for (k, sphere) in spheres.iter().enumerate() {
                    if let Some(hit) = sphere.intersect(&searched)
                        && (hit.t < searched.t_max || best.is_none())
                    {
                        searched.t_max = hit.t;
                        best = Some((hit.t, k));
                    }
                }
                let got = nearest[block].sphere.0[lane];
                let got = (got >= 0.0).then(|| (nearest[block].t.0[lane].to_bits(), got as usize));
                assert_eq!(got, best.map(|(t, k)| (t.to_bits(), k)), "{set} {ray:?} {spheres:?}");
                assert_eq!(any[block] >> lane & 1 == 1, best.is_some(), "{set} {ray:?}");
                found += usize::from(best.is_some());
            }
            let last = any.last().copied().unwrap_or_default();
            assert!(u32::from(last) >> (1 + (rays.len() - 1) % LANES) == 0, "empty lanes hit nothing");
        }
    }
    assert!(found > 10_000, "{found}");
}
