//! Subsurface scattering: the medium inside a material with `subsurface_weight`.

use super::{Material, OpenPbr, PrincipledMaterial, color_at};
use crate::color::Spectrum;
use crate::interaction::SurfaceInteraction;
use crate::material::MaterialEvalContext;
use crate::medium::Homogeneous;
use crate::schema::ColorSource;

/// The mean cosine of scattering is clamped to ± this value.
const MAX_ANISOTROPY: f64 = 0.999;

impl PrincipledMaterial {
    /// Whether light enters anywhere and is scattered inside.
    pub(crate) fn has_subsurface(&self) -> bool {
        let any = |source: ColorSource| !matches!(source, ColorSource::Constant(c) if c.is_black());
        let all = |source: ColorSource| matches!(source, ColorSource::Constant(c) if c == Spectrum::WHITE);
        !self.thin_walled
            && !self.unlit
            && any(self.subsurface_weight)
            && self.subsurface_radius > 0.0
            && any(self.subsurface_radius_scale)
            && !all(self.base_metalness)
            && !all(self.transmission_weight)
    }
}

impl OpenPbr {
    /// The medium inside, from the colours at a surface point; mean free paths are at least `shortest`.
    pub(crate) fn body(
        &self,
        scene: &impl MaterialEvalContext,
        surface: &SurfaceInteraction,
        shortest: f64,
    ) -> Homogeneous {
        let d = &self.desc;
        let color = color_at(d.subsurface_color, scene, surface);
        let scale = color_at(d.subsurface_radius_scale, scene, surface);
        // Texture values can be NaN.
        let sound = |v: f32| if v > 0.0 { v.min(1.0) } else { 0.0 };
        let mean_free_paths = scale.to_array().map(|s| {
            let mean_free_path = d.subsurface_radius * f64::from(s);
            if mean_free_path > shortest { mean_free_path.min(1e30) } else { shortest }
        });
        let g = d.subsurface_scatter_anisotropy.clamp(-MAX_ANISOTROPY, MAX_ANISOTROPY);
        Homogeneous::of_body(color.map(sound), mean_free_paths, g)
    }
}

impl Material {
    /// Whether it, or any part of a mix, has subsurface scattering.
    pub(crate) fn has_subsurface(&self, scene: &impl MaterialEvalContext) -> bool {
        match self {
            Material::OpenPbr(m) => m.walks,
            Material::Mix(m) => m.walks(scene),
            Material::Classic(_) | Material::Principled(..) => false,
        }
    }
}
