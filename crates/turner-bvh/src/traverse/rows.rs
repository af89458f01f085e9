//! One ray per lane, tested against one triangle after the other.
//!
//! Hits equal those of single rays bit for bit, because triangles are tested by the same arithmetic.

use super::PacketLeaves;
use crate::Hit;
use crate::simd::{Lanes, Simd};
use crate::triangle::{Axes, BLOCK, Block, Corners, MIN_EDGE_SUM, Shear, depth, edge_test, weights};

/// The most rays in a row.
pub(super) const MAX_RAYS: usize = 16;

/// One float per ray.
pub(super) type Row = [f32; MAX_RAYS];

/// Error bounds of the approximate t: relative, and absolute for numbers below the normal range.
const MARGIN: f32 = 1.0 / 512.0;
const TINY: f32 = 1e-30;

/// Up to [`Simd::PACKET`] rays with the same longest axis, and their nearest hits so far.
pub(super) struct Rows {
    /// Axis order of the sheared space: see [`Shear`].
    pub(super) axes: Axes,
    pub(super) shear: [Row; 3],
    pub(super) origin: [Row; 3],
    pub(super) tolerance: Row,
    pub(super) t_min: Row,
    /// t of the nearest hits so far, or the ends of the rays; negative for rays that are finished.
    pub(super) t: Row,
    pub(super) u: Row,
    pub(super) v: Row,
    /// Triangle indices, as the bits of a float.
    pub(super) primitive: Row,
    /// Factor from t in the BVH to the caller's t.
    pub(super) t_scale: Row,
    /// Indices of the rays.
    pub(super) index: [u32; MAX_RAYS],
}

impl Rows {
    /// The nearest hit so far, with t in the units of the BVH.
    #[inline(always)]
    pub(super) fn hit(&self, i: usize) -> Hit {
        let primitive = self.primitive[i].to_bits();
        Hit { t: self.t[i], u: self.u[i], v: self.v[i], primitive }
    }

    /// A vertex in the sheared space of each ray: [`Shear::corner`], one ray per lane.
    #[inline(always)]
    fn sheared_corner<S: Simd>(&self, simd: S, corner: &[[f32; BLOCK]; 3], lane: usize) -> [S::Packet; 3] {
        let [x, y, z] = self.axes.refs(corner);
        let [x, y, z] = [simd.splat_packet(x[lane]), simd.splat_packet(y[lane]), simd.splat_packet(z[lane])];
        let [sx, sy] = [simd.load_packet(&self.shear[0]), simd.load_packet(&self.shear[1])];
        [
            x.sub(sx.mul(z)).sub(simd.load_packet(&self.origin[0])),
            y.sub(sy.mul(z)).sub(simd.load_packet(&self.origin[1])),
            z.sub(simd.load_packet(&self.origin[2])),
        ]
    }

    /// Tests a triangle. Updates the rays for which it is the nearest hit so far or, with `ANY`, any hit.
    #[inline(always)]
    pub(super) fn triangle<S: Simd, L: PacketLeaves, const ANY: bool>(
        &mut self,
        simd: S,
        leaves: &L,
        block: &Block,
        lane: usize,
    ) {
        let corners: Corners<S::Packet> = [
            self.sheared_corner(simd, &block.corners[0], lane),
            self.sheared_corner(simd, &block.corners[1], lane),
            self.sheared_corner(simd, &block.corners[2], lane),
        ];
        let (inside, edges) = edge_test(&corners, simd.splat_packet(0.0));
        if inside == 0 {
            return;
        }
        let (depth, sum) = depth(&corners, &edges);
        let (ends, t_min) = (simd.load_packet(&self.t), simd.load_packet(&self.t_min));
        let shear_z = simd.load_packet(&self.shear[2]);
        // Most triangles are clearly too near or too far, which an approximate t without a division shows. (t
        // underflows, or sums do, far below `TINY`; NaN is kept.)
        let approximate = depth.mul(sum.near_inverse()).mul(shear_z);
        let latest = ends.mul_add(simd.splat_packet(1.0 + MARGIN), simd.splat_packet(TINY));
        let earliest = t_min.mul_add(simd.splat_packet(1.0 - MARGIN), simd.splat_packet(-TINY));
        let possible = inside & !(latest.lt(approximate) | approximate.lt(earliest));
        if possible == 0 {
            return;
        }
        let t = depth.div(sum).mul(shear_z);
        let mut candidates = possible & t_min.le(t) & t.le(ends);
        if candidates == 0 {
            return;
        }
        candidates &= simd.splat_packet(MIN_EDGE_SUM).le(sum.abs());
        let [u, v, off] = weights(&corners, &edges, simd.splat_packet(1.0), sum);
        let close = off.le(simd.load_packet(&self.tolerance));
        let primitive = block.ids[lane];
        let nearer = t.lt(ends);
        // The common case: precise weights, no ties, no filter.
        if !leaves.is_filtered() && !ANY && candidates & !(close & nearer) == 0 {
            t.choose(candidates, ends).store(&mut self.t);
            u.choose(candidates, simd.load_packet(&self.u)).store(&mut self.u);
            v.choose(candidates, simd.load_packet(&self.v)).store(&mut self.v);
            let number = simd.splat_packet(f32::from_bits(primitive));
            number.choose(candidates, simd.load_packet(&self.primitive)).store(&mut self.primitive);
            return;
        }
        let [mut ts, mut us, mut vs] = [[0.0; MAX_RAYS]; 3];
        t.store(&mut ts);
        u.store(&mut us);
        v.store(&mut vs);
        while candidates != 0 {
            let i = candidates.trailing_zeros() as usize % MAX_RAYS;
            candidates &= candidates - 1;
            let (mut t, mut u, mut v) = (ts[i], us[i], vs[i]);
            if close >> i & 1 == 0 {
                [t, u, v] = block.doubtful(&self.shear_of(i), lane, t);
            }
            let hit = Hit { t, u, v, primitive };
            let nearer = t < self.t[i] || t == self.t[i] && (ANY || primitive < self.primitive[i].to_bits());
            let outside = Hit { t: t * self.t_scale[i], ..hit };
            if nearer && t < f32::INFINITY && leaves.accepts(self.index[i], &outside) {
                self.t[i] = if ANY { f32::NEG_INFINITY } else { t };
                self.u[i] = u;
                self.v[i] = v;
                self.primitive[i] = f32::from_bits(primitive);
            }
        }
    }

    #[inline(always)]
    fn shear_of(&self, i: usize) -> Shear {
        Shear {
            axes: self.axes,
            shear: [self.shear[0][i], self.shear[1][i], self.shear[2][i]],
            origin: [self.origin[0][i], self.origin[1][i], self.origin[2][i]],
            tolerance: self.tolerance[i],
        }
    }
}
