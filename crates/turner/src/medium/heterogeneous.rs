//! Heterogeneous media on a grid, and unbiased tracking through them.
//!
//! If the density varies along the ray, neither the transmittance exp(−∫ σt dt) nor the distribution of free paths has
//! a closed form, and numerical integration (ray marching) is biased. Null-collision methods (Woodcock et al. 1965)
//! fill the medium with fictitious matter up to a constant majorant σ̄ ≥ σt, so that free paths are exponential. A
//! collision at t is real with probability σt(t)/σ̄; otherwise it is a null collision, which changes nothing.
//!
//! ```text
//!   σ̄ ┌────────────┐              majorant: constant in a block of 8³ cells
//!      │      ____  └─────┬─────
//!   σt │_____/    \___    │       × collisions, −ln(1 − u)/σ̄ apart
//!      └──×───×────×──×───×────> t
//! ```
//!
//! - Delta tracking (`walk`): the path scatters at the first real collision. The colour bands have different σt but
//!   share one path. The probability of a real collision is the mean of σt/σ̄ over the bands, weighted by their
//!   throughput. The weights are divided by the probability of the event that occurs, so no band's weight can grow
//!   without bound (after Kutz et al. 2017, "Spectral and decomposition tracking for rendering heterogeneous volumes",
//!   and Miller et al. 2019, "A null-scattering path integral formulation of light transport").
//! - Ratio tracking (`transmittance`): no collision ends the ray; each multiplies the estimate by 1 − σt/σ̄. The mean
//!   of the estimate is the exact transmittance, with less noise than an estimate of 0 or 1 (Novák et al. 2014,
//!   "Residual ratio tracking for estimating attenuation in participating media").
//! - Emission is collected at every collision and, as thin media have few of them, at points at equal distances from a random
//!   offset (systematic sampling). Both count by the balance heuristic: 1/(σ̄ + points per unit of length).
//!
//! The cost is proportional to the number of collisions, so the majorant is local: the maximum of each block, which a
//! 3D DDA visits in order.

use std::sync::Arc;

use super::temperatures::Temperatures;
use super::{Coefficients, RaySegment, Walk};
use crate::color::Spectrum;
use crate::math::elementary::ln;
use crate::math::{DVec3, Ray};
use crate::sampler::Stream;
use crate::schema::{ErrorCode, GridData, SceneError};

/// Cells along one edge of a block.
const BLOCK: u32 = 8;

/// Maximum number of collisions and emission points on one segment; a longer path is terminated.
const MAX_POINTS: u32 = 1 << 20;

/// Number of emission points across the box at the greatest density.
const EMISSION_POINTS: f64 = 16.0;

/// A prepared heterogeneous medium.
#[derive(Clone, Debug)]
pub struct Heterogeneous {
    pub(super) coefficients: Coefficients,
    grid: Arc<GridData>,
    /// Whether extinction or scattering differ by colour.
    has_colors: bool,
    /// Whether the density fades at the border, as if empty cells followed.
    fades: bool,
    /// World to cell coordinates: (p − min) · scale.
    min: DVec3,
    scale: DVec3,
    /// Number of blocks along each axis, and the maximum density in each, x fastest.
    blocks: [u32; 3],
    max_density: Vec<f32>,
    /// What multiplies the emission by temperature.
    temperatures: Option<Temperatures>,
    /// Majorant at density 1, collisions per unit of length.
    majorant: f64,
    /// Emission points per unit of length at density 1.
    emission_rate: f64,
}

/// The result of tracking, by band: throughput, emission and the scattering distance.
struct Tracked {
    weight: [f64; 3],
    emitted: [f64; 3],
    scattered: Option<f64>,
}

impl Heterogeneous {
    /// A grid that fills a box; the density may fade at its border.
    pub(super) fn new(
        coefficients: Coefficients,
        grid: Arc<GridData>,
        fades: bool,
        [min, max]: [DVec3; 2],
    ) -> Result<Heterogeneous, SceneError> {
        let size = grid.size();
        let cells = DVec3::from(size.map(f64::from));
        let blocks = size.map(|n| n.div_ceil(BLOCK));
        let count = blocks.iter().map(|n| *n as usize).product();
        let mut max_density = Vec::new();
        if max_density.try_reserve_exact(count).is_err() {
            return Err(SceneError::new(ErrorCode::TooLarge, "not enough memory for the blocks of a grid"));
        }
        let b = i64::from(BLOCK);
        for z in 0..i64::from(blocks[2]) {
            for y in 0..i64::from(blocks[1]) {
                for x in 0..i64::from(blocks[0]) {
                    // The interpolation reads the centres of neighbouring cells, too.
                    let first = [x, y, z].map(|v| v * b - 1);
                    max_density.push(grid.largest(first, first.map(|v| v + b + 1)));
                }
            }
        }
        let greatest = max_density.iter().copied().fold(0.0f32, f32::max);
        let [r, g, b] = coefficients.extinction;
        let majorant = r.max(g).max(b);
        let mut emission_rate = 0.0;
        if coefficients.emits() && greatest > 0.0 {
            emission_rate = EMISSION_POINTS / ((max - min).length() * f64::from(greatest));
        }
        let scale = cells / (max - min);
        let has_colors = grid.has_colors();
        let temperatures = None;
        Ok(Heterogeneous {
            coefficients,
            grid,
            has_colors,
            fades,
            min,
            scale,
            blocks,
            max_density,
            temperatures,
            majorant,
            emission_rate,
        })
    }

    /// The same medium whose emission has the colours of temperatures.
    pub(super) fn with_temperatures(self, temperatures: Option<Temperatures>) -> Heterogeneous {
        Heterogeneous { temperatures, ..self }
    }

    /// Density and emission at a point.
    #[inline]
    fn at(&self, p: DVec3) -> [f64; 2] {
        let p = (p - self.min) * self.scale;
        let [density, emission_scale] = self.grid.at(p);
        [if self.fades { density * self.grid.fade(p) } else { density }, emission_scale]
    }

    /// Extinction and scattering coefficients by colour at a point of this density.
    #[inline]
    fn coefficients_at(&self, p: DVec3, density: f64) -> [[f64; 3]; 2] {
        let c = &self.coefficients;
        if self.has_colors {
            return self.colored_at(p);
        }
        [c.extinction.map(|v| v * density), c.scattering.map(|v| v * density)]
    }

    #[inline(never)]
    fn colored_at(&self, p: DVec3) -> [[f64; 3]; 2] {
        let p = (p - self.min) * self.scale;
        let fade = if self.fades { self.grid.fade(p) } else { 1.0 };
        let [extinction, scattering] = self.grid.colors_at(p);
        let c = &self.coefficients;
        let by = |a: [f64; 3], b: [f64; 3]| [a[0] * b[0] * fade, a[1] * b[1] * fade, a[2] * b[2] * fade];
        [by(c.extinction, extinction), by(c.scattering, scattering)]
    }

    /// Visits the blocks along a ray in order, with the distances of entry and exit and the maximum density, until `f`
    /// returns false.
    #[inline]
    fn visit(&self, ray: &Ray, from: f64, to: f64, mut f: impl FnMut(f64, f64, f64) -> bool) {
        let scale = self.scale / f64::from(BLOCK);
        let o = ((ray.origin - self.min) * scale).to_array();
        let d = (ray.direction * scale).to_array();
        let extent = self.grid.size().map(|n| f64::from(n) / f64::from(BLOCK));
        let (mut t0, mut t1) = (from, to);
        for axis in 0..3 {
            if d[axis] == 0.0 {
                if !(0.0..=extent[axis]).contains(&o[axis]) {
                    return;
                }
                continue;
            }
            let (a, b) = (-o[axis] / d[axis], (extent[axis] - o[axis]) / d[axis]);
            (t0, t1) = (t0.max(a.min(b)), t1.min(a.max(b)));
        }
        if !(t0 < t1 && t1 < f64::INFINITY) {
            return;
        }
        let (mut cell, mut next, mut step) = ([0i64; 3], [f64::INFINITY; 3], [0i64; 3]);
        for axis in 0..3 {
            let last = i64::from(self.blocks[axis]) - 1;
            cell[axis] = ((o[axis] + d[axis] * t0).floor() as i64).clamp(0, last);
            if d[axis] != 0.0 {
                step[axis] = if d[axis] > 0.0 { 1 } else { -1 };
                let wall = cell[axis] + i64::from(d[axis] > 0.0);
                next[axis] = (wall as f64 - o[axis]) / d[axis];
            }
        }
        loop {
            let axis = match next {
                [x, y, z] if x <= y && x <= z => 0,
                [_, y, z] if y <= z => 1,
                _ => 2,
            };
            let exit = next[axis].min(t1);
            let index = cell[0] + i64::from(self.blocks[0]) * (cell[1] + i64::from(self.blocks[1]) * cell[2]);
            let max_density = self.max_density.get(index as usize).copied().unwrap_or(0.0);
            if exit > t0 && !f(t0, exit, f64::from(max_density)) {
                return;
            }
            t0 = t0.max(exit);
            cell[axis] += step[axis];
            if t0 >= t1 || cell[axis] < 0 || cell[axis] >= i64::from(self.blocks[axis]) {
                return;
            }
            let wall = cell[axis] + i64::from(step[axis] > 0);
            next[axis] = (wall as f64 - o[axis]) / d[axis];
        }
    }

    /// Adds the emission at a point with these density and scale of emission, found at `rate` points per unit of length.
    fn emit(&self, found: &mut Tracked, p: DVec3, [density, scale]: [f64; 2], rate: f64) {
        let color = self.temperatures.as_ref().map_or([1.0; 3], |t| t.color_at(p));
        let Tracked { emitted, weight, .. } = found;
        for (i, color) in color.into_iter().enumerate() {
            emitted[i] += weight[i] * density * scale * self.coefficients.emission[i] * color / rate;
        }
    }

    /// Tracks from collision to collision. `shares` are the fractions of the bands in the path's throughput: with them
    /// the path scatters (delta tracking), without them it passes (ratio tracking). `u` decides the first collision:
    /// `u[1]` its distance, `u[0]` its kind. Emission is collected with an offset of `emission_depth` (0 to 1).
    fn track(
        &self,
        ray: &Ray,
        [from, to]: [f64; 2],
        shares: Option<[f64; 3]>,
        u: [f64; 2],
        mut emission_depth: Option<f64>,
        more: &mut Stream,
    ) -> Tracked {
        let mut found = Tracked { weight: [1.0; 3], emitted: [0.0; 3], scattered: None };
        let mut depth = -ln(1.0 - u[1]);
        let mut first_u = Some(u[0]);
        let mut points_left = MAX_POINTS;
        self.visit(ray, from, to, |mut t, end, max_density| {
            let [rate, emission_rate] = [self.majorant, self.emission_rate].map(|rate| rate * max_density);
            if max_density <= 0.0 {
                return true;
            }
            loop {
                let block_depth = (end - t) * rate;
                let collides = depth < block_depth;
                let next = if collides { t + depth / rate } else { end };
                if let Some(depth) = &mut emission_depth {
                    let mut at = t + *depth / emission_rate;
                    while at < next && points_left > 0 {
                        points_left -= 1;
                        let p = ray.at(at);
                        self.emit(&mut found, p, self.at(p), rate + emission_rate);
                        at += 1.0 / emission_rate;
                    }
                    *depth = (at - next) * emission_rate;
                }
                points_left = points_left.saturating_sub(1);
                if points_left == 0 {
                    found.weight = [0.0; 3];
                    return false;
                }
                if !collides {
                    depth -= block_depth;
                    return true;
                }
                t = next;
                let point = ray.at(t);
                let [density, emission_scale] = self.at(point);
                if emission_depth.is_some() {
                    self.emit(&mut found, point, [density, emission_scale], rate + emission_rate);
                }
                let [extinction, scattering] = self.coefficients_at(point, density);
                let weight = &mut found.weight;
                // Probability of a real collision, by band.
                let real = extinction.map(|s| (s / rate).min(1.0));
                let u0 = first_u.take().unwrap_or_else(|| more.unit());
                if let Some(shares) = shares {
                    let total: f64 = (0..3).map(|i| shares[i] * weight[i]).sum();
                    let p: f64 = (0..3).map(|i| shares[i] * weight[i] * real[i]).sum::<f64>() / total;
                    if u0 < p {
                        for i in 0..3 {
                            weight[i] *= scattering[i] / (rate * p);
                        }
                        found.scattered = Some(t);
                        return false;
                    }
                    for i in 0..3 {
                        weight[i] *= (1.0 - real[i]) / (1.0 - p);
                    }
                } else {
                    for i in 0..3 {
                        weight[i] *= 1.0 - real[i];
                    }
                }
                let greatest = weight[0].max(weight[1]).max(weight[2]);
                if greatest < 0.02 {
                    // Russian roulette.
                    if greatest.is_nan() || greatest <= 0.0 || more.unit() < 0.5 {
                        *weight = [0.0; 3];
                        return false;
                    }
                    *weight = weight.map(|v| 2.0 * v);
                }
                depth = -ln(1.0 - more.unit());
            }
        });
        found
    }

    /// Samples scattering along a segment. The first two of `u` decide the first collision, the third is the offset of
    /// the emission points.
    pub fn walk(&self, stretch: &RaySegment<'_>, u: [f64; 3], more: &mut Stream) -> Walk {
        let shares = stretch.scatters.then_some(stretch.shares);
        let emission = (self.emission_rate > 0.0).then_some(u[2]);
        let found = self.track(stretch.ray, [0.0, stretch.end], shares, [u[0], u[1]], emission, more);
        let single = |v: [f64; 3]| Spectrum::from(v.map(|v| v as f32));
        Walk {
            scattered: found.scattered,
            weight: single(found.weight),
            pdf: 0.0,
            emitted: single(found.emitted),
        }
    }

    /// Unbiased estimate of the transmittance between two distances along a ray of unit direction.
    pub fn transmittance(&self, ray: &Ray, from: f64, to: f64, more: &mut Stream) -> Spectrum {
        let u = [0.0, more.unit()];
        let found = self.track(ray, [from, to], None, u, None, more);
        Spectrum::from(found.weight.map(|v| v as f32))
    }
}

#[cfg(test)]
mod tests;
