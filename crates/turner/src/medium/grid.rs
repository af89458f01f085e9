//! Media on a grid: smoke and clouds from a file.

use std::sync::Arc;

use super::{Coefficients, Varying};
use crate::color::Spectrum;
use crate::math::DVec3;
use crate::scene::error::{ErrorCode, SceneError};
use crate::scene::read::ReadContext;
use crate::scene::schema::{ParamType, Range, choice, params, wrong_type};
use crate::scene::value::{Data, Value};
use crate::scene::write::WriteContext;

/// The most values that one channel of a grid may have.
pub const MAX_VALUES: u64 = 1 << 30;

/// Numbers on a grid of cells, x fastest, then y, then z.
#[derive(Clone, Debug, PartialEq)]
pub struct GridData {
    size: [u32; 3],
    density: Vec<f32>,
    emission: Option<Vec<f32>>,
}

impl GridData {
    /// A grid of `size` cells along x, y and z, with a density for each and, where it shines, a factor of the emission.
    ///
    /// Errors: counts that do not fit, numbers that are negative or not finite; in words.
    pub fn new(size: [u32; 3], density: Vec<f32>, emission: Option<Vec<f32>>) -> Result<GridData, String> {
        let count = size.iter().try_fold(1u64, |n, s| n.checked_mul(u64::from(*s)));
        let Some(count) = count.filter(|n| (1..=MAX_VALUES).contains(n)) else {
            let [x, y, z] = size;
            return Err(format!("a grid of {x} × {y} × {z} cells: expected 1 to {MAX_VALUES}"));
        };
        for (what, values) in [("density", Some(&density)), ("emission", emission.as_ref())] {
            let Some(values) = values else { continue };
            if values.len() as u64 != count {
                return Err(format!("{} values of {what} for {count} cells", values.len()));
            }
            // Sums and products of these stay finite.
            if let Some(bad) = values.iter().position(|v| !(0.0..=1e30).contains(v)) {
                let value = values.get(bad).copied().unwrap_or_default();
                return Err(format!("the {what} of cell {bad} is {value}: expected 0 to 1e30"));
            }
        }
        Ok(GridData { size, density, emission })
    }

    /// How many cells there are along x, y and z.
    pub fn size(&self) -> [u32; 3] {
        self.size
    }

    /// The density of each cell, x fastest, then y, then z.
    pub fn density(&self) -> &[f32] {
        &self.density
    }

    /// The factor of the emission of each cell, if there is one.
    pub fn emission(&self) -> Option<&[f32]> {
        self.emission.as_deref()
    }

    /// Bytes of memory.
    pub fn memory(&self) -> usize {
        let floats = self.density.len() + self.emission.as_ref().map_or(0, Vec::len);
        floats * size_of::<f32>()
    }

    /// Density and emission at a place in units of cells, from the grid's corner: trilinear between the middles of cells, and at the rim that of the
    /// cells there. The emission is 1 where the grid has none.
    #[inline]
    pub(super) fn at(&self, p: DVec3) -> [f64; 2] {
        let axis = |v: f64, n: u32| {
            let v = (v - 0.5).clamp(0.0, f64::from(n - 1));
            let low = (v as u32).min(n - 1);
            (low as usize, (low + 1).min(n - 1) as usize, v - f64::from(low))
        };
        let [nx, ny, nz] = self.size;
        let ((x0, x1, fx), (y0, y1, fy), (z0, z1, fz)) = (axis(p.x, nx), axis(p.y, ny), axis(p.z, nz));
        let (nx, ny) = (nx as usize, ny as usize);
        let row = |y: usize, z: usize| nx * (y + ny * z);
        let rows = [row(y0, z0), row(y1, z0), row(y0, z1), row(y1, z1)];
        let of = |values: &[f32]| {
            let value = |i: usize| values.get(i).map_or(0.0, |v| f64::from(*v));
            let along = |r: usize| value(r + x0) * (1.0 - fx) + value(r + x1) * fx;
            let [a, b, c, d] = rows.map(along);
            (a * (1.0 - fy) + b * fy) * (1.0 - fz) + (c * (1.0 - fy) + d * fy) * fz
        };
        [of(&self.density), self.emission.as_deref().map_or(1.0, of)]
    }

    /// What is left of the density at a place in units of cells where empty cells follow beyond the grid: 1 but in the outer halves of the outermost cells.
    #[inline]
    pub(super) fn fade(&self, p: DVec3) -> f64 {
        let along = |v: f64, n: u32| (v + 0.5).min(f64::from(n) - v + 0.5).clamp(0.0, 1.0);
        let [nx, ny, nz] = self.size;
        along(p.x, nx) * along(p.y, ny) * along(p.z, nz)
    }

    /// The largest density within a range of cells, both ends included and cut to the grid.
    pub(super) fn largest(&self, from: [i64; 3], to: [i64; 3]) -> f32 {
        let cut = |v: i64, n: u32| v.clamp(0, i64::from(n) - 1) as usize;
        let [nx, ny, nz] = self.size;
        let mut most = 0.0f32;
        for z in cut(from[2], nz)..=cut(to[2], nz) {
            for y in cut(from[1], ny)..=cut(to[1], ny) {
                let row = nx as usize * (y + ny as usize * z);
                let values = self.density.get(row + cut(from[0], nx)..=row + cut(to[0], nx));
                most = values.unwrap_or_default().iter().copied().fold(most, f32::max);
            }
        }
        most
    }
}

/// A file of a grid that a medium names. Two are the same if they hold the same.
#[derive(Clone, Debug)]
pub struct GridFile {
    /// Its name as written.
    pub uri: String,
    /// What it holds.
    pub data: Arc<GridData>,
}

impl PartialEq for GridFile {
    fn eq(&self, other: &GridFile) -> bool {
        Arc::ptr_eq(&self.data, &other.data) || self.data == other.data
    }
}

impl ParamType for GridFile {
    fn kind() -> String {
        "\"grid file\"".into()
    }
    fn read(value: &Value, cx: &mut ReadContext<'_>) -> Result<GridFile, SceneError> {
        match &value.data {
            Data::String(uri) => Ok(GridFile { uri: uri.clone(), data: cx.grid(uri, value.span)? }),
            _ => Err(wrong_type(value, "the name of a grid file")),
        }
    }
    fn show(&self) -> String {
        "a file".into()
    }
    fn write(&self, cx: &mut WriteContext<'_>) -> Result<Option<Data>, SceneError> {
        cx.grid(self).map(Some)
    }
}

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
    /// A medium whose density is given on a grid: smoke, clouds, scans. Its file is described in docs/volumes.md. The grid fills the box from `min` to
    /// `max`; beyond there is nothing of it. All that a medium does is in proportion to the density of the place.
    pub struct GridMedium as "grid" {
        /// The file, relative to the scene's.
        file: GridFile;
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
    // An example needs a file of its own: docs/volumes.md has one.
    example ""
}

impl GridMedium {
    /// Makes it ready.
    ///
    /// Errors: a box without an inside, both ways to say the coefficients at once.
    pub fn prepare(&self) -> Result<Varying, SceneError> {
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
        Varying::new(coefficients, Arc::clone(&self.file.data), fades, [self.min, self.max])
    }
}
