//! Directional albedos of rough surfaces, tabulated: what a lobe reflects of light from one direction, and what it loses by
//! scattering only once between its facets. [`table`](super::albedo_table) holds numbers made by the test of this file.

use std::sync::OnceLock;

use super::albedo_table::{DIELECTRIC_LOSS, FUZZ, GGX_LOSS, REFLECT_SHIFT};

/// Angles, evenly spaced in the mean of µ and µ (1 + α) / (µ + α), as what facets lose changes most where µ is about α; in √µ for
/// fuzz.
pub(super) const ANGLES: usize = 22;
/// Widths: α = (k / 27)²; the first row is the limit of small ones.
pub(super) const WIDTHS: usize = 28;
/// Contrasts s = (η − 1) / (η + 1) of indices of refraction.
pub(super) const CONTRASTS: [f64; 14] =
    [0.0, 0.04, 0.08, 0.11, 0.14, 0.17, 0.2, 0.25, 0.3, 0.4, 0.5, 0.65, 0.8, 1.0];
/// Values at the angles, in units of 1/32767, and last their mean over light from all around, which serves where nodes do not move with the width.
pub(super) type Row = [i16; ANGLES + 1];

const UNIT: f64 = 1.0 / 32767.0;

/// A tabulated function of the angle, for one width and one index.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    rows: [&'static Row; 4],
    weights: [f64; 4],
    /// Width that stretches the angles; `None` for √µ.
    alpha: Option<f64>,
}

impl Line {
    /// Its value at the cosine µ, by cubic splines through the nodes (Catmull and Rom).
    pub(crate) fn at(&self, mu: f64) -> f64 {
        let (k, [a, b, c, d]) = spline(coordinate(mu, self.alpha) * (ANGLES - 1) as f64);
        let mut sum = 0.0;
        for (row, weight) in self.rows.iter().zip(self.weights) {
            let at = |k: usize| f64::from(row[k]);
            let (before, after) = (at(k.max(1) - 1), at((k + 2).min(ANGLES - 1)));
            sum += weight * (a * before + b * at(k) + c * at(k + 1) + d * after);
        }
        sum * UNIT
    }

    /// ∫ of it 2µ dµ: of what [`Line::at`] gives between the nodes, for energy is kept only if both agree.
    pub(crate) fn average(&self) -> f64 {
        let Some(alpha) = self.alpha else {
            let sum: f64 =
                self.rows.iter().zip(self.weights).map(|(row, w)| w * f64::from(row[ANGLES])).sum();
            return sum * UNIT;
        };
        let (k, f) = place(alpha.sqrt() * (SHARES - 1) as f64, SHARES);
        let shares = shares();
        let mut sum = 0.0;
        for (row, weight) in self.rows.iter().zip(self.weights) {
            let of = |shares: &[f64; ANGLES]| -> f64 {
                shares.iter().zip(row.iter()).map(|(share, v)| share * f64::from(*v)).sum()
            };
            sum += weight * ((1.0 - f) * of(&shares[k]) + f * of(&shares[k + 1]));
        }
        sum * UNIT
    }
}

/// Widths of [`shares`]: α = (k / 511)².
const SHARES: usize = 512;

/// For each width, what the value at each node counts in the average of a line: ∫ of its spline 2µ dµ. 90 KB, made when it is first asked for.
fn shares() -> &'static [[f64; ANGLES]] {
    /// Places of the sum over √µ, in which what is narrow at grazing angles is wide.
    const PLACES: u32 = 1024;
    static TABLE: OnceLock<Vec<[f64; ANGLES]>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let of_width = |k: usize| {
            let root = k as f64 / (SHARES - 1) as f64;
            let alpha = (root * root).max(MIN_ALPHA);
            let mut shares = [0.0; ANGLES];
            for i in 0..PLACES {
                let s = (f64::from(i) + 0.5) / f64::from(PLACES);
                let share = 4.0 * s * s * s / f64::from(PLACES);
                let (k, weights) = spline(coordinate(s * s, Some(alpha)) * (ANGLES - 1) as f64);
                for (node, weight) in (0..4).zip(weights) {
                    shares[(k + node).clamp(1, ANGLES) - 1] += share * weight;
                }
            }
            shares
        };
        (0..SHARES).map(of_width).collect()
    })
}

/// Where a cosine lies among the angles, 0..=1.
pub(super) fn coordinate(mu: f64, alpha: Option<f64>) -> f64 {
    let mu = mu.clamp(0.0, 1.0);
    match alpha {
        None => mu.sqrt(),
        Some(alpha) => 0.5 * (mu + mu * (1.0 + alpha) / (mu + alpha)),
    }
}

/// The node below and the weights of the four nodes around.
pub(super) fn spline(x: f64) -> (usize, [f64; 4]) {
    let (k, f) = place(x, ANGLES);
    let (f2, f3) = (f * f, f * f * f);
    let a = 0.5 * (2.0 * f2 - f3 - f);
    let b = 0.5 * (3.0 * f3 - 5.0 * f2 + 2.0);
    let c = 0.5 * (4.0 * f2 - 3.0 * f3 + f);
    (k, [a, b, c, 0.5 * (f3 - f2)])
}

/// Place of a value between nodes: the lower node and the share of the upper one. `value` in units of nodes, `nodes` >= 2.
fn place(value: f64, nodes: usize) -> (usize, f64) {
    let v = value.clamp(0.0, (nodes - 1) as f64);
    let k = (v as usize).min(nodes - 2);
    (k, v - k as f64)
}

/// Narrower lobes look like this one.
pub(super) const MIN_ALPHA: f64 = 1e-4;

fn line(table: &'static [Row], position: f64, alpha: Option<f64>) -> Line {
    let (k, f) = place(position, table.len());
    let (a, b) = (&table[k], &table[k + 1]);
    Line { rows: [a, b, a, a], weights: [1.0 - f, f, 0.0, 0.0], alpha }
}

fn line_of_index(table: &'static [[Row; WIDTHS]; CONTRASTS.len()], eta: f64, alpha: f64) -> Line {
    let s = if eta.is_finite() { ((eta - 1.0) / (eta + 1.0)).abs() } else { 1.0 };
    let above = CONTRASTS.iter().position(|c| *c > s).unwrap_or(CONTRASTS.len() - 1).max(1);
    let (low, high) = (CONTRASTS[above - 1], CONTRASTS[above]);
    let g = ((s - low) / (high - low)).clamp(0.0, 1.0);
    let (k, f) = place(alpha.sqrt() * (WIDTHS - 1) as f64, WIDTHS);
    let (a, b) = (&table[above - 1], &table[above]);
    Line {
        rows: [&a[k], &a[k + 1], &b[k], &b[k + 1]],
        weights: [(1.0 - g) * (1.0 - f), (1.0 - g) * f, g * (1.0 - f), g * f],
        alpha: Some(alpha.max(MIN_ALPHA)),
    }
}

/// Share of light that a rough perfect mirror loses.
pub(super) fn mirror_loss(alpha: f64) -> Line {
    line(&GGX_LOSS, alpha.sqrt() * (WIDTHS - 1) as f64, Some(alpha.max(MIN_ALPHA)))
}

/// Share of light that a rough dielectric boundary of relative index `eta` (behind over in front) loses: neither reflected nor
/// transmitted.
pub(super) fn dielectric_loss(eta: f64, alpha: f64) -> Line {
    line_of_index(&DIELECTRIC_LOSS[usize::from(eta < 1.0)], eta, alpha)
}

/// What a rough dielectric, η >= 1, reflects more than a smooth one does.
pub(super) fn reflect_shift(eta: f64, alpha: f64) -> Line {
    line_of_index(&REFLECT_SHIFT, eta, alpha)
}

/// Albedo of fuzz of a roughness.
pub(super) fn fuzz(roughness: f64) -> Line {
    let low = super::fuzz::MIN_ROUGHNESS;
    line(&FUZZ, (roughness - low) / (1.0 - low) * (WIDTHS - 1) as f64, None)
}

#[cfg(test)]
#[path = "albedo_tests.rs"]
mod tests;
