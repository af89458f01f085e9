//! Counter-based random numbers: each is a hash of seed, pixel, sample index and dimension. There is no state, so the
//! order of rendering cannot change them.

mod alias;
mod owen_sobol;
mod stream;
mod vertex_numbers;

pub use alias::AliasTable;
pub use owen_sobol::OwenSobol;
pub use stream::Stream;
pub use vertex_numbers::VertexNumbers;

use crate::math::elementary::sin_cos;
use crate::math::{DVec2, DVec3};

/// The identity of a sample, on which its random numbers depend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleId {
    /// Column of the pixel.
    pub x: u32,
    /// Row of the pixel.
    pub y: u32,
    /// Index of the sample within the pixel.
    pub index: u32,
    /// The seed of the render.
    pub seed: u64,
}

/// A hash of 64 bits (the finalizer of SplitMix64, Steele et al. 2014).
#[inline(always)]
pub(crate) fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl SampleId {
    /// 64 random bits for one dimension of this sample.
    #[inline]
    pub fn bits(&self, dimension: u64) -> u64 {
        let pixel = (u64::from(self.y) << 32) | u64::from(self.x);
        let which = mix(pixel ^ mix(self.seed ^ 0x9e37_79b9_7f4a_7c15)) ^ u64::from(self.index);
        mix(mix(which.wrapping_add(0x9e37_79b9_7f4a_7c15))
            .wrapping_add(dimension.wrapping_mul(0x9e37_79b9_7f4a_7c15)))
    }

    /// Two random numbers in 0..1 for one dimension.
    #[inline]
    pub fn unit_square(&self, dimension: u64) -> DVec2 {
        let b = self.bits(dimension);
        let scale = 1.0 / 4_294_967_296.0;
        DVec2::new(f64::from(b as u32) * scale, f64::from((b >> 32) as u32) * scale)
    }
}

/// A jittered point in stratum `i` of `n` over the unit square. The grid has about as many columns as rows, with
/// columns · rows ≥ n; `jitter` in 0..1 is the position within the stratum.
pub fn stratified(i: u32, n: u32, jitter: DVec2) -> DVec2 {
    let columns = (f64::from(n).sqrt().ceil() as u32).max(1);
    let rows = n.div_ceil(columns).max(1);
    // The last row may have fewer strata; they are wider, so that the density stays uniform.
    let row = i / columns;
    let in_row = if row + 1 == rows { n - row * columns } else { columns };
    DVec2::new(
        (f64::from(i % columns) + jitter.x) / f64::from(in_row.max(1)),
        (f64::from(row) + jitter.y) / f64::from(rows),
    )
}

/// Maps the unit square to the unit disk, preserving area (Shirley and Chiu 1997).
pub fn concentric_disk(u: DVec2) -> DVec2 {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
    let o = 2.0 * u - DVec2::ONE;
    if o == DVec2::ZERO {
        return DVec2::ZERO;
    }
    let (r, angle) = if o.x.abs() > o.y.abs() {
        (o.x, FRAC_PI_4 * (o.y / o.x))
    } else {
        (o.y, FRAC_PI_2 - FRAC_PI_4 * (o.x / o.y))
    };
    let (s, c) = sin_cos(angle);
    r * DVec2::new(c, s)
}

/// Maps the unit square to the unit sphere, preserving area.
pub fn uniform_sphere(u: DVec2) -> DVec3 {
    let z = 1.0 - 2.0 * u.x;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (s, c) = sin_cos(std::f64::consts::TAU * u.y);
    DVec3::new(r * c, r * s, z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{
        ChiSquareOptions, Random, chi_square_of_directions, chi_square_on_square, sidak_level,
    };

    #[test]
    fn numbers_are_uniform_and_independent_of_neighbours() {
        let options = ChiSquareOptions { samples: 64 * 64, rows: 8, columns: 8, ..Default::default() };
        for dimension in 0..4 {
            let mut i = 0..64 * 64;
            let sample = || {
                let id = i.next().map(|i| SampleId { x: i % 64, y: i / 64, index: 0, seed: 7 });
                id.map(|id| id.unit_square(dimension))
            };
            let test = chi_square_on_square(&options, |_| 1.0, sample);
            assert!(test.p_value > sidak_level(0.01, 4), "dimension {dimension}: {test:?}");
        }
    }

    #[test]
    fn disk_and_sphere_are_covered_evenly() {
        let mut random = Random::new(4);
        let options = ChiSquareOptions::default();
        let disk = |p: DVec2| {
            let inside = (2.0 * p - 1.0).length_squared() <= 1.0;
            if inside { 4.0 / std::f64::consts::PI } else { 0.0 }
        };
        let on_disk = || Some(0.5 * (concentric_disk(random.units::<2>().into()) + 1.0));
        let test = chi_square_on_square(&options, disk, on_disk);
        assert!(test.p_value > sidak_level(0.01, 2), "{test:?}");
        let even = |_| 0.25 / std::f64::consts::PI;
        let test =
            chi_square_of_directions(&options, even, || Some(uniform_sphere(random.units::<2>().into())));
        assert!(test.p_value > sidak_level(0.01, 2), "{test:?}");
    }

    #[test]
    fn strata_cover_the_square_once() {
        for n in [1, 2, 3, 4, 5, 7, 9, 16, 30] {
            // The mean of the stratum centres, weighted by area, is the centre of the square.
            let mut seen = Vec::new();
            for i in 0..n {
                let p = stratified(i, n, DVec2::splat(0.5));
                assert!(p.x > 0.0 && p.x < 1.0 && p.y > 0.0 && p.y < 1.0);
                assert!(!seen.contains(&p), "cell {i} of {n} twice");
                seen.push(p);
            }
        }
    }
}
