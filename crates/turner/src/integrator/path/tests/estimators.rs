//! The same light by different estimators.

use std::sync::Arc;

use crate::description::SceneDesc;
use crate::image::{Image, Pixels};
use crate::integrator::path::learn_environment::Sky;
use crate::integrator::{Caustics, IntegratorDesc, LightSampling, PathDesc, SharedPathsMode};
use crate::light::{EnvironmentDesc, LightDesc};
use crate::material::{AlphaMode, PrincipledMaterial};
use crate::math::DVec3;
use crate::schema::{Asset, ColorSource, ImageId, MeshData, PrepareOptions, TextureId};
use crate::shape::{PlaneDesc, ShapeDesc};
use crate::testing::scenes::{
    Mean, cuboid, emissive, grey, matte, mean_of, path, plane, rectangle, rgb, sphere, v,
};
use crate::texture::{CheckerboardDesc, TextureDesc};

fn metal(base_color: ColorSource, roughness: f64) -> PrincipledMaterial {
    PrincipledMaterial {
        base_color,
        base_metalness: grey(1.0),
        specular_roughness: grey(roughness),
        ..PrincipledMaterial::default()
    }
}

/// A floor, a wall, a metal ball and three lights.
fn room(desc: PathDesc) -> SceneDesc {
    let wall = || PrincipledMaterial { base_color: rgb([0.7, 0.6, 0.5]), ..PrincipledMaterial::default() };
    let lamp = || emissive(5.0, grey(1.0));
    let back = PlaneDesc { point: v(0.0, 0.0, -2.0), normal: DVec3::Z };
    path(desc)
        .seen_at(v(0.0, 1.0, 3.4), v(0.0, 0.9, 0.0), 45.0)
        .with(plane(), wall())
        .with(ShapeDesc::Plane(back), wall())
        .with(sphere(v(0.5, 0.6, 0.0), 0.6), metal(rgb([0.9, 0.6, 0.2]), 0.4))
        .with(rectangle(v(-0.5, 2.0, 0.0), v(1.0, 0.0, 0.0), v(0.0, 0.0, 1.0)), lamp())
        .with(sphere(v(-0.9, 0.4, 0.6), 0.25), lamp())
        .with(cuboid(v(1.2, 0.0, 0.6), v(1.4, 0.3, 0.8)), lamp())
}

fn estimate(samples: u32, desc: SceneDesc) -> Mean {
    mean_of(24, samples, desc)
}

#[test]
fn with_and_without_light_sampling() {
    let by = |light_sampling| room(PathDesc { max_depth: 4, light_sampling, ..PathDesc::default() });
    let both = estimate(16, by(LightSampling::Both));
    let bsdf = estimate(128, by(LightSampling::Bsdf));
    let light = estimate(16, by(LightSampling::Light));
    both.agrees(&bsdf, 0.02);
    both.agrees(&light, 0.03);
}

/// Light resampling on rough mirrors: flat ones that are shaded in SIMD blocks, and round ones.
#[test]
fn resampled_lights_keep_the_mean() {
    let with = |samples, light_sampling| {
        let caustics = Caustics::Off;
        let mut desc = path(PathDesc { max_depth: 3, caustics, light_sampling, ..PathDesc::default() })
            .seen_at(v(0.0, 2.0, 5.0), v(0.0, 0.2, 1.0), 32.0)
            .lit(LightDesc::Environment(EnvironmentDesc::studio()));
        for (x, roughness) in [(-1.5, 0.15), (-0.5, 0.3), (0.5, 0.45)] {
            let plate = desc.mesh(MeshData {
                positions: vec![[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x + 1.0, 0.0, 2.0], [x, 0.0, 2.0]],
                triangles: vec![[0, 2, 1], [0, 3, 2]],
                ..MeshData::default()
            });
            desc = desc.with(plate, metal(rgb([0.9, 0.8, 0.5]), roughness));
        }
        // With an occluder for some of the light.
        let desc = desc
            .with(sphere(v(-1.0, 0.8, -1.0), 0.1), emissive(40.0, grey(1.0)))
            .with(sphere(v(0.0, 0.9, -1.0), 0.3), emissive(10.0, grey(1.0)))
            .with(sphere(v(1.2, 1.0, -1.0), 0.6), emissive(4.0, grey(1.0)))
            .with(sphere(v(0.2, 0.3, 1.6), 0.3), metal(grey(0.8), 0.25))
            .with(cuboid(v(-0.3, 0.3, -0.4), v(-0.1, 2.0, -0.2)), matte(grey(0.8)));
        estimate(samples, desc)
    };
    let (both, bsdf) = (with(32, LightSampling::Both), with(256, LightSampling::Bsdf));
    both.agrees(&bsdf, 0.01);
    both.agrees(&with(64, LightSampling::Light), 0.02);
}

#[test]
fn environments_sampled_and_hit() {
    let by = |samples, light_sampling| {
        let around =
            EnvironmentDesc { rotation: 40.0, tint: [1.0, 0.8, 0.6].into(), ..EnvironmentDesc::studio() };
        let room = room(PathDesc { max_depth: 3, light_sampling, ..PathDesc::default() });
        estimate(samples, room.lit(LightDesc::Environment(around)))
    };
    let both = by(16, LightSampling::Both);
    both.agrees(&by(64, LightSampling::Bsdf), 0.02);
    both.agrees(&by(64, LightSampling::Light), 0.03);
}

#[test]
fn russian_roulette_changes_no_mean() {
    let starting = |rr_start| room(PathDesc { rr_start: Some(rr_start), ..PathDesc::default() });
    estimate(16, starting(1000)).agrees(&estimate(32, starting(1)), 0.02);
}

#[test]
fn a_clamp_removes_indirect_light_only() {
    let clamped = |max_depth, clamp_indirect| {
        estimate(4, room(PathDesc { max_depth, clamp_indirect, ..PathDesc::default() }))
    };
    let (without, with) = (clamped(16, 0.0), clamped(16, 0.1));
    assert!(with.value()[0] < 0.98 * without.value()[0], "{with:?} {without:?}");
    assert_eq!(clamped(1, 0.0).value(), clamped(1, 0.1).value());
}

/// A closed room with a window, through which the sky lights it.
pub(super) fn windowed_room(desc: PathDesc) -> SceneDesc {
    let wall = |a, b| (cuboid(a, b), matte(grey(0.6)));
    let walls = [
        wall(v(-2.1, -0.1, -2.1), v(2.1, 0.0, 2.1)),
        wall(v(-2.1, 2.0, -2.1), v(2.1, 2.1, 2.1)),
        wall(v(-2.1, 0.0, -2.1), v(2.1, 2.0, -2.0)),
        wall(v(-2.1, 0.0, 2.0), v(2.1, 2.0, 2.1)),
        wall(v(2.0, 0.0, -2.0), v(2.1, 2.0, 2.0)),
        // The wall with the window.
        wall(v(-2.1, 0.0, -2.0), v(-2.0, 0.8, 2.0)),
        wall(v(-2.1, 1.6, -2.0), v(-2.0, 2.0, 2.0)),
        wall(v(-2.1, 0.8, -2.0), v(-2.0, 1.6, -0.4)),
        wall(v(-2.1, 0.8, 0.3), v(-2.0, 1.6, 2.0)),
    ];
    let sky = EnvironmentDesc { rotation: 160.0, ..EnvironmentDesc::studio() };
    let plastic = PrincipledMaterial { base_color: rgb([0.7, 0.3, 0.2]), ..PrincipledMaterial::default() };
    let room = path(desc)
        .seen_at(v(0.5, 1.0, 1.8), v(-0.3, 0.7, 0.0), 60.0)
        .lit(LightDesc::Environment(sky))
        .with(sphere(v(-0.5, 0.5, -0.8), 0.5), plastic)
        .with(sphere(v(0.6, 0.3, -0.2), 0.3), metal(rgb([0.9, 0.6, 0.2]), 0.2));
    walls.into_iter().fold(room, |room, (shape, material)| room.with(shape, material))
}

#[test]
fn adaptive_sampling_of_the_sky_keeps_the_mean() {
    let by = |samples, light_sampling, shared_paths| {
        let caustics = Caustics::Off;
        let desc = PathDesc { max_depth: 3, caustics, light_sampling, shared_paths, ..PathDesc::default() };
        estimate(samples, windowed_room(desc))
    };
    let both = by(32, LightSampling::Both, SharedPathsMode::Off);
    both.agrees(&by(512, LightSampling::Bsdf, SharedPathsMode::Off), 0.02);
    both.agrees(&by(64, LightSampling::Light, SharedPathsMode::Off), 0.02);
    both.agrees(&by(32, LightSampling::Both, SharedPathsMode::Always), 0.02);
}

/// Light paths weigh the densities of adaptive sampling.
#[test]
fn adaptive_sampling_beside_light_paths() {
    let by = |samples, caustics, light_sampling| {
        let desc = PathDesc { max_depth: 4, caustics, light_sampling, ..PathDesc::default() };
        let glass = PrincipledMaterial {
            transmission_weight: grey(1.0),
            specular_roughness: grey(0.1),
            ..PrincipledMaterial::default()
        };
        estimate(samples, windowed_room(desc).with(sphere(v(-1.3, 0.4, 0.3), 0.4), glass))
    };
    let light_paths = by(64, Caustics::LightTracing, LightSampling::Both);
    light_paths.agrees(&by(512, Caustics::Off, LightSampling::Bsdf), 0.03);
}

#[test]
fn adaptive_sampling_is_chosen_for_rooms() {
    let chosen = |desc: &SceneDesc| {
        let prepared = desc.prepare(&PrepareOptions::default()).unwrap();
        prepared.choose(0);
        prepared.path().and_then(|path| path.choice.get()).is_some_and(|choice| choice.adaptive.is_some())
    };
    assert!(chosen(&windowed_room(PathDesc::default())));
    let bsdf = PathDesc { light_sampling: LightSampling::Bsdf, ..PathDesc::default() };
    assert!(!chosen(&windowed_room(bsdf)));
    let sky = LightDesc::Environment(EnvironmentDesc::studio());
    let ball = path(PathDesc::default()).with(sphere(DVec3::ZERO, 1.0), matte(grey(0.5)));
    assert!(!chosen(&ball.lit(sky)));
}

/// Emission of surfaces that are partly or completely cut out or transparent, seen and found by every strategy; the
/// texture's squares are smaller than the footprints of reflected rays.
#[test]
fn transparent_lamps_by_every_strategy() {
    let half =
        CheckerboardDesc { even: grey(1.0), odd: grey(0.0), density: 8.0, ..CheckerboardDesc::default() };
    let by = |luminance, alpha_mode, opacity: Option<f64>, light_sampling| {
        let opacity = opacity.map_or(ColorSource::Texture(TextureId(0)), grey);
        let lamp = PrincipledMaterial { alpha_mode, opacity, ..emissive(luminance, grey(1.0)) };
        let desc = PathDesc { max_depth: 1, light_sampling, ..PathDesc::default() };
        let scene = path(desc)
            .seen_at(v(0.0, 3.0, 6.0), v(0.0, 0.0, 0.0), 20.0)
            .with(plane(), matte(grey(0.6)))
            .with(rectangle(v(-1.0, 2.0, -1.0), v(2.0, 0.0, 0.0), v(0.0, 0.0, 2.0)), lamp);
        SceneDesc { textures: vec![TextureDesc::Checkerboard(half.clone()).into()], ..scene }
    };
    for (alpha_mode, opacity, expected) in [
        (AlphaMode::Mask, Some(0.0), 0.0),
        (AlphaMode::Mask, Some(0.6), 1.0),
        (AlphaMode::Mask, None, 0.5),
        (AlphaMode::Blend, Some(0.25), 0.25),
        (AlphaMode::Blend, None, 0.5),
    ] {
        for light_sampling in [LightSampling::Both, LightSampling::Bsdf, LightSampling::Light] {
            let found = estimate(128, by(5.0, alpha_mode, opacity, light_sampling));
            if expected == 0.0 {
                found.is_grey(0.0, 0.0);
            } else {
                let opaque = by(5.0 * expected, AlphaMode::Opaque, Some(1.0), LightSampling::Light);
                found.agrees(&estimate(128, opaque), 0.02);
            }
        }
    }
}

/// A scene with the picture of a uniform sky, and that sky.
pub(super) fn uniform_sky(desc: SceneDesc) -> (SceneDesc, LightDesc) {
    let pixels = Pixels::F32([0.8, 0.9, 1.0].repeat(8));
    let data = Arc::new(Image { width: 4, height: 2, channels: 3, pixels });
    let mut images = desc.images.clone();
    images.push(Asset { uri: "sky.exr".into(), data });
    let file = Some(ImageId(images.len() as u32 - 1));
    let sky = LightDesc::Environment(EnvironmentDesc { file, ..EnvironmentDesc::studio() });
    (SceneDesc { images, ..desc }, sky)
}

/// Under a uniform sky light samples follow the cosine, at the first surface alone: the mean is that of light samples at all.
#[test]
fn uniform_skies_are_sampled_by_the_cosine() {
    let scene = |light_sampling, light_samples| {
        let caustics = Caustics::Off;
        let settings =
            PathDesc { max_depth: 4, caustics, light_sampling, light_samples, ..PathDesc::default() };
        let plastic = PrincipledMaterial { base_color: grey(0.3), ..PrincipledMaterial::default() };
        let pane = PrincipledMaterial { transmission_weight: grey(1.0), ..PrincipledMaterial::default() };
        let desc = path(settings)
            .seen_at(v(0.0, 1.5, 4.0), v(0.0, 0.5, 0.0), 45.0)
            .with(plane(), matte(grey(0.5)))
            .with(sphere(v(0.0, 0.6, 0.0), 0.6), metal(grey(0.9), 0.3))
            .with(sphere(v(-1.2, 0.5, 0.0), 0.5), plastic)
            .with(sphere(v(1.2, 0.5, 0.0), 0.5), pane);
        let (desc, sky) = uniform_sky(desc);
        desc.lit(sky)
    };
    let chosen = |desc: &SceneDesc| {
        let prepared = desc.prepare(&PrepareOptions::default()).unwrap();
        prepared.choose(0);
        let path = prepared.path().unwrap();
        let start = path.context(&prepared.scene, &prepared.view).settings.rr_start;
        (path.choice.get().unwrap().sky, start)
    };
    let both = scene(LightSampling::Both, None);
    assert_eq!(chosen(&both), (Sky::Uniform, 5));
    let mut lit = both.clone().with(sphere(v(2.0, 2.0, 0.0), 0.1), emissive(5.0, grey(1.0)));
    assert_eq!(chosen(&lit), (Sky::Open, 5));
    // What is asked for stays.
    let IntegratorDesc::Path(settings) = &mut lit.integrator else { panic!() };
    settings.rr_start = Some(3);
    assert_eq!(chosen(&lit), (Sky::Open, 3));
    // Under a lid little arrives.
    let lid = rectangle(v(0.0, 2.0, 0.0), DVec3::X * 60.0, DVec3::Z * 60.0);
    assert_eq!(chosen(&both.clone().with(lid, matte(grey(0.5)))), (Sky::Closed, 3));
    let expected = estimate(256, scene(LightSampling::Light, None));
    for light_samples in [None, Some(1), Some(4)] {
        estimate(64, scene(LightSampling::Both, light_samples)).agrees(&expected, 0.01);
    }
}
