//! Grids of densities or signed distances, as read from files.

use std::sync::Arc;

use crate::math::DVec3;
use crate::schema::value::{Data, Value};
use crate::schema::{ParamType, ReadContext, SceneError, WriteContext, wrong_type};

/// Maximum number of values of one channel.
pub const MAX_VALUES: u64 = 1 << 30;

/// What is scattered in each cell of a grid, by colour.
#[derive(Clone, Debug, PartialEq)]
pub enum GridScattering {
    /// A factor of the single-scattering albedo, 0 to 1.
    Albedo(Vec<[f32; 3]>),
    /// A factor of the scattering coefficient; at most the extinction of the cell.
    Coefficient(Vec<[f32; 3]>),
}

impl GridScattering {
    /// The values, x fastest, then y, then z.
    pub fn values(&self) -> &[[f32; 3]] {
        match self {
            GridScattering::Albedo(values) | GridScattering::Coefficient(values) => values,
        }
    }
}

/// Values on a grid of cells, x fastest, then y, then z.
#[derive(Clone, Debug, PartialEq)]
pub struct GridData {
    size: [u32; 3],
    density: Vec<f32>,
    emission: Option<Vec<f32>>,
    extinction: Option<Vec<[f32; 3]>>,
    scattering: Option<GridScattering>,
    bounds: Option<[DVec3; 2]>,
    /// Whether the densities are signed distances.
    has_distances: bool,
}

impl GridData {
    /// A grid of `size` cells along x, y and z, with a density for each cell and optionally a factor of the emission.
    ///
    /// Errors: lists whose length differs from the number of cells, values that are negative or not finite.
    pub fn new(size: [u32; 3], density: Vec<f32>, emission: Option<Vec<f32>>) -> Result<GridData, String> {
        let count = count_of(size)?;
        for (what, values) in [("density", Some(&density)), ("emission", emission.as_ref())] {
            let Some(values) = values else { continue };
            if values.len() as u64 != count {
                return Err(format!("{} values of {what} for {count} cells", values.len()));
            }
            // The upper bound keeps sums and products finite.
            if let Some(bad) = values.iter().position(|v| !(0.0..=1e30).contains(v)) {
                let value = values.get(bad).copied().unwrap_or_default();
                return Err(format!("the {what} of cell {bad} is {value}: expected 0 to 1e30"));
            }
        }
        Ok(GridData { size, density, emission, ..GridData::default() })
    }

    /// A grid of `size` signed distances along x, y and z, negative inside a surface. The first and the last ones lie on
    /// the faces of its box.
    ///
    /// Errors: a list whose length differs from the number of values, values that are not finite.
    pub fn of_distances(size: [u32; 3], distances: Vec<f32>) -> Result<GridData, String> {
        let count = count_of(size)?;
        if distances.len() as u64 != count {
            return Err(format!("{} distances for {count} vertices", distances.len()));
        }
        if let Some(bad) = distances.iter().position(|v| !(-1e30..=1e30).contains(v)) {
            let value = distances.get(bad).copied().unwrap_or_default();
            return Err(format!("the distance {bad} is {value}: expected -1e30 to 1e30"));
        }
        Ok(GridData { size, density: distances, has_distances: true, ..GridData::default() })
    }

    /// A grid of `size` cells along x, y and z, with an extinction for each cell and colour and optionally a factor of the
    /// emission. The density is the greatest of the three.
    ///
    /// Errors: lists whose length differs from the number of cells, values that are negative or not finite.
    pub fn of_extinction(
        size: [u32; 3],
        extinction: Vec<[f32; 3]>,
        emission: Option<Vec<f32>>,
    ) -> Result<GridData, String> {
        let density = extinction.iter().map(|[r, g, b]| r.max(*g).max(*b)).collect();
        // Greatest values do not show NaN and negative ones.
        if let Some(cell) = extinction.iter().position(|c| c.iter().any(|v| !(0.0..=1e30).contains(v))) {
            let value = extinction.get(cell).copied().unwrap_or_default();
            return Err(format!("the extinction of cell {cell} is {value:?}: expected 0 to 1e30"));
        }
        Ok(GridData { extinction: Some(extinction), ..GridData::new(size, density, emission)? })
    }

    /// The same grid with an extinction for each cell and colour. The density becomes the greatest of the three.
    ///
    /// Errors: a list whose length differs from the number of cells, values that are negative or not finite.
    pub fn with_extinction(self, extinction: Vec<[f32; 3]>) -> Result<GridData, String> {
        let made = GridData::of_extinction(self.size, extinction, self.emission)?;
        Ok(GridData { scattering: self.scattering, bounds: self.bounds, ..made })
    }

    /// The same grid with what each cell scatters, after [`GridData::with_extinction`] if both are given.
    ///
    /// Errors: a list whose length differs from the number of cells, albedos outside of 0 to 1, a cell that scatters
    /// more than its extinction.
    pub fn with_scattering(mut self, scattering: GridScattering) -> Result<GridData, String> {
        let values = scattering.values();
        if values.len() != self.density.len() {
            return Err(format!("{} values of scattering for {} cells", values.len(), self.density.len()));
        }
        for (i, value) in values.iter().enumerate() {
            let most = match scattering {
                GridScattering::Albedo(_) => [1.0; 3],
                GridScattering::Coefficient(_) => self.extinction_of(i),
            };
            if !value.iter().zip(most).all(|(v, most)| (0.0..=most).contains(v)) {
                return Err(format!("cell {i} scatters {value:?}: expected 0 to {most:?}"));
            }
        }
        self.scattering = Some(scattering);
        Ok(self)
    }

    /// The same grid in a box of space, from its smallest to its largest coordinates.
    ///
    /// Errors: an empty box, coordinates that are not finite.
    pub fn with_bounds(mut self, [min, max]: [DVec3; 2]) -> Result<GridData, String> {
        if !(min.cmplt(max).all() && min.is_finite() && max.is_finite()) {
            return Err(format!("the box of the grid, {min} to {max}, is empty"));
        }
        self.bounds = Some([min, max]);
        Ok(self)
    }

    /// The box that the file places the grid in, if it does: cells fill it, distances have the first and the last
    /// vertices on its faces.
    pub fn bounds(&self) -> Option<[DVec3; 2]> {
        self.bounds
    }

    /// The box between the first and the last values, if the file places the grid. Those of cells are at their centres.
    pub fn vertex_bounds(&self) -> Option<[DVec3; 2]> {
        let [min, max] = self.bounds?;
        let half = if self.has_distances { 0.0 } else { 0.5 };
        let margin = half * (max - min) / DVec3::from(self.size.map(f64::from));
        Some([min + margin, max - margin])
    }

    /// Whether the values are signed distances instead of densities.
    pub fn has_distances(&self) -> bool {
        self.has_distances
    }

    /// The number of cells along x, y and z.
    pub fn size(&self) -> [u32; 3] {
        self.size
    }

    /// The density of each cell, or the distances; x fastest, then y, then z.
    pub fn density(&self) -> &[f32] {
        &self.density
    }

    /// The factor of the emission of each cell, if the grid has one.
    pub fn emission(&self) -> Option<&[f32]> {
        self.emission.as_deref()
    }

    /// The extinction of each cell by colour, if it differs from the density.
    pub fn extinction(&self) -> Option<&[[f32; 3]]> {
        self.extinction.as_deref()
    }

    /// What each cell scatters by colour, if the grid says so.
    pub fn scattering(&self) -> Option<&GridScattering> {
        self.scattering.as_ref()
    }

    fn extinction_of(&self, cell: usize) -> [f32; 3] {
        let colors = self.extinction.as_ref().and_then(|e| e.get(cell)).copied();
        colors.unwrap_or_else(|| [self.density.get(cell).copied().unwrap_or_default(); 3])
    }

    /// Memory in bytes.
    pub fn memory(&self) -> usize {
        let floats = self.density.len() + self.emission.as_ref().map_or(0, Vec::len);
        let colors = self.extinction.as_ref().map_or(0, Vec::len)
            + self.scattering.as_ref().map_or(0, |s| s.values().len());
        (floats + 3 * colors) * size_of::<f32>()
    }

    /// Density and emission factor at `p`, in units of cells from the grid's corner: trilinear interpolation between
    /// the centres of cells, constant beyond the outermost centres. Without emission the factor is 1.
    #[inline]
    pub(crate) fn at(&self, p: DVec3) -> [f64; 2] {
        let place = self.place(p);
        let of = |values: &[f32]| place.of(|i| values.get(i).map_or(0.0, |v| f64::from(*v)));
        [of(&self.density), self.emission.as_deref().map_or(1.0, of)]
    }

    /// Whether extinction or scattering differ by colour.
    pub(crate) fn has_colors(&self) -> bool {
        self.extinction.is_some() || self.scattering.is_some()
    }

    /// Factors of the extinction and the scattering coefficient at `p`, in units of cells, by colour.
    pub(crate) fn colors_at(&self, p: DVec3) -> [[f64; 3]; 2] {
        let place = self.place(p);
        let colors = |values: &[[f32; 3]]| {
            [0, 1, 2].map(|band| place.of(|i| values.get(i).map_or(0.0, |v| f64::from(v[band]))))
        };
        let extinction = match &self.extinction {
            Some(values) => colors(values),
            None => [place.of(|i| self.density.get(i).map_or(0.0, |v| f64::from(*v))); 3],
        };
        let scattering = match &self.scattering {
            None => extinction,
            Some(GridScattering::Coefficient(values)) => colors(values),
            Some(GridScattering::Albedo(values)) => {
                let albedo = colors(values);
                [0, 1, 2].map(|band| extinction[band] * albedo[band])
            }
        };
        [extinction, scattering]
    }

    /// Where `p`, in units of cells, lies among the centres of cells.
    #[inline]
    fn place(&self, p: DVec3) -> Place {
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
        Place { rows, columns: [x0, x1], fractions: [fx, fy, fz] }
    }

    /// The factor of the density at `p`, in units of cells, if empty cells surround the grid: 1 inside, less in the
    /// outer halves of the outermost cells.
    #[inline]
    pub(crate) fn fade(&self, p: DVec3) -> f64 {
        let along = |v: f64, n: u32| (v + 0.5).min(f64::from(n) - v + 0.5).clamp(0.0, 1.0);
        let [nx, ny, nz] = self.size;
        along(p.x, nx) * along(p.y, ny) * along(p.z, nz)
    }

    /// The largest density within a range of cells, both ends included and clamped to the grid.
    pub(crate) fn largest(&self, from: [i64; 3], to: [i64; 3]) -> f32 {
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

/// The number of values.
///
/// Errors: none or too many.
fn count_of(size: [u32; 3]) -> Result<u64, String> {
    let count = size.iter().try_fold(1u64, |n, s| n.checked_mul(u64::from(*s)));
    count.filter(|n| (1..=MAX_VALUES).contains(n)).ok_or_else(|| {
        let [x, y, z] = size;
        format!("a grid of {x} × {y} × {z} cells: expected 1 to {MAX_VALUES}")
    })
}

/// Eight cells around a point, and the fractions of the way between them.
struct Place {
    /// The first cells of four rows: two along y, two along z.
    rows: [usize; 4],
    columns: [usize; 2],
    fractions: [f64; 3],
}

impl Place {
    /// Trilinear interpolation between the values of cells.
    #[inline]
    fn of(&self, value: impl Fn(usize) -> f64) -> f64 {
        let ([x0, x1], [fx, fy, fz]) = (self.columns, self.fractions);
        let along = |r: usize| value(r + x0) * (1.0 - fx) + value(r + x1) * fx;
        let [a, b, c, d] = self.rows.map(along);
        (a * (1.0 - fy) + b * fy) * (1.0 - fz) + (c * (1.0 - fy) + d * fy) * fz
    }
}

impl Default for GridData {
    /// One cell of density 1.
    fn default() -> GridData {
        GridData {
            size: [1; 3],
            density: vec![1.0],
            emission: None,
            extinction: None,
            scattering: None,
            bounds: None,
            has_distances: false,
        }
    }
}

/// The grid file of a medium or a shape. Two are equal if their data are equal. By default one cell of density 1, without a file.
#[derive(Clone, Debug, Default)]
pub struct GridFile {
    /// The file name as written in the scene.
    pub uri: String,
    /// Its data.
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
    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<GridFile, SceneError> {
        match &value.data {
            Data::String(uri) => Ok(GridFile { uri: uri.clone(), data: cx.grid(uri, value.span)? }),
            _ => Err(wrong_type(value, "the name of a grid file")),
        }
    }
    fn show(&self) -> String {
        "a file".into()
    }
    fn write(&self, cx: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        cx.grid(self).map(Some)
    }
}
