//! Rows of the albedo tables. Each is computed when first needed and is the same in every process: about a millisecond
//! per row for what a scene's few materials need, instead of megabytes of constants.

use std::sync::OnceLock;

use super::microfacets::{Boundary, Lattice};
use super::{Grid, MIN_ALPHA, coordinate, smoothed, warp};
use crate::bsdf::facets::{FacetDistribution, FacetKind, FacetMasking, Facets};
use crate::bsdf::fresnel;
use crate::math::DVec3;

/// Angles, evenly spaced in [`coordinate`].
pub(super) const ANGLES: usize = 48;
/// Widths: α = (k / 63)². The first row is the limit of small widths.
pub(super) const WIDTHS: usize = 64;
/// Contrasts of the indices: |η − 1| / (η + 1) = (k / 47)².
pub(super) const CONTRASTS: usize = 48;
/// Widths of anisotropic lobes: α = (k / 39)², the root mean square of αx and αy.
pub(super) const STRETCHED_WIDTHS: usize = 40;
/// Contrasts for anisotropic lobes: (k / 23)².
pub(super) const STRETCHED_CONTRASTS: usize = 24;
/// Ratios of the smaller to the larger width: (k / 13)².
pub(super) const RATIOS: usize = 14;
/// Azimuths from the longer to the shorter axis, evenly spaced in [`azimuth`](super::azimuth). Total reflection makes
/// sharp edges in the loss of anisotropic glass.
pub(super) const AZIMUTHS: usize = 25;

/// Values at the angles.
pub(super) type Angles = [f32; ANGLES];

/// A function of the angle, and of the azimuth for anisotropic lobes, for one width, contrast and ratio.
#[derive(Debug)]
pub(super) struct Row {
    /// Values at each azimuth; empty for isotropic lobes.
    azimuths: Box<[Angles]>,
    /// Mean over all azimuths.
    mean: Angles,
    /// ∫ 2µ dµ of the mean.
    pub(super) average: f64,
}

impl Row {
    /// The values at an azimuth: the mean for isotropic lobes.
    pub(super) fn at_azimuth(&self, k: usize) -> &Angles {
        self.azimuths.get(k).unwrap_or(&self.mean)
    }

    pub(super) fn mean(&self) -> &Angles {
        &self.mean
    }
}

type Slot = OnceLock<Box<Row>>;
type Block<const W: usize, const C: usize> = [[Slot; W]; C];

static MIRROR: [Slot; WIDTHS] = [const { OnceLock::new() }; WIDTHS];
static ROUND: [Block<WIDTHS, CONTRASTS>; 3] =
    [const { [const { [const { OnceLock::new() }; WIDTHS] }; CONTRASTS] }; 3];
static STRETCHED_MIRROR: Block<STRETCHED_WIDTHS, RATIOS> =
    [const { [const { OnceLock::new() }; STRETCHED_WIDTHS] }; RATIOS];
static STRETCHED: [[Block<STRETCHED_WIDTHS, STRETCHED_CONTRASTS>; RATIOS]; 3] = [const {
    [const { [const { [const { OnceLock::new() }; STRETCHED_WIDTHS] }; STRETCHED_CONTRASTS] }; RATIOS]
}; 3];

fn square(k: usize, n: usize) -> f64 {
    let r = k as f64 / (n - 1) as f64;
    r * r
}

/// Rows of other kinds than [`FacetKind::PLAIN`], which few scenes have: isotropic ones, then anisotropic ones.
static OTHERS: [OnceLock<Vec<Slot>>; 3] = [const { OnceLock::new() }; 3];
const ROUND_ROWS: usize = 4 * CONTRASTS * WIDTHS;
const STRETCHED_ROWS: usize = 4 * RATIOS * STRETCHED_CONTRASTS * STRETCHED_WIDTHS;

fn other(kind: FacetKind, index: usize) -> &'static Slot {
    let k = match (kind.distribution, kind.masking) {
        (FacetDistribution::Ggx, _) => 0,
        (FacetDistribution::Beckmann, FacetMasking::Correlated) => 1,
        (FacetDistribution::Beckmann, FacetMasking::Separable) => 2,
    };
    let make = || std::iter::repeat_with(Slot::new).take(ROUND_ROWS + STRETCHED_ROWS).collect();
    &OTHERS[k].get_or_init(make)[index]
}

/// A row of an isotropic lobe; `width` < WIDTHS, `contrast` < CONTRASTS.
pub(super) fn round(kind: FacetKind, grid: Grid, width: usize, contrast: usize) -> &'static Row {
    let alpha = || square(width, WIDTHS).max(MIN_ALPHA);
    let make = |grid, alpha, contrast, ratio| make(kind, grid, alpha, contrast, ratio);
    if kind != FacetKind::PLAIN {
        let index = (grid.table() * CONTRASTS + contrast) * WIDTHS + width;
        let contrast = square(contrast, CONTRASTS);
        return other(kind, index).get_or_init(|| Box::new(make(grid, alpha(), contrast, 1.0)));
    }
    match grid {
        Grid::MirrorLoss => MIRROR[width].get_or_init(|| Box::new(make(grid, alpha(), 1.0, 1.0))),
        _ => ROUND[grid.index()][contrast][width]
            .get_or_init(|| Box::new(make(grid, alpha(), square(contrast, CONTRASTS), 1.0))),
    }
}

/// A row of an anisotropic lobe.
pub(super) fn stretched(
    kind: FacetKind,
    grid: Grid,
    width: usize,
    contrast: usize,
    ratio: usize,
) -> &'static Row {
    let alpha = || square(width, STRETCHED_WIDTHS).max(MIN_ALPHA);
    let q = square(ratio, RATIOS);
    let make = |grid, alpha, contrast, ratio| make(kind, grid, alpha, contrast, ratio);
    if kind != FacetKind::PLAIN {
        let index =
            ((grid.table() * RATIOS + ratio) * STRETCHED_CONTRASTS + contrast) * STRETCHED_WIDTHS + width;
        let contrast = square(contrast, STRETCHED_CONTRASTS);
        return other(kind, ROUND_ROWS + index).get_or_init(|| Box::new(make(grid, alpha(), contrast, q)));
    }
    match grid {
        Grid::MirrorLoss => {
            STRETCHED_MIRROR[ratio][width].get_or_init(|| Box::new(make(grid, alpha(), 1.0, q)))
        }
        _ => STRETCHED[grid.index()][ratio][contrast][width]
            .get_or_init(|| Box::new(make(grid, alpha(), square(contrast, STRETCHED_CONTRASTS), q))),
    }
}

/// The tabulated value for light from `wo`.
pub(super) fn value(grid: Grid, facets: &Facets, wo: DVec3, contrast: f64, lattice: &Lattice) -> f64 {
    let index = index(contrast);
    let is_mirror = index == f64::INFINITY;
    let loss = |boundary| {
        let (r, t) = lattice.albedos(facets, wo, boundary);
        1.0 - r - t
    };
    match grid {
        Grid::MirrorLoss => loss(Boundary::Mirror),
        Grid::Reflected if is_mirror => -loss(Boundary::Mirror),
        Grid::Reflected => {
            let alpha = (0.5 * (facets.ax * facets.ax + facets.ay * facets.ay)).sqrt();
            lattice.albedos(facets, wo, Boundary::Dielectric(index)).0
                - fresnel::dielectric(smoothed(wo.z, alpha), index)
        }
        Grid::LossFromThin | Grid::LossFromDense if is_mirror => loss(Boundary::Mirror),
        Grid::LossFromThin => loss(Boundary::Dielectric(index)),
        Grid::LossFromDense => loss(Boundary::Dielectric(1.0 / index)),
    }
}

/// The relative index, at least 1, of a contrast; infinite at 1.
pub(super) fn index(contrast: f64) -> f64 {
    if contrast >= 1.0 { f64::INFINITY } else { (1.0 + contrast.max(1e-4)) / (1.0 - contrast.max(1e-4)) }
}

/// The k-th cosine: where [`coordinate`] is k / (ANGLES − 1).
fn cosine(k: usize, alpha: f64) -> f64 {
    let (t, w) = (k as f64 / (ANGLES - 1) as f64, warp(alpha));
    // The root of µ² + (1 + 2w − 2t) µ = 2 t w.
    let half = 0.5 + w - t;
    (2.0 * t * w / (half + (half * half + 2.0 * t * w).sqrt())).clamp(1e-6, 1.0)
}

/// The points of the quadrature: more where the critical angle cuts through them, fewer where a row needs many sums of
/// both reflection and transmission.
fn lattice(kind: FacetKind, grid: Grid, round: bool) -> &'static Lattice {
    static LATTICES: [OnceLock<Lattice>; 4] = [const { OnceLock::new() }; 4];
    let (k, n, before) = match (grid, round) {
        (_, false) if kind != FacetKind::PLAIN => (3, 233, 144),
        (Grid::LossFromDense, true) => (0, 4181, 2584),
        (Grid::MirrorLoss, _) | (_, true) => (1, 2584, 1597),
        _ => (2, 610, 377),
    };
    LATTICES[k].get_or_init(|| Lattice::new(n, before))
}

fn make(kind: FacetKind, grid: Grid, alpha: f64, contrast: f64, ratio: f64) -> Row {
    // OpenPBR's widths of an anisotropic lobe.
    let ax = alpha * (2.0 / (1.0 + ratio * ratio)).sqrt();
    let facets = Facets { ax, ay: (ax * ratio).max(MIN_ALPHA), kind };
    let lattice = lattice(kind, grid, ratio == 1.0);
    let row = |cos: f64, sin: f64| -> Angles {
        std::array::from_fn(|k| {
            let mu = cosine(k, alpha);
            let r = (1.0 - mu * mu).max(0.0).sqrt();
            value(grid, &facets, DVec3::new(r * cos, r * sin, mu), contrast, lattice) as f32
        })
    };
    if ratio == 1.0 {
        let mean = row(1.0, 0.0);
        return Row { azimuths: Box::new([]), average: average(grid, &mean, alpha, contrast), mean };
    }
    let azimuths: Box<[Angles]> = (0..AZIMUTHS)
        .map(|k| {
            // Where y / (x + y) is k / (AZIMUTHS − 1).
            let y = k as f64 / (AZIMUTHS - 1) as f64;
            let length = ((1.0 - y) * (1.0 - y) + y * y).sqrt();
            row((1.0 - y) / length, y / length)
        })
        .collect();
    let weights = super::azimuth_weights();
    let mean: Angles = std::array::from_fn(|k| {
        azimuths.iter().zip(weights).map(|(angles, weight)| f64::from(angles[k]) * weight).sum::<f64>() as f32
    });
    Row { average: average(grid, &mean, alpha, contrast), mean, azimuths }
}

fn average(grid: Grid, mean: &Angles, alpha: f64, contrast: f64) -> f64 {
    const STEPS: u32 = 2048;
    let index = index(contrast);
    let at = |i: u32| {
        let s = (f64::from(i) + 0.5) / f64::from(STEPS);
        let mu = s * s;
        let curve =
            super::interpolate(mean, &super::spline(coordinate(mu, alpha) * (ANGLES - 1) as f64, ANGLES));
        let base =
            if grid == Grid::Reflected { fresnel::dielectric(smoothed(mu, alpha), index) } else { 0.0 };
        (curve + base) * 4.0 * s * s * s
    };
    (0..STEPS).map(at).sum::<f64>() / f64::from(STEPS)
}
