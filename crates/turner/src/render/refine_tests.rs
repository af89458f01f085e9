//! More camera rays for the denoiser.

use std::sync::atomic::AtomicBool;

use super::{PassOptions, Renderer};
use crate::color::Spectrum;
use crate::denoise::{Rgb, luminance};
use crate::description::{ObjectDesc, SceneDesc};
use crate::film::{Antialias, Denoise};
use crate::integrator::path::Caustics;
use crate::integrator::{IntegratorDesc, PathDesc, Prepared};
use crate::material::{MaterialDesc, PrincipledMaterial};
use crate::math::DVec3;
use crate::medium::HomogeneousMedium;
use crate::schema::{ColorSource, MaterialId, PrepareOptions};
use crate::shape::{BoxDesc, ShapeDesc, SphereDesc};
use crate::testing::scenes::{cuboid, even, grey, matte, path, plane, v};

const SIZE: [u32; 2] = [96, 64];

/// A glass sphere over a floor, below a small lamp that the camera sees.
fn scene(samples: u32, caustics: Caustics) -> Prepared {
    let mut desc = SceneDesc::default();
    [desc.film.width, desc.film.height] = SIZE;
    (desc.film.antialias, desc.film.samples) = (Antialias::MonteCarlo, samples);
    desc.film.denoise = Denoise::On;
    desc.integrator = IntegratorDesc::Path(PathDesc { caustics, ..PathDesc::default() });
    let grey = |v| ColorSource::Constant(Spectrum::grey(v));
    let clear = PrincipledMaterial {
        transmission_weight: grey(1.0),
        specular_roughness: grey(0.0),
        ..PrincipledMaterial::default()
    };
    let emissive = PrincipledMaterial { emission_luminance: 40.0, ..PrincipledMaterial::default() };
    desc.materials = [clear, emissive].map(|m| MaterialDesc::Principled(m).into()).into();
    let ball = |center, radius| ShapeDesc::Sphere(SphereDesc { center, radius });
    let (min, max) = (Some(DVec3::new(-3.0, -1.0, -3.0)), Some(DVec3::new(3.0, 0.0, 3.0)));
    let floor = ShapeDesc::Box(BoxDesc { min, max, center: None, size: None });
    let of = |material, shape| ObjectDesc { material: Some(MaterialId(material)), ..ObjectDesc::new(shape) };
    desc.objects = vec![
        of(0, ball(DVec3::new(0.0, 0.6, 0.0), 0.5)),
        of(1, ball(DVec3::new(1.2, 1.6, 0.0), 0.3)),
        ObjectDesc::new(floor),
    ];
    desc.prepare(&PrepareOptions::default()).unwrap()
}

/// A box of glowing fog on a floor.
fn fog_scene(samples: u32) -> Prepared {
    let mut desc = path(PathDesc::default())
        .seen_at(v(0.0, 2.0, 6.0), v(0.0, 0.5, 0.0), 40.0)
        .with(plane(), matte(grey(0.5)))
        .filled(
            cuboid(v(-1.0, 0.0, -1.0), v(1.0, 1.5, 1.0)),
            HomogeneousMedium {
                scattering: even(0.8),
                emission: Spectrum::grey(0.3),
                ..HomogeneousMedium::default()
            },
        )
        .filmed(SIZE, samples);
    desc.film.denoise = Denoise::On;
    desc.prepare(&PrepareOptions::default()).unwrap()
}

fn rendered(scene: Prepared) -> Renderer {
    let mut renderer = Renderer::new(scene).unwrap();
    let options = PassOptions { threads: 2, cancel: &AtomicBool::new(false), progress: None };
    renderer.pass(u32::MAX, &options).unwrap();
    renderer
}

/// Rays with the sample indices of the film find what the film found, light of photons excluded.
#[test]
fn rays_find_what_samples_find() {
    let scenes = [scene(8, Caustics::Off), scene(8, Caustics::Full), fog_scene(8)];
    for (number, scene) in scenes.into_iter().enumerate() {
        let renderer = rendered(scene);
        let buffers = renderer.denoising_buffers(&renderer.developed_as(Denoise::Off, 1), 1).unwrap();
        let pixels: Vec<u32> = (0..SIZE[0] * SIZE[1]).collect();
        let (means, traced) = renderer.guide_means(&pixels, 0..8, 2);
        assert!(traced >= 8 * pixels.len() as u64);
        for (i, mean) in means.iter().enumerate() {
            let near = |a: f32, b: f32| (a - b).abs() <= 1e-4 * (1.0 + a.abs());
            let emission = buffers.emission.mean[i].iter().zip(mean.emission);
            assert!(
                emission.clone().all(|(a, b)| near(*a, b)),
                "{number} {i} {:?}",
                emission.collect::<Vec<_>>()
            );
            assert!(buffers.guides[i].iter().zip(mean.guides).all(|(a, b)| near(*a, b)), "{number} {i}");
        }
    }
}

/// The error of emission relative to a picture of many samples.
fn error(found: &[Rgb], truth: &[Rgb]) -> f64 {
    let each = found.iter().zip(truth).map(|(a, b)| {
        let (a, b) = (f64::from(luminance(a)), f64::from(luminance(b)));
        (a - b) * (a - b) / (b * b + 0.01)
    });
    each.sum::<f64>() / found.len() as f64
}

#[test]
fn more_rays_smooth_the_edges_of_lamps() {
    let truth = rendered(scene(512, Caustics::Off));
    let truth = truth.denoising_buffers(&truth.developed_as(Denoise::Off, 2), 2).unwrap();
    let few = rendered(scene(4, Caustics::Off));
    let developed = few.developed_as(Denoise::Off, 2);
    let plain = few.denoising_buffers(&developed, 2).unwrap();
    let refined = few.refined_buffers(&developed, 2).unwrap();
    let [before, after] = [&plain, &refined].map(|b| error(&b.emission.mean, &truth.emission.mean));
    assert!(before > 0.001 && after < 0.4 * before, "{before} {after}");
    let sum = |pixels: &[Rgb]| pixels.iter().map(|v| f64::from(luminance(v))).sum::<f64>();
    let [all, own] = [&truth, &refined].map(|b| sum(&b.emission.mean));
    assert!((own / all - 1.0).abs() < 0.02, "{own} {all}");
    // The same on any number of threads.
    let one = few.refined_buffers(&developed, 1).unwrap();
    assert!(one.emission.mean == refined.emission.mean && one.guides == refined.guides);
    assert!(one.reflected.mean == refined.reflected.mean && one.uncertain == refined.uncertain);
}

#[test]
fn the_error_that_is_left_is_known_after_developing() {
    let few = rendered(scene(4, Caustics::Off));
    assert_eq!(few.left_after_denoising(), None, "nothing is denoised yet");
    few.developed_as(Denoise::Fast, 1);
    assert_eq!(few.left_after_denoising(), None, "the fast denoiser does not estimate");
    few.developed(1);
    let one = few.left_after_denoising();
    few.developed(2);
    assert!(one.is_some_and(|left| left > 0.0) && one == few.left_after_denoising());
}
