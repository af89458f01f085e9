//! Media on a grid: smoke and clouds from a file.

use std::sync::Arc;

use super::temperatures::Temperatures;
use super::{Coefficients, Heterogeneous, PhaseFunction};
use crate::color::Spectrum;
use crate::math::DVec3;
use crate::schema::{ErrorCode, GridFile, Range, SceneError, choice, params};

choice! {
    /// The density in the outer half of the border cells.
    pub enum GridBorder {
        /// The density of the cell.
        Extend = "extend",
        /// Falls linearly to half at the border, as if empty cells followed.
        Fade = "fade",
    }
}

params! {
    /// A medium whose density comes from a grid file: smoke, clouds, scans. The file is OpenVDB (`.vdb`), NanoVDB
    /// (`.nvdb`) or of the kind that docs/guides/fog-and-smoke.md describes. The grid fills the box from `min` to `max`;
    /// outside it the medium is empty. All coefficients are multiplied by the local density.
    pub struct GridMedium as "grid" {
        /// Path of the file, relative to the scene file. `smoke.vdb#flames` is the grid `flames` of an OpenVDB or
        /// NanoVDB file; without a name it is `density` or the only grid of floats.
        file: GridFile, required, default GridFile::default();
        /// Corner of the grid's first cell, in scene units. If not given, where the file places it; (-1, -1, -1) if it
        /// does not.
        min: Option<DVec3> = None;
        /// The opposite corner; (1, 1, 1) if neither it nor the file gives one.
        max: Option<DVec3> = None;
        /// The density in the outer half of the border cells.
        border: GridBorder = GridBorder::Extend;
        /// Factor of the grid's densities.
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
        /// Emitted radiance per scene unit at density 1, times the grid's emission if the file has one, and times the
        /// colour of its `temperature` if that is given.
        emission: Spectrum = Spectrum::BLACK, in Range::closed(0.0, 1e15);
        /// A grid of temperatures in the same box, or where its file places it beside the densities: `emission` then has
        /// the colour of a black body, whose greatest spectral value is 1. Fire and explosions:
        /// `temperature = "fire.vdb#temperature"`.
        temperature: Option<GridFile> = None;
        /// Kelvin per unit of `temperature`.
        temperature_scale: f64 = 1.0, in Range::closed(0.0, 1e9);
        /// The value of `temperature` at 0 K.
        temperature_offset: f64 = 0.0, in Range::closed(-1e9, 1e9);
    }
    // An example needs a file of its own: docs/guides/fog-and-smoke.md has one.
    example ""
}

impl GridMedium {
    /// Prepares the medium.
    ///
    /// Errors: an empty box, both pairs of coefficients at once, signed distances instead of densities.
    pub fn prepare(&self) -> Result<Heterogeneous, SceneError> {
        let coefficients = Coefficients::new(
            self.density,
            [self.extinction, self.albedo],
            [self.absorption, self.scattering],
            PhaseFunction::new([self.anisotropy, self.second_anisotropy], self.second_weight, self.rayleigh),
            self.emission,
        )?;
        if self.file.data.has_distances() {
            let message = "the grid is a level set, distances to a surface: expected densities";
            return Err(SceneError::new(ErrorCode::Volume, message)
                .help("an object of `type = \"distance_grid\"` has this surface"));
        }
        let [min, max] = self.bounds();
        if !(min.cmplt(max).all() && (max - min).is_finite()) {
            let message = format!("the box of the grid, {min} to {max}, is empty");
            return Err(SceneError::new(ErrorCode::OutOfRange, message)
                .help("`min` must be less than `max` along each axis"));
        }
        let fades = self.border == GridBorder::Fade;
        let medium = Heterogeneous::new(coefficients, Arc::clone(&self.file.data), fades, [min, max])?;
        Ok(medium.with_temperatures(self.temperatures([min, max])?))
    }

    /// The temperatures of a medium in a box.
    fn temperatures(&self, medium: [DVec3; 2]) -> Result<Option<Temperatures>, SceneError> {
        let Some(GridFile { data, .. }) = &self.temperature else { return Ok(None) };
        if data.has_distances() {
            let message = "the grid of temperatures is a level set, distances to a surface";
            return Err(SceneError::new(ErrorCode::Volume, message));
        }
        // Files that place both grids place them in one space, of which the medium's box may be another part.
        let bounds = match (data.bounds(), self.file.data.bounds()) {
            (None, _) => medium,
            (Some(own), None) => own,
            (Some(own), Some([min, max])) => {
                let scale = (medium[1] - medium[0]) / (max - min);
                own.map(|p| medium[0] + (p - min) * scale)
            }
        };
        Ok(Some(Temperatures::new(data, bounds, self.temperature_offset, self.temperature_scale)))
    }

    /// The box that the grid fills: `min` and `max`, or that of the file.
    pub fn bounds(&self) -> [DVec3; 2] {
        let [min, max] = self.file.data.bounds().unwrap_or([DVec3::NEG_ONE, DVec3::ONE]);
        [self.min.unwrap_or(min), self.max.unwrap_or(max)]
    }
}
