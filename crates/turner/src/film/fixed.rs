//! Fixed-point sums.
//!
//! Floating-point addition is not associative: the same samples added in another order give other bits. Integer
//! addition is, so sums are kept as integers.

/// A signed 96-bit fixed-point value with 44 fractional bits: resolution 6e-14, range ±2e15. Sums are exact, so
/// any order, split or merge of samples gives the same bits. 12 bytes.
///
/// ```text
/// bit 95       64 63       44 43   32 31             0
///    word 2      │     word 1        │     word 0
///    sign, 51 bits of integer │  44 bits of fraction       two's complement, value = integer / 2^44
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fixed96([u32; 3]);

/// Units of a colour of 1.
pub(super) const COLOR: f64 = (1u64 << 44) as f64;

/// Units of a weight or coverage of 1, in the sums of a pixel.
pub(super) const ONE: f64 = 4_294_967_296.0;

/// 1.5 · 2^52.
const SHIFT: f64 = 6_755_399_441_055_744.0;

/// Smaller values, as multiples of the unit of a colour, need fewer than 51 bits: [`whole`] rounds them to integers.
const SMALL: f32 = 128.0;

/// Values from [`SMALL`] to this have no digits below the last place of a colour.
const LARGE: f32 = (1 << 18) as f32;

/// The largest absolute value of a sample, in units of a colour: a million of them do not overflow.
pub(super) const LIMIT: f64 = 2e9 * COLOR;

/// The nearest integer, ties to even, of a value below 2^51.
///
/// Adding [`SHIFT`] moves the fraction out of the mantissa, so that the bits of the sum are those of `SHIFT` plus the
/// integer. Compilers vectorize this, unlike a conversion.
#[inline(always)]
pub(super) fn round_small(value: f64) -> i64 {
    ((value + SHIFT).to_bits() as i64).wrapping_sub(SHIFT.to_bits() as i64)
}

/// [`round_small`] as a float.
#[inline(always)]
pub(super) fn whole(value: f64) -> f64 {
    (value + SHIFT) - SHIFT
}

/// The nearest integer, ties to even, of a value clamped to ±[`LIMIT`].
#[inline]
pub(super) fn round(value: f64) -> i128 {
    match value.abs() {
        small if small < (1u64 << 51) as f64 => i128::from(round_small(value)),
        // Conversion to i128 is a function call.
        fits if fits < 9e18 => i128::from(value.round_ties_even() as i64),
        _ => value.clamp(-LIMIT, LIMIT) as i128,
    }
}

impl Fixed96 {
    /// Rounds `v` to 44 binary places and clamps it to ±2e9, so that a million such values do not overflow.
    #[inline]
    pub fn from_f32(v: f32) -> Fixed96 {
        Fixed96::from_f64(f64::from(v))
    }

    /// The same for double precision.
    #[inline]
    pub fn from_f64(v: f64) -> Fixed96 {
        Fixed96::from_i128(round(v * COLOR))
    }

    pub(super) fn from_i128(v: i128) -> Fixed96 {
        Fixed96([v as u32, (v >> 32) as u32, (v >> 64) as u32])
    }

    #[inline]
    pub(super) fn to_i128(self) -> i128 {
        let [low, mid, high] = self.0;
        (i128::from(high as i32) << 64) | i128::from((u64::from(mid) << 32) | u64::from(low))
    }

    /// The stored words, the low word first.
    pub fn to_words(self) -> [u32; 3] {
        self.0
    }

    /// The inverse of [`Fixed96::to_words`].
    pub fn from_words(words: [u32; 3]) -> Fixed96 {
        Fixed96(words)
    }

    /// Whether the mean of this single value is the value itself.
    #[inline]
    pub(super) fn keeps(v: f32) -> bool {
        // Of values in this range no digit is below the last place; −0 would become 0.
        (v.abs() >= 1.0 / (1 << 20) as f32 && v.abs() <= LARGE) || v.to_bits() == 0
    }

    /// The mean of a single value in single precision: the value after rounding to the places of a sum.
    #[inline]
    pub(crate) fn mean_of_one(v: f32) -> f32 {
        match v.abs() {
            // As in `round`, but without integers.
            small if small < SMALL => (whole(f64::from(v) * COLOR) / COLOR) as f32,
            exact if exact <= LARGE => v,
            _ => Fixed96::from_f32(v).mean(1.0) as f32,
        }
    }

    /// [`Fixed96::mean_of_one`] of each value; vectorized unless a value is above [`LARGE`].
    #[inline]
    pub(crate) fn means_of_one<const N: usize>(values: [f32; N]) -> [f32; N] {
        if !values.iter().fold(true, |fit, v| fit & (v.abs() <= LARGE)) {
            return values.map(Fixed96::mean_of_one);
        }
        values.map(|v| {
            let rounded = (whole(f64::from(v) * COLOR) / COLOR) as f32;
            if v.abs() < SMALL { rounded } else { v }
        })
    }

    /// The exact sum; wraps outside the range.
    #[must_use]
    #[inline]
    pub fn plus(self, other: Fixed96) -> Fixed96 {
        Fixed96::from_i128(self.to_i128().wrapping_add(other.to_i128()))
    }

    /// Adds an integer in units of the last place to stored words; wraps outside the range.
    #[inline(always)]
    pub(super) fn add_to_words([low, mid, high]: &mut [u32; 3], v: i64) {
        let (sum, carry) = (u64::from(*mid) << 32 | u64::from(*low)).overflowing_add(v as u64);
        (*low, *mid) = (sum as u32, (sum >> 32) as u32);
        *high = high.wrapping_add((v >> 63) as u32).wrapping_add(u32::from(carry));
    }

    /// This value divided by a count or by a sum of weights.
    #[inline]
    pub fn mean(self, weight: f64) -> f64 {
        let [low, mid, high] = self.0;
        // Nearly all sums fit in 64 bits and avoid the conversion from i128, which is a function call.
        let small = (u64::from(mid) << 32 | u64::from(low)) as i64;
        let sum = if high == (small >> 63) as u32 { small as f64 } else { self.to_i128() as f64 };
        sum / (COLOR * weight)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_exact_in_any_order() {
        let values: Vec<f32> = (0..1000).map(|i| ((i * 7919) % 1009) as f32 * 1.7e-3 - 0.6).collect();
        let sum = |it: &mut dyn Iterator<Item = &f32>| {
            it.fold(Fixed96::default(), |a, v| a.plus(Fixed96::from_f32(*v)))
        };
        let forward = sum(&mut values.iter());
        assert_eq!(forward, sum(&mut values.iter().rev()));
        let halves = sum(&mut values[..317].iter()).plus(sum(&mut values[317..].iter()));
        assert_eq!(forward, halves);
        let exact: f64 = values.iter().map(|v| f64::from(*v)).sum::<f64>() / 1000.0;
        assert!((forward.mean(1000.0) - exact).abs() < 1e-12);
    }

    #[test]
    fn words_are_added_with_carry() {
        let values = [0, 1, -1, 5, i64::MAX, i64::MIN, 1 << 32, -(1 << 32), 0xffff_ffff, 1 << 44];
        let mut words = Fixed96::default().to_words();
        let mut sum = 0i128;
        for a in values {
            for b in values {
                for v in [a, b, a] {
                    Fixed96::add_to_words(&mut words, v);
                    sum += i128::from(v);
                    assert_eq!(Fixed96::from_words(words), Fixed96::from_i128(sum), "{a} {b}");
                }
            }
        }
    }

    #[test]
    fn one_sample_comes_back() {
        for v in [0.0f32, 1.0, -1.0, 0.1, 1e-6, 65504.0, 123_456.7] {
            assert_eq!(Fixed96::from_f32(v).mean(1.0) as f32, v);
        }
        let bits = (0..u32::MAX).step_by(9973).map(f32::from_bits).filter(|v| v.is_finite());
        for v in bits.chain([f32::MIN_POSITIVE, 9.6e-7, -262_145.0, 3e9]) {
            let mean = Fixed96::from_f32(v).mean(1.0) as f32;
            assert_eq!(Fixed96::mean_of_one(v).to_bits(), mean.to_bits(), "{v:e}");
            for other in [1.0, 4e5] {
                assert_eq!(Fixed96::means_of_one([v, other])[0].to_bits(), mean.to_bits(), "{v:e}");
            }
        }
        assert_eq!(Fixed96::from_f32(f32::MAX).mean(1.0), 2e9);
    }

    #[test]
    fn a_million_bright_samples_do_not_drift() {
        let v = Fixed96::from_f32(1.9e9);
        let sum = (0..1_000_000).fold(Fixed96::default(), |a, _| a.plus(v));
        assert_eq!(sum.mean(1e6) as f32, 1.9e9);
    }
}
