//! Warnings state what is wrong and have a remedy as data.

use super::lint;
use crate::color::Transfer;
use crate::description::{ObjectDesc, SceneDesc};
use crate::film::{Antialias, FilmDesc};
use crate::integrator::{IdsDesc, IntegratorDesc, PathDesc};
use crate::schema::{KeyEdit, PrepareOptions, Remedy, Warning, WarningKind};

/// A sphere without light.
fn scene(integrator: IntegratorDesc, film: FilmDesc) -> SceneDesc {
    let film = FilmDesc { width: 8, height: 8, ..film };
    SceneDesc { film, integrator, objects: vec![ObjectDesc::default()], ..SceneDesc::default() }
}

fn path() -> IntegratorDesc {
    IntegratorDesc::Path(PathDesc::default())
}

fn warnings(desc: &SceneDesc) -> Vec<Warning> {
    lint(desc, &desc.prepare(&PrepareOptions::default()).unwrap())
}

fn keys(warning: &Warning) -> Vec<String> {
    let Some(Remedy::Set(edits)) = &warning.remedy else { return Vec::new() };
    let path = |e: &KeyEdit| {
        let parts: Vec<&str> = e.path.iter().map(|part| part.key.as_str()).collect();
        parts.join(".")
    };
    edits.iter().map(path).collect()
}

#[test]
fn a_film_for_classic_does_not_suit_a_path_tracer() {
    let mut desc = scene(path(), FilmDesc::default());
    desc.background.color = crate::color::Spectrum::WHITE;
    let found = warnings(&desc);
    assert_eq!(found.len(), 2, "{found:?}");
    assert_eq!(keys(&found[0]), ["film.antialias", "film.samples"]);
    assert_eq!(keys(&found[1]), ["film.transfer"]);
    assert!(found.iter().all(|w| w.kind == WarningKind::Doubtful));
    desc.film = FilmDesc { width: 8, height: 8, ..FilmDesc::default_for("path") };
    assert_eq!(warnings(&desc), []);
}

#[test]
fn a_scene_without_light_can_have_the_studio() {
    let mut desc = scene(path(), FilmDesc::default_for("path"));
    let found = warnings(&desc);
    assert_eq!((found.len(), keys(&found[0])), (1, vec![super::STUDIO_KEY.to_owned()]), "{found:?}");
    desc.studio = Some(crate::description::default_studio::StudioDesc::default());
    assert_eq!(warnings(&desc), []);
}

#[test]
fn ids_take_one_sample_per_pixel() {
    let ids = IntegratorDesc::Ids(IdsDesc::default());
    let film = FilmDesc {
        antialias: Antialias::MonteCarlo,
        samples: 32,
        transfer: Transfer::Srgb,
        ..FilmDesc::default()
    };
    let desc = scene(ids.clone(), film);
    let prepared = desc.prepare(&PrepareOptions::default()).unwrap();
    assert_eq!(prepared.view.film.samples_per_pixel(), 1);
    let found = lint(&desc, &prepared);
    assert_eq!((found.len(), found[0].kind), (1, WarningKind::Note), "{found:?}");
    assert_eq!(warnings(&scene(ids, FilmDesc::default())), []);
}
