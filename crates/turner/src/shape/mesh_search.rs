//! From f64 rays to the f32 rays of a mesh's tree.
//!
//! The tree holds the mesh's own f32 vertices, which must not be rounded. A mesh far from its origin is shifted
//! towards the origin, axis by axis, by an amount that is exact for every vertex; where no such amount exists,
//! that axis is not shifted. Each ray is moved along itself, in f64, to near the sphere around the mesh, before
//! it is rounded to f32:
//!
//! ```text
//!                                 ___
//!      ray.origin              /       \
//!      o - - - - - - - - - -> o────────────────>
//!                       start  \  mesh /
//!                                 ‾‾‾
//! ```
//!
//! The error is bounded: let `size` be the largest coordinate of a ray within reach. Origin and direction are
//! rounded by 4 · 2^-24 `size` in total, and the search reports points within 20 · 2^-23 `size` of the ray (see
//! `turner_bvh`). Both are less than [`PAD`] · `size`. A search that begins and ends that much early and late
//! therefore finds every hit.

use turner_bvh::Hit;

use crate::math::{Bounds, DVec3, Ray};

/// Bound on the distance of an f32 hit from the true one, in units of the largest coordinate.
const PAD: f64 = 1.0 / (1 << 17) as f64;

/// A hit this many paddings before the end of a ray is before it in f64, too.
pub(super) const PAD_STEPS: f64 = 2.0;

/// The positions of a mesh and of its tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MeshSpace {
    center: DVec3,
    /// Subtracted from positions before they are put into the tree.
    shift: DVec3,
    /// Radius of a sphere around all used vertices; negative if there are none.
    radius: f64,
    /// Padding, in units of length.
    pad: f64,
}

/// A ray to search the tree with, and how to convert its hits back.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeshRay {
    pub(super) original: Ray,
    pub(super) ray: turner_bvh::Ray,
    /// Unit direction in f64.
    direction: DVec3,
    /// Length per unit of t.
    speed: f64,
    pad: f64,
    /// Rounding error of f64 distances along the ray.
    rounding: f64,
    /// Hits up to here may lie before `t_min`.
    safe_min: f32,
    /// Hits from here on may lie beyond `t_max`.
    safe_max: f32,
}

impl MeshRay {
    /// Whether the f64 hit may lie before `t_min`.
    #[inline(always)]
    pub(super) fn may_precede_start(&self, hit: &Hit) -> bool {
        hit.t <= self.safe_min
    }

    /// Whether the f64 hit is between the ray's ends in any case.
    #[inline(always)]
    pub(super) fn is_safe(&self, hit: &Hit) -> bool {
        hit.t > self.safe_min && hit.t < self.safe_max
    }

    /// Whether `t` is not beyond the ray's end.
    #[inline(always)]
    pub(super) fn ends_after(&self, t: f64) -> bool {
        t <= self.original.t_max && t < f64::INFINITY
    }

    /// Whether this distance between a ray and a triangle exceeds rounding.
    pub(super) fn is_clear_miss(&self, distance: f64) -> bool {
        !(distance <= self.rounding)
    }

    /// Rays parallel to this one, offset by a little more than the search error, limited to the neighbourhood
    /// of a hit.
    pub(super) fn offset_rays(&self, hit: &Hit) -> [turner_bvh::Ray; 16] {
        let (x, y) = self.direction.any_orthonormal_pair();
        let room = (16.0 * self.pad) as f32;
        // Eight directions in a half circle, about 22.5 degrees apart; each is used with both signs.
        let around = [(1.0, 0.0), (0.92, 0.38), (0.71, 0.71), (0.38, 0.92)];
        let around = around.iter().flat_map(|&(a, b)| [(a, b), (-b, a)]).collect::<Vec<_>>();
        std::array::from_fn(|i| {
            let (a, b) = around[i / 2];
            let step = if i % 2 == 0 { 0.125 * self.pad } else { -0.125 * self.pad };
            let origin = DVec3::from(self.ray.origin.map(f64::from)) + step * (a * x + b * y);
            turner_bvh::Ray {
                origin: origin.as_vec3().to_array(),
                t_min: (hit.t - room).max(0.0),
                t_max: hit.t + room,
                ..self.ray
            }
        })
    }

    /// The t of the point on the ray nearest to `p`.
    pub(super) fn t_of(&self, p: DVec3) -> f64 {
        (p - self.original.origin).dot(self.direction) / self.speed
    }
}

impl MeshSpace {
    pub(super) fn new(bounds: &Bounds, positions: &[[f32; 3]]) -> MeshSpace {
        if bounds.is_empty() || !bounds.is_finite() {
            return MeshSpace { center: DVec3::ZERO, shift: DVec3::ZERO, radius: -1.0, pad: 0.0 };
        }
        let (center, half) = (bounds.center(), 0.5 * bounds.size());
        let mut shift = DVec3::ZERO;
        for axis in 0..3 {
            // A shift of a centre nearer than this gains less than three bits.
            if center[axis].abs() > 8.0 * half[axis] {
                shift[axis] = lossless_shift(positions, axis, bounds);
            }
        }
        // The values come from f32's range: no underflow or overflow in f64.
        let radius = half.length() * (1.0 + 1e-12);
        let size = (center - shift).abs().max_element() + 4.0 * radius;
        MeshSpace { center, shift, radius, pad: PAD * size + f64::from(f32::MIN_POSITIVE) }
    }

    /// Whether the mesh has nothing to hit.
    pub(super) fn is_empty(&self) -> bool {
        self.radius < 0.0
    }

    /// Centre of the mesh.
    pub(super) fn center(&self) -> DVec3 {
        self.center
    }

    /// The vector subtracted from positions.
    pub(super) fn shift(&self) -> DVec3 {
        self.shift
    }

    /// Padding, in units of length.
    pub(super) fn pad(&self) -> f64 {
        self.pad
    }

    /// Rays that pass the centre at more than this distance miss the mesh.
    pub(super) fn reach(&self) -> f64 {
        self.radius + self.pad
    }

    /// Positions for the tree, if they differ from those of the mesh.
    pub(super) fn moved(&self, positions: &[[f32; 3]]) -> Option<Vec<[f32; 3]>> {
        let moved = |p: &[f32; 3]| [0, 1, 2].map(|i| (f64::from(p[i]) - self.shift[i]) as f32);
        (self.shift != DVec3::ZERO).then(|| positions.iter().map(moved).collect())
    }

    /// The ray to search with; `None` if it misses the bounding sphere or is invalid (NaN, infinite, zero
    /// direction).
    #[inline]
    pub(super) fn ray(&self, ray: &Ray) -> Option<MeshRay> {
        let o = ray.origin - self.center;
        let speed = ray.direction.length();
        let inv = 1.0 / speed;
        if !(inv > 0.0 && inv < f64::INFINITY) || self.radius < 0.0 {
            return None;
        }
        let direction = ray.direction * inv;
        let nearest = -o.dot(direction);
        let reach = self.reach();
        let first = ray.t_min * speed;
        let (begin, start) = (nearest - 2.0 * reach, first - 2.0 * self.pad);
        let start = if begin > start { begin } else { start };
        if !((o + direction * nearest).length_squared() <= reach * reach && start <= nearest + 2.0 * reach) {
            return None;
        }
        // Matters for rays that begin very far away.
        let rounding = 1e-10 * self.pad + 4.0 * f64::EPSILON * nearest.abs();
        let pad = self.pad + rounding;
        let p = o + direction * start + (self.center - self.shift);
        let search = turner_bvh::Ray {
            origin: p.as_vec3().to_array(),
            direction: direction.as_vec3().to_array(),
            t_min: 0.0,
            t_max: (ray.t_max * speed - start + 2.0 * pad) as f32,
        };
        let safe_min = (first - start + 2.0 * pad) as f32;
        let safe_max = (ray.t_max * speed - start - PAD_STEPS * pad) as f32;
        Some(MeshRay { original: *ray, ray: search, direction, speed, pad, rounding, safe_min, safe_max })
    }
}

/// A shift near the centre of the positions on one axis that f32 represents exactly for all of them, or 0.
fn lossless_shift(positions: &[[f32; 3]], axis: usize, bounds: &Bounds) -> f64 {
    let (low, high) = (bounds.min[axis], bounds.max[axis]);
    let far = low.abs().max(high.abs()) as f32;
    // The last bit (ulp) of the largest coordinate.
    let unit = f64::from(far) - f64::from(far.next_down());
    let shift = (0.5 * (low + high) / unit).round() * unit;
    let exact = positions.iter().all(|p| {
        let moved = f64::from(p[axis]) - shift;
        !p[axis].is_finite()
            || f64::from(moved as f32) == moved
            || !(low..=high).contains(&f64::from(p[axis]))
    });
    if exact { shift } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moving_loses_nothing_or_is_not_done() {
        let far: Vec<[f32; 3]> =
            (0..100).map(|i| [1e5 + i as f32 * 0.01, i as f32, -3e6 - i as f32]).collect();
        let bounds = Bounds::of(far.iter().map(|p| DVec3::from(p.map(f64::from))));
        let space = MeshSpace::new(&bounds, &far);
        assert!(space.shift.x != 0.0 && space.shift.y == 0.0 && space.shift.z != 0.0);
        for (p, q) in far.iter().zip(space.moved(&far).unwrap()) {
            for i in 0..3 {
                assert_eq!(f64::from(p[i]) - space.shift[i], f64::from(q[i]));
            }
        }
        // Meshes near the origin are not shifted.
        let near = [[0.0_f32; 3], [1.0; 3]];
        let space = MeshSpace::new(&Bounds::new(DVec3::ZERO, DVec3::ONE), &near);
        assert!(space.moved(&near).is_none());
    }
}
