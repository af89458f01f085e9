//! The default sampler: Sobol points, Owen-scrambled by hashing (Laine and Karras 2011, "Stratified sampling for
//! stochastic transparency"; Burley 2020, "Practical hash-based Owen scrambling", JCGT 9(4)).
//!
//! Independent random numbers clump; a low-discrepancy sequence covers the unit square evenly. The Sobol sequence
//! multiplies the bits of the sample index by a binary matrix per dimension; the result, read as binary digits after
//! the point, is the number. Any aligned run of 2^k samples then has exactly one point in each elementary interval of
//! area 2^-k of the first two dimensions.
//!
//! Owen scrambling randomizes such points without losing that property: it flips each binary digit depending on a
//! hash of all more significant digits, that is, it swaps the two halves of an interval at random, at all levels:
//!
//! ```text
//!    digit 1:    |       0       |       1       |      swap the halves?
//!    digit 2:    |   0   |   1   |   0   |   1   |      swap the quarters of each half?
//!    digit 3:    | 0 | 1 | 0 | 1 | 0 | 1 | 0 | 1 |      ...
//! ```
//!
//! Every scrambled number is uniform, so estimates are unbiased. On reversed digits the operation is a hash in which
//! each bit depends only on lower bits: a few multiplications and xors, see [`permute`].
//!
//! A sample asks for sets of up to four numbers, one set per decision along its path (position in the pixel, choice
//! of light, BSDF sample). Each set uses its own scrambling and its own scrambled order of samples ("padding"):
//! evenly distributed within the set, independent between sets. There is no state: a number depends on seed, pixel,
//! set and sample index only.

use super::{SampleId, mix};

/// The points of one sample of a pixel.
#[derive(Clone, Copy, Debug, Default)]
pub struct OwenSobol {
    /// Hash of seed and pixel.
    pub(super) pixel: u64,
    pub(super) index: u32,
}

impl OwenSobol {
    /// The points of a sample.
    #[inline]
    pub fn new(id: &SampleId) -> OwenSobol {
        let pixel = (u64::from(id.y) << 32) | u64::from(id.x);
        OwenSobol { pixel: mix(pixel ^ mix(id.seed ^ 0x6a09_e667_f3bc_c909)), index: id.index }
    }

    /// Splits the sample: part `number` of `of`. The parts of all samples of a pixel form a sequence again.
    #[inline]
    pub fn part(&self, number: u32, of: u32) -> OwenSobol {
        OwenSobol { index: self.index.wrapping_mul(of).wrapping_add(number), ..*self }
    }

    /// Four numbers in 0..1; the first two are the best distributed pair.
    #[inline(always)] // the compiler removes numbers that the caller does not use
    pub fn four(&self, set: u32) -> [f64; 4] {
        let (a, b, c) = self.seeds(set);
        let index = self.shuffled(a as u32);
        [
            unit(permute(index, (a >> 32) as u32).reverse_bits()),
            unit(permute(column_bits(&TABLES[0], index), b as u32).reverse_bits()),
            unit(permute(column_bits(&TABLES[1], index), (b >> 32) as u32).reverse_bits()),
            unit(permute(column_bits(&TABLES[2], index), c as u32).reverse_bits()),
        ]
    }

    /// Two numbers in 0..1.
    #[inline]
    pub fn two(&self, set: u32) -> [f64; 2] {
        let (a, b, _) = self.seeds(set);
        let index = self.shuffled(a as u32);
        [
            unit(permute(index, (a >> 32) as u32).reverse_bits()),
            unit(permute(column_bits(&TABLES[0], index), b as u32).reverse_bits()),
        ]
    }

    #[inline]
    fn seeds(&self, set: u32) -> (u64, u64, u64) {
        let a = mix(self.pixel.wrapping_add(u64::from(set).wrapping_mul(0x9e37_79b9_7f4a_7c15)));
        let b = mix(a ^ 0xbf58_476d_1ce4_e5b9);
        (a, b, mix(b ^ 0x94d0_49bb_1331_11eb))
    }

    /// The sample's index in the scrambled order of this set.
    #[inline]
    fn shuffled(&self, seed: u32) -> u32 {
        permute(self.index.reverse_bits(), seed).reverse_bits()
    }
}

/// A permutation of 32-bit values in which each bit depends only on itself and lower bits: Owen scrambling of a
/// number with reversed digits (Laine and Karras 2011, with Burley's constants).
#[inline(always)]
pub(super) fn permute(mut x: u32, seed: u32) -> u32 {
    x = x.wrapping_add(seed);
    x ^= x.wrapping_mul(0x6c50_b47c);
    x ^= x.wrapping_mul(0xb82f_1e52);
    x ^= x.wrapping_mul(0xc7af_e638);
    x ^= x.wrapping_mul(0x8d22_f6e6);
    x
}

/// The number in 0..1 with these binary digits.
#[inline(always)]
pub(super) fn unit(digits: u32) -> f64 {
    f64::from(digits) * (1.0 / 4_294_967_296.0)
}

/// The product of a binary matrix and an index: the xor of the columns of its set bits, one byte at a time.
#[inline]
fn column_bits(table: &[[u32; 256]; 4], index: u32) -> u32 {
    let [a, b, c, d] = index.to_le_bytes();
    table[0][a as usize] ^ table[1][b as usize] ^ table[2][c as usize] ^ table[3][d as usize]
}

/// Generator matrices of the second, third and fourth Sobol dimension, by columns: what each bit of the index
/// contributes. The lowest bit stands for 1/2. The matrix of the first dimension is the identity.
pub(super) const COLUMNS: [[u32; 32]; 3] = [
    // Polynomials x + 1, x² + x + 1, x³ + x + 1 with the initial numbers of Joe and Kuo 2008.
    columns(1, 0, [1, 0, 0]),
    columns(2, 1, [1, 3, 0]),
    columns(3, 1, [1, 3, 1]),
];

/// The same for complete bytes of the index.
static TABLES: [[[u32; 256]; 4]; 3] = [table(&COLUMNS[0]), table(&COLUMNS[1]), table(&COLUMNS[2])];

/// Columns from the degree of a primitive polynomial, its inner coefficients and the first direction numbers.
const fn columns(degree: usize, coefficients: u32, first: [u32; 3]) -> [u32; 32] {
    let mut m = [0u32; 32];
    let mut k = 0;
    while k < 32 {
        if k < degree {
            m[k] = first[k] << (31 - k);
        } else {
            // The recurrence of Bratley and Fox 1988, with the direction numbers as fractions.
            m[k] = m[k - degree] ^ (m[k - degree] >> degree);
            let mut i = 1;
            while i < degree {
                if coefficients >> (degree - 1 - i) & 1 == 1 {
                    m[k] ^= m[k - i];
                }
                i += 1;
            }
        }
        k += 1;
    }
    k = 0;
    while k < 32 {
        m[k] = m[k].reverse_bits();
        k += 1;
    }
    m
}

const fn table(columns: &[u32; 32]) -> [[u32; 256]; 4] {
    let mut out = [[0u32; 256]; 4];
    let mut byte = 0;
    while byte < 4 {
        let mut value = 0;
        while value < 256 {
            let mut bits = 0;
            let mut bit = 0;
            while bit < 8 {
                if value >> bit & 1 == 1 {
                    bits ^= columns[8 * byte + bit];
                }
                bit += 1;
            }
            out[byte][value] = bits;
            value += 1;
        }
        byte += 1;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{ChiSquareOptions, chi_square_on_square, sidak_level};

    fn at(x: u32, index: u32) -> OwenSobol {
        OwenSobol::new(&SampleId { x, y: 3, index, seed: 11 })
    }

    /// One sample in each elementary interval, for all interval shapes: a (0, k, 2)-net.
    #[test]
    fn the_first_two_numbers_are_a_net() {
        for set in 0..20 {
            for k in 0..10u32 {
                let n = 1u32 << k;
                // Any aligned run, not only the first.
                for start in [0, n, 5 * n] {
                    for columns in 0..=k {
                        let mut seen = vec![false; n as usize];
                        for i in start..start + n {
                            let [x, y, ..] = at(9, i).four(set);
                            let column = (x * f64::from(1u32 << columns)) as usize;
                            let row = (y * f64::from(1u32 << (k - columns))) as usize;
                            let cell = column << (k - columns) | row;
                            assert!(!seen[cell], "set {set}, {n} samples, 2^{columns} columns");
                            seen[cell] = true;
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn each_number_is_stratified_and_two_is_the_start_of_four() {
        for set in 0..50 {
            for dimension in 0..4 {
                let mut seen = [false; 64];
                for i in 64..128 {
                    let s = at(1, i);
                    let four = s.four(set);
                    assert_eq!(s.two(set), [four[0], four[1]]);
                    let stratum = (four[dimension] * 64.0) as usize;
                    assert!(!seen[stratum]);
                    seen[stratum] = true;
                }
            }
        }
    }

    /// The third and fourth numbers form at worst a (1, k, 2)-net: no elementary interval of twice the area is empty.
    #[test]
    fn other_pairs_are_well_spread() {
        for (a, b) in [(0, 2), (1, 2), (0, 3), (1, 3), (2, 3)] {
            let mut cells = [0u32; 64];
            for i in 0..256 {
                let u = at(2, i).four(4);
                cells[(u[a] * 8.0) as usize * 8 + (u[b] * 8.0) as usize] += 1;
            }
            // Random points would leave cells with 0 and with 10 points.
            assert!(cells.iter().all(|c| (1..=8).contains(c)), "{a} {b}: {cells:?}");
        }
    }

    /// Chi-square test over pixels for one sample index, and for pairs of sets and of neighbouring pixels.
    #[test]
    fn pixels_and_sets_are_independent() {
        let (samples, level) = (8192, sidak_level(0.01, 32));
        let options = ChiSquareOptions { samples, rows: 8, columns: 8, ..ChiSquareOptions::default() };
        let check = |pair: &dyn Fn(u32) -> [f64; 2]| {
            let mut i = 0..samples;
            let test = chi_square_on_square(&options, |_| 1.0, || i.next().map(|i| pair(i).into()));
            assert!(test.p_value > level, "{test:?}");
        };
        for set in 0..8 {
            let one = |x: u32, set: u32, d: usize| at(x, 7).four(set)[d];
            check(&|x| [one(x, set, 0), one(x, set, 3)]);
            check(&|x| [one(x, set, 0), one(x, set + 1, 0)]);
            check(&|x| [one(x, set, 1), one(x + 1, set, 1)]);
        }
        // Between two sets of one pixel, over its samples.
        for x in 0..8 {
            check(&|i| [at(x, i).four(0)[0], at(x, i).four(1)[0]]);
        }
    }

    /// The error for a smooth integrand falls much faster than with independent random numbers.
    #[test]
    fn the_error_of_a_smooth_integrand_falls_fast() {
        let rms = |n: u32| {
            let mut sum = 0.0;
            for x in 0..200 {
                let estimate = (0..n)
                    .map(|i| {
                        let [u, v] = at(x, i).two(0);
                        (u * u) * (1.0 - v * v * v) / (1.0 / 3.0 * 0.75)
                    })
                    .sum::<f64>()
                    / f64::from(n);
                sum += (estimate - 1.0) * (estimate - 1.0);
            }
            (sum / 200.0).sqrt()
        };
        // Independent random numbers: a factor of 8.
        let (few, many) = (rms(16), rms(1024));
        assert!(few / many > 150.0, "{few} {many}");
    }
}
