//! The integral of e^(−x²) and its inverse, with the same bits on every machine.
//!
//! libm's `erf` branches into five rational functions, and evaluates e^(−x²) twice. Here erfc(x) = e^(−x²) · R(x) with one
//! rational function R of positive coefficients, and the caller gets e^(−x²) as well, which is the derivative that
//! Newton's method needs. [`gaussian_x8`](super::gaussian_x8) has the same functions for eight numbers at a time.

use std::f64::consts::{FRAC_2_SQRT_PI, LN_2};

use super::elementary::{exponential, log2, polynomial};

/// R(x) = e^(x²) erfc(x) in 0..=6: numerator and denominator, lowest coefficient first. Weighted by e^(−x²) they are the
/// minimax approximation of their degrees, with an error below 5e-16.
pub(super) const TAIL: [[f64; 8]; 2] = [
    [
        1.0,
        1.468_997_501_891_588_2,
        1.079_565_108_370_895,
        0.474_861_936_874_425,
        0.130_034_393_847_993_34,
        0.020_912_860_731_617_564,
        0.001_551_387_743_080_999_5,
        0.0,
    ],
    [
        1.0,
        2.597_376_668_987_247,
        3.010_390_830_748_842_3,
        2.026_600_344_320_713,
        0.860_300_985_219_460_2,
        0.231_845_875_942_546_74,
        0.037_067_609_479_980_9,
        0.002_749_748_387_579_974_4,
    ],
];
/// Where the approximation ends; erfc(6) is 2e-17.
pub(super) const TAIL_END: f64 = 6.0;

/// erf⁻¹(x) / x as a rational function of −ln(1 − x²), 0..=36: numerator and denominator, lowest coefficient first. They
/// are the minimax approximation of x times the function, with an error below 6e-5.
pub(super) const INVERSE: [[f64; 5]; 2] = [
    [
        0.886_432_841_815_261,
        0.319_509_948_890_300_43,
        0.063_648_343_084_735_84,
        0.007_658_248_579_892_64,
        3.903_819_884_404_358e-5,
    ],
    [1.0, 0.099_113_820_152_543_34, 0.033_046_352_739_091_49, 8.778_696_433_181_382e-4, 0.0],
];
/// The smallest 1 − x² of the inverse.
pub(super) const LEAST_REST: f64 = 1e-17;

/// e^(−x²) and erfc(|x|) = 1 − erf(|x|), with an absolute error below 1e-15 and 3e-14.
#[inline]
pub fn gaussian_and_tail(x: f64) -> (f64, f64) {
    let e = exponential(-x * x);
    let x = x.abs();
    let x = if x > TAIL_END { TAIL_END } else { x };
    let [over, under] = TAIL;
    (e, e * (polynomial(x, over) / polynomial(x, under)))
}

/// The inverse of the error function of x in −1..=1, with an error below 6e-5 where it is within ±5; at most about
/// 6. A start for Newton's method.
#[inline]
pub fn inverse_erf_start(x: f64) -> f64 {
    let rest = (1.0 - x) * (1.0 + x);
    let rest = if rest > LEAST_REST { rest } else { LEAST_REST };
    let w = -LN_2 * log2(rest);
    let [over, under] = INVERSE.map(|c| c[0] + w * (c[1] + w * (c[2] + w * (c[3] + w * c[4]))));
    x * (over / under)
}

/// The inverse of the error function of x in −1..=1: erf of the result is x within 1e-12. At most about 6.
#[inline]
pub fn inverse_erf(x: f64) -> f64 {
    let y = inverse_erf_start(x).abs();
    // One step of Halley's method.
    let (e, tail) = gaussian_and_tail(y);
    let step = ((1.0 - x.abs()) - tail) / (FRAC_2_SQRT_PI * e);
    (y - step / (1.0 + y * step)).copysign(x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::elementary::pow_int;

    #[test]
    fn the_tail_is_that_of_libm() {
        for i in -700_000..=700_000 {
            let x = f64::from(i) * 1e-5;
            let (e, tail) = gaussian_and_tail(x);
            assert!((e - libm::exp(-x * x)).abs() < 2e-14, "{x}: {e}");
            assert!((tail - libm::erfc(x.abs())).abs() < 3e-14, "{x}: {tail}");
        }
        for x in [8.0, -27.0, 1e9, f64::INFINITY] {
            let (e, tail) = gaussian_and_tail(x);
            assert!((0.0..=1e-16).contains(&e) && (0.0..=1e-16).contains(&tail), "{x}: {e} {tail}");
        }
        assert_eq!(gaussian_and_tail(0.0), (1.0, 1.0));
        let (e, tail) = gaussian_and_tail(f64::NAN);
        assert!(e.is_nan() && tail.is_nan());
    }

    #[test]
    fn the_inverse_of_the_error_function() {
        for i in -1_000_000..=1_000_000 {
            let x = f64::from(i) * 1e-6;
            for x in [x, pow_int(x, 9), x * (1.0 - 1e-13)] {
                let y = inverse_erf(x);
                assert!((libm::erf(y) - x).abs() < 1e-12 && y.abs() < 6.5, "{x}: {y}");
                let near = inverse_erf_start(x);
                assert!((near - y).abs() < 6e-5 || y.abs() > 5.0, "{x}: {near}, not {y}");
            }
        }
        assert_eq!([inverse_erf(0.0), inverse_erf(-0.0)], [0.0; 2]);
        assert!(inverse_erf(f64::NAN).is_nan() && inverse_erf_start(f64::NAN).is_nan());
    }
}
