//! Four triangles, one per lane.

use super::{Corners, Shear, Weights, corners_meet, precise};
use crate::Hit;
use crate::build::wide::NO_PRIMITIVE;
use crate::simd::{Lanes, Simd};

/// Four triangles of a leaf: 160 bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub(crate) struct Triangle4 {
    /// By corner and axis.
    pub(crate) corners: [[[f32; 4]; 3]; 3],
    /// Numbers of the triangles; `NO_PRIMITIVE` in empty lanes, whose corners are NaN.
    pub(crate) ids: [u32; 4],
}

const _: () = assert!(size_of::<Triangle4>() == 160);

impl Triangle4 {
    pub(crate) const EMPTY: Triangle4 =
        Triangle4 { corners: [[[f32::NAN; 4]; 3]; 3], ids: [NO_PRIMITIVE; 4] };

    pub(crate) fn set(&mut self, lane: usize, id: u32, corners: [[f32; 3]; 3]) {
        for (corner, p) in corners.into_iter().enumerate() {
            for (axis, x) in p.into_iter().enumerate() {
                self.corners[corner][axis][lane] = x;
            }
        }
        self.ids[lane] = id;
    }

    /// All four as the ray sees them.
    #[inline(always)]
    fn sheared<S: Simd>(&self, simd: S, ray: &Shear) -> Corners<S::F4> {
        let origin = ray.origin.map(|x| simd.splat4(x));
        let shear = [simd.splat4(ray.shear[0]), simd.splat4(ray.shear[1])];
        let seen = |corner: usize| {
            let p = ray.axes.refs(&self.corners[corner]);
            let [x, y, z] = p.map(|p| simd.load4(p));
            [x.sub(shear[0].mul(z)).sub(origin[0]), y.sub(shear[1].mul(z)).sub(origin[1]), z.sub(origin[2])]
        };
        [seen(0), seen(1), seen(2)]
    }

    /// Hits with `t_min <= t <= hit.t`, each given to `accept`.
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
        let (inside, edges) = corners_meet(&corners, simd.splat4(0.0));
        if inside == 0 {
            return false;
        }
        let at = Weights::new(&corners, edges, simd.splat4(1.0), simd.splat4(ray.shear[2]));
        let within = simd.splat4(t_min).le(at.t) & at.t.le(simd.splat4(t_max));
        let close = at.off.le(simd.splat4(ray.tolerance));
        // A NaN in `off` alone is impossible: whatever makes one is in `t` too.
        let mut doubtful = inside & !close;
        let mut good = inside & close & within;
        if good | doubtful == 0 {
            return false;
        }
        let [mut t, mut u, mut v] = [[0.0; 4]; 3];
        at.t.store(&mut t);
        at.u.store(&mut u);
        at.v.store(&mut v);
        while doubtful != 0 {
            let lane = doubtful.trailing_zeros() as usize & 3;
            doubtful &= doubtful - 1;
            let corners = self.lane(lane).map(|p| ray.corner(p));
            if let Some(found) = precise(&corners, ray.shear[2], ray.tolerance) {
                [t[lane], u[lane], v[lane]] = found;
                good |= u32::from(t_min <= t[lane] && t[lane] <= t_max) << lane;
            }
        }
        while good != 0 {
            let lane = good.trailing_zeros() as usize & 3;
            good &= good - 1;
            if t[lane] < f32::INFINITY && accept(t[lane], u[lane], v[lane], self.ids[lane]) {
                return true;
            }
        }
        false
    }

    pub(crate) fn lane(&self, lane: usize) -> [[f32; 3]; 3] {
        self.corners.map(|corner| corner.map(|axis| axis[lane]))
    }

    /// Takes the nearest hit into `hit`, of equally near ones that of the lowest number.
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
                let candidate = Hit { t, u, v, primitive, instance: Hit::NONE };
                if filter(&candidate) {
                    *hit = candidate;
                }
            }
            false
        });
    }

    /// Whether there is a hit with `t_min <= t <= t_max`.
    #[inline(always)]
    pub(crate) fn any<S: Simd>(
        &self,
        simd: S,
        ray: &Shear,
        t_min: f32,
        t_max: f32,
        mut filter: impl FnMut(&Hit) -> bool,
    ) -> bool {
        self.each_hit(simd, ray, t_min, t_max, |t, u, v, primitive| {
            filter(&Hit { t, u, v, primitive, instance: Hit::NONE })
        })
    }
}
