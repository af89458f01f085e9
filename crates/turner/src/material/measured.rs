//! Materials from measured BRDFs.

use super::open_pbr::Unlayered;
use super::{AlphaMode, BumpUnit, OpenPbr, PrincipledMaterial, ShadowKind};
use crate::bsdf::Measured;
use crate::color::Spectrum;
use crate::schema::{ColorSource, MeasuredFile, MediumId, Range, params};

/// A constant grey.
const fn grey(v: f32) -> ColorSource {
    ColorSource::Constant(Spectrum::grey(v))
}

params! {
    /// A measured BRDF: a table of how a real surface reflects light (Dupuy and Jakob 2018), as the RGL material database
    /// has for paints, fabrics, foils and metals. The integrator "classic" shows a
    /// principled material of similar colour and roughness.
    pub struct MeasuredMaterial as "measured" {
        /// Path of the BSDF file (`.bsdf`), relative to the scene file, with linear sRGB or with spectra.
        file: MeasuredFile, required, default MeasuredFile::default();
        /// Whether only the front face reflects light.
        front_only: bool = false;
        /// The medium behind a surface with holes (`opacity`). Only for the integrators "path" and "direct".
        interior: Option<MediumId> = None;
        /// Emitted radiance, a factor of `emission_color`.
        emission_luminance: f64 = 0.0, in Range::NON_NEGATIVE;
        /// Colour of the emission.
        emission_color: ColorSource = grey(1.0), in Range::NON_NEGATIVE;
        /// Whether only the front face emits.
        emission_front_only: bool = false;
        /// Opacity from 0 (transparent) to 1 (opaque); `alpha_mode` determines its use.
        opacity: ColorSource = grey(1.0), in Range::UNIT;
        /// How `opacity` is used.
        alpha_mode: AlphaMode = AlphaMode::Blend;
        /// Normal map in tangent space: red along u, green along v. Use an image with `encoding = "linear"`.
        normal_map: Option<ColorSource> = None;
        /// Strength of the normal map: factor of red and green.
        normal_scale: f64 = 1.0;
        /// Bump map: a texture of heights, white is high. It changes the shading normal, not the shape.
        bump_map: Option<ColorSource> = None;
        /// Height of white above black, in `bump_unit`; negative inverts.
        bump_scale: f64 = 0.1;
        /// The unit of `bump_scale`.
        bump_unit: BumpUnit = BumpUnit::Scene;
    }
    example r##"[material.paint]
type = "measured"
file = "chm_orange_rgb.bsdf"

[[object]]
type = "sphere"
material = "paint"
"##
}

impl MeasuredMaterial {
    /// A measured BRDF with the emission, opacity, interior, bump and normal maps of another material.
    pub fn with_use_of(file: MeasuredFile, used: PrincipledMaterial) -> MeasuredMaterial {
        MeasuredMaterial {
            file,
            front_only: used.front_only,
            interior: used.interior,
            emission_luminance: used.emission_luminance,
            emission_color: used.emission_color,
            emission_front_only: used.emission_front_only,
            opacity: used.opacity,
            alpha_mode: used.alpha_mode,
            normal_map: used.normal_map,
            normal_scale: used.normal_scale,
            bump_map: used.bump_map,
            bump_scale: used.bump_scale,
            bump_unit: used.bump_unit,
        }
    }

    /// A principled material of similar colour and roughness, for integrators and formats without this one.
    pub fn principled(&self) -> PrincipledMaterial {
        self.similar(&Measured::new(&self.file.data))
    }

    /// A single lobe of the same albedo is a metal's.
    fn similar(&self, tables: &Measured) -> PrincipledMaterial {
        PrincipledMaterial {
            base_color: ColorSource::Constant(tables.albedo_color()),
            base_metalness: grey(1.0),
            specular_roughness: grey(tables.roughness() as f32),
            // Directions are those of (u, v).
            specular_roughness_anisotropy: grey(if tables.is_anisotropic() { 0.5 } else { 0.0 }),
            interior: self.interior,
            front_only: self.front_only,
            emission_luminance: self.emission_luminance,
            emission_color: self.emission_color,
            emission_front_only: self.emission_front_only,
            opacity: self.opacity,
            alpha_mode: self.alpha_mode,
            normal_map: self.normal_map,
            normal_scale: self.normal_scale,
            bump_map: self.bump_map,
            bump_scale: self.bump_scale,
            bump_unit: self.bump_unit,
            soften_terminator: false,
            ..PrincipledMaterial::default()
        }
    }
}

impl OpenPbr {
    /// A measured material.
    pub(crate) fn measured(desc: &MeasuredMaterial) -> OpenPbr {
        let tables = Box::new(Measured::new(&desc.file.data));
        let mut made = OpenPbr::new(desc.similar(&tables));
        let see_through = made.desc.alpha_mode == AlphaMode::Blend && made.desc.opacity != grey(1.0);
        made.shadow = if see_through { ShadowKind::Tinted } else { ShadowKind::Opaque };
        (made.pane, made.casts_caustics, made.near_specular) = (false, false, false);
        (made.constant, made.textured_base, made.metal_index) = (None, None, None);
        (made.is_opaque_base, made.is_plain, made.is_plain_outside) = (false, false, false);
        made.unlayered = Some(Unlayered::Measured { tables, front_only: desc.front_only });
        made
    }
}
