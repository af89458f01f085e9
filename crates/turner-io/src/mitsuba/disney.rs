//! Mitsuba's `principled` and `principledthin` as Turner's Disney material.

use turner::material::{AlphaMode, BumpUnit, DisneyMaterial, MaterialDesc};
use turner::schema::ColorSource;

use super::assembly::Assembly;
use super::materials::{Use, color_of, grey, number_as, number_of};
use super::params::Object;
use super::spectra::{Role, index};
use crate::scene_import::report::Fault;
use crate::scene_import::{Through, map_values};

/// The material of a BSDF for a use.
pub(super) fn material(scene: &mut Assembly<'_>, object: &Object, usage: Use) -> Result<MaterialDesc, Fault> {
    let on = usage.surface;
    let thin_walled = object.kind == "principledthin";
    let mut number = |name, or| number_of(scene, object, name, or, on);
    let mut made = DisneyMaterial {
        roughness: number("roughness", 0.5)?,
        anisotropic: number("anisotropic", 0.0)?,
        spec_trans: number("spec_trans", 0.0)?,
        spec_tint: number("spec_tint", 0.0)?,
        sheen: number("sheen", 0.0)?,
        sheen_tint: number("sheen_tint", 0.0)?,
        flatness: number("flatness", 0.0)?,
        thin_walled,
        ..DisneyMaterial::default()
    };
    if thin_walled {
        // 2 is all light.
        let through = number_as(scene, object, ("diff_trans", 0.0), Role::Unbounded, on)?;
        made.diff_trans = map_values(&mut scene.stock, through, object.place, Through::Scale(0.5));
        made.ior = index(object, "eta", 1.5)?;
    } else {
        made.metallic = number("metallic", 0.0)?;
        made.clearcoat = number("clearcoat", 0.0)?;
        made.clearcoat_gloss = number("clearcoat_gloss", 0.0)?;
        made.ior = if object.has("eta") {
            index(object, "eta", 1.5)?
        } else {
            let specular = object.float("specular")?.unwrap_or(0.5).clamp(1e-3, 1.0);
            2.0 / (1.0 - (0.08 * specular).sqrt()) - 1.0
        };
    }
    made.ior = made.ior.clamp(1e-3, 100.0);
    made.base_color = color_of(scene, object, "base_color", 0.5, on)?;
    // How Mitsuba chooses among the lobes.
    object.pass(&[
        "main_specular_sampling_rate",
        "clearcoat_sampling_rate",
        "diffuse_reflectance_sampling_rate",
        "diff_trans_sampling_rate",
        "specular_reflectance_sampling_rate",
        "specular_transmittance_sampling_rate",
    ]);
    scene.finish(object);
    Ok(MaterialDesc::Disney(with_use(made, usage)))
}

/// Adds sides, emission, opacity, bump map and normal map.
fn with_use(mut made: DisneyMaterial, usage: Use) -> DisneyMaterial {
    let transmits = made.spec_trans != grey(0.0) || made.thin_walled;
    made.front_only = !usage.two_sided && !transmits;
    if transmits || usage.opacity.is_some() {
        made.interior = usage.interior;
    }
    made.alpha_mode = AlphaMode::Opaque;
    if let Some(opacity) = usage.opacity {
        (made.opacity, made.alpha_mode) = (opacity, AlphaMode::Blend);
    }
    if let Some((heights @ ColorSource::Texture(_), scale)) = usage.bump {
        (made.bump_map, made.bump_scale) = (Some(heights), f64::from_bits(scale));
        made.bump_unit = BumpUnit::Scene;
    }
    if let Some(normals @ ColorSource::Texture(_)) = usage.normal {
        made.normal_map = Some(normals);
    }
    if let Some(emission) = usage.emission {
        made.emission_luminance = 1.0;
        made.emission_color = emission.radiance;
        made.emission_front_only = true;
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uses_change_sides_and_opacity() {
        let plain = with_use(DisneyMaterial::default(), Use::default());
        assert!(plain.front_only && plain.alpha_mode == AlphaMode::Opaque);
        let both = Use { two_sided: true, opacity: Some(grey(0.5)), ..Use::default() };
        let shown = with_use(DisneyMaterial::default(), both);
        assert!(!shown.front_only && shown.alpha_mode == AlphaMode::Blend && shown.opacity == grey(0.5));
        let glass = DisneyMaterial { spec_trans: grey(1.0), ..plain };
        assert!(!with_use(glass, Use::default()).front_only);
    }
}
