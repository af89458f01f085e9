//! Radiance with a closed form.
#![allow(
    clippy::disallowed_methods,
    reason = "expected values are independent of the renderer's own functions"
)]

use std::f64::consts::PI;

use super::{DirectDesc, LightSampling, PathDesc};
use crate::camera::PinholeDesc;
use crate::color::Spectrum;
use crate::description::{ObjectDesc, SceneDesc};
use crate::integrator::IntegratorDesc;
use crate::light::{AmbientDesc, Attenuation, DirectionalDesc, LightDesc, PointDesc, SpotDesc};
use crate::material::{AlphaMode, PrincipledMaterial};
use crate::math::{DAffine3, DVec3};
use crate::schema::Transform;
use crate::schema::transform::rotation;
use crate::shape::{BoxDesc, CylinderDesc, DiskDesc, PlaneDesc, ShapeDesc};
use crate::testing::scenes::{emissive, grey, matte, mean, path, plane, rectangle, rgb, scene, sphere, v};

fn plain() -> SceneDesc {
    path(PathDesc::default())
}

fn by(light_sampling: LightSampling) -> PathDesc {
    PathDesc { light_sampling, ..PathDesc::default() }
}

const STRATEGIES: [LightSampling; 3] = [LightSampling::Both, LightSampling::Bsdf, LightSampling::Light];

fn ambient() -> LightDesc {
    LightDesc::Ambient(AmbientDesc { intensity: 1.0, ..AmbientDesc::default() })
}

#[test]
fn uniform_light_shows_the_albedo() {
    for is_background in [true, false] {
        for albedo in [0.0, 0.3, 1.0] {
            let camera =
                PinholeDesc { position: v(0.0, 0.0, 4.0), fov: Some(10.0), ..PinholeDesc::default() };
            let mut desc = path(PathDesc { rr_start: Some(1000), ..PathDesc::default() })
                .seen(camera)
                .with(sphere(DVec3::ZERO, 1.0), matte(grey(albedo)));
            if is_background {
                desc.background.color = Spectrum::WHITE;
            } else {
                desc = desc.lit(ambient());
            }
            let m = mean(16, desc);
            for v in m.value() {
                assert!((v - albedo).abs() < 2e-6, "{m:?}");
            }
        }
    }
}

#[test]
fn emissive_surfaces_show_their_radiance() {
    let emission = emissive(3.0, rgb([1.0, 0.5, 0.25]));
    for shape in [
        sphere(DVec3::ZERO, 0.1),
        rectangle(DVec3::ZERO, v(1.0, 0.0, 0.0), v(0.0, 0.0, -1.0)),
        ShapeDesc::Cylinder(CylinderDesc::default()),
    ] {
        for strategy in STRATEGIES {
            let m = mean(4, path(by(strategy)).seen_down().with(shape.clone(), emission.clone()));
            m.is([3.0, 1.5, 0.75], 0.0);
        }
    }
    // The back face does not emit.
    let back = rectangle(DVec3::ZERO, v(1.0, 0.0, 0.0), v(0.0, 0.0, 1.0));
    let mut desc = path(PathDesc { max_depth: 3, ..PathDesc::default() })
        .seen_down()
        .with(back, PrincipledMaterial { double_sided: false, ..emission });
    desc.background.color = Spectrum::grey(0.125);
    mean(4, desc).is_grey(0.125, 0.0);
}

#[test]
fn delta_lights_on_a_matte_plane() {
    let lit = |light: LightDesc| {
        mean(1, plain().seen_down().with(plane(), matte(rgb([0.5, 0.25, 1.0]))).lit(light))
    };
    let expected = |e: f64| [0.5, 0.25, 1.0].map(|c| c / PI * e);
    // 60 degrees from the normal at distance 2: irradiance = intensity / 4 · cos.
    let at = v(1.732_050_807_568_877_2, 1.0, 0.0);
    let inverse_square = Attenuation { coefficients: [0.0, 0.0, 1.0] };
    let point = PointDesc { position: at, intensity: 8.0, ..PointDesc::default() };
    lit(LightDesc::Point(PointDesc { attenuation: inverse_square, ..point.clone() })).is(expected(1.0), 0.0);
    lit(LightDesc::Point(point)).is(expected(4.0), 0.0);
    lit(LightDesc::Directional(DirectionalDesc {
        from: Some(at),
        intensity: 8.0,
        ..DirectionalDesc::default()
    }))
    .is(expected(4.0), 0.0);
    lit(LightDesc::Spot(SpotDesc {
        position: at,
        intensity: 8.0,
        attenuation: inverse_square,
        ..SpotDesc::default()
    }))
    .is(expected(1.0), 0.0);
}

/// Form factor from a point to a parallel rectangle with one corner straight above it. The sides are a and b times the
/// height.
fn corner_factor(a: f64, b: f64) -> f64 {
    let part = |a: f64, b: f64| a / (1.0 + a * a).sqrt() * (b / (1.0 + a * a).sqrt()).atan();
    (part(a, b) + part(b, a)) / (2.0 * PI)
}

/// Emitters above the origin, with their form factors there (cosine-weighted solid angle over π).
fn emitters() -> Vec<(ObjectDesc, f64)> {
    let box_factor = 4.0 * corner_factor(0.5, 1.0);
    let above = v(0.0, 1.0, 0.0);
    let boxed = BoxDesc { min: Some(v(-0.5, 1.0, -1.0)), max: Some(v(0.5, 3.0, 1.0)), ..BoxDesc::default() };
    let disk = DiskDesc { center: v(0.0, 2.0, 0.0), radius: 1.5, ..DiskDesc::default() };
    let scaled = DAffine3::from_translation(v(0.0, 2.0, 0.0)) * DAffine3::from_scale(DVec3::splat(1.5));
    let rotated = DAffine3::from_translation(above)
        * DAffine3::from_mat3(rotation(DVec3::X, 90.0))
        * DAffine3::from_scale(v(-1.0, 2.0, 1.0));
    let under = |transform, shape| ObjectDesc { transform: Transform(transform), ..ObjectDesc::new(shape) };
    vec![
        (ObjectDesc::new(rectangle(above, v(1.0, 0.0, 0.0), v(0.0, 0.0, 2.0))), box_factor),
        // A rectangle larger than its distance from the floor is sampled by solid angle, a parallelogram of the same
        // area by area.
        (
            ObjectDesc::new(rectangle(above, v(8.0, 0.0, 0.0), v(0.0, 0.0, 6.0))),
            4.0 * corner_factor(4.0, 3.0),
        ),
        (ObjectDesc::new(ShapeDesc::Box(boxed)), box_factor),
        (ObjectDesc::new(ShapeDesc::Disk(disk)), 2.25 / (2.25 + 4.0)),
        (ObjectDesc::new(sphere(v(0.0, 2.0, 0.0), 1.5)), 2.25 / 4.0),
        (under(scaled, sphere(DVec3::ZERO, 1.0)), 2.25 / 4.0),
        (under(rotated, rectangle(DVec3::ZERO, v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0))), box_factor),
    ]
}

#[test]
fn emitters_above_a_matte_plane() {
    for (emitter, factor) in emitters() {
        for (strategy, cap) in STRATEGIES.into_iter().zip([0.004, 0.05, 0.01]) {
            // The camera is below all emitters, so it sees none of them.
            let desc = path(PathDesc { max_depth: 1, ..by(strategy) })
                .seen_down()
                .with(plane(), matte(grey(0.5)))
                .with_object(emitter.clone(), emissive(4.0, grey(1.0)));
            mean(256, desc).is_grey(0.5 * 4.0 * factor, cap);
        }
    }
}

#[test]
fn depth_limits_cut_a_geometric_series() {
    // Inside a sphere with emission 1 and albedo 1/2: 1 + 1/2 + 1/4 + …
    let inside = |desc: SceneDesc| {
        let camera =
            PinholeDesc { position: v(0.1, 0.0, 0.0), look_at: v(0.0, 0.0, 1.0), ..PinholeDesc::default() };
        let shell = PrincipledMaterial { emission_luminance: 1.0, ..matte(grey(0.5)) };
        mean(8, desc.seen(camera).with(sphere(DVec3::ZERO, 1.0), shell))
    };
    for depth in [0u32, 1, 2, 3, 7] {
        let all = PathDesc { rr_start: Some(1000), ..by(LightSampling::Bsdf) };
        let expected = 2.0 - 0.5f64.powi(depth as i32);
        inside(path(PathDesc { max_depth: depth, ..all.clone() })).is_grey(expected, 1e-6);
        inside(path(PathDesc { max_depth: 100, max_diffuse: Some(depth), ..all.clone() }))
            .is_grey(expected, 1e-6);
        inside(path(PathDesc { max_depth: depth, max_glossy: Some(0), max_transmission: Some(0), ..all }))
            .is_grey(expected, 1e-6);
    }
    // The direct integrator stops after the first bounce.
    let direct = DirectDesc { light_sampling: LightSampling::Bsdf, ..DirectDesc::default() };
    inside(scene(IntegratorDesc::Direct(direct))).is_grey(1.5, 1e-6);
}

#[test]
fn parallel_planes_and_russian_roulette() {
    let plane = |y: f64| ShapeDesc::Plane(PlaneDesc { point: v(0.0, y, 0.0), normal: v(0.0, -y, 0.0) });
    let material = PrincipledMaterial { emission_luminance: 1.0, ..matte(rgb([0.5, 0.9, 0.1])) };
    let camera = PinholeDesc { position: DVec3::ZERO, look_at: v(0.0, -1.0, 0.2), ..PinholeDesc::default() };
    let desc = path(PathDesc { max_depth: 1000, rr_start: Some(1), ..PathDesc::default() })
        .seen(camera)
        .with(plane(-1.0), material.clone())
        .with(plane(1.0), material);
    mean(256, desc).is([2.0, 10.0, 1.0 / 0.9], 0.02);
}

#[test]
fn partially_opaque_surfaces() {
    let sheet = |emission_luminance: f64| {
        let material = PrincipledMaterial {
            alpha_mode: AlphaMode::Blend,
            opacity: grey(0.25),
            ..emissive(emission_luminance, grey(1.0))
        };
        (rectangle(v(0.0, 0.15, 0.0), v(8.0, 0.0, 0.0), v(0.0, 0.0, 8.0)), material)
    };
    // Alpha and colour over a transparent background.
    let (shape, material) = sheet(2.0);
    let mut desc = plain().seen_down().with(shape, material);
    desc.background.transparent = true;
    let m = mean(64, desc);
    assert!((m.alpha() - 0.25).abs() < 0.003, "{m:?}");
    m.is_grey(0.5, 0.02);
    // A surface behind the sheet shows with 3/4 of its radiance and receives 3/4 of the light.
    let (shape, material) = sheet(0.0);
    let sun = DirectionalDesc { from: Some(v(0.2, 1.0, 0.0)), intensity: 2.0, ..DirectionalDesc::default() };
    let desc = path(PathDesc { max_depth: 1, ..PathDesc::default() })
        .seen_down_from(0.1)
        .lit(LightDesc::Directional(sun))
        .with(shape, material)
        .with(plane(), matte(grey(0.5)));
    let cos = 1.0 / 1.04f64.sqrt();
    mean(64, desc).is_grey(0.75 * 0.5 / PI * 2.0 * cos, 1e-6);
    // Unlit surfaces show their base colour and block light.
    let unlit = PrincipledMaterial { unlit: true, base_color: grey(0.75), ..PrincipledMaterial::default() };
    mean(1, plain().seen_down().lit(ambient()).with(plane(), unlit)).is_grey(0.75, 0.0);
}
