//! Hair and fur.

use super::open_pbr::Unlayered;
use super::{MaterialEvalContext, OpenPbr, PrincipledMaterial};
use crate::bsdf::{Bsdf, HairPoint, sigma_a_of_color, sigma_a_of_melanin};
use crate::color::Spectrum;
use crate::interaction::SurfaceInteraction;
use crate::math::{DVec3, Frame};
use crate::schema::{ColorSource, Range, params};

params! {
    /// Hair and fur (Chiang et al. 2016): light is reflected by fibres with tilted scales, passes through them and is
    /// absorbed inside. For the shape "curves", whose (u, v) it needs: u along the fibre, v across it. The colour is that
    /// of `sigma_a`, else of `color`, else of the two melanins. The integrator "classic" shows a diffuse surface.
    pub struct HairMaterial as "hair" {
        /// Concentration of eumelanin: 0.3 is blond, 1.3 brown, 8 black.
        eumelanin: f64 = 1.3, in Range::closed(0.0, 1e6);
        /// Concentration of pheomelanin, which makes hair red.
        pheomelanin: f64 = 0.0, in Range::closed(0.0, 1e6);
        /// Colour of a mass of hair in white light, instead of melanin.
        color: Option<ColorSource> = None, in Range::NON_NEGATIVE;
        /// Absorption inside the fibre per radius of the fibre, by colour, instead of `color` and melanin.
        sigma_a: Option<Spectrum> = None, in Range::closed(0.0, 1e6);
        /// Roughness along the fibre: 0 is smooth, 1 very rough.
        beta_m: f64 = 0.3, in Range::UNIT;
        /// Roughness around the fibre: 0 is smooth, 1 very rough.
        beta_n: f64 = 0.3, in Range::UNIT;
        /// Angle in degrees by which the scales of the fibre are tilted towards its root.
        alpha: f64 = 2.0, in Range::closed(-30.0, 30.0);
        /// Index of refraction of the fibre.
        ior: f64 = 1.55, in Range::closed(1.0, 10.0);
    }
    example r##"[material.brown]
type = "hair"
eumelanin = 1.3
beta_m = 0.25

[[object]]
type = "curves"
points = [[0, -1, 0], [0.2, -0.3, 0], [-0.2, 0.4, 0], [0, 1, 0]]
width = 0.2
material = "brown"
"##
}

impl HairMaterial {
    /// A thin diffuse wall with about the albedo and roughness of a fibre, for integrators and formats without hair. A
    /// texture is used unchanged.
    pub fn principled(&self) -> PrincipledMaterial {
        let grey = |v: f64| ColorSource::Constant(Spectrum::grey(v as f32));
        let albedo = |color| ColorSource::Constant(Bsdf::hair(&self.point(color, 0.0)).albedo_hint());
        let color = match (self.sigma_a, self.color) {
            (None, Some(texture @ ColorSource::Texture(_))) => texture,
            (_, Some(ColorSource::Constant(color))) => albedo(Some(color)),
            _ => albedo(None),
        };
        PrincipledMaterial {
            base_color: color,
            subsurface_color: color,
            subsurface_weight: grey(0.3),
            base_diffuse_roughness: grey(self.beta_n),
            specular_roughness: grey(self.beta_m.max(0.1)),
            specular_ior: self.ior,
            thin_walled: true,
            soften_terminator: false,
            ..PrincipledMaterial::default()
        }
    }

    /// The absorption inside the fibre, where `color` has the given value.
    fn absorption(&self, color: Option<Spectrum>) -> [f64; 3] {
        match (self.sigma_a, color) {
            (Some(s), _) => s.to_array().map(f64::from),
            (None, Some(color)) => sigma_a_of_color(color, self.beta_n),
            (None, None) => sigma_a_of_melanin(self.eumelanin, self.pheomelanin),
        }
    }

    /// The parameters where `color` has the given value, at the offset `h`.
    fn point(&self, color: Option<Spectrum>, h: f64) -> HairPoint {
        HairPoint {
            sigma_a: self.absorption(color),
            h,
            beta_m: self.beta_m,
            beta_n: self.beta_n,
            alpha: self.alpha,
            ior: self.ior,
        }
    }

    /// The BSDF at a surface point.
    pub(super) fn bsdf(
        &self,
        scene: &impl MaterialEvalContext,
        surface: &SurfaceInteraction,
    ) -> Bsdf<'static> {
        let at = scene.texture_point(surface);
        let color = self.color.map(|c| scene.textures().color(c, &at));
        Bsdf::hair(&self.point(color, 2.0 * at.uv.y - 1.0))
    }
}

impl OpenPbr {
    /// Hair.
    pub(crate) fn hair(desc: &HairMaterial) -> OpenPbr {
        let mut made = OpenPbr::new(desc.principled());
        made.unlayered = Some(Unlayered::Hair(Box::new(desc.clone())));
        (made.casts_caustics, made.near_specular) = (false, false);
        // Its BSDF depends on where the fibre is hit.
        (made.constant, made.textured_base) = (None, None);
        (made.is_opaque_base, made.is_plain, made.is_plain_outside) = (false, false, false);
        made
    }

    /// The frame of a hair: x along it, z perpendicular to it on the side of `wo`.
    pub(super) fn hair_frame(
        scene: &impl MaterialEvalContext,
        surface: &SurfaceInteraction,
        wo: DVec3,
    ) -> Frame {
        let x = scene.tangent_frame(surface, 0).map_or_else(|| Frame::from_z(surface.ns).x, |(x, _)| x);
        let z = (wo - x * wo.dot(x)).try_normalize().unwrap_or_else(|| x.any_orthonormal_vector());
        Frame { x, y: z.cross(x), z }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Integrators without hair show a fibre's own albedo, which is brighter than a mass of such hair.
    #[test]
    fn the_wall_has_the_albedo_of_a_fibre() {
        let of = |hair: HairMaterial| match hair.principled().base_color {
            ColorSource::Constant(c) => c,
            ColorSource::Texture(_) => panic!("no texture was given"),
        };
        let white = of(HairMaterial { eumelanin: 0.0, ..HairMaterial::default() });
        assert!((white - Spectrum::WHITE).map(f32::abs).max_component() < 1e-4, "{white:?}");
        let brown = of(HairMaterial::default());
        assert!(brown.r > 0.2 && brown.r < 0.5 && brown.b > 0.05 && brown.b < brown.r, "{brown:?}");
        let color = Spectrum::new(0.1, 0.3, 0.5);
        let of_color =
            of(HairMaterial { color: Some(ColorSource::Constant(color)), ..HairMaterial::default() });
        assert!(of_color.r > color.r && of_color.r < of_color.b && of_color.b > color.b, "{of_color:?}");
    }
}
