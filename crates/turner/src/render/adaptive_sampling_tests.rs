//! Adaptive sampling: the same bytes however it is interrupted or split, no bias, and less error where noise is uneven.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use super::{PassOptions, PassRange, Renderer, TileSet};
use crate::color::Spectrum;
use crate::description::SceneDesc;
use crate::film::{Film, Half};
use crate::filter::FilterKind;
use crate::integrator::{Caustics, PathDesc, Prepared, SharedPathsMode};
use crate::material::PrincipledMaterial;
use crate::schema::{Limits, PrepareOptions};
use crate::testing::scenes::{emissive, grey, path, rectangle, sphere, v};

/// A ball and a mirror-like one before a grey sky; a small bright lamp that camera paths find rarely.
fn uneven(shared_paths: SharedPathsMode, caustics: Caustics) -> SceneDesc {
    let settings = PathDesc { caustics, shared_paths, max_depth: 4, ..PathDesc::default() };
    let shiny = PrincipledMaterial {
        base_metalness: grey(1.0),
        specular_roughness: grey(0.25),
        ..PrincipledMaterial::default()
    };
    let mut desc = path(settings)
        .with(sphere(v(-0.5, -0.2, 0.0), 0.4), PrincipledMaterial::default())
        .with(rectangle(v(0.6, -0.3, 0.0), v(0.7, 0.0, 0.3), v(0.0, 0.2, -0.8)), shiny)
        .with(sphere(v(0.3, 1.2, 0.6), 0.08), emissive(60.0, grey(1.0)));
    desc.background.color = Spectrum::grey(0.4);
    desc.film.adaptive_sampling = true;
    desc
}

fn prepared(desc: &SceneDesc) -> Prepared {
    desc.prepare(&PrepareOptions::default()).unwrap()
}

fn rendered(prepared: &Prepared, threads: usize) -> Renderer {
    let mut renderer = Renderer::new(prepared.clone()).unwrap();
    let never = AtomicBool::new(false);
    assert!(renderer.pass(u32::MAX, &PassOptions { threads, cancel: &never, progress: None }).unwrap());
    assert!(renderer.is_complete());
    renderer
}

/// Passes that are cancelled, written, read and continued.
fn interrupted(prepared: &Prepared, threads: usize, stop: usize) -> Film {
    let mut renderer = Renderer::new(prepared.clone()).unwrap();
    let mut stops = 0;
    while !renderer.is_complete() {
        let (cancel, tasks) = (AtomicBool::new(false), AtomicUsize::new(0));
        let progress = |_: usize, _: usize| {
            cancel.store(tasks.fetch_add(1, Ordering::Relaxed) + 1 >= stop, Ordering::Relaxed);
        };
        renderer.pass(5, &PassOptions { threads, cancel: &cancel, progress: Some(&progress) }).unwrap();
        let film = Film::from_bytes(&renderer.film.to_bytes(), &Limits::default()).unwrap();
        renderer = Renderer::resume(prepared.clone(), film).unwrap();
        stops += 1;
    }
    assert!(stops > 3, "{stops} passes");
    renderer.film
}

#[test]
fn the_film_is_the_same_for_threads_and_interrupts() {
    for (shared_paths, caustics) in [
        (SharedPathsMode::Off, Caustics::Off),
        (SharedPathsMode::Always, Caustics::Off),
        (SharedPathsMode::Off, Caustics::LightTracing),
    ] {
        let prepared = prepared(&uneven(shared_paths, caustics).filmed([75, 53], 32));
        let whole = rendered(&prepared, 1).film;
        assert!(whole.identity().adaptive);
        let goals = |film: &Film| -> Vec<u64> {
            (0..film.tiles().count()).flat_map(|t| Half::BOTH.map(|half| film.goal(t, half))).collect()
        };
        let range = [goals(&whole).into_iter().min(), goals(&whole).into_iter().max()];
        assert!(range[0] < range[1], "{shared_paths:?} {caustics:?}: {range:?}");
        assert!((20.0..=32.0).contains(&whole.mean_samples()), "{}", whole.mean_samples());
        let bytes = whole.to_bytes();
        assert!(rendered(&prepared, 3).film.to_bytes() == bytes, "{shared_paths:?} {caustics:?}");
        for (threads, stop) in [(1, 7), (3, 4), (2, 11)] {
            let film = interrupted(&prepared, threads, stop);
            assert!(film.to_bytes() == bytes, "{shared_paths:?} {caustics:?} {threads} {stop}");
        }
    }
}

/// Two machines trace the tiles before the first decision.
#[test]
fn films_of_different_tiles_merge_to_the_same_film() {
    let prepared = prepared(&uneven(SharedPathsMode::Off, Caustics::Off).filmed([75, 53], 32));
    let never = AtomicBool::new(false);
    let options = PassOptions { threads: 2, cancel: &never, progress: None };
    let part = |odd: u32| {
        let mut renderer = Renderer::new(prepared.clone()).unwrap();
        let tiles = (0..renderer.film.tiles().count() as u32).filter(|tile| tile % 2 == odd).collect();
        renderer
            .pass_over(&PassRange { samples: 0..u32::MAX, tiles: TileSet::Some(tiles) }, &options)
            .unwrap();
        renderer.film
    };
    let (mut film, other) = (part(0), part(1));
    assert!(!film.has_reached_goals());
    film.merge(&other).unwrap();
    assert!(film.has_reached_goals() && film.mean_samples() == 8.0);
    let mut renderer = Renderer::resume(prepared.clone(), film).unwrap();
    assert!(renderer.pass(u32::MAX, &options).unwrap());
    let whole = rendered(&prepared, 2).film;
    assert!(renderer.film.to_bytes() == whole.to_bytes());
    // Films that have decided differently do not fit together.
    let error = whole.clone().merge(&other).unwrap_err();
    assert!(error.message.contains("allotted"), "{}", error.message);
}

/// The sum of squared errors of the pixels' luminance, relative as the allotment weighs them.
fn error(film: &Film, reference: &[f32]) -> f64 {
    let estimate = film.error(0).unwrap();
    let mean = f64::from(reference.iter().sum::<f32>()) / reference.len() as f64;
    let pixels = estimate.luminance.iter().zip(reference);
    let of_pixel = |(a, b): (&f32, &f32)| {
        let (difference, luminance) = (f64::from(a - b), f64::from(*b) + 0.1 * mean);
        difference * difference / (luminance * luminance.sqrt())
    };
    pixels.map(of_pixel).sum()
}

#[test]
fn uneven_noise_falls_faster() {
    let desc = uneven(SharedPathsMode::Off, Caustics::Off).filmed([160, 128], 64);
    let mut reference = desc.clone().filmed([160, 128], 1024);
    (reference.film.adaptive_sampling, reference.film.seed) = (false, 9);
    let reference = rendered(&prepared(&reference), 2).film.error(0).unwrap().luminance;
    let mut even = desc.clone();
    even.film.adaptive_sampling = false;
    let (even, adaptive) = (rendered(&prepared(&even), 2), rendered(&prepared(&desc), 2));
    let [before, after] = [&even, &adaptive].map(|r| error(&r.film, &reference) * r.stats.total() as f64);
    assert!(before > 1.3 * after, "error times rays: {before} and {after}");
}

/// The mean of many pictures is that of pictures with even samples, although rare bright samples decide.
#[test]
fn decisions_do_not_bias_the_mean() {
    const SEEDS: u32 = 150;
    let mean_of = |adaptive: bool| {
        let mut desc = uneven(SharedPathsMode::Off, Caustics::Off).filmed([32, 32], 16);
        desc.film.adaptive_sampling = adaptive;
        let mut prepared = prepared(&desc);
        let means: Vec<f64> = (0..SEEDS)
            .map(|seed| {
                prepared.view.film.seed = seed + 1000 * u32::from(adaptive);
                let luminance = rendered(&prepared, 2).film.error(0).unwrap().luminance;
                luminance.iter().map(|l| f64::from(*l)).sum::<f64>() / luminance.len() as f64
            })
            .collect();
        let mean = means.iter().sum::<f64>() / means.len() as f64;
        let variance = means.iter().map(|m| (m - mean) * (m - mean)).sum::<f64>() / (means.len() - 1) as f64;
        (mean, variance / means.len() as f64)
    };
    let ((even, a), (adaptive, b)) = (mean_of(false), mean_of(true));
    let z = (adaptive - even) / (a + b).sqrt();
    assert!(z.abs() < 3.5, "{even} {adaptive}: z = {z}");
    assert!(
        (a + b).sqrt() < 0.01 * even,
        "the test sees a bias of a few per cent: {}",
        (a + b).sqrt() / even
    );
}

/// Each sample index needs photons, so all pixels get the same indices, and a pass ends with the last of them.
#[test]
fn photons_get_even_samples() {
    let mut prepared = super::resume_tests::scene("photons");
    (prepared.view.film.adaptive_sampling, prepared.view.film.samples) = (true, 1 << 24);
    let never = AtomicBool::new(false);
    let options = PassOptions { threads: 2, cancel: &never, progress: None };
    let mut renderer = Renderer::new(prepared).unwrap();
    assert!(renderer.pass(12, &options).unwrap());
    assert_eq!((renderer.film.mean_goal(), renderer.film.mean_samples()), (12, 12.0));
}

#[test]
fn filters_beyond_the_pixel_get_even_samples() {
    let mut desc = uneven(SharedPathsMode::Off, Caustics::Off).filmed([75, 53], 32);
    desc.film.filter = FilterKind::Gaussian;
    let film = rendered(&prepared(&desc), 2).film;
    assert!((0..film.tiles().count()).all(|tile| film.held_half(tile, Half::Odd).len() == 32));
}
