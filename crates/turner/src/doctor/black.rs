//! Rules for black and dark pictures: no light, too little light, settings that remove light.

use super::evidence::Evidence;
use super::finding::{Finding, Question, Severity, percent, rounded, short};
use super::lights::LightFacts;
use super::materials;
use super::picture::{quantile, show};
use super::trial::Trial;
use crate::integrator::{IntegratorDesc, LightSampling};
use crate::light::{Light, LightDesc};
use crate::lint::{STUDIO_KEY, STUDIO_SECTION, can_have_studio};
use crate::math::elementary::ln;
use crate::schema::Remedy;

const BLACK: Question = Question::Black;

pub(super) fn check(e: &Evidence<'_>, out: &mut Vec<Finding>) {
    if e.picture.light.is_empty() || e.scene.stats.primitives == 0 {
        return;
    }
    let before = out.len();
    out.extend(dark(e));
    let is_dark = out.len() > before;
    out.extend(settings(e));
    if !is_dark {
        out.extend(exposure(e));
        out.extend(too_dim(e));
        out.extend(black_materials(e));
    }
}

/// A scene in which nothing emits light.
fn dark(e: &Evidence<'_>) -> Option<Finding> {
    let scene = e.scene;
    let background =
        !scene.background.color.is_black() || scene.background.zenith.is_some_and(|z| !z.is_black());
    let shapes = scene.emitter_list().len() > scene.lights.len() || e.hits().any(|(_, _, m)| m.emits);
    let unsampled = scene.integrator.capabilities().physical && any_material_emits(e);
    let physical = scene.integrator.capabilities().physical;
    if shapes || unsampled || !scene.ambient.is_black() || physical && background {
        return None;
    }
    let (mut off, mut on) = (Vec::new(), 0);
    for (i, light) in e.desc.lights.iter().enumerate() {
        match strength(&light.value) {
            _ if light.hidden => off.push(i),
            Some(strength) if strength <= 0.0 => off.push(i),
            _ => on += 1,
        }
    }
    let black =
        scene.lights.iter().filter(|l| matches!(l, Light::Environment(env) if env.is_black())).count();
    let emits = on > black || e.g.lights.iter().any(|l| l.unlit < l.sampled);
    if emits && !scene.lights.is_empty() {
        return None;
    }
    let severity = if e.is_black() { Severity::Error } else { Severity::Warning };
    if scene.lights.is_empty() && e.desc.lights.is_empty() {
        let emissive = e.desc.materials.iter().filter(|m| materials::is_emissive(&m.value)).count();
        if emissive > 0 && !physical {
            let what = format!(
                "{emissive} materials emit light, but with the integrator \"classic\" only [[light]]s illuminate surfaces"
            );
            return Some(
                Finding::new(BLACK, severity, "classic-emission", 1.0, what)
                    .why("only \"path\" and \"direct\" trace light from emissive surfaces")
                    .remedy("render with \"path\", or add a [[light]]")
                    .or(Remedy::set("integrator.type", "path")
                        .and("film.antialias", "monte-carlo")
                        .and("film.samples", 64)
                        .and("film.transfer", "srgb"))
                    .measure("emissive-materials", emissive as f64, "count"),
            );
        }
        return Some(no_lights(e, severity, physical));
    }
    if let Some(finding) = all_hidden(e, severity) {
        return Some(finding);
    }
    if let Some(finding) = (0..e.desc.lights.len() as u32).find_map(|i| night(e, i, 0.0)) {
        return Some(finding);
    }
    let first = off.first().copied().unwrap_or(0);
    let name = e.labels.light_of_description(first as u32);
    let key =
        e.desc.lights.get(first).and_then(|l| strength_key(&l.value)).map_or("intensity", |(key, _)| key);
    let what = match e.desc.lights.len() {
        1 => format!("the only light of the scene, {name}, is off or black"),
        n => format!("all {n} lights are off or black; the first is {name}"),
    };
    Some(
        Finding::new(BLACK, severity, "lights-off", 1.0, what)
            .why(format!("its `{key}` is 0, or its colour or image is black"))
            .remedy(format!("raise `{key}`, or choose another colour"))
            .set(&format!("light.{first}.{key}"), 1.0)
            .about(name.text)
            .at(e.desc.lights.get(first).and_then(|l| l.span))
            .measure("lights", e.desc.lights.len() as f64, "count"),
    )
}

/// The finding for a scene whose lights are all hidden.
fn all_hidden(e: &Evidence<'_>, severity: Severity) -> Option<Finding> {
    let first = e.desc.lights.first().filter(|_| e.desc.lights.iter().all(|light| light.hidden))?;
    let count = e.desc.lights.len() as f64;
    Some(
        Finding::new(BLACK, severity, "lights-hidden", 1.0, "all lights of the scene are hidden")
            .why("a light with `hidden = true` does not shine")
            .remedy("show a light: remove its key `hidden`")
            .set("light.0.hidden", false)
            .at(first.span)
            .measure("lights", count, "count"),
    )
}

/// The finding for a scene without any light, not even lights that are off.
fn no_lights(e: &Evidence<'_>, severity: Severity, physical: bool) -> Finding {
    let what = match (e.desc.imports.is_empty(), physical) {
        (_, false) => "the scene has no [[light]]",
        (true, true) => {
            "nothing in the scene emits light: it has no light, no emissive material and no background"
        }
        (false, true) => {
            "nothing in the scene emits light: the model brings no light, and the scene has none of its own"
        }
    };
    let finding = Finding::new(BLACK, severity, "no-lights", 1.0, what)
        .why("no light arrives at any surface")
        .measure("lights", 0.0, "count");
    if !physical {
        return finding.remedy("add a [[light]], or render with \"path\" and a [background]");
    }
    let finding = match can_have_studio(e.desc) {
        true => finding
            .remedy(format!("add a [[light]], an object with a material of type \"emissive\" or `[background] color`; a {STUDIO_SECTION} section adds the built-in studio light, which lights a model that is rendered alone"))
            .set(STUDIO_KEY, true),
        false => finding.remedy("add a [[light]], an object with a material of type \"emissive\", or `[background] color`"),
    };
    finding.set("background.color", 1.0)
}

/// A sky light with the sun below the horizon.
fn night(e: &Evidence<'_>, light: u32, irradiance: f64) -> Option<Finding> {
    let LightDesc::Sky(sky) = &e.desc.lights.get(light as usize)?.value else { return None };
    if sky.strength <= 0.0 || sky.direction.map_or(sky.elevation >= 0.0, |d| d.y >= 0.0) {
        return None;
    }
    let name = e.labels.light_of_description(light);
    let what = format!("the sun of {name} is below the horizon: it is night");
    let severity = if e.is_black() { Severity::Error } else { Severity::Warning };
    let finding = Finding::new(BLACK, severity, "sun-below-horizon", 1.0, what)
        .why(format!(
            "the irradiance at visible surfaces is {}; a white surface needs about 3 to look white",
            short(irradiance)
        ))
        .remedy("raise `elevation` above 0, or the exposure")
        .set(&format!("light.{light}.elevation"), 35.0)
        .about(name.text)
        .at(e.desc.lights.get(light as usize).and_then(|l| l.span))
        .measure("irradiance", irradiance, "irradiance");
    Some(if sky.direction.is_none() {
        finding.measure("elevation", sky.elevation, "degrees")
    } else {
        finding
    })
}

/// Whether any material in use emits light.
fn any_material_emits(e: &Evidence<'_>) -> bool {
    e.scene
        .primitive_materials()
        .any(|(_, m)| materials::emits_at(e.scene, m, true) || materials::emits_at(e.scene, m, false))
}

/// The intensity or strength of a light, times its colour.
fn strength(light: &LightDesc) -> Option<f64> {
    let product =
        |intensity: f64, color: crate::color::Spectrum| Some(intensity * f64::from(color.max_component()));
    match light {
        LightDesc::Ambient(l) => product(l.intensity, l.color),
        LightDesc::Point(l) => product(l.intensity, l.color),
        LightDesc::Directional(l) => product(l.intensity, l.color),
        LightDesc::Spot(l) => product(l.intensity, l.color),
        LightDesc::Rectangle(l) => product(l.intensity, l.color),
        LightDesc::Disk(l) => product(l.intensity, l.color),
        LightDesc::Sphere(l) => product(l.intensity, l.color),
        LightDesc::Environment(l) => product(l.strength, l.tint),
        LightDesc::Sky(l) => Some(l.strength),
    }
}

/// Integrator settings that remove light, found by trials.
fn settings(e: &Evidence<'_>) -> Vec<Finding> {
    let mut out = Vec::new();
    let severity = |t: &Trial, error: f64, warning: f64| {
        let gain = if t.ratio.is_finite() { t.ratio - 1.0 } else { 100.0 };
        if gain > error || e.is_black() && gain > 0.2 {
            Some(Severity::Error)
        } else {
            (gain > warning || t.brighter > 0.05).then_some(Severity::Warning)
        }
    };
    let measured = |f: Finding, t: &Trial| {
        f.measure("brightness-ratio", t.ratio, "ratio").measure("pixels-brightened", t.brighter, "fraction")
    };
    let times = |t: &Trial| {
        if t.ratio.is_finite() {
            format!("{} times the light", short(t.ratio))
        } else {
            "light where there was none".to_owned()
        }
    };
    let integrator = &e.scene.integrator;
    let depth = match integrator {
        IntegratorDesc::Path(p) => {
            let limits = [Some(p.max_depth), p.max_diffuse, p.max_glossy, p.max_transmission];
            limits.into_iter().flatten().min().unwrap_or(p.max_depth)
        }
        IntegratorDesc::Direct(d) => d.max_depth,
        IntegratorDesc::Classic(c) => c.max_depth,
        _ => 0,
    };
    if let Some(t) = &e.g.deeper
        && let Some(severity) = severity(t, 0.5, 0.05)
    {
        // At high depths the missing light is rarely a fault.
        let severity = if depth >= 8 && t.ratio < 2.0 { Severity::Note } else { severity };
        let direct = matches!(integrator, IntegratorDesc::Direct(_));
        let what = format!("`max_depth` is too low: paths end after {depth} bounces");
        let finding = Finding::new(BLACK, severity, "depth-too-low", if depth <= 1 { 0.94 } else { 0.8 }, what)
            .why(format!(
                "with a higher depth the same samples give {}; {} of the pixels get brighter. A glass pane or ball takes two bounces, the surface behind it one more",
                times(t),
                percent(t.brighter)
            ))
            .remedy(if direct { "raise `max_depth` of [integrator]" } else { "raise `max_depth` of [integrator], and `max_diffuse`, `max_glossy` and `max_transmission` if they are given" })
            .set("integrator.max_depth", if depth < 4 { 16 } else { 64 });
        out.push(measured(finding, t).measure("max-depth", f64::from(depth), "count"));
    }
    let IntegratorDesc::Path(p) = integrator else { return out };
    if let Some(t) = &e.g.unclamped
        && let Some(severity) = severity(t, 1.0, 0.05)
    {
        let what = format!("`clamp_indirect = {}` removes light", short(p.clamp_indirect));
        let finding = Finding::new(BLACK, severity, "clamp-darkens", 0.8, what)
            .why(format!("without it the same samples give {}", times(t)))
            .remedy("raise it or remove it: more samples reduce fireflies, too")
            .set("integrator.clamp_indirect", 0.0);
        out.push(measured(finding, t).measure("clamp", p.clamp_indirect, "radiance"));
    }
    if let Some(t) = &e.g.transparent
        && let Some(severity) = severity(t, 0.5, 0.02)
    {
        let what = format!("`max_transparent = {}` ends rays between transparent layers", p.max_transparent);
        let finding = Finding::new(BLACK, severity, "transparency-too-low", 0.93, what)
            .why(format!("with a higher limit the same samples give {}", times(t)))
            .remedy("raise `max_transparent` of [integrator]")
            .set("integrator.max_transparent", p.max_transparent.max(16).saturating_mul(16).min(4096));
        out.push(measured(finding, t).measure("max-transparent", f64::from(p.max_transparent), "count"));
    }
    if let Some(t) = &e.g.both_strategies
        && p.light_sampling != LightSampling::Both
        && let Some(severity) = severity(t, 0.5, 0.05)
    {
        let word = p.light_sampling.word();
        let why = match p.light_sampling {
            LightSampling::Bsdf => "a BSDF-sampled ray never hits a point light or a directional light",
            _ => {
                "light sampling misses emitters that cannot be sampled, such as infinite planes, and everything that mirrors show"
            }
        };
        let what = format!("`light_sampling = \"{word}\"` misses lights");
        let finding = Finding::new(BLACK, severity, "light-sampling", 0.94, what)
            .why(format!("{why}: with \"both\" the same samples give {}", times(t)))
            .remedy("remove `light_sampling` from [integrator]")
            .set("integrator.light_sampling", "both");
        out.push(measured(finding, t));
    }
    out
}

/// Enough light, but too low an exposure.
fn exposure(e: &Evidence<'_>) -> Option<Finding> {
    let film = e.scene.film();
    if film.exposure > -1.0 || e.is_black() && e.picture.light.iter().all(|l| *l <= 0.0 || l.is_nan()) {
        return None;
    }
    let shown = |factor: f64| quantile(e.g.colors.iter().map(|c| show(film, c, factor)[1]), 0.9);
    let (now, plain) = (shown(e.picture.factor), shown(1.0));
    if now >= 0.25 || plain < 2.0 * now.max(0.05) {
        return None;
    }
    let severity = if e.is_black() || now < 0.1 { Severity::Error } else { Severity::Warning };
    let what = format!(
        "the exposure of {} stops makes the picture {} times darker",
        short(film.exposure),
        short(1.0 / e.picture.factor)
    );
    Some(
        Finding::new(BLACK, severity, "exposure-too-low", 0.97, what)
            .why(format!(
                "90 % of the pixels are displayed below {}; at exposure 0 that value is {} (of 1)",
                short(now),
                short(plain)
            ))
            .remedy("set `exposure` of [film] to 0")
            .set("film.exposure", 0.0)
            .measure("exposure", film.exposure, "stops")
            .measure("brightness-shown", now, "fraction")
            .measure("brightness-at-exposure-0", plain, "fraction"),
    )
}

/// The mean albedo of visible non-emissive surfaces, and the fraction of them that are almost black.
fn albedo(e: &Evidence<'_>) -> Option<(f64, f64)> {
    let list: Vec<f64> = e
        .hits()
        .filter(|(_, _, m)| !m.emits && !materials::transmits(e.scene, m.material))
        .map(|(_, _, m)| m.albedo)
        .collect();
    if list.is_empty() {
        return None;
    }
    let n = list.len() as f64;
    Some((list.iter().sum::<f64>() / n, list.iter().filter(|a| **a < 0.01).count() as f64 / n))
}

/// Light that arrives but is too weak.
fn too_dim(e: &Evidence<'_>) -> Option<Finding> {
    if !e.is_black() {
        return None;
    }
    let irradiance: f64 = e.g.lights.iter().map(|l| l.irradiance).sum();
    let potential: f64 = e.g.lights.iter().map(|l| l.irradiance + l.blocked_irradiance).sum();
    let (albedo, _) = albedo(e).unwrap_or((0.5, 0.0));
    // The displayed radiance of diffuse surfaces with an albedo of 0.5.
    let light = irradiance * e.picture.factor * 0.5 / std::f64::consts::PI;
    if irradiance <= 0.0 || irradiance < 0.02 * potential || light > 0.05 || albedo < 0.02 {
        return None;
    }
    let most = e.g.lights.iter().max_by(|a, b| a.irradiance.total_cmp(&b.irradiance))?;
    let brightest = quantile(e.picture.light.iter().copied(), 0.9);
    let wanted = 0.35;
    let factor = wanted / (brightest * e.picture.factor).max(1e-30);
    let stops = (ln(factor) * std::f64::consts::LOG2_E).ceil();
    let name = e.emitter_name(most.emitter);
    if let Some(finding) = e.light_number(most.emitter).and_then(|i| night(e, i, irradiance)) {
        return Some(finding);
    }
    let far = most.distance.is_finite() && attenuates(e, most);
    let what = if far {
        format!("{name} is too weak for its distance of {} units", short(most.distance))
    } else {
        format!("{name} is too weak")
    };
    let why = if far {
        format!(
            "light falls off with the square of the distance: 1/{} of its intensity is left. The irradiance at visible surfaces is {}; a white surface needs about 3 to look white. A scene in millimetres needs a million times the intensity of one in metres",
            short(most.distance * most.distance),
            short(irradiance)
        )
    } else {
        format!(
            "the irradiance at visible surfaces is {}; a white surface needs about 3 to look white",
            short(irradiance)
        )
    };
    let mut finding =
        Finding::new(BLACK, Severity::Error, "light-too-weak", 0.9, what).why(why).remedy(format!(
            "multiply its strength by about {}, or raise the exposure by {} stops",
            short(factor),
            short(stops)
        ));
    finding = match e.light_number(most.emitter) {
        Some(i) => match e.desc.lights.get(i as usize).and_then(|l| strength_key(&l.value)) {
            Some((key, now)) => finding.set(&format!("light.{i}.{key}"), rounded(now * factor)),
            None => finding,
        },
        None => finding,
    };
    if stops <= 60.0 {
        finding = finding
            .set("film.exposure", rounded(e.scene.film().exposure + stops))
            .set("film.auto_exposure", true);
    }
    Some(
        finding
            .about(name.text)
            .at(e.span_of(most.emitter))
            .measure("irradiance", irradiance, "irradiance")
            .measure("distance", most.distance, "units")
            .measure("factor-needed", factor, "ratio")
            .measure("brightness", brightest, "radiance"),
    )
}

/// The key of a light's intensity or strength, and its value.
pub(super) fn strength_key(light: &LightDesc) -> Option<(&'static str, f64)> {
    Some(match light {
        LightDesc::Ambient(l) => ("intensity", l.intensity),
        LightDesc::Point(l) => ("intensity", l.intensity),
        LightDesc::Directional(l) => ("intensity", l.intensity),
        LightDesc::Spot(l) => ("intensity", l.intensity),
        LightDesc::Rectangle(l) => ("intensity", l.intensity),
        LightDesc::Disk(l) => ("intensity", l.intensity),
        LightDesc::Sphere(l) => ("intensity", l.intensity),
        LightDesc::Environment(l) => ("strength", l.strength),
        LightDesc::Sky(l) => ("strength", l.strength),
    })
}

/// Whether the light falls off with distance.
fn attenuates(e: &Evidence<'_>, l: &LightFacts) -> bool {
    let light = e.light_number(l.emitter).and_then(|i| e.desc.lights.get(i as usize));
    let attenuation = light.and_then(|l| l.value.attenuation());
    // The solid angle of emissive shapes decreases with distance.
    attenuation.is_none_or(|a| a.coefficients[1] + a.coefficients[2] > 0.0)
}

/// Visible surfaces that reflect almost no light.
fn black_materials(e: &Evidence<'_>) -> Option<Finding> {
    let (mean, black) = albedo(e)?;
    let irradiance: f64 = e.g.lights.iter().map(|l| l.irradiance).sum();
    if mean > 0.02 || black < 0.8 || irradiance * e.picture.factor < 1e-4 {
        return None;
    }
    let severity = if e.is_black() { Severity::Error } else { Severity::Warning };
    let (_, _, hit) = e.hits().find(|(_, _, m)| m.albedo < 0.01 && !m.emits)?;
    let name = e.labels.material_label(hit.material);
    let what = format!("the visible surfaces are black: their mean albedo is {}", short(mean));
    Some(
        Finding::new(BLACK, severity, "materials-black", 0.92, what)
            .why(format!(
                "they receive an irradiance of {} and reflect almost none of it; {} of the pixels show a material as black as {name}",
                short(irradiance),
                percent(black)
            ))
            .remedy("give the materials another `color` or `base_color`, and check that their textures were found")
            .about(name.text)
            .measure("albedo", mean, "fraction")
            .measure("black-pixels", black, "fraction")
            .measure("irradiance", irradiance, "irradiance"),
    )
}
