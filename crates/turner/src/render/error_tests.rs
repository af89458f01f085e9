//! Intervals of the error estimate cover the truth as often as they say.

use std::sync::atomic::AtomicBool;

use super::{PassOptions, Renderer};
use crate::color::Spectrum;
use crate::description::SceneDesc;
use crate::film::{Antialias, ErrorEstimate};
use crate::filter::FilterKind;
use crate::integrator::{Caustics, PathDesc, SharedPathsMode};
use crate::light::{LightDesc, PointDesc};
use crate::material::{MaterialDesc, PrincipledMaterial};
use crate::schema::{ColorSource, PrepareOptions};
use crate::testing::scenes::{emissive, grey, path, rectangle, sphere, v};

/// A room with a lamp: direct light, a little indirect light.
fn room(shared_paths: SharedPathsMode) -> SceneDesc {
    let settings = PathDesc { caustics: Caustics::Off, shared_paths, max_depth: 5, ..PathDesc::default() };
    let grey_wall = || PrincipledMaterial {
        base_color: grey(0.7),
        specular_weight: grey(0.0),
        ..PrincipledMaterial::default()
    };
    path(settings)
        .with(rectangle(v(0.0, -1.0, 0.0), v(4.0, 0.0, 0.0), v(0.0, 0.0, -4.0)), grey_wall())
        .with(rectangle(v(0.0, 0.0, -2.0), v(4.0, 0.0, 0.0), v(0.0, 4.0, 0.0)), grey_wall())
        .with(rectangle(v(-1.5, 0.0, 0.0), v(0.0, 4.0, 0.0), v(0.0, 0.0, -4.0)), grey_wall())
        .with(sphere(v(0.3, -0.5, -0.8), 0.5), PrincipledMaterial::default())
        .with(rectangle(v(0.5, 1.4, 0.0), v(0.6, 0.0, 0.0), v(0.0, 0.0, 0.6)), emissive(12.0, grey(1.0)))
}

/// Balls under a sky with a small bright lamp: rare bright paths.
fn balls() -> SceneDesc {
    let settings = PathDesc {
        caustics: Caustics::Off,
        shared_paths: SharedPathsMode::Off,
        max_depth: 4,
        ..PathDesc::default()
    };
    let mut desc = path(settings)
        .with(sphere(v(0.0, 0.4, 0.0), 0.5), PrincipledMaterial::default())
        .with(sphere(v(0.0, -3.0, 0.0), 2.9), PrincipledMaterial::default())
        .with(sphere(v(1.0, 1.5, 0.5), 0.2), emissive(9.0, grey(1.0)));
    desc.background.color = Spectrum::new(0.3, 0.5, 0.9);
    desc
}

/// A glass ball that gathers the light of a lamp: light paths.
fn caustic() -> SceneDesc {
    let settings = PathDesc { caustics: Caustics::LightTracing, max_depth: 6, ..PathDesc::default() };
    let white = ColorSource::Constant(Spectrum::WHITE);
    let glass = PrincipledMaterial {
        transmission_weight: white,
        specular_roughness: ColorSource::Constant(Spectrum::BLACK),
        ..PrincipledMaterial::default()
    };
    let light = PointDesc { position: v(-1.0, 3.0, 1.0), intensity: 3.0, ..PointDesc::default() };
    path(settings)
        .with(
            rectangle(v(0.0, -0.5, 0.0), v(5.0, 0.0, 0.0), v(0.0, 0.0, -5.0)),
            PrincipledMaterial::default(),
        )
        .with(sphere(v(0.0, 0.0, 0.0), 0.4), MaterialDesc::Principled(glass))
        .lit(LightDesc::Point(light))
}

/// The fraction of intervals that cover the mean of all renders, among pixels that are not exact.
fn coverage(mut desc: SceneDesc, filter: FilterKind, samples: u32, seeds: u32) -> f64 {
    desc = desc.filmed([48, 40], samples);
    desc.film.filter = filter;
    let never = AtomicBool::new(false);
    let options = PassOptions { threads: 2, cancel: &never, progress: None };
    let mut prepared = desc.prepare(&PrepareOptions::default()).unwrap();
    let estimates: Vec<_> = (0..seeds)
        .map(|seed| {
            prepared.view.film.seed = seed;
            let mut renderer = Renderer::new(prepared.clone()).unwrap();
            assert!(renderer.pass(u32::MAX, &options).unwrap());
            renderer.film.error(1).unwrap()
        })
        .collect();
    let n = f64::from(seeds);
    // The mean contains each render, so that renders are closer to it than to the truth.
    let scale = ((n - 1.0) / n).sqrt();
    let (mut covered, mut all) = (0u64, 0u64);
    for i in 0..estimates[0].luminance.len() {
        let values = || estimates.iter().map(|e| f64::from(e.luminance[i]));
        let truth = values().sum::<f64>() / n;
        if values().all(|v| (v - truth).abs() <= 1e-5 * truth) {
            continue;
        }
        all += u64::from(seeds);
        let within = |e: &&ErrorEstimate| {
            (f64::from(e.luminance[i]) - truth).abs() <= scale * f64::from(e.half_width[i])
        };
        covered += estimates.iter().filter(within).count() as u64;
    }
    assert!(all > 200 * u64::from(seeds), "the scene is exact");
    covered as f64 / all as f64
}

/// The limits are wide, because each scene is rendered only 24 times.
#[test]
fn intervals_cover_the_truth() {
    let cases: [(&str, SceneDesc, FilterKind, u32); 6] = [
        ("room", room(SharedPathsMode::Off), FilterKind::Box, 16),
        ("room", room(SharedPathsMode::Off), FilterKind::Gaussian, 20),
        ("room, shared", room(SharedPathsMode::Always), FilterKind::Box, 32),
        ("room, shared", room(SharedPathsMode::Always), FilterKind::Tent, 16),
        ("balls", balls(), FilterKind::Box, 16),
        ("caustic", caustic(), FilterKind::Box, 32),
    ];
    for (name, desc, filter, samples) in cases {
        let covered = coverage(desc, filter, samples, 24);
        println!("{name} {filter:?} {samples}: {covered:.4}");
        assert!((0.9..=0.98).contains(&covered), "{name} {filter:?} {samples}: {covered}");
    }
}

/// A large picture is estimated in strips.
#[test]
fn strips_have_the_error_of_the_whole() {
    let scene = balls().filmed([37, 150], 16).prepare(&PrepareOptions::default()).unwrap();
    let mut renderer = Renderer::new(scene).unwrap();
    let never = AtomicBool::new(false);
    renderer.pass(u32::MAX, &PassOptions { threads: 2, cancel: &never, progress: None }).unwrap();
    let film = &renderer.film;
    let whole = film.error(2).unwrap();
    for rows in [0..16, 16..80, 80..150, 144..150] {
        let strip = film.error_strip(rows.clone(), 2);
        let part = rows.start as usize * 37..rows.end as usize * 37;
        assert_eq!(strip.half_width, whole.half_width[part.clone()], "{rows:?}");
        assert_eq!(strip.luminance, whole.luminance[part], "{rows:?}");
    }
    assert_eq!(film.noise(3), Some(whole.noise()));
}

/// Without independent samples there is no estimate, and with too few none yet.
#[test]
fn pictures_without_randomness_have_no_estimate() {
    let mut desc = balls().filmed([20, 20], 3);
    let estimate = |desc: &SceneDesc| {
        let mut renderer = Renderer::new(desc.prepare(&PrepareOptions::default()).unwrap()).unwrap();
        let never = AtomicBool::new(false);
        renderer.pass(u32::MAX, &PassOptions { threads: 1, cancel: &never, progress: None }).unwrap();
        renderer.film.error(1)
    };
    assert!(estimate(&desc).is_none(), "three samples");
    desc.film.samples = 4;
    assert!(estimate(&desc).is_some());
    desc.film.antialias = Antialias::None;
    assert!(estimate(&desc).is_none());
}
