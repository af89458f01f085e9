//! Weighted reconstruction: crops, single pixels, edges, and less noise than importance sampling.

use super::pixel;
use crate::color::Spectrum;
use crate::description::{ObjectDesc, SceneDesc};
use crate::film::{FilmDesc, Picture, Reconstruction};
use crate::filter::FilterKind;
use crate::integrator::{Caustics, PathDesc, SharedPathsMode};
use crate::material::PrincipledMaterial;
use crate::schema::PrepareOptions;
use crate::testing::scenes::{emissive, grey, path, render, sphere, v};

/// A ball on a ball under a bright sky.
fn balls(settings: PathDesc, filter: FilterKind, samples: u32) -> SceneDesc {
    let mut desc = path(settings).filmed([40, 36], samples);
    desc.film.filter = filter;
    desc.background.color = Spectrum::new(0.3, 0.5, 0.9);
    desc.with(sphere(v(0.0, 0.4, 0.0), 0.5), PrincipledMaterial::default())
        .with(sphere(v(0.0, -3.0, 0.0), 2.9), PrincipledMaterial::default())
        .with(sphere(v(1.0, 1.5, 0.5), 0.2), emissive(9.0, grey(1.0)))
}

fn settings(shared_paths: SharedPathsMode) -> PathDesc {
    PathDesc { caustics: Caustics::Off, shared_paths, max_depth: 4, ..PathDesc::default() }
}

const FILTERS: [FilterKind; 3] = [FilterKind::Tent, FilterKind::Gaussian, FilterKind::BlackmanHarris];

#[test]
fn a_crop_is_that_part_of_the_picture() {
    for (filter, shared) in [
        (FilterKind::Tent, SharedPathsMode::Off),
        (FilterKind::Gaussian, SharedPathsMode::Always),
        (FilterKind::BlackmanHarris, SharedPathsMode::Off),
    ] {
        let whole = balls(settings(shared), filter, 3);
        let all = render(&whole).0;
        for [x, y, width, height] in [[0, 0, 9, 7], [11, 5, 18, 21], [39, 35, 1, 1], [16, 0, 24, 36]] {
            let film = FilmDesc { crop: Some([x, y, width, height]), ..whole.film.clone() };
            let part = render(&SceneDesc { film, ..whole.clone() }).0;
            for (row, line) in part.linear.chunks(width as usize).enumerate() {
                let start = (y as usize + row) * 40 + x as usize;
                assert_eq!(line, &all.linear[start..start + width as usize], "{filter:?} {x} {y}");
            }
        }
    }
}

#[test]
fn one_pixel_on_its_own_is_that_of_the_picture() {
    for (filter, radius) in
        [(FilterKind::Tent, None), (FilterKind::Gaussian, Some(2.2)), (FilterKind::Box, Some(9.0))]
    {
        let mut desc = balls(settings(SharedPathsMode::Off), filter, 2);
        desc.film.filter_radius = radius;
        let picture = render(&desc).0;
        let prepared = desc.prepare(&PrepareOptions::default()).unwrap();
        for (x, y) in [(0, 0), (20, 17), (39, 20), (5, 35)] {
            let record = pixel(&prepared, x, y).unwrap();
            assert_eq!(record.color, picture.linear[(y * 40 + x) as usize], "{filter:?} {x} {y}");
            let total: f64 = record.samples.iter().map(|s| s.weight).sum();
            assert!((total - 1.0).abs() < 1e-6, "{filter:?}: the weights add up to {total}");
            let red: f64 = record.samples.iter().map(|s| s.weight * f64::from(s.radiance.color.r)).sum();
            assert!((red - f64::from(record.color[0])).abs() < 1e-5);
            assert_eq!(record.count, record.samples.len() as u64);
            let reach = desc.film.filter().radius();
            let center = [f64::from(x) + 0.5, f64::from(y) + 0.5];
            let is_near = |at: [f64; 2]| (0..2).all(|i| (at[i] - center[i]).abs() <= reach);
            assert!(record.samples.iter().all(|s| is_near(s.place) && s.weight > 0.0));
        }
    }
}

fn mean(picture: &Picture) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for p in &picture.linear {
        (0..3).for_each(|i| sum[i] += f64::from(p[i]) / picture.linear.len() as f64);
    }
    sum
}

/// Mean square difference of two pictures.
fn difference(a: &Picture, b: &Picture) -> f64 {
    let pairs = a.linear.iter().zip(&b.linear).flat_map(|(a, b)| (0..3).map(move |i| f64::from(a[i] - b[i])));
    pairs.map(|d| d * d).sum::<f64>() / (3 * a.linear.len()) as f64
}

#[test]
fn weighted_samples_give_the_same_picture_with_less_noise() {
    for filter in FILTERS {
        let with = |reconstruction, samples, seed| {
            let mut desc = balls(settings(SharedPathsMode::Off), filter, samples);
            (desc.film.reconstruction, desc.film.seed) = (reconstruction, seed);
            render(&desc).0
        };
        let [weighted, importance] = [Reconstruction::Weighted, Reconstruction::Importance].map(|kind| {
            let reference = with(kind, 1024, 99);
            let error = (0..3).map(|seed| difference(&with(kind, 8, seed), &reference)).sum::<f64>() / 3.0;
            (reference, error)
        });
        for (a, b) in mean(&weighted.0).into_iter().zip(mean(&importance.0)) {
            assert!((a / b - 1.0).abs() < 0.02, "{filter:?}: {a} {b}");
        }
        // The pictures agree within their noise: that of 1024 samples is 128 times smaller than that of 8.
        let noise = (weighted.1 + importance.1) / 128.0;
        let apart = difference(&weighted.0, &importance.0);
        assert!(apart < 3.0 * noise, "{filter:?}: {apart} {noise}");
        assert!(weighted.1 < 0.7 * importance.1, "{filter:?}: {} {}", weighted.1, importance.1);
    }
}

/// Light paths have the same brightness at the edges as elsewhere: a constant picture of splats stays constant.
#[test]
fn splats_at_the_edges_are_means_over_the_inside() {
    use crate::film::{Film, Splat};
    use crate::math::DVec2;
    for filter in FILTERS {
        let mut desc = balls(settings(SharedPathsMode::Off), filter, 4).film;
        (desc.width, desc.height) = (9, 6);
        let mut film = Film::new(&desc).unwrap();
        film.take_light(1).unwrap();
        let fine = 16;
        let splats: Vec<Splat> = (0..9 * fine * 6 * fine)
            .map(|i| {
                let at = DVec2::new(f64::from(i % (9 * fine)) + 0.5, f64::from(i / (9 * fine)) + 0.5);
                Splat { place: at / f64::from(fine), color: Spectrum::WHITE }
            })
            .collect();
        let black = crate::film::SampleValues { color: Spectrum::BLACK, alpha: 1.0, extra: &[], index: 0 };
        let mut sums = crate::film::TileSums::default();
        sums.reset(film.region, 0, false);
        (0..54).for_each(|i| assert!(sums.add_weighted(i, &black, 1.0)));
        let mut samples = crate::film::SampleSet::default();
        samples.insert(0..1);
        let shared = film.share();
        assert!(shared.deposit_sums((0, None), &sums, &samples, &crate::film::NonFinite::default(), 0));
        assert!(shared.deposit_light(&desc.filter(), 0..1, &splats));
        drop(shared);
        let picture = film.develop(&desc, 1);
        let expected = f64::from(fine * fine);
        for (i, pixel) in picture.linear.iter().enumerate() {
            assert!((f64::from(pixel[0]) / expected - 1.0).abs() < 5e-3, "{filter:?} {i}: {}", pixel[0]);
        }
    }
}

#[test]
fn one_sample_per_pixel_is_weighted_as_well() {
    let mut desc = balls(settings(SharedPathsMode::Off), FilterKind::Gaussian, 1);
    desc.objects.push(ObjectDesc::new(sphere(v(0.4, 0.9, 0.6), 0.1)));
    let smooth = render(&desc).0;
    desc.film.reconstruction = Reconstruction::Importance;
    let rough = render(&desc).0;
    let square = |v: f64| v * v;
    let steps = |p: &Picture| p.linear.windows(2).map(|w| square(f64::from(w[0][0] - w[1][0]))).sum::<f64>();
    assert!(steps(&smooth) < 0.5 * steps(&rough));
}
