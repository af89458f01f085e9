//! Numbers for sampling that depend on nothing but what they are for: a hash of seed, pixel, sample and
//! dimension. No state, so no order of rendering can change them.

mod alias;
mod owen_sobol;

pub use alias::AliasTable;
pub use owen_sobol::OwenSobol;

use crate::math::elementary::sin_cos;
use crate::math::{DVec2, DVec3};

/// What a sample's numbers depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleId {
    /// Column of the pixel.
    pub x: u32,
    /// Row of the pixel.
    pub y: u32,
    /// Which of the pixel's samples.
    pub index: u32,
    /// The render's seed.
    pub seed: u64,
}

/// Well-mixed bits (the finaliser of SplitMix64, Steele et al. 2014).
#[inline]
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl SampleId {
    /// 64 bits for one dimension of this sample.
    #[inline]
    pub fn bits(&self, dimension: u64) -> u64 {
        let pixel = (u64::from(self.y) << 32) | u64::from(self.x);
        let which = mix(pixel ^ mix(self.seed ^ 0x9e37_79b9_7f4a_7c15)) ^ u64::from(self.index);
        mix(mix(which.wrapping_add(0x9e37_79b9_7f4a_7c15))
            .wrapping_add(dimension.wrapping_mul(0x9e37_79b9_7f4a_7c15)))
    }

    /// Two numbers in 0..1 for one dimension.
    #[inline]
    pub fn unit_square(&self, dimension: u64) -> DVec2 {
        let b = self.bits(dimension);
        let scale = 1.0 / 4_294_967_296.0;
        DVec2::new(f64::from(b as u32) * scale, f64::from((b >> 32) as u32) * scale)
    }
}

/// A point of cell `i` of `n` in a grid over the unit square, columns × rows nearest to square with
/// columns·rows ≥ n; `jitter` in 0..1 places it within the cell.
pub fn stratified(i: u32, n: u32, jitter: DVec2) -> DVec2 {
    let columns = (f64::from(n).sqrt().ceil() as u32).max(1);
    let rows = n.div_ceil(columns).max(1);
    // The last row may hold fewer cells: they are wider, so that the square is covered evenly.
    let row = i / columns;
    let in_row = if row + 1 == rows { n - row * columns } else { columns };
    DVec2::new(
        (f64::from(i % columns) + jitter.x) / f64::from(in_row.max(1)),
        (f64::from(row) + jitter.y) / f64::from(rows),
    )
}

/// The unit square onto the unit disk, areas kept (Shirley & Chiu 1997).
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

/// The unit square onto the unit sphere, areas kept.
pub fn uniform_sphere(u: DVec2) -> DVec3 {
    let z = 1.0 - 2.0 * u.x;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (s, c) = sin_cos(std::f64::consts::TAU * u.y);
    DVec3::new(r * c, r * s, z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_uniform_and_independent_of_neighbours() {
        // Chi-square over 16 bins: the 0.999 quantile with 15 degrees of freedom is 37.7.
        for dimension in 0..4 {
            let mut bins = [0u32; 16];
            let n = 64 * 64;
            for i in 0..n {
                let id = SampleId { x: i % 64, y: i / 64, index: 0, seed: 7 };
                bins[(id.unit_square(dimension).x * 16.0) as usize] += 1;
            }
            let expected = f64::from(n) / 16.0;
            let chi2: f64 =
                bins.iter().map(|b| (f64::from(*b) - expected) * (f64::from(*b) - expected) / expected).sum();
            assert!(chi2 < 37.7, "dimension {dimension}: {chi2}");
        }
    }

    #[test]
    fn strata_cover_the_square_once() {
        for n in [1, 2, 3, 4, 5, 7, 9, 16, 30] {
            // The mean of the cell centres, weighted by cell area, is the middle.
            let mut seen = Vec::new();
            for i in 0..n {
                let p = stratified(i, n, DVec2::splat(0.5));
                assert!(p.x > 0.0 && p.x < 1.0 && p.y > 0.0 && p.y < 1.0);
                assert!(!seen.contains(&p), "cell {i} of {n} twice");
                seen.push(p);
            }
        }
    }

    #[test]
    fn disk_and_sphere_keep_areas() {
        let (mut inner, mut upper) = (0, 0);
        let n = 100;
        for i in 0..n * n {
            let u =
                DVec2::new((f64::from(i % n) + 0.5) / f64::from(n), (f64::from(i / n) + 0.5) / f64::from(n));
            let d = concentric_disk(u);
            assert!(d.length() <= 1.0 + 1e-12);
            inner += u32::from(d.length() < 0.5);
            upper += u32::from(uniform_sphere(u).z > 0.5);
        }
        assert!((f64::from(inner) / 10_000.0 - 0.25).abs() < 0.01);
        assert!((f64::from(upper) / 10_000.0 - 0.25).abs() < 0.01);
    }
}
