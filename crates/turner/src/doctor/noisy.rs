//! Why it is noisy: which light, material or sort of path carries the variance.

use super::evidence::Evidence;
use super::finding::{Finding, Question, Severity, percent, short};
use super::kind::{PathKind, Source};
use super::lights::LightFacts;
use super::picture::quantile;
use crate::film::Antialias;
use crate::light::Light;
use crate::scene::ListedEmitter;
use crate::schema::Remedy;

/// Relative mean squared error above which noise is seen at once.
const VISIBLE: f64 = 0.01;

/// Above this it is worth a note.
const NOTABLE: f64 = 0.002;

pub(super) fn ask(e: &Evidence<'_>, out: &mut Vec<Finding>) {
    let before = out.len();
    measured(e, out);
    if !e.g.paths.is_empty() && out.iter().skip(before).all(|f| f.code != "noise-caustics") {
        out.extend(rare_caustics(e));
    }
}

/// What carries the variance that was measured.
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
            .measure("error-expected", error, "relmse")
            .measure("variance-of-a-sample", e.variance, "relmse")
            .measure("samples", samples, "count")
            .measure("samples-for-0.01", wanted, "count")
    };
    if e.scene.film().antialias == Antialias::None && e.scene.integrator.capabilities().physical {
        let what = "each pixel has one sample alone: `antialias = \"none\"`".to_owned();
        out.push(flags(
            Finding::new(Question::Noisy, severity, "one-sample", 0.9, what)
                .why(format!("light is found by chance; the error to expect is {} (relMSE), and below {VISIBLE} noise is hard to see", short(error)))
                .remedy("give `antialias = \"monte-carlo\"` and `samples` in [film]"),
        ));
    }
    if let Some(f) = fireflies(e) {
        out.push(flags(Finding { severity, ..f }));
    }
    let mut kinds: Vec<(PathKind, [f64; 3])> = e.by_kind.iter().map(|(k, v)| (*k, *v)).collect();
    kinds.sort_by(|a, b| b.1[1].total_cmp(&a.1[1]).then(a.0.cmp(&b.0)));
    for (i, (kind, sums)) in kinds.into_iter().enumerate() {
        // The one that carries most, and others that carry much.
        if i == 0 || sums[1] > 0.25 * all {
            out.push(flags(of_kind(e, severity, kind, sums, all, error, wanted)));
        }
    }
}

/// Light that goes through glass to what is seen, by lights so small that the probe may not have found it at all.
fn rare_caustics(e: &Evidence<'_>) -> Option<Finding> {
    /// Share of a hemisphere below which a light is hardly ever hit by chance.
    const SMALL: f64 = 2e-3;
    if e.g.by_light_paths.is_some() {
        return None;
    }
    let arrives: f64 = e.g.lights.iter().map(|l| l.arrives).sum();
    let lost = |l: &LightFacts| {
        let share: f64 = l.blockers.iter().filter(|b| b.lets_through).map(|b| b.share).sum();
        share * l.kept_off
    };
    let small = |l: &LightFacts| {
        let ListedEmitter::Shape { .. } = l.one else { return None };
        let radius = 0.5 * l.bounds?.size().length();
        let share = 0.5 * (radius / l.distance) * (radius / l.distance);
        (share < SMALL).then_some(share)
    };
    let list: Vec<(&LightFacts, f64)> = e.g.lights.iter().filter_map(|l| Some((l, small(l)?))).collect();
    let total: f64 = list.iter().map(|(l, _)| lost(l)).sum();
    let (light, size) = list.into_iter().max_by(|a, b| lost(a.0).total_cmp(&lost(b.0)))?;
    let share = total / (total + arrives);
    let blocker = light.blockers.iter().find(|b| b.lets_through)?;
    if share.is_nan() || share < 0.02 {
        return None;
    }
    let (name, glass) = (e.emitter_name(light.one), e.labels.object(blocker.primitive, blocker.shape));
    // What is noisy by way of other surfaces then comes from there, too.
    let weight = if share > 0.5 { 0.93 } else { 0.72 };
    let what = format!(
        "{} of the light goes through \"{glass}\", as caustics of \"{name}\", which paths hardly ever find",
        percent(share)
    );
    let finding = Finding::new(Question::Noisy, Severity::Warning, "noise-caustics", weight, what)
        .why(format!("sampling a light asks for a straight way, which glass does not leave, and by chance one of {} paths hits a light of this size", short(1.0 / size)))
        .remedy("find it by light paths; or make the light larger, or the glass `thin_walled` with roughness 0, which lets light go straight")
        .or(Remedy::set("integrator.type", "path").and("integrator.caustics", "full"))
        .about(glass)
        .measure("light-through-glass", share, "share")
        .measure("chance-to-hit", size, "share");
    Some(finding)
}

/// A sort of path that carries much of the variance.
fn of_kind(
    e: &Evidence<'_>,
    severity: Severity,
    kind: PathKind,
    sums: [f64; 3],
    all: f64,
    error: f64,
    wanted: f64,
) -> Finding {
    let share = |v: f64| v / all;
    let of_kind = share(sums[1]);
    let material = e.by_material.iter().filter(|((k, m), _)| *k == kind && m.is_some());
    let material = material.max_by(|a, b| a.1[1].total_cmp(&b.1[1]));
    let at = match material {
        Some(((_, Some(m)), v)) if share(v[1]) > 0.3 * of_kind => Some((e.labels.material(*m), share(v[1]))),
        _ => None,
    };
    let source = e.by_source.iter().max_by(|a, b| a.1[1].total_cmp(&b.1[1]));
    let by = source.map(|(s, v)| (e.source(*s), share(v[1]), *s));
    let chance = if sums[1] > 0.0 { sums[2] / sums[1] } else { 0.0 };
    let (code, why, remedy) = advice(e, kind, by.as_ref().map(|(_, _, s)| *s), chance);
    let mut what = format!("{} of the noise is {}", percent(of_kind), kind.words());
    if let Some((name, part)) = &at {
        what += &format!(", {} of it at \"{name}\"", percent((part / of_kind).min(1.0)));
    }
    if let Some((name, part, _)) = by.as_ref().filter(|(_, part, _)| *part > 0.3) {
        what += &format!("; {} of all noise is light of \"{name}\"", percent(part.min(1.0)));
    }
    let samples = e.samples();
    let mut finding =
        Finding::new(Question::Noisy, severity, code, 0.7 + 0.15 * of_kind.clamp(0.0, 1.0), what)
            .why(format!("{why}. The error to expect with {samples} samples is {} (relMSE)", short(error)))
            .remedy(format!("{remedy}; {} samples bring the error to {VISIBLE}", short(wanted)))
            .measure("share-of-kind", of_kind, "share")
            .measure("found-by-chance", chance, "share");
    if kind == PathKind::Caustic {
        finding = finding.set("integrator.caustics", "full").set("integrator.clamp_indirect", 10.0);
    }
    if let Some((name, part)) = at {
        finding = finding.about(name).measure("share-of-material", part, "share");
    }
    if let Some((name, part, _)) = by {
        finding.subject.get_or_insert(name);
        finding = finding.measure("share-of-light", part, "share");
    }
    finding
}

/// Why a sort of path is noisy, and what helps.
fn advice(
    e: &Evidence<'_>,
    kind: PathKind,
    source: Option<Source>,
    chance: f64,
) -> (&'static str, &'static str, &'static str) {
    let many = e.g.emitters > 64;
    let environment = |s| matches!(s, Some(Source::Light(i)) if matches!(e.scene.lights.get(i as usize), Some(Light::Environment(_))));
    match kind {
        PathKind::Caustic => (
            "noise-caustics",
            "light that mirrors or glass throw on a surface is found only by paths that hit the light by chance",
            "find it by light paths: `caustics = \"full\"` in [integrator]; or make the light larger, or the glass `thin_walled`; `clamp_indirect = 10` takes the brightest away, and light with them",
        ),
        PathKind::Indirect => (
            "noise-indirect",
            "light that comes by way of other surfaces is found by chance, the less often the smaller the opening or the lit patch that it comes from",
            "put a light where the light comes from: a rectangle that shines in the window; or open the room towards it",
        ),
        PathKind::Glossy => (
            "noise-glossy",
            "what gloss shows of other surfaces is found by chance",
            "raise or lower the roughness, or light the surfaces that are reflected more evenly",
        ),
        PathKind::Direct if many && chance < 0.5 => (
            "noise-many-lights",
            "each point asks one of many lights, and most of them bring it little",
            "take away lights that are not seen to matter, or gather small ones into one shining surface",
        ),
        PathKind::Direct if chance > 0.5 && environment(source) => (
            "noise-environment",
            "the environment has small bright places that paths find by chance",
            "leave `light_sampling` at \"both\", or put a directional light in place of the sun in the picture",
        ),
        PathKind::Direct if chance > 0.5 => (
            "noise-light-by-chance",
            "the light is found by chance alone: planes that shine, what moves, and lights seen through glass cannot be sampled",
            "put a rectangle in place of a plane that shines, or a larger light",
        ),
        PathKind::Direct => (
            "noise-direct",
            "soft shadows ask one point of a light at a time, which is seen or not",
            "a smaller light throws sharper shadows with less noise",
        ),
        PathKind::Specular => (
            "noise-specular",
            "what is seen in mirrors and glass takes as many samples as where it is seen directly",
            "look at what is reflected: its light is what is noisy",
        ),
        PathKind::Emitted | PathKind::Background => (
            "noise-edges",
            "bright edges, defocus, motion and surfaces that cover a share of what is behind them change from sample to sample within a pixel",
            "this noise goes away with few samples more",
        ),
    }
}

/// Few samples that bring most of the variance.
fn fireflies(e: &Evidence<'_>) -> Option<Finding> {
    let pixels: Vec<_> =
        e.g.paths.iter().flatten().filter(|p| p.samples >= 2 && p.variance.is_finite()).collect();
    let all: f64 = pixels.iter().map(|p| p.variance).sum();
    let typical = quantile(pixels.iter().map(|p| p.variance), 0.5);
    let spiked: Vec<_> = pixels
        .iter()
        .filter(|p| p.spike > 0.6 && p.variance > 20.0 * typical.max(1e-4) && p.variance > 1.0)
        .collect();
    let share = spiked.iter().map(|p| p.variance).sum::<f64>() / all.max(f64::MIN_POSITIVE);
    let count = spiked.len() as f64 / pixels.len().max(1) as f64;
    if share < 0.5 || count > 0.1 || spiked.is_empty() {
        return None;
    }
    let worst = spiked.iter().max_by(|a, b| a.variance.total_cmp(&b.variance))?;
    let (key, _) = worst.shares.iter().max_by(|a, b| a.1.variance.total_cmp(&b.1.variance))?;
    if key.kind == PathKind::Caustic && e.g.by_light_paths.is_some() {
        // Light paths find these.
        return None;
    }
    let material = key.material.map_or(String::new(), |m| format!(" at \"{}\"", e.labels.material(m)));
    let what = format!(
        "fireflies: single samples in {} of the pixels carry {} of the variance: {}{material}",
        percent(count),
        percent(share),
        key.kind.words()
    );
    let finding = Finding::new(Question::Noisy, Severity::Warning, "fireflies", 0.6, what)
        .why("bright light that is found rarely by chance stands out as single pixels")
        .remedy("more samples make them rarer and paler; `clamp_indirect = 10` in [integrator] takes them away, and their light with them; a larger or weaker light, or rougher glass, makes none")
        .set("integrator.clamp_indirect", 10.0)
        .measure("pixels", count, "share")
        .measure("share-of-variance", share, "share");
    Some(match key.material {
        Some(m) => finding.about(e.labels.material(m)),
        None => finding.about(e.source(key.source)),
    })
}
