//! The alias method: sampling a discrete distribution in constant time (Walker 1977; Vose 1991).
//!
//! The n items get n slots of equal probability 1/n. Each slot is filled with one item's probability and, where that
//! is less than 1/n, topped up by a single other item, the alias:
//!
//! ```text
//!    weights 1 : 5 : 3 : 3
//!
//!         +---+---+---+---+
//!         | 1 |   |   |   |    alias
//!         |---| 1 | 2 | 3 |
//!         | 0 |   |   |   |    the slot's own item
//!         +---+---+---+---+
//!    slot   0   1   2   3
//! ```
//!
//! To sample, u · n selects a slot by its integer part, and its fraction decides between the item and the alias. The
//! fraction is rescaled and returned, so that the same random number can be used again.

/// A discrete distribution prepared for sampling.
#[derive(Clone, Debug, Default)]
pub struct AliasTable {
    slots: Vec<Slot>,
}

#[derive(Clone, Copy, Debug)]
struct Slot {
    /// The slot yields its own item below this fraction, else the alias.
    threshold: f32,
    /// The alias.
    alias: u32,
    /// The probability of the slot's own item.
    probability: f32,
}

impl AliasTable {
    /// From finite, non-negative weights; others count as 0. If all are 0, the distribution is uniform. `None` if
    /// there are no weights, more than 2^32 - 1, or not enough memory.
    pub fn new(weights: &[f64]) -> Option<AliasTable> {
        let n = u32::try_from(weights.len()).ok().filter(|n| *n > 0)?;
        let weight =
            |i: u32| weights.get(i as usize).copied().filter(|w| *w > 0.0 && w.is_finite()).unwrap_or(0.0);
        let largest = (0..n).map(weight).fold(0.0, f64::max);
        // Scaled so that the sum neither overflows nor underflows.
        let scaled = |i: u32| if largest > 0.0 { weight(i) / largest } else { 1.0 };
        let sum: f64 = (0..n).map(scaled).sum();
        let mut table = AliasTable::default();
        let (mut small, mut large) = (Vec::new(), Vec::new());
        let mut rest: Vec<f64> = Vec::new();
        table.slots.try_reserve_exact(n as usize).ok()?;
        rest.try_reserve_exact(n as usize).ok()?;
        small.try_reserve_exact(n as usize).ok()?;
        large.try_reserve_exact(n as usize).ok()?;
        for i in 0..n {
            let p = scaled(i) / sum;
            table.slots.push(Slot { threshold: 1.0, alias: i, probability: p as f32 });
            let relative = p * f64::from(n);
            rest.push(relative);
            if relative < 1.0 { small.push(i) } else { large.push(i) }
        }
        while let (Some(s), Some(&l)) = (small.pop(), large.last()) {
            let remainder = rest[s as usize];
            table.slots[s as usize].threshold = remainder as f32;
            table.slots[s as usize].alias = l;
            rest[l as usize] -= 1.0 - remainder;
            if rest[l as usize] < 1.0 {
                large.pop();
                small.push(l);
            }
        }
        Some(table)
    }

    /// The item that `u` in 0..1 selects, its probability, and the remaining randomness of `u`, again in 0..1.
    #[inline]
    pub fn sample(&self, u: f64) -> (u32, f64, f64) {
        let n = self.slots.len();
        if n == 1 {
            return (0, self.probability(0), u.clamp(0.0, 1.0 - f64::EPSILON));
        }
        let scaled = u * n as f64;
        let i = (scaled as usize).min(n - 1);
        let slot = &self.slots[i];
        let (remainder, threshold) = (scaled - i as f64, f64::from(slot.threshold));
        let (chosen, remainder) = if remainder < threshold {
            (i as u32, remainder / threshold)
        } else {
            (slot.alias, (remainder - threshold) / (1.0 - threshold))
        };
        (chosen, self.probability(chosen), remainder.clamp(0.0, 1.0 - f64::EPSILON))
    }

    /// The probability of an item; 0 for an index out of range.
    #[inline]
    pub fn probability(&self, i: u32) -> f64 {
        self.slots.get(i as usize).map_or(0.0, |s| f64::from(s.probability))
    }

    /// Number of items.
    pub fn len(&self) -> usize {
        self.slots.len()
    }

    /// Whether there are no items.
    pub fn is_empty(&self) -> bool {
        self.slots.is_empty()
    }

    /// Bytes of memory.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.slots[..])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frequencies_match_probabilities() {
        for weights in [
            &[1.0][..],
            &[1.0, 2.0, 3.0, 0.0, 10.0],
            &[0.0, 0.0],
            &[1e-300, 1e300, f64::NAN, -3.0],
            &[5.0; 7],
        ] {
            let table = AliasTable::new(weights).unwrap();
            let n = 100_000;
            let mut counts = vec![0.0; weights.len()];
            for i in 0..n {
                let (chosen, p, remainder) = table.sample((f64::from(i) + 0.5) / f64::from(n));
                assert!((0.0..1.0).contains(&remainder) && p == table.probability(chosen));
                counts[chosen as usize] += 1.0 / f64::from(n);
            }
            let mut sum = 0.0;
            for (i, count) in counts.iter().enumerate() {
                let p = table.probability(i as u32);
                assert!((count - p).abs() < 1e-4, "{weights:?}: {count} and {p}");
                sum += p;
            }
            assert!((sum - 1.0).abs() < 1e-6);
        }
        assert!(AliasTable::new(&[]).is_none());
    }

    #[test]
    fn the_remainder_is_uniform() {
        let table = AliasTable::new(&[1.0, 2.0, 0.5]).unwrap();
        let mut sums = [(0.0, 0.0); 3];
        for i in 0..30_000 {
            let (chosen, _, remainder) = table.sample((f64::from(i) + 0.5) / 30_000.0);
            sums[chosen as usize].0 += remainder;
            sums[chosen as usize].1 += 1.0;
        }
        for (sum, n) in sums {
            assert!((sum / n - 0.5_f64).abs() < 0.01);
        }
    }
}
