//! The same light found in different ways.

use crate::path::statistics::{Mean, mean_of};

const ROOM: &str = r#"
camera = { position = [0, 1, 3.4], look_at = [0, 0.9, 0], fov = 45 }
[material.wall]
type = "principled"
base_color = [0.7, 0.6, 0.5]
[material.gloss]
type = "principled"
base_color = [0.9, 0.6, 0.2]
base_metalness = 1
specular_roughness = 0.4
[material.lamp]
type = "principled"
base_weight = 0
specular_weight = 0
emission_luminance = 5
[[object]]
type = "plane"
material = "wall"
[[object]]
type = "plane"
point = [0, 0, -2]
normal = [0, 0, 1]
material = "wall"
[[object]]
type = "sphere"
center = [0.5, 0.6, 0]
radius = 0.6
material = "gloss"
[[object]]
type = "rectangle"
center = [-0.5, 2, 0]
edge_u = [1, 0, 0]
edge_v = [0, 0, 1]
material = "lamp"
[[object]]
type = "sphere"
center = [-0.9, 0.4, 0.6]
radius = 0.25
material = "lamp"
[[object]]
type = "box"
min = [1.2, 0, 0.6]
max = [1.4, 0.3, 0.8]
material = "lamp"
"#;

fn estimate(samples: u32, integrator: &str, scene: &str) -> Mean {
    mean_of(24, samples, &format!("integrator = {{ {integrator} }}\n{scene}"))
}

#[test]
fn with_and_without_light_sampling() {
    let both = estimate(16, "type = \"path\", max_depth = 4", ROOM);
    let bsdf = estimate(128, "type = \"path\", max_depth = 4, light_sampling = \"bsdf\"", ROOM);
    let light = estimate(16, "type = \"path\", max_depth = 4, light_sampling = \"light\"", ROOM);
    both.agrees(&bsdf, 0.02);
    both.agrees(&light, 0.03);
}

/// Where mirrors look at several lights before one is followed: flat ones that are shaded in blocks, and round ones.
#[test]
fn one_of_several_lights_stands_for_all() {
    let plate = |x: f64, roughness: f64| {
        format!(
            "{{ type = \"mesh\", positions = [[{x}, 0, 0], [{0}, 0, 0], [{0}, 0, 2], [{x}, 0, 2]], triangles = [[0, 2, 1], [0, 3, 2]], \
             material = {{ type = \"principled\", base_metalness = 1, base_color = [0.9, 0.8, 0.5], specular_roughness = {roughness} }} }}",
            x + 1.0
        )
    };
    let lamp = |center: &str, radius: f64, strength: f64| {
        format!(
            "{{ type = \"sphere\", center = {center}, radius = {radius}, material = {{ type = \"emissive\", strength = {strength} }} }}"
        )
    };
    let round = "{ type = \"sphere\", center = [0.2, 0.3, 1.6], radius = 0.3, material = { type = \"principled\", base_metalness = 1, \
                 specular_roughness = 0.25 } }";
    // Something in the way of some light, too.
    let scene = format!(
        "camera = {{ position = [0, 2, 5], look_at = [0, 0.2, 1], fov = 32 }}\nlight = [{{ type = \"environment\" }}]\n\
         object = [{}, {}, {}, {}, {}, {}, {round},\n\
         {{ type = \"box\", min = [-0.3, 0.3, -0.4], max = [-0.1, 2, -0.2], material = {{ type = \"matte\" }} }}]\n",
        plate(-1.5, 0.15),
        plate(-0.5, 0.3),
        plate(0.5, 0.45),
        lamp("[-1, 0.8, -1]", 0.1, 40.0),
        lamp("[0, 0.9, -1]", 0.3, 10.0),
        lamp("[1.2, 1, -1]", 0.6, 4.0),
    );
    let with = |samples: u32, how: &str| {
        estimate(
            samples,
            &format!("type = \"path\", max_depth = 3, caustics = \"off\", light_sampling = \"{how}\""),
            &scene,
        )
    };
    let (both, bsdf, light) = (with(32, "both"), with(256, "bsdf"), with(64, "light"));
    both.agrees(&bsdf, 0.01);
    both.agrees(&light, 0.02);
}

#[test]
fn environments_sampled_and_hit() {
    let scene =
        format!("light = [{{ type = \"environment\", rotation = 40, tint = [1, 0.8, 0.6] }}]\n{ROOM}");
    let both = estimate(16, "type = \"path\", max_depth = 3", &scene);
    let bsdf = estimate(64, "type = \"path\", max_depth = 3, light_sampling = \"bsdf\"", &scene);
    let light = estimate(64, "type = \"path\", max_depth = 3, light_sampling = \"light\"", &scene);
    both.agrees(&bsdf, 0.02);
    both.agrees(&light, 0.03);
}

#[test]
fn russian_roulette_changes_no_mean() {
    let without = estimate(16, "type = \"path\", rr_start = 1000", ROOM);
    let with = estimate(32, "type = \"path\", rr_start = 1", ROOM);
    without.agrees(&with, 0.02);
}

#[test]
fn a_clamp_takes_light_away_and_only_indirect_light() {
    let without = estimate(4, "type = \"path\"", ROOM);
    let with = estimate(4, "type = \"path\", clamp_indirect = 0.1", ROOM);
    assert!(with.value()[0] < 0.98 * without.value()[0], "{with:?} {without:?}");
    let direct = |clamp: &str| estimate(4, &format!("type = \"path\", max_depth = 1{clamp}"), ROOM).value();
    assert_eq!(direct(""), direct(", clamp_indirect = 0.1"));
}
