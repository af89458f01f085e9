//! Samples follow the radiance, and densities integrate to 1.

use std::f64::consts::{PI, TAU};

use super::*;
use crate::image::Pixels;
use crate::light::Light;
use crate::math::DVec2;
use crate::math::elementary::cos;
use crate::testing::{ChiSquareOptions, Random, chi_square_of_directions, sidak_level};

fn image(width: u32, height: u32, channels: u8, samples: Vec<f32>) -> Image {
    Image { width, height, channels, pixels: Pixels::F32(samples) }
}

pub(super) fn desc(file: bool) -> EnvironmentDesc {
    EnvironmentDesc { file: file.then_some(ImageId(0)), ..EnvironmentDesc::default() }
}

pub(super) fn light_of(desc: &EnvironmentDesc, image: Image, compensated: bool) -> EnvironmentLight {
    let images = [Asset { uri: "sky.hdr".into(), data: Arc::new(image) }];
    desc.prepare(&images, compensated).unwrap()
}

fn light(image: Image) -> EnvironmentLight {
    light_of(&desc(true), image, false)
}

/// A sky with a sun of one pixel, black pixels, and noise.
fn sky(width: u32, height: u32) -> Image {
    sky_with_sun(width, height, 3000.0)
}

pub(super) fn sky_with_sun(width: u32, height: u32, sun: f32) -> Image {
    let mut random = Random::new(3);
    let mut samples = Vec::new();
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let is_sun = x == width / 3 && y == height / 4;
        let dark = y > 3 * height / 4 && x % 5 != 0;
        let grey = if is_sun { sun } else { random.unit() as f32 * 2.0 };
        samples.extend(if dark { [0.0; 3] } else { [grey, grey * 0.9, grey * 0.7] });
    }
    image(width, height, 3, samples)
}

/// The directions of a grid of `w` x `h` cells of the image (before rotation), with their solid angles.
pub(super) fn grid(w: u32, h: u32) -> impl Iterator<Item = (DVec3, f64)> {
    let edge = move |y: u32| cos(PI * f64::from(y) / f64::from(h));
    (0..h).flat_map(move |y| {
        let solid_angle = TAU / f64::from(w) * (edge(y) - edge(y + 1));
        (0..w).map(move |x| {
            let uv = DVec2::new((f64::from(x) + 0.5) / f64::from(w), (f64::from(y) + 0.5) / f64::from(h));
            (map::direction(uv), solid_angle)
        })
    })
}

#[test]
fn densities_integrate_to_one() {
    for (w, h) in [(1, 1), (3, 2), (32, 16), (200, 100), (33, 70)] {
        for compensated in [false, true] {
            let light = light_of(&desc(true), sky(w, h), compensated);
            let total: f64 = grid(3 * w, 3 * h).map(|(d, solid_angle)| light.pdf(d) * solid_angle).sum();
            assert!((total - 1.0).abs() < 1e-6, "{w}x{h} {compensated}: {total}");
        }
    }
}

#[test]
fn samples_follow_the_density() {
    for (compensated, rotation) in [(false, 0.0), (true, 0.0), (false, 77.0)] {
        let (w, h) = (24, 12);
        let light =
            light_of(&EnvironmentDesc { rotation, ..desc(true) }, sky_with_sun(w, h, 20.0), compensated);
        let mut random = Random::new(11);
        let options = ChiSquareOptions { samples: 100_000, rows: 24, columns: 24, tolerance: 3e-3 };
        // The image's axis is +y, that of the test +z.
        let turned = |w: DVec3| DVec3::new(w.y, w.z, w.x);
        let back = |w: DVec3| DVec3::new(w.z, w.x, w.y);
        let test = chi_square_of_directions(
            &options,
            |w| light.pdf(back(w)),
            || light.sample(random.units()).map(|s| turned(s.direction)),
        );
        // Three tests, 1 % together.
        assert!(test.p_value > sidak_level(0.01, 3), "{test:?}");
    }
}

#[test]
fn samples_agree_with_found() {
    let desc =
        EnvironmentDesc { rotation: -130.0, strength: 2.5, tint: Spectrum::new(1.0, 0.5, 0.0), ..desc(true) };
    for compensated in [false, true] {
        let light = light_of(&desc, sky(48, 24), compensated);
        let mut random = Random::new(5);
        let mut disagree = 0;
        for _ in 0..20_000 {
            let sample = light.sample([random.unit(), random.unit()]).unwrap();
            let (radiance, pdf) = light.found(sample.direction);
            for there in [radiance, light.radiance(sample.direction)] {
                let difference = there + sample.radiance * -1.0;
                assert!(difference.map(f32::abs).max_component() < 1e-6 * (1.0 + there.max_component()));
            }
            assert_eq!(pdf, light.pdf(sample.direction));
            assert!(sample.pdf > 0.0 && sample.pdf.is_finite());
            // On an edge between two pixels rounding may lead to the other one.
            disagree += u32::from((light.pdf(sample.direction) / sample.pdf - 1.0).abs() > 1e-9);
        }
        assert!(disagree < 3, "{disagree}");
        for u in [0.0, 1.0, 0.5, f64::NAN, -1.0, 2.0] {
            for v in [0.0, 1.0, 0.5, f64::NAN, -1.0, 2.0] {
                let sample = light.sample([u, v]);
                assert!(sample.is_none_or(|s| u.is_nan() || s.direction.is_finite()), "{u} {v} {sample:?}");
            }
        }
    }
}

/// The estimate of the total light is correct and has hardly any noise: the density follows the luminance except for
/// differences within a pixel.
#[test]
fn importance_sampling_integrates_the_light() {
    let light = light(sky(64, 32));
    let mut random = Random::new(9);
    let n = 200_000;
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..n {
        let s = light.sample([random.unit(), random.unit()]).unwrap();
        let v = f64::from(s.radiance.luminance()) / s.pdf;
        sum += v;
        squares += v * v;
    }
    let mean = sum / f64::from(n);
    let deviation = (squares / f64::from(n) - mean * mean).max(0.0).sqrt() / f64::from(n).sqrt();
    // The integral of the bilinear look-up, on a fine grid.
    let truth: f64 = grid(64 * 8, 32 * 8).map(|(d, a)| f64::from(light.radiance(d).luminance()) * a).sum();
    assert!((mean - truth).abs() < 4.0 * deviation + 2e-3 * truth, "{mean} {truth} {deviation}");
    assert!(deviation < 0.01 * truth, "{deviation}");
    let stated = f64::from(light.power().luminance());
    assert!((stated - truth).abs() < 0.01 * truth, "{stated} {truth}");
}

#[test]
fn every_direction_with_light_has_a_pdf() {
    let mut samples = vec![0.0; 16 * 8];
    samples[3 * 16] = 1.0;
    let light = light(image(16, 8, 1, samples));
    for (d, _) in grid(160, 80) {
        assert!(light.radiance(d).is_black() || light.pdf(d) > 0.0, "{d}");
    }
}

#[test]
fn a_constant_is_sampled_uniformly() {
    for compensated in [false, true] {
        for (w, h) in [(1, 1), (7, 5), (64, 32)] {
            let light = light_of(&desc(true), image(w, h, 1, vec![0.7; (w * h) as usize]), compensated);
            for (d, _) in grid(50, 30) {
                assert!((light.pdf(d) * 2.0 * TAU - 1.0).abs() < 1e-6, "{compensated} {d} {}", light.pdf(d));
                let difference = light.radiance(d) - Spectrum::grey(0.7);
                assert!(difference.map(f32::abs).max_component() < 1e-6);
            }
            assert!((f64::from(light.power().g) - 0.7 * 2.0 * TAU).abs() < 1e-6);
        }
    }
}

#[test]
fn compensation_omits_directions_dimmer_than_the_mean() {
    // Upper half 3, lower half 1: the mean is 2.
    let samples = (0..64 * 32).map(|i| if i < 64 * 16 { 3.0 } else { 1.0 }).collect();
    let light = light_of(&desc(true), image(64, 32, 1, samples), true);
    assert_eq!(light.pdf(DVec3::NEG_Y), 0.0);
    assert!((light.pdf(DVec3::new(0.3, 0.7, -0.2)) - 1.0 / TAU).abs() < 0.01);
    assert_eq!(light.radiance(DVec3::NEG_Y), Spectrum::WHITE);
}

#[test]
fn black_and_invalid_images_are_defined() {
    let odd = [0.0, f32::NAN, -1.0, f32::INFINITY, f32::NEG_INFINITY, -0.0];
    let black = light(image(6, 4, 1, (0..24).map(|i| odd[i % 6]).collect()));
    assert!(black.is_black() && black.sample([0.5, 0.5]).is_none());
    assert_eq!((black.pdf(DVec3::X), black.radiance(DVec3::X)), (0.0, Spectrum::BLACK));
    assert_eq!(black.invalid_pixels(), 16);
    // The largest finite values.
    let huge = EnvironmentDesc { strength: 1e30, ..desc(true) };
    let huge = light_of(&huge, image(4, 2, 1, vec![f32::MAX; 8]), false);
    assert!(huge.radiance(DVec3::X).is_finite() && huge.power().is_finite());
    assert!((huge.pdf(DVec3::X) * 2.0 * TAU - 1.0).abs() < 1e-6);
    let none = EnvironmentDesc { strength: 0.0, ..desc(true) };
    let none = light_of(&none, sky(8, 4), false);
    assert!(none.is_black() && none.radiance(DVec3::Y).is_black());
    let short = Image { width: 9, ..sky(8, 4) };
    let images = [Asset { uri: "a".into(), data: Arc::new(short) }];
    assert!(desc(true).prepare(&images, false).is_err());
    assert!(desc(true).prepare(&[], false).is_err());
}

#[test]
fn rotation_is_about_y() {
    let image_of_sky = || sky(36, 18);
    let still = light(image_of_sky());
    for degrees in [90.0, -33.0, 360.0, 1234.5] {
        let turned = light_of(&EnvironmentDesc { rotation: degrees, ..desc(true) }, image_of_sky(), false);
        let rotation = crate::math::DMat3::from_rotation_y(radians(degrees));
        for (d, _) in grid(23, 11) {
            let (a, b) = (still.radiance(d), turned.radiance(rotation * d));
            assert!((a - b).map(f32::abs).max_component() < 1e-3 * (1.0 + a.g), "{degrees} {d}: {a:?} {b:?}");
        }
    }
    // A mark at the centre of the image lies along −z; rotated by 90 degrees, along −x.
    let mut samples = vec![0.0; 40 * 21];
    samples[10 * 40 + 20] = 1.0;
    samples[10 * 40 + 19] = 1.0;
    let mark = |rotation| {
        light_of(&EnvironmentDesc { rotation, ..desc(true) }, image(40, 21, 1, samples.clone()), false)
    };
    assert!(mark(0.0).radiance(DVec3::NEG_Z).g > 0.99);
    assert!(mark(90.0).radiance(DVec3::NEG_X).g > 0.99 && mark(90.0).radiance(DVec3::NEG_Z).is_black());
}

/// `turned_by` is the matrix, and what is sampled in batches is what is found.
#[test]
fn an_environment_may_have_any_rotation() {
    use crate::math::DMat3;
    let still = light(sky_with_sun(36, 18, 20.0));
    let y = DMat3::from_rotation_y(2.1);
    let flat = |a: f64| DMat3::from_rotation_x(a) * y;
    let others = [DMat3::from_rotation_z(1.0) * flat(-2.9), flat(std::f64::consts::PI) * 3.0];
    for m in [y, flat(0.5 * PI), flat(-0.5 * PI)].into_iter().chain(others) {
        let turned = light_of(&desc(true).turned_by(m).unwrap(), sky_with_sun(36, 18, 20.0), false);
        for (d, _) in grid(23, 11) {
            let (a, b) = (still.radiance(d), turned.radiance(m * d));
            assert!((a - b).map(f32::abs).max_component() < 1e-3 * (1.0 + a.g), "{m} {d}: {a:?} {b:?}");
        }
        let at = |i: u32| (f64::from(i) + 0.37) / 40.0;
        let u: Vec<[f64; 2]> = (0..40).map(|i| [at(i), at(i * 7 % 40)]).collect();
        let mut scratch = EnvironmentBatch::default();
        let set = turner_bvh::InstructionSet::best();
        turned.sample_batch(set, &u, &mut scratch, |i, sample| {
            let (sample, alone) = (sample.unwrap(), turned.sample(u[i]).unwrap());
            assert!((sample.direction - alone.direction).length() < 1e-12);
            let (radiance, pdf) = turned.found(sample.direction);
            assert!((pdf / sample.pdf - 1.0).abs() < 1e-6, "{m}: {pdf} {sample:?}");
            assert!((radiance - sample.radiance).map(f32::abs).max_component() < 1e-2 * (1.0 + radiance.g));
        });
    }
    for bad in [DMat3::ZERO, DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)), DMat3::NAN] {
        assert_eq!(desc(true).turned_by(bad), None);
    }
}

/// Irradiance over π on a plane with normal `n`.
fn irradiance(light: &EnvironmentLight, n: DVec3) -> f64 {
    let n = n.normalize();
    let arriving =
        |(d, solid_angle): (DVec3, f64)| f64::from(light.radiance(d).g) * solid_angle * d.dot(n).max(0.0);
    grid(1024, 512).map(arriving).sum::<f64>() / PI
}

#[test]
fn the_studio_suits_exposure_zero() {
    let studio = desc(false).prepare(&[], false).unwrap();
    let up = irradiance(&studio, DVec3::Y);
    assert!((up - 0.865).abs() < 0.02, "{up}");
    let [front, left, right, back, down] =
        [DVec3::Z, DVec3::NEG_X, DVec3::X, DVec3::NEG_Z, DVec3::NEG_Y].map(|n| irradiance(&studio, n));
    // The key light is at the upper left of the front; no side is dark.
    assert!(left > 1.3 * right && front > 1.1 * back, "{front} {left} {right} {back}");
    assert!([front, left, right, back, down].iter().all(|side| *side > 0.5), "{right} {down}");
    let (mut most, mut towards) = (0.0, DVec3::ZERO);
    for (d, _) in grid(512, 256) {
        let light = studio.radiance(d);
        assert!(light.r == light.g && light.g == light.b && light.g >= 0.1, "{d} {light:?}");
        if light.g > most {
            (most, towards) = (light.g, d);
        }
    }
    assert!((4.0..=15.0).contains(&most), "{most}");
    assert!(towards.x < -0.3 && towards.y > 0.5 && towards.z > 0.3, "{towards}");
    // A white floor, a dark ceiling.
    assert!(studio.radiance(DVec3::NEG_Y).g > 4.0 * studio.radiance(DVec3::Y).g);
    assert_eq!(studio.invalid_pixels(), 0);
    assert!(studio.memory() < 2 << 20);
}

#[test]
fn a_rotated_environment_keeps_its_prepared_image() {
    let data = Arc::new(image(4, 2, 3, (0..24).map(|i| i as f32).collect()));
    let images = [Asset { uri: "sky.hdr".into(), data }];
    let desc = desc(true);
    let before = [Light::Environment(desc.prepare(&images, true).unwrap())];
    let Light::Environment(first) = &before[0] else { unreachable!() };
    let turned = EnvironmentDesc { rotation: 90.0, ..desc };
    let setting =
        LightSetting { images: &images, compensated: true, physical: true, threads: 1, before: &before };
    let kept = turned.prepare_again(&setting).unwrap();
    assert!(kept.shares_image(first));
    let fresh = turned.prepare(&images, true).unwrap();
    assert!(!fresh.shares_image(first));
    assert_eq!(kept.radiance(DVec3::X), fresh.radiance(DVec3::X));
    let other = LightSetting { compensated: false, ..setting };
    assert!(!turned.prepare_again(&other).unwrap().shares_image(first));
}
