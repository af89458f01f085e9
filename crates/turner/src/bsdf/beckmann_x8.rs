//! Beckmann's distribution of eight lanes, with the bits of [`Beckmann`](super::beckmann::Beckmann).

use std::f64::consts::{FRAC_2_SQRT_PI, PI};

use turner_bvh::lanes::{F64x8, Mask8, Simd, Vec3x8};

use super::beckmann::{
    ENOUGH, HALF_ROOT_PI, MAX_COT, MAX_SLOPE, MAX_STEPS, MIN_SLOPE, MIN_Z2, NEAR, START, START_COT,
};
use crate::math::elementary_x8::{clamp, exponential};
use crate::math::gaussian_x8::{gaussian_and_tail, inverse_erf, inverse_erf_start};

/// Isotropic facets of one width per lane.
#[derive(Clone, Copy)]
pub(super) struct BeckmannX8<S: Simd> {
    pub(super) a: F64x8<S>,
}

impl<S: Simd> BeckmannX8<S> {
    /// See [`Beckmann::d`](super::beckmann::Beckmann::d).
    #[inline(always)]
    pub(super) fn d(&self, simd: S, h: Vec3x8<S>) -> F64x8<S> {
        let splat = |v: f64| F64x8::splat(simd, v);
        let z2 = h.z * h.z;
        let (x, y) = (h.x / self.a, h.y / self.a);
        let d = exponential(simd, -(x * x + y * y) / z2) / (splat(PI) * self.a * self.a * z2 * z2);
        z2.lt(splat(MIN_Z2)).select(splat(0.0), d)
    }

    /// See [`Beckmann::lambda`](super::beckmann::Beckmann::lambda).
    #[inline(always)]
    pub(super) fn lambda(&self, simd: S, w: Vec3x8<S>) -> F64x8<S> {
        let splat = |v: f64| F64x8::splat(simd, v);
        let (x, y, z) = (self.a * w.x, self.a * w.y, w.z.abs());
        let slope = (x * x + y * y).sqrt();
        let cot = z / slope;
        let (e, tail) = gaussian_and_tail(simd, cot);
        let lambda = splat(0.5) * (e * splat(0.5 * FRAC_2_SQRT_PI) / cot - tail);
        let steep = slope.gt(splat(MIN_SLOPE) * z);
        steep.select(lambda.or_larger(splat(0.0)), splat(0.0))
    }

    /// Facets of some lanes; see [`Beckmann::sample_visible`](super::beckmann::Beckmann::sample_visible).
    #[inline(always)]
    pub(super) fn sample_visible(
        &self,
        simd: S,
        lanes: Mask8<S>,
        wo: Vec3x8<S>,
        u: [F64x8<S>; 2],
    ) -> Vec3x8<S> {
        let splat = |v: f64| F64x8::splat(simd, v);
        let (zero, one, two, end) = (splat(0.0), splat(1.0), splat(2.0), splat(MAX_SLOPE));
        let stretched = Vec3x8 { x: self.a * wo.x, y: self.a * wo.y, z: wo.z };
        let across = (stretched.x * stretched.x + stretched.y * stretched.y).sqrt();
        let inclined = across.gt(zero);
        let cos = inclined.select(stretched.x / across, one);
        let sin = inclined.select(stretched.y / across, zero);
        let x = -visible_slope(simd, lanes, stretched.z / across, u[0]);
        let y = clamp(inverse_erf(simd, two * u[1] - one), -end, end);
        let (sx, sy) = (cos * x - sin * y, sin * x + cos * y);
        let h = Vec3x8 { x: self.a * sx, y: self.a * sy, z: one };
        h * (one / h.dot(h).sqrt())
    }
}

/// The slopes of some lanes; see [`visible_slope`](super::beckmann).
#[inline(always)]
fn visible_slope<S: Simd>(simd: S, lanes: Mask8<S>, cot: F64x8<S>, u: F64x8<S>) -> F64x8<S> {
    let splat = |v: f64| F64x8::splat(simd, v);
    let (one, half, end) = (splat(1.0), splat(0.5), splat(MAX_SLOPE));
    let cot = cot.lt(splat(MAX_COT)).select(cot, splat(MAX_COT));
    let (mut low, mut high) = (-end, cot.lt(end).select(cot, end));
    let total = below(simd, cot, high).0;
    let wanted = u * total;
    let start = visible_slope_start(simd, cot, u);
    let mut x = (start.gt(low) & start.lt(high)).select(start, high - half);
    let mut active = lanes;
    for _ in 0..MAX_STEPS {
        let (value, e) = below(simd, cot, x);
        let off = value - wanted;
        active = active.and_not(off.abs().le(splat(ENOUGH) * total));
        if !active.any() {
            break;
        }
        let above = off.gt(splat(0.0));
        high = above.select(x, high);
        low = above.select(low, x);
        let z = cot - x;
        let next = x - off * z / (z * z * e + off * (half + x * z));
        let next = (next.ge(low) & next.lt(high)).select(next, half * (low + high));
        let near = (next - x).abs().le(splat(NEAR) * z.lt(one).select(z, one));
        x = active.select(next, x);
        active = active.and_not(near);
        if !active.any() {
            break;
        }
    }
    x
}

/// See [`below`](super::beckmann).
#[inline(always)]
fn below<S: Simd>(simd: S, cot: F64x8<S>, x: F64x8<S>) -> (F64x8<S>, F64x8<S>) {
    let splat = |v: f64| F64x8::splat(simd, v);
    let (e, tail) = gaussian_and_tail(simd, x);
    let share = x.gt(splat(0.0)).select(splat(2.0) - tail, tail);
    (cot * splat(HALF_ROOT_PI) * share + splat(0.5) * e, e)
}

/// See [`visible_slope_start`](super::beckmann).
#[inline(always)]
fn visible_slope_start<S: Simd>(simd: S, cot: F64x8<S>, u: F64x8<S>) -> F64x8<S> {
    let splat = |v: f64| F64x8::splat(simd, v);
    let c = |i: usize, j: usize| splat(START[i][j]);
    let n = inverse_erf_start(simd, splat(2.0) * u - splat(1.0));
    let g = splat(START_COT) / (cot + splat(START_COT));
    let (a, b, d) = (
        c(0, 0) + g * (c(0, 1) + g * c(0, 2)),
        c(1, 0) + g * (c(1, 1) + g * c(1, 2)),
        c(2, 0) + g * (c(2, 1) + g * c(2, 2)),
    );
    let h = a + n * (b + n * d);
    -splat(START_COT) - h * (splat(2.0) + h * g / splat(START_COT))
}

#[cfg(test)]
mod tests {
    use turner_bvh::InstructionSet;
    use turner_bvh::lanes::{Block, Work, dispatch};

    use super::*;
    use crate::bsdf::beckmann::Beckmann;
    use crate::math::DVec3;
    use crate::math::block::{set_vector, vector};
    use crate::testing::Random;

    #[derive(Default)]
    struct All {
        a: Block,
        wo: [Block; 3],
        u: [Block; 2],
        lanes: u8,
        d: Block,
        lambda: Block,
        h: [Block; 3],
    }

    impl Work for &mut All {
        type Output = ();
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) {
            let facets = BeckmannX8 { a: F64x8::load(simd, &self.a) };
            let wo = Vec3x8::load(simd, &self.wo);
            let u = [F64x8::load(simd, &self.u[0]), F64x8::load(simd, &self.u[1])];
            facets.d(simd, wo).store(&mut self.d);
            facets.lambda(simd, wo).store(&mut self.lambda);
            facets.sample_visible(simd, Mask8::new(simd, self.lanes), wo, u).store(&mut self.h);
        }
    }

    #[test]
    fn the_same_bits_as_one_by_one() {
        let mut random = Random::new(12);
        let ends = [0.0, 1e-300, 1e-17, 1e-9, 0.5, 1.0 - 1e-9, 1.0 - f64::EPSILON / 2.0];
        let number = |random: &mut Random| match random.unit() {
            r if r < 0.3 => ends[(random.unit() * ends.len() as f64) as usize],
            _ => random.unit(),
        };
        for round in 0..3000 {
            let mut all = All { lanes: random.bits() as u8, ..All::default() };
            for lane in 0..8 {
                all.a.0[lane] = [1e-6, 1e-3, 0.1, 0.4, 1.0][(random.unit() * 5.0) as usize];
                let w = random.direction();
                let w = match round % 4 {
                    0 => DVec3::Z,
                    1 => DVec3::new(w.x, w.y, 1e-7 * w.z.abs() + 1e-12),
                    _ => DVec3::new(w.x, w.y, w.z.abs() + 1e-6),
                };
                set_vector(&mut all.wo, lane, w.normalize());
                (all.u[0].0[lane], all.u[1].0[lane]) = (number(&mut random), number(&mut random));
            }
            for set in InstructionSet::available() {
                dispatch(set, &mut all);
                for lane in 0..8 {
                    let facets = Beckmann { ax: all.a.0[lane], ay: all.a.0[lane] };
                    let (wo, u) = (vector(&all.wo, lane), all.u.map(|u| u.0[lane]));
                    let (d, lambda) = (facets.d(wo), facets.lambda(wo));
                    assert_eq!(d.to_bits(), all.d.0[lane].to_bits(), "{facets:?} {wo} {set:?}");
                    assert_eq!(lambda.to_bits(), all.lambda.0[lane].to_bits(), "{facets:?} {wo} {set:?}");
                    if all.lanes >> lane & 1 == 1 {
                        let h = facets.sample_visible(wo, u).to_array().map(f64::to_bits);
                        let wide = vector(&all.h, lane).to_array().map(f64::to_bits);
                        assert_eq!(h, wide, "{facets:?} {wo} {u:?} {set:?}");
                    }
                }
            }
        }
    }
}
