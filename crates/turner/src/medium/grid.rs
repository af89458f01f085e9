//! Media on a grid: smoke and clouds from a file.

use std::sync::Arc;

use super::{Coefficients, Heterogeneous};
use crate::color::Spectrum;
use crate::math::DVec3;
use crate::schema::{ErrorCode, GridFile, Range, SceneError, choice, params};

choice! {
    /// The density in the outer halves of the outermost cells.
    pub enum GridBorder {
        /// That of the cells.
        Extend = "extend",
        /// It falls towards the border, to half there: as if empty cells followed.
        Fade = "fade",
    }
}

params! {
    /// A medium whose density is given on a grid: smoke, clouds, scans. Its file is described in docs/guides/fog-and-smoke.md. The grid fills the box from `min` to
    /// `max`; beyond there is nothing of it. All that a medium does is in proportion to the density of the place.
    pub struct GridMedium as "grid" {
        /// The file, relative to the scene's.
        file: GridFile, required, default GridFile::default();
        /// The corner of the grid's first cell.
        min: DVec3 = DVec3::NEG_ONE;
        /// The opposite corner.
        max: DVec3 = DVec3::ONE;
        /// The density in the outer halves of the outermost cells.
        border: GridBorder = GridBorder::Extend;
        /// A factor of the grid's densities.
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
        /// Radiance that it emits per unit of length at density 1, times the grid's emission where it has one.
        emission: Spectrum = Spectrum::BLACK, in Range::closed(0.0, 1e15);
    }
    // An example needs a file of its own: docs/guides/fog-and-smoke.md has one.
    example ""
}

impl GridMedium {
    /// Makes it ready.
    ///
    /// Errors: a box without an inside, both ways to say the coefficients at once.
    pub fn prepare(&self) -> Result<Heterogeneous, SceneError> {
        let coefficients = Coefficients::new(
            self.density,
            [self.extinction, self.albedo],
            [self.absorption, self.scattering],
            self.anisotropy,
            self.emission,
        )?;
        if !(self.min.cmplt(self.max).all() && (self.max - self.min).is_finite()) {
            let message = format!("the box of the grid, {} to {}, has no inside", self.min, self.max);
            return Err(SceneError::new(ErrorCode::OutOfRange, message)
                .help("`min` must be less than `max` along each axis"));
        }
        let fades = self.border == GridBorder::Fade;
        Heterogeneous::new(coefficients, Arc::clone(&self.file.data), fades, [self.min, self.max])
    }
}
