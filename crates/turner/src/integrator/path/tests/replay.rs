//! A replayed sample equals the rendered sample, and its contributions sum to it.

use super::replay_scenes::{HEIGHT, WIDTH, scenes, seen};
use crate::color::Spectrum;
use crate::description::SceneDesc;
use crate::film::{Antialias, PixelSum};
use crate::integrator::path::{End, Passage, PathRecord, replay};
use crate::integrator::{Caustics, ClassicDesc, IntegratorDesc, NormalsDesc, PathDesc, Prepared, Radiance};
use crate::render::sample;
use crate::schema::PrepareOptions;
use crate::testing::scenes::{path, render, scene};

fn bits(s: Spectrum) -> [u32; 3] {
    s.to_array().map(f32::to_bits)
}

fn prepared(desc: &SceneDesc) -> Prepared {
    desc.prepare(&PrepareOptions { threads: 1, ..Default::default() }).unwrap()
}

/// Pixels all over the image, different ones for each scene.
fn places(salt: u32) -> impl Iterator<Item = (u32, u32)> {
    let mut state = salt.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    std::iter::repeat_with(move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        ((state >> 8) % WIDTH, (state >> 20) % HEIGHT)
    })
}

/// The scene with this `caustics` setting. Splats of light paths belong to no sample.
fn with_caustics(mut desc: SceneDesc, caustics: Caustics) -> SceneDesc {
    if let IntegratorDesc::Path(path) = &mut desc.integrator {
        path.caustics = caustics;
        path.photon_radius = Some(1.0);
    }
    desc
}

#[test]
fn samples_of_the_picture_are_sums_of_their_records() {
    for (i, (name, desc, occurs)) in scenes().into_iter().enumerate() {
        let desc = with_caustics(desc, Caustics::Off);
        let scene = prepared(&desc);
        let picture = render(&desc).0;
        let mut occurred = false;
        for (x, y) in places(i as u32).take(150) {
            // The pixel is made of its four samples.
            let mut pixel = PixelSum::default();
            for index in 0..4 {
                let (path, rendered) = sample_and_record(&scene, (x, y, index), name);
                let by_lens = scene.view.weight(path.place.into());
                assert!(pixel.add_or_omit(rendered.color * by_lens, rendered.alpha));
                occurred |= occurs(&path);
                check(&path, name);
            }
            let [r, g, b, a] = pixel.mean().unwrap();
            let shown = picture.linear[(y * WIDTH + x) as usize];
            assert_eq!([r, g, b, a].map(f32::to_bits), shown.map(f32::to_bits), "{name}: {x},{y}");
        }
        assert!(occurred, "{name}: nothing of the kind was met");
    }
}

fn sample_and_record(scene: &Prepared, (x, y, index): (u32, u32, u32), name: &str) -> (PathRecord, Radiance) {
    let path = replay(scene, x, y, index).unwrap();
    let rendered = sample(scene, x, y, index).unwrap();
    let at = format!("{name}: {x},{y} sample {index}: {path:?}");
    assert_eq!(bits(path.sum()), bits(rendered.color), "{at}");
    assert_eq!(path.radiance, rendered, "{at}");
    (path, rendered)
}

/// With MIS weights against light paths, and with photons.
#[test]
fn samples_with_light_paths_are_sums_of_their_records() {
    let mut gathered = 0;
    for (i, (name, desc, _)) in scenes().into_iter().enumerate() {
        for caustics in [Caustics::LightTracing, Caustics::Full] {
            let scene = prepared(&with_caustics(desc.clone(), caustics));
            for (x, y) in places(i as u32).take(if i < 2 { 300 } else { 40 }) {
                let (path, _) = sample_and_record(&scene, (x, y, 1), name);
                gathered += path.vertices.iter().filter(|v| v.photons.is_some_and(|p| p.count > 0)).count();
            }
        }
    }
    assert!(gathered > 4, "{gathered}");
}

/// A further pixel of the same sample index does not trace the light paths again.
#[test]
fn photons_of_the_last_sample_are_kept() {
    let mut kept = 0;
    for (name, desc, _) in scenes() {
        let scene = prepared(&with_caustics(desc, Caustics::Full));
        scene.choose(1);
        let of = |index| scene.integrator.photons(&scene.scene, &scene.view, index);
        let (Some(first), Some(again)) = (of(1), of(1)) else { continue };
        assert!(std::sync::Arc::ptr_eq(&first, &again), "{name}");
        assert!(of(2).is_some_and(|other| other.index == 2), "{name}");
        kept += 1;
    }
    assert!(kept > 0);
}

/// Whether `found` equals `expected` up to a few roundings.
fn near(found: Spectrum, expected: Spectrum) -> bool {
    let pairs = found.to_array().into_iter().zip(expected.to_array());
    pairs.into_iter().all(|(f, e)| (f - e).abs() <= 2e-6 * f.abs().max(e.abs()) + 1e-30)
}

/// Power heuristic; an infinitely small density has no weight.
fn heuristic(pdf: f64, other: f64) -> f64 {
    let (a, b) = (pdf / pdf.max(other), other / pdf.max(other));
    a * a / (a * a + b * b)
}

/// The values of a record are consistent with one another.
fn check(path: &PathRecord, at: &str) {
    // Only scenes with "clamp" in their name have a clamp.
    let clamped = at.contains("clamp");
    let bsdf_sampled = at.starts_with("lights by BSDF sampling");
    let mut carried = Spectrum::WHITE;
    for (i, v) in path.vertices.iter().enumerate() {
        let way = v.way.as_ref();
        let reaches = carried * v.transmittance.unwrap_or(Spectrum::WHITE);
        let reaches = way.map_or(reaches, |w| reaches * w.weight);
        if let Some((_, l)) = way.and_then(|w| w.second.as_ref())
            && let Some(visible) = l.visible
        {
            assert!(near(l.contribution, l.unshadowed * visible), "second light {i} {at}");
        }
        let reaches = v.walk.map_or(reaches, |w| reaches * w.weight);
        let beside = way.map_or(0.0, |w| w.beside);
        assert!(near(v.throughput, reaches), "throughput {i} {at}");
        let way = v.p - v.origin;
        // A walk that is too long exits where it entered.
        assert!(v.walk.is_some() || (way.length() - v.t).abs() < 1e-5 * (1.0 + v.t), "t {i} {at}");
        if let Some(e) = &v.emission {
            let expected = v.throughput * e.radiance * e.weight as f32;
            assert!(clamped || near(e.contribution, expected), "emission {i} {at}");
            match e.pdf {
                Some(pdf) if e.light_pdf > 0.0 && !bsdf_sampled => {
                    assert!(
                        (e.weight - heuristic(pdf, e.light_pdf)).abs() < 1e-9,
                        "emission's weight {i} {at}"
                    );
                }
                _ => assert_eq!(e.weight, 1.0, "{at}"),
            }
        }
        // From here on one band stands for all, if it was chosen here.
        let onward = v.dispersed.unwrap_or(v.throughput);
        for l in v.lights.iter().filter(|l| l.visible.is_some()) {
            let through = l.transmittance.unwrap_or(Spectrum::WHITE);
            let counts = f64::from(l.counts);
            let expected = l.bsdf * l.radiance * (counts * l.weight * l.cosine / l.pdf) as f32 * through;
            let is = near(l.unshadowed, onward * expected);
            assert!(clamped || is, "light {i} {at}");
            assert!(near(l.contribution, l.unshadowed * l.visible.unwrap()), "visible light {i} {at}");
            let found = if l.is_delta { 0.0 } else { l.bsdf_pdf / l.pdf };
            let weight = if v.passage == Passage::Medium {
                1.0 / (1.0 + beside * beside + found * found)
            } else if l.is_delta {
                1.0
            } else {
                heuristic(l.pdf, l.bsdf_pdf)
            };
            assert!((l.weight - weight).abs() < 1e-9, "light's weight {i} {at}");
        }
        carried = onward;
        if let Some(s) = &v.scatter {
            let survival = s.roulette.map_or(1.0, |r| if r.number < r.survival { r.survival } else { 1.0 });
            let expected = onward * s.weight * (1.0 / survival) as f32;
            assert!(near(s.throughput, expected), "scattering {i} {at}");
            carried = s.throughput;
            if let Some(next) = path.vertices.get(i + 1).filter(|next| next.walk.is_none()) {
                assert_eq!(next.direction, s.direction, "{at}");
            }
        }
    }
    let lost = path.vertices.last().and_then(|v| v.scatter?.roulette).is_some_and(|r| r.number >= r.survival);
    assert_eq!(path.end == End::Roulette, lost, "{at}");
    if let Some(e) = &path.escape {
        assert_eq!(path.end, End::Escaped);
        let reaches = carried * e.transmittance.unwrap_or(Spectrum::WHITE);
        let reaches = e.way.as_ref().map_or(reaches, |w| reaches * w.weight);
        assert!(near(e.throughput, reaches), "outside {at}");
        let found = e.lights.iter().fold(e.background + e.ambient, |s, l| s + l.radiance * l.weight as f32);
        assert!(clamped || near(e.contribution, e.throughput * found), "found outside {at}");
    }
}

#[test]
fn what_cannot_be_replayed_is_an_error() {
    let mut desc = seen(path(PathDesc::default()));
    let path = prepared(&desc);
    let message = |scene: &Prepared, x, y, i| {
        let e = replay(scene, x, y, i).unwrap_err();
        format!("{} {}; {}", e.code.as_str(), e.message, e.help.unwrap())
    };
    assert!(message(&path, WIDTH, 0, 0).contains("no pixel in column 24, row 0: the picture has 24x16"));
    assert!(message(&path, 0, HEIGHT, 0).starts_with("E0105"));
    assert!(message(&path, 0, 0, 4).contains("no sample 4: samples of a pixel are numbered 0 to 3"));
    desc.film.antialias = Antialias::Adaptive;
    assert!(message(&prepared(&desc), 0, 0, 0).contains("shares samples between pixels"));
    for other in
        [IntegratorDesc::Classic(ClassicDesc::default()), IntegratorDesc::Normals(NormalsDesc::default())]
    {
        let name = other.type_name();
        let scene = prepared(&seen(scene(other)));
        let said = message(&scene, 0, 0, 0);
        assert!(said.starts_with("E0107") && said.contains(&format!("\"{name}\"")), "{said}");
        // Its samples can be traced separately nevertheless.
        assert!(sample(&scene, 3, 2, 1).unwrap().alpha == 1.0);
    }
}
