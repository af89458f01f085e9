//! Triplanar mapping: a texture looked up along x, y and z, and mixed by the normal.
//!
//! The weight of an axis is |nᵢ|^k over the sum of the three (the usual form since Geiss 2007, "Generating complex procedural terrains using the GPU", GPU Gems 3,
//! ch. 1), with n in the texture's own space. Axes with less than a hundredth are left out, smoothly.

use super::mapping::Side;
use super::{Projection, Texture, TexturePoint, Textures};
use crate::color::Spectrum;
use crate::math::elementary::pow;
use crate::math::{DMat3, DVec3};
use crate::schema::Transform;

/// A texture and how its three projections are mixed.
#[derive(Clone, Debug)]
pub(super) struct Triplanar {
    pub(super) inner: Texture,
    blend: f64,
    /// Normals of the object in the texture's space: the transpose of the texture's transform.
    normals: DMat3,
}

impl Triplanar {
    pub(super) fn new(inner: Texture, blend: f64, transform: Transform) -> Triplanar {
        Triplanar { inner, blend, normals: transform.0.matrix3.transpose() }
    }

    /// The sides that count, with weights that add up to 1.
    fn sides(&self, n: DVec3) -> [Option<(Side, f64)>; 3] {
        /// Weights below this count as none.
        const LEAST: f64 = 0.01;
        let n = (self.normals * n).try_normalize().unwrap_or(DVec3::Z).to_array();
        let raw = n.map(|c| pow(c.abs(), self.blend));
        let sum: f64 = raw.iter().sum();
        let raw = raw.map(|w| (w / sum - LEAST).max(0.0));
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

    /// Opacity of its own, as [`Texture::opacity`].
    pub(super) fn opacity(&self, textures: &Textures, at: &TexturePoint<'_>) -> Option<f32> {
        self.sides(at.n).into_iter().flatten().try_fold(0.0, |sum, (side, weight)| {
            Some(sum + self.inner.opacity(textures, &TexturePoint { side, ..*at })? * weight as f32)
        })
    }

    /// The shortest of its sides'.
    pub(super) fn spacing(&self, textures: &Textures, at: &TexturePoint<'_>) -> Option<f64> {
        let sides = self.sides(at.n).into_iter().flatten();
        sides
            .filter_map(|(side, _)| self.inner.spacing(textures, &TexturePoint { side, ..*at }))
            .reduce(f64::min)
    }

    /// How a picture lies on each side, as [`Textures::projections`].
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
