//! A ray prepared for traversal, and the conservative slab test.
//!
//! A box is the intersection of three slabs. On each axis the ray is inside the slab from `t_near` to `t_far`:
//!
//! ```text
//!            |       |                entry = max(t_min, t_near of x, y, z)
//!       -----+-------*---- y max      exit  = min(t_max, t_far of x, y, z)
//!            |     / |
//!            |   /   |                The ray hits the box if entry <= exit.
//!            | /     |
//!       -----*-------+---- y min
//!          x min   x max
//! ```
//!
//! Each value is `plane * inv + offset` with `inv = 1 / direction` and `offset = -origin * inv`. All boxes share `inv`
//! and `offset`, and so their rounding. Boxes are padded by moving the *ray*: near and far planes have different
//! offsets, which costs nothing per box.
//!
//! The padding: let `size` be the largest coordinate of the origin plus that of any plane, and `e = 2^-23`. A hit point
//! lies on its triangle up to `2 e size` that the triangle test allows, `3 e size` from rounding the vertices, `6 e
//! size` from summing them and `6 e size` along the ray. The slab test adds `3 e size` (one rounding each of `inv`, the
//! offset, the product and the difference). The sum is 20; [`PADDING`] is larger. So the ray enters every box that
//! contains the hit point on the triangle at or before the hit, with every instruction set.

use crate::node::WideNode;
use crate::simd::{Lanes, Simd};
use crate::triangle::Shear;
use crate::{Hit, Ray};

/// Padding of boxes in units of `f32::EPSILON * size`.
pub(super) const PADDING: f32 = 24.0;

/// The largest supported coordinate: products of three such numbers are finite.
pub(crate) const MAX_COORDINATE: f32 = (1_u64 << 40) as f32;

/// Directions are not rescaled if their longest component is between `1 / MAX_DIRECTION` and `MAX_DIRECTION`.
pub(super) const MAX_DIRECTION: f32 = (1 << 20) as f32;

/// Each component of a direction is raised to at least this fraction of the longest one.
pub(super) const MIN_COMPONENT: f32 = 1.0 / (1_u64 << 40) as f32;

/// The coordinate system of a BVH.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Space {
    /// BVH units per caller's unit: a power of two, 1 unless the BVH is very large or small.
    pub(crate) scale: f32,
    /// `1 / scale`.
    pub(crate) unscale: f32,
    /// The largest absolute coordinate in the BVH.
    pub(crate) reach: f32,
}

impl Space {
    /// For a BVH with these nodes.
    pub(crate) fn of(scale: f32, nodes: &[WideNode]) -> Space {
        let planes = nodes.first().into_iter().flat_map(|root| root.planes.iter().flatten().flatten());
        let reach = planes.map(|x| x.abs()).filter(|x| x.is_finite()).fold(0.0, f32::max);
        Space { scale, unscale: 1.0 / scale, reach }
    }
}

/// A ray in the units of a BVH. Very long or short directions are scaled by a power of two.
///
/// [`prepare`](super::prepare) writes it as four rows of eight floats.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct SearchRay {
    pub(super) inv: [f32; 3],
    pub(crate) t_min: f32,
    pub(super) near_offset: [f32; 3],
    pub(crate) t_max: f32,
    pub(super) far_offset: [f32; 3],
    /// Factor from t in the BVH to the caller's t.
    pub(crate) t_scale: f32,
    /// Byte offsets of the near planes on each axis: see [`WideNode::side`].
    pub(super) near_side: [u32; 3],
    /// The signs of the direction as three bits: selects the order of children.
    pub(crate) octant: u32,
    pub(crate) shear: Shear,
    pub(super) spare: [f32; 6],
}

/// Rows of eight floats in a [`SearchRay`].
pub(super) const ROWS: usize = 4;
const _: () = assert!(size_of::<SearchRay>() == 32 * ROWS);

impl SearchRay {
    /// A placeholder.
    pub(crate) const NONE: SearchRay = SearchRay {
        inv: [0.0; 3],
        t_min: 0.0,
        near_offset: [0.0; 3],
        t_max: 0.0,
        far_offset: [0.0; 3],
        t_scale: 1.0,
        near_side: [0; 3],
        octant: 0,
        shear: Shear::NONE,
        spare: [0.0; 6],
    };

    /// The hit in the caller's units.
    #[inline(always)]
    pub(crate) fn finish(&self, hit: Hit) -> Hit {
        if hit.is_hit() { Hit { t: hit.t * self.t_scale, ..hit } } else { Hit::MISS }
    }

    /// `None` for rays that cannot hit anything: NaN or infinite, without a direction, with an empty interval, or with
    /// an origin out of range.
    #[inline(always)]
    pub(crate) fn new<S: Simd>(simd: S, ray: &Ray, space: &Space) -> Option<SearchRay> {
        let ([ox, oy, oz], [dx, dy, dz]) = (ray.origin, ray.direction);
        // The fourth lanes load the floats that follow in memory; they are ignored.
        let mut origin = simd.load4(&[ox, oy, oz, dx]);
        let mut direction = simd.load4(&[dx, dy, dz, ray.t_min]);
        let mut longest = larger(larger(dx.abs(), dy.abs()), dz.abs());
        let (mut t_scale, mut to_tree) = (1.0, 1.0);
        let ordinary = space.scale == 1.0 && (1.0 / MAX_DIRECTION..=MAX_DIRECTION).contains(&longest);
        if !ordinary {
            [t_scale, to_tree, longest] = rescale(space, longest);
            // A direction of length 1 has length `scale` in the BVH, so t does not change.
            origin = origin.mul(simd.splat4(space.scale));
            direction = direction.mul(simd.splat4(t_scale * space.scale));
        }
        let within = origin.abs().le(simd.splat4(MAX_COORDINATE)) & direction.abs().le(simd.splat4(f32::MAX));
        let usable =
            within & 7 == 7 && longest >= f32::MIN_POSITIVE && ray.t_min <= ray.t_max && ray.t_max >= 0.0;
        if !usable {
            return None;
        }
        let [origin_in_tree, direction_in_tree] = [array(origin), array(direction)];
        let [ox, oy, oz] = origin_in_tree;
        let far = larger(larger(ox.abs(), oy.abs()), oz.abs());
        let size = far + space.reach;
        let padding = PADDING * size * f32::EPSILON;
        let d = direction.abs().max(simd.splat4(MIN_COMPONENT * longest)).with_sign(direction);
        let inv = simd.splat4(1.0).div(d);
        let scaled_origin = origin.mul(inv);
        let pad = simd.splat4(padding).mul(inv.abs());
        let down = d.lt(simd.splat4(0.0)) & 7;
        let [x, y, z] = [down & 1, down >> 1 & 1, down >> 2];
        Some(SearchRay {
            inv: array(inv),
            near_offset: array(simd.splat4(0.0).sub(scaled_origin).sub(pad)),
            far_offset: array(pad.sub(scaled_origin)),
            spare: [0.0; 6],
            near_side: [x * WideNode::UPPER, y * WideNode::UPPER, z * WideNode::UPPER],
            octant: down,
            t_min: larger(ray.t_min, 0.0) * to_tree,
            t_max: smaller(ray.t_max * to_tree, f32::MAX * smaller(to_tree, 1.0)),
            t_scale,
            shear: Shear::new(simd, &origin_in_tree, &direction_in_tree, size),
        })
    }

    /// The data of the slab test in registers.
    #[inline(always)]
    pub(crate) fn slabs<S: Simd>(&self, simd: S) -> Slabs<S::F8> {
        let [x, y, z] = self.near_side;
        Slabs {
            inv: splat(simd, self.inv),
            near_offset: splat(simd, self.near_offset),
            far_offset: splat(simd, self.far_offset),
            t_min: simd.splat8(self.t_min),
            near_side: [x, y, z],
            far_side: [x ^ WideNode::UPPER, y ^ WideNode::UPPER, z ^ WideNode::UPPER],
            octant: self.octant as usize & 7,
        }
    }
}

/// A ray, broadcast to eight lanes.
#[derive(Clone, Copy)]
pub(crate) struct Slabs<V> {
    inv: [V; 3],
    near_offset: [V; 3],
    far_offset: [V; 3],
    t_min: V,
    near_side: [u32; 3],
    far_side: [u32; 3],
    /// See [`SearchRay::octant`].
    pub(crate) octant: usize,
}

impl<V: Lanes> Slabs<V> {
    /// For each box, a lower bound of the t at which the ray enters it and an upper bound of the t at which it leaves
    /// it (at most `t_max`). The ray hits the box if entry <= exit.
    #[inline(always)]
    pub(crate) fn intersect<S: Simd<F8 = V>>(&self, simd: S, node: &WideNode, t_max: f32) -> (V, V) {
        let near = [self.near(simd, node, 0), self.near(simd, node, 1), self.near(simd, node, 2)];
        let far = [self.far(simd, node, 0), self.far(simd, node, 1), self.far(simd, node, 2)];
        let entry = near[0].max(near[1]).max(near[2].max(self.t_min));
        let exit = far[0].min(far[1]).min(far[2].min(simd.splat8(t_max)));
        (entry, exit)
    }

    /// t of the eight near planes.
    #[inline(always)]
    fn near<S: Simd<F8 = V>>(&self, simd: S, node: &WideNode, axis: usize) -> V {
        simd.load8(node.side(axis, self.near_side[axis])).mul_add(self.inv[axis], self.near_offset[axis])
    }

    #[inline(always)]
    fn far<S: Simd<F8 = V>>(&self, simd: S, node: &WideNode, axis: usize) -> V {
        simd.load8(node.side(axis, self.far_side[axis])).mul_add(self.inv[axis], self.far_offset[axis])
    }
}

#[inline(always)]
fn splat<S: Simd>(simd: S, [x, y, z]: [f32; 3]) -> [S::F8; 3] {
    [simd.splat8(x), simd.splat8(y), simd.splat8(z)]
}

#[inline(always)]
fn array<V: Lanes>(lanes: V) -> [f32; 3] {
    let mut array = [0.0; 4];
    lanes.store(&mut array);
    let [x, y, z, _] = array;
    [x, y, z]
}

#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// For very long or short directions and very large or small BVHs. Returns the factor from t in the BVH to the caller's
/// t, its inverse, and the longest component of the direction in the BVH, which is 1 to 2.
#[cold]
#[inline(never)]
fn rescale(space: &Space, longest: f32) -> [f32; 3] {
    if !(f32::MIN_POSITIVE..=f32::MAX).contains(&longest) {
        return [1.0, 1.0, 0.0];
    }
    // 2^-e for a longest component in 2^e..2^(e + 1). If that is not a normal number, half of it suffices.
    let exponent = longest.to_bits() >> 23;
    let normal = f32::from_bits((254 - exponent).max(1) << 23);
    let back = f32::from_bits(exponent.min(253) << 23);
    [normal * space.unscale, back * space.scale, longest * normal]
}
