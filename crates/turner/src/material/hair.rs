//! Hair and fur.

use super::{MaterialEvalContext, OpenPbr, PrincipledMaterial};
use crate::bsdf::{Bsdf, HairPoint, color_of_sigma_a, sigma_a_of_color, sigma_a_of_melanin};
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
    /// A thin diffuse wall of about the same colour and roughness, for integrators and formats without hair.
    pub fn principled(&self) -> PrincipledMaterial {
        let grey = |v: f64| ColorSource::Constant(Spectrum::grey(v as f32));
        let color = match (self.sigma_a, self.color) {
            (None, Some(color)) => color,
            _ => ColorSource::Constant(color_of_sigma_a(self.absorption(None), self.beta_n)),
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

    /// The BSDF at a surface point.
    pub(super) fn bsdf(&self, scene: &impl MaterialEvalContext, surface: &SurfaceInteraction) -> Bsdf {
        let at = scene.texture_point(surface);
        Bsdf::hair(&HairPoint {
            sigma_a: self.absorption(self.color.map(|c| scene.textures().color(c, &at))),
            h: 2.0 * at.uv.y - 1.0,
            beta_m: self.beta_m,
            beta_n: self.beta_n,
            alpha: self.alpha,
            ior: self.ior,
        })
    }
}

impl OpenPbr {
    /// Hair.
    pub(crate) fn hair(desc: &HairMaterial) -> OpenPbr {
        let mut made = OpenPbr::new(desc.principled());
        made.hair = Some(Box::new(desc.clone()));
        (made.casts_caustics, made.near_specular) = (false, false);
        // Its BSDF depends on where the fibre is hit.
        (made.constant, made.textured_base) = (None, None);
        (made.is_opaque_base, made.is_plain) = (false, false);
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
