//! Several light samples at the first surface: the same light, and no trace of what was traced before they were chosen.

use super::estimators::windowed_room;
use crate::description::SceneDesc;
use crate::integrator::{Caustics, LightSampling, PathDesc, SharedPathsMode};
use crate::light::{EnvironmentDesc, LightDesc};
use crate::material::PrincipledMaterial;
use crate::schema::PrepareOptions;
use crate::testing::scenes::{
    emissive, grey, lamp, matte, mean_of, path, plane, rectangle, render_prepared, rgb, sphere, v,
};

/// A dull ball, a plastic one, a mirror and a pane of clear glass on a dull floor.
fn balls(settings: PathDesc) -> SceneDesc {
    let plastic = PrincipledMaterial { base_color: rgb([0.2, 0.5, 0.7]), ..PrincipledMaterial::default() };
    let mirror = PrincipledMaterial {
        base_metalness: grey(1.0),
        specular_roughness: grey(0.0),
        ..PrincipledMaterial::default()
    };
    let pane = PrincipledMaterial {
        transmission_weight: grey(1.0),
        specular_roughness: grey(0.0),
        thin_walled: true,
        ..PrincipledMaterial::default()
    };
    path(settings)
        .seen_at(v(0.0, 1.2, 5.0), v(0.0, 0.6, 0.0), 45.0)
        .with(plane(), matte(grey(0.5)))
        .with(sphere(v(-1.2, 0.6, 0.0), 0.6), matte(rgb([0.8, 0.4, 0.3])))
        .with(sphere(v(0.0, 0.6, 0.0), 0.6), plastic)
        .with(sphere(v(1.2, 0.6, 0.0), 0.6), mirror)
        .with(rectangle(v(-0.6, 0.6, 1.5), v(0.8, 0.0, 0.0), v(0.0, 0.8, 0.0)), pane)
}

fn sky() -> LightDesc {
    LightDesc::Environment(EnvironmentDesc::studio())
}

fn settings(light_samples: Option<u32>) -> PathDesc {
    let shared_paths = SharedPathsMode::Off;
    PathDesc { max_depth: 4, light_samples, caustics: Caustics::Off, shared_paths, ..PathDesc::default() }
}

#[test]
fn the_mean_is_kept() {
    for light_sampling in [LightSampling::Both, LightSampling::Light] {
        let by = |samples, light_samples| {
            let desc = balls(PathDesc { light_sampling, ..settings(Some(light_samples)) }).lit(sky());
            let lamp = rectangle(v(-1.0, 2.5, 1.0), v(1.0, 0.0, 0.0), v(0.0, 0.0, 1.0));
            mean_of(24, samples, desc.with(lamp, emissive(4.0, grey(1.0))))
        };
        let one = by(64, 1);
        for light_samples in [2, 5] {
            by(32, light_samples).agrees(&one, 0.01);
        }
    }
}

/// Dull balls on a dull floor under a large lamp.
fn under_lamp(settings: PathDesc) -> SceneDesc {
    let ball = |x: f64| sphere(v(x, 0.6, 0.0), 0.6);
    path(settings)
        .seen_at(v(0.0, 2.0, 5.0), v(0.0, 0.4, 0.0), 45.0)
        .with(plane(), matte(grey(0.5)))
        .with(ball(-1.2), matte(rgb([0.8, 0.4, 0.3])))
        .with(ball(1.2), matte(rgb([0.3, 0.4, 0.8])))
        .with(rectangle(v(-2.0, 3.5, -2.0), v(4.0, 0.0, 0.0), v(0.0, 0.0, 4.0)), emissive(4.0, grey(1.0)))
}

/// The number of light samples of a scene.
fn chosen(desc: &SceneDesc) -> u32 {
    let prepared = desc.prepare(&PrepareOptions::default()).unwrap();
    prepared.choose(0);
    prepared.path().and_then(|path| path.choice.get()).map_or(0, |choice| choice.light_samples)
}

#[test]
fn several_are_chosen_where_they_pay() {
    let under_lamp = |light_samples| under_lamp(settings(light_samples));
    assert!(chosen(&under_lamp(None)) > 1);
    // As asked.
    assert_eq!(chosen(&under_lamp(Some(1))), 1);
    assert_eq!(chosen(&under_lamp(Some(7))), 7);
    // As few and as many as are possible.
    assert_eq!([0, u32::MAX].map(|number| chosen(&under_lamp(Some(number)))), [1, 256]);
    // A point light has no points to choose from, and without lights there is nothing to sample.
    assert_eq!(chosen(&balls(settings(None)).lit(lamp(v(0.0, 3.0, 2.0), 9.0))), 1);
    assert_eq!(chosen(&balls(settings(None))), 1);
}

/// With several threads a preview is traced while the integrator makes its choices.
#[test]
fn samples_from_before_the_choices_are_not_kept() {
    let room = windowed_room(settings(Some(1)));
    for desc in [under_lamp(settings(None)), room] {
        let desc = desc.filmed([64, 48], 2);
        let picture = |threads| {
            let integrator = desc.integrator.integrator();
            let scene = desc.prepare_unchosen(integrator, &PrepareOptions::default()).unwrap();
            let (picture, _) = render_prepared(scene.clone(), threads, u32::MAX);
            assert!(!scene.integrator.keeps_samples());
            picture.linear
        };
        let one = picture(1);
        assert!(one == picture(3));
        assert!(one.iter().flatten().any(|v| *v > 0.0));
    }
}

/// A first surface that only the mirror shows has as many light samples as one that is seen.
#[test]
fn mirrors_show_as_little_noise() {
    let error = |light_samples| {
        let by = |seed: u32, samples, light_samples| {
            let mirror = PrincipledMaterial {
                base_metalness: grey(1.0),
                base_color: grey(1.0),
                specular_roughness: grey(0.0),
                ..PrincipledMaterial::default()
            };
            let mut desc = path(PathDesc { max_depth: 2, ..settings(Some(light_samples)) })
                .seen_at(v(0.0, 1.0, 3.0), v(0.0, 1.0, 0.0), 20.0)
                .with(rectangle(v(-2.0, -1.0, 0.0), v(4.0, 0.0, 0.0), v(0.0, 4.0, 0.0)), mirror)
                .with(rectangle(v(-4.0, -3.0, 8.0), v(0.0, 8.0, 0.0), v(8.0, 0.0, 0.0)), matte(grey(0.5)))
                .lit(sky())
                .filmed([16, 16], samples);
            desc.film.seed = seed;
            let scene = desc.prepare(&PrepareOptions::default()).unwrap();
            render_prepared(scene, 2, u32::MAX).0.linear
        };
        let exact = by(1, 256, 8);
        let noisy = by(2, 4, light_samples);
        let terms = exact.iter().zip(&noisy).map(|(a, b)| f64::from(a[1] - b[1]) * f64::from(a[1] - b[1]));
        terms.sum::<f64>()
    };
    let (one, four) = (error(1), error(4));
    assert!(one > 0.0 && four < 0.75 * one, "{one} {four}");
}
