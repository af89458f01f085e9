//! Smoke and clouds out of nothing but numbers: a ball whose edge noise frays.

use std::sync::Arc;

use super::{Coefficients, Heterogeneous};
use crate::color::Spectrum;
use crate::math::DVec3;
use crate::schema::{ErrorCode, GridData, Range, SceneError, params};
use crate::texture::Fractal;

params! {
    /// A puff of smoke, or a small cloud: a ball of density 1 inside, into which noise eats. It is laid out on a grid once, before rendering.
    pub struct SmokeMedium as "smoke" {
        /// The middle.
        center: DVec3 = DVec3::ZERO;
        /// Where it ends.
        radius: f64 = 1.0, in Range::POSITIVE;
        /// How far the noise eats into the ball: 0 is a ball, 1 leaves wisps.
        roughness: f64 = 0.6, in Range::UNIT;
        /// About how large the largest billows are, in scene units; a third of the radius if not given.
        size: Option<f64> = None, in Range::POSITIVE;
        /// How much detail: octaves of noise.
        octaves: u32 = 5, in Range::closed(1.0, 12.0);
        /// How wide the edge is, in radii.
        softness: f64 = 0.15, in Range::closed(0.001, 1.0);
        /// Another number, another puff.
        seed: u32 = 0;
        /// Cells of the grid along each axis.
        resolution: u32 = 96, in Range::closed(4.0, 512.0);
        /// A factor of the densities.
        density: f64 = 1.0, in Range::closed(0.0, 1e30);
        /// What is lost per unit of length at density 1. 1 if nothing else says it.
        extinction: Option<Spectrum> = None, in Range::closed(0.0, 1e30);
        /// The share of that which is scattered, not absorbed.
        albedo: Option<Spectrum> = None, in Range::UNIT;
        /// In place of `extinction` and `albedo`: what is absorbed per unit of length at density 1.
        absorption: Option<Spectrum> = None, in Range::closed(0.0, 1e30);
        /// In place of `extinction` and `albedo`: what is scattered per unit of length at density 1.
        scattering: Option<Spectrum> = None, in Range::closed(0.0, 1e30);
        /// The mean cosine g of Henyey and Greenstein's phase function.
        anisotropy: f64 = 0.0, in Range::closed(-0.999, 0.999);
        /// Radiance that it emits per unit of length at density 1.
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
    /// Makes it ready.
    ///
    /// Errors: both ways to say the coefficients at once, no memory.
    pub fn prepare(&self) -> Result<Heterogeneous, SceneError> {
        let coefficients = Coefficients::new(
            self.density,
            [self.extinction, self.albedo],
            [self.absorption, self.scattering],
            self.anisotropy,
            self.emission,
        )?;
        let n = self.resolution.max(1);
        let mut density = Vec::new();
        if density.try_reserve_exact((n as usize).pow(3)).is_err() {
            let message = format!("there is no memory for {n}³ cells of smoke");
            return Err(SceneError::new(ErrorCode::TooLarge, message));
        }
        let noise = Fractal::new(u64::from(self.seed), self.octaves, 2.0, 0.55);
        let billow = self.size.unwrap_or(self.radius / 3.0) / self.radius;
        let cell = 2.0 / f64::from(n);
        let middle = |i: u32| (f64::from(i) + 0.5) * cell - 1.0;
        for z in 0..n {
            for y in 0..n {
                for x in 0..n {
                    density.push(self.at(&noise, billow, cell, DVec3::new(middle(x), middle(y), middle(z))));
                }
            }
        }
        let data = GridData::new([n; 3], density, None)
            .map_err(|problem| SceneError::new(ErrorCode::OutOfRange, problem))?;
        let half = DVec3::splat(self.radius);
        Heterogeneous::new(coefficients, Arc::new(data), false, [self.center - half, self.center + half])
    }

    /// The density at a place of the unit ball.
    fn at(&self, noise: &Fractal, billow: f64, cell: f64, p: DVec3) -> f32 {
        let r = p.length();
        if r >= 1.0 {
            return 0.0;
        }
        // Noise is seldom beyond ±0.4; what it takes from the middle is less than from the rim.
        let frayed = 2.5 * self.roughness * noise.fbm(p / billow, cell / billow);
        let edge = (1.0 - r) - 0.4 * self.roughness + frayed * (0.3 + 0.7 * r);
        let inside = (edge / self.softness).clamp(0.0, 1.0);
        // Nothing is cut off at the rim.
        let rim = ((1.0 - r) / 0.08).clamp(0.0, 1.0);
        (inside * inside * (3.0 - 2.0 * inside) * rim) as f32
    }
}
