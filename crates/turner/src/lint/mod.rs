//! Warnings about scenes that can be rendered but are probably not what their author intended: no light, surfaces that
//! reflect more light than they receive, one sample per pixel with a physically based integrator, light paths that
//! multiply the render time.

#[cfg(test)]
mod tests;

use crate::color::{Spectrum, Transfer};
use crate::description::SceneDesc;
use crate::film::{Antialias, Aov, FilmDesc};
use crate::integrator::{Capabilities, Caustics, IntegratorDesc, Prepared};
use crate::light::{Light, LightDesc};
use crate::material::{Material, MaterialDesc, SpecularModel};
use crate::scene::Scene;
use crate::schema::value::Span;
use crate::schema::{ColorSource, Named, Remedy, Warning, WarningKind};

/// Colours up to this value count as 1 with rounding errors.
const ONE: f32 = 1.0 + 1e-4;

/// Light paths are reported if they multiply the work per sample by more than this factor.
const EXPENSIVE: f64 = 2.0;

/// The key that lights a scene with the built-in studio environment.
pub(crate) const STUDIO_KEY: &str = "studio.lights";

/// The section of this key.
pub(crate) const STUDIO_SECTION: &str = "[studio]";

fn doubt(message: String, span: Option<Span>) -> Warning {
    Warning { span, ..Warning::new(WarningKind::Doubtful, message) }
}

/// A warning about a scene that is not lit.
fn unlit(message: String) -> Warning {
    Warning::new(WarningKind::Ignored, message)
}

/// All warnings about a scene. `desc` is the description that it was prepared from.
pub fn lint(desc: &SceneDesc, prepared: &Prepared) -> Vec<Warning> {
    let capabilities = prepared.integrator.capabilities();
    let mut out = of_materials(desc, capabilities.physical);
    out.extend(black_environment(&prepared.scene));
    out.extend(of_labels(desc, capabilities));
    out.extend(of_aovs(&prepared.scene, &prepared.view.film, prepared.integrator.name(), capabilities));
    out.extend(with_findings(desc, prepared));
    out
}

/// The warnings for which the doctor has findings of its own.
pub(crate) fn with_findings(desc: &SceneDesc, prepared: &Prepared) -> Vec<Warning> {
    let capabilities = prepared.integrator.capabilities();
    let mut out = of_film(&prepared.view.film, prepared.integrator.name(), capabilities);
    out.extend(of_lights(&prepared.scene, desc, capabilities));
    out.extend(of_caustics(desc, prepared));
    out
}

/// A warning about AOVs that have no values, and about shadow catchers that are ordinary objects.
fn of_aovs(scene: &Scene, film: &FilmDesc, integrator: &str, capabilities: Capabilities) -> Option<Warning> {
    let of_paths = |aov: &Aov| aov.is_light() || matches!(aov, Aov::Cost | Aov::Shadow);
    let mut lost: Vec<String> =
        film.aovs.iter().filter(of_paths).map(|aov| format!("the AOV \"{}\"", aov.word())).collect();
    let catches = !scene.shadow_catchers.is_empty() && !capabilities.debug;
    lost.extend(catches.then(|| "the shadow on shadow catchers".to_owned()));
    let why = if !capabilities.splits_light {
        format!("the integrator \"{integrator}\" does not know")
    } else if film.antialias == Antialias::Adaptive {
        "adaptive anti-aliasing, which has no samples of its own in each pixel, does not know".to_owned()
    } else {
        return None;
    };
    let remedy = if capabilities.splits_light {
        Remedy::set("film.antialias", "monte-carlo")
    } else {
        Remedy::set("integrator.type", "path")
    };
    let message = format!("{why} {}", lost.join(", "));
    (!lost.is_empty())
        .then(|| Warning { remedy: Some(remedy), ..Warning::new(WarningKind::Ignored, message) })
}

/// Warnings about colours and emission of materials. They apply to physically based integrators only.
fn of_materials(scene: &SceneDesc, physical: bool) -> Vec<Warning> {
    let mut out = Vec::new();
    if !physical {
        return out;
    }
    let first = |is: &dyn Fn(&MaterialDesc) -> bool| {
        let found = scene.materials.iter().find(|m| is(&m.value));
        let Some(Named { name, span, .. }) = found else { return (String::new(), None) };
        (name.as_ref().map_or_else(String::new, |name| format!(" (\"{name}\")")), *span)
    };
    let bright: usize = scene.materials.iter().map(|m| colors_above_one(&m.value)).sum();
    if bright > 0 {
        let (name, span) = first(&|m| colors_above_one(m) > 0);
        let message = format!(
            "{} above 1{name}: a surface cannot reflect more light than it receives, so 1 is used",
            plural(bright, "material colour is", "material colours are")
        );
        out.push(doubt(message, span));
    }
    let wrong = scene.materials.iter().filter(|m| has_unsound_emission(&m.value)).count();
    if wrong > 0 {
        let (name, span) = first(&has_unsound_emission);
        let message = format!(
            "the emission of {}{name} is negative, too large or NaN: 0 or the largest valid value is used",
            plural(wrong, "material", "materials")
        );
        out.push(doubt(message, span));
    }
    out
}

fn plural(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// The number of constant colours of reflection and transmission above 1.
fn colors_above_one(material: &MaterialDesc) -> usize {
    let Some(m) = material.principled() else { return 0 };
    // glTF's colour is a factor of F₀.
    let specular = match m.specular_model {
        SpecularModel::OpenPbr => m.specular_color,
        SpecularModel::Gltf => ColorSource::Constant(Spectrum::WHITE),
    };
    let colors = [
        m.base_color,
        specular,
        m.transmission_color,
        m.transmission_tint,
        m.subsurface_color,
        m.coat_color,
        m.fuzz_color,
    ];
    let above = |source: &ColorSource| matches!(source, ColorSource::Constant(c) if c.max_component() > ONE);
    colors.iter().filter(|c| above(c)).count()
}

fn has_unsound_emission(material: &MaterialDesc) -> bool {
    material.principled().is_some_and(|m| m.sound_emission() != (m.emission_luminance, m.emission_color))
}

fn is_black_environment(light: &Light) -> bool {
    matches!(light, Light::Environment(e) if e.is_black())
}

fn black_environment(scene: &Scene) -> Option<Warning> {
    let message = "the environment light is black: it lights nothing. Check its image and `strength`";
    scene.lights.iter().any(is_black_environment).then(|| doubt(message.to_owned(), None))
}

/// Film settings that are ignored because IDs cannot be averaged.
fn of_labels(desc: &SceneDesc, capabilities: Capabilities) -> Option<Warning> {
    let asks = desc.film.antialias != Antialias::None || desc.film.samples != FilmDesc::default().samples;
    if !capabilities.labels || !asks {
        return None;
    }
    let message = format!(
        "\"{}\" takes one sample through the centre of each pixel: IDs cannot be averaged, so `antialias` and `samples` are ignored",
        desc.integrator.type_name()
    );
    Some(Warning::new(WarningKind::Note, message))
}

/// Film settings that are unsuitable for physically based light transport.
fn of_film(film: &FilmDesc, integrator: &str, capabilities: Capabilities) -> Vec<Warning> {
    let mut out = Vec::new();
    if !capabilities.physical {
        return out;
    }
    let warn = |message: String, remedy| Warning { remedy: Some(remedy), ..doubt(message, None) };
    if takes_one_sample(film) {
        let samples = FilmDesc::default_for(integrator).samples;
        let message = format!(
            "`antialias = \"{}\"` takes one sample per pixel: a picture by \"{integrator}\" is noisy. Use \"monte-carlo\" with {samples} samples or more",
            film.antialias.word()
        );
        let remedy = Remedy::set("film.antialias", "monte-carlo").and("film.samples", samples);
        out.push(warn(message, remedy));
    }
    if film.transfer == Transfer::None {
        let message = "`transfer = \"none\"` writes light to the picture without the sRGB curve: on a display it looks too dark. Use \"srgb\"; EXR and HDR files are not affected";
        out.push(warn(message.to_owned(), Remedy::set("film.transfer", "srgb")));
    }
    out
}

/// Whether each pixel gets only one sample.
pub(crate) fn takes_one_sample(film: &FilmDesc) -> bool {
    matches!(film.antialias, Antialias::None | Antialias::Mean)
}

/// A scene in which nothing emits light.
fn of_lights(scene: &Scene, desc: &SceneDesc, capabilities: Capabilities) -> Option<Warning> {
    if capabilities.debug || scene.primitives.is_empty() {
        return None;
    }
    let black = scene.lights.iter().filter(|l| is_black_environment(l)).count();
    let off = desc.lights.iter().filter(|l| !l.hidden && is_off(&l.value)).count();
    let emitting = scene.lights.len() + usize::from(!scene.ambient.is_black()) > black + off;
    if emitting || surfaces_emit(scene) {
        return None;
    }
    let background = !scene.background.color.is_black()
        || scene.background.zenith.is_some_and(|zenith| !zenith.is_black());
    if capabilities.physical {
        return (!background).then(|| no_light(desc));
    }
    Some(unlit(match off + black {
        0 if !desc.lights.is_empty() => "all lights of the scene are hidden: show one of them".to_owned(),
        0 => "the scene has no [[light]]: surfaces are black unless they reflect the background. Add a light"
            .to_owned(),
        _ => "all lights of the scene are black or have intensity 0: raise the intensity of one".to_owned(),
    }))
}

fn no_light(desc: &SceneDesc) -> Warning {
    let has_lights = desc.lights.iter().any(|light| !light.hidden);
    if !has_lights && !desc.lights.is_empty() {
        return unlit(
            "all lights of the scene are hidden, so the picture is black. Show one of them".to_owned(),
        );
    }
    let what = if has_lights {
        "all lights of the scene are black or have strength 0, so the picture is black"
    } else if desc.imports.is_empty() {
        "nothing in the scene emits light, so the picture is black"
    } else {
        "nothing in the scene emits light, so the picture is black: the model brings no light with it"
    };
    if has_lights {
        return unlit(format!("{what}. Raise the strength of one"));
    }
    if !can_have_studio(desc) {
        return unlit(format!("{what}. Add a [[light]], a material with emission or a [background]"));
    }
    let message = format!(
        "{what}. Add a [[light]], a material with emission or a [background]; a {STUDIO_SECTION} section adds the built-in studio light"
    );
    Warning { remedy: Some(Remedy::set(STUDIO_KEY, true)), ..unlit(message) }
}

/// Whether the built-in studio can be suggested: the scene has no `[studio]` and no lights.
pub(crate) fn can_have_studio(desc: &SceneDesc) -> bool {
    desc.studio.is_none() && desc.lights.is_empty()
}

/// Light paths that `caustics = "auto"` chose and that take most of the time.
fn of_caustics(desc: &SceneDesc, prepared: &Prepared) -> Option<Warning> {
    let [work, contribution, light_paths_only] = expensive_caustics(desc, prepared)?;
    let loss = match light_paths_only {
        a if a < 5e-4 => format!(
            "`caustics = \"off\"` avoids that: caustics, {:.1} % of the light, then have more noise",
            100.0 * contribution
        ),
        _ => format!(
            "`caustics = \"off\"` avoids that and loses caustics: {:.1} % of the light is found by light paths alone",
            100.0 * light_paths_only
        ),
    };
    let message = format!("light paths for caustics multiply the work per sample by about {work:.0}. {loss}");
    let remedy = Some(Remedy::set("integrator.caustics", "off"));
    Some(Warning { remedy, ..Warning::new(WarningKind::Note, message) })
}

/// If `caustics = "auto"` chose expensive light paths: the factor of the work per sample, and the fractions of the
/// picture's light that light paths contribute and that only they find. Estimates of the probe that made the choice.
pub(crate) fn expensive_caustics(desc: &SceneDesc, prepared: &Prepared) -> Option<[f64; 3]> {
    let IntegratorDesc::Path(path) = &desc.integrator else { return None };
    let price = prepared.path()?.caustics()?.price?;
    let is_expensive = path.caustics == Caustics::Auto && price.work > EXPENSIVE;
    is_expensive.then_some([price.work, price.contribution.min(1.0), price.light_paths_only.min(1.0)])
}

/// Whether any surface emits light.
fn surfaces_emit(scene: &Scene) -> bool {
    let emits: Vec<bool> = scene.materials.iter().map(|m| emits(m, scene)).collect();
    let ids = scene.primitives.iter().map(|p| p.material).chain(scene.face_materials());
    ids.into_iter().any(|id| emits.get(id.index()) == Some(&true))
}

fn emits(material: &Material, scene: &Scene) -> bool {
    match material {
        Material::Classic(_) => false,
        Material::Principled(m, _) => m.unlit || m.sound_emission().0 > 0.0,
        Material::OpenPbr(m) => m.desc.unlit || m.is_emissive(),
        Material::Mix(m) => m.shares().any(|(id, share)| {
            share > 0.0 && scene.materials.get(id.index()).is_some_and(|m| emits(m, scene))
        }),
    }
}

/// Whether the values of a light switch it off.
fn is_off(light: &LightDesc) -> bool {
    match light {
        LightDesc::Point(l) => l.intensity == 0.0 || l.color.is_black(),
        LightDesc::Directional(l) => l.intensity == 0.0 || l.color.is_black(),
        LightDesc::Spot(l) => l.intensity == 0.0 || l.color.is_black(),
        LightDesc::Rectangle(l) => l.intensity == 0.0 || l.color.is_black(),
        LightDesc::Disk(l) => l.intensity == 0.0 || l.color.is_black(),
        LightDesc::Sphere(l) => l.intensity == 0.0 || l.color.is_black(),
        // The caller checks the sum of ambient lights and the radiance of environments.
        LightDesc::Ambient(_) | LightDesc::Environment(_) | LightDesc::Sky(_) => false,
    }
}
