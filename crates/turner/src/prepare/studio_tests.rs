//! What the default studio shows: backdrop, floor, light and glass.

use crate::color::{Spectrum, Tonemap, Transfer};
use crate::description::{SceneDesc, StudioDesc};
use crate::film::DisplayTransform;
use crate::integrator::{IntegratorDesc, PathDesc, Prepared};
use crate::light::Light;
use crate::material::DielectricMaterial;
use crate::schema::PrepareOptions;
use crate::testing::scenes::{grey, matte, render, sphere, v};

/// A white ball of radius 1 in the studio.
fn ball(studio: StudioDesc) -> SceneDesc {
    let mut desc =
        SceneDesc { integrator: IntegratorDesc::Path(PathDesc::default()), ..SceneDesc::default() }
            .with(sphere(v(0.0, 1.0, 0.0), 1.0), matte(grey(0.8)))
            .filmed([32, 32], 4);
    desc.film.tonemap = Tonemap::Studio;
    desc.film.transfer = Transfer::Srgb;
    desc.studio = Some(studio);
    desc
}

fn from(camera: &str) -> StudioDesc {
    StudioDesc { camera: Some(camera.to_owned()), ground: Some(true), ..StudioDesc::default() }
}

fn prepared(desc: &SceneDesc) -> Prepared {
    desc.prepare(&PrepareOptions::default()).unwrap()
}

/// The picture's corners as display values.
fn corners(desc: &SceneDesc) -> Vec<[u8; 4]> {
    let (picture, _) = render(desc);
    let film = prepared(desc).view.film.clone();
    let transform = DisplayTransform {
        exposure: film.exposure,
        tonemap: film.tonemap,
        transfer: film.transfer,
        ..DisplayTransform::default()
    };
    [0, 31, 31 * 32, 31 * 33].map(|i| transform.to_8_bits(&[picture.linear[i]], 1)[0]).to_vec()
}

#[test]
fn the_backdrop_has_no_seam_and_no_lights_from_any_direction() {
    for camera in ["orbit:35,22", "orbit:200,1", "orbit:0,0", "orbit:90,-30", "orbit:10,88"] {
        for (backdrop, value) in [(None, 245), (Some(Spectrum::WHITE), 255)] {
            for exposure in [0.0, 1.5] {
                let mut desc = ball(StudioDesc { backdrop, ..from(camera) });
                desc.film.exposure = exposure;
                let found = corners(&desc);
                // Shadows reach other corners, seen from above.
                let seen = |c: &[u8; 4]| c[0].abs_diff(value) <= 1 && c[0] == c[1] && c[1] == c[2];
                assert!(seen(&found[0]), "{camera} {backdrop:?} {exposure}: {found:?}");
            }
        }
    }
}

#[test]
fn a_floor_is_seen_by_its_shadows_and_not_from_below() {
    for (camera, floor) in [("orbit:35,22", true), ("orbit:0,0", true), ("orbit:35,-22", false)] {
        let scene = prepared(&ball(from(camera))).scene;
        assert_eq!(!scene.shadow_catchers.is_empty(), floor, "{camera}");
    }
    // Under the ball it is darker than beside it.
    let (picture, _) = render(&ball(from("orbit:0,15")));
    let least = (24..32).map(|y| picture.linear[y * 32 + 16][0]).fold(f32::INFINITY, f32::min);
    assert!(least < 0.4, "{least}");
}

#[test]
fn the_lights_stand_relative_to_an_orbit_camera() {
    let radiance = |camera: &str, azimuth: f64| {
        let scene = prepared(&ball(from(camera))).scene;
        let (s, c) = crate::math::elementary::sin_cos(crate::math::radians(azimuth));
        match &scene.lights[0] {
            Light::Environment(light) => light.radiance(v(s, 1.0, c)).r,
            light => panic!("the studio is an environment: {light:?}"),
        }
    };
    for turn in [0.0, 90.0, 215.0] {
        let camera = format!("orbit:{turn},20");
        assert!((radiance(&camera, turn - 46.0) - radiance("orbit:0,20", -46.0)).abs() < 0.05, "{turn}");
    }
    assert!(radiance("orbit:0,20", -46.0) > 2.0 * radiance("orbit:0,20", 46.0));
    let scene = prepared(&ball(from("orbit:0,20"))).scene;
    let turned = scene.with_turned_studio(90.0).unwrap();
    let Light::Environment(light) = &turned.lights[0] else { panic!("an environment") };
    let (s, c) = crate::math::elementary::sin_cos(crate::math::radians(44.0));
    assert!((light.radiance(v(s, 1.0, c)).r - radiance("orbit:0,20", -46.0)).abs() < 0.05);
}

#[test]
fn white_reads_as_white_and_keeps_its_shape() {
    let (picture, _) = render(&ball(from("orbit:0,20")));
    let at = |x: usize, y: usize| Tonemap::Studio.map(Spectrum::grey(picture.linear[y * 32 + x][0])).r;
    let (lit, shaded) = (at(12, 11), at(22, 20));
    assert!((0.6..0.99).contains(&lit), "{lit}");
    assert!(shaded < 0.8 * lit, "{shaded} {lit}");
}

#[test]
fn glass_before_a_transparent_background_is_transparent() {
    let mut desc = ball(StudioDesc { ground: Some(false), ..from("orbit:0,0") });
    let glass = DielectricMaterial { ior: 1.5, ..DielectricMaterial::default() };
    desc = SceneDesc { objects: Vec::new(), materials: Vec::new(), ..desc }
        .with(sphere(v(0.0, 1.0, 0.0), 1.0), glass.principled());
    desc.film.samples = 64;
    desc.background.transparent = true;
    let (picture, _) = render(&desc);
    let center = picture.linear[16 * 32 + 16];
    // Two faces at normal incidence reflect 4 % each.
    assert!((0.01..0.2).contains(&center[3]), "{center:?}");
    let edge = picture.linear[16 * 32 + 4];
    assert!(edge[3] < 1.0 && picture.linear[0][3] == 0.0, "{edge:?}");
}
