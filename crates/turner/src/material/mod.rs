//! Materials: how a surface answers light. One file each; [`MaterialDesc`] is the table of their names in a scene.

mod classic;

pub use classic::{Classic, ClassicMaterial, Fresnel, ShadowKind};

use crate::color::Spectrum;
use crate::scene::schema::family;
use crate::scene::{ColorSource, Scene, SurfaceInteraction};

family! {
    /// Materials: in `[material.NAME]`, or in place as `material = { … }`. The `type` is "classic" unless given.
    pub enum MaterialDesc as "material", "materials" {
        Classic(ClassicMaterial),
    }
}

impl Default for MaterialDesc {
    fn default() -> MaterialDesc {
        MaterialDesc::Classic(ClassicMaterial::default())
    }
}

/// A material ready to shade.
#[derive(Clone, Copy, Debug)]
pub enum Material {
    /// The classic documents' material.
    Classic(Classic),
}

impl MaterialDesc {
    /// Makes it ready.
    pub fn prepare(&self) -> Material {
        match self {
            MaterialDesc::Classic(m) => Material::Classic(m.prepare()),
        }
    }

    /// Its opacity and the least that counts; `None` for a material that is there everywhere.
    pub fn cutout(&self) -> Option<(ColorSource, f32)> {
        let MaterialDesc::Classic(m) = self;
        let cutoff = m.alpha_cutoff as f32;
        let everywhere = match m.opacity {
            ColorSource::Constant(c) => (c.r + c.g + c.b) / 3.0 >= cutoff,
            ColorSource::Texture(_) => false,
        };
        (!everywhere).then_some((m.opacity, cutoff))
    }
}

impl Material {
    /// What shadow its objects cast.
    #[inline]
    pub fn shadow(&self) -> ShadowKind {
        match self {
            Material::Classic(m) => m.shadow,
        }
    }

    /// The share of light that a tinted shadow lets through at a crossing of the surface.
    pub fn shadow_tint(&self, scene: &Scene, surface: &SurfaceInteraction) -> Spectrum {
        match self {
            Material::Classic(m) => color_at(m.color, scene, surface) * m.k_refract as f32,
        }
    }
}

/// The colour of a source on a surface.
#[inline]
pub fn color_at(source: ColorSource, scene: &Scene, surface: &SurfaceInteraction) -> Spectrum {
    match source {
        ColorSource::Constant(c) => c,
        ColorSource::Texture(_) => scene.textures.color(source, &scene.texture_point(surface)),
    }
}
