//! Directional albedos of rough lobes, tabulated.
//!
//! The problem: how much light a rough lobe returns in all directions together, E(µ) = ∫ f(wo, wi) cos θi dwi, has no
//! closed form for GGX with Fresnel, and microfacet BSDFs count one scattering only: light that hits a second facet is
//! lost, L = 1 − E. Layering needs E (what is under a rough layer receives 1 − E), and multiple scattering between
//! facets needs L: Kulla and Conty (2017, "Revisiting physically based shading at Imageworks") return it as the lobe
//!
//! ```text
//!   f(wo, wi) = L(wo) L(wi) / (π L̄),     L̄ = ∫ L(µ) 2µ dµ
//! ```
//!
//! which integrates to exactly L(wo). Metals multiply it by the colour that several reflections leave.
//!
//! The tables ([`rows`], [`fuzz`]) are over the cosine, the width α, the contrast |η − 1| / (η + 1), and for
//! anisotropic lobes the ratio αmin/αmax and the azimuth. Lookups are Catmull-Rom splines over the angles and linear in
//! the rest. A table row is computed when first needed; a lookup reads at most eight rows. Energy is kept only if L̄ is
//! the integral of the interpolated L, so means are integrals of the splines.

mod fuzz;
mod fuzz_table;
mod lookup_x8;
mod microfacets;
mod rows;

use std::sync::OnceLock;

use super::fresnel;
pub(super) use fuzz::FuzzAlbedo;
pub(super) use lookup_x8::AlbedoCurveBlock;
use rows::{ANGLES, AZIMUTHS, Angles, CONTRASTS, RATIOS, Row, STRETCHED_CONTRASTS, STRETCHED_WIDTHS, WIDTHS};

use crate::bsdf::facets::{FacetKind, Facets};
use crate::math::DVec3;

/// A tabulated function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Grid {
    /// Albedo of a rough dielectric seen from outside, less the reflectance at the [`smoothed`] cosine.
    Reflected,
    /// Loss of a rough dielectric, seen from the side of the lower index.
    LossFromThin,
    /// Loss of a rough dielectric, seen from the side of the higher index.
    LossFromDense,
    /// Loss of a rough perfect mirror.
    MirrorLoss,
}

impl Grid {
    fn index(self) -> usize {
        match self {
            Grid::Reflected => 0,
            Grid::LossFromThin => 1,
            Grid::LossFromDense | Grid::MirrorLoss => 2,
        }
    }

    /// Its place where the mirror's loss is not separate.
    fn table(self) -> usize {
        if self == Grid::MirrorLoss { 3 } else { self.index() }
    }
}

/// Lower widths are clamped to this one.
pub(super) const MIN_ALPHA: f64 = 1e-4;

/// The coordinates of a direction in the tables.
#[derive(Clone, Copy, Debug)]
pub(super) struct AlbedoDirection {
    /// Cosine to the normal, within 0..=1.
    pub(super) mu: f64,
    /// Azimuth; `None` for the mean over all azimuths.
    azimuth: Option<f64>,
}

impl AlbedoDirection {
    /// The mean over all azimuths at the cosine `mu`.
    pub(super) fn all(mu: f64) -> AlbedoDirection {
        AlbedoDirection { mu, azimuth: None }
    }

    /// A direction on either side; x and y are the axes of anisotropy.
    pub(super) fn of(w: DVec3) -> AlbedoDirection {
        AlbedoDirection { mu: w.z.abs().min(1.0), azimuth: Some(azimuth(w.x.abs(), w.y.abs())) }
    }
}

/// The azimuth coordinate from x (0) to y (1), both at least 0.
fn azimuth(x: f64, y: f64) -> f64 {
    if x + y > 0.0 { y / (x + y) } else { 0.0 }
}

/// A tabulated function of the direction, for one width, anisotropy and index.
#[derive(Clone, Copy, Debug)]
pub(super) struct AlbedoCurve {
    grid: Grid,
    kind: FacetKind,
    /// Lower nodes of width, contrast and ratio; `None` for isotropic lobes.
    width: u8,
    contrast: u8,
    ratio: Option<u8>,
    /// Whether αy is the larger width.
    along_y: bool,
    /// Fractions between the nodes, 0..=1.
    f: [f64; 3],
    alpha: f64,
}

impl AlbedoCurve {
    fn new(grid: Grid, facets: &Facets, eta: f64) -> AlbedoCurve {
        let alpha = (0.5 * (facets.ax * facets.ax + facets.ay * facets.ay)).sqrt();
        let contrast = if eta.is_finite() { ((eta - 1.0) / (eta + 1.0)).abs() } else { 1.0 };
        let (along_y, ratio) = if facets.ax == facets.ay {
            (false, None)
        } else {
            (facets.ay > facets.ax, Some(facets.ay.min(facets.ax) / facets.ay.max(facets.ax)))
        };
        let (widths, contrasts) =
            if ratio.is_some() { (STRETCHED_WIDTHS, STRETCHED_CONTRASTS) } else { (WIDTHS, CONTRASTS) };
        let (width, fw) = locate(alpha.sqrt() * (widths - 1) as f64, widths);
        let (contrast, fc) = locate(contrast.sqrt() * (contrasts - 1) as f64, contrasts);
        let (ratio, fr) = match ratio {
            None => (None, 0.0),
            Some(q) => {
                let (ratio, f) = locate(q.sqrt() * (RATIOS - 1) as f64, RATIOS);
                (Some(ratio as u8), f)
            }
        };
        let alpha = alpha.max(MIN_ALPHA);
        AlbedoCurve {
            grid,
            kind: facets.kind,
            width: width as u8,
            contrast: contrast as u8,
            ratio,
            along_y,
            f: [fw, fc, fr],
            alpha,
        }
    }

    /// The interpolated mean of `of` over the neighbouring rows.
    #[inline(always)]
    fn mean(&self, of: impl Fn(&'static Row) -> f64) -> f64 {
        let [fw, fc, fr] = self.f;
        let (w, c) = (usize::from(self.width), usize::from(self.contrast));
        let with = |c: usize, r: Option<usize>| {
            let row = |w: usize| match r {
                None => rows::round(self.kind, self.grid, w, c),
                Some(r) => rows::stretched(self.kind, self.grid, w, c, r),
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

    /// The value in a direction, by Catmull-Rom splines through the nodes.
    pub(super) fn at(&self, w: AlbedoDirection) -> f64 {
        let angle = spline(coordinate(w.mu, self.alpha) * (ANGLES - 1) as f64, ANGLES);
        let (Some(azimuth), Some(_)) = (w.azimuth, self.ratio) else {
            return self.mean(|row| interpolate(row.mean(), &angle));
        };
        let azimuth = if self.along_y { 1.0 - azimuth } else { azimuth };
        let (t, weights) = spline(azimuth * (AZIMUTHS - 1) as f64, AZIMUTHS);
        self.mean(|row| {
            weights
                .iter()
                .enumerate()
                .map(|(i, weight)| weight * interpolate(row.at_azimuth(mirrored(t, i)), &angle))
                .sum()
        })
    }

    /// ∫ 2µ dµ over all azimuths of the values that [`AlbedoCurve::at`] interpolates: energy is kept only if both
    /// agree.
    pub(super) fn average(&self) -> f64 {
        let (k, f) = locate(self.alpha.sqrt() * (QUADRATURE_WIDTHS - 1) as f64, QUADRATURE_WIDTHS);
        let (a, b) = (quadrature_weights(k), quadrature_weights(k + 1));
        self.mean(|row| {
            let of = |weights: &[f64; ANGLES]| -> f64 {
                weights.iter().zip(row.mean()).map(|(weight, v)| weight * f64::from(*v)).sum()
            };
            (1.0 - f) * of(a) + f * of(b)
        })
    }
}

/// Directional albedo of a rough dielectric, seen from outside.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reflected {
    pub(super) curve: AlbedoCurve,
    pub(super) eta: f64,
}

impl Reflected {
    /// `eta` is at least 1; infinite is a perfect mirror, whose loss goes to the layer below.
    pub(super) fn new(facets: &Facets, eta: f64) -> Reflected {
        let grid = if eta == f64::INFINITY { Grid::MirrorLoss } else { Grid::Reflected };
        Reflected { curve: AlbedoCurve::new(grid, facets, eta), eta }
    }

    /// Fraction of light from `w` that is reflected, within 0..=1.
    pub(super) fn at(&self, w: AlbedoDirection) -> f64 {
        if self.eta == f64::INFINITY {
            return (1.0 - self.curve.at(w)).clamp(0.0, 1.0);
        }
        let smooth = fresnel::dielectric(smoothed(w.mu, self.curve.alpha), self.eta);
        (smooth + self.curve.at(w)).clamp(0.0, 1.0)
    }

    /// Cosine-weighted mean.
    pub(super) fn average(&self) -> f64 {
        if self.eta == f64::INFINITY {
            return (1.0 - self.curve.average()).clamp(0.0, 1.0);
        }
        self.curve.mean(|row| row.average).clamp(0.0, 1.0)
    }
}

/// Loss of a rough perfect mirror.
pub(super) fn mirror_loss(facets: &Facets) -> AlbedoCurve {
    AlbedoCurve::new(Grid::MirrorLoss, facets, 1.0)
}

/// Loss of a rough dielectric of relative index `eta` (behind over in front): light neither reflected nor transmitted.
pub(super) fn dielectric_loss(eta: f64, facets: &Facets) -> AlbedoCurve {
    AlbedoCurve::new(if eta < 1.0 { Grid::LossFromDense } else { Grid::LossFromThin }, facets, eta)
}

/// The approximate cosine between a direction at µ and its visible facets.
pub(super) fn smoothed(mu: f64, alpha: f64) -> f64 {
    (mu * mu + (1.0 - mu * mu) * 0.5 * alpha * alpha).sqrt()
}

/// Position of a cosine among the angles, 0..=1: the mean of µ and µ (1 + w) / (µ + w). The loss changes most where µ
/// is about `w`.
fn coordinate(mu: f64, alpha: f64) -> f64 {
    let (mu, w) = (mu.clamp(0.0, 1.0), warp(alpha));
    0.5 * (mu + mu * (1.0 + w) / (mu + w))
}

/// The cosine w around which nodes are dense.
fn warp(alpha: f64) -> f64 {
    alpha / (1.0 + 4.0 * alpha)
}

/// The lower node and the weights of the four neighbouring nodes.
type Spline = (usize, [f64; 4]);

fn spline(x: f64, nodes: usize) -> Spline {
    let (k, f) = locate(x, nodes);
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

/// The i-th azimuth node of a spline from node `k`; nodes beyond the axes are reflected.
fn mirrored(k: usize, i: usize) -> usize {
    let node = (k + i).abs_diff(1);
    if node < AZIMUTHS { node } else { 2 * (AZIMUTHS - 1) - node }
}

/// The lower node and the fraction of the upper one. `value` is in units of nodes, `nodes` >= 2.
fn locate(value: f64, nodes: usize) -> (usize, f64) {
    let v = value.clamp(0.0, (nodes - 1) as f64);
    let k = (v as usize).min(nodes - 2);
    (k, v - k as f64)
}

/// Number of widths of [`quadrature_weights`]: α = (k / 511)².
const QUADRATURE_WIDTHS: usize = 512;

/// Weights of the node values in the cosine-weighted mean of a curve: ∫ of its spline 2µ dµ. Computed when first
/// needed.
fn quadrature_weights(k: usize) -> &'static [f64; ANGLES] {
    /// Steps of the sum over √µ, which resolves narrow features at grazing angles.
    const STEPS: u32 = 1024;
    static TABLE: [OnceLock<[f64; ANGLES]>; QUADRATURE_WIDTHS] =
        [const { OnceLock::new() }; QUADRATURE_WIDTHS];
    TABLE[k].get_or_init(|| {
        let root = k as f64 / (QUADRATURE_WIDTHS - 1) as f64;
        let alpha = (root * root).max(MIN_ALPHA);
        let mut sums = [0.0; ANGLES];
        for i in 0..STEPS {
            let s = (f64::from(i) + 0.5) / f64::from(STEPS);
            let measure = 4.0 * s * s * s / f64::from(STEPS);
            let (k, weights) = spline(coordinate(s * s, alpha) * (ANGLES - 1) as f64, ANGLES);
            for (node, weight) in (0..4).zip(weights) {
                sums[(k + node).clamp(1, ANGLES) - 1] += measure * weight;
            }
        }
        sums
    })
}

/// Weights of the azimuth nodes in the mean over all azimuths.
fn azimuth_weights() -> &'static [f64; AZIMUTHS] {
    const STEPS: u32 = 4096;
    static TABLE: OnceLock<[f64; AZIMUTHS]> = OnceLock::new();
    TABLE.get_or_init(|| {
        let mut sums = [0.0; AZIMUTHS];
        for i in 0..STEPS {
            let (y, x) =
                crate::math::elementary::sin_cos_turns((f64::from(i) + 0.5) / (4.0 * f64::from(STEPS)));
            let (k, weights) = spline(azimuth(x, y) * (AZIMUTHS - 1) as f64, AZIMUTHS);
            for (node, weight) in weights.iter().enumerate() {
                sums[mirrored(k, node)] += weight / f64::from(STEPS);
            }
        }
        sums
    })
}

#[cfg(test)]
mod tests;
