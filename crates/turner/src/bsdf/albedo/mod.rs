//! Directional albedos of rough surfaces: what a lobe reflects of light from one direction, and what it loses by scattering only once
//! between its facets. Tabulated by angle, width, contrast of the indices of refraction and stretch; see [`rows`] and [`fuzz`].

mod fuzz;
mod fuzz_table;
mod microfacets;
mod rows;

use std::sync::OnceLock;

use super::fresnel;
pub(super) use fuzz::FuzzAlbedo;
use rows::{ANGLES, Angles, CONTRASTS, RATIOS, Row, STRETCHED_CONTRASTS, STRETCHED_WIDTHS, TURNS, WIDTHS};

use crate::bsdf::microfacet::Ggx;
use crate::math::DVec3;

/// What is tabulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Grid {
    /// What a rough dielectric, seen from outside, reflects; less the reflectance at the [`smoothed`] cosine.
    Reflected,
    /// What a rough boundary loses, neither reflected nor transmitted, seen from the thinner side.
    LossFromThin,
    /// The same from the denser side.
    LossFromDense,
    /// What a rough perfect mirror loses.
    MirrorLoss,
}

impl Grid {
    fn number(self) -> usize {
        match self {
            Grid::Reflected => 0,
            Grid::LossFromThin => 1,
            Grid::LossFromDense | Grid::MirrorLoss => 2,
        }
    }
}

/// Narrower lobes look like this one.
pub(super) const MIN_ALPHA: f64 = 1e-4;

/// A direction as the tables know it.
#[derive(Clone, Copy, Debug)]
pub(super) struct AlbedoDirection {
    /// Cosine to the normal, within 0..=1.
    pub(super) mu: f64,
    /// Azimuth; `None` for the mean over all of them.
    turn: Option<f64>,
}

impl AlbedoDirection {
    /// All directions of a cosine.
    pub(super) fn all(mu: f64) -> AlbedoDirection {
        AlbedoDirection { mu, turn: None }
    }

    /// Of a direction on either side; x and y are the axes of the stretch.
    pub(super) fn of(w: DVec3) -> AlbedoDirection {
        AlbedoDirection { mu: w.z.abs().min(1.0), turn: Some(turn(w.x.abs(), w.y.abs())) }
    }
}

/// The azimuth from x (0) to y (1), both at least 0.
fn turn(x: f64, y: f64) -> f64 {
    if x + y > 0.0 { y / (x + y) } else { 0.0 }
}

/// A tabulated function of the direction, for one width, stretch and index.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    grid: Grid,
    /// Lower nodes of width, contrast and ratio; no ratio for round lobes.
    width: u8,
    contrast: u8,
    ratio: Option<u8>,
    /// Whether y is the longer axis.
    along_y: bool,
    /// Places between the nodes, 0..=1.
    f: [f64; 3],
    alpha: f64,
}

impl Line {
    fn new(grid: Grid, ggx: &Ggx, eta: f64) -> Line {
        let alpha = (0.5 * (ggx.ax * ggx.ax + ggx.ay * ggx.ay)).sqrt();
        let contrast = if eta.is_finite() { ((eta - 1.0) / (eta + 1.0)).abs() } else { 1.0 };
        let (along_y, ratio) = if ggx.ax == ggx.ay {
            (false, None)
        } else {
            (ggx.ay > ggx.ax, Some(ggx.ay.min(ggx.ax) / ggx.ay.max(ggx.ax)))
        };
        let (widths, contrasts) =
            if ratio.is_some() { (STRETCHED_WIDTHS, STRETCHED_CONTRASTS) } else { (WIDTHS, CONTRASTS) };
        let (width, fw) = place(alpha.sqrt() * (widths - 1) as f64, widths);
        let (contrast, fc) = place(contrast.sqrt() * (contrasts - 1) as f64, contrasts);
        let (ratio, fr) = match ratio {
            None => (None, 0.0),
            Some(q) => {
                let (ratio, f) = place(q.sqrt() * (RATIOS - 1) as f64, RATIOS);
                (Some(ratio as u8), f)
            }
        };
        let alpha = alpha.max(MIN_ALPHA);
        Line { grid, width: width as u8, contrast: contrast as u8, ratio, along_y, f: [fw, fc, fr], alpha }
    }

    /// The mean of `of` over the rows around, by their weights.
    #[inline(always)]
    fn mean(&self, of: impl Fn(&'static Row) -> f64) -> f64 {
        let [fw, fc, fr] = self.f;
        let (w, c) = (usize::from(self.width), usize::from(self.contrast));
        let with = |c: usize, r: Option<usize>| {
            let row = |w: usize| match r {
                None => rows::round(self.grid, w, c),
                Some(r) => rows::stretched(self.grid, w, c, r),
            };
            (1.0 - fw) * of(row(w)) + fw * of(row(w + 1))
        };
        let with = |r: Option<usize>| match self.grid {
            Grid::MirrorLoss => with(0, r),
            _ => (1.0 - fc) * with(c, r) + fc * with(c + 1, r),
        };
        match self.ratio.map(usize::from) {
            None => with(None),
            Some(r) => (1.0 - fr) * with(Some(r)) + fr * with(Some(r + 1)),
        }
    }

    /// Its value in a direction, by cubic splines through the nodes (Catmull and Rom).
    pub(super) fn at(&self, w: AlbedoDirection) -> f64 {
        let angle = spline(coordinate(w.mu, self.alpha) * (ANGLES - 1) as f64, ANGLES);
        let (Some(turn), Some(_)) = (w.turn, self.ratio) else {
            return self.mean(|row| interpolate(row.mean(), &angle));
        };
        let turn = if self.along_y { 1.0 - turn } else { turn };
        let (t, weights) = spline(turn * (TURNS - 1) as f64, TURNS);
        self.mean(|row| {
            weights
                .iter()
                .enumerate()
                .map(|(i, weight)| weight * interpolate(row.turn(mirrored(t, i)), &angle))
                .sum()
        })
    }

    /// ∫ of it 2µ dµ over all azimuths: of what [`Line::at`] gives between the nodes, for energy is kept only if both agree.
    pub(super) fn average(&self) -> f64 {
        let (k, f) = place(self.alpha.sqrt() * (SHARES - 1) as f64, SHARES);
        let (a, b) = (shares(k), shares(k + 1));
        self.mean(|row| {
            let of = |shares: &[f64; ANGLES]| -> f64 {
                shares.iter().zip(row.mean()).map(|(share, v)| share * f64::from(*v)).sum()
            };
            (1.0 - f) * of(a) + f * of(b)
        })
    }
}

/// What a rough dielectric reflects, seen from outside.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reflected {
    line: Line,
    eta: f64,
}

impl Reflected {
    /// Of a lobe and an index of at least 1; infinite is a perfect mirror, with what its facets lose left to what is below.
    pub(super) fn new(ggx: &Ggx, eta: f64) -> Reflected {
        let grid = if eta == f64::INFINITY { Grid::MirrorLoss } else { Grid::Reflected };
        Reflected { line: Line::new(grid, ggx, eta), eta }
    }

    /// Share of light from a direction, within 0..=1.
    pub(super) fn at(&self, w: AlbedoDirection) -> f64 {
        if self.eta == f64::INFINITY {
            return (1.0 - self.line.at(w)).clamp(0.0, 1.0);
        }
        let smooth = fresnel::dielectric(smoothed(w.mu, self.line.alpha), self.eta);
        (smooth + self.line.at(w)).clamp(0.0, 1.0)
    }

    /// Share of light from all around.
    pub(super) fn average(&self) -> f64 {
        if self.eta == f64::INFINITY {
            return (1.0 - self.line.average()).clamp(0.0, 1.0);
        }
        self.line.mean(|row| row.average).clamp(0.0, 1.0)
    }
}

/// Share of light that a rough perfect mirror loses.
pub(super) fn mirror_loss(ggx: &Ggx) -> Line {
    Line::new(Grid::MirrorLoss, ggx, 1.0)
}

/// Share of light that a rough dielectric boundary of relative index `eta` (behind over in front) loses: neither reflected nor
/// transmitted.
pub(super) fn dielectric_loss(eta: f64, ggx: &Ggx) -> Line {
    Line::new(if eta < 1.0 { Grid::LossFromDense } else { Grid::LossFromThin }, ggx, eta)
}

/// About the cosine at which light from µ meets the visible facets.
pub(super) fn smoothed(mu: f64, alpha: f64) -> f64 {
    (mu * mu + (1.0 - mu * mu) * 0.5 * alpha * alpha).sqrt()
}

/// Where a cosine lies among the angles, 0..=1: the mean of µ and µ (1 + w) / (µ + w), as what facets lose changes most where µ is about `w`.
fn coordinate(mu: f64, alpha: f64) -> f64 {
    let (mu, w) = (mu.clamp(0.0, 1.0), warp(alpha));
    0.5 * (mu + mu * (1.0 + w) / (mu + w))
}

/// The width that stretches the angles.
fn warp(alpha: f64) -> f64 {
    alpha / (1.0 + 4.0 * alpha)
}

/// The node below and the weights of the four nodes around.
type Spline = (usize, [f64; 4]);

fn spline(x: f64, nodes: usize) -> Spline {
    let (k, f) = place(x, nodes);
    let (f2, f3) = (f * f, f * f * f);
    let a = 0.5 * (2.0 * f2 - f3 - f);
    let b = 0.5 * (3.0 * f3 - 5.0 * f2 + 2.0);
    let c = 0.5 * (4.0 * f2 - 3.0 * f3 + f);
    (k, [a, b, c, 0.5 * (f3 - f2)])
}

fn interpolate(row: &Angles, (k, [a, b, c, d]): &Spline) -> f64 {
    let at = |k: usize| f64::from(row[k]);
    a * at((*k).max(1) - 1) + b * at(*k) + c * at(k + 1) + d * at((k + 2).min(ANGLES - 1))
}

/// The i-th azimuth of a spline from node `k`: those beyond the axes are as those on this side.
fn mirrored(k: usize, i: usize) -> usize {
    let node = (k + i).abs_diff(1);
    if node < TURNS { node } else { 2 * (TURNS - 1) - node }
}

/// Place of a value between nodes: the lower node and the share of the upper one. `value` in units of nodes, `nodes` >= 2.
fn place(value: f64, nodes: usize) -> (usize, f64) {
    let v = value.clamp(0.0, (nodes - 1) as f64);
    let k = (v as usize).min(nodes - 2);
    (k, v - k as f64)
}

/// Widths of [`shares`]: α = (k / 511)².
const SHARES: usize = 512;

/// For a width, what the value at each node counts in the average of a line: ∫ of its spline 2µ dµ. Made when it is first asked for.
fn shares(k: usize) -> &'static [f64; ANGLES] {
    /// Places of the sum over √µ, in which what is narrow at grazing angles is wide.
    const PLACES: u32 = 1024;
    static TABLE: [OnceLock<[f64; ANGLES]>; SHARES] = [const { OnceLock::new() }; SHARES];
    TABLE[k].get_or_init(|| {
        let root = k as f64 / (SHARES - 1) as f64;
        let alpha = (root * root).max(MIN_ALPHA);
        let mut shares = [0.0; ANGLES];
        for i in 0..PLACES {
            let s = (f64::from(i) + 0.5) / f64::from(PLACES);
            let share = 4.0 * s * s * s / f64::from(PLACES);
            let (k, weights) = spline(coordinate(s * s, alpha) * (ANGLES - 1) as f64, ANGLES);
            for (node, weight) in (0..4).zip(weights) {
                shares[(k + node).clamp(1, ANGLES) - 1] += share * weight;
            }
        }
        shares
    })
}

/// What the value at each azimuth counts in the mean over all of them.
fn turn_shares() -> &'static [f64; TURNS] {
    const PLACES: u32 = 4096;
    static TABLE: OnceLock<[f64; TURNS]> = OnceLock::new();
    TABLE.get_or_init(|| {
        let mut shares = [0.0; TURNS];
        for i in 0..PLACES {
            let (y, x) =
                crate::math::elementary::sin_cos_turns((f64::from(i) + 0.5) / (4.0 * f64::from(PLACES)));
            let (k, weights) = spline(turn(x, y) * (TURNS - 1) as f64, TURNS);
            for (node, weight) in weights.iter().enumerate() {
                shares[mirrored(k, node)] += weight / f64::from(PLACES);
            }
        }
        shares
    })
}

#[cfg(test)]
mod tests;
