//! Examinations do not change the scene.

use super::{Options, examine, maps};
use crate::color::Spectrum;
use crate::description::{ObjectDesc, SceneDesc};
use crate::film::Antialias;
use crate::integrator::path::Caustics;
use crate::integrator::{IntegratorDesc, PathDesc, Prepared};
use crate::material::{MaterialDesc, PrincipledMaterial};
use crate::math::DVec3;
use crate::render::sample;
use crate::schema::{ColorSource, MaterialId, PrepareOptions};
use crate::shape::{BoxDesc, ShapeDesc, SphereDesc};

/// A glass sphere over a floor, below an emissive sphere, so that light paths are traced.
fn glass() -> SceneDesc {
    let mut desc = SceneDesc::default();
    (desc.film.width, desc.film.height) = (24, 16);
    (desc.film.antialias, desc.film.samples) = (Antialias::MonteCarlo, 4);
    desc.integrator =
        IntegratorDesc::Path(PathDesc { caustics: Caustics::LightTracing, ..PathDesc::default() });
    let grey = |v| ColorSource::Constant(Spectrum::grey(v));
    let clear = PrincipledMaterial {
        transmission_weight: grey(1.0),
        specular_roughness: grey(0.0),
        ..PrincipledMaterial::default()
    };
    let emissive = PrincipledMaterial { emission_luminance: 40.0, ..PrincipledMaterial::default() };
    desc.materials = [clear, emissive].map(|m| MaterialDesc::Principled(m).into()).into();
    let ball =
        |height, radius| ShapeDesc::Sphere(SphereDesc { center: DVec3::new(0.0, height, 0.0), radius });
    let (min, max) = (Some(DVec3::new(-3.0, -1.0, -3.0)), Some(DVec3::new(3.0, 0.0, 3.0)));
    let floor = ShapeDesc::Box(BoxDesc { min, max, center: None, size: None });
    let of = |material, shape| ObjectDesc { material: Some(MaterialId(material)), ..ObjectDesc::new(shape) };
    desc.objects = vec![of(0, ball(1.0, 0.5)), of(1, ball(4.0, 0.5)), ObjectDesc::new(floor)];
    desc
}

/// The first sample of each pixel.
fn picture(prepared: &Prepared) -> Vec<Spectrum> {
    let pixels = (0..16).flat_map(|y| (0..24).map(move |x| (x, y)));
    pixels.map(|(x, y)| sample(prepared, x, y, 0).unwrap().color).collect()
}

#[test]
fn an_examination_does_not_change_the_scene() {
    let desc = glass();
    let prepared = desc.prepare(&PrepareOptions::default()).unwrap();
    let (before, count) = (picture(&prepared), prepared.integrator.light_paths());
    assert!(count > 0, "the scene has light paths");
    let options = Options { pixels: 32, samples: 4, threads: 1, ..Options::default() };
    let examined = examine(&prepared, &desc, &options);
    assert!(examined.findings.iter().all(|f| f.code != "debug-view"));
    assert_eq!((prepared.integrator.light_paths(), &prepared.view.film), (count, &desc.film));
    assert_eq!(picture(&prepared), before);
    assert_eq!(maps::maps(&prepared, &desc, &options).len(), 3);
    assert_eq!(prepared.integrator.light_paths(), count);
}
