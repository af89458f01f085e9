//! Rules for lights that do not reach visible surfaces, and the objects that block them.

use std::collections::BTreeMap;

use super::evidence::Evidence;
use super::finding::{Finding, Question, Severity, percent, rounded, short};
use super::lights::{Blocker, LightFacts};
use crate::description::Label;
use crate::light::{Light, LightDesc};
use crate::math::DVec3;
use crate::math::elementary::acos;
use crate::scene::ListedEmitter;
use crate::schema::Remedy;

const BLACK: Question = Question::Black;

/// The fraction of visible surface points that a light must reach.
const MIN_REACHED: f64 = 0.01;

pub(super) fn check(e: &Evidence<'_>, out: &mut Vec<Finding>) {
    if e.g.lights.is_empty() || e.picture.light.is_empty() {
        return;
    }
    let potential = |l: &LightFacts| l.irradiance + l.blocked_irradiance + l.back_irradiance;
    let all_irradiance: f64 = e.g.lights.iter().map(|l| l.irradiance).sum();
    let tried = [e.g.deeper, e.g.unclamped, e.g.transparent, e.g.both_strategies];
    let settings = tried.iter().flatten().any(|t| t.ratio > 3.0);
    let mut causes: BTreeMap<(&'static str, Option<u32>), Found<'_>> = BTreeMap::new();
    for l in e.g.lights.iter().filter(|l| l.sampled > 0) {
        let Some(cause) = cause(e, l) else { continue };
        let missed = potential(l) > 0.1 * all_irradiance || l.unlit == l.sampled;
        let severity = match (e.is_black(), missed) {
            // Other settings let its light arrive.
            (true, _) if settings && indirectly(e, l) => Severity::Note,
            (true, _) => Severity::Error,
            // The light may be intended as indirect light.
            (false, true) if indirectly(e, l) => Severity::Note,
            (false, true) => Severity::Warning,
            (false, false) => Severity::Note,
        };
        let finding = Finding { severity, ..cause.finding };
        causes.entry((finding.code, cause.by)).or_default().push((l, finding));
    }
    for ((code, _), mut list) in causes {
        list.sort_by(|a, b| potential(b.0).total_cmp(&potential(a.0)));
        let count = list.len();
        let worst = list.iter().map(|(_, f)| f.severity).min();
        let Some((_, mut finding)) = list.into_iter().next() else { continue };
        finding.severity = worst.unwrap_or(finding.severity);
        if count > 1 {
            finding.what += &format!("; the same holds for {} more lights", count - 1);
            finding = finding.measure("lights", count as f64, "count");
        }
        debug_assert_eq!(code, finding.code);
        out.push(finding);
    }
    out.extend(behind_glass(e, all_irradiance));
}

/// Whether the light or its indirect light contributes to the picture.
fn indirectly(e: &Evidence<'_>, l: &LightFacts) -> bool {
    let source = match l.emitter {
        ListedEmitter::Light(i) => super::Source::Light(i),
        ListedEmitter::Shape { primitive, .. } => super::Source::Object(primitive),
    };
    e.by_source.get(&source).is_some_and(|s| s[0] > 0.05 * e.all[0])
}

/// Lights with their findings.
type Found<'a> = Vec<(&'a LightFacts, Finding)>;

/// Why a light does not arrive, and the object that blocks it.
struct Cause {
    finding: Finding,
    by: Option<u32>,
}

fn cause(e: &Evidence<'_>, l: &LightFacts) -> Option<Cause> {
    let fraction = |n: u32| f64::from(n) / f64::from(l.sampled);
    // On floors that extend to the horizon, some light arrives far away.
    let next_to_nothing =
        l.irradiance < MIN_REACHED * (l.irradiance + l.blocked_irradiance) && fraction(l.visible) < 0.5;
    if fraction(l.visible) > MIN_REACHED && !next_to_nothing {
        return None;
    }
    let name = e.emitter_name(l.emitter);
    let measured = |f: Finding| {
        f.about(name.text.clone())
            .at(e.span_of(l.emitter))
            .measure("points-reached", fraction(l.visible), "fraction")
            .measure("points-in-shadow", fraction(l.blocked), "fraction")
            .measure("points-facing-away", fraction(l.facing_away), "fraction")
            .measure("points-not-illuminated", fraction(l.unlit), "fraction")
            .measure("irradiance-blocked", l.blocked_irradiance, "irradiance")
    };
    let find =
        |code, weight, what: String| measured(Finding::new(BLACK, Severity::Error, code, weight, what));
    if fraction(l.unlit) > 0.97 {
        return turned_away(e, l, &name, &find).map(|finding| Cause { finding, by: None });
    }
    if l.bounds.is_none()
        && let Some(finding) = below_horizon(e, l, &name, &find)
    {
        return Some(Cause { finding, by: None });
    }
    let blocker = l.blockers.iter().find(|b| !b.transmits).or(l.blockers.first());
    if l.blockers.first().is_some_and(|b| b.transmits)
        && l.blockers.iter().filter(|b| b.transmits).map(|b| b.fraction).sum::<f64>() > 0.9
    {
        // There is a separate finding for light through glass.
        return None;
    }
    let by = |b: &Blocker| e.labels.object_label(b.primitive, b.shape);
    if l.bounds.is_none() {
        let b = blocker?;
        let what = format!("{} blocks {name}", by(b));
        let finding = find("sky-blocked", 0.92, what)
            .why(format!(
                "it reaches {} of the visible surface points; {} blocks {} of the rest",
                percent(fraction(l.visible)),
                by(b),
                percent(b.fraction)
            ))
            .remedy("make an opening in it, remove it, or put a light inside")
            .measure("fraction-blocked-by-it", b.fraction, "fraction");
        return Some(Cause { finding, by: Some(b.primitive) });
    }
    if let Some(cause) = enclosed_light(e, l, blocker, &name, &find) {
        return Some(cause);
    }
    match blocker {
        Some(b) => {
            let what = format!("{} is between {name} and all visible surfaces", by(b));
            let finding = find("light-blocked", 0.94, what)
                .why(format!(
                    "the light reaches {} of the visible surface points. {} are in shadow, and {} casts {} of that; {} face away from the light",
                    percent(fraction(l.visible)),
                    percent(fraction(l.blocked)),
                    by(b),
                    percent(b.fraction),
                    percent(fraction(l.facing_away))
                ))
                .remedy("move the light to the side that the camera sees, or remove what is between")
                .measure("distance", l.distance, "units");
            Some(Cause { finding, by: Some(b.primitive) })
        }
        None if fraction(l.facing_away) > 0.9 => {
            let what = format!("{name} is behind all visible surfaces");
            let finding = find("light-blocked", 0.9, what)
                .why(format!("{} of the visible surface points face away from it", percent(fraction(l.facing_away))))
                .remedy("move the light to the camera's side of the surfaces, or the camera to the light's: the light may be below a floor or behind a wall")
                .measure("distance", l.distance, "units");
            Some(Cause { finding, by: None })
        }
        None => None,
    }
}

/// Creates a finding about a light from a code, a weight and a text.
type Find<'a> = &'a dyn Fn(&'static str, f64, String) -> Finding;

/// A directional light from below the horizon.
fn below_horizon(e: &Evidence<'_>, l: &LightFacts, name: &Label, find: Find<'_>) -> Option<Finding> {
    let up = e.scene.prepared.view.camera_desc.clone().placement_mut()[2].normalize_or(DVec3::Y);
    let height = l.towards.dot(up);
    let is_sun = match l.emitter {
        ListedEmitter::Light(i) => matches!(e.scene.lights.get(i as usize), Some(Light::Directional(_))),
        ListedEmitter::Shape { .. } => false,
    };
    if !is_sun || height >= -1e-3 {
        return None;
    }
    let below = 90.0 - acos((-height).clamp(-1.0, 1.0)).to_degrees();
    let what = format!("{name} comes from {} degrees below the horizon", short(below));
    let finding = find("sun-below-horizon", 0.93, what)
        .why("the visible surfaces face up: the ground blocks the light, or faces away from it")
        .remedy("reverse its direction: `from` points towards the light, `direction` is the direction in which the light travels; a sky has `elevation`")
        .measure("below-horizon", below, "degrees");
    let Some(i) = e.light_number(l.emitter) else { return Some(finding) };
    let is_sky = matches!(e.desc.lights.get(i as usize).map(|l| &l.value), Some(LightDesc::Sky(_)));
    Some(match is_sky {
        true => finding.set(&format!("light.{i}.elevation"), 35.0),
        false => {
            let to = l.towards - 2.0 * height * up;
            finding.set(&format!("light.{i}.from"), to.to_array().map(rounded))
        }
    })
}

/// A light that an opaque object encloses: rays in nearly all directions hit it.
fn enclosed_light(
    e: &Evidence<'_>,
    l: &LightFacts,
    blocker: Option<&Blocker>,
    name: &Label,
    find: Find<'_>,
) -> Option<Cause> {
    let (encloser, shape) = l.encloser?;
    let is_enclosed = l.enclosed > 0.97
        && l.blocked > 0
        && blocker.is_some_and(|b| b.primitive == encloser || l.wall_distance < 0.5 * l.distance);
    if !is_enclosed {
        return None;
    }
    let encloser_name = e.labels.object_label(encloser, shape);
    let what = format!("{name} is inside {encloser_name}");
    let finding = find("light-enclosed", 0.95, what)
        .why(format!(
            "{} of all directions from the light end at an opaque surface; it reaches {} of the visible surface points",
            percent(l.enclosed),
            percent(f64::from(l.visible) / f64::from(l.sampled))
        ))
        .remedy(format!("move the light out of {encloser_name}, or make an opening in it. For light to pass through, give it a transmissive material, or `shadow = \"none\"` with \"classic\""))
        .measure("directions-enclosed", l.enclosed, "fraction");
    Some(Cause { finding, by: Some(encloser) })
}

/// A light that does not emit towards visible surfaces.
fn turned_away(e: &Evidence<'_>, l: &LightFacts, name: &Label, find: Find<'_>) -> Option<Finding> {
    let bounds = l.bounds?;
    let axis = l.axis.normalize_or_zero();
    let points = e.g.paths.iter().flatten().flat_map(|p| p.points.iter().map(|(p, _)| *p));
    let seen: Vec<DVec3> = points.chain(e.hits().map(|(_, _, m)| m.p)).collect();
    // The median, because floors that extend to the horizon would shift the mean.
    let median_of = |i: usize| super::picture::quantile(seen.iter().map(|p| p[i]), 0.5);
    let center = DVec3::new(median_of(0), median_of(1), median_of(2));
    let spot =
        e.light_number(l.emitter).and_then(|i| match e.desc.lights.get(i as usize).map(|l| &l.value) {
            Some(LightDesc::Spot(s)) => Some((i, s)),
            _ => None,
        });
    let spot_axis = spot.map_or(axis, |(_, s)| (s.look_at - s.position).normalize_or_zero());
    let to = (center - bounds.center()).normalize_or_zero();
    let angle = acos(spot_axis.dot(to).clamp(-1.0, 1.0)).to_degrees();
    if let Some((i, spot)) = spot {
        if angle < 45.0 && spot.angle < 5.0 {
            let what = format!("the cone of {name} is too narrow: {} degrees", short(spot.angle));
            return Some(
                find("spot-too-narrow", 0.93, what)
                    .why(format!(
                        "the centre of the visible surfaces is {} degrees off its axis",
                        short(angle)
                    ))
                    .remedy("widen it with `angle`, the degrees from its axis to the rim")
                    .set(&format!("light.{i}.angle"), rounded((angle + 15.0).clamp(20.0, 90.0)))
                    .measure("angle-off-axis", angle, "degrees")
                    .measure("cone", spot.angle, "degrees"),
            );
        }
        let what =
            format!("{name} points away: the visible surfaces are {} degrees off its axis", short(angle));
        return Some(
            find("light-faces-away", 0.93, what)
                .why(format!("its cone ends {} degrees from the axis", short(spot.angle)))
                .remedy("aim it with `look_at`")
                .set(&format!("light.{i}.look_at"), center.to_array().map(rounded))
                .measure("angle-off-axis", angle, "degrees")
                .measure("cone", spot.angle, "degrees"),
        );
    }
    if l.emitting <= 0.0 || l.emitting > 0.9 {
        return None;
    }
    let what = format!("{name} emits light away from all visible surfaces");
    let one_sided = matches!(l.emitter, ListedEmitter::Shape { .. });
    let why = if one_sided {
        "its material has `double_sided = false` and emits only on the side of the normal, which points away"
    } else {
        "it emits only in some directions, and none of them leads there"
    };
    let remedy = if one_sided {
        "flip the surface (swap `edge_u` and `edge_v`, or reverse the winding of a mesh), or set `double_sided = true`"
    } else {
        "rotate it"
    };
    Some(
        find("light-faces-away", 0.93, what)
            .why(format!(
                "{why}; the centre of the visible surfaces is {} degrees off its main direction",
                short(angle)
            ))
            .remedy(remedy)
            .measure("angle-off-axis", angle, "degrees")
            .measure("directions-lit", l.emitting, "fraction"),
    )
}

/// Delta lights behind refracting glass, which paths from the camera never find.
fn behind_glass(e: &Evidence<'_>, all_irradiance: f64) -> Option<Finding> {
    if !e.scene.integrator.capabilities().physical || e.g.by_light_paths.is_some() {
        return None;
    }
    let lost = |l: &LightFacts| {
        let fraction: f64 = l.blockers.iter().filter(|b| b.transmits).map(|b| b.fraction).sum();
        fraction * l.blocked_irradiance
    };
    let delta = |l: &&LightFacts| match l.emitter {
        ListedEmitter::Light(i) => e.scene.lights.get(i as usize).is_some_and(Light::is_delta),
        ListedEmitter::Shape { .. } => false,
    };
    let most = e.g.lights.iter().filter(delta).max_by(|a, b| lost(a).total_cmp(&lost(b)))?;
    let total: f64 = e.g.lights.iter().filter(delta).map(lost).sum();
    let fraction = total / (total + all_irradiance);
    if fraction.is_nan() || fraction < 0.05 {
        return None;
    }
    let b = most.blockers.iter().find(|b| b.transmits)?;
    let (name, glass) = (e.emitter_name(most.emitter), e.labels.object_label(b.primitive, b.shape));
    let severity = match fraction {
        s if e.is_black() && s > 0.5 => Severity::Error,
        s if s > 0.3 => Severity::Warning,
        _ => Severity::Note,
    };
    let what =
        format!("light of {name} that passes through {glass} is missing: {} of all light", percent(fraction));
    Some(
        Finding::new(BLACK, severity, "light-behind-glass", 0.91, what)
            .why("a BSDF-sampled ray never hits a light without extent, and light sampling needs a straight path, which refraction bends: the caustics are missing")
            .remedy("trace light paths; or give the light an extent: an object with a material of type \"emissive\" in its place, or `angle` of a directional light; or make the glass `thin_walled = true` with roughness 0, which does not bend light")
            .or(Remedy::set("integrator.type", "path").and("integrator.caustics", "light-tracing"))
            .about(name.text)
            .at(e.span_of(most.emitter))
            .measure("light-lost", fraction, "fraction")
            .measure("fraction-lost-at-it", b.fraction, "fraction"),
    )
}
