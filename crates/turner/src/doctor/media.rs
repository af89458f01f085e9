//! Rules for light that media or coloured glass absorb, measured by trials without them.

use std::sync::Arc;

use super::evidence::Evidence;
use super::finding::{Finding, Question, Severity, percent, rounded, short};
use super::grid::Pixel;
use super::trial::{self, Trial};
use super::{Options, materials};
use crate::color::Spectrum;
use crate::description::Label;
use crate::doctor::subject::Subject;
use crate::material::Material;
use crate::medium::{Medium, MediumDesc};
use crate::scene::Scene;
use crate::schema::{ColorSource, MaterialId};

const WHITE: ColorSource = ColorSource::Constant(Spectrum::WHITE);
const BLACK: ColorSource = ColorSource::Constant(Spectrum::BLACK);

/// Maximum number of media, and of materials, that are tried.
const MAX: usize = 8;

/// A cause of absorption.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Absorber {
    /// A medium, by its index.
    Medium(u32),
    /// The interior of a transparent material.
    Inside(MaterialId),
}

/// The trial without an absorber.
#[derive(Clone, Copy, Debug)]
pub(super) struct Without {
    pub(super) what: Absorber,
    pub(super) trial: Trial,
}

/// Tries the scene without each medium and without the absorption of each transparent material. Restores the scene.
pub(super) fn try_without(
    scene: &mut Subject,
    pixels: &[Pixel],
    samples: u32,
    options: &Options<'_>,
) -> Vec<Without> {
    let media = scene.volumes.as_ref().map_or(0, |v| v.count()).min(MAX) as u32;
    let absorbing: Vec<MaterialId> =
        (0..scene.materials.len() as u32).map(MaterialId).filter(|m| absorbs(scene, *m)).take(MAX).collect();
    let media = (0..media).map(Absorber::Medium);
    let all: Vec<Absorber> = media.chain(absorbing.into_iter().map(Absorber::Inside)).collect();
    if all.is_empty() {
        return Vec::new();
    }
    let before = trial::mean_luminances(scene, pixels, samples, options);
    let mut out = Vec::new();
    for what in all {
        let after = match what {
            Absorber::Medium(id) => {
                let Some(own) = exchange(scene, id, Medium::void()) else { continue };
                let after = trial::mean_luminances(scene, pixels, samples, options);
                exchange(scene, id, own);
                after
            }
            Absorber::Inside(id) => {
                let Some(color) = inside(scene, id) else { continue };
                let own = std::mem::replace(color, WHITE);
                let after = trial::mean_luminances(scene, pixels, samples, options);
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

/// Whether the interior of a transparent material absorbs light.
fn absorbs(scene: &Scene, id: MaterialId) -> bool {
    match scene.materials.get(id.index()) {
        Some(Material::OpenPbr(m)) => {
            let d = &m.desc;
            d.transmission_weight != BLACK && d.transmission_depth > 0.0 && d.transmission_color != WHITE
        }
        _ => false,
    }
}

/// The `transmission_color` of a transparent material, mutable: the colour of white light after `transmission_depth`.
/// `None` if its interior does not absorb.
fn inside(scene: &mut Subject, id: MaterialId) -> Option<&mut ColorSource> {
    match Arc::make_mut(&mut scene.scene_mut().materials).get_mut(id.index())? {
        Material::OpenPbr(m) if m.desc.transmission_weight != BLACK && m.desc.transmission_depth > 0.0 => {
            Some(&mut m.desc.transmission_color).filter(|c| **c != WHITE)
        }
        _ => None,
    }
}

/// The finding for an absorber that makes the picture dark.
pub(super) fn check(e: &Evidence<'_>, out: &mut Vec<Finding>) {
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
        f.measure("brightness-ratio", ratio, "ratio").measure(
            "pixels-brightened",
            found.trial.brighter,
            "fraction",
        )
    };
    match found.what {
        Absorber::Medium(id) => {
            let Some(medium) = e.desc.media.get(id as usize) else { return };
            let name = medium.name.clone().unwrap_or_else(|| format!("{} medium", medium.value.type_name()));
            let label = Label { text: name.clone(), is_name: medium.name.is_some() };
            let extinction = e.scene.volumes.as_ref().map_or(0.0, |v| v.extinction(id));
            let mean_free_path = if extinction > 0.0 { 1.0 / extinction } else { f64::INFINITY };
            let what = format!("{label} absorbs or scatters away {lost} of the light");
            let finding = Finding::new(Question::Black, severity, "medium-too-dense", 0.985, what)
                .why(format!(
                    "the mean free path in it is {} units at its full density, and visible surfaces are {} units away; without it the same samples give {more}",
                    short(mean_free_path),
                    short(distance(e))
                ))
                .remedy(format!(
                    "lower its density: about {} times the density lets a third of the light reach the visible surfaces; or move the camera and the lights out of it",
                    short(thinning(e, extinction))
                ))
                .set(&format!("medium.{name}.density"), rounded(density(&medium.value) * thinning(e, extinction)));
            // A medium written in place has no name for a key path.
            let finding =
                if medium.name.is_some() { finding } else { Finding { remedies: Vec::new(), ..finding } };
            let finding = finding.about(name).at(medium.span);
            out.push(measured(finding).measure("mean-free-path", mean_free_path, "units"));
        }
        Absorber::Inside(id) => {
            let name = e.labels.material_label(id);
            let depth = e.scene.materials.get(id.index()).and_then(materials::absorbing_depth).unwrap_or(0.0);
            let what = format!("the interior of {name} absorbs {lost} of the light");
            let finding = Finding::new(Question::Black, severity, "glass-too-dark", 0.985, what)
                .why(format!(
                    "white light has its colour after {} units and is almost gone after a few times that; with clear glass the same samples give {more}",
                    short(depth)
                ))
                .remedy("raise `depth` (`transmission_depth` of \"principled\") to the size of the object, or choose a lighter colour");
            let finding = finding.about(name.text).at(e.desc.materials.get(id.index()).and_then(|m| m.span));
            out.push(measured(finding).measure("depth", depth, "units"));
        }
    }
}

/// The median distance to visible surfaces.
fn distance(e: &Evidence<'_>) -> f64 {
    super::picture::quantile(e.hits().map(|(_, _, hit)| hit.t), 0.5)
}

/// The `density` key of a medium.
fn density(medium: &MediumDesc) -> f64 {
    match medium {
        MediumDesc::Homogeneous(m) => m.density,
        MediumDesc::Grid(m) => m.density,
        MediumDesc::Smoke(m) => m.density,
        MediumDesc::Cloud(_) => 1.0,
    }
}

/// The density factor, at most 1, for which the distance to visible surfaces is one mean free path.
fn thinning(e: &Evidence<'_>, extinction: f64) -> f64 {
    let depth = extinction * distance(e);
    if depth > 1.0 { 1.0 / depth } else { 0.1 }
}
