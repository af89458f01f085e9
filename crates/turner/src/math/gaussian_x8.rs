//! The integral of e^(−x²) and its inverse for eight numbers at a time, with the same bits as in
//! [`gaussian`](super::gaussian).

use std::f64::consts::{FRAC_2_SQRT_PI, LN_2};

use turner_bvh::lanes::{F64x8, Simd};

use super::elementary_x8::{exponential, log2, polynomial};
use super::gaussian::{INVERSE, LEAST_REST, TAIL, TAIL_END};

/// As [`gaussian_and_tail`](super::gaussian::gaussian_and_tail).
#[inline(always)]
pub fn gaussian_and_tail<S: Simd>(simd: S, x: F64x8<S>) -> (F64x8<S>, F64x8<S>) {
    let e = exponential(simd, -x * x);
    let (x, end) = (x.abs(), F64x8::splat(simd, TAIL_END));
    let x = x.gt(end).select(end, x);
    (e, e * (polynomial(simd, x, &TAIL[0]) / polynomial(simd, x, &TAIL[1])))
}

/// As [`inverse_erf_start`](super::gaussian::inverse_erf_start).
#[inline(always)]
pub fn inverse_erf_start<S: Simd>(simd: S, x: F64x8<S>) -> F64x8<S> {
    let splat = |v: f64| F64x8::splat(simd, v);
    let rest = (splat(1.0) - x) * (splat(1.0) + x);
    let rest = rest.gt(splat(LEAST_REST)).select(rest, splat(LEAST_REST));
    let w = splat(-LN_2) * log2(simd, rest);
    x * (horner(simd, w, &INVERSE[0]) / horner(simd, w, &INVERSE[1]))
}

#[inline(always)]
fn horner<S: Simd>(simd: S, w: F64x8<S>, c: &[f64; 5]) -> F64x8<S> {
    let c = |i: usize| F64x8::splat(simd, c[i]);
    c(0) + w * (c(1) + w * (c(2) + w * (c(3) + w * c(4))))
}

/// As [`inverse_erf`](super::gaussian::inverse_erf).
#[inline(always)]
pub fn inverse_erf<S: Simd>(simd: S, x: F64x8<S>) -> F64x8<S> {
    let splat = |v: f64| F64x8::splat(simd, v);
    let y = inverse_erf_start(simd, x).abs();
    let (e, tail) = gaussian_and_tail(simd, y);
    let step = ((splat(1.0) - x.abs()) - tail) / (splat(FRAC_2_SQRT_PI) * e);
    (y - step / (splat(1.0) + y * step)).copysign(x)
}

#[cfg(test)]
mod tests {
    use turner_bvh::InstructionSet;
    use turner_bvh::lanes::{Block, Work, dispatch};

    use super::*;
    use crate::math::gaussian;
    use crate::testing::Random;

    struct All<'a>(&'a Block, &'a mut [Block; 4]);

    impl Work for All<'_> {
        type Output = ();
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) {
            let x = F64x8::load(simd, self.0);
            let (e, tail) = gaussian_and_tail(simd, x);
            e.store(&mut self.1[0]);
            tail.store(&mut self.1[1]);
            inverse_erf_start(simd, x).store(&mut self.1[2]);
            inverse_erf(simd, x).store(&mut self.1[3]);
        }
    }

    #[test]
    fn the_same_bits_as_one_by_one() {
        let special = [0.0, -0.0, 1.0, -1.0, 1e-300, -1e-17, 6.0, 27.0, 1e9, f64::INFINITY, f64::NAN];
        let mut random = Random::new(9);
        for i in 0..4000 {
            let mut number = |_: usize| match i % 4 {
                0 => special[(random.unit() * special.len() as f64) as usize],
                1 => 2.0 * random.unit() - 1.0,
                2 => 1.0 - random.unit() * 1e-9,
                _ => 16.0 * (random.unit() - 0.5),
            };
            let x = Block(std::array::from_fn(&mut number));
            for set in InstructionSet::available() {
                let mut out = [Block::default(); 4];
                dispatch(set, All(&x, &mut out));
                for (lane, x) in x.0.into_iter().enumerate() {
                    let (e, tail) = gaussian::gaussian_and_tail(x);
                    let one = [e, tail, gaussian::inverse_erf_start(x), gaussian::inverse_erf(x)];
                    for (one, wide) in one.into_iter().zip(&out) {
                        let wide = wide.0[lane];
                        let same = one.to_bits() == wide.to_bits() || one.is_nan() && wide.is_nan();
                        assert!(same, "{x}: {one} {wide}, {set:?}");
                    }
                }
            }
        }
    }
}
