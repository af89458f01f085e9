//! Rules for noise: the light, material and kind of path that cause the variance.

use super::evidence::Evidence;
use super::finding::{Finding, Question, Severity, percent, short};
use super::kind::{PathKind, Source};
use super::lights::LightFacts;
use super::picture::quantile;
use crate::light::Light;
use crate::lint::takes_one_sample;
use crate::scene::ListedEmitter;
use crate::schema::Remedy;

/// Relative mean squared error above which noise is a warning.
const VISIBLE: f64 = 0.01;

/// Relative mean squared error above which noise is a note.
const NOTABLE: f64 = 0.002;

pub(super) fn check(e: &Evidence<'_>, out: &mut Vec<Finding>) {
    let before = out.len();
    measured(e, out);
    if !e.g.paths.is_empty() && out.iter().skip(before).all(|f| f.code != "noise-caustics") {
        out.extend(rare_caustics(e));
    }
}

/// Findings about the measured variance.
fn measured(e: &Evidence<'_>, out: &mut Vec<Finding>) {
    if e.g.paths.is_empty() || e.variance <= 0.0 {
        return;
    }
    let samples = f64::from(e.samples());
    let error = e.variance / samples;
    if error < NOTABLE {
        return;
    }
    let severity = if error < VISIBLE { Severity::Note } else { Severity::Warning };
    let wanted = (e.variance / VISIBLE).ceil();
    let fewer = wanted.min(16_777_216.0);
    let all = e.all[1].max(f64::MIN_POSITIVE);
    let flags = |f: Finding| {
        f.or(Remedy::set("film.antialias", "monte-carlo").and("film.samples", fewer as u32))
            .measure("expected-error", error, "relmse")
            .measure("variance-of-a-sample", e.variance, "relmse")
            .measure("samples", samples, "count")
            .measure("samples-for-0.01", wanted, "count")
    };
    if takes_one_sample(e.scene.film()) && e.scene.integrator.capabilities().physical {
        let word = e.scene.film().antialias.word();
        let what = format!("`antialias = \"{word}\"` takes one sample per pixel");
        out.push(flags(
            Finding::new(Question::Noisy, severity, "one-sample", 0.9, what)
                .why(format!("light transport is stochastic. The expected error is {} (relMSE); noise is hard to see below {VISIBLE}", short(error)))
                .remedy("set `antialias = \"monte-carlo\"` and `samples` in [film]"),
        ));
    }
    if let Some(f) = fireflies(e) {
        out.push(flags(Finding { severity, ..f }));
    }
    let mut kinds: Vec<(PathKind, [f64; 3])> = e.by_kind.iter().map(|(k, v)| (*k, *v)).collect();
    kinds.sort_by(|a, b| b.1[1].total_cmp(&a.1[1]).then(a.0.cmp(&b.0)));
    for (i, (kind, sums)) in kinds.into_iter().enumerate() {
        // The kind with the most variance, and others with more than a quarter of it.
        if i == 0 || sums[1] > 0.25 * all {
            out.push(flags(of_kind(e, severity, kind, sums, all, error, wanted)));
        }
    }
}

/// Caustics of lights that are so small that the probe may have missed them.
fn rare_caustics(e: &Evidence<'_>) -> Option<Finding> {
    /// The fraction of the hemisphere below which BSDF-sampled rays rarely hit a light.
    const SMALL: f64 = 2e-3;
    if e.g.by_light_paths.is_some() {
        return None;
    }
    let irradiance: f64 = e.g.lights.iter().map(|l| l.irradiance).sum();
    let lost = |l: &LightFacts| {
        let fraction: f64 = l.blockers.iter().filter(|b| b.transmits).map(|b| b.fraction).sum();
        fraction * l.blocked_irradiance
    };
    let small = |l: &LightFacts| {
        let ListedEmitter::Shape { .. } = l.emitter else { return None };
        let radius = 0.5 * l.bounds?.size().length();
        let fraction = 0.5 * (radius / l.distance) * (radius / l.distance);
        (fraction < SMALL).then_some(fraction)
    };
    let list: Vec<(&LightFacts, f64)> = e.g.lights.iter().filter_map(|l| Some((l, small(l)?))).collect();
    let total: f64 = list.iter().map(|(l, _)| lost(l)).sum();
    let (light, size) = list.into_iter().max_by(|a, b| lost(a.0).total_cmp(&lost(b.0)))?;
    let fraction = total / (total + irradiance);
    let blocker = light.blockers.iter().find(|b| b.transmits)?;
    if fraction.is_nan() || fraction < 0.02 {
        return None;
    }
    let (name, glass) =
        (e.emitter_name(light.emitter), e.labels.object_label(blocker.primitive, blocker.shape));
    // Above one half, indirect light is noisy for the same reason, so this finding precedes that one.
    let weight = if fraction > 0.5 { 0.93 } else { 0.72 };
    let what = format!(
        "{} of the light is caustics of {name} through {glass}, which paths hardly ever find",
        percent(fraction)
    );
    let finding = Finding::new(Question::Noisy, Severity::Warning, "noise-caustics", weight, what)
        .why(format!("light sampling needs a straight path, which refraction bends, and only one BSDF-sampled ray in {} hits a light of this size", short(1.0 / size)))
        .remedy("trace light paths; or make the light larger, or the glass `thin_walled` with roughness 0, which does not bend light")
        .or(Remedy::set("integrator.type", "path").and("integrator.caustics", "full"))
        .about(glass.text)
        .at(e.span_of(light.emitter))
        .measure("light-through-glass", fraction, "fraction")
        .measure("hit-probability", size, "fraction");
    Some(finding)
}

/// The finding about a kind of path with much variance.
fn of_kind(
    e: &Evidence<'_>,
    severity: Severity,
    kind: PathKind,
    sums: [f64; 3],
    all: f64,
    error: f64,
    wanted: f64,
) -> Finding {
    let fraction = |v: f64| v / all;
    let of_kind = fraction(sums[1]);
    let material = e.by_material.iter().filter(|((k, m), _)| *k == kind && m.is_some());
    let material = material.max_by(|a, b| a.1[1].total_cmp(&b.1[1]));
    let at = match material {
        Some(((_, Some(m)), v)) if fraction(v[1]) > 0.3 * of_kind => {
            Some((e.labels.material_label(*m), fraction(v[1])))
        }
        _ => None,
    };
    let source = e.by_source.iter().max_by(|a, b| a.1[1].total_cmp(&b.1[1]));
    let by = source.map(|(s, v)| (e.source(*s), fraction(v[1]), *s));
    let bsdf_sampled = if sums[1] > 0.0 { sums[2] / sums[1] } else { 0.0 };
    let (code, why, remedy) = advice(e, kind, by.as_ref().map(|(_, _, s)| *s), bsdf_sampled);
    let mut what = format!("{} of the noise is {}", percent(of_kind), kind.words());
    if let Some((name, part)) = &at {
        what += &format!(", {} of that on {name}", percent((part / of_kind).min(1.0)));
    }
    if let Some((name, part, _)) = by.as_ref().filter(|(_, part, _)| *part > 0.3) {
        what += &format!("; {} of all noise comes from {name}", percent(part.min(1.0)));
    }
    let samples = match e.samples() {
        1 => "1 sample".to_owned(),
        n => format!("{n} samples"),
    };
    let mut finding =
        Finding::new(Question::Noisy, severity, code, 0.7 + 0.15 * of_kind.clamp(0.0, 1.0), what)
            .why(format!("{why}. The expected error with {samples} is {} (relMSE)", short(error)))
            .remedy(format!("{remedy}; {} samples per pixel reduce the error to {VISIBLE}", short(wanted)))
            .measure("fraction-of-kind", of_kind, "fraction")
            .measure("fraction-bsdf-sampled", bsdf_sampled, "fraction");
    if kind == PathKind::Caustic {
        finding = finding.set("integrator.caustics", "full").set("integrator.clamp_indirect", 10.0);
    }
    if let Some((name, part)) = at {
        finding = finding.about(name.text).measure("fraction-of-material", part, "fraction");
    }
    if let Some((name, part, source)) = by {
        finding.subject.get_or_insert(name.text);
        if let Source::Light(i) = source {
            finding.span = e.span_of(ListedEmitter::Light(i));
        }
        finding = finding.measure("fraction-of-light", part, "fraction");
    }
    finding
}

/// The code of a noisy kind of path, the reason for the noise, and the remedy. `bsdf_sampled` is the fraction of its
/// variance due to BSDF-sampled rays.
fn advice(
    e: &Evidence<'_>,
    kind: PathKind,
    source: Option<Source>,
    bsdf_sampled: f64,
) -> (&'static str, &'static str, &'static str) {
    let many = e.g.emitters > 64;
    let environment = |s| matches!(s, Some(Source::Light(i)) if matches!(e.scene.lights.get(i as usize), Some(Light::Environment(_))));
    match kind {
        PathKind::Caustic => (
            "noise-caustics",
            "light that mirrors or glass focus on a surface is found only by BSDF-sampled rays that hit the light",
            "trace light paths: `caustics = \"full\"` in [integrator]; or make the light larger, or the glass `thin_walled`; `clamp_indirect = 10` removes the brightest spots, and some light with them",
        ),
        PathKind::Indirect => (
            "noise-indirect",
            "indirect light is found by BSDF-sampled rays; the smaller the opening or lit surface that it comes from, the fewer rays find it",
            "put a light where the light comes from, such as an emissive rectangle in the window; or make the opening larger",
        ),
        PathKind::Glossy => (
            "noise-glossy",
            "glossy reflections of other surfaces are found by BSDF-sampled rays",
            "raise or lower the roughness, or light the reflected surfaces more evenly",
        ),
        PathKind::Direct if many && bsdf_sampled < 0.5 => (
            "noise-many-lights",
            "each sample takes one of many lights, and most of them contribute little",
            "remove lights that contribute little, or replace small ones by one emissive surface",
        ),
        PathKind::Direct if bsdf_sampled > 0.5 && environment(source) => (
            "noise-environment",
            "the environment has small bright regions that few BSDF-sampled rays hit",
            "keep `light_sampling` at \"both\", or replace the sun in the environment map by a directional light",
        ),
        PathKind::Direct if bsdf_sampled > 0.5 => (
            "noise-light-not-sampled",
            "only BSDF-sampled rays find this light: emissive planes, moving emitters and lights behind glass cannot be sampled",
            "replace an emissive plane by a rectangle, or make the light larger",
        ),
        PathKind::Direct => (
            "noise-direct",
            "in soft shadows each sample tests one point of the light, which is visible or not",
            "a smaller light casts sharper shadows with less noise",
        ),
        PathKind::Specular => (
            "noise-specular",
            "surfaces seen in mirrors and glass need as many samples as surfaces seen directly",
            "find the reflected surface: its light is noisy",
        ),
        PathKind::Emitted | PathKind::Background => (
            "noise-edges",
            "bright edges, depth of field, motion blur and partial opacity vary between the samples of a pixel",
            "a few more samples remove this noise",
        ),
    }
}

/// Few samples with most of the variance.
fn fireflies(e: &Evidence<'_>) -> Option<Finding> {
    let pixels: Vec<_> =
        e.g.paths.iter().flatten().filter(|p| p.samples >= 2 && p.variance.is_finite()).collect();
    let all: f64 = pixels.iter().map(|p| p.variance).sum();
    let typical = quantile(pixels.iter().map(|p| p.variance), 0.5);
    let spiked: Vec<_> = pixels
        .iter()
        .filter(|p| p.spike > 0.6 && p.variance > 20.0 * typical.max(1e-4) && p.variance > 1.0)
        .collect();
    let fraction = spiked.iter().map(|p| p.variance).sum::<f64>() / all.max(f64::MIN_POSITIVE);
    let count = spiked.len() as f64 / pixels.len().max(1) as f64;
    if fraction < 0.5 || count > 0.1 || spiked.is_empty() {
        return None;
    }
    let worst = spiked.iter().max_by(|a, b| a.variance.total_cmp(&b.variance))?;
    let (key, _) = worst.contributions.iter().max_by(|a, b| a.1.variance.total_cmp(&b.1.variance))?;
    if key.kind == PathKind::Caustic && e.g.by_light_paths.is_some() {
        // Light paths compute these caustics.
        return None;
    }
    let material = key.material.map_or(String::new(), |m| format!(" on {}", e.labels.material_label(m)));
    let what = format!(
        "fireflies: single samples in {} of the pixels carry {} of the variance: {}{material}",
        percent(count),
        percent(fraction),
        key.kind.words()
    );
    let finding = Finding::new(Question::Noisy, Severity::Warning, "fireflies", 0.6, what)
        .why("bright light that few samples find stands out as single pixels")
        .remedy("more samples make them rarer and dimmer; `clamp_indirect = 10` in [integrator] removes them, and their light with them; a larger or weaker light, or rougher glass, avoids them")
        .set("integrator.clamp_indirect", 10.0)
        .measure("pixels", count, "fraction")
        .measure("fraction-of-variance", fraction, "fraction");
    Some(match key.material {
        Some(m) => finding.about(e.labels.material(m)),
        None => finding.about(e.source(key.source).text),
    })
}
