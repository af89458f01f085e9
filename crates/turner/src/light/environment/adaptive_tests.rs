//! Adaptive sampling follows its density, finds all light, and prefers what is seen.

use super::tests::{desc, grid, light_of, sky_with_sun};
use super::*;
use crate::math::DVec2;
use crate::testing::{ChiSquareOptions, Random, chi_square_of_directions, sidak_level};
use turner_bvh::InstructionSet;

/// Whether a point sees a direction: points on the left see one window, those on the right another.
fn sees(p: DVec3, direction: DVec3) -> bool {
    let window = if p.x < 0.0 { DVec3::new(0.8, 0.6, 0.0) } else { DVec3::new(0.0, 0.28, -0.96) };
    direction.dot(window) > 0.93
}

const LEFT: DVec3 = DVec3::new(-1.0, 0.0, 0.0);
const RIGHT: DVec3 = DVec3::new(1.0, 0.0, 0.0);

/// An environment of this size, rotated, that two groups of points have learned.
fn learned(width: u32, height: u32) -> AdaptiveEnvironment {
    let rotated = EnvironmentDesc { rotation: 77.0, ..desc(true) };
    let light = light_of(&rotated, sky_with_sun(width, height, 20.0), true);
    let mut random = Random::new(5);
    let mut point = |center: DVec3| center + 0.1 * (DVec3::from(random.units::<3>()) - 0.5);
    let points: Vec<DVec3> = (0..1600).map(|i| point(if i % 2 == 0 { LEFT } else { RIGHT })).collect();
    let mut learning = EnvironmentLearning::new(&light, points.clone()).unwrap();
    for p in points.iter().flat_map(|p| [p; 16]) {
        let direction = learning.direction(random.units()).unwrap();
        learning.add(*p, direction, f32::from(u8::from(sees(*p, direction))));
    }
    learning.finish(3).unwrap()
}

#[test]
fn samples_follow_the_density() {
    // Sizes that divide into tiles, and others; larger than the tables, and smaller than the tiles: one colour, too.
    let sizes = [(64, 32), (24, 12), (45, 70), (1100, 530), (1, 1)];
    for (w, h) in sizes {
        let adaptive = learned(w, h);
        assert_eq!(adaptive.light(), 3);
        let mut random = Random::new(11);
        let options = ChiSquareOptions { samples: 100_000, rows: 24, columns: 24, tolerance: 3e-3 };
        for p in [LEFT, RIGHT] {
            let cell = adaptive.cell(p);
            // The image's axis is +y, that of the test +z.
            let turned = |w: DVec3| DVec3::new(w.y, w.z, w.x);
            let back = |w: DVec3| DVec3::new(w.z, w.x, w.y);
            let test = chi_square_of_directions(
                &options,
                |w| adaptive.found(cell, back(w)).1,
                || adaptive.sample(cell, random.units()).map(|s| turned(s.direction)),
            );
            assert!(test.p_value > sidak_level(0.01, 10), "{w} {h}: {test:?}");
        }
    }
}

#[test]
fn what_is_seen_is_preferred_and_nothing_is_lost() {
    let adaptive = learned(64, 32);
    let mut random = Random::new(2);
    for p in [LEFT, RIGHT] {
        let cell = adaptive.cell(p);
        let seen = (0..1000)
            .filter(|_| {
                let u = random.units();
                adaptive.sample(cell, u).is_some_and(|s| sees(p, s.direction))
            })
            .count();
        // The windows hold about 4 % of the light.
        assert!(seen > 300, "{seen}");
        for (direction, _) in grid(61, 37) {
            let (radiance, pdf) = adaptive.found(cell, direction);
            assert!(pdf > 0.0 || radiance.is_black(), "{direction}");
        }
    }
}

#[test]
fn densities_are_those_of_samples() {
    let adaptive = learned(200, 100);
    let mut random = Random::new(9);
    let mut wrong = 0;
    for _ in 0..2000 {
        let cell = adaptive.cell(if random.unit() < 0.5 { LEFT } else { RIGHT });
        let Some(s) = adaptive.sample(cell, random.units()) else { continue };
        let (radiance, pdf) = adaptive.found(cell, s.direction);
        // A sample at the very edge of a pixel may round into the next one.
        wrong += u32::from((pdf / s.pdf - 1.0).abs() > 1e-9);
        assert!(
            (radiance.luminance() - s.radiance.luminance()).abs() <= 1e-3 * s.radiance.luminance() + 1e-6
        );
    }
    assert!(wrong < 3, "{wrong}");
}

#[test]
fn batches_equal_single_samples() {
    let adaptive = learned(64, 32);
    let mut random = Random::new(4);
    let mut scratch = EnvironmentBatch::default();
    for set in InstructionSet::available() {
        for count in [0, 3, 8, 300] {
            let requests: Vec<(u32, [f64; 2])> = (0..count)
                .map(|i| (adaptive.cell(if i % 3 == 0 { LEFT } else { RIGHT }), random.units()))
                .collect();
            let mut seen = 0;
            adaptive.sample_batch(set, &requests, &mut scratch, |i, sample| {
                assert_eq!(sample, adaptive.sample(requests[i].0, requests[i].1));
                seen += 1;
            });
            let directions: Vec<DVec3> =
                requests.iter().map(|(_, u)| crate::sampler::uniform_sphere(DVec2::from(*u))).collect();
            let cells: Vec<u32> = requests.iter().map(|(cell, _)| *cell).collect();
            adaptive.found_batch(set, &cells, &directions, &mut scratch, |i, found| {
                assert_eq!(found, adaptive.found(cells[i], directions[i]));
                seen += 1;
            });
            assert_eq!(seen, 2 * count);
        }
    }
}

#[test]
fn nothing_is_learned_of_an_open_sky() {
    let light = light_of(&desc(true), sky_with_sun(64, 32, 20.0), true);
    let mut random = Random::new(5);
    let points: Vec<DVec3> = (0..400).map(|_| DVec3::from(random.units::<3>())).collect();
    let mut learning = EnvironmentLearning::new(&light, points.clone()).unwrap();
    for p in points.iter().flat_map(|p| [p; 8]) {
        let direction = learning.direction(random.units()).unwrap();
        learning.add(*p, direction, 1.0);
    }
    assert!(learning.finish(0).is_none());
    assert!(EnvironmentLearning::new(&light, Vec::new()).is_none());
}
