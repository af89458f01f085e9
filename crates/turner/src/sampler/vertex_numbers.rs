//! Random numbers for the path vertices of many samples at once: two consecutive sets of [`OwenSobol`] per vertex.
//!
//! The bits are those of [`OwenSobol::four`], eight samples at a time. The loops run over arrays of sixteen lanes
//! (two sets of eight samples), which compilers turn into SIMD registers. Table lookups would have to be done lane by
//! lane, so the generator matrices are applied differently: the second dimension's is Pascal's triangle modulo 2, a
//! product of five sparse matrices; the third and fourth are applied column by column.

use turner_bvh::InstructionSet;
use turner_bvh::lanes::{LANES, Simd, Work, dispatch};

use super::mix;
use super::owen_sobol::{COLUMNS, OwenSobol, permute, unit};

/// Lanes: two sets for each of eight samples.
const WIDTH: usize = 2 * LANES;

type Bits = [u32; WIDTH];

/// The eight random numbers of a path vertex, four of each set.
#[derive(Clone, Copy, Debug, Default)]
pub struct VertexNumbers([u32; 8]);

impl VertexNumbers {
    /// The numbers of one sample, from set `set` and the next.
    pub fn of(sample: &OwenSobol, set: u32) -> VertexNumbers {
        // Exact: each number has 32 bits.
        let bits = |set: u32| sample.four(set).map(|u| (u * 4_294_967_296.0) as u32);
        let ([a, b, c, d], [e, f, g, h]) = (bits(set), bits(set + 1));
        VertexNumbers([a, b, c, d, e, f, g, h])
    }

    /// The numbers of the first set, in 0..1.
    #[inline]
    pub fn first(&self) -> [f64; 4] {
        let [a, b, c, d, ..] = self.0;
        [a, b, c, d].map(unit)
    }

    /// The numbers of the second set, in 0..1.
    #[inline]
    pub fn second(&self) -> [f64; 4] {
        let [.., a, b, c, d] = self.0;
        [a, b, c, d].map(unit)
    }
}

impl OwenSobol {
    /// Fills `out` with the numbers of each sample, given with the first of its two sets.
    pub fn vertex_numbers(set: InstructionSet, samples: &[(OwenSobol, u32)], out: &mut Vec<VertexNumbers>) {
        out.clear();
        out.resize(samples.len(), VertexNumbers::default());
        dispatch(set, Fill { samples, out });
    }
}

impl OwenSobol {
    /// Fills `out` with the first three of the four numbers of a set of each sample.
    pub fn first_three(set: InstructionSet, samples: &[(OwenSobol, u32)], out: &mut Vec<[f64; 3]>) {
        out.clear();
        out.resize(samples.len(), [0.0; 3]);
        dispatch(set, FirstThree { samples, out });
    }
}

struct FirstThree<'a> {
    samples: &'a [(OwenSobol, u32)],
    out: &'a mut [[f64; 3]],
}

impl Work for FirstThree<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        for (samples, out) in self.samples.chunks(WIDTH).zip(self.out.chunks_mut(WIDTH)) {
            let mut pixels = [0u64; WIDTH];
            let mut order = [0u32; WIDTH];
            for (lane, (sample, set)) in samples.iter().enumerate() {
                pixels[lane] = in_set(sample, u64::from(*set));
                order[lane] = sample.index;
            }
            let [a, b, c, _] = numbers(pixels, order);
            for (lane, out) in out.iter_mut().enumerate() {
                *out = [unit(a[lane]), unit(b[lane]), unit(c[lane])];
            }
        }
    }
}

/// What the seeds of a set are made from.
#[inline(always)]
fn in_set(sample: &OwenSobol, set: u64) -> u64 {
    sample.pixel.wrapping_add(set.wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

struct Fill<'a> {
    samples: &'a [(OwenSobol, u32)],
    out: &'a mut [VertexNumbers],
}

impl Work for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        for (samples, out) in self.samples.chunks(LANES).zip(self.out.chunks_mut(LANES)) {
            let mut pixels = [0u64; WIDTH];
            let mut order = [0u32; WIDTH];
            for (i, (sample, set)) in samples.iter().enumerate() {
                for next in 0..2 {
                    let lane = i + next * LANES;
                    let set = u64::from(*set) + next as u64;
                    pixels[lane] = in_set(sample, set);
                    order[lane] = sample.index;
                }
            }
            let numbers = numbers(pixels, order);
            for (i, out) in out.iter_mut().enumerate() {
                for (n, numbers) in numbers.iter().enumerate() {
                    (out.0[n], out.0[n + 4]) = (numbers[i], numbers[i + LANES]);
                }
            }
        }
    }
}

/// As [`OwenSobol::four`], as binary digits. Plain loops, because closures of array methods are not compiled for the
/// caller's instruction set.
#[inline(always)]
fn numbers(pixels: [u64; WIDTH], order: Bits) -> [Bits; 4] {
    let mut seeds = [[0u64; WIDTH]; 3];
    let [a, b, c] = &mut seeds;
    for lane in 0..WIDTH {
        a[lane] = mix(pixels[lane]);
        b[lane] = mix(a[lane] ^ 0xbf58_476d_1ce4_e5b9);
        c[lane] = mix(b[lane] ^ 0x94d0_49bb_1331_11eb);
    }
    let mut index = [0; WIDTH];
    for lane in 0..WIDTH {
        index[lane] = permute(order[lane].reverse_bits(), a[lane] as u32).reverse_bits();
    }
    let mut out = [index, [0; WIDTH], by_columns(&index, &COLUMNS[1]), by_columns(&index, &COLUMNS[2])];
    for lane in 0..WIDTH {
        out[0][lane] = permute(index[lane], (a[lane] >> 32) as u32).reverse_bits();
        out[1][lane] = permute(pascal(index[lane]), b[lane] as u32).reverse_bits();
        out[2][lane] = permute(out[2][lane], (b[lane] >> 32) as u32).reverse_bits();
        out[3][lane] = permute(out[3][lane], c[lane] as u32).reverse_bits();
    }
    out
}

/// The generator matrix of x + 1: Pascal's triangle modulo 2, as a product of five sparse matrices.
#[inline(always)]
fn pascal(x: u32) -> u32 {
    let x = x ^ (x >> 1 & 0x5555_5555);
    let x = x ^ (x >> 2 & 0x3333_3333);
    let x = x ^ (x >> 4 & 0x0f0f_0f0f);
    let x = x ^ (x >> 8 & 0x00ff_00ff);
    x ^ x >> 16
}

#[inline(always)]
fn by_columns(index: &Bits, columns: &[u32; 32]) -> Bits {
    let mut sum = [0; WIDTH];
    for (bit, column) in columns.iter().enumerate() {
        for lane in 0..WIDTH {
            sum[lane] ^= column & 0u32.wrapping_sub(index[lane] >> bit & 1);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::SampleId;

    #[test]
    fn same_bits_as_one_sample() {
        let samples: Vec<(OwenSobol, u32)> = (0..100u32)
            .map(|i| {
                let id = SampleId { x: i % 7, y: i, index: i.wrapping_mul(0x9e37_79b1), seed: 5 };
                (OwenSobol::new(&id), 2 + 2 * (i % 9))
            })
            .collect();
        let mut out = Vec::new();
        for (count, set) in
            InstructionSet::available().flat_map(|set| [0, 1, 8, 100].map(|count| (count, set)))
        {
            OwenSobol::vertex_numbers(set, &samples[..count], &mut out);
            assert_eq!(out.len(), count);
            for ((sample, set), numbers) in samples.iter().zip(&out) {
                assert_eq!(numbers.first(), sample.four(*set));
                assert_eq!(numbers.second(), sample.four(set + 1));
                assert_eq!(VertexNumbers::of(sample, *set).0, numbers.0);
            }
            let mut three = Vec::new();
            OwenSobol::first_three(set, &samples[..count], &mut three);
            let all = samples[..count].iter().map(|(sample, set)| sample.four(*set));
            assert!(three.into_iter().eq(all.map(|[a, b, c, _]| [a, b, c])));
        }
    }
}
