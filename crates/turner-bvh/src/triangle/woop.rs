//! Watertight ray-triangle intersection (Woop, Benthin, Wald 2013, "Watertight ray/triangle intersection").
//!
//! Transform space so that the ray starts at the origin and runs along +z: translate the origin, permute the axes so
//! that the direction is longest in z, and shear x and y. The problem becomes two-dimensional: is the origin inside the
//! projected triangle?
//!
//! ```text
//!            C                 edge functions (signed areas, times 2):
//!           / \                    U = C.x B.y - C.y B.x      opposite A
//!          /   \                   V = A.x C.y - A.y C.x      opposite B
//!         /  o  \                  W = B.x A.y - B.y A.x      opposite C
//!        A-------B             hit if U, V, W are all >= 0 or all <= 0
//!      o: the ray, seen        t = (U A.z + V B.z + W C.z) / (U + V + W) * (1 / direction.z)
//!         along z              weights of A, B, C: U, V, W divided by U + V + W
//! ```
//!
//! **Watertight.** A vertex has the same sheared coordinates in every triangle that shares it. The rounded edge
//! function `fl(fl(c.x b.y) - fl(c.y b.x))` changes sign exactly when both vertices swap. Rounding is monotone, so its
//! sign is correct or it is 0, which counts as inside for both neighbours. So at least one of the triangles around an
//! edge or a vertex takes the ray. Fused multiply-add would break both properties.
//!
//! **A hit lies on its triangle.** The weights of an edge-on triangle are mostly rounding error. A hit is accepted only
//! if the point given by its weights is within [`Shear::tolerance`] of the ray. Otherwise the weights are computed
//! again in double precision, and t is the larger of both values (so that traversal may skip everything behind its
//! nearest hit by the first t alone, in any order of triangles). Hence any box around that part of the triangle, padded
//! by a few tolerances, contains the hit: no BVH can lose it, however its boxes are cut.

use crate::simd::{Lanes, Simd};

/// A permutation of the three axes, as indices below 3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub(crate) struct Axes([u32; 3]);

impl Axes {
    pub(crate) const XYZ: Axes = Axes([0, 1, 2]);
    pub(crate) const YZX: Axes = Axes([1, 2, 0]);
    pub(crate) const ZXY: Axes = Axes([2, 0, 1]);

    /// The last axis.
    #[inline(always)]
    pub(crate) fn last(self) -> usize {
        self.0[2] as usize % 3
    }

    /// The components in this order.
    #[inline(always)]
    pub(crate) fn of<T: Copy>(self, xyz: &[T; 3]) -> [T; 3] {
        let [x, y, z] = self.refs(xyz);
        [*x, *y, *z]
    }

    /// References to the components in this order.
    #[inline(always)]
    pub(crate) fn refs<T>(self, xyz: &[T; 3]) -> [&T; 3] {
        let [x, y, z] = self.0;
        // SAFETY: the indices are below 3.
        unsafe {
            [xyz.get_unchecked(x as usize), xyz.get_unchecked(y as usize), xyz.get_unchecked(z as usize)]
        }
    }
}

/// The transformation of a ray, for any number of triangles.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct Shear {
    /// x and y of the direction divided by its z, and 1 / z, in the permuted axes.
    pub(crate) shear: [f32; 3],
    /// How far from the ray the point given by the weights may lie.
    pub(crate) tolerance: f32,
    /// Sheared x and y of the origin, and its z.
    pub(crate) origin: [f32; 3],
    /// Axis order: the longest axis of the direction last.
    pub(crate) axes: Axes,
}

impl Shear {
    /// A placeholder.
    pub(crate) const NONE: Shear =
        Shear { axes: Axes::XYZ, origin: [0.0; 3], shear: [0.0; 3], tolerance: 0.0 };

    /// For a ray with a finite, non-zero direction. `size` is the largest coordinate of its origin plus that of any
    /// triangle.
    #[inline(always)]
    pub(crate) fn new<S: Simd>(simd: S, origin: &[f32; 3], direction: &[f32; 3], size: f32) -> Shear {
        let [x, y, z] = [direction[0].abs(), direction[1].abs(), direction[2].abs()];
        // By arithmetic: a branch on the longest axis would be mispredicted.
        let y_over_x = y > x;
        let other = if y_over_x { y } else { x };
        let longest = if z >= other { 2 } else { usize::from(y_over_x) };
        let axes = [Axes::YZX, Axes::ZXY, Axes::XYZ][longest];
        let [x, y, z] = axes.of(direction);
        let mut shear = [0.0; 4];
        simd.load4(&[x, y, 1.0, 1.0]).div(simd.splat4(z)).store(&mut shear);
        let [x, y, z, _] = shear;
        let [ox, oy, oz] = axes.of(origin);
        let origin = [ox - x * oz, oy - y * oz, oz];
        Shear { axes, shear: [x, y, z], origin, tolerance: 2.0 * f32::EPSILON * size }
    }

    /// A vertex in the sheared space of the ray.
    #[inline(always)]
    pub(crate) fn corner(&self, p: [f32; 3]) -> [f32; 3] {
        let p = self.axes.of(&p);
        let [x, y] = [0, 1].map(|i| p[i] - self.shear[i] * p[2] - self.origin[i]);
        [x, y, p[2] - self.origin[2]]
    }
}

/// The least sum of edge functions that counts: products with smaller ones lose precision. The vertices of such
/// triangles are about 2^-50 apart, which is nothing in the coordinates of a BVH.
pub(crate) const MIN_EDGE_SUM: f32 = 1.0 / (1_u128 << 100) as f32;

/// Sheared x, y, z of three vertices, one triangle per lane.
pub(crate) type Corners<V> = [[V; 3]; 3];

/// The lanes in which the ray's line passes through the triangle, and the edge functions.
#[inline(always)]
pub(crate) fn edge_test<V: Lanes>([a, b, c]: &Corners<V>, zero: V) -> (u32, [V; 3]) {
    let u = c[0].mul(b[1]).sub(c[1].mul(b[0]));
    let v = a[0].mul(c[1]).sub(a[1].mul(c[0]));
    let w = b[0].mul(a[1]).sub(b[1].mul(a[0]));
    let least = u.min(v).min(w);
    let most = u.max(v).max(w);
    (zero.le(least) | most.le(zero), [u, v, w])
}

/// t of the intersections, and the sums of the edge functions. t is NaN or infinite where a triangle is degenerate or a
/// value is not finite.
#[inline(always)]
pub(crate) fn distance<V: Lanes>(corners: &Corners<V>, edges: &[V; 3], shear_z: V) -> (V, V) {
    let (depth, sum) = depth(corners, edges);
    (depth.div(sum).mul(shear_z), sum)
}

/// Numerator and denominator of [`distance`]: t is their quotient times `shear[2]`.
#[inline(always)]
pub(crate) fn depth<V: Lanes>([a, b, c]: &Corners<V>, &[u, v, w]: &[V; 3]) -> (V, V) {
    (u.mul(a[2]).add(v.mul(b[2])).add(w.mul(c[2])), u.add(v).add(w))
}

/// Weights of the second and third vertex, and the distance from the ray of the point they give.
#[inline(always)]
pub(crate) fn weights<V: Lanes>([a, b, c]: &Corners<V>, &[u, v, w]: &[V; 3], one: V, sum: V) -> [V; 3] {
    let scale = one.div(sum);
    let (u, v, w) = (u.mul(scale), v.mul(scale), w.mul(scale));
    let x = u.mul(a[0]).add(v.mul(b[0])).add(w.mul(c[0]));
    let y = u.mul(a[1]).add(v.mul(b[1])).add(w.mul(c[1]));
    [v, w, x.abs().max(y.abs())]
}

/// The same in double precision for nearly edge-on triangles: products of two single-precision numbers are exact. Call
/// it only if the edge functions agree in sign. `None` if the triangle is degenerate or misses the ray.
#[cold]
#[inline(never)]
pub(crate) fn precise(corners: &Corners<f32>, shear_z: f32, tolerance: f32, t: f32) -> Option<[f32; 3]> {
    let [a, b, c] = corners.map(|p| p.map(f64::from));
    let u = c[0] * b[1] - c[1] * b[0];
    let v = a[0] * c[1] - a[1] * c[0];
    let w = b[0] * a[1] - b[1] * a[0];
    // Edge functions that single precision rounded to 0 may have the other sign here.
    let side = if u + v + w < 0.0 { -1.0 } else { 1.0 };
    let [u, v, w] = [u, v, w].map(|x| (x * side).max(0.0));
    let sum = u + v + w;
    if !(sum > 0.0 && sum.is_finite()) {
        return None;
    }
    let (u, v, w) = (u / sum, v / sum, w / sum);
    let point = [0, 1, 2].map(|i| u * a[i] + v * b[i] + w * c[i]);
    let near = point[0].abs().max(point[1].abs()) <= f64::from(tolerance);
    let precise = (point[2] * f64::from(shear_z)) as f32;
    near.then_some([precise.max(t), v as f32, w as f32])
}
