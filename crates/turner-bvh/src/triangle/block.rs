//! Blocks of eight triangles, one per SIMD lane.

use super::{Corners, MIN_EDGE_SUM, Shear, distance, edge_test, precise, weights};
use crate::Hit;
use crate::build::wide::NO_PRIMITIVE;
use crate::simd::{Lanes, Simd};

/// Triangles per block: the number of lanes of a 256-bit register.
pub(crate) const BLOCK: usize = 8;

/// Triangles of a leaf: 40 bytes each.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct Block {
    /// Coordinates by vertex and axis.
    pub(crate) corners: [[[f32; BLOCK]; 3]; 3],
    /// Triangle indices; `NO_PRIMITIVE` in empty lanes, whose vertices are NaN.
    pub(crate) ids: [u32; BLOCK],
}

const _: () = assert!(size_of::<Block>() == 40 * BLOCK);

impl Block {
    pub(crate) const EMPTY: Block =
        Block { corners: [[[f32::NAN; BLOCK]; 3]; 3], ids: [NO_PRIMITIVE; BLOCK] };

    pub(crate) fn set(&mut self, lane: usize, id: u32, corners: [[f32; 3]; 3]) {
        for (corner, p) in corners.into_iter().enumerate() {
            for (axis, x) in p.into_iter().enumerate() {
                self.corners[corner][axis][lane] = x;
            }
        }
        self.ids[lane] = id;
    }

    pub(crate) fn lane(&self, lane: usize) -> [[f32; 3]; 3] {
        self.corners.map(|corner| corner.map(|axis| axis[lane]))
    }

    /// All triangles in the sheared space of the ray.
    #[inline(always)]
    fn sheared<S: Simd>(&self, simd: S, ray: &Shear) -> Corners<S::F8> {
        let [a, b, c] = &self.corners;
        [
            Self::sheared_corner(simd, ray, a),
            Self::sheared_corner(simd, ray, b),
            Self::sheared_corner(simd, ray, c),
        ]
    }

    /// One vertex of each triangle: [`Shear::corner`] in all lanes.
    #[inline(always)]
    fn sheared_corner<S: Simd>(simd: S, ray: &Shear, corner: &[[f32; BLOCK]; 3]) -> [S::F8; 3] {
        let [x, y, z] = ray.axes.refs(corner);
        let [x, y, z] = [simd.load8(x), simd.load8(y), simd.load8(z)];
        let [sx, sy, _] = ray.shear;
        let [ox, oy, oz] = ray.origin;
        [
            x.sub(simd.splat8(sx).mul(z)).sub(simd.splat8(ox)),
            y.sub(simd.splat8(sy).mul(z)).sub(simd.splat8(oy)),
            z.sub(simd.splat8(oz)),
        ]
    }

    /// Passes each hit with `t_min <= t <= t_max` to `accept` until it returns true; returns whether it did.
    #[inline(always)]
    fn each_hit<S: Simd>(
        &self,
        simd: S,
        ray: &Shear,
        t_min: f32,
        t_max: f32,
        mut accept: impl FnMut(f32, f32, f32, u32) -> bool,
    ) -> bool {
        let corners = self.sheared(simd, ray);
        let (inside, edges) = edge_test(&corners, simd.splat8(0.0));
        // No early exit if no triangle passes: among the eight of a leaf, one usually does.
        let (t, sum) = distance(&corners, &edges, simd.splat8(ray.shear[2]));
        let mut candidates = inside & simd.splat8(t_min).le(t) & t.le(simd.splat8(t_max));
        if candidates == 0 {
            return false;
        }
        candidates &= simd.splat8(MIN_EDGE_SUM).le(sum.abs());
        let [u, v, off] = weights(&corners, &edges, simd.splat8(1.0), sum);
        let close = off.le(simd.splat8(ray.tolerance));
        let [mut ts, mut us, mut vs] = [[0.0; BLOCK]; 3];
        t.store(&mut ts);
        u.store(&mut us);
        v.store(&mut vs);
        while candidates != 0 {
            let lane = candidates.trailing_zeros() as usize % BLOCK;
            candidates &= candidates - 1;
            let (mut t, mut u, mut v) = (ts[lane], us[lane], vs[lane]);
            if close >> lane & 1 == 0 {
                [t, u, v] = self.doubtful(ray, lane, t);
            }
            if t <= t_max && t < f32::INFINITY && accept(t, u, v, self.ids[lane]) {
                return true;
            }
        }
        false
    }

    /// Tests a nearly edge-on triangle again in double precision; NaN if it is not hit.
    #[cold]
    #[inline(never)]
    pub(crate) fn doubtful(&self, ray: &Shear, lane: usize, t: f32) -> [f32; 3] {
        let corners = self.lane(lane).map(|p| ray.corner(p));
        precise(&corners, ray.shear[2], ray.tolerance, t).unwrap_or([f32::NAN; 3])
    }

    /// Updates `hit` with the nearest hit; among equally near ones, the lowest index.
    #[inline(always)]
    pub(crate) fn closest<S: Simd>(
        &self,
        simd: S,
        ray: &Shear,
        t_min: f32,
        hit: &mut Hit,
        mut filter: impl FnMut(&Hit) -> bool,
    ) {
        self.each_hit(simd, ray, t_min, hit.t, |t, u, v, primitive| {
            if t < hit.t || (t == hit.t && primitive < hit.primitive) {
                let candidate = Hit { t, u, v, primitive };
                if filter(&candidate) {
                    *hit = candidate;
                }
            }
            false
        });
    }

    /// Whether there is a hit with `t_min <= t <= t_max` that `filter` accepts.
    #[inline(always)]
    pub(crate) fn any<S: Simd>(
        &self,
        simd: S,
        ray: &Shear,
        t_min: f32,
        t_max: f32,
        mut filter: impl FnMut(&Hit) -> bool,
    ) -> bool {
        self.each_hit(simd, ray, t_min, t_max, |t, u, v, primitive| filter(&Hit { t, u, v, primitive }))
    }
}
