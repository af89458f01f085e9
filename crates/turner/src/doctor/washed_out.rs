//! Rules for pictures that are too bright or have no contrast.

use super::black::strength_key;
use super::evidence::Evidence;
use super::finding::{Finding, Question, Severity, percent, rounded, short};
use super::kind::Source;
use super::picture::{quantile, show};
use crate::color::{Tonemap, Transfer};
use crate::math::elementary::ln;
use crate::scene::ListedEmitter;

pub(super) fn check(e: &Evidence<'_>, out: &mut Vec<Finding>) {
    let p = &e.picture;
    if p.shown.is_empty() {
        return;
    }
    if e.is_black() {
        let is_linear =
            e.scene.integrator.capabilities().physical && e.scene.film().transfer == Transfer::None;
        out.extend(is_linear.then(transfer_missing));
        return;
    }
    let find = |severity, code, weight, what: String| {
        Finding::new(Question::WashedOut, severity, code, weight, what)
    };
    let measured = |f: Finding| {
        f.measure("white-pixels", p.white, "fraction")
            .measure("clipped-pixels", p.clipped, "fraction")
            .measure("saturation", p.saturation, "fraction")
    };
    let objects_white = objects_white(e);
    let too_bright = objects_white > 0.3 || p.white > 0.6;
    let severity = if objects_white > 0.6 || p.white > 0.8 { Severity::Error } else { Severity::Warning };
    let stops = {
        let middle = quantile(p.light.iter().copied(), 0.75) * p.factor;
        (ln(middle.max(1e-30) / 0.6) * std::f64::consts::LOG2_E).ceil().max(1.0)
    };
    if too_bright {
        let film = e.scene.film();
        let white = |factor: f64| {
            let list = e.g.colors.iter().map(|c| show(film, c, factor).into_iter().fold(1.0, f64::min));
            let (n, all) =
                list.fold((0.0, 0.0), |(n, all), v| (n + f64::from(u8::from(v >= 0.985)), all + 1.0));
            n / f64::max(all, 1.0)
        };
        let plain = white(1.0);
        if film.exposure >= 0.5 && plain < 0.5 * p.white {
            let what = format!(
                "the exposure of {} stops makes {} of the pixels white",
                short(film.exposure),
                percent(p.white)
            );
            out.push(measured(
                find(severity, "exposure-too-high", 0.9, what)
                    .why(format!("at exposure 0 it is {}", percent(plain)))
                    .remedy("lower `exposure` of [film]")
                    .set("film.exposure", 0.0)
                    .measure("exposure", film.exposure, "stops")
                    .measure("white-pixels-at-exposure-0", plain, "fraction"),
            ));
        } else {
            out.push(measured(too_strong(e, severity, stops)));
        }
    }
    if !too_bright && let Some(f) = flat(e) {
        out.push(measured(f));
    }
    if let Some(f) = albedo(e) {
        out.push(f);
    }
    let physical = e.scene.integrator.capabilities().physical;
    if physical && e.scene.film().transfer == Transfer::None {
        out.push(transfer_missing());
    } else if physical && e.scene.film().tonemap == Tonemap::None && p.clipped > 0.1 && !too_bright {
        let what = format!("{} of the pixels are clipped at the brightest value", percent(p.clipped));
        out.push(measured(
            find(Severity::Note, "tonemap-missing", 0.4, what)
                .why("without tone mapping values above 1 are clipped, and bright colours turn white")
                .remedy("set `tonemap` in [film]")
                .set("film.tonemap", "agx"),
        ));
    }
}

/// The finding for linear values in a picture for displays.
fn transfer_missing() -> Finding {
    let what = "`transfer = \"none\"` writes light to the picture without the sRGB curve: it looks too dark";
    Finding::new(Question::Black, Severity::Warning, "transfer-missing", 0.4, what)
        .why("displays expect sRGB values. Without the curve midtones look too dark, and brighter lights to compensate for that wash out the rest")
        .remedy("set `transfer = \"srgb\"` in [film]; colours given as #rrggbb are then decoded with the same curve. EXR and HDR files are not affected")
        .set("film.transfer", "srgb")
}

/// The fraction of white pixels among those that show a non-emissive surface.
fn objects_white(e: &Evidence<'_>) -> f64 {
    let list: Vec<f64> = e
        .hits()
        .filter(|(_, _, m)| !m.emits)
        .filter_map(|(i, _, _)| e.g.colors.get(i))
        .map(|c| show(e.scene.film(), c, e.picture.factor).into_iter().fold(1.0, f64::min))
        .collect();
    if list.len() < 8 { 0.0 } else { list.iter().filter(|v| **v >= 0.985).count() as f64 / list.len() as f64 }
}

/// The finding about the light that is too strong.
fn too_strong(e: &Evidence<'_>, severity: Severity, stops: f64) -> Finding {
    let q = Question::WashedOut;
    let factor = crate::math::elementary::pow(2.0, -stops);
    let lower = |f: Finding| f.set("film.exposure", rounded(e.scene.film().exposure - stops));
    let ambient = ambient_share(e);
    if ambient > 0.5 {
        let what = format!("ambient light is {} of all light and makes the picture white", percent(ambient));
        let finding = Finding::new(q, severity, "ambient-too-strong", 0.8, what)
            .why("ambient light is the same from all directions: it removes shadows and contrast")
            .remedy(format!("multiply its `intensity` by about {}", short(factor)))
            .measure("fraction-of-light", ambient, "fraction");
        return lower(finding);
    }
    let strongest = e.g.lights.iter().max_by(|a, b| a.irradiance.total_cmp(&b.irradiance));
    let by_paths = e.by_source.iter().max_by(|a, b| a.1[0].total_cmp(&b.1[0]));
    let irradiance: f64 = e.g.lights.iter().map(|l| l.irradiance).sum();
    let (name, fraction, light) = match (by_paths, strongest) {
        (Some((source, sums)), _) => {
            let light = match source {
                Source::Light(i) => e.light_number(ListedEmitter::Light(*i)),
                _ => None,
            };
            (e.source(*source), sums[0] / e.all[0].max(f64::MIN_POSITIVE), light)
        }
        (None, Some(l)) => (
            e.emitter_name(l.emitter),
            l.irradiance / irradiance.max(f64::MIN_POSITIVE),
            e.light_number(l.emitter),
        ),
        (None, None) => {
            let what = "the picture is white, though no light could be identified".to_owned();
            return lower(Finding::new(q, severity, "overexposed", 0.7, what).remedy("lower the exposure"));
        }
    };
    let what = format!(
        "{name} is too strong: it is the source of {} of the light, and {} of the pixels are white",
        percent(fraction),
        percent(e.picture.white)
    );
    let key =
        light.and_then(|i| e.desc.lights.get(i as usize).and_then(|l| Some((i, strength_key(&l.value)?))));
    let mut finding = Finding::new(q, severity, "light-too-strong", 0.8, what)
        .why(format!("surfaces are {} stops brighter than white", short(stops)))
        .remedy(format!(
            "multiply its strength by about {}, or lower the exposure by {} stops",
            short(factor),
            short(stops)
        ))
        .about(name.text)
        .at(light.and_then(|i| e.desc.lights.get(i as usize)?.span))
        .measure("fraction-of-light", fraction, "fraction")
        .measure("stops-too-bright", stops, "stops");
    if let Some((i, (key, now))) = key {
        finding = finding.set(&format!("light.{i}.{key}"), rounded(now * factor));
    }
    lower(finding).set("film.auto_exposure", true)
}

/// The ambient fraction of all light.
fn ambient_share(e: &Evidence<'_>) -> f64 {
    let ambient = f64::from(e.scene.ambient.luminance());
    if ambient <= 0.0 {
        return 0.0;
    }
    if e.scene.integrator.capabilities().physical {
        return e.by_source.get(&Source::Ambient).map_or(0.0, |s| s[0] / e.all[0].max(f64::MIN_POSITIVE));
    }
    let irradiance: f64 = e.g.lights.iter().map(|l| l.irradiance).sum();
    ambient / (ambient + irradiance)
}

/// A bright picture without contrast, due to ambient light.
fn flat(e: &Evidence<'_>) -> Option<Finding> {
    let shown: Vec<f64> = e
        .hits()
        .filter(|(_, _, m)| !m.emits)
        .filter_map(|(i, _, _)| e.picture.shown.get(i).copied())
        .collect();
    if shown.len() < 30 {
        return None;
    }
    let (low, middle, high) = (
        quantile(shown.iter().copied(), 0.05),
        quantile(shown.iter().copied(), 0.5),
        quantile(shown.iter().copied(), 0.95),
    );
    let ambient = ambient_share(e);
    if middle < 0.35 || high - low > 0.3 || ambient < 0.6 {
        return None;
    }
    let what = format!("ambient light is {} of all light: there is almost no contrast", percent(ambient));
    Some(
        Finding::new(Question::WashedOut, Severity::Warning, "ambient-too-strong", 0.6, what)
            .why(format!("90 % of the surfaces are displayed between {} and {} (of 1)", short(low), short(high)))
            .remedy("lower the `intensity` of the ambient light, and raise that of lights with a position or a direction")
            .measure("fraction-of-light", ambient, "fraction")
            .measure("contrast", high - low, "fraction"),
    )
}

/// Surfaces with an albedo close to 1.
fn albedo(e: &Evidence<'_>) -> Option<Finding> {
    if !e.scene.integrator.capabilities().physical {
        return None;
    }
    let through = |m| super::materials::transmits(e.scene, m);
    let list: Vec<_> =
        e.hits().filter(|(_, _, m)| !m.emits && !through(m.material)).map(|(_, _, m)| m).collect();
    let white = list.iter().filter(|m| m.albedo > 0.95 && !metal(e, m.material)).count() as f64
        / list.len().max(1) as f64;
    let indirect =
        e.by_kind.get(&super::PathKind::Indirect).map_or(0.0, |s| s[0] / e.all[0].max(f64::MIN_POSITIVE));
    if white < 0.3 || list.len() < 30 || indirect < 0.3 {
        return None;
    }
    let hit = list.iter().find(|m| m.albedo > 0.95)?;
    let name = e.labels.material_label(hit.material);
    let what = format!(
        "{} of the surfaces reflect over 95 % of the light; one of their materials is {name}",
        percent(white)
    );
    Some(
        Finding::new(
            Question::WashedOut,
            Severity::Warning,
            "albedo-too-high",
            if indirect > 0.6 { 0.9 } else { 0.5 },
            what,
        )
        .why(format!(
            "light bounces between them: {} of the light is indirect. White paint reflects 80 %, snow 90 %",
            percent(indirect)
        ))
        .remedy("lower their `color` to 0.8 or less, which also renders faster")
        .about(name.text)
        .measure("bright-surfaces", white, "fraction")
        .measure("indirect-light", indirect, "fraction"),
    )
}

fn metal(e: &Evidence<'_>, id: crate::schema::MaterialId) -> bool {
    use crate::schema::ColorSource::Constant;
    super::materials::principled(e.desc, id)
        .is_some_and(|m| !matches!(m.base_metalness, Constant(c) if c.max_component() < 0.5))
}
