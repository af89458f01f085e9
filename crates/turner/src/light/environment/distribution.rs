//! Directions chosen by how much light comes from them.
//!
//! The density is constant over each pixel: proportional to the mean luminance that the bilinear look-up has there,
//! so that wherever light comes from the density is above 0. Within a pixel all directions are alike per solid angle.
//! A row is chosen by its share of the light, then a column in it (inversion of both distribution functions): points
//! that are spread well over the unit square stay spread well over the sphere.

use std::collections::TryReserveError;
use std::f64::consts::{PI, TAU};

use super::map::{EnvironmentMap, around, coordinates_fast, height, solid_angles};
use crate::math::elementary::cos;
use crate::math::{DVec2, DVec3};
use crate::schema::{ErrorCode, SceneError};

/// The columns of a row share this many units.
const UNITS: u32 = u32::MAX;

/// A density of directions, constant over each pixel.
#[derive(Debug)]
pub(super) struct Distribution {
    width: u32,
    height: u32,
    /// Where each row begins in 0..=1, and the end of the last; empty if all is black.
    rows: Vec<f64>,
    /// In which unit each column begins, row by row; the last one ends at [`UNITS`].
    columns: Vec<u32>,
    /// Cosine of the angle from the zenith at the upper edge of each row, and at the end.
    edges: Vec<f64>,
    /// The density per unit of each row.
    densities: Vec<f64>,
    /// In which row each of equal parts of 0..=1 begins, as many as a power of two, and the last row: half of a search.
    row_guide: Vec<u32>,
    /// The same for the columns of each row, of [`UNITS`] + 1.
    column_guide: Vec<u32>,
    /// Parts of a row's guide are this power of two.
    guide_bits: u32,
}

impl Distribution {
    /// By the luminance of a picture. With `compensated`, the mean over all directions is subtracted first (Karlik
    /// et al. 2019, "MIS Compensation"): for use with the balance heuristic alone. A picture that is the same
    /// everywhere is then sampled evenly.
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
            // Nothing rises above the mean.
            sums = distribution.fill(map, &solid_angles, 0.0);
        }
        let (mut begin, whole) = (0.0, sums.iter().sum::<f64>());
        distribution.rows = Vec::with_capacity(sums.len() + 1);
        for sum in sums {
            distribution.rows.push((begin / whole).min(1.0));
            begin += sum;
        }
        distribution.rows.push(1.0);
        distribution.guide().map_err(|_| no_memory(width, height))?;
        Ok(distribution)
    }

    /// Fills in what is looked up beforehand.
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

    /// Writes the columns of every row; gives the light of each row above `floor`.
    fn fill(&mut self, map: &EnvironmentMap, solid_angles: &[f64], floor: f64) -> Vec<f64> {
        self.columns.clear();
        let mut around = Smoothed::new(map);
        let mut weights = vec![0.0; self.width as usize];
        (0..self.height)
            .zip(solid_angles)
            .map(|(y, solid_angle)| {
                around.row(y, &mut weights);
                weights.iter_mut().for_each(|w| *w = (*w - floor).max(0.0));
                self.push_row(&weights);
                weights.iter().sum::<f64>() * solid_angle
            })
            .collect()
    }

    /// Divides a row's units among its columns by their weights; each that has any gets one at least.
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

    /// A direction for two uniform numbers in 0..1, its place in the picture and its density per solid angle; `None` if all is
    /// black.
    pub(super) fn sample(&self, u: [f64; 2]) -> Option<(DVec3, DVec2, f64)> {
        let (u, cos_theta, pdf) = self.find(u)?;
        let sin_theta = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
        let uv = DVec2::new(u, height(sin_theta, cos_theta));
        (pdf > 0.0).then(|| (around(u, sin_theta, cos_theta), uv, pdf))
    }

    /// The same as u in the picture and the cosine of the angle from the zenith, with a density that may be 0.
    #[inline]
    pub(super) fn find(&self, u: [f64; 2]) -> Option<(f64, f64, f64)> {
        let row = self.row_of(u)?;
        self.place(&row, self.span(&row)?)
    }

    /// The row, by the second number. This, `span` and `place` make [`Distribution::find`]: those that read large tables do little else, so that many
    /// reads are under way together where there are many numbers.
    #[inline]
    pub(super) fn row_of(&self, u: [f64; 2]) -> Option<Row> {
        let [u, v] = u.map(|u| if u > 0.0 { u.min(1.0 - f64::EPSILON) } else { 0.0 });
        let parts = self.row_guide.len().checked_sub(1)?;
        let y = between(&self.row_guide, (v * parts as f64) as usize, &self.rows, |begin| *begin <= v)?;
        let (begin, end) = (self.rows[y], self.rows[y + 1]);
        let down = ((v - begin) / (end - begin)).clamp(0.0, 1.0);
        Some(Row { y, down, unit: u * f64::from(UNITS) })
    }

    /// The first and last column that come into question.
    #[inline]
    pub(super) fn span(&self, row: &Row) -> Option<[u32; 2]> {
        let part = (u64::from(row.unit as u32) << self.guide_bits >> 32) as usize;
        let first = row.y * ((1 << self.guide_bits) + 1) + part;
        Some([*self.column_guide.get(first)?, *self.column_guide.get(first + 1)?])
    }

    /// Reads a column of each, so that they are near when they are searched; what comes out is of no account.
    #[inline]
    pub(super) fn touch(&self, rows: &[Option<(Row, [u32; 2])>]) -> u32 {
        let mut sum = 0_u32;
        for (row, [first, _]) in rows.iter().flatten() {
            let at = row.y * self.width as usize + *first as usize;
            sum = sum.wrapping_add(self.columns.get(at).copied().unwrap_or_default());
        }
        sum
    }

    /// The column, the place and its density.
    #[inline]
    pub(super) fn place(
        &self,
        &Row { y, down, unit }: &Row,
        [first, last]: [u32; 2],
    ) -> Option<(f64, f64, f64)> {
        // The greatest whole number that is not above it: columns begin at whole numbers.
        let whole = unit as u32;
        let row = self.row(y);
        let begins = row.get(first as usize + 1..=last as usize)?;
        let x = first as usize + begins.partition_point(|begin| *begin <= whole);
        let (first, units) = column(row, x);
        let across = ((unit - f64::from(first)) / f64::from(units)).clamp(0.0, 1.0);
        let cos_theta = self.edges[y] + (self.edges[y + 1] - self.edges[y]) * down;
        Some(((x as f64 + across) / f64::from(self.width), cos_theta, self.density(x, y)))
    }

    /// Reads what [`Distribution::pdf_at`] will, at many places; what comes out is of no account.
    #[inline]
    pub(super) fn touch_at(&self, places: impl Iterator<Item = DVec2>) -> u32 {
        let cell = |v: f64, n: u32| ((v * f64::from(n)) as u32).min(n - 1) as usize;
        let mut sum = 0_u32;
        for uv in places {
            let at = cell(uv.y, self.height) * self.width as usize + cell(uv.x, self.width);
            sum = sum.wrapping_add(self.columns.get(at).copied().unwrap_or_default());
        }
        sum
    }

    /// The density of a direction of any length, per solid angle.
    pub(super) fn pdf(&self, direction: DVec3) -> f64 {
        self.pdf_at(coordinates_fast(direction))
    }

    /// The same at a place in the picture, (u, v) in 0..=1.
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

    /// Bytes of the tables.
    pub(super) fn memory(&self) -> usize {
        let guides = size_of_val(&*self.row_guide) + size_of_val(&*self.column_guide);
        let rows = size_of_val(&*self.rows) + size_of_val(&*self.edges) + size_of_val(&*self.densities);
        rows + guides + size_of_val(&*self.columns)
    }
}

/// A row that was chosen, how far down in it, and the place along it in units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    y: usize,
    down: f64,
    unit: f64,
}

/// The last place that begins early enough, found between two entries of a guide; `begins` says of which places that is so: the
/// first ones.
#[inline]
fn between<T>(guide: &[u32], part: usize, places: &[T], begins: impl Fn(&T) -> bool) -> Option<usize> {
    let (first, last) = (*guide.get(part)? as usize, *guide.get(part + 1)? as usize);
    Some(first + places.get(first + 1..=last)?.partition_point(begins))
}

fn no_memory(width: u32, height: u32) -> SceneError {
    let message = format!("there is no memory to sample an environment of {width}x{height} pixels");
    SceneError::new(ErrorCode::TooLarge, message).help("scale the picture down")
}

/// Where a column begins, and how many units it has.
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
    /// Luminances along the rows before, at and after the last one asked for, already smoothed along the row.
    near: [Vec<f64>; 3],
    at: Option<u32>,
}

impl<'a> Smoothed<'a> {
    fn new(map: &'a EnvironmentMap) -> Smoothed<'a> {
        let empty = || vec![0.0; map.size().0 as usize];
        Smoothed { map, near: [empty(), empty(), empty()], at: None }
    }

    /// The means of row `y`: rows are asked for one after the other.
    fn row(&mut self, y: u32, out: &mut [f64]) {
        let last = self.map.size().1 - 1;
        if self.at.is_some_and(|at| at + 1 == y) {
            self.near.rotate_left(1);
        } else {
            along(self.map, y.saturating_sub(1), &mut self.near[0]);
            along(self.map, y, &mut self.near[1]);
        }
        along(self.map, (y + 1).min(last), &mut self.near[2]);
        self.at = Some(y);
        let [before, here, after] = &self.near;
        for (x, out) in out.iter_mut().enumerate() {
            *out = 0.125 * (before[x] + after[x]) + 0.75 * here[x];
        }
    }
}

/// Luminances of a row, smoothed along it and around its ends.
fn along(map: &EnvironmentMap, y: u32, out: &mut [f64]) {
    let w = map.size().0;
    let at = |x: u32| luminance(map.pixel(x, y).to_array().map(f64::from));
    let (mut before, mut here) = (at(w - 1), at(0));
    for (x, out) in (0..w).zip(out) {
        let after = at((x + 1) % w);
        *out = 0.125 * (before + after) + 0.75 * here;
        (before, here) = (here, after);
    }
}
