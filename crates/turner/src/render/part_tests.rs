//! Films of parts of a picture, stitched; films with more samples.

use std::sync::atomic::AtomicBool;

use proptest::prelude::*;

use super::resume_tests::{KINDS, complete_film, scene};
use super::{PassOptions, PassRange, Renderer};
use crate::film::{Antialias, Film};
use crate::integrator::Prepared;
use crate::schema::{ErrorCode, Limits};

/// The film of a part of a picture with some of its samples.
fn part(scene: &Prepared, crop: [u32; 4], samples: std::ops::Range<u32>) -> Film {
    let mut scene = scene.clone();
    scene.view.film.crop = Some(crop);
    let mut renderer = Renderer::new(scene).unwrap();
    let options = PassOptions { threads: 2, cancel: &AtomicBool::new(false), progress: None };
    assert!(renderer.pass_over(&PassRange::all_tiles(samples), &options).unwrap());
    Film::from_bytes(&renderer.film.to_bytes(), &Limits::default()).unwrap()
}

/// Cuts a rectangle of at least 2 x 2 pixels in two, again and again.
fn cut(rect: [u32; 4], cuts: &[u32], out: &mut Vec<[u32; 4]>) {
    let [x, y, w, h] = rect;
    let (Some((first, rest)), true) = (cuts.split_first(), w > 1 && h > 1) else {
        out.push(rect);
        return;
    };
    let (left, right) = rest.split_at(rest.len() / 2);
    if first % 2 == 0 {
        let at = 1 + first / 2 % (w - 1);
        cut([x, y, at, h], left, out);
        cut([x + at, y, w - at, h], right, out);
    } else {
        let at = 1 + first / 2 % (h - 1);
        cut([x, y, w, at], left, out);
        cut([x, y + at, w, h - at], right, out);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 8, ..ProptestConfig::default() })]

    #[test]
    fn parts_of_a_picture_stitch_to_the_complete_film(
        cuts in proptest::collection::vec(any::<u32>(), 1..6),
        kind in proptest::sample::select(&KINDS[..]),
        mean in any::<bool>(),
    ) {
        let mut scene = scene(kind);
        if mean && kind == "one" {
            scene.view.film.antialias = Antialias::Mean;
        }
        let samples = scene.view.film.samples_per_pixel();
        let mut crops = Vec::new();
        cut([0, 0, 53, 37], &cuts, &mut crops);
        let films: Vec<Film> = crops
            .iter()
            .map(|crop| {
                let mut film = part(&scene, *crop, samples / 2..samples);
                if samples > 1 {
                    film.merge(&part(&scene, *crop, 0..samples / 2)).unwrap();
                }
                film
            })
            .collect();
        let (whole, complete) = (Film::stitch(&films).unwrap(), complete_film(&scene));
        prop_assert!(whole.to_bytes() == complete.to_bytes(), "{} {:?}", kind, crops);
        prop_assert_eq!(whole.develop(&scene.view.film, 1), complete.develop(&scene.view.film, 1));
    }
}

#[test]
fn parts_that_do_not_fit_are_refused() {
    let scene = scene("light");
    let film = |crop, samples| part(&scene, crop, samples);
    let refused = |films: &[Film]| {
        let error = Film::stitch(films).unwrap_err();
        assert_eq!(error.code, ErrorCode::Conflict);
        assert!(error.help.is_some(), "{} has no remedy", error.message);
        error.message
    };
    let (left, right) = (film([0, 0, 20, 37], 0..6), film([20, 0, 33, 37], 0..6));
    assert!(Film::stitch(&[right.clone(), left.clone()]).is_ok());
    assert_eq!(refused(&[]), "there are no films to stitch");
    assert_eq!(
        refused(&[left.clone(), left.clone()]),
        "the films overlap: 20x37 pixels at (0, 0) and 20x37 pixels at (0, 0)"
    );
    assert_eq!(
        refused(&[left.clone(), film([21, 0, 32, 37], 0..6)]),
        "the films leave a gap: 37 of 53x37 pixels at (0, 0) are missing"
    );
    assert_eq!(
        refused(&[left.clone(), film([20, 0, 33, 37], 1..6)]),
        "the films hold different samples: 0..6 in 20x37 pixels at (0, 0), but 1..6 in 16x16 pixels at (20, 0)"
    );
    let mut other = right;
    other.set_scene(7);
    assert_eq!(
        refused(&[left, other]),
        "the films are of different pictures; scene: none and 0000000000000007"
    );
    // A border lacks samples that the picture around the rectangle has.
    let mut mean = self::scene("one");
    mean.view.film.antialias = Antialias::Mean;
    let message = refused(&[part(&mean, [0, 0, 9, 9], 0..1), part(&mean, [9, 0, 9, 9], 0..1)]);
    assert!(message.contains("they must cover the whole picture"), "{message}");
}

#[test]
fn a_film_takes_more_samples() {
    let never = AtomicBool::new(false);
    let options = PassOptions { threads: 2, cancel: &never, progress: None };
    for kind in ["path", "shared-paths", "light", "photons", "aovs"] {
        for few in [1, 2] {
            let (mut before, after) = (scene(kind), scene(kind));
            before.view.film.samples = few;
            let film = Film::from_bytes(&complete_film(&before).to_bytes(), &Limits::default()).unwrap();
            let mut renderer = Renderer::extend(after.clone(), film.clone()).unwrap();
            assert!(
                !renderer.is_complete()
                    && renderer.film.memory() == Renderer::new(after.clone()).unwrap().film.memory()
            );
            assert!(renderer.pass(u32::MAX, &options).unwrap() && renderer.is_complete());
            assert!(renderer.film.to_bytes() == complete_film(&after).to_bytes(), "{kind} {few}");
        }
    }
    let full = complete_film(&scene("path"));
    let refused = |change: &dyn Fn(&mut Prepared)| {
        let mut scene = scene("path");
        change(&mut scene);
        Renderer::extend(scene, full.clone()).err().map(|e| e.message)
    };
    assert_eq!(refused(&|_| ()), None);
    assert!(refused(&|s| s.view.film.samples = 5).unwrap().contains("expected at least as many, found 5"));
    let message = refused(&|s| (s.view.sobol, s.view.film.samples) = (false, 9)).unwrap();
    assert!(message.contains("places its samples by their number"), "{message}");
    let grid = refused(&|s| (s.view.film.antialias, s.view.film.samples) = (Antialias::Grid, 9)).unwrap();
    assert!(grid.contains("anti-aliasing \"grid\""), "{grid}");
    let cone = |s: &mut Prepared| {
        s.view.film.samples = 9;
        s.view.pixel_cone = Some(crate::camera::PixelCone::new(&s.view.camera, &s.view.film));
    };
    assert!(refused(&cone).unwrap().contains("textures are filtered"));
}
