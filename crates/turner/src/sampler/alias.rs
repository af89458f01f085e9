//! A choice among things in proportion to their weights, in constant time (Walker 1977; Vose 1991).

/// A prepared choice.
#[derive(Clone, Debug, Default)]
pub struct AliasTable {
    slots: Vec<Slot>,
}

#[derive(Clone, Copy, Debug)]
struct Slot {
    /// Below this share of the slot it stands for itself.
    keep: f32,
    /// What it stands for otherwise.
    other: u32,
    /// The probability of this thing.
    probability: f32,
}

impl AliasTable {
    /// For weights that are finite and not negative; others count as 0. Where all are 0 each is as likely. `None`
    /// for no weights, more than 2^32, or no memory.
    pub fn new(weights: &[f64]) -> Option<AliasTable> {
        let n = u32::try_from(weights.len()).ok().filter(|n| *n > 0)?;
        let weight =
            |i: u32| weights.get(i as usize).copied().filter(|w| *w > 0.0 && w.is_finite()).unwrap_or(0.0);
        let largest = (0..n).map(weight).fold(0.0, f64::max);
        // Scaled so that the sum neither overflows nor vanishes.
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
            table.slots.push(Slot { keep: 1.0, other: i, probability: p as f32 });
            let share = p * f64::from(n);
            rest.push(share);
            if share < 1.0 { small.push(i) } else { large.push(i) }
        }
        while let (Some(s), Some(&l)) = (small.pop(), large.last()) {
            let left = rest[s as usize];
            table.slots[s as usize].keep = left as f32;
            table.slots[s as usize].other = l;
            rest[l as usize] -= 1.0 - left;
            if rest[l as usize] < 1.0 {
                large.pop();
                small.push(l);
            }
        }
        Some(table)
    }

    /// The one that `u` in 0..1 chooses, its probability, and what is left of `u`, again in 0..1.
    #[inline]
    pub fn sample(&self, u: f64) -> (u32, f64, f64) {
        let n = self.slots.len();
        if n == 1 {
            return (0, self.probability(0), u.clamp(0.0, 1.0 - f64::EPSILON));
        }
        let scaled = u * n as f64;
        let i = (scaled as usize).min(n - 1);
        let slot = &self.slots[i];
        let (left, keep) = (scaled - i as f64, f64::from(slot.keep));
        let (chosen, left) =
            if left < keep { (i as u32, left / keep) } else { (slot.other, (left - keep) / (1.0 - keep)) };
        (chosen, self.probability(chosen), left.clamp(0.0, 1.0 - f64::EPSILON))
    }

    /// The probability of one; 0 for a number beyond the last.
    #[inline]
    pub fn probability(&self, i: u32) -> f64 {
        self.slots.get(i as usize).map_or(0.0, |s| f64::from(s.probability))
    }

    /// Among how many things.
    pub fn len(&self) -> usize {
        self.slots.len()
    }

    /// Whether there is nothing to choose.
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
    fn chooses_in_proportion_and_says_so() {
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
                let (chosen, p, left) = table.sample((f64::from(i) + 0.5) / f64::from(n));
                assert!((0.0..1.0).contains(&left) && p == table.probability(chosen));
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
    fn what_is_left_is_uniform() {
        let table = AliasTable::new(&[1.0, 2.0, 0.5]).unwrap();
        let mut sums = [(0.0, 0.0); 3];
        for i in 0..30_000 {
            let (chosen, _, left) = table.sample((f64::from(i) + 0.5) / 30_000.0);
            sums[chosen as usize].0 += left;
            sums[chosen as usize].1 += 1.0;
        }
        for (sum, n) in sums {
            assert!((sum / n - 0.5_f64).abs() < 0.01);
        }
    }
}
