//! Random numbers for loops whose length is not known in advance, such as random walks.

use super::{OwenSobol, mix};

/// A sequence of random numbers for one purpose of a sample; the same each time it is created (SplitMix64, Steele et
/// al. 2014).
#[derive(Clone, Debug)]
pub struct Stream(u64);

impl Stream {
    /// The next number, in 0..1.
    #[inline]
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        (mix(self.0) >> 11) as f64 / (1u64 << 53) as f64
    }
}

impl OwenSobol {
    /// The sequence of a set, independent of the numbers of the set.
    #[inline]
    pub fn stream(&self, set: u32) -> Stream {
        let which = (u64::from(self.index) << 32) | u64::from(set);
        Stream(mix(self.pixel ^ mix(which ^ 0x3c6e_f372_fe94_f82b)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::SampleId;

    #[test]
    fn sequences_are_uniform_and_differ_by_sample_and_set() {
        let of = |index, set| OwenSobol::new(&SampleId { x: 3, y: 4, index, seed: 1 }).stream(set);
        let (mut sum, mut square, mut product) = (0.0, 0.0, 0.0);
        let n = 100_000;
        let (mut a, mut b) = (of(0, 7), of(1, 7));
        for _ in 0..n {
            let (u, v) = (a.unit(), b.unit());
            assert!((0.0..1.0).contains(&u));
            (sum, square, product) = (sum + u, square + u * u, product + u * v);
        }
        let n = f64::from(n);
        assert!((sum / n - 0.5).abs() < 0.004 && (square / n - 1.0 / 3.0).abs() < 0.004);
        assert!((product / n - 0.25).abs() < 0.004);
        assert_ne!(of(0, 7).unit(), of(0, 8).unit());
        assert_eq!(of(2, 9).unit(), of(2, 9).unit());
    }
}
