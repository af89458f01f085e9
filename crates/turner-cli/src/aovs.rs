//! AOVs in files: the channels of an EXR file, and the attributes that name their numbers.

use std::collections::BTreeMap;

use serde_json::{Value, json};
use turner::film::{FilmDesc, LabelKind};
use turner::render::{AovValues, Renderer, label_name};
use turner::scene::Scene;
use turner_io::image::{ExtraChannel, Metadata, SampleKind};

/// The channels of the film's AOVs, developed on `threads` threads.
pub(crate) fn channels(renderer: &Renderer, threads: usize) -> Vec<ExtraChannel<'static>> {
    let channel = |c: turner::render::AovChannel| match c.values {
        AovValues::Float(values) => ExtraChannel::new(c.name, SampleKind::Float, values),
        AovValues::Uint(values) => ExtraChannel::new(c.name, SampleKind::Uint, values),
    };
    let mut channels: Vec<_> = renderer.develop_aovs(threads).into_iter().map(channel).collect();
    if renderer.denoises() {
        channels.extend(raw(renderer, threads));
    }
    channels
}

/// The layer `raw`: the picture before the denoiser.
fn raw(renderer: &Renderer, threads: usize) -> impl Iterator<Item = ExtraChannel<'static>> {
    let film = &renderer.film;
    let (desc, rows) = (&renderer.prepared().view.film, 0..film.crop.height);
    let linear = film.developed(desc, threads).linear(rows, threads).into_owned();
    ["raw.R", "raw.G", "raw.B"].into_iter().enumerate().map(move |(c, name)| {
        let values: Vec<f32> = linear.iter().map(|pixel| pixel[c]).collect();
        ExtraChannel::new(name.to_owned(), SampleKind::Float, values)
    })
}

/// The metadata of an EXR file with AOVs: that of the picture, and what describes the channels.
pub(crate) fn metadata(renderer: &Renderer, picture: &Metadata) -> Metadata {
    // "Software" is PNG's own keyword.
    let name = |name: &str| if name == "Software" { "turner:software".to_owned() } else { name.to_owned() };
    let mut out: Metadata = picture.iter().map(|(key, value)| (name(key), value.clone())).collect();
    out.extend(renderer.aov_attributes().into_iter().map(|(key, value)| (key, value.as_str().into())));
    out
}

/// For each AOV with numbers: the name of each number.
pub(crate) fn numbers(film: &FilmDesc, scene: &Scene) -> BTreeMap<&'static str, Value> {
    let of = |kind: LabelKind| {
        let count = match kind {
            LabelKind::Object => scene.stats.primitives as usize,
            LabelKind::Material => scene.materials.len(),
            LabelKind::Instance => scene.entry_count(),
        };
        (0..count as u32)
            .map(|label| ((label + 1).to_string(), json!(label_name(scene, kind, label))))
            .collect()
    };
    film.aovs.iter().filter_map(|aov| Some((aov.word(), Value::Object(of(aov.labels()?))))).collect()
}
