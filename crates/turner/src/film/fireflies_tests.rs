//! Fireflies: single bright samples are removed; light that several samples see stays. Order and splits of the samples
//! change nothing.

use super::*;
use crate::color::Spectrum;
use crate::schema::Limits;

const SIDE: u32 = 9;

fn desc(samples: u32, fireflies: Fireflies) -> FilmDesc {
    let plain = crate::description::SceneDesc::default().film;
    FilmDesc { width: SIDE, height: SIDE, antialias: Antialias::MonteCarlo, samples, fireflies, ..plain }
}

/// A film of grey samples: `value` of column, row and index.
fn film(samples: u32, fireflies: Fireflies, value: impl Fn(u32, u32, u32) -> f32) -> Film {
    let mut film = Film::new(&desc(samples, fireflies)).unwrap();
    add(&mut film, 0..samples, false, &value);
    film
}

fn add(
    film: &mut Film,
    indices: std::ops::Range<u32>,
    backwards: bool,
    value: &impl Fn(u32, u32, u32) -> f32,
) {
    let mut sums = TileSums::default();
    sums.reset(film.tiles().rect(0), 0, false);
    sums.keep_brightest(film.identity().removes_fireflies);
    let mut order: Vec<u32> = indices.clone().collect();
    if backwards {
        order.reverse();
    }
    for index in order {
        for pixel in 0..SIDE * SIDE {
            let color = Spectrum::new(1.0, 0.5, 0.25) * value(pixel % SIDE, pixel / SIDE, index);
            let sample = SampleValues { color, alpha: 1.0, extra: &[], index };
            assert!(sums.add_weighted(pixel as usize, &sample, 1.0));
        }
    }
    let mut set = SampleSet::default();
    set.insert(indices.start.into()..indices.end.into());
    assert!(film.share().deposit_sums((0, None), &sums, &set, &NonFinite::default(), 0));
}

/// The red of the pixels, row by row.
fn red(film: &Film) -> Vec<f32> {
    film.develop(&desc(2, Fireflies::Keep), 1).linear.iter().map(|p| p[0]).collect()
}

const CENTER: usize = (SIDE * SIDE / 2) as usize;
const MIDDLE: u32 = SIDE / 2;

/// A random number in 0..1.
fn random(x: u32, y: u32, i: u32) -> f32 {
    let mut h = (x * 7919 + y * 104_729).wrapping_add(i.wrapping_mul(0x9e37_79b9));
    for _ in 0..3 {
        h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    }
    (h >> 8) as f32 / (1 << 24) as f32
}

/// Noise like that of a diffuse surface.
fn surface(x: u32, y: u32, i: u32) -> f32 {
    0.1 + 0.2 * random(x, y, i)
}

#[test]
fn a_spike_goes_and_its_neighbours_stay() {
    for samples in [4, 16, 64, 256] {
        for spike in [50.0, 1e3, 1e6] {
            let value = |x, y, i| {
                let is_spike = (x, y, i) == (MIDDLE, MIDDLE, 1);
                if is_spike { spike } else { surface(x, y, i) }
            };
            let kept = red(&film(samples, Fireflies::Keep, value));
            let removed = red(&film(samples, Fireflies::Remove, value));
            let clean = red(&film(samples, Fireflies::Keep, surface));
            assert!(kept[CENTER] > spike / samples as f32);
            let most = clean[CENTER] * if samples < 16 { 1.7 } else { 1.3 };
            assert!((0.7 * clean[CENTER]..most).contains(&removed[CENTER]), "{samples} {spike} {removed:?}");
            for i in (0..kept.len()).filter(|i| *i != CENTER) {
                assert_eq!(removed[i].to_bits(), kept[i].to_bits());
            }
        }
    }
}

/// Lights, lines and edges are seen by several samples of a pixel or of its neighbours: nothing changes.
#[test]
fn light_stays() {
    let lamp = |x: u32, y: u32, i: u32| {
        // An eighth of one pixel.
        if (x, y) == (MIDDLE, MIDDLE) && i.is_multiple_of(8) { 200.0 } else { surface(x, y, i) }
    };
    let line = |x: u32, y: u32, i: u32| {
        if x == y && i.is_multiple_of(16) { 500.0 } else { surface(x, y, i) }
    };
    let edge = |x: u32, _: u32, _: u32| if x < MIDDLE { 1e4 } else { 1e-3 };
    let flat = |_: u32, _: u32, _: u32| 0.3;
    fn same(samples: u32, value: impl Fn(u32, u32, u32) -> f32) {
        let [kept, removed] =
            [Fireflies::Keep, Fireflies::Remove].map(|f| red(&film(samples, f, &value)).into_iter());
        assert!(kept.map(f32::to_bits).eq(removed.map(f32::to_bits)), "{samples}");
    }
    for samples in [64, 256] {
        same(samples, lamp);
        same(samples, line);
    }
    for samples in [2, 3, 4, 16, 64] {
        same(samples, edge);
        same(samples, flat);
        same(samples, surface);
    }
}

/// Samples are `1 / p` with the probability `p`, and otherwise 0: the mean is 1. The more samples, the less
/// of it is lost, and in the end nothing.
#[test]
fn the_mean_converges() {
    let mean = |p: f32, samples: u32, fireflies: Fireflies| {
        let value = |x, y, i| if random(x, y, i) < p { 1.0 / p } else { 0.0 };
        let all = red(&film(samples, fireflies, value));
        f64::from(all.iter().sum::<f32>()) / all.len() as f64
    };
    let left = |p: f32, samples: u32| {
        let left = mean(p, samples, Fireflies::Remove) / mean(p, samples, Fireflies::Keep);
        // Sums of single precision leave some 1e-8 of the light.
        (1e6 * left).round() * 1e-6
    };
    let rare = [64, 128, 256, 512, 1024].map(|samples| left(0.01, samples));
    assert!(rare.is_sorted() && rare[0] < 0.1 && rare[4] == 1.0, "{rare:?}");
    let rarer = [64, 1024, 2048, 4096, 8192].map(|samples| left(0.001, samples));
    assert!(rarer.is_sorted() && rarer[0] < 0.1 && rarer[4] == 1.0, "{rarer:?}");
}

#[test]
fn order_and_splits_do_not_matter() {
    let value = |x: u32, y: u32, i: u32| if random(x, y, i) < 0.05 { 40.0 } else { surface(x, y, i) };
    let whole = film(32, Fireflies::Remove, value);
    let mut backwards = Film::new(&desc(32, Fireflies::Remove)).unwrap();
    add(&mut backwards, 0..32, true, &value);
    assert!(whole.to_bytes() == backwards.to_bytes());
    let mut parts = [0..5, 20..32, 5..20].map(|range| {
        let mut part = Film::new(&desc(32, Fireflies::Remove)).unwrap();
        add(&mut part, range, false, &value);
        Film::from_bytes(&part.to_bytes(), &Limits::default()).unwrap()
    });
    let [merged, others @ ..] = &mut parts;
    others.iter().for_each(|other| merged.merge(other).unwrap());
    assert!(whole.to_bytes() == merged.to_bytes());
    assert_eq!(whole.memory() - film(32, Fireflies::Keep, value).memory(), 64 * (SIDE * SIDE) as usize);
    // With and without are different pictures.
    let mut other = Film::new(&desc(32, Fireflies::Keep)).unwrap();
    let message = other.merge(&whole).unwrap_err().message;
    assert_eq!(message, "the films are of different pictures; fireflies: kept and removed");
    // Damaged bytes with a valid checksum.
    let bytes = whole.to_bytes();
    let length = bytes.len() - 8;
    for at in [length - 3, length - 16, length - 40] {
        let mut damaged = bytes[..length].to_vec();
        damaged[at] ^= 0x7f;
        damaged.extend(checksum(&damaged).to_le_bytes());
        let _ = Film::from_bytes(&damaged, &Limits::default());
        let mut short = bytes[..at].to_vec();
        short.extend(checksum(&short).to_le_bytes());
        assert!(Film::from_bytes(&short, &Limits::default()).is_err());
    }
}
