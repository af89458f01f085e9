//! Importance sampling of an environment map: directions are sampled in proportion to luminance.
//!
//! The estimator radiance / pdf has little noise if the pdf is close to proportional to the radiance. The pdf per
//! solid angle is constant over each pixel, proportional to the mean luminance of the bilinear look-up there. It is
//! therefore above 0 wherever light comes from, which keeps the estimator
//! unbiased. Within a pixel directions are uniform per solid angle.
//!
//! Sampling inverts two distribution functions (pbrt, "Sampling Light Sources: Image Infinite Area Lights"): the
//! second random number chooses a row by its total luminance and solid angle, the first a column in that row.
//!
//! ```text
//!    rows            columns of row y
//!   |----| u[1]     0                       UNITS
//!   |    |          |---|--|--------|--|------|
//!   |----|<-- y     +   u[0] · UNITS  ^
//!   |    |
//! ```
//!
//! Inversion keeps stratification: well-distributed points in the unit square give well-distributed directions. Guide
//! tables hold where the search of each equal interval begins, so that a binary search covers few entries.

use std::collections::TryReserveError;
use std::f64::consts::{PI, TAU};

use super::map::{EnvironmentMap, coordinates_fast, direction_at, height, solid_angles};
use crate::math::elementary::cos;
use crate::math::{DVec2, DVec3};
use crate::schema::{ErrorCode, SceneError};

/// The columns of a row divide this many units.
const UNITS: u32 = u32::MAX;

/// A density over directions, constant over each pixel.
#[derive(Debug)]
pub(super) struct Distribution {
    width: u32,
    height: u32,
    /// Start of each row in 0..=1, and the end of the last; empty if the image is black.
    rows: Vec<f64>,
    /// Start of each column in units, row by row; the last column ends at [`UNITS`].
    columns: Vec<u32>,
    /// Cosine of the angle from the zenith at the upper edge of each row, and at the end.
    edges: Vec<f64>,
    /// Density per unit of each row, per solid angle.
    densities: Vec<f64>,
    /// Guide table: the row in which each of a power of two of equal intervals of 0..=1 begins, and the last row.
    row_guide: Vec<u32>,
    /// The same for the columns of each row, whose guide divides [`UNITS`] + 1.
    column_guide: Vec<u32>,
    /// log2 of the intervals in a column guide.
    guide_bits: u32,
}

impl Distribution {
    /// From the luminance of an image. With `compensated`, the mean over all directions is subtracted first (Karlík
    /// et al. 2019, "MIS Compensation"), which is valid only with the balance heuristic. A constant image is then
    /// sampled uniformly.
    pub(super) fn new(map: &EnvironmentMap, compensated: bool) -> Result<Distribution, SceneError> {
        let (width, height) = map.size();
        let solid_angles: Vec<f64> = solid_angles(width, height).collect();
        let total = luminance(map.integral());
        let mut distribution = Distribution {
            width,
            height,
            rows: Vec::new(),
            columns: Vec::new(),
            edges: (0..=height).map(|y| cos(PI * f64::from(y) / f64::from(height))).collect(),
            densities: Vec::new(),
            row_guide: Vec::new(),
            column_guide: Vec::new(),
            guide_bits: (width / 4).max(1).ilog2(),
        };
        if total <= 0.0 {
            return Ok(distribution);
        }
        let cells = width as usize * height as usize;
        distribution.columns.try_reserve_exact(cells).map_err(|_| no_memory(width, height))?;
        let floor = if compensated { total / (2.0 * TAU) } else { 0.0 };
        let mut sums = distribution.fill(map, &solid_angles, floor);
        if sums.iter().sum::<f64>() <= 0.0 {
            // No pixel is above the mean.
            sums = distribution.fill(map, &solid_angles, 0.0);
        }
        let (mut begin, total) = (0.0, sums.iter().sum::<f64>());
        distribution.rows = Vec::with_capacity(sums.len() + 1);
        for sum in sums {
            distribution.rows.push((begin / total).min(1.0));
            begin += sum;
        }
        distribution.rows.push(1.0);
        distribution.guide().map_err(|_| no_memory(width, height))?;
        Ok(distribution)
    }

    /// Computes the densities and guide tables.
    fn guide(&mut self) -> Result<(), TryReserveError> {
        let width = f64::from(self.width);
        self.densities = (self.rows.windows(2).zip(self.edges.windows(2)))
            .map(|(row, edge)| (row[1] - row[0]) / f64::from(UNITS) / (TAU / width * (edge[0] - edge[1])))
            .collect();
        let parts = self.height.next_power_of_two();
        let last = self.height - 1;
        let found = |v: f64| (self.rows.partition_point(|begin| *begin <= v).max(1) as u32 - 1).min(last);
        self.row_guide = (0..parts).map(|k| found(f64::from(k) / f64::from(parts))).chain([last]).collect();
        let parts = 1u32 << self.guide_bits;
        let size = self.height as usize * (parts as usize + 1);
        self.column_guide.try_reserve_exact(size)?;
        for row in self.columns.chunks_exact(self.width as usize) {
            let mut x = 0;
            for k in 0..parts {
                let unit = (u64::from(k) << 32 >> self.guide_bits) as u32;
                while row.get(x + 1).is_some_and(|begin| *begin <= unit) {
                    x += 1;
                }
                self.column_guide.push(x as u32);
            }
            self.column_guide.push(self.width - 1);
        }
        Ok(())
    }

    /// Writes the columns of every row; returns the luminance of each row above `floor`, times solid angle.
    fn fill(&mut self, map: &EnvironmentMap, solid_angles: &[f64], floor: f64) -> Vec<f64> {
        self.columns.clear();
        let mut smoothed = Smoothed::new(map);
        let mut weights = vec![0.0; self.width as usize];
        (0..self.height)
            .zip(solid_angles)
            .map(|(y, solid_angle)| {
                smoothed.row(y, &mut weights);
                weights.iter_mut().for_each(|w| *w = (*w - floor).max(0.0));
                self.push_row(&weights);
                weights.iter().sum::<f64>() * solid_angle
            })
            .collect()
    }

    /// Divides a row's units among its columns in proportion to their weights; each non-zero weight gets at least one
    /// unit.
    fn push_row(&mut self, weights: &[f64]) {
        let sum: f64 = weights.iter().sum();
        let some = weights.iter().filter(|w| **w > 0.0).count() as u32;
        let last = weights.iter().rposition(|w| *w > 0.0);
        let mut begin = 0_u32;
        for (x, weight) in weights.iter().enumerate() {
            self.columns.push(begin);
            if Some(x) == last {
                begin = UNITS;
            } else if *weight > 0.0 {
                let units = (weight / sum * f64::from(UNITS - some)) as u32 + 1;
                begin = begin.saturating_add(units);
            }
        }
    }

    /// A direction for two uniform numbers in 0..1, its (u, v) in the image and its pdf per solid angle; `None` if
    /// the image is black.
    pub(super) fn sample(&self, u: [f64; 2]) -> Option<(DVec3, DVec2, f64)> {
        let (u, cos_theta, pdf) = self.find(u)?;
        let sin_theta = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
        let uv = DVec2::new(u, height(sin_theta, cos_theta));
        (pdf > 0.0).then(|| (direction_at(u, sin_theta, cos_theta), uv, pdf))
    }

    /// The same as u in the image and the cosine of the angle from the zenith; the pdf may be 0.
    #[inline]
    pub(super) fn find(&self, u: [f64; 2]) -> Option<(f64, f64, f64)> {
        let row = self.row_of(u)?;
        self.position(&row, self.span(&row)?)
    }

    /// The row, from the second number. `row_of`, `span` and `position` make up [`Distribution::find`]. They are
    /// separate so that a loop over a batch does little but read large tables, and the cache misses overlap.
    #[inline]
    pub(super) fn row_of(&self, u: [f64; 2]) -> Option<Row> {
        let [u, v] = u.map(|u| if u > 0.0 { u.min(1.0 - f64::EPSILON) } else { 0.0 });
        let parts = self.row_guide.len().checked_sub(1)?;
        let y = search(&self.row_guide, (v * parts as f64) as usize, &self.rows, |begin| *begin <= v)?;
        let (begin, end) = (self.rows[y], self.rows[y + 1]);
        let down = ((v - begin) / (end - begin)).clamp(0.0, 1.0);
        Some(Row { y, down, unit: u * f64::from(UNITS) })
    }

    /// Whether no direction has a density above 0.
    pub(super) fn is_black(&self) -> bool {
        self.rows.is_empty()
    }

    /// Width and height in pixels.
    pub(super) fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// The units of a row between two columns; the second may be the end of the row.
    #[inline]
    fn units(&self, y: u32, columns: [u32; 2]) -> [u32; 2] {
        let row = self.row(y as usize);
        columns.map(|x| row.get(x as usize).copied().unwrap_or(UNITS))
    }

    /// The probability of the pixels of a row between two columns.
    pub(super) fn probability(&self, y: u32, columns: [u32; 2]) -> f64 {
        let Some([begin, end]) = self.rows.get(y as usize..y as usize + 2) else { return 0.0 };
        let [first, last] = self.units(y, columns);
        (end - begin) * (f64::from(last - first) / f64::from(UNITS))
    }

    /// A position in a row, with `u` in 0..1 between two columns.
    #[inline]
    pub(super) fn row_between(&self, y: u32, down: f64, columns: [u32; 2], u: f64) -> Row {
        let [first, last] = self.units(y, columns);
        let unit = f64::from(first) + u.min(1.0 - f64::EPSILON) * f64::from(last - first);
        Row { y: y as usize, down, unit }
    }

    /// The first and last candidate column.
    #[inline]
    pub(super) fn span(&self, row: &Row) -> Option<[u32; 2]> {
        let part = (u64::from(row.unit as u32) << self.guide_bits >> 32) as usize;
        let first = row.y * ((1 << self.guide_bits) + 1) + part;
        Some([*self.column_guide.get(first)?, *self.column_guide.get(first + 1)?])
    }

    /// Prefetches one column of each entry, for the search that follows; the sum only keeps the reads alive.
    #[inline]
    pub(super) fn prefetch(&self, rows: &[Option<(Row, [u32; 2])>]) -> u32 {
        let mut sum = 0_u32;
        for (row, [first, _]) in rows.iter().flatten() {
            let at = row.y * self.width as usize + *first as usize;
            sum = sum.wrapping_add(self.columns.get(at).copied().unwrap_or_default());
        }
        sum
    }

    /// The column: u, the cosine of the angle from the zenith, and the pdf.
    #[inline]
    pub(super) fn position(
        &self,
        &Row { y, down, unit }: &Row,
        [first, last]: [u32; 2],
    ) -> Option<(f64, f64, f64)> {
        // Columns begin at integers, so the integer part decides.
        let integer = unit as u32;
        let row = self.row(y);
        let begins = row.get(first as usize + 1..=last as usize)?;
        let x = first as usize + begins.partition_point(|begin| *begin <= integer);
        let (first, units) = column(row, x);
        let across = ((unit - f64::from(first)) / f64::from(units)).clamp(0.0, 1.0);
        let cos_theta = self.edges[y] + (self.edges[y + 1] - self.edges[y]) * down;
        Some(((x as f64 + across) / f64::from(self.width), cos_theta, self.density(x, y)))
    }

    /// Prefetches what [`Distribution::pdf_at`] reads, for many positions; the sum only keeps the reads alive.
    #[inline]
    pub(super) fn prefetch_at(&self, entries: impl Iterator<Item = DVec2>) -> u32 {
        let cell = |v: f64, n: u32| ((v * f64::from(n)) as u32).min(n - 1) as usize;
        let mut sum = 0_u32;
        for uv in entries {
            let at = cell(uv.y, self.height) * self.width as usize + cell(uv.x, self.width);
            sum = sum.wrapping_add(self.columns.get(at).copied().unwrap_or_default());
        }
        sum
    }

    /// The pdf of a direction of any length, per solid angle.
    pub(super) fn pdf(&self, direction: DVec3) -> f64 {
        self.pdf_at(coordinates_fast(direction))
    }

    /// The same at (u, v) in 0..=1 of the image.
    #[inline]
    pub(super) fn pdf_at(&self, uv: DVec2) -> f64 {
        let cell = |v: f64, n: u32| ((v * f64::from(n)) as u32).min(n - 1) as usize;
        self.density(cell(uv.x, self.width), cell(uv.y, self.height))
    }

    fn density(&self, x: usize, y: usize) -> f64 {
        self.densities.get(y).map_or(0.0, |density| density * f64::from(column(self.row(y), x).1))
    }

    fn row(&self, y: usize) -> &[u32] {
        &self.columns[y * self.width as usize..][..self.width as usize]
    }

    /// Memory of the tables, in bytes.
    pub(super) fn memory(&self) -> usize {
        let guides = size_of_val(&*self.row_guide) + size_of_val(&*self.column_guide);
        let rows = size_of_val(&*self.rows) + size_of_val(&*self.edges) + size_of_val(&*self.densities);
        rows + guides + size_of_val(&*self.columns)
    }
}

/// A sampled row, the fraction of its height, and the position along it in units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    y: usize,
    down: f64,
    unit: f64,
}

/// Index of the last entry that satisfies `begins`, searched between two entries of a guide table. `begins` holds for
/// a prefix of `entries`.
#[inline]
fn search<T>(guide: &[u32], part: usize, entries: &[T], begins: impl Fn(&T) -> bool) -> Option<usize> {
    let (first, last) = (*guide.get(part)? as usize, *guide.get(part + 1)? as usize);
    Some(first + entries.get(first + 1..=last)?.partition_point(begins))
}

fn no_memory(width: u32, height: u32) -> SceneError {
    let message = format!("not enough memory to sample an environment map of {width}x{height} pixels");
    SceneError::new(ErrorCode::TooLarge, message).help("scale the image down")
}

/// Start and size of a column, in units.
fn column(row: &[u32], x: usize) -> (u32, u32) {
    let end = row.get(x + 1).copied().unwrap_or(UNITS);
    (row[x], end - row[x])
}

fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// The mean luminance of the bilinear look-up over each pixel: an eighth of each neighbour, along rows and columns.
struct Smoothed<'a> {
    map: &'a EnvironmentMap,
    /// Luminances of the previous, current and next row, already smoothed along the row.
    near: [Vec<f64>; 3],
    at: Option<u32>,
}

impl<'a> Smoothed<'a> {
    fn new(map: &'a EnvironmentMap) -> Smoothed<'a> {
        let empty = || vec![0.0; map.size().0 as usize];
        Smoothed { map, near: [empty(), empty(), empty()], at: None }
    }

    /// The means of row `y`. Rows are requested in order.
    fn row(&mut self, y: u32, out: &mut [f64]) {
        let last = self.map.size().1 - 1;
        if self.at.is_some_and(|at| at + 1 == y) {
            self.near.rotate_left(1);
        } else {
            smooth_row(self.map, y.saturating_sub(1), &mut self.near[0]);
            smooth_row(self.map, y, &mut self.near[1]);
        }
        smooth_row(self.map, (y + 1).min(last), &mut self.near[2]);
        self.at = Some(y);
        let [before, here, after] = &self.near;
        for (x, out) in out.iter_mut().enumerate() {
            *out = 0.125 * (before[x] + after[x]) + 0.75 * here[x];
        }
    }
}

/// Luminances of a row, smoothed along it with wrap-around.
fn smooth_row(map: &EnvironmentMap, y: u32, out: &mut [f64]) {
    let w = map.size().0;
    let at = |x: u32| luminance(map.pixel(x, y).to_array().map(f64::from));
    let (mut before, mut here) = (at(w - 1), at(0));
    for (x, out) in (0..w).zip(out) {
        let after = at((x + 1) % w);
        *out = 0.125 * (before + after) + 0.75 * here;
        (before, here) = (here, after);
    }
}
