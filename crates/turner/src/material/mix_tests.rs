//! Mixes of materials: weighted sums of their parts.

use super::{ClassicMaterial, MaterialDesc, MixMaterial, PrincipledMaterial};
use crate::camera::{CameraDesc, OrthographicDesc, PinholeDesc, Viewport};
use crate::description::{ObjectDesc, SceneDesc};
use crate::film::FilmDesc;
use crate::integrator::{LightSampling, PathDesc};
use crate::light::{LightDesc, PointDesc};
use crate::math::{DVec2, DVec3};
use crate::schema::{ColorSource, MaterialId};
use crate::shape::{DiskDesc, ShapeDesc};
use crate::testing::scenes::{
    Mean, emissive, grey, matte, mean, path, pixel, plane, rectangle, render, rgb, sphere, v,
};
use crate::texture::{GradientDesc, Stop, TextureDesc};

/// A mix of the scene's materials with these ids.
fn mix(materials: &[u32], weights: Vec<ColorSource>) -> MaterialDesc {
    MaterialDesc::Mix(MixMaterial { materials: materials.iter().map(|m| MaterialId(*m)).collect(), weights })
}

fn numbers(weights: &[f64]) -> Vec<ColorSource> {
    weights.iter().map(|w| grey(*w)).collect()
}

/// These materials, followed by their mix.
fn mixed<const N: usize>(parts: [PrincipledMaterial; N], weights: Vec<ColorSource>) -> Vec<MaterialDesc> {
    let all: Vec<u32> = (0..N as u32).collect();
    parts.into_iter().map(MaterialDesc::Principled).chain([mix(&all, weights)]).collect()
}

/// A scene with a shape of the last of these materials.
fn of_last(mut desc: SceneDesc, materials: Vec<MaterialDesc>, shape: ShapeDesc) -> SceneDesc {
    let ids: Vec<MaterialId> = materials.into_iter().map(|m| desc.material(m)).collect();
    desc.with_shared(shape, ids[ids.len() - 1])
}

fn ball() -> ShapeDesc {
    sphere(DVec3::ZERO, 1.0)
}

/// A sphere of the last of these materials in a uniform environment.
fn furnace(samples: u32, materials: Vec<MaterialDesc>) -> Mean {
    let desc =
        path(PathDesc { rr_start: Some(1000), ..PathDesc::default() }).seen_from_front(4.0, 10.0).before(1.0);
    mean(samples, of_last(desc, materials, ball()))
}

fn dark() -> MaterialDesc {
    MaterialDesc::Principled(matte(grey(0.2)))
}

fn light() -> MaterialDesc {
    MaterialDesc::Principled(matte(rgb([0.8, 0.6, 0.4])))
}

#[test]
fn weights_of_two_of_three_and_of_mixes() {
    let weighted = |materials: &[u32], weights: &[f64]| {
        furnace(256, vec![dark(), light(), mix(materials, numbers(weights))])
    };
    let blend = |light: f64| [0.8, 0.6, 0.4].map(|c| 0.2 + (c - 0.2) * light);
    weighted(&[0, 1], &[]).is(blend(0.5), 0.01);
    weighted(&[0, 1], &[0.25]).is(blend(0.25), 0.01);
    weighted(&[0, 1], &[1.0, 3.0]).is(blend(0.75), 0.01);
    weighted(&[0, 1, 0], &[0.3, 0.3]).is(blend(0.3), 0.01);
    // Weights that sum to more than 1 leave nothing for the first.
    weighted(&[0, 1, 0], &[3.0, 1.0]).is(blend(0.75), 0.01);
    weighted(&[0, 1], &[0.0, 0.0]).is(blend(0.0), 0.01);
    let half = |other| mix(&[0, other], numbers(&[0.5]));
    furnace(256, vec![dark(), light(), half(1), half(2)]).is(blend(0.25), 0.01);
}

#[test]
fn nothing_is_lost_in_a_furnace() {
    let mirror = PrincipledMaterial {
        specular_roughness: grey(0.0),
        base_metalness: grey(1.0),
        base_color: grey(1.0),
        ..PrincipledMaterial::default()
    };
    furnace(64, mixed([matte(grey(1.0)), mirror], numbers(&[0.6]))).is_grey(1.0, 0.001);
}

#[test]
fn a_textured_weight_shows_its_texture() {
    let mut desc = path(PathDesc::default()).filmed([2, 1], 4);
    let camera = OrthographicDesc {
        position: v(0.0, 0.0, 4.0),
        viewport: Viewport::Size(DVec2::new(2.0, 1.0)),
        ..OrthographicDesc::default()
    };
    desc.camera = Some(CameraDesc::Orthographic(camera).into());
    let stops = vec![Stop { at: 0.499, color: grey(0.0) }, Stop { at: 0.501, color: grey(1.0) }];
    let step = desc.texture(TextureDesc::Gradient(GradientDesc { stops, ..GradientDesc::default() }));
    let materials = mixed([[1.0, 0.0, 0.0], [0.0, 0.0, 2.0]].map(|c| emissive(1.0, rgb(c))), vec![step]);
    let square = rectangle(DVec3::ZERO, v(2.0, 0.0, 0.0), v(0.0, 2.0, 0.0));
    let picture = render(&of_last(desc, materials, square)).0;
    let both = [pixel(&picture, 0, 0), pixel(&picture, 1, 0)];
    assert!(both.contains(&[1.0, 0.0, 0.0]) && both.contains(&[0.0, 0.0, 2.0]), "{both:?}");
}

/// An emitter of weight 0.25 with holes of weight 0.5. The emitter is the first material.
fn emitter_with_holes() -> Vec<MaterialDesc> {
    let hole = PrincipledMaterial { opacity: grey(0.0), ..PrincipledMaterial::default() };
    mixed([emissive(4.0, grey(1.0)), matte(grey(0.0)), hole], numbers(&[1.0, 1.0, 2.0]))
}

fn disk(height: f64, normal: DVec3) -> ShapeDesc {
    ShapeDesc::Disk(DiskDesc { center: v(0.0, height, 0.0), normal, ..DiskDesc::default() })
}

#[test]
fn emission_and_holes_are_weighted() {
    // A quarter of the emission 4, and half of the background.
    let before = path(PathDesc::default()).before(0.5).seen_from_front(4.0, 1.0);
    let square = rectangle(DVec3::ZERO, v(2.0, 0.0, 0.0), v(0.0, 2.0, 0.0));
    mean(256, of_last(before, emitter_with_holes(), square)).is_grey(1.25, 0.01);
    // Lit by it, and through it: light sampling and BSDF sampling agree with the formula of a disk above a point.
    for light_sampling in [LightSampling::Both, LightSampling::Bsdf, LightSampling::Light] {
        let below = SceneDesc {
            materials: emitter_with_holes().into_iter().map(Into::into).collect(),
            ..path(PathDesc { max_depth: 1, light_sampling, ..PathDesc::default() })
        };
        let lit = below
            .seen_down()
            .with(plane(), matte(grey(0.5)))
            .with_shared(disk(1.0, DVec3::Y), MaterialId(3))
            .with_shared(disk(2.0, DVec3::Y), MaterialId(0));
        // Half of the upper disk is visible through the lower one, and nothing beyond its rim.
        mean(256, lit).is_grey(0.5 * (0.25 * 4.0 * 0.5 + 0.5 * 4.0 * 0.2), 0.03);
    }
}

#[test]
fn one_sided_parts_pass_rays_from_behind() {
    let seen = |normal: f64| {
        let desc = path(PathDesc::default()).before(0.25).seen_from_front(4.0, 1.0);
        let unlit = PrincipledMaterial {
            unlit: true,
            base_color: grey(0.75),
            double_sided: false,
            ..PrincipledMaterial::default()
        };
        let materials = mixed([unlit, emissive(1.0, grey(1.0))], Vec::new());
        mean(256, of_last(desc, materials, disk(0.0, v(0.0, 0.0, normal))))
    };
    seen(1.0).is_grey(0.5 * (0.75 + 1.0), 0.01);
    seen(-1.0).is_grey(0.5 * (0.25 + 1.0), 0.02);
}

#[test]
fn glass_in_a_mix_absorbs_inside() {
    // One half is a film without effect, the other glass without contrast that absorbs.
    let glass = PrincipledMaterial {
        transmission_weight: grey(1.0),
        specular_ior: 1.0,
        specular_roughness: grey(0.0),
        transmission_color: grey(0.25),
        transmission_depth: 2.0,
        ..PrincipledMaterial::default()
    };
    let materials = mixed([glass, matte(grey(0.8))], numbers(&[0.0]));
    let desc =
        path(PathDesc { max_depth: 50, ..PathDesc::default() }).before(1.0).seen_from_front(4.0, 0.001);
    mean(16, of_last(desc, materials, ball())).is_grey(0.25, 0.001);
}

#[test]
fn the_classic_integrator_shows_the_mean() {
    let classic = |c| MaterialDesc::Classic(ClassicMaterial { color: rgb(c), ..ClassicMaterial::default() });
    let shown = |materials| {
        let desc = SceneDesc {
            film: FilmDesc { width: 8, height: 8, ..FilmDesc::default() },
            ..SceneDesc::default()
        };
        let camera = PinholeDesc { position: v(0.0, 0.0, 4.0), ..PinholeDesc::default() };
        let point = PointDesc { position: v(2.0, 3.0, 4.0), ..PointDesc::default() };
        render(&of_last(desc.seen(camera).lit(LightDesc::Point(point)), materials, ball())).0
    };
    let (red, blue) = (classic([1.0, 0.0, 0.0]), classic([0.0, 0.0, 1.0]));
    let both = shown(vec![red, blue, mix(&[0, 1], numbers(&[0.25]))]);
    let mean = shown(vec![classic([0.75, 0.0, 0.25])]);
    for (a, b) in both.linear.iter().zip(&mean.linear) {
        for i in 0..4 {
            assert!((a[i] - b[i]).abs() < 1e-6, "{a:?} {b:?}");
        }
    }
}

#[test]
fn invalid_mixes_are_refused() {
    let refused = |materials: Vec<MaterialDesc>| {
        let mut desc = path(PathDesc::default());
        desc.materials = materials.into_iter().map(Into::into).collect();
        desc.objects.push(ObjectDesc::default());
        desc.prepare(&Default::default()).expect_err("refused").to_string()
    };
    let plain = || MaterialDesc::default();
    let own = refused(vec![mix(&[0, 0], Vec::new())]);
    assert!(own.contains("contains itself"), "{own}");
    let few = refused(vec![plain(), mix(&[0], Vec::new())]);
    assert!(few.contains("two materials"), "{few}");
    let many = refused(vec![plain(), plain(), mix(&[0, 1], numbers(&[1.0, 2.0, 3.0]))]);
    assert!(many.contains("expected 1 or 2 weights"), "{many}");
}
