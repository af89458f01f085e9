//! Numbers that expressions are evaluated with.

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::math::elementary::{exp, ln, pow, pow_int, sin};

/// A number, an interval, or either with a derivative.
pub(in crate::shape) trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    fn constant(v: f64) -> Self;
    /// The sign: whether it is negative; `None` if it may be either.
    fn is_negative(self) -> Option<bool>;
    /// Everything between two.
    fn hull(self, other: Self) -> Self;
    fn minimum(self, other: Self) -> Self;
    fn absolute(self) -> Self;
    fn whole_power(self, n: u32) -> Self;
    /// A power of a number that is not negative.
    fn power(self, exponent: f64) -> Self;
    fn square_root(self) -> Self;
    fn exponential(self) -> Self;
    fn logarithm(self) -> Self;
    fn sine(self) -> Self;
}

impl Number for f64 {
    fn constant(v: f64) -> f64 {
        v
    }
    fn is_negative(self) -> Option<bool> {
        Some(self < 0.0)
    }
    fn hull(self, _: f64) -> f64 {
        self
    }
    fn minimum(self, other: f64) -> f64 {
        if other < self { other } else { self }
    }
    fn absolute(self) -> f64 {
        self.abs()
    }
    fn whole_power(self, n: u32) -> f64 {
        pow_int(self, n)
    }
    fn power(self, exponent: f64) -> f64 {
        pow(self.max(0.0), exponent)
    }
    fn square_root(self) -> f64 {
        self.max(0.0).sqrt()
    }
    fn exponential(self) -> f64 {
        exp(self)
    }
    fn logarithm(self) -> f64 {
        ln(self.max(f64::MIN_POSITIVE))
    }
    fn sine(self) -> f64 {
        sin(self)
    }
}

/// All numbers from `low` to `high`. Results are rounded outwards, so they contain the exact ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::shape) struct Interval {
    pub(in crate::shape) low: f64,
    pub(in crate::shape) high: f64,
}

/// More than the relative error of an elementary function.
const WIDEN: f64 = 8.0 * f64::EPSILON;

impl Interval {
    const EVERYTHING: Interval = Interval { low: f64::NEG_INFINITY, high: f64::INFINITY };

    pub(in crate::shape) fn new(low: f64, high: f64) -> Interval {
        Interval { low, high }
    }

    /// Rounded outwards; NaN becomes everything.
    fn outward(low: f64, high: f64) -> Interval {
        if low.is_nan() || high.is_nan() {
            return Interval::EVERYTHING;
        }
        let margin = |v: f64| if v.is_finite() { v.abs() * WIDEN + f64::MIN_POSITIVE } else { 0.0 };
        Interval { low: low - margin(low), high: high + margin(high) }
    }

    /// Whether 0 is not in it.
    pub(in crate::shape) fn excludes_zero(self) -> bool {
        self.low > 0.0 || self.high < 0.0
    }

    /// From an increasing function.
    fn increasing(self, f: impl Fn(f64) -> f64) -> Interval {
        Interval::outward(f(self.low), f(self.high))
    }
}

impl Add for Interval {
    type Output = Interval;
    fn add(self, b: Interval) -> Interval {
        Interval::outward(self.low + b.low, self.high + b.high)
    }
}

impl Sub for Interval {
    type Output = Interval;
    fn sub(self, b: Interval) -> Interval {
        Interval::outward(self.low - b.high, self.high - b.low)
    }
}

impl Neg for Interval {
    type Output = Interval;
    fn neg(self) -> Interval {
        Interval { low: -self.high, high: -self.low }
    }
}

impl Mul for Interval {
    type Output = Interval;
    fn mul(self, b: Interval) -> Interval {
        let all = [self.low * b.low, self.low * b.high, self.high * b.low, self.high * b.high];
        if all.iter().any(|v| v.is_nan()) {
            return Interval::EVERYTHING;
        }
        let low = all.iter().copied().fold(f64::INFINITY, f64::min);
        let high = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Interval::outward(low, high)
    }
}

impl Div for Interval {
    type Output = Interval;
    fn div(self, b: Interval) -> Interval {
        if !b.excludes_zero() {
            return Interval::EVERYTHING;
        }
        self * Interval::outward(1.0 / b.high, 1.0 / b.low)
    }
}

impl Number for Interval {
    fn constant(v: f64) -> Interval {
        Interval { low: v, high: v }
    }
    fn is_negative(self) -> Option<bool> {
        if self.high < 0.0 {
            Some(true)
        } else if self.low >= 0.0 {
            Some(false)
        } else {
            None
        }
    }
    fn hull(self, b: Interval) -> Interval {
        Interval { low: self.low.min(b.low), high: self.high.max(b.high) }
    }
    fn minimum(self, b: Interval) -> Interval {
        Interval { low: self.low.min(b.low), high: self.high.min(b.high) }
    }
    fn absolute(self) -> Interval {
        match self.is_negative() {
            Some(true) => -self,
            Some(false) => self,
            None => Interval { low: 0.0, high: self.high.max(-self.low) },
        }
    }
    fn whole_power(self, n: u32) -> Interval {
        let base = if n.is_multiple_of(2) { self.absolute() } else { self };
        // A power of many factors has many roundings.
        let Interval { low, high } = base.increasing(|v| pow_int(v, n));
        let more = |v: f64| if v.is_finite() { v.abs() * WIDEN * f64::from(n) } else { 0.0 };
        Interval { low: low - more(low), high: high + more(high) }
    }
    fn power(self, exponent: f64) -> Interval {
        let base = Interval { low: self.low.max(0.0), high: self.high.max(0.0) };
        let Interval { low, high } = base;
        let ends = if exponent < 0.0 { (high, low) } else { (low, high) };
        Interval::outward(pow(ends.0, exponent), pow(ends.1, exponent))
    }
    fn square_root(self) -> Interval {
        let root = self.increasing(|v| v.max(0.0).sqrt());
        Interval { low: root.low.max(0.0), ..root }
    }
    fn exponential(self) -> Interval {
        self.increasing(exp)
    }
    fn logarithm(self) -> Interval {
        self.increasing(|v| ln(v.max(f64::MIN_POSITIVE)))
    }
    fn sine(self) -> Interval {
        use std::f64::consts::{FRAC_PI_2, TAU};
        if !(self.high - self.low < TAU) {
            return Interval { low: -1.0, high: 1.0 };
        }
        // Whether a maximum, at π/2 + 2πk, lies within; for minima the same half a turn later.
        let has = |first: f64| {
            ((self.high - first) / TAU + 1e-9).floor() >= ((self.low - first) / TAU - 1e-9).ceil()
        };
        let (a, b) = (sin(self.low), sin(self.high));
        let range = Interval::outward(a.min(b), a.max(b));
        Interval {
            low: if has(-FRAC_PI_2) { -1.0 } else { range.low },
            high: if has(FRAC_PI_2) { 1.0 } else { range.high },
        }
    }
}

/// A value with its derivative along a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::shape) struct Dual<N> {
    pub(in crate::shape) value: N,
    pub(in crate::shape) slope: N,
}

impl<N: Number> Add for Dual<N> {
    type Output = Dual<N>;
    fn add(self, b: Dual<N>) -> Dual<N> {
        Dual { value: self.value + b.value, slope: self.slope + b.slope }
    }
}

impl<N: Number> Sub for Dual<N> {
    type Output = Dual<N>;
    fn sub(self, b: Dual<N>) -> Dual<N> {
        Dual { value: self.value - b.value, slope: self.slope - b.slope }
    }
}

impl<N: Number> Neg for Dual<N> {
    type Output = Dual<N>;
    fn neg(self) -> Dual<N> {
        Dual { value: -self.value, slope: -self.slope }
    }
}

impl<N: Number> Mul for Dual<N> {
    type Output = Dual<N>;
    fn mul(self, b: Dual<N>) -> Dual<N> {
        Dual { value: self.value * b.value, slope: self.slope * b.value + self.value * b.slope }
    }
}

impl<N: Number> Div for Dual<N> {
    type Output = Dual<N>;
    fn div(self, b: Dual<N>) -> Dual<N> {
        let value = self.value / b.value;
        Dual { value, slope: (self.slope - value * b.slope) / b.value }
    }
}

impl<N: Number> Number for Dual<N> {
    fn constant(v: f64) -> Dual<N> {
        Dual { value: N::constant(v), slope: N::constant(0.0) }
    }
    fn is_negative(self) -> Option<bool> {
        self.value.is_negative()
    }
    fn hull(self, b: Dual<N>) -> Dual<N> {
        Dual { value: self.value.hull(b.value), slope: self.slope.hull(b.slope) }
    }
    fn minimum(self, b: Dual<N>) -> Dual<N> {
        let slope = match (self.value - b.value).is_negative() {
            Some(true) => self.slope,
            Some(false) => b.slope,
            None => self.slope.hull(b.slope),
        };
        Dual { value: self.value.minimum(b.value), slope }
    }
    fn absolute(self) -> Dual<N> {
        let slope = match self.value.is_negative() {
            Some(true) => -self.slope,
            Some(false) => self.slope,
            None => self.slope.hull(-self.slope),
        };
        Dual { value: self.value.absolute(), slope }
    }
    fn whole_power(self, n: u32) -> Dual<N> {
        let factor = if n == 0 { N::constant(0.0) } else { self.value.whole_power(n - 1) };
        Dual { value: self.value.whole_power(n), slope: self.slope * factor * N::constant(f64::from(n)) }
    }
    fn power(self, exponent: f64) -> Dual<N> {
        let factor = self.value.power(exponent - 1.0) * N::constant(exponent);
        Dual { value: self.value.power(exponent), slope: self.slope * factor }
    }
    fn square_root(self) -> Dual<N> {
        let value = self.value.square_root();
        Dual { value, slope: self.slope / (value + value) }
    }
    fn exponential(self) -> Dual<N> {
        let value = self.value.exponential();
        Dual { value, slope: self.slope * value }
    }
    fn logarithm(self) -> Dual<N> {
        Dual { value: self.value.logarithm(), slope: self.slope / self.value }
    }
    fn sine(self) -> Dual<N> {
        let quarter = N::constant(std::f64::consts::FRAC_PI_2);
        Dual { value: self.value.sine(), slope: self.slope * (self.value + quarter).sine() }
    }
}
