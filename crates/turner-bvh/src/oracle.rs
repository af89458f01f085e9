//! Brute force without a BVH: the reference for all traversals.

use crate::simd::Portable;
use crate::traverse::{SearchRay, Space};
use crate::triangle::{MIN_EDGE_SUM, distance, edge_test, precise, weights};
use crate::{Hit, Ray};

/// The nearest hit among triangles whose vertices are already in the units of the BVH.
pub(crate) fn closest(triangles: &[(u32, [[f32; 3]; 3])], ray: &Ray, space: &Space) -> Hit {
    let Some(search) = SearchRay::new(Portable, ray, space) else { return Hit::MISS };
    let mut best = Hit { t: search.t_max, ..Hit::MISS };
    for &(primitive, corners) in triangles {
        let Some([t, u, v]) = one(&search, corners) else { continue };
        if t < best.t || t == best.t && primitive < best.primitive {
            best = Hit { t, u, v, primitive };
        }
    }
    search.finish(best)
}

/// The scalar test of one triangle.
fn one(ray: &SearchRay, corners: [[f32; 3]; 3]) -> Option<[f32; 3]> {
    let sheared = corners.map(|p| ray.shear.corner(p));
    let lanes = sheared.map(|p| p.map(|x| [x; 1]));
    let (inside, edges) = edge_test(&lanes, [0.0]);
    if inside == 0 {
        return None;
    }
    let z = ray.shear.shear[2];
    let ([t], sum) = distance(&lanes, &edges, [z]);
    if !(ray.t_min <= t && t < f32::INFINITY && MIN_EDGE_SUM <= sum[0].abs()) {
        return None;
    }
    let [[u], [v], [off]] = weights(&lanes, &edges, [1.0], sum);
    if off <= ray.shear.tolerance { Some([t, u, v]) } else { precise(&sheared, z, ray.shear.tolerance, t) }
}
