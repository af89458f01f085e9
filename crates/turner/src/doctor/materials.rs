//! Properties of materials that the rules need, known without tracing rays.

use crate::color::Spectrum;
use crate::description::SceneDesc;
use crate::material::{AlphaMode, Material, MaterialDesc, PrincipledMaterial, ShadowKind};
use crate::scene::Scene;
use crate::schema::{ColorSource, MaterialId};

/// Whether a material emits light on one side (`outside`: the front), or is unlit.
pub(super) fn emits_at(scene: &Scene, id: MaterialId, outside: bool) -> bool {
    match scene.materials.get(id.index()) {
        Some(Material::OpenPbr(m)) => m.desc.unlit || m.is_emissive() && (outside || m.emits_backwards()),
        Some(Material::Principled(m, _)) => m.unlit,
        Some(m) => m.is_emissive(scene),
        None => false,
    }
}

/// Whether a material transmits light, with or without refraction.
pub(super) fn transmits(scene: &Scene, id: MaterialId) -> bool {
    match scene.materials.get(id.index()) {
        Some(Material::OpenPbr(m)) => m.desc.is_transmissive(),
        Some(Material::Principled(m, _)) => m.is_transmissive(),
        Some(Material::Classic(m)) => m.k_refract > 0.0,
        Some(Material::Mix(_)) | None => false,
    }
}

/// Whether a material is opaque.
pub(super) fn is_opaque(scene: &Scene, id: MaterialId) -> bool {
    let shadow = scene.materials.get(id.index()).map(|m| m.shadow());
    shadow == Some(ShadowKind::Opaque) && !transmits(scene, id)
}

/// The principled form of a material of the description.
pub(super) fn principled(desc: &SceneDesc, id: MaterialId) -> Option<PrincipledMaterial> {
    desc.materials.get(id.index())?.value.principled()
}

/// The opacity of a material that is always fully transparent; `None` for others.
pub(super) fn invisible(material: &MaterialDesc) -> Option<f64> {
    // Interfaces of media are invisible by design.
    if matches!(material, MaterialDesc::Interface(_)) {
        return None;
    }
    let m = material.principled()?;
    let ColorSource::Constant(opacity) = m.opacity else { return None };
    let opacity = f64::from(opacity.max_component());
    let gone = match m.alpha_mode {
        AlphaMode::Opaque => false,
        AlphaMode::Mask => opacity < m.alpha_cutoff,
        AlphaMode::Blend => opacity < 0.002,
    };
    gone.then_some(opacity)
}

/// The distance after which white light has the colour of a transparent material; `None` if it does not absorb.
pub(super) fn absorbing_depth(material: &Material) -> Option<f64> {
    match material {
        Material::OpenPbr(m) => Some(m.desc.transmission_depth).filter(|d| *d > 0.0),
        _ => None,
    }
}

/// Whether a material of the description emits light.
pub(super) fn is_emissive(material: &MaterialDesc) -> bool {
    material.principled().is_some_and(|m| {
        m.emission_luminance > 0.0 && m.emission_color != ColorSource::Constant(Spectrum::BLACK)
    })
}
