//! Materials as the preview sees them: constant BSDFs, and which lobes they have.

use crate::bsdf::Bsdf;
use crate::color::Spectrum;
use crate::material::{AlphaMode, Material, OpenPbr};
use crate::scene::Scene;
use crate::schema::ColorSource;

/// The lobes of a BSDF.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lobes {
    /// Albedo of the diffuse base, reflected and transmitted.
    pub(super) diffuse: [Spectrum; 2],
    /// Approximate albedo of all other lobes at normal incidence.
    pub(super) specular: Spectrum,
    pub(super) roughness: f32,
    pub(super) has_delta: bool,
    pub(super) has_gloss: bool,
}

impl Lobes {
    pub(super) fn of(bsdf: &Bsdf<'_>) -> Lobes {
        let diffuse = bsdf.diffuse_albedos();
        if bsdf.as_lambert().is_some() {
            return Lobes { diffuse, roughness: 1.0, ..Lobes::default() };
        }
        let all = bsdf.albedo_hint();
        let specular = (all - diffuse[0] - diffuse[1]).map(|v| v.clamp(0.0, 1.0));
        let (has_delta, has_gloss) = (bsdf.has_delta(), bsdf.has_gloss());
        // The floor is Fresnel reflection, which the sum above may hide.
        let specular = if has_gloss { specular.map(|v| v.max(0.02)) } else { specular };
        Lobes { diffuse, specular, roughness: bsdf.gloss_roughness() as f32, has_delta, has_gloss }
    }

    /// Albedo of the diffuse base.
    pub(super) fn albedo(&self) -> Spectrum {
        self.diffuse[0] + self.diffuse[1]
    }

    /// Whether light can be sampled.
    pub(super) fn is_smooth(&self) -> bool {
        self.has_gloss || !self.albedo().is_black()
    }
}

/// A material whose BSDF is the same everywhere, from outside and from inside.
struct Look {
    sides: [(Bsdf<'static>, Lobes); 2],
    /// Whether nothing is seen beside or behind the surface, and the shading normal is that of the shape.
    is_plain: bool,
}

/// The materials of a scene, by id.
#[derive(Default)]
pub(super) struct Looks(Vec<Option<Look>>);

impl Looks {
    pub(super) fn of(scene: &Scene) -> Looks {
        let look = |material: &Material| {
            let Material::OpenPbr(m) = material else { return None };
            let side = |outside: bool| {
                let bsdf = m.constant_bsdf(outside)?.without_walk();
                Some((bsdf, Lobes::of(&bsdf)))
            };
            let sides = [side(true)?, side(false)?];
            let d = &m.desc;
            let is_plain = (d.alpha_mode != AlphaMode::Blend
                || d.opacity == ColorSource::Constant(Spectrum::WHITE))
                && !(m.boundary || d.unlit || m.is_emissive())
                && d.bump().is_none()
                && d.normal_map.is_none()
                && sides.iter().all(|(_, lobes)| !lobes.has_delta);
            Some(Look { sides, is_plain })
        };
        Looks(scene.materials.iter().map(look).collect())
    }

    /// The BSDF of a material and its lobes, if they are constant.
    #[inline]
    pub(super) fn get(&self, material: usize, outside: bool) -> Option<&(Bsdf<'static>, Lobes)> {
        let look = self.0.get(material)?.as_ref()?;
        Some(&look.sides[usize::from(!outside)])
    }

    /// Both sides of a material that is the same everywhere, with nothing seen beside or behind it.
    #[inline]
    pub(super) fn plain(&self, material: usize) -> Option<&[(Bsdf<'static>, Lobes); 2]> {
        self.0.get(material)?.as_ref().filter(|look| look.is_plain).map(|look| &look.sides)
    }
}

/// Absorption coefficients inside a solid, from the colour that is left after its depth (Beer–Lambert law).
pub(super) fn absorption(
    scene: &Scene,
    material: &OpenPbr,
    at: &crate::texture::TexturePoint<'_>,
) -> [f32; 3] {
    let depth = material.desc.transmission_depth;
    if depth <= 0.0 {
        return [0.0; 3];
    }
    let left = scene.textures.color(material.desc.transmission_color, at);
    left.to_array()
        .map(|v| (-crate::math::elementary::ln(f64::from(v).clamp(1e-10, 1.0)) / depth).min(1e30) as f32)
}
