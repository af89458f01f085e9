//! Light that fog, smoke or the inside of glass swallows, found by looking at the same pixels without it.

use std::sync::Arc;

use super::evidence::Evidence;
use super::finding::{Finding, Question, Severity, percent, rounded, short};
use super::grid::Pixel;
use super::trial::{self, Trial};
use super::{Options, materials};
use crate::color::Spectrum;
use crate::doctor::subject::Subject;
use crate::material::Material;
use crate::medium::{Medium, MediumDesc};
use crate::scene::Scene;
use crate::schema::{ColorSource, MaterialId};

const WHITE: ColorSource = ColorSource::Constant(Spectrum::WHITE);
const BLACK: ColorSource = ColorSource::Constant(Spectrum::BLACK);

/// The most media, and the most materials, that are tried.
const MOST: usize = 8;

/// What swallows light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Absorber {
    /// A medium by its number.
    Medium(u32),
    /// The inside of a transparent material.
    Inside(MaterialId),
}

/// What the picture is without it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Without {
    pub(super) what: Absorber,
    pub(super) trial: Trial,
}

/// Tries each medium and each transparent material that absorbs. The scene is as before afterwards.
pub(super) fn try_without(
    scene: &mut Subject,
    pixels: &[Pixel],
    samples: u32,
    options: &Options<'_>,
) -> Vec<Without> {
    let media = scene.volumes.as_ref().map_or(0, |v| v.count()).min(MOST) as u32;
    let absorbing: Vec<MaterialId> =
        (0..scene.materials.len() as u32).map(MaterialId).filter(|m| absorbs(scene, *m)).take(MOST).collect();
    let media = (0..media).map(Absorber::Medium);
    let all: Vec<Absorber> = media.chain(absorbing.into_iter().map(Absorber::Inside)).collect();
    if all.is_empty() {
        return Vec::new();
    }
    let before = trial::light(scene, pixels, samples, options);
    let mut out = Vec::new();
    for what in all {
        let after = match what {
            Absorber::Medium(id) => {
                let Some(own) = exchange(scene, id, Medium::void()) else { continue };
                let after = trial::light(scene, pixels, samples, options);
                exchange(scene, id, own);
                after
            }
            Absorber::Inside(id) => {
                let Some(color) = inside(scene, id) else { continue };
                let own = std::mem::replace(color, WHITE);
                let after = trial::light(scene, pixels, samples, options);
                if let Some(color) = inside(scene, id) {
                    *color = own;
                }
                after
            }
        };
        out.push(Without { what, trial: trial::compare(&before, &after) });
    }
    out
}

fn exchange(scene: &mut Subject, id: u32, medium: Medium) -> Option<Medium> {
    Arc::make_mut(scene.scene_mut().volumes.as_mut()?).exchange(id, medium)
}

/// Whether the inside of a transparent material absorbs.
fn absorbs(scene: &Scene, id: MaterialId) -> bool {
    match scene.materials.get(id.index()) {
        Some(Material::OpenPbr(m)) => {
            let d = &m.desc;
            d.transmission_weight != BLACK && d.transmission_depth > 0.0 && d.transmission_color != WHITE
        }
        _ => false,
    }
}

/// The colour that light has after the way that a transparent material states; `None` if its inside does not absorb.
fn inside(scene: &mut Subject, id: MaterialId) -> Option<&mut ColorSource> {
    match Arc::make_mut(&mut scene.scene_mut().materials).get_mut(id.index())? {
        Material::OpenPbr(m) if m.desc.transmission_weight != BLACK && m.desc.transmission_depth > 0.0 => {
            Some(&mut m.desc.transmission_color).filter(|c| **c != WHITE)
        }
        _ => None,
    }
}

/// Whether a picture is dark for the light that something swallows.
pub(super) fn ask(e: &Evidence<'_>, out: &mut Vec<Finding>) {
    let found = e.g.without.iter().max_by(|a, b| a.trial.ratio.total_cmp(&b.trial.ratio));
    let Some(found) = found else { return };
    let ratio = found.trial.ratio;
    let severity = match e.is_black() {
        true if ratio > 1.5 => Severity::Error,
        false if ratio > 20.0 => Severity::Warning,
        _ => return,
    };
    let lost = if ratio.is_finite() { percent(1.0 - 1.0 / ratio) } else { "all".to_owned() };
    let more =
        if ratio.is_finite() { format!("{} times the light", short(ratio)) } else { "light".to_owned() };
    let measured = |f: Finding| {
        f.measure("light-without-it", ratio, "ratio").measure(
            "pixels-that-get-brighter",
            found.trial.brighter,
            "share",
        )
    };
    match found.what {
        Absorber::Medium(id) => {
            let Some(medium) = e.desc.media.get(id as usize) else { return };
            let name = medium.name.clone().unwrap_or_else(|| format!("medium #{id}"));
            let extinction = e.scene.volumes.as_ref().map_or(0.0, |v| v.extinction(id));
            let way = if extinction > 0.0 { 1.0 / extinction } else { f64::INFINITY };
            let what = format!("the medium \"{name}\" swallows {lost} of the light");
            let finding = Finding::new(Question::Black, severity, "medium-too-dense", 0.985, what)
                .why(format!(
                    "light goes {} units through it on average, where it is as dense as it says, and surfaces that are seen are {} units away; without it the same samples bring {more}",
                    short(way),
                    short(distance(e))
                ))
                .remedy(format!(
                    "make it thinner: about {} times as dense leaves a third on the way to what is seen; or move the camera and the lights out of it",
                    short(thinner(e, extinction))
                ))
                .set(&format!("medium.{name}.density"), rounded(density(&medium.value) * thinner(e, extinction)));
            // Media in place have no name that a key path could use.
            let finding =
                if medium.name.is_some() { finding } else { Finding { remedies: Vec::new(), ..finding } };
            out.push(measured(finding.about(name)).measure("mean-way-of-light", way, "units"));
        }
        Absorber::Inside(id) => {
            let name = e.labels.material(id);
            let depth = e.scene.materials.get(id.index()).and_then(materials::absorbing_depth).unwrap_or(0.0);
            let what = format!("the inside of \"{name}\" swallows {lost} of the light");
            let finding = Finding::new(Question::Black, severity, "glass-too-dark", 0.985, what)
                .why(format!(
                    "its colour is what is left of white after {} units, and nothing after a few times that; clear, the same samples bring {more}",
                    short(depth)
                ))
                .remedy("raise `depth` (`transmission_depth` of \"principled\") to the size of the body, or choose a lighter colour");
            out.push(measured(finding.about(name)).measure("depth", depth, "units"));
        }
    }
}

/// How far away the surfaces are that are seen, the middle of them.
fn distance(e: &Evidence<'_>) -> f64 {
    super::picture::quantile(e.mets().map(|(_, _, met)| met.t), 0.5)
}

/// The factor of density that a medium has now.
fn density(medium: &MediumDesc) -> f64 {
    match medium {
        MediumDesc::Homogeneous(m) => m.density,
        MediumDesc::Grid(m) => m.density,
        MediumDesc::Smoke(m) => m.density,
    }
}

/// The factor that makes the way to what is seen one mean way of light, at most 1.
fn thinner(e: &Evidence<'_>, extinction: f64) -> f64 {
    let depth = extinction * distance(e);
    if depth > 1.0 { 1.0 / depth } else { 0.1 }
}
