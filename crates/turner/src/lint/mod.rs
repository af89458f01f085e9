//! What a scene says that is unlikely to be meant: surfaces that return more light than arrives, and nothing that shines.

use crate::description::SceneDesc;
use crate::film::Antialias;
use crate::integrator::{Capabilities, IntegratorDesc, Prepared};
use crate::light::{Light, LightDesc};
use crate::material::{Material, MaterialDesc};
use crate::scene::Scene;
use crate::schema::{ColorSource, Warning, WarningKind};

/// Colours up to here are 1 but for rounding.
const ONE: f32 = 1.0 + 1e-4;

fn doubt(message: String) -> Warning {
    Warning::new(WarningKind::Doubtful, message)
}

/// Objects that were asked for are not seen.
fn unlit(message: &str) -> Warning {
    Warning::new(WarningKind::Ignored, message)
}

/// What there is to say about a scene and what it was prepared from.
pub fn lint(desc: &SceneDesc, prepared: &Prepared) -> Vec<Warning> {
    let capabilities = prepared.integrator.capabilities();
    let mut out = of_description(desc, capabilities.physical);
    out.extend(of_scene(&prepared.scene, desc, capabilities));
    out
}

/// About the description; `physical` if materials are taken as physical ones.
fn of_description(scene: &SceneDesc, physical: bool) -> Vec<Warning> {
    let mut out = Vec::new();
    if physical {
        let bright: usize = scene.materials.iter().map(|m| colors_above_one(&m.value)).sum();
        if bright > 0 {
            out.push(doubt(format!(
                "{bright} colours of materials are above 1: no surface returns more light than it gets, they count as 1"
            )));
        }
        let wrong = scene.materials.iter().filter(|m| shines_wrongly(&m.value)).count();
        if wrong > 0 {
            out.push(doubt(format!(
                "the emission of {wrong} materials is negative, too large or no number: it counts as 0 or as the largest there is"
            )));
        }
    }
    out
}

/// Constant colours of what a material reflects or lets through.
fn colors_above_one(material: &MaterialDesc) -> usize {
    let Some(m) = material.principled() else { return 0 };
    let colors = [
        m.base_color,
        m.specular_color,
        m.transmission_color,
        m.subsurface_color,
        m.coat_color,
        m.fuzz_color,
    ];
    let above = |source: &ColorSource| matches!(source, ColorSource::Constant(c) if c.max_component() > ONE);
    colors.iter().filter(|c| above(c)).count()
}

fn shines_wrongly(material: &MaterialDesc) -> bool {
    material.principled().is_some_and(|m| m.sound_emission() != (m.emission_luminance, m.emission_color))
}

/// What there is to say about a scene that is ready.
fn of_scene(scene: &Scene, desc: &SceneDesc, capabilities: Capabilities) -> Vec<Warning> {
    let mut out = Vec::new();
    let dark = scene.lights.iter().filter(|l| matches!(l, Light::Environment(e) if e.is_black())).count();
    if dark > 0 {
        out.push(doubt("the environment is black: no light comes from it".into()));
    }
    if matches!(desc.integrator, IntegratorDesc::Ids(_)) && desc.film.antialias != Antialias::None {
        let word = desc.film.antialias.word();
        out.push(doubt(format!(
            "antialias = \"{word}\" takes means of numbers of objects, which mean nothing: use \"none\""
        )));
    }
    if capabilities.debug || scene.primitives.is_empty() {
        return out;
    }
    let off = desc.lights.iter().filter(|l| is_off(&l.value)).count();
    let emissive = scene.lights.len() + usize::from(!scene.ambient.is_black()) > dark + off;
    if emissive || surfaces_shine(scene) {
        return out;
    }
    let around = !scene.background.color.is_black()
        || scene.background.zenith.is_some_and(|zenith| !zenith.is_black());
    if capabilities.physical {
        if !around {
            out.push(unlit("nothing in the scene shines, so that the picture is black: add a [[light]], a material with emission or a [background]"));
        }
    } else if off + dark > 0 {
        out.push(unlit("all lights of the scene are black"));
    } else {
        out.push(unlit("the scene has no [[light]]: whatever does not reflect the background is black"));
    }
    out
}

/// Whether any surface has light of its own.
fn surfaces_shine(scene: &Scene) -> bool {
    let shines: Vec<bool> = scene.materials.iter().map(|m| shines(m, scene)).collect();
    let ids = scene.primitives.iter().map(|p| p.material).chain(scene.face_materials());
    ids.into_iter().any(|id| shines.get(id.index()) == Some(&true))
}

fn shines(material: &Material, scene: &Scene) -> bool {
    match material {
        Material::Classic(_) => false,
        Material::Principled(m, _) => m.unlit || m.sound_emission().0 > 0.0,
        Material::OpenPbr(m) => m.desc.unlit || m.is_emissive(),
        Material::Mix(m) => m.shares().any(|(id, share)| {
            share > 0.0 && scene.materials.get(id.index()).is_some_and(|m| shines(m, scene))
        }),
    }
}

/// Whether a light is switched off by its own numbers.
fn is_off(light: &LightDesc) -> bool {
    match light {
        LightDesc::Point(l) => l.intensity == 0.0 || l.color.is_black(),
        LightDesc::Directional(l) => l.intensity == 0.0 || l.color.is_black(),
        LightDesc::Spot(l) => l.intensity == 0.0 || l.color.is_black(),
        LightDesc::Rectangle(l) => l.intensity == 0.0 || l.color.is_black(),
        LightDesc::Disk(l) => l.intensity == 0.0 || l.color.is_black(),
        LightDesc::Sphere(l) => l.intensity == 0.0 || l.color.is_black(),
        // An ambient light counts by its sum, an environment by its picture.
        LightDesc::Ambient(_) | LightDesc::Environment(_) | LightDesc::Sky(_) => false,
    }
}
