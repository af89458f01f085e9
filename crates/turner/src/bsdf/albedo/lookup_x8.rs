//! Albedo curves of isotropic lobes, looked up for eight lanes at a time with the bits of [`AlbedoCurve::at`].

use turner_bvh::lanes::{Block, Block32, F32x8, F64x8, LANES, Simd};

use super::rows::{ANGLES, Angles};
use super::{AlbedoCurve, Grid, rows, warp};
use crate::math::elementary_x8::clamp;

/// The values of lanes without a curve.
static NONE: Angles = [0.0; ANGLES];

/// The curves of eight lanes.
#[derive(Clone, Debug)]
pub(in crate::bsdf) struct AlbedoCurveBlock {
    /// The rows between which a curve is interpolated: two widths of the lower contrast, two of the upper.
    rows: [[&'static Angles; 4]; LANES],
    /// Fractions of the upper width and of the upper contrast.
    fractions: [Block; 2],
    alpha: Block,
    /// The cosine around which the nodes are dense.
    warp: Block,
}

impl Default for AlbedoCurveBlock {
    fn default() -> AlbedoCurveBlock {
        AlbedoCurveBlock {
            rows: [[&NONE; 4]; LANES],
            fractions: [Block::default(); 2],
            alpha: Block([1.0; LANES]),
            warp: Block([1.0; LANES]),
        }
    }
}

impl AlbedoCurve {
    /// Whether its lobe is isotropic.
    pub(in crate::bsdf) fn is_isotropic(&self) -> bool {
        self.ratio.is_none()
    }

    /// The four rows of an isotropic lobe; the mirror's loss has one contrast.
    fn rows(&self) -> [&'static Angles; 4] {
        let w = usize::from(self.width);
        let c = usize::from(self.contrast);
        let (c, upper) = if self.grid == Grid::MirrorLoss { (0, 0) } else { (c, c + 1) };
        [(w, c), (w + 1, c), (w, upper), (w + 1, upper)]
            .map(|(w, c)| rows::round(self.kind, self.grid, w, c).mean())
    }
}

impl AlbedoCurveBlock {
    /// Stores the curve of an isotropic lobe in a lane.
    pub(in crate::bsdf) fn set(&mut self, lane: usize, curve: &AlbedoCurve) {
        self.rows[lane] = curve.rows();
        let [width, contrast, _] = curve.f;
        self.fractions[0].0[lane] = width;
        self.fractions[1].0[lane] = if curve.grid == Grid::MirrorLoss { 0.0 } else { contrast };
        self.alpha.0[lane] = curve.alpha;
        self.warp.0[lane] = warp(curve.alpha);
    }

    /// Copies the curve of a lane of another block.
    pub(in crate::bsdf) fn copy_lane(&mut self, to: usize, other: &AlbedoCurveBlock, from: usize) {
        self.rows[to] = other.rows[from];
        let copies = [(&mut self.alpha, &other.alpha), (&mut self.warp, &other.warp)];
        for (a, b) in self.fractions.iter_mut().zip(&other.fractions).chain(copies) {
            a.0[to] = b.0[from];
        }
    }

    /// Sets all lanes to a lane of another block.
    pub(in crate::bsdf) fn set_all(&mut self, other: &AlbedoCurveBlock, from: usize) {
        self.rows = [other.rows[from]; LANES];
        let copies = [(&mut self.alpha, &other.alpha), (&mut self.warp, &other.warp)];
        for (a, b) in self.fractions.iter_mut().zip(&other.fractions).chain(copies) {
            a.0 = [b.0[from]; LANES];
        }
    }

    /// The widths α of the curves.
    #[inline(always)]
    pub(in crate::bsdf) fn alpha<S: Simd>(&self, simd: S) -> F64x8<S> {
        F64x8::load(simd, &self.alpha)
    }

    /// The values at cosines.
    #[inline(always)]
    pub(in crate::bsdf) fn at<S: Simd>(&self, simd: S, mu: F64x8<S>) -> F64x8<S> {
        let splat = |v: f64| F64x8::splat(simd, v);
        let (zero, half, one, two) = (splat(0.0), splat(0.5), splat(1.0), splat(2.0));
        let (mu, w) = (clamp(mu, zero, one), F64x8::load(simd, &self.warp));
        let coordinate = half * (mu + mu * (one + w) / (mu + w));
        let last = splat((ANGLES - 1) as f64);
        let x = clamp(coordinate * last, zero, last);
        let mut node = Block::default();
        x.store(&mut node);
        // values[row][node]: all reads of memory at once.
        let mut values = [[Block32::default(); 4]; 4];
        for lane in 0..LANES {
            let k = (node.0[lane] as usize).min(ANGLES - 2);
            node.0[lane] = k as f64;
            let nodes = [k.max(1) - 1, k, k + 1, (k + 2).min(ANGLES - 1)];
            for (values, row) in values.iter_mut().zip(self.rows[lane]) {
                for (block, k) in values.iter_mut().zip(nodes) {
                    block.0[lane] = row[k];
                }
            }
        }
        // The weights of `spline`.
        let f = x - F64x8::load(simd, &node);
        let (f2, f3) = (f * f, f * f * f);
        let a = half * (two * f2 - f3 - f);
        let b = half * (splat(3.0) * f3 - splat(5.0) * f2 + two);
        let c = half * (splat(4.0) * f2 - splat(3.0) * f3 + f);
        let d = half * (f3 - f2);
        let weights = [a, b, c, d];
        let [fw, fc] = [F64x8::load(simd, &self.fractions[0]), F64x8::load(simd, &self.fractions[1])];
        let lower =
            interpolate(simd, &values[0], weights) * (one - fw) + interpolate(simd, &values[1], weights) * fw;
        let upper =
            interpolate(simd, &values[2], weights) * (one - fw) + interpolate(simd, &values[3], weights) * fw;
        (one - fc) * lower + fc * upper
    }
}

/// As [`interpolate`](super::interpolate).
#[inline(always)]
fn interpolate<S: Simd>(simd: S, values: &[Block32; 4], [a, b, c, d]: [F64x8<S>; 4]) -> F64x8<S> {
    let [v0, v1, v2, v3] = values;
    let (v0, v1) = (F32x8::load(simd, v0).widen(), F32x8::load(simd, v1).widen());
    let (v2, v3) = (F32x8::load(simd, v2).widen(), F32x8::load(simd, v3).widen());
    a * v0 + b * v1 + c * v2 + d * v3
}
