//! Environment sampling for a batch of directions.
//!
//! Results equal those of [`EnvironmentLight::sample`] and [`EnvironmentLight::found`] bit by bit. Image and tables
//! do not fit into caches; in loops that do little but read them, many cache misses overlap.

use std::f64::consts::{PI, TAU};
use std::hint::black_box;

use turner_bvh::InstructionSet;
use turner_bvh::lanes::{Block, F64x8, LANES, Simd, Work, dispatch};

use super::distribution::{Distribution, Row};
use super::map::Taps;
use super::{AdaptiveEnvironment, EnvironmentLight, EnvironmentSample};
use crate::color::Spectrum;
use crate::math::{DVec2, DVec3, elementary_x8 as x8};

/// Scratch memory for a batch, reused between calls.
#[derive(Default)]
pub struct EnvironmentBatch {
    blocks: Vec<Directions>,
    rows: Vec<Option<(Row, [u32; 2])>>,
    taps: Vec<Taps>,
    factors: Vec<f64>,
}

/// Eight directions and their positions in the image.
#[derive(Clone, Default)]
struct Directions {
    direction: [Block; 3],
    /// Cosine of the angle from the zenith.
    cos_theta: Block,
    u: Block,
    v: Block,
    pdf: Block,
}

impl Directions {
    fn uv(&self, lane: usize) -> DVec2 {
        DVec2::new(self.u.0[lane], self.v.0[lane])
    }

    fn direction(&self, lane: usize) -> DVec3 {
        let [x, y, z] = &self.direction;
        DVec3::new(x.0[lane], y.0[lane], z.0[lane])
    }
}

impl EnvironmentBatch {
    fn reset(&mut self, count: usize) {
        // Lanes of the last block beyond the count are computed and ignored.
        self.blocks.resize_with(count.div_ceil(LANES).max(self.blocks.len()), Directions::default);
    }
}

impl EnvironmentLight {
    /// [`EnvironmentLight::sample`] for each pair of numbers; `take` gets its index and the result.
    pub fn sample_batch(
        &self,
        set: InstructionSet,
        u: &[[f64; 2]],
        scratch: &mut EnvironmentBatch,
        mut take: impl FnMut(usize, Option<EnvironmentSample>),
    ) {
        let EnvironmentBatch { rows, .. } = &mut *scratch;
        rows.clear();
        rows.extend(u.iter().map(|u| self.prepared.distribution.row_of(*u).map(|row| (row, [0; 2]))));
        self.sample_in_rows(set, &self.prepared.distribution, scratch, |i, sample, _| take(i, sample));
    }

    /// Samples in the rows that are chosen; `take` also gets the scratch memory's factors.
    fn sample_in_rows(
        &self,
        set: InstructionSet,
        distribution: &Distribution,
        scratch: &mut EnvironmentBatch,
        mut take: impl FnMut(usize, Option<EnvironmentSample>, &[f64]),
    ) {
        let count = scratch.rows.len();
        scratch.reset(count);
        let map = &self.prepared.map;
        let EnvironmentBatch { blocks, rows, taps, factors } = scratch;
        for chosen in &mut *rows {
            *chosen = chosen.and_then(|(row, _)| Some((row, distribution.span(&row)?)));
        }
        black_box(distribution.prefetch(rows));
        for (rows, block) in rows.chunks(LANES).zip(&mut *blocks) {
            for (lane, row) in rows.iter().enumerate() {
                let found = row.and_then(|(row, span)| distribution.position(&row, span));
                let (across, cos_theta, pdf) = found.unwrap_or((0.0, 0.0, 0.0));
                (block.u.0[lane], block.cos_theta.0[lane], block.pdf.0[lane]) = (across, cos_theta, pdf);
            }
        }
        let blocks = &mut blocks[..count.div_ceil(LANES)];
        dispatch(set, ChosenDirections { blocks, rotation: self.rotation });
        taps.clear();
        taps.extend((0..count).map(|i| map.taps(blocks[i / LANES].uv(i % LANES))));
        black_box(map.prefetch(taps));
        for (i, taps) in taps.iter().enumerate() {
            let (block, lane) = (&blocks[i / LANES], i % LANES);
            let pdf = block.pdf.0[lane];
            let sample = (pdf > 0.0).then(|| EnvironmentSample {
                direction: self.tilted(block.direction(lane)),
                radiance: self.scaled(map.blend(taps)),
                pdf,
            });
            take(i, sample, factors);
        }
    }

    /// [`EnvironmentLight::found`] for each direction; `take` gets its index and the result.
    pub fn found_batch(
        &self,
        set: InstructionSet,
        directions: &[DVec3],
        scratch: &mut EnvironmentBatch,
        mut take: impl FnMut(usize, (Spectrum, f64)),
    ) {
        let distribution = &self.prepared.distribution;
        self.found_at(set, distribution, directions, scratch, |i, radiance, uv| {
            take(i, (radiance, distribution.pdf_at(uv)));
        });
    }

    /// Radiance and (u, v) in the image of each direction. The density there is prefetched.
    fn found_at(
        &self,
        set: InstructionSet,
        distribution: &Distribution,
        directions: &[DVec3],
        scratch: &mut EnvironmentBatch,
        mut take: impl FnMut(usize, Spectrum, DVec2),
    ) {
        scratch.reset(directions.len());
        let map = &self.prepared.map;
        let EnvironmentBatch { blocks, taps, .. } = scratch;
        for (directions, block) in directions.chunks(LANES).zip(&mut *blocks) {
            for (lane, d) in directions.iter().enumerate() {
                for (block, v) in block.direction.iter_mut().zip(self.upright(*d).to_array()) {
                    block.0[lane] = v;
                }
            }
        }
        let blocks = &mut blocks[..directions.len().div_ceil(LANES)];
        dispatch(set, Positions { blocks, rotation: self.rotation });
        let position = |i: usize| blocks[i / LANES].uv(i % LANES);
        taps.clear();
        taps.extend((0..directions.len()).map(|i| map.taps(position(i))));
        black_box(map.prefetch(taps));
        black_box(distribution.prefetch_at((0..directions.len()).map(position)));
        for (i, taps) in taps.iter().enumerate() {
            take(i, self.scaled(map.blend(taps)), position(i));
        }
    }
}

impl AdaptiveEnvironment {
    /// [`AdaptiveEnvironment::sample`] for each cell and pair of numbers; `take` gets its index and the result.
    pub fn sample_batch(
        &self,
        set: InstructionSet,
        requests: &[(u32, [f64; 2])],
        scratch: &mut EnvironmentBatch,
        mut take: impl FnMut(usize, Option<EnvironmentSample>),
    ) {
        let EnvironmentBatch { rows, factors, .. } = &mut *scratch;
        rows.clear();
        factors.clear();
        for (cell, u) in requests {
            let row = self.row(*cell, *u);
            rows.push(row.map(|(row, _)| (row, [0; 2])));
            factors.push(row.map_or(0.0, |(_, factor)| factor));
        }
        let (environment, distribution) = self.parts();
        environment.sample_in_rows(set, distribution, scratch, |i, sample, factors| {
            let sample = sample.map(|s| EnvironmentSample { pdf: s.pdf * factors[i], ..s });
            take(i, sample.filter(|s| s.pdf > 0.0));
        });
    }

    /// [`AdaptiveEnvironment::found`] for each cell and direction; `take` gets its index and the result.
    pub fn found_batch(
        &self,
        set: InstructionSet,
        cells: &[u32],
        directions: &[DVec3],
        scratch: &mut EnvironmentBatch,
        mut take: impl FnMut(usize, (Spectrum, f64)),
    ) {
        let (environment, distribution) = self.parts();
        environment.found_at(set, distribution, directions, scratch, |i, radiance, uv| {
            take(i, (radiance, self.pdf_at(cells[i], uv)));
        });
    }
}

/// Computes the sampled directions in world space, and their v in the image.
struct ChosenDirections<'a> {
    blocks: &'a mut [Directions],
    rotation: (f64, f64),
}

impl Work for ChosenDirections<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let (sin, cos) = (F64x8::splat(simd, self.rotation.0), F64x8::splat(simd, self.rotation.1));
        let (zero, one) = (F64x8::splat(simd, 0.0), F64x8::splat(simd, 1.0));
        for block in self.blocks {
            let cos_theta = F64x8::load(simd, &block.cos_theta);
            let sin_theta = (one - cos_theta * cos_theta).or_larger(zero).sqrt();
            (x8::angle(simd, sin_theta, cos_theta) * F64x8::splat(simd, 1.0 / PI)).store(&mut block.v);
            let u = F64x8::load(simd, &block.u);
            let (sin_phi, cos_phi) = x8::sin_cos_turns(simd, u - F64x8::splat(simd, 0.5));
            let (x, y, z) = (sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi);
            let [to_x, to_y, to_z] = &mut block.direction;
            (cos * x + sin * z).store(to_x);
            y.store(to_y);
            (cos * z - sin * x).store(to_z);
        }
    }
}

/// Computes the positions of world-space directions in the image.
struct Positions<'a> {
    blocks: &'a mut [Directions],
    rotation: (f64, f64),
}

impl Work for Positions<'_> {
    type Output = ();

    /// Like `coordinates_fast`, operation by operation.
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let (sin, cos) = (F64x8::splat(simd, self.rotation.0), F64x8::splat(simd, self.rotation.1));
        let zero = F64x8::splat(simd, 0.0);
        for block in self.blocks {
            let [x, y, z] = &block.direction;
            let (x, y, z) = (F64x8::load(simd, x), F64x8::load(simd, y), F64x8::load(simd, z));
            let (x, z) = (cos * x - sin * z, sin * x + cos * z);
            let flat = (x * x + z * z).sqrt();
            let phi = flat.gt(zero).select(x8::angle(simd, x, -z), zero);
            (F64x8::splat(simd, 0.5) + phi * F64x8::splat(simd, 1.0 / TAU)).store(&mut block.u);
            (x8::angle(simd, flat, y) * F64x8::splat(simd, 1.0 / PI)).store(&mut block.v);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::image::{Image, Pixels};
    use crate::sampler::uniform_sphere;
    use crate::testing::Random;

    #[test]
    fn batches_equal_single_samples() {
        let mut random = Random::new(2);
        let samples = (0..37 * 19 * 3)
            .map(|_| crate::math::elementary::pow(random.units::<1>()[0], 4.0) as f32)
            .collect();
        let image = Image { width: 37, height: 19, channels: 3, pixels: Pixels::F32(samples) };
        let rotation = crate::math::elementary::sin_cos(0.7);
        let mut scratch = EnvironmentBatch::default();
        let sets: Vec<InstructionSet> = InstructionSet::available().collect();
        for compensated in [false, true] {
            let light =
                EnvironmentLight::from_image(Arc::new(image.clone()), Spectrum::WHITE, rotation, compensated)
                    .unwrap();
            for (i, count) in [0, 3, 8, 700, 12].into_iter().enumerate() {
                let set = sets[i % sets.len()];
                let u: Vec<[f64; 2]> = (0..count).map(|_| random.units::<2>()).collect();
                let mut seen = 0;
                light.sample_batch(set, &u, &mut scratch, |i, sample| {
                    assert_eq!(sample, light.sample(u[i]));
                    seen += 1;
                });
                let mut directions: Vec<DVec3> = u.iter().map(|u| uniform_sphere((*u).into())).collect();
                if let Some(d) = directions.first_mut() {
                    *d = DVec3::Y;
                }
                light.found_batch(set, &directions, &mut scratch, |i, found| {
                    assert_eq!(found, light.found(directions[i]));
                    seen += 1;
                });
                assert_eq!(seen, 2 * count);
            }
        }
    }
}
