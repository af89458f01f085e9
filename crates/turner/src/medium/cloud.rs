//! Procedural clouds in a box, after pbrt's medium "cloud" (Pharr, Jakob and Humphreys 2023, §11.4.5).

use std::sync::Arc;

use super::{Coefficients, Heterogeneous, PhaseFunction};
use crate::color::Spectrum;
use crate::math::DVec3;
use crate::schema::{ErrorCode, GridData, Range, SceneError, params};
use crate::texture::reference_noise;

params! {
    /// Clouds that fill a box: dense below, in wisps above the middle of its height (y), none at its top. The density is
    /// evaluated on a grid once, before rendering.
    pub struct CloudMedium as "cloud" {
        /// Corner of the box with the smallest coordinates, in scene units.
        min: DVec3 = DVec3::ZERO;
        /// Corner of the box with the largest coordinates.
        max: DVec3 = DVec3::ONE;
        /// How much of the upper half the clouds cover; below the middle it changes little. The density is at most 1.
        density: f64 = 1.0, in Range::closed(0.0, 1e30);
        /// How much finer noise displaces the edges.
        wispiness: f64 = 1.0, in Range::closed(0.0, 1e6);
        /// Number of the largest billows along each side of the box.
        frequency: f64 = 5.0, in Range::closed(0.0, 1e6);
        /// Cells of the grid along the longest side of the box.
        resolution: u32 = 160, in Range::closed(4.0, 512.0);
        /// Extinction coefficient (absorption + scattering) per scene unit at density 1, by colour. 1 if no coefficient
        /// is given.
        extinction: Option<Spectrum> = None, in Range::closed(0.0, 1e30);
        /// Single-scattering albedo, by colour: the fraction of the extinction that is scattered. 0 only absorbs, 1
        /// only scatters. 1 if not given.
        albedo: Option<Spectrum> = None, in Range::UNIT;
        /// Absorption coefficient per scene unit at density 1, by colour; with `scattering`, instead of `extinction`
        /// and `albedo`.
        absorption: Option<Spectrum> = None, in Range::closed(0.0, 1e30);
        /// Scattering coefficient per scene unit at density 1, by colour; with `absorption`, instead of `extinction`
        /// and `albedo`.
        scattering: Option<Spectrum> = None, in Range::closed(0.0, 1e30);
        /// Mean cosine g of the Henyey-Greenstein phase function: 0 is isotropic, above 0 forward, below 0 backward.
        anisotropy: f64 = 0.0, in Range::closed(-0.999, 0.999);
        /// Mean cosine of a second Henyey-Greenstein lobe: clouds have one that scatters back.
        second_anisotropy: f64 = 0.0, in Range::closed(-0.999, 0.999);
        /// Fraction of light that the second lobe scatters.
        second_weight: f64 = 0.0, in Range::UNIT;
        /// Fraction of light that is scattered by Rayleigh's phase function, as by particles much smaller than the
        /// wavelength: 1 is clear air. The lobes above share the rest.
        rayleigh: f64 = 0.0, in Range::UNIT;
        /// Emitted radiance per scene unit at density 1.
        emission: Spectrum = Spectrum::BLACK, in Range::closed(0.0, 1e15);
    }
    example r##"[medium.sky]
type = "cloud"
min = [-4, 0, -4]
max = [4, 2, 4]
extinction = 20
resolution = 64

[[object]]
type = "box"
min = [-4, 0, -4]
max = [4, 2, 4]
medium = "sky"
"##
}

impl CloudMedium {
    /// Prepares the medium.
    ///
    /// Errors: both pairs of coefficients at once, an empty box, out of memory.
    pub fn prepare(&self) -> Result<Heterogeneous, SceneError> {
        let coefficients = Coefficients::new(
            1.0,
            [self.extinction, self.albedo],
            [self.absorption, self.scattering],
            PhaseFunction::new([self.anisotropy, self.second_anisotropy], self.second_weight, self.rayleigh),
            self.emission,
        )?;
        let size = self.max - self.min;
        if !(size.cmpgt(DVec3::ZERO).all() && size.is_finite()) {
            let message = format!("the box of the clouds, {} to {}, is empty", self.min, self.max);
            return Err(SceneError::new(ErrorCode::OutOfRange, message)
                .help("`min` must be less than `max` along each axis"));
        }
        let data = self.grid([DVec3::ZERO, DVec3::ONE], size)?;
        Heterogeneous::new(coefficients, Arc::new(data), false, [self.min, self.max])
    }

    /// The densities in a part of the clouds' own space, whose box is from (0, 0, 0) to (1, 1, 1). `sides` are the
    /// lengths of the part's sides in any unit: cells are about cubes.
    ///
    /// Errors: out of memory.
    pub fn grid(&self, [from, to]: [DVec3; 2], sides: DVec3) -> Result<GridData, SceneError> {
        let most = f64::from(self.resolution.max(1));
        let cells = (sides / sides.max_element() * most).round().max(DVec3::ONE).min(DVec3::splat(most));
        let [nx, ny, nz] = cells.to_array().map(|n| n as u32);
        let count = nx as usize * ny as usize * nz as usize;
        let mut density = Vec::new();
        if density.try_reserve_exact(count).is_err() {
            let message = format!("not enough memory for {count} cells of clouds");
            return Err(SceneError::new(ErrorCode::TooLarge, message));
        }
        for z in 0..nz {
            for y in 0..ny {
                for x in 0..nx {
                    let center = DVec3::new(f64::from(x), f64::from(y), f64::from(z)) + 0.5;
                    density.push(self.at(from + (to - from) * center / cells) as f32);
                }
            }
        }
        GridData::new([nx, ny, nz], density, None)
            .map_err(|problem| SceneError::new(ErrorCode::OutOfRange, problem))
    }

    /// The density at a point of the clouds' own space.
    fn at(&self, p: DVec3) -> f64 {
        let mut displaced = p * self.frequency;
        if self.wispiness > 0.0 {
            let (mut weight, mut scale) = (0.05 * self.wispiness, 10.0);
            for _ in 0..2 {
                displaced += weight * slope(scale * displaced);
                weight *= 0.5;
                scale *= 1.99;
            }
        }
        let (mut sum, mut weight, mut scale) = (0.0, 0.5, 1.0);
        for _ in 0..5 {
            sum += weight * reference_noise::noise(scale * displaced);
            weight *= 0.5;
            scale *= 1.99;
        }
        let wisps = ((1.0 - p.y) * 4.5 * self.density * sum).clamp(0.0, 1.0);
        (wisps + 2.0 * (0.5 - p.y).max(0.0)).clamp(0.0, 1.0)
    }
}

/// The slope of the noise, by differences over a hundredth.
fn slope(p: DVec3) -> DVec3 {
    const STEP: f64 = 0.01;
    let here = reference_noise::noise(p);
    let along = |axis: DVec3| (reference_noise::noise(p + axis * STEP) - here) / STEP;
    DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clouds_are_dense_below_and_absent_at_the_top() {
        let cloud = CloudMedium { resolution: 40, ..CloudMedium::default() };
        let data = cloud.grid([DVec3::ZERO, DVec3::ONE], DVec3::new(2.0, 1.0, 1.0)).unwrap();
        assert_eq!(data.size(), [40, 20, 20]);
        let at = |y: f64| -> Vec<f64> {
            let place = |i: usize| DVec3::new((i % 20) as f64, 0.0, (i / 20) as f64) / 20.0;
            (0..400).map(|i| cloud.at(place(i) + DVec3::Y * y)).collect()
        };
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
        assert!(at(0.0).iter().all(|d| *d == 1.0) && at(1.0).iter().all(|d| *d == 0.0));
        // Half of the noise is positive.
        let (middle, above) = (at(0.55), at(0.9));
        assert!(mean(&middle) > 0.15 && mean(&middle) < 0.45, "{}", mean(&middle));
        assert!(mean(&above) < mean(&middle) && mean(&above) > 0.0);
        assert!(middle.contains(&0.0), "gaps");
    }

    #[test]
    fn wispiness_displaces_edges_and_density_covers_more() {
        let with = |density, wispiness| CloudMedium { density, wispiness, ..CloudMedium::default() };
        let p = DVec3::new(0.31, 0.7, 0.62);
        assert!(with(1.0, 0.0).at(p) != with(1.0, 1.0).at(p));
        assert_eq!(with(0.0, 1.0).at(p), 0.0);
        let thin = with(0.5, 1.0).at(p);
        assert!((with(1.0, 1.0).at(p) - 2.0 * thin).abs() < 1e-12 || thin == 0.0);
        let flat = CloudMedium { max: DVec3::new(1.0, 0.0, 1.0), ..CloudMedium::default() };
        assert!(flat.prepare().unwrap_err().message.contains("is empty"));
    }
}
