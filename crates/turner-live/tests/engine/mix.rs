//! Light groups: a mix of the film's channels is what lights of other strengths give.

use std::sync::Arc;

use turner::SceneDesc;
use turner::light::LightDesc;
use turner_live::engine::{Engine, Layers, Look, Order};

use super::common::*;

/// Two lamps that the camera sees and that light nothing: each pixel is light of one group, and certain.
const LAMPS: &str = r#"
[film]
width = 48
height = 32
samples = 4

[camera]
position = [0, 0, 6]
look_at = [0, 0, 0]

[integrator]
type = "path"

[[object]]
type = "sphere"
center = [-1, 0, 0]
light_group = "left"
material = { type = "principled", base_weight = 0, specular_weight = 0, emission_color = [1, 0.8, 0.5], emission_luminance = 0.5 }

[[object]]
type = "sphere"
center = [1, 0, 0]
light_group = "right"
material = { type = "principled", base_weight = 0, specular_weight = 0, emission_color = [0.3, 0.8, 1], emission_luminance = 0.25 }
"#;

fn mixed(engine: &Engine, desc: &Arc<SceneDesc>, mix: &[(&str, f32)]) -> Vec<[f32; 4]> {
    let mix = mix.iter().map(|(name, factor)| ((*name).to_owned(), *factor)).collect();
    let look = Look { mix, layers: Layers::Groups, ..Look::default() };
    let number = engine.order(Order { look, ..order(desc) });
    settled(engine, number).picture.linear.clone()
}

fn assert_close(what: &str, a: &[[f32; 4]], b: &[[f32; 4]]) {
    assert_eq!(a.len(), b.len());
    let (mut worst, mut light) = (0.0_f32, 0.0_f32);
    for (a, b) in a.iter().flatten().zip(b.iter().flatten()) {
        worst = worst.max((a - b).abs() / b.abs().max(0.01));
        light = light.max(*b);
    }
    assert!(worst < 2e-5 && light > 0.1, "{what}: relative difference {worst}, brightest {light}");
}

#[test]
fn a_factor_of_one_group_is_its_light_times_the_factor() {
    let desc = Arc::new(scene(LAMPS));
    let engine = Engine::new(|| {});
    for (left, right) in [(1.0, 1.0), (2.0, 1.0), (1.0, 0.0), (0.25, 3.0), (0.0, 0.5)] {
        let text = LAMPS
            .replace("emission_luminance = 0.5 ", &format!("emission_luminance = {} ", 0.5 * left))
            .replace("emission_luminance = 0.25 ", &format!("emission_luminance = {} ", 0.25 * right));
        let again = rendered(&scene(&text));
        let mix = mixed(&engine, &desc, &[("light.left", left), ("light.right", right)]);
        assert_close(&format!("{left} and {right}"), &mix, &again.linear);
    }
}

/// Twice as strong lights have the same samples: light is chosen by the share of its power. Light that light paths bring is
/// of no group, but a layer of its own.
#[test]
fn all_groups_twice_as_strong_are_a_scene_twice_as_bright() {
    let desc = balls("path", |desc| desc.background = Default::default());
    let engine = Engine::new(|| {});
    let twice = balls("path", |desc| {
        desc.background = Default::default();
        for light in &mut desc.lights {
            if let LightDesc::Point(point) = &mut light.value {
                point.intensity *= 2.0;
            }
        }
        for material in &mut desc.materials {
            if let turner::material::MaterialDesc::Principled(m) = &mut material.value {
                m.emission_luminance *= 2.0;
            }
        }
    });
    let mix = mixed(&engine, &desc, &[("light.key", 2.0), ("light.lamp", 2.0), ("caustics", 2.0)]);
    assert_close("twice", &mix, &rendered(&twice).linear);
}

/// Without a change of strength the mix is the picture itself, and unknown layers add nothing.
#[test]
fn a_mix_of_ones_is_the_picture() {
    let desc = balls("path", |_| {});
    let engine = Engine::new(|| {});
    let reference = rendered(&desc);
    for mix in [vec![("light.key", 1.0)], vec![("light.key", 1.0), ("light.lamp", 1.0)]] {
        let linear = mixed(&engine, &desc, &mix);
        assert!(linear == reference.linear, "{mix:?}");
    }
    // A changed factor makes a sum of the layers, in another order of additions.
    assert_close("unknown", &mixed(&engine, &desc, &[("nothing of this name", 5.0)]), &reference.linear);
}

/// Emission, direct and indirect light: together they are the picture, and a layer without light leaves the others.
#[test]
fn parts_of_light_add_up() {
    let desc = balls("path", |_| {});
    let engine = Engine::new(|| {});
    let reference = rendered(&desc);
    let of = |mix: &[(&str, f32)]| {
        let mix = mix.iter().map(|(name, factor)| ((*name).to_owned(), *factor)).collect();
        let look = Look { mix, layers: Layers::Parts, ..Look::default() };
        let number = engine.order(Order { look, ..order(&desc) });
        settled(&engine, number).picture.linear.clone()
    };
    assert!(of(&[]) == reference.linear);
    let layers = engine.status().layers;
    for part in ["emission", "direct", "indirect"] {
        assert!(layers.iter().any(|layer| layer == part), "{layers:?}");
    }
    let alone = |part: &str| -> Vec<[f32; 4]> {
        let mix: Vec<(&str, f32)> =
            layers.iter().map(|layer| (layer.as_str(), f32::from(layer == part))).collect();
        of(&mix)
    };
    let mut sum = vec![[0.0_f32; 4]; reference.linear.len()];
    for layer in &layers {
        for (to, from) in sum.iter_mut().flatten().zip(alone(layer).iter().flatten()) {
            *to += from;
        }
    }
    sum.iter_mut().zip(&reference.linear).for_each(|(sum, whole)| sum[3] = whole[3]);
    assert_close("the sum of the layers", &sum, &reference.linear);
}
