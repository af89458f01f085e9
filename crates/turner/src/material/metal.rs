//! Metals.

use super::PrincipledMaterial;
use super::metals::{MetalName, colors_of_index};
use crate::color::Spectrum;
use crate::schema::{ColorSource, Range, params};

params! {
    /// A metal: by its name, by its index of refraction, or by a colour. A colour goes before an index, an index before a name.
    pub struct MetalMaterial as "metal" {
        /// Which metal.
        name: MetalName = MetalName::Aluminium;
        /// Real part of the index of refraction, with `k`.
        eta: Option<Spectrum> = None, in Range::NON_NEGATIVE;
        /// Imaginary part of the index of refraction.
        k: Option<Spectrum> = None, in Range::NON_NEGATIVE;
        /// Colour seen head-on.
        color: Option<ColorSource> = None, in Range::NON_NEGATIVE;
        /// 0 is a mirror. The width of the highlight is its square.
        roughness: ColorSource = ColorSource::Constant(Spectrum::grey(0.2)), in Range::UNIT;
        /// How much longer highlights are along the tangent than across.
        anisotropy: ColorSource = ColorSource::Constant(Spectrum::BLACK), in Range::UNIT;
        /// A picture of normals in the tangent frame (red along u, green along v), with `encoding = "linear"`.
        normal_map: Option<ColorSource> = None;
        /// Factor of its red and green parts.
        normal_scale: f64 = 1.0;
        /// A texture of heights that the normal follows as if the surface rose and fell with it: white stands highest.
        bump_map: Option<ColorSource> = None;
        /// How high white stands above black, scene units; below 0, how deep.
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
    /// The same in the terms of the physical material.
    pub fn principled(&self) -> PrincipledMaterial {
        let (color, tint) = match (self.color, self.eta, self.k) {
            (Some(color), _, _) => (color, Spectrum::WHITE),
            (None, None, None) => {
                let c = self.name.colors();
                (ColorSource::Constant(c.f0), c.tint)
            }
            (None, eta, k) => {
                let c = colors_of_index(eta.unwrap_or(Spectrum::WHITE), k.unwrap_or(Spectrum::BLACK));
                (ColorSource::Constant(c.f0), c.tint)
            }
        };
        PrincipledMaterial {
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
