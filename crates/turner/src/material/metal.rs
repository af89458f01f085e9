//! Metals.

use super::PrincipledMaterial;
use super::metals::{MetalName, colors_of_index};
use crate::color::Spectrum;
use crate::schema::{ColorSource, Range, params};

params! {
    /// A metal: by name, by index of refraction, or by colour. `color` takes precedence over `eta` and `k`, and these
    /// over `name`.
    pub struct MetalMaterial as "metal" {
        /// The metal.
        name: MetalName = MetalName::Aluminium;
        /// Real part of the index of refraction, by colour; use it with `k`.
        eta: Option<Spectrum> = None, in Range::NON_NEGATIVE;
        /// Imaginary part of the index of refraction (extinction coefficient), by colour.
        k: Option<Spectrum> = None, in Range::NON_NEGATIVE;
        /// Reflectance at normal incidence.
        color: Option<ColorSource> = None, in Range::NON_NEGATIVE;
        /// Roughness: 0 is a perfect mirror, 1 very rough. The GGX α is its square.
        roughness: ColorSource = ColorSource::Constant(Spectrum::grey(0.2)), in Range::UNIT;
        /// Elongation of highlights along the tangent: 0 is isotropic, 1 extremely anisotropic.
        anisotropy: ColorSource = ColorSource::Constant(Spectrum::BLACK), in Range::UNIT;
        /// Normal map in tangent space: red along u, green along v. Use an image with `encoding = "linear"`.
        normal_map: Option<ColorSource> = None;
        /// Strength of the normal map: factor of red and green.
        normal_scale: f64 = 1.0;
        /// Bump map: a texture of heights, white is high. It changes the shading normal, not the shape.
        bump_map: Option<ColorSource> = None;
        /// Height of white above black in scene units; negative inverts.
        bump_scale: f64 = 0.1;
    }
    example r##"[material.ring]
type = "metal"
name = "gold"
roughness = 0.15

[[object]]
type = "sphere"
material = "ring"
"##
}

impl MetalMaterial {
    /// The equivalent OpenPBR material.
    pub fn principled(&self) -> PrincipledMaterial {
        let has_index = self.color.is_none();
        let (color, tint) = match (self.color, self.eta, self.k) {
            (Some(color), _, _) => (color, Spectrum::WHITE),
            (None, None, None) => {
                let c = self.name.colors();
                (ColorSource::Constant(c.f0), c.tint)
            }
            (None, eta, k) => {
                let c = colors_of_index(eta.unwrap_or(Spectrum::WHITE), k.unwrap_or(Spectrum::BLACK));
                // The colour for what knows no index.
                (ColorSource::Constant(c.f0), Spectrum::WHITE)
            }
        };
        PrincipledMaterial {
            metal_eta: self.eta.filter(|_| has_index),
            metal_k: self.k.filter(|_| has_index),
            base_color: color,
            base_metalness: ColorSource::Constant(Spectrum::WHITE),
            specular_color: ColorSource::Constant(tint),
            specular_roughness: self.roughness,
            specular_roughness_anisotropy: self.anisotropy,
            normal_map: self.normal_map,
            normal_scale: self.normal_scale,
            bump_map: self.bump_map,
            bump_scale: self.bump_scale,
            ..PrincipledMaterial::default()
        }
    }
}
