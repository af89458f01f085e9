//! Plane intersection, eight rays at a time.

use turner_bvh::RayBlock;
use turner_bvh::lanes::LANES;

use crate::shape::Plane;

/// The t at which eight rays cross a plane, and the lanes with a valid crossing: as [`Plane::intersect`], operation
/// by operation, except for the test that the point is finite.
#[inline]
pub(crate) fn crossings(plane: &Plane, rays: &RayBlock) -> ([f64; LANES], u8) {
    let (mut ts, mut hit_lanes) = ([0.0; LANES], 0);
    let ([nx, ny, nz], [px, py, pz]) = (plane.normal.to_array(), plane.point.to_array());
    let ([ox, oy, oz], [dx, dy, dz]) = (&rays.origin, &rays.direction);
    for (lane, at) in ts.iter_mut().enumerate() {
        let speed = dx.0[lane] * nx + dy.0[lane] * ny + dz.0[lane] * nz;
        let t = ((px - ox.0[lane]) * nx + (py - oy.0[lane]) * ny + (pz - oz.0[lane]) * nz) / speed;
        let valid = t >= rays.t_min.0[lane]
            && t <= rays.t_max.0[lane]
            && t < f64::INFINITY
            && speed.abs() < f64::INFINITY;
        *at = t;
        hit_lanes |= u8::from(valid) << lane;
    }
    (ts, hit_lanes)
}
