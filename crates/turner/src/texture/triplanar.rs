//! Triplanar mapping: a texture projected along x, y and z, blended by the surface normal.
//!
//! ```text
//!               | y projection
//!               v
//!             ,---.
//!     x -->  (     )  <-- x       weight of axis i: |nᵢ|^k / (|n₀|^k + |n₁|^k + |n₂|^k)
//!             `---´
//! ```
//!
//! The exponent k is `blend`, and n is the normal in the texture's space (the usual form since Geiss 2007,
//! "Generating complex procedural terrains using the GPU", GPU Gems 3, ch. 1). Any shape is covered without seams and
//! with little stretching, at the cost of up to three lookups. Projections with weights below 0.01 are skipped;
//! subtracting 0.01 from all weights keeps the transition smooth.

use super::mapping::Side;
use super::{Projection, Texture, TexturePoint, Textures};
use crate::color::Spectrum;
use crate::math::elementary::pow;
use crate::math::{DMat3, DVec3};
use crate::schema::Transform;

/// A texture and the blending of its three projections.
#[derive(Clone, Debug)]
pub(super) struct Triplanar {
    pub(super) inner: Texture,
    blend: f64,
    /// Normals from object space to the texture's space: the transpose of the texture's transform.
    normals: DMat3,
}

impl Triplanar {
    pub(super) fn new(inner: Texture, blend: f64, transform: Transform) -> Triplanar {
        Triplanar { inner, blend, normals: transform.0.matrix3.transpose() }
    }

    /// The projections with positive weights; the weights add up to 1.
    fn sides(&self, n: DVec3) -> [Option<(Side, f64)>; 3] {
        /// Weights below this count as 0.
        const MIN_WEIGHT: f64 = 0.01;
        let n = (self.normals * n).try_normalize().unwrap_or(DVec3::Z).to_array();
        let raw = n.map(|c| pow(c.abs(), self.blend));
        let sum: f64 = raw.iter().sum();
        let raw = raw.map(|w| (w / sum - MIN_WEIGHT).max(0.0));
        let sum: f64 = raw.iter().sum();
        std::array::from_fn(|axis| {
            let sign = if n[axis] < 0.0 { -1.0 } else { 1.0 };
            (raw[axis] > 0.0).then_some((Side { axis, sign }, raw[axis] / sum))
        })
    }

    pub(super) fn eval(&self, textures: &Textures, at: &TexturePoint<'_>) -> Spectrum {
        let sides = self.sides(at.n).into_iter().flatten();
        sides.fold(Spectrum::BLACK, |sum, (side, weight)| {
            sum + self.inner.eval(textures, &TexturePoint { side, ..*at }) * weight as f32
        })
    }

    /// The texture's own opacity, as [`Texture::opacity`].
    pub(super) fn opacity(&self, textures: &Textures, at: &TexturePoint<'_>) -> Option<f32> {
        self.sides(at.n).into_iter().flatten().try_fold(0.0, |sum, (side, weight)| {
            Some(sum + self.inner.opacity(textures, &TexturePoint { side, ..*at })? * weight as f32)
        })
    }

    /// The smallest spacing of its projections.
    pub(super) fn spacing(&self, textures: &Textures, at: &TexturePoint<'_>) -> Option<f64> {
        let sides = self.sides(at.n).into_iter().flatten();
        sides
            .filter_map(|(side, _)| self.inner.spacing(textures, &TexturePoint { side, ..*at }))
            .reduce(f64::min)
    }

    /// How an image is mapped in each projection, as [`Textures::projections`].
    pub(super) fn projections(&self, at: &TexturePoint<'_>) -> [Option<Projection>; 3] {
        self.sides(at.n).map(|found| {
            let (side, weight) = found?;
            let one = self.inner.projection(&TexturePoint { side, ..*at })?;
            Some(Projection { weight, ..one })
        })
    }

    pub(super) fn memory(&self) -> usize {
        size_of::<Triplanar>() + self.inner.memory()
    }
}
