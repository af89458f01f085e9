//! Procedural smoke and clouds: a ball whose edge is eroded by noise.

use std::sync::Arc;

use super::{Coefficients, Heterogeneous, PhaseFunction};
use crate::color::Spectrum;
use crate::math::DVec3;
use crate::schema::{ErrorCode, GridData, Range, SceneError, params};
use crate::texture::Fractal;

params! {
    /// A puff of smoke or a small cloud: a ball of density 1, eroded by fractal noise. It is evaluated on a grid once,
    /// before rendering.
    pub struct SmokeMedium as "smoke" {
        /// Centre of the ball.
        center: DVec3 = DVec3::ZERO;
        /// Radius in scene units; the density is 0 beyond.
        radius: f64 = 1.0, in Range::POSITIVE;
        /// How far the noise erodes the ball: 0 is a smooth ball, 1 leaves wisps.
        roughness: f64 = 0.6, in Range::UNIT;
        /// Approximate size of the largest billows in scene units; a third of the radius if not given.
        size: Option<f64> = None, in Range::POSITIVE;
        /// Octaves of noise: more add finer detail.
        octaves: u32 = 5, in Range::closed(1.0, 12.0);
        /// Width of the edge as a fraction of the radius.
        softness: f64 = 0.15, in Range::closed(0.001, 1.0);
        /// Seed of the noise: another seed gives another puff.
        seed: u32 = 0;
        /// Cells of the grid along each axis.
        resolution: u32 = 96, in Range::closed(4.0, 512.0);
        /// Factor of the densities.
        density: f64 = 1.0, in Range::closed(0.0, 1e30);
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
    example r##"[medium.puff]
type = "smoke"
extinction = 12
albedo = 0.9
resolution = 32

[[object]]
type = "sphere"
medium = "puff"
"##
}

impl SmokeMedium {
    /// Prepares the medium.
    ///
    /// Errors: both pairs of coefficients at once, out of memory.
    pub fn prepare(&self) -> Result<Heterogeneous, SceneError> {
        let coefficients = Coefficients::new(
            self.density,
            [self.extinction, self.albedo],
            [self.absorption, self.scattering],
            PhaseFunction::new([self.anisotropy, self.second_anisotropy], self.second_weight, self.rayleigh),
            self.emission,
        )?;
        let n = self.resolution.max(1);
        let mut density = Vec::new();
        if density.try_reserve_exact((n as usize).pow(3)).is_err() {
            let message = format!("not enough memory for {n}³ cells of smoke");
            return Err(SceneError::new(ErrorCode::TooLarge, message));
        }
        let noise = Fractal::new(u64::from(self.seed), self.octaves, 2.0, 0.55);
        let billow = self.size.unwrap_or(self.radius / 3.0) / self.radius;
        let cell = 2.0 / f64::from(n);
        let cell_center = |i: u32| (f64::from(i) + 0.5) * cell - 1.0;
        for z in 0..n {
            for y in 0..n {
                for x in 0..n {
                    density.push(self.at(
                        &noise,
                        billow,
                        cell,
                        DVec3::new(cell_center(x), cell_center(y), cell_center(z)),
                    ));
                }
            }
        }
        let data = GridData::new([n; 3], density, None)
            .map_err(|problem| SceneError::new(ErrorCode::OutOfRange, problem))?;
        let half = DVec3::splat(self.radius);
        Heterogeneous::new(coefficients, Arc::new(data), false, [self.center - half, self.center + half])
    }

    /// The density at a point of the unit ball.
    fn at(&self, noise: &Fractal, billow: f64, cell: f64, p: DVec3) -> f32 {
        let r = p.length();
        if r >= 1.0 {
            return 0.0;
        }
        // Noise seldom exceeds ±0.4. It erodes the rim more than the centre.
        let frayed = 2.5 * self.roughness * noise.fbm(p / billow, cell / billow);
        let edge = (1.0 - r) - 0.4 * self.roughness + frayed * (0.3 + 0.7 * r);
        let inside = (edge / self.softness).clamp(0.0, 1.0);
        // The density falls smoothly to 0 at the rim.
        let rim = ((1.0 - r) / 0.08).clamp(0.0, 1.0);
        (inside * inside * (3.0 - 2.0 * inside) * rim) as f32
    }
}
