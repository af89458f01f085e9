//! Elementary functions that return the same bits on every machine.
//!
//! The `libm` of each platform rounds differently. Every value that can reach a pixel therefore comes from the
//! pure-Rust crate `libm` (a port of musl), or from the polynomials below, which are faster and exact enough for
//! shading. `sqrt`, `abs`, `floor` and the like are exact in IEEE 754 and come from `std`. Angles are in radians.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, LOG2_E, PI, SQRT_2};

/// Sine.
pub fn sin(x: f64) -> f64 {
    libm::sin(x)
}

/// Cosine.
pub fn cos(x: f64) -> f64 {
    libm::cos(x)
}

/// Sine and cosine.
pub fn sin_cos(x: f64) -> (f64, f64) {
    libm::sincos(x)
}

/// Tangent.
pub fn tan(x: f64) -> f64 {
    libm::tan(x)
}

/// Arc cosine, its argument clamped to −1..=1.
pub fn acos(x: f64) -> f64 {
    libm::acos(x.clamp(-1.0, 1.0))
}

/// Arc sine, its argument clamped to −1..=1.
pub fn asin(x: f64) -> f64 {
    libm::asin(x.clamp(-1.0, 1.0))
}

/// Angle of the point (x, y), −π..=π.
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// Taylor coefficients in x² of sin(x) / x and of (cos(x) − 1) / x².
pub(super) const SINE: [f64; 8] = [
    1.0,
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 1_307_674_368_000.0,
];
pub(super) const COSINE: [f64; 8] = [
    -0.5,
    1.0 / 24.0,
    -1.0 / 720.0,
    1.0 / 40_320.0,
    -1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 20_922_789_888_000.0,
];

/// 1.5 · 2^52. Adding it to a moderate number rounds that to an integer, whose low bits are the low bits of the sum.
pub(super) const ROUND: f64 = 6_755_399_441_055_744.0;

/// Interpolates atan(√z) / √z at ten Chebyshev nodes over 0..=tan²(π/8), with an error below 4e-16.
pub(super) const ARC_LOW: [f64; 8] = [
    0.999_999_999_999_999,
    -0.333_333_333_332_214_3,
    0.199_999_999_783_926_63,
    -0.142_857_126_616_847_93,
    0.111_110_488_537_512_96,
    -0.090_895_299_565_623_02,
    0.076_735_354_281_832_23,
    -0.065_059_829_671_704_51,
];
pub(super) const ARC_HIGH: [f64; 2] = [0.050_247_621_189_388_49, -0.025_316_479_573_758_974];
pub(super) const TAN_EIGHTH: f64 = SQRT_2 - 1.0;

/// Sine and cosine of 2π · `turns`, for moderate `turns`: error below 1e-15, several times faster than [`sin_cos`].
#[inline]
pub fn sin_cos_turns(turns: f64) -> (f64, f64) {
    let quarters = 4.0 * turns;
    let shifted = quarters + ROUND;
    let nearest = shifted.to_bits();
    let x = FRAC_PI_2 * (quarters - (shifted - ROUND));
    let z = x * x;
    // Taylor series: within an eighth of a turn the remainder is below 1e-16.
    let sin = x * polynomial(z, SINE);
    // From the second term on; the first is added last, for precision.
    let cos = 1.0 + z * polynomial(z, COSINE);
    let (sin, cos) = if nearest & 1 == 0 { (sin, cos) } else { (cos, -sin) };
    if nearest & 2 == 0 { (sin, cos) } else { (-sin, -cos) }
}

/// As [`atan2`], several times faster, error below 2e-15. 0 for (0, 0); NaN only for non-finite points.
#[inline]
pub fn angle(y: f64, x: f64) -> f64 {
    let (ax, ay) = (x.abs(), y.abs());
    let (low, high) = if ay > ax { (ax, ay) } else { (ay, ax) };
    // atan(low / high) = π/4 + atan((low − high) / (low + high)).
    let (over, under, base) =
        if low > TAN_EIGHTH * high { (low - high, low + high, FRAC_PI_4) } else { (low, high, 0.0) };
    let t = over / under.max(f64::MIN_POSITIVE);
    let z = t * t;
    let z8 = (z * z) * (z * z) * ((z * z) * (z * z));
    let a = base + t * (polynomial(z, ARC_LOW) + (ARC_HIGH[0] + ARC_HIGH[1] * z) * z8);
    let a = if ay > ax { FRAC_PI_2 - a } else { a };
    let a = if x < 0.0 { PI - a } else { a };
    a.copysign(y)
}

/// As [`acos`], several times faster, error below 2e-15.
#[inline]
pub fn arc_cosine(x: f64) -> f64 {
    let x = x.clamp(-1.0, 1.0);
    angle(((1.0 - x) * (1.0 + x)).sqrt(), x)
}

/// A polynomial with eight coefficients, lowest first, by Estrin's scheme (1960): short dependency chains.
#[inline(always)]
pub(super) fn polynomial(x: f64, c: [f64; 8]) -> f64 {
    let (x2, x4) = (x * x, (x * x) * (x * x));
    let (a, b) = (c[0] + c[1] * x, c[2] + c[3] * x);
    let (d, e) = (c[4] + c[5] * x, c[6] + c[7] * x);
    (a + b * x2) + (d + e * x2) * x4
}

/// e^x.
pub fn exp(x: f64) -> f64 {
    libm::exp(x)
}

/// (e^x − 1 − x) / x² within ±ln(2) / 2, lowest coefficient first: the minimax approximation of e^x of this form, with an
/// error below 2e-14.
pub(super) const EXPONENTIAL: [f64; 8] = [
    0.499_999_999_996_645_46,
    0.166_666_666_672_568_5,
    0.041_666_666_962_118_8,
    0.008_333_333_098_290_008,
    0.001_388_881_116_071_236_2,
    0.000_198_415_351_405_271_54,
    2.488_080_338_284_608_7e-5,
    2.749_461_862_302_038e-6,
];
/// ln 2 as a sum of a high and a low part: whole numbers up to 2^20 times the high part are exact.
pub(super) const LN_2_PARTS: [f64; 2] = [0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10];
/// Beyond these arguments, the exponential is 0 or infinite.
pub(super) const EXPONENTIAL_RANGE: [f64; 2] = [-708.0, 709.0];

/// As [`exp`], several times faster: the relative error is below 2e-14. 0 below −708, infinite above 709.
#[inline]
pub fn exponential(x: f64) -> f64 {
    let [least, greatest] = EXPONENTIAL_RANGE;
    let near = x.clamp(least, greatest);
    // e^x = 2^k e^r.
    let k = (near * LOG2_E + ROUND) - ROUND;
    let r = (near - k * LN_2_PARTS[0]) - k * LN_2_PARTS[1];
    let power = (1.0 + (r + (r * r) * polynomial(r, EXPONENTIAL))) * power_of_two(k);
    if x < least {
        0.0
    } else if x > greatest {
        f64::INFINITY
    } else {
        power
    }
}

/// 2^k for whole numbers −1022..=1023.
#[inline]
fn power_of_two(k: f64) -> f64 {
    f64::from_bits((k + (ROUND + 1023.0)).to_bits() << 52)
}

/// Natural logarithm.
pub fn ln(x: f64) -> f64 {
    libm::log(x)
}

/// The error function.
pub fn erf(x: f64) -> f64 {
    libm::erf(x)
}

/// Taylor coefficients in x² of artanh(x) / x.
pub(super) const ARTANH: [f64; 8] =
    [1.0, 1.0 / 3.0, 1.0 / 5.0, 1.0 / 7.0, 1.0 / 9.0, 1.0 / 11.0, 1.0 / 13.0, 1.0 / 15.0];

/// Binary logarithm of a positive, normal number, faster than [`ln`]. The error is below 1e-13 · (1 + |log2 x|).
#[inline]
pub fn log2(x: f64) -> f64 {
    /// The fraction bits of √½.
    const HALF_ROOT: u64 = std::f64::consts::FRAC_1_SQRT_2.to_bits();
    const EXPONENT: u64 = 0x7ff << 52;
    // x = m · 2^e with m in √½..√2.
    let above = x.to_bits().wrapping_sub(HALF_ROOT);
    let e = (above as i64) >> 52;
    let m = f64::from_bits(x.to_bits().wrapping_sub(above & (EXPONENT | 1 << 63)));
    // ln m = 2 artanh((m − 1) / (m + 1)), as a series.
    let s = (m - 1.0) / (m + 1.0);
    let z = s * s;
    e as f64 + s * polynomial(z, ARTANH) * (2.0 * LOG2_E)
}

/// Cube root.
pub fn cbrt(x: f64) -> f64 {
    libm::cbrt(x)
}

/// x^y. Integer exponents up to 65,536, which covers the usual highlight exponents, use repeated squaring: 6x faster
/// than the general power, and within 20 ulp of it.
pub fn pow(x: f64, y: f64) -> f64 {
    Exponent::new(y).of(x)
}

/// An exponent, classified once for [`pow`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exponent {
    /// An integer up to 65,536.
    Whole(u32),
    /// Any other exponent.
    Real(f64),
}

impl Exponent {
    /// Classifies an exponent.
    pub fn new(y: f64) -> Exponent {
        if (0.0..=65_536.0).contains(&y) && y == y.floor() {
            Exponent::Whole(y as u32)
        } else {
            Exponent::Real(y)
        }
    }

    /// x to this power.
    #[inline]
    pub fn of(self, x: f64) -> f64 {
        match self {
            Exponent::Whole(n) => pow_int(x, n),
            Exponent::Real(y) => libm::pow(x, y),
        }
    }
}

/// x^n by repeated squaring.
pub fn pow_int(mut x: f64, mut n: u32) -> f64 {
    let mut result = 1.0;
    loop {
        if n & 1 == 1 {
            result *= x;
        }
        n >>= 1;
        if n == 0 {
            return result;
        }
        x *= x;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_powers_agree_with_the_general_power() {
        for n in [0u32, 1, 2, 3, 7, 10, 50, 500, 1000, 65_536] {
            for x in [0.0, 0.1, 0.5, 0.9, 0.999, 0.999_999, 1.0] {
                let (a, b) = (pow(x, f64::from(n)), libm::pow(x, f64::from(n)));
                assert!((a - b).abs() <= 1e-11 * b.abs(), "{x}^{n}: {a} and {b}");
            }
        }
        assert_eq!(pow(2.0, 0.5), std::f64::consts::SQRT_2);
    }

    #[test]
    fn the_fast_logarithm_is_the_logarithm() {
        for i in -60_000..=60_000 {
            let exact = f64::from(i) / 1000.0 + 1e-4;
            let x = libm::exp2(exact);
            assert!((log2(x) - libm::log2(x)).abs() < 1e-13 * (1.0 + exact.abs()), "{x}: {}", log2(x));
        }
        assert_eq!([log2(1.0), log2(0.25), log2(1024.0)], [0.0, -2.0, 10.0]);
    }

    #[test]
    fn the_fast_exponential_is_the_exponential() {
        for i in -708_000..=709_000 {
            for x in [f64::from(i) / 1000.0, f64::from(i) / 1000.0 * (1.0 - 1e-6), f64::from(i) * 1e-6] {
                let exact = libm::exp(x);
                assert!((exponential(x) - exact).abs() <= 2e-14 * exact, "{x}: {}", exponential(x));
            }
        }
        assert_eq!([0.0, -0.0, 1e-300, -1e-300].map(exponential), [1.0; 4]);
        assert!(exponential(-708.0) > f64::MIN_POSITIVE && exponential(709.0) < f64::MAX);
        assert_eq!([-708.1, -745.0, -1e300, f64::NEG_INFINITY].map(exponential), [0.0; 4]);
        assert_eq!([709.1, 1e300, f64::INFINITY].map(exponential), [f64::INFINITY; 3]);
        assert!(exponential(f64::NAN).is_nan());
    }

    #[test]
    fn the_fast_functions_are_as_good_as_the_slow_ones() {
        for i in -40_000..=40_000 {
            let turns = f64::from(i) / 20_000.0;
            let ((s, c), (sin, cos)) = (sin_cos_turns(turns), sin_cos(std::f64::consts::TAU * turns));
            assert!((s - sin).abs() < 2e-15 && (c - cos).abs() < 2e-15, "{turns}: {s} {c}, not {sin} {cos}");
            for r in [1.0, 1e-300, 1e300, 0.7] {
                let (y, x) = (r * s, r * c);
                let (fast, slow) = (angle(y, x), atan2(y, x));
                assert!((fast - slow).abs() < 2e-15, "{y} {x}: {fast}, not {slow}");
            }
        }
        for i in 0..=40_000 {
            let x = f64::from(i) / 20_000.0 - 1.0;
            for x in [x, x.next_up(), x * (1.0 - 1e-12)] {
                assert!((arc_cosine(x) - acos(x)).abs() < 2e-15, "{x}");
            }
        }
        assert_eq!((angle(0.0, 0.0), angle(0.0, 1.0), angle(0.0, -1.0)), (0.0, 0.0, PI));
        assert_eq!((angle(1.0, 0.0), angle(-1.0, 0.0)), (FRAC_PI_2, -FRAC_PI_2));
        assert_eq!(sin_cos_turns(0.25), (1.0, 0.0));
        assert_eq!(sin_cos_turns(-0.5).1, -1.0);
    }

    #[test]
    fn inverse_functions_take_rounded_arguments() {
        assert_eq!(acos(1.0 + 1e-15), 0.0);
        assert!((acos(-1.0 - 1e-15) - std::f64::consts::PI).abs() < 1e-15);
        assert!(asin(2.0).is_finite());
    }
}
