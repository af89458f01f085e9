//! Pictures of cameras whose light has factors: lenses that darken the corners.

use super::pixel as explain;
use crate::camera::{LensBrightness, RealisticDesc};
use crate::description::SceneDesc;
use crate::film::{Antialias, FilmDesc};
use crate::integrator::{AlbedoDesc, Caustics, ClassicDesc, DirectDesc, IntegratorDesc, PathDesc};
use crate::material::DielectricMaterial;
use crate::schema::PrepareOptions;
use crate::testing::scenes::{
    emissive, grey, matte, path, pixel, rectangle, render, render_with, scene, sphere, v,
};

const SIZE: [u32; 2] = [30, 20];

fn lens() -> RealisticDesc {
    RealisticDesc { position: v(0.0, 0.0, 4.0), look_at: v(0.0, 0.0, 0.0), ..RealisticDesc::default() }
}

/// A wall that fills the picture and emits a radiance of 2.
fn wall(integrator: IntegratorDesc) -> SceneDesc {
    let desc = scene(integrator).seen(lens()).sized(SIZE).before_color([2.0, 2.0, 2.0]);
    desc.with(rectangle(v(0.0, 0.0, 0.0), v(9.0, 0.0, 0.0), v(0.0, 9.0, 0.0)), emissive(2.0, grey(1.0)))
}

#[test]
fn an_even_wall_shows_what_the_lens_does() {
    let [path, direct, classic] = [
        IntegratorDesc::Path(PathDesc::default()),
        IntegratorDesc::Direct(DirectDesc::default()),
        IntegratorDesc::Classic(ClassicDesc::default()),
    ];
    for integrator in [path, direct, classic] {
        let name = integrator.type_name();
        let mut desc = wall(integrator.clone());
        if name == "classic" {
            desc.objects.clear();
        }
        for brightness in [LensBrightness::Relative, LensBrightness::Absolute] {
            let desc = desc.clone().seen(RealisticDesc { brightness, ..lens() });
            for antialias in [Antialias::None, Antialias::Mean, Antialias::Grid, Antialias::MonteCarlo] {
                let film = FilmDesc { antialias, samples: 16, ..desc.film.clone() };
                let desc = SceneDesc { film, ..desc.clone() };
                let prepared = desc.prepare(&PrepareOptions::default()).unwrap();
                let picture = render(&desc).0;
                let center = prepared.view.weight([15.0, 10.0].into());
                for (x, y) in [(0, 0), (14, 9), (29, 10), (7, 19)] {
                    // The factor is nearly a line within a pixel.
                    let weight = prepared.view.weight([f64::from(x) + 0.5, f64::from(y) + 0.5].into());
                    let found = pixel(&picture, x, y)[1];
                    // "mean" takes in the neighbours.
                    let tolerance = if antialias == Antialias::Mean { 0.12 } else { 0.02 };
                    let expected = 2.0 * weight;
                    assert!(
                        (found - expected).abs() < tolerance * center,
                        "{name} {antialias:?} {x} {y}: {found} {expected}"
                    );
                    let record = explain(&prepared, x, y).unwrap();
                    let sum: f64 =
                        record.samples.iter().map(|s| s.weight * f64::from(s.radiance.color.g)).sum();
                    assert!(
                        (sum - f64::from(found)).abs() < 1e-5,
                        "{name} {antialias:?} {x} {y}: {sum} {found}"
                    );
                    assert!(record.samples.iter().all(|s| (s.radiance.color.g - 2.0).abs() < 1e-5), "{name}");
                }
                let (middle, corner) = (pixel(&picture, 15, 10)[0], pixel(&picture, 0, 0)[0]);
                assert!(corner < 0.7 * middle, "{corner} {middle}");
                // π/4 of the f-number, 2, squared; less for a near object.
                let whole = if brightness == LensBrightness::Relative { 2.0 } else { 2.0 * 0.19 };
                assert!((middle / whole - 1.0).abs() < 0.05, "{name} {brightness:?}: {middle}");
            }
        }
    }
}

/// Clamped is what reaches the film.
#[test]
fn samples_are_clamped_behind_the_lens() {
    let mut desc = wall(IntegratorDesc::Path(PathDesc::default())).filmed(SIZE, 4);
    desc.film.clamp_sample = 1.0;
    let prepared = desc.prepare(&PrepareOptions::default()).unwrap();
    let picture = render(&desc).0;
    for (x, y) in [(15, 10), (0, 0), (3, 10)] {
        let weight = prepared.view.weight([f64::from(x) + 0.5, f64::from(y) + 0.5].into());
        let found = pixel(&picture, x, y)[1];
        assert!((found - (2.0 * weight).min(1.0)).abs() < 0.03, "{x} {y}: {found} {weight}");
    }
}

/// Pictures of what is not light have no factors.
#[test]
fn properties_of_the_first_hit_stay() {
    let mut desc = wall(IntegratorDesc::Albedo(AlbedoDesc::default()));
    desc.objects.clear();
    let desc = desc.with(rectangle(v(0.0, 0.0, 0.0), v(9.0, 0.0, 0.0), v(0.0, 9.0, 0.0)), matte(grey(0.25)));
    let picture = render(&desc).0;
    assert_eq!((pixel(&picture, 0, 0), pixel(&picture, 15, 10)), ([0.25; 3], [0.25; 3]));
    let light = desc.prepare(&PrepareOptions::default()).unwrap();
    assert!(
        !light.view.weighted && light.with_integrator(&PathDesc::default()).is_ok_and(|p| p.view.weighted)
    );
}

/// Light paths do not reach such a camera, whatever is asked for, and the bytes do not depend on threads and passes.
#[test]
fn caustics_come_from_camera_paths_alone() {
    let desc = path(PathDesc { caustics: Caustics::Full, ..PathDesc::default() })
        .with(rectangle(v(0.0, -1.0, 0.0), v(9.0, 0.0, 0.0), v(0.0, 0.0, -9.0)), matte(grey(0.5)))
        .with(sphere(v(0.0, 0.0, 0.0), 0.6), DielectricMaterial::default())
        .with(sphere(v(1.0, 2.0, 0.0), 0.3), emissive(5.0, grey(1.0)));
    let of = |desc: &SceneDesc| desc.prepare(&PrepareOptions::default()).unwrap();
    let pinhole = desc.clone().seen_at(v(0.0, 0.0, 4.0), v(0.0, 0.0, 0.0), 40.0).filmed(SIZE, 8);
    let prepared = of(&pinhole);
    prepared.choose(1);
    assert!(prepared.integrator.light_paths() > 0);
    let desc = desc.seen(lens()).filmed(SIZE, 8);
    let prepared = of(&desc);
    prepared.choose(1);
    assert_eq!(prepared.integrator.light_paths(), 0);
    let whole = render_with(&desc, 1, u32::MAX).0;
    assert_eq!(whole.linear, render_with(&desc, 3, 1).0.linear);
    assert!(whole.linear.iter().all(|p| p.iter().all(|v| v.is_finite())));
}
