//! Values of AOVs by formula, and that they change nothing else.
#![allow(
    clippy::disallowed_methods,
    reason = "expected values are independent of the renderer's own functions"
)]

use std::sync::atomic::AtomicBool;

use crate::description::{ObjectDesc, SceneDesc};
use crate::film::{Antialias, Aov, Aovs, Picture, Reconstruction};
use crate::filter::FilterKind;
use crate::integrator::{Caustics, ClassicDesc, DirectDesc, IntegratorDesc, PathDesc, SharedPathsMode};
use crate::light::BackgroundDesc;
use crate::material::DielectricMaterial;
use crate::math::{DAffine3, DVec3};
use crate::render::{AovValues, PassOptions, Renderer};
use crate::schema::{PrepareOptions, Transform};
use crate::testing::scenes::{emissive, grey, lamp, matte, path, plane, rectangle, render, rgb, sphere, v};

/// The developed AOVs, and what else the file has.
pub(super) struct Rendered {
    pub(super) picture: Picture,
    pub(super) renderer: Renderer,
}

impl Rendered {
    pub(super) fn of(desc: &SceneDesc, aovs: &[Aov]) -> Rendered {
        let mut desc = desc.clone();
        desc.film.aovs = Aovs::new(aovs);
        let prepared = desc.prepare(&PrepareOptions::default()).unwrap();
        let mut renderer = Renderer::new(prepared).unwrap();
        let options = PassOptions { threads: 2, cancel: &AtomicBool::new(false), progress: None };
        assert!(renderer.pass(u32::MAX, &options).unwrap());
        assert_eq!(renderer.film.non_finite.count, 0);
        Rendered { picture: renderer.develop(), renderer }
    }

    fn all(desc: &SceneDesc) -> Rendered {
        Rendered::of(desc, &Aov::all().collect::<Vec<_>>())
    }

    pub(super) fn channel(&self, name: &str) -> Vec<f64> {
        let all = self.renderer.develop_aovs(2);
        let found = all.into_iter().find(|c| c.name == name).unwrap_or_else(|| panic!("{name}"));
        match found.values {
            AovValues::Float(v) => v.into_iter().map(f64::from).collect(),
            AovValues::Uint(v) => v.into_iter().map(f64::from).collect(),
        }
    }

    #[track_caller]
    pub(super) fn is(&self, name: &str, x: usize, y: usize, expected: f64) {
        let found = self.channel(name)[y * self.picture.width as usize + x];
        assert!(
            (found - expected).abs() < 1e-5 * expected.abs().max(1.0),
            "{name} ({x}, {y}): {found} {expected}"
        );
    }
}

/// A white wall in the left half of a picture of 16 x 12 pixels; its edge is at x = 0, in the middle of column 8's left
/// border. It is at a distance of 5 from the camera, and one pixel is 0.5 wide there.
fn wall() -> SceneDesc {
    // Half of the picture's height is 3 at a distance of 5.
    let fov = 2.0 * (3.0f64 / 5.0).atan().to_degrees();
    let mut object = ObjectDesc::new(rectangle(v(-5.0, 0.0, 0.0), v(10.25, 0.0, 0.0), v(0.0, 20.0, 0.0)));
    object.name = Some("wall".to_owned());
    let mut desc = path(PathDesc::default())
        .with_object(object, matte(rgb([0.2, 0.4, 0.6])))
        .seen_from_front(5.0, fov)
        .filmed([16, 12], 16);
    desc.background = BackgroundDesc { transparent: true, ..desc.background };
    desc
}

#[test]
fn values_of_a_wall_that_faces_the_camera() {
    let r = Rendered::all(&wall());
    // Columns 0 to 7 are covered, a quarter of column 8, and nothing beyond.
    for (name, inside) in [
        ("Z", 5.0),
        ("N.X", 0.0),
        ("N.Z", 1.0),
        ("Nc.Z", 1.0),
        ("Ng.Z", 1.0),
        ("albedo.R", 0.2),
        ("albedo.B", 0.6),
        ("object_id", 1.0),
        ("material_id", 1.0),
        ("instance_id", 1.0),
        ("P.Z", 0.0),
        ("motion.X", 0.0),
        ("sample_count", 16.0),
        ("CryptoObject00.G", 1.0),
        ("CryptoObject00.A", 0.0),
    ] {
        r.is(name, 3, 4, inside);
    }
    for (name, outside) in [
        ("Z", 1e10),
        ("distance.Z", 1e10),
        ("N.Z", 0.0),
        ("albedo.R", 0.0),
        ("object_id", 0.0),
        ("P.X", 0.0),
        ("CryptoObject00.G", 0.0),
        ("sample_count", 16.0),
    ] {
        r.is(name, 12, 4, outside);
    }
    // White light on a diffuse wall is noise; outside there is none.
    assert!(r.channel("error").iter().all(|v| v.is_finite() && *v >= 0.0));
    r.is("error", 12, 4, 0.0);
    // The mean position of column 7's samples is its centre, up to their placement.
    assert!((r.channel("P.X")[7] + 0.25).abs() < 0.05);
    // At the edge depth is that of the wall, not a mean with what is behind it; colours are weighted by coverage.
    r.is("Z", 8, 4, 5.0);
    let alpha = f64::from(r.picture.linear[4 * 16 + 8][3]);
    assert!((alpha - 0.25).abs() < 0.1, "{alpha}");
    r.is("albedo.R", 8, 4, 0.2 * alpha);
    r.is("CryptoObject00.G", 8, 4, alpha);
    let distance = (25.0f64 + 0.5 * 0.5 * 0.5).sqrt();
    assert!((r.channel("distance.Z")[6 * 16 + 7] - distance).abs() < 0.05);
}

/// Every combination of sums: importance sampling, weights, one sample, adaptive squares, shared paths.
#[test]
fn the_colour_has_the_same_bits_with_and_without() {
    let lit = |integrator| {
        let ball = sphere(v(1.0, -2.0, 1.0), 1.0);
        let mut desc = wall().with(ball, matte(grey(0.5))).lit(lamp(v(1.0, 4.0, 3.0), 20.0));
        desc.integrator = integrator;
        desc.film.samples = 4;
        desc
    };
    let path = || IntegratorDesc::Path(PathDesc::default());
    let shared = PathDesc { shared_paths: SharedPathsMode::Always, ..PathDesc::default() };
    let mut scenes = vec![
        lit(path()),
        lit(IntegratorDesc::Path(shared)),
        lit(IntegratorDesc::Direct(DirectDesc::default())),
        lit(IntegratorDesc::Classic(ClassicDesc::default())),
    ];
    for (antialias, filter, reconstruction) in [
        (Antialias::MonteCarlo, FilterKind::Tent, Reconstruction::Weighted),
        (Antialias::MonteCarlo, FilterKind::Gaussian, Reconstruction::Importance),
        (Antialias::None, FilterKind::Box, Reconstruction::Weighted),
        (Antialias::Adaptive, FilterKind::Box, Reconstruction::Weighted),
        (Antialias::Mean, FilterKind::Box, Reconstruction::Weighted),
        (Antialias::Grid, FilterKind::Box, Reconstruction::Weighted),
    ] {
        let mut desc = lit(path());
        (desc.film.antialias, desc.film.filter, desc.film.reconstruction) =
            (antialias, filter, reconstruction);
        scenes.push(desc);
    }
    for desc in scenes {
        let (plain, _) = render(&desc);
        let with = Rendered::all(&desc);
        assert!(plain == with.picture, "{:?}", desc.film);
        assert_eq!(with.channel("Z")[0], 5.0, "{:?}", desc.film);
    }
}

/// Emission, direct and indirect light and caustics are the colour.
#[test]
fn the_parts_of_the_light_add_up() {
    let closed = |desc: PathDesc| {
        let glass = DielectricMaterial::default();
        path(desc)
            .with(plane(), matte(grey(0.6)))
            .with(rectangle(v(0.0, 1.0, -1.0), v(4.0, 0.0, 0.0), v(0.0, 4.0, 0.0)), matte(grey(0.7)))
            .with(sphere(v(-0.4, 0.4, 0.0), 0.4), glass)
            .with(sphere(v(0.5, 0.2, 0.2), 0.2), emissive(3.0, grey(1.0)))
            .seen_at(v(0.0, 1.0, 4.0), v(0.0, 0.5, 0.0), 40.0)
            .before(0.2)
            .filmed([24, 16], 8)
    };
    for desc in [
        PathDesc { caustics: Caustics::Off, ..PathDesc::default() },
        PathDesc { caustics: Caustics::LightTracing, ..PathDesc::default() },
        PathDesc { caustics: Caustics::Full, max_depth: 4, ..PathDesc::default() },
        PathDesc { shared_paths: SharedPathsMode::Always, ..PathDesc::default() },
        PathDesc { max_depth: 0, ..PathDesc::default() },
    ] {
        let mut scene = closed(desc.clone());
        scene.film.clamp_sample = 4.0;
        let r = Rendered::of(&scene, &[Aov::Emission, Aov::Direct, Aov::Indirect, Aov::Caustics]);
        for (i, band) in ["R", "G", "B"].iter().enumerate() {
            let part = |name: &str| r.channel(&format!("{name}.{band}"));
            let parts = ["emission", "direct", "indirect", "caustics"].map(part);
            let mut totals = [0.0; 4];
            for (pixel, linear) in r.picture.linear.iter().enumerate() {
                let sum: f64 = parts.iter().map(|p| p[pixel]).sum();
                assert!((sum - f64::from(linear[i])).abs() < 2e-5, "{desc:?}: {sum} {linear:?}");
                assert!(parts.iter().all(|p| p[pixel] > -2e-5), "{desc:?} {pixel}");
                totals.iter_mut().zip(&parts).for_each(|(t, p)| *t += p[pixel]);
            }
            let [emission, direct, indirect, caustics] = totals;
            assert!(emission > 1.0);
            assert_eq!(direct > 1.0 && indirect > 1.0, desc.max_depth > 0, "{desc:?} {totals:?}");
            let tracing = matches!(desc.caustics, Caustics::LightTracing | Caustics::Full);
            assert!(!tracing || caustics > 0.0, "{desc:?} {totals:?}");
        }
    }
    // The emitter itself, and nothing else, is emission in a closed dark room.
    let dark = closed(PathDesc { caustics: Caustics::Off, ..PathDesc::default() }).before(0.0);
    let r = Rendered::of(&dark, &[Aov::Emission, Aov::ObjectId]);
    let (emission, ids) = (r.channel("emission.R"), r.channel("object_id"));
    assert!(ids.iter().zip(&emission).any(|(id, e)| *id == 4.0 && *e > 0.5));
    assert!(ids.iter().zip(&emission).all(|(_, e)| *e <= 3.0 + 1e-4));
    // Light that takes two bounces at most: what "direct" alone sees is emission and direct light.
    let once = closed(PathDesc { max_depth: 1, caustics: Caustics::Off, ..PathDesc::default() });
    let r = Rendered::of(&once, &[Aov::Indirect]);
    assert!(r.channel("indirect.R").iter().all(|v| v.abs() < 2e-5));
}

#[test]
fn motion_is_in_pixels_over_the_shutter() {
    let mut desc = wall();
    // One unit is two pixels at the wall.
    desc.objects[0].motion = Some(Transform(DAffine3::from_translation(v(-1.0, 0.5, 0.0))));
    desc.film.shutter = [0.0, 0.5];
    let r = Rendered::of(&desc, &[Aov::Motion, Aov::Depth]);
    r.is("motion.X", 3, 4, -1.0);
    r.is("motion.Y", 3, 4, 0.5);
    r.is("motion.X", 12, 4, 0.0);
    r.is("Z", 3, 4, 5.0);
}

#[test]
fn what_a_moving_camera_sees_moves_in_the_picture() {
    let mut desc = wall();
    let shift = Transform(DAffine3::from_translation(v(1.0, -0.5, -2.0)));
    *desc.camera.as_mut().unwrap().value.motion_mut() = Some(shift);
    desc.film.shutter = [0.0, 0.0];
    let r = Rendered::of(&desc, &[Aov::Motion, Aov::Depth]);
    r.is("motion.X", 3, 4, 0.0);
    r.is("Z", 3, 4, 5.0);
    desc.film.shutter = [0.5, 0.5];
    let r = Rendered::of(&desc, &[Aov::Depth, Aov::Normal]);
    // Half way, the wall is one unit nearer.
    r.is("Z", 3, 4, 4.0);
    desc.film.shutter = [0.0, 0.5];
    let sideways = Transform(DAffine3::from_translation(v(1.0, -0.5, 0.0)));
    *desc.camera.as_mut().unwrap().value.motion_mut() = Some(sideways);
    let r = Rendered::of(&desc, &[Aov::Motion, Aov::Depth]);
    r.is("motion.X", 3, 4, -1.0);
    r.is("motion.Y", 3, 4, 0.5);
    r.is("Z", 3, 4, 5.0);
}

#[test]
fn mattes_have_names_and_add_up_to_alpha() {
    let named = |name: &str, shape| ObjectDesc { name: Some(name.to_owned()), ..ObjectDesc::new(shape) };
    let mut desc = wall()
        .with_object(named("ball \"é\"", sphere(v(0.5, 0.0, 0.5), 1.2)), matte(grey(0.5)))
        .with_object(named("wall", sphere(v(2.0, 1.0, 0.0), 0.7)), matte(grey(0.5)))
        .with(sphere(DVec3::new(-1.0, -1.0, 1.0), 0.6), matte(grey(0.5)));
    desc.materials[1].name = Some("paint".to_owned());
    (desc.film.filter, desc.film.samples) = (FilterKind::BlackmanHarris, 32);
    let r = Rendered::of(&desc, &[Aov::CryptoObject, Aov::CryptoMaterial, Aov::CryptoAsset, Aov::ObjectId]);
    for layer in ["CryptoObject", "CryptoMaterial", "CryptoAsset"] {
        let channels = (0..3).flat_map(|i| ["G", "A"].map(|c| r.channel(&format!("{layer}{i:02}.{c}"))));
        let parts: Vec<Vec<f64>> = channels.collect();
        for (pixel, linear) in r.picture.linear.iter().enumerate() {
            let sum: f64 = parts.iter().map(|p| p[pixel]).sum();
            assert!((sum - f64::from(linear[3])).abs() < 1e-5, "{layer} {pixel}: {sum} {}", linear[3]);
            assert!(parts.windows(2).all(|p| p[0][pixel] >= p[1][pixel]), "{layer} {pixel}");
        }
    }
    let attributes = r.renderer.aov_attributes();
    let of = |name: &str| {
        let end = format!("/{name}");
        attributes.iter().filter(|(key, _)| key.ends_with(&end)).map(|(_, v)| v.as_str()).collect::<Vec<_>>()
    };
    let mut layers = of("name");
    layers.sort_unstable();
    assert_eq!(layers, ["CryptoAsset", "CryptoMaterial", "CryptoObject"]);
    assert_eq!(of("hash"), ["MurmurHash3_32"; 3]);
    let manifests = of("manifest");
    // Two objects share a name and so a matte; one has none.
    let objects = manifests.iter().find(|m| m.contains("object.4")).unwrap();
    assert!(objects.contains(r#""ball \"\u00e9\"":""#) && objects.contains(r#""wall":""#), "{objects}");
    assert_eq!(objects.matches(':').count(), 3, "{objects}");
    assert!(manifests.iter().any(|m| m.contains("\"paint\":") && m.contains("\"material.1\":")));
    assert!(manifests.iter().any(|m| m.contains("\"instance.4\":")));
    assert!(attributes.iter().all(|(key, _)| key.len() <= 31), "{attributes:?}");
    let ids = attributes.iter().find(|(key, _)| key == "turner:object_id").unwrap();
    assert!(ids.1.starts_with(r#"{"1":"wall","2":"#) && ids.1.ends_with(r#""4":"object.4"}"#), "{}", ids.1);
}
