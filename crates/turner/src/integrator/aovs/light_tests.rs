//! Light groups, cost and variance by formula.

use super::tests::Rendered;
use crate::camera::{LensBrightness, RealisticDesc};
use crate::description::{ObjectDesc, SceneDesc, SceneLight};
use crate::film::Aov;
use crate::integrator::{Caustics, DirectDesc, IntegratorDesc, PathDesc, SharedPathsMode};
use crate::light::{BackgroundDesc, EnvironmentDesc, LightDesc};
use crate::material::{DielectricMaterial, PrincipledMaterial};
use crate::medium::HomogeneousMedium;
use crate::testing::scenes::{
    cuboid, emissive, even, grey, lamp, matte, path, plane, rectangle, render, rgb, sphere, v,
};

/// The groups of the scene below, and of light in none.
const LAYERS: [&str; 5] = ["key", "sky", "sign", "fill light", "default"];

/// A scene with lights in four groups, and one light in none. Only light of the groups in `lit` is on.
fn groups(integrator: IntegratorDesc, lit: &[&str]) -> SceneDesc {
    let on = |group: &str, value: f64| if lit.contains(&group) { value } else { 0.0 };
    let mut desc = SceneDesc { integrator, ..SceneDesc::default() }
        .with(plane(), matte(rgb([0.6, 0.5, 0.4])))
        .with(
            rectangle(v(0.0, 1.0, -1.5), v(5.0, 0.0, 0.0), v(0.0, 4.0, 0.0)),
            PrincipledMaterial { base_color: grey(0.7), ..PrincipledMaterial::default() },
        )
        .with(sphere(v(-0.5, 0.5, 0.0), 0.5), DielectricMaterial::default())
        .seen_at(v(0.0, 1.2, 4.0), v(0.0, 0.6, 0.0), 45.0)
        .filmed([24, 16], 64);
    let sky = EnvironmentDesc { strength: on("sky", 0.2), ..EnvironmentDesc::studio() };
    for (group, light) in [
        (Some("key"), lamp(v(2.0, 2.5, 2.0), on("key", 6.0))),
        (Some("sky"), LightDesc::Environment(sky)),
        (None, lamp(v(-2.0, 2.0, 1.0), on("default", 3.0))),
    ] {
        desc.lights.push(SceneLight { group: group.map(str::to_owned), ..SceneLight::from(light) });
    }
    for (group, shape, luminance) in [
        ("sign", sphere(v(0.8, 0.3, 0.4), 0.25), 4.0),
        ("fill light", rectangle(v(-1.5, 1.0, 1.0), v(0.0, 0.0, 0.6), v(0.0, 0.8, 0.0)), 2.0),
        ("key", sphere(v(0.0, 1.7, -0.5), 0.15), 3.0),
    ] {
        let object = ObjectDesc { light_group: Some(group.to_owned()), ..ObjectDesc::new(shape) };
        desc = desc.with_object(object, emissive(on(group, luminance), rgb([1.0, 0.8, 0.6])));
    }
    desc
}

fn layer(r: &Rendered, layer: &str, band: &str) -> Vec<f64> {
    r.channel(&format!("light.{layer}.{band}"))
}

/// What one layer and all layers must be, for each way in which light is added.
#[test]
fn layers_of_light_groups_add_up() {
    let path = |desc: PathDesc| IntegratorDesc::Path(PathDesc { max_depth: 6, ..desc });
    let off = PathDesc { caustics: Caustics::Off, ..PathDesc::default() };
    for integrator in [
        path(off.clone()),
        path(PathDesc { shared_paths: SharedPathsMode::Always, ..off.clone() }),
        path(PathDesc { clamp_indirect: 0.3, ..off }),
        path(PathDesc { caustics: Caustics::LightTracing, ..PathDesc::default() }),
        path(PathDesc { caustics: Caustics::Full, ..PathDesc::default() }),
        IntegratorDesc::Direct(DirectDesc::default()),
    ] {
        let mut desc = groups(integrator.clone(), &LAYERS);
        (desc.film.samples, desc.film.clamp_sample) = (8, 3.0);
        for fog in [false, true] {
            if fog {
                let smoke = HomogeneousMedium { scattering: even(0.1), ..HomogeneousMedium::default() };
                desc = desc.filled(cuboid(v(-3.0, 0.01, -1.4), v(3.0, 2.4, 2.2)), smoke);
            }
            let r = Rendered::of(&desc, &[Aov::LightGroups, Aov::Caustics]);
            for (i, band) in ["R", "G", "B"].iter().enumerate() {
                let caustics = r.channel(&format!("caustics.{band}"));
                let layers = LAYERS.map(|name| layer(&r, name, band));
                for (pixel, linear) in r.picture.linear.iter().enumerate() {
                    let sum: f64 = caustics[pixel] + layers.iter().map(|l| l[pixel]).sum::<f64>();
                    let exact = f64::from(linear[i]);
                    assert!((sum - exact).abs() < 2e-5, "{integrator:?} {fog} {pixel}: {sum} {exact}");
                    assert!(layers.iter().all(|l| l[pixel] > -2e-5), "{integrator:?} {fog} {pixel}");
                }
                for (name, layer) in LAYERS.iter().zip(&layers) {
                    assert!(layer.iter().sum::<f64>() > 1.0, "{integrator:?} {fog} {name}");
                }
            }
        }
    }
}

/// A lens darkens the parts of the light like the picture.
#[test]
fn a_lens_darkens_all_layers_alike() {
    let off = PathDesc { caustics: Caustics::Off, max_depth: 6, ..PathDesc::default() };
    let camera = RealisticDesc {
        position: v(0.0, 1.2, 4.0),
        look_at: v(0.0, 0.6, 0.0),
        brightness: LensBrightness::Absolute,
        ..RealisticDesc::default()
    };
    let mut desc = groups(IntegratorDesc::Path(off), &LAYERS).seen(camera);
    (desc.film.samples, desc.film.clamp_sample) = (8, 0.5);
    let parts = ["emission", "direct", "indirect"];
    let r = Rendered::of(&desc, &[Aov::LightGroups, Aov::Emission, Aov::Direct, Aov::Indirect]);
    for (i, band) in ["R", "G", "B"].iter().enumerate() {
        let of_groups = LAYERS.map(|name| layer(&r, name, band));
        let of_parts = parts.map(|part| r.channel(&format!("{part}.{band}")));
        for (pixel, linear) in r.picture.linear.iter().enumerate() {
            let exact = f64::from(linear[i]);
            let [groups, parts] =
                [&of_groups[..], &of_parts[..]].map(|all| all.iter().map(|l| l[pixel]).sum::<f64>());
            assert!(
                (groups - exact).abs() < 1e-5 && (parts - exact).abs() < 1e-5,
                "{groups} {parts} {exact}"
            );
        }
        assert!(of_parts.iter().all(|part| part.iter().sum::<f64>() > 0.1));
    }
}

/// Each layer is the picture with the lights of its group alone, up to noise.
#[test]
fn a_layer_is_the_picture_of_its_lights() {
    for desc in [
        PathDesc { caustics: Caustics::Off, ..PathDesc::default() },
        PathDesc { caustics: Caustics::Off, shared_paths: SharedPathsMode::Always, ..PathDesc::default() },
        PathDesc { caustics: Caustics::Full, ..PathDesc::default() },
    ] {
        let integrator = IntegratorDesc::Path(PathDesc { max_depth: 6, ..desc });
        let all = Rendered::of(&groups(integrator.clone(), &LAYERS), &[Aov::LightGroups, Aov::Caustics]);
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let mut splatted = mean(&all.channel("caustics.G"));
        for name in LAYERS {
            let alone = Rendered::of(&groups(integrator.clone(), &[name]), &[Aov::Caustics]);
            let own = mean(&alone.channel("caustics.G"));
            splatted -= own;
            let green: Vec<f64> = alone.picture.linear.iter().map(|p| f64::from(p[1])).collect();
            let (found, expected) = (mean(&layer(&all, name, "G")), mean(&green) - own);
            assert!((found / expected - 1.0).abs() < 0.04, "{integrator:?} {name}: {found} {expected}");
        }
        assert!(splatted.abs() < 0.01, "{integrator:?} {splatted}");
    }
}

#[test]
fn a_scene_without_groups_has_one_layer() {
    let mut desc = path(PathDesc::default())
        .with(plane(), matte(grey(0.5)))
        .lit(lamp(v(0.0, 2.0, 0.0), 3.0))
        .seen_at(v(0.0, 1.0, 4.0), v(0.0, 0.0, 0.0), 40.0)
        .filmed([8, 6], 4);
    // A group of the name is the same layer.
    for named in [false, true] {
        desc.lights[0].group = named.then(|| "default".to_owned());
        let r = Rendered::of(&desc, &[Aov::LightGroups]);
        let names: Vec<String> = r.renderer.develop_aovs(2).into_iter().map(|c| c.name).collect();
        assert_eq!(names, ["light.default.R", "light.default.G", "light.default.B"]);
        let colors = r.picture.linear.iter().map(|p| f64::from(p[2]));
        assert!(layer(&r, "default", "B").into_iter().eq(colors));
    }
}

/// A wall in the left half of the picture, before a transparent background.
fn half(max_depth: u32) -> SceneDesc {
    let wall = rectangle(v(-5.0, 0.0, 0.0), v(10.25, 0.0, 0.0), v(0.0, 20.0, 0.0));
    let mut desc = path(PathDesc { max_depth, caustics: Caustics::Off, ..PathDesc::default() })
        .with(wall, matte(grey(0.5)))
        .lit(lamp(v(0.0, 0.0, 3.0), 20.0))
        .seen_from_front(5.0, 60.0)
        .filmed([16, 12], 16);
    desc.background = BackgroundDesc { transparent: true, ..desc.background };
    desc
}

#[test]
fn cost_is_the_number_of_rays() {
    // The camera ray, the shadow ray, and the ray that looks for emitters.
    let r = Rendered::of(&half(1), &[Aov::Cost]);
    r.is("cost", 2, 4, 3.0);
    r.is("cost", 14, 4, 1.0);
    let r = Rendered::of(&half(0), &[Aov::Cost]);
    r.is("cost", 2, 4, 1.0);
    // All rays of a pass: those that no Russian roulette ends are counted where they are sampled.
    let mut desc =
        groups(IntegratorDesc::Path(PathDesc { rr_start: Some(100), ..PathDesc::default() }), &LAYERS);
    for shared_paths in [SharedPathsMode::Off, SharedPathsMode::Always] {
        desc.integrator = IntegratorDesc::Path(PathDesc {
            max_depth: 4,
            rr_start: Some(100),
            shared_paths,
            caustics: Caustics::Off,
            ..PathDesc::default()
        });
        let r = Rendered::of(&desc, &[Aov::Cost]);
        let rays: f64 = r.channel("cost").iter().sum::<f64>() * f64::from(desc.film.samples);
        let counted = render(&desc).1.total() as f64;
        assert!((rays / counted - 1.0).abs() < 1e-3, "{shared_paths:?} {rays} {counted}");
    }
}

/// A pixel that an emitter covers in part has the variance of a Bernoulli distribution.
#[test]
fn variance_is_that_of_independent_samples() {
    let mut desc = half(0);
    desc.lights.clear();
    desc.materials[0].value = emissive(1.0, grey(1.0)).into();
    let r = Rendered::of(&desc, &[Aov::Variance]);
    for (x, is_edge) in [(2, false), (8, true), (14, false)] {
        let covered = f64::from(r.picture.linear[4 * 16 + x][3]);
        assert_eq!(covered > 0.0 && covered < 1.0, is_edge, "{x}");
        r.is("variance", x, 4, covered * (1.0 - covered) / 15.0);
    }
}
