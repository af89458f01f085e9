//! Elementary functions for eight numbers at a time, with the same bits as those of [`elementary`](super::elementary).

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, LOG2_E, PI, SQRT_2};

use turner_bvh::lanes::{F64x8, Mask8, Simd};

use super::elementary::{
    ARC_HIGH, ARC_LOW, ARTANH, COSINE, EXPONENTIAL, EXPONENTIAL_RANGE, LN_2_PARTS, ROUND, SINE, TAN_EIGHTH,
};

/// Clamps to `low..=high`; NaN stays NaN.
#[inline(always)]
pub fn clamp<S: Simd>(x: F64x8<S>, low: F64x8<S>, high: F64x8<S>) -> F64x8<S> {
    let x = x.lt(low).select(low, x);
    x.gt(high).select(high, x)
}

/// Lanes that are neither infinite nor NaN.
#[inline(always)]
pub fn is_finite<S: Simd>(simd: S, x: F64x8<S>) -> Mask8<S> {
    x.abs().lt(F64x8::splat(simd, f64::INFINITY))
}

/// As [`sin_cos_turns`](super::elementary::sin_cos_turns).
#[inline(always)]
pub fn sin_cos_turns<S: Simd>(simd: S, turns: F64x8<S>) -> (F64x8<S>, F64x8<S>) {
    let splat = |v: f64| F64x8::splat(simd, v);
    let quarters = splat(4.0) * turns;
    let nearest = quarters + splat(ROUND);
    let x = splat(FRAC_PI_2) * (quarters - (nearest - splat(ROUND)));
    let z = x * x;
    let sin = x * polynomial(simd, z, &SINE);
    let cos = splat(1.0) + z * polynomial(simd, z, &COSINE);
    let odd = nearest.has_bit(0);
    let (sin, cos) = (odd.select(cos, sin), odd.select(-sin, cos));
    let back = nearest.has_bit(1);
    (back.select(-sin, sin), back.select(-cos, cos))
}

/// As [`arc_cosine`](super::elementary::arc_cosine).
#[inline(always)]
pub fn arc_cosine<S: Simd>(simd: S, x: F64x8<S>) -> F64x8<S> {
    let one = F64x8::splat(simd, 1.0);
    let x = clamp(x, -one, one);
    angle(simd, ((one - x) * (one + x)).sqrt(), x)
}

/// As [`angle`](super::elementary::angle).
#[inline(always)]
pub fn angle<S: Simd>(simd: S, y: F64x8<S>, x: F64x8<S>) -> F64x8<S> {
    let splat = |v: f64| F64x8::splat(simd, v);
    let (ax, ay) = (x.abs(), y.abs());
    let steep = ay.gt(ax);
    let (low, high) = (steep.select(ax, ay), steep.select(ay, ax));
    let wide = low.gt(splat(TAN_EIGHTH) * high);
    let over = wide.select(low - high, low);
    let under = wide.select(low + high, high);
    let base = wide.select(splat(FRAC_PI_4), splat(0.0));
    let t = over / under.or_larger(splat(f64::MIN_POSITIVE));
    let z = t * t;
    let z8 = (z * z) * (z * z) * ((z * z) * (z * z));
    let more = splat(ARC_HIGH[0]) + splat(ARC_HIGH[1]) * z;
    let a = base + t * (polynomial(simd, z, &ARC_LOW) + more * z8);
    let a = steep.select(splat(FRAC_PI_2) - a, a);
    let a = x.lt(splat(0.0)).select(splat(PI) - a, a);
    a.copysign(y)
}

/// As [`exponential`](super::elementary::exponential).
#[inline(always)]
pub fn exponential<S: Simd>(simd: S, x: F64x8<S>) -> F64x8<S> {
    let splat = |v: f64| F64x8::splat(simd, v);
    let (least, greatest) = (splat(EXPONENTIAL_RANGE[0]), splat(EXPONENTIAL_RANGE[1]));
    let near = clamp(x, least, greatest);
    let k = (near * splat(LOG2_E) + splat(ROUND)) - splat(ROUND);
    let r = (near - k * splat(LN_2_PARTS[0])) - k * splat(LN_2_PARTS[1]);
    let power = (splat(1.0) + (r + (r * r) * polynomial(simd, r, &EXPONENTIAL))) * k.power_of_two();
    let power = x.gt(greatest).select(splat(f64::INFINITY), power);
    x.lt(least).select(splat(0.0), power)
}

/// As [`log2`](super::elementary::log2), for positive, normal numbers.
#[inline(always)]
pub fn log2<S: Simd>(simd: S, x: F64x8<S>) -> F64x8<S> {
    let splat = |v: f64| F64x8::splat(simd, v);
    let (one, m) = (splat(1.0), x.fraction());
    let large = m.ge(splat(SQRT_2));
    let m = large.select(m * splat(0.5), m);
    let e = large.select(x.exponent() + one, x.exponent());
    let s = (m - one) / (m + one);
    e + s * polynomial(simd, s * s, &ARTANH) * splat(2.0 * LOG2_E)
}

#[inline(always)]
pub(super) fn polynomial<S: Simd>(simd: S, x: F64x8<S>, c: &[f64; 8]) -> F64x8<S> {
    let c = |i: usize| F64x8::splat(simd, c[i]);
    let (x2, x4) = (x * x, (x * x) * (x * x));
    let (a, b) = (c(0) + c(1) * x, c(2) + c(3) * x);
    let (d, e) = (c(4) + c(5) * x, c(6) + c(7) * x);
    (a + b * x2) + (d + e * x2) * x4
}

#[cfg(test)]
mod tests {
    use turner_bvh::InstructionSet;
    use turner_bvh::lanes::{Block, Work, dispatch};

    use super::*;
    use crate::math::elementary;
    use crate::testing::Random;

    struct All<'a>(&'a Block, &'a Block, &'a mut [Block; 6]);

    impl Work for All<'_> {
        type Output = ();
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) {
            let (x, y) = (F64x8::load(simd, self.0), F64x8::load(simd, self.1));
            let (s, c) = sin_cos_turns(simd, x);
            s.store(&mut self.2[0]);
            c.store(&mut self.2[1]);
            arc_cosine(simd, x).store(&mut self.2[2]);
            angle(simd, y, x).store(&mut self.2[3]);
            exponential(simd, x).store(&mut self.2[4]);
            log2(simd, positive(simd, x)).store(&mut self.2[5]);
        }
    }

    /// A positive, normal number.
    #[inline(always)]
    fn positive<S: Simd>(simd: S, x: F64x8<S>) -> F64x8<S> {
        let x = clamp(x.abs(), F64x8::splat(simd, f64::MIN_POSITIVE), F64x8::splat(simd, f64::MAX));
        x.is_nan().select(F64x8::splat(simd, SQRT_2), x)
    }

    #[test]
    fn the_same_bits_as_one_by_one() {
        let special = [
            0.0,
            -0.0,
            1.0,
            -1.0,
            0.25,
            0.125,
            -0.375,
            0.5,
            1e-300,
            1e9,
            709.0,
            -708.0,
            -708.5,
            709.5,
            SQRT_2,
            SQRT_2.next_down(),
            1e300,
            -1e300,
            f64::INFINITY,
            f64::NAN,
        ];
        let mut random = Random::new(8);
        let sets: Vec<InstructionSet> = InstructionSet::available().collect();
        for i in 0..4000 {
            let mut number = |_: usize| match i % 4 {
                0 => special[(random.units::<1>()[0] * special.len() as f64) as usize],
                1 => 2.0 * random.units::<1>()[0] - 1.0,
                2 => 1500.0 * (random.units::<1>()[0] - 0.5),
                _ => 100.0 * (random.units::<1>()[0] - 0.5),
            };
            let (x, y) = (Block(std::array::from_fn(&mut number)), Block(std::array::from_fn(&mut number)));
            let mut out = [Block::default(); 6];
            dispatch(sets[i % sets.len()], All(&x, &y, &mut out));
            for lane in 0..8 {
                let (x, y) = (x.0[lane], y.0[lane]);
                let (s, c) = elementary::sin_cos_turns(x);
                let positive = if x.is_nan() { SQRT_2 } else { x.abs().clamp(f64::MIN_POSITIVE, f64::MAX) };
                let one = [
                    s,
                    c,
                    elementary::arc_cosine(x),
                    elementary::angle(y, x),
                    elementary::exponential(x),
                    elementary::log2(positive),
                ];
                for (one, polynomial) in one.iter().zip(&out) {
                    let polynomial = polynomial.0[lane];
                    assert!(
                        one.to_bits() == polynomial.to_bits() || one.is_nan() && polynomial.is_nan(),
                        "{x} {y}: {one} {polynomial}"
                    );
                }
            }
        }
    }
}
