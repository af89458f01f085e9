//! Lookup tables for 8-bit display values: the sRGB curve without a power for each component.

use std::sync::OnceLock;

use crate::color::Transfer;
use crate::math::elementary::pow;

/// A lookup table of a monotonically increasing curve from linear values 0..=1 to bytes. Lookups are exact.
pub(super) struct ByteTable {
    /// Entry i is the smallest linear value whose byte is i + 1. The last entry is NaN, so that every search ends.
    thresholds: [f32; 256],
    /// The byte of the smallest value in each [`bucket`], where a search begins.
    starts: [u8; BUCKETS],
}

/// log2 of the buckets in an octave (a factor of two), and the number of buckets: 13 octaves from 2^−13 to 1.
const FINE: u32 = 5;
const BUCKETS: usize = (13 << FINE) + 2;

/// The exponents that have a table.
const POWERS: [f64; 2] = [1.0, 2.2];

/// The bucket of a value: its exponent and the leading bits of its mantissa. All values below 2^−13 are in bucket 0.
fn bucket(v: f32) -> usize {
    const SHIFT: u32 = f32::MANTISSA_DIGITS - 1 - FINE;
    const FIRST: u32 = (127 - 13) << FINE;
    let v = if v > 0.0 { v.min(1.0) } else { 0.0 };
    (((v.to_bits() >> SHIFT) + 1).saturating_sub(FIRST) as usize).min(BUCKETS - 1)
}

impl ByteTable {
    /// The table of v → sRGB(v^power); `None` if there is no table for this power.
    pub(super) fn srgb_of_power(power: f64) -> Option<&'static ByteTable> {
        static TABLES: [OnceLock<ByteTable>; POWERS.len()] = [const { OnceLock::new() }; POWERS.len()];
        let i = POWERS.iter().position(|p| *p == power)?;
        let linear = move |v: f32| if power == 1.0 { v } else { pow(f64::from(v), power) as f32 };
        Some(TABLES[i].get_or_init(|| ByteTable::new(|v| quantise(Transfer::Srgb.encode(linear(v))))))
    }

    fn new(curve: impl Fn(f32) -> u8) -> ByteTable {
        let mut thresholds = [f32::NAN; 256];
        for (i, threshold) in (1..=255).zip(&mut thresholds) {
            *threshold = smallest(|v| curve(v) >= i);
        }
        let mut starts = [0; BUCKETS];
        for (i, start) in starts.iter_mut().enumerate() {
            let least = smallest(|v| bucket(v) >= i);
            *start = thresholds[..255].partition_point(|t| *t <= least) as u8;
        }
        ByteTable { thresholds, starts }
    }

    /// The byte of a linear value, which is clamped to 0..=1.
    #[inline]
    pub(super) fn byte(&self, v: f32) -> u8 {
        let mut i = usize::from(self.starts[bucket(v)]);
        while self.thresholds[i] <= v {
            i += 1;
        }
        i as u8
    }
}

/// The nearest 8-bit value.
pub(super) fn quantise(encoded: f32) -> u8 {
    (f64::from(encoded) * 255.0 + 0.5) as u8
}

/// The smallest f32 in 0..=1 for which a monotonic condition is true, or 1 if there is none. Bisects the bits of
/// non-negative floats, which are ordered like their values.
fn smallest(is_reached: impl Fn(f32) -> bool) -> f32 {
    let (mut low, mut high) = (0u32, 1.0f32.to_bits());
    while low < high {
        let middle = low + (high - low) / 2;
        if is_reached(f32::from_bits(middle)) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    f32::from_bits(low)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_the_curve() {
        for power in POWERS {
            let table = ByteTable::srgb_of_power(power).unwrap();
            let exact = |v: f32| quantise(Transfer::Srgb.encode(pow(f64::from(v), power) as f32));
            let even = (0..=40_000).map(|i| i as f32 / 39_000.0);
            let dark = (0..4000).map(|i| pow(2.0, f64::from(i) / 100.0 - 60.0) as f32);
            let thresholds = table.thresholds[..255].iter().flat_map(|t| [t.next_down(), *t, t.next_up()]);
            for v in even.chain(dark).chain(thresholds).filter(|v| *v <= 1.0) {
                assert_eq!(table.byte(v), exact(v), "{v} to the power of {power}");
            }
            assert_eq!([-1.0, -0.0, 2.0, f32::INFINITY].map(|v| table.byte(v)), [0, 0, 255, 255]);
        }
        assert!(ByteTable::srgb_of_power(3.0).is_none());
    }
}
