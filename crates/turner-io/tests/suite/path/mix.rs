//! Mixes of materials: weighted sums of what each does.

use crate::classic::common::{describe, pixel, render};
use crate::path::statistics::{Mean, mean};

/// A sphere of a material in light from all around.
fn furnace(samples: u32, materials: &str, around: f64) -> Mean {
    mean(
        samples,
        &format!(
            "integrator = {{ type = \"path\", rr_start = 1000 }}\n\
             camera = {{ position = [0, 0, 4], look_at = [0, 0, 0], fov = 10 }}\nbackground.color = {around}\n{materials}\n\
             object = [{{ type = \"sphere\", radius = 1, material = \"m\" }}]"
        ),
    )
}

const DARK: &str = "material.dark = { type = \"matte\", color = 0.2 }\nmaterial.light = { type = \"matte\", color = [0.8, 0.6, 0.4] }\n";

#[test]
fn shares_of_two_of_three_and_of_mixes() {
    let weighed = |materials: &str, weights: &str| {
        let m = format!(
            "{DARK}material.m = {{ type = \"mix\", materials = [{materials}], weights = [{weights}] }}"
        );
        furnace(256, &m, 1.0)
    };
    let blend = |light: f64| [0.8, 0.6, 0.4].map(|c| 0.2 + (c - 0.2) * light);
    weighed("\"dark\", \"light\"", "").is(blend(0.5), 0.01);
    weighed("\"dark\", \"light\"", "0.25").is(blend(0.25), 0.01);
    weighed("\"dark\", \"light\"", "1, 3").is(blend(0.75), 0.01);
    weighed("\"dark\", \"light\", \"dark\"", "0.3, 0.3").is(blend(0.3), 0.01);
    // Of more than one in all, nothing is left for the first.
    weighed("\"dark\", \"light\", \"dark\"", "3, 1").is(blend(0.75), 0.01);
    weighed("\"dark\", \"light\"", "0, 0").is(blend(0.0), 0.01);
    let inner = "{ type = \"mix\", materials = [\"dark\", \"light\"], weights = [0.5] }";
    weighed(&format!("\"dark\", {inner}"), "0.5").is(blend(0.25), 0.01);
}

#[test]
fn nothing_is_lost_in_a_furnace() {
    let m = "material.m = { type = \"mix\", weights = [0.6], materials = [{ type = \"matte\", color = 1 }, \
             { type = \"principled\", specular_roughness = 0, base_metalness = 1, base_color = 1 }] }";
    furnace(64, m, 1.0).is_grey(1.0, 0.001);
}

#[test]
fn a_textured_weight_shows_its_texture() {
    let text = "film = { width = 2, height = 1, antialias = \"monte-carlo\", samples = 4 }\n\
        integrator.type = \"path\"\ncamera = { type = \"orthographic\", position = [0, 0, 4], look_at = [0, 0, 0], viewport = [2, 1] }\n\
        material.red = { type = \"emissive\", color = [1, 0, 0] }\nmaterial.blue = { type = \"emissive\", color = [0, 0, 2] }\n\
        material.m = { type = \"mix\", materials = [\"red\", \"blue\"], weights = [{ type = \"gradient\", kind = \"linear\", stops = [[0.499, 0], [0.501, 1]] }] }\n\
        object = [{ type = \"rectangle\", edge_u = [2, 0, 0], edge_v = [0, 2, 0], material = \"m\" }]";
    let picture = render(text).0;
    let both = [pixel(&picture, 0, 0), pixel(&picture, 1, 0)];
    assert!(both.contains(&[1.0, 0.0, 0.0]) && both.contains(&[0.0, 0.0, 2.0]), "{both:?}");
}

/// A lamp with a share of 0.25 behind holes with a share of 0.5.
const LAMP: &str = "material.lamp = { type = \"emissive\", strength = 4 }\n\
    material.wall = { type = \"matte\", color = 0 }\n\
    material.hole = { type = \"principled\", opacity = 0 }\n\
    material.m = { type = \"mix\", materials = [\"lamp\", \"wall\", \"hole\"], weights = [1, 1, 2] }\n";

#[test]
fn emission_and_holes_have_their_shares() {
    // Seen: a quarter of 4, and half of what is behind.
    let seen = mean(
        256,
        &format!(
            "{LAMP}integrator.type = \"path\"\nbackground.color = 0.5\n\
             camera = {{ position = [0, 0, 4], look_at = [0, 0, 0], fov = 1 }}\n\
             object = [{{ type = \"rectangle\", edge_u = [2, 0, 0], edge_v = [0, 2, 0], material = \"m\" }}]"
        ),
    );
    seen.is_grey(1.25, 0.01);
    // Lit by it, and through it: both ways of finding light agree with the formula of a disk above a point.
    for how in ["both", "bsdf", "light"] {
        let lit = mean(
            256,
            &format!(
                "{LAMP}integrator = {{ type = \"path\", max_depth = 1, light_sampling = \"{how}\" }}\n\
                 camera = {{ position = [0, 0.2, 0], look_at = [0, 0, 0], up = [0, 0, -1], fov = 0.001 }}\n\
                 object = [{{ type = \"plane\", material = {{ type = \"matte\", color = 0.5 }} }}, \
                 {{ type = \"disk\", center = [0, 1, 0], radius = 1, material = \"m\" }}, \
                 {{ type = \"disk\", center = [0, 2, 0], radius = 1, material = \"lamp\" }}]"
            ),
        );
        // The upper disk is seen by half through the lower one, and beyond its rim not at all.
        lit.is_grey(0.5 * (0.25 * 4.0 * 0.5 + 0.5 * 4.0 * 0.2), 0.03);
    }
}

#[test]
fn one_sided_parts_pass_what_comes_from_behind() {
    let m = "material.m = { type = \"mix\", materials = [{ type = \"principled\", unlit = true, base_color = 0.75, double_sided = false }, { type = \"emissive\" }] }";
    let seen = |normal: f64| {
        mean(
            256,
            &format!(
                "{m}\nintegrator.type = \"path\"\nbackground.color = 0.25\ncamera = {{ position = [0, 0, 4], look_at = [0, 0, 0], fov = 1 }}\n\
                 object = [{{ type = \"disk\", normal = [0, 0, {normal}], material = \"m\" }}]"
            ),
        )
    };
    seen(1.0).is_grey(0.5 * (0.75 + 1.0), 0.01);
    seen(-1.0).is_grey(0.5 * (0.25 + 1.0), 0.02);
}

#[test]
fn glass_in_a_mix_absorbs_inside() {
    // Half of the surface is a film without effect, half glass without contrast that absorbs.
    let text = "integrator = { type = \"path\", max_depth = 50 }\nbackground.color = 1\n\
        camera = { position = [0, 0, 4], look_at = [0, 0, 0], fov = 0.001 }\n\
        material.m = { type = \"mix\", weights = [0], materials = [{ type = \"principled\", transmission_weight = 1, specular_ior = 1, specular_roughness = 0, transmission_color = 0.25, transmission_depth = 2 }, { type = \"matte\" }] }\n\
        object = [{ type = \"sphere\", radius = 1, material = \"m\" }]";
    mean(16, text).is_grey(0.25, 0.001);
}

#[test]
fn the_classic_integrator_shows_the_mean() {
    let text = |material: &str| {
        format!(
            "film = {{ width = 8, height = 8 }}\ncamera = {{ position = [0, 0, 4], look_at = [0, 0, 0] }}\n\
             material.a = {{ color = [1, 0, 0] }}\nmaterial.b = {{ color = [0, 0, 1] }}\n\
             {material}\nlight = [{{ type = \"point\", position = [2, 3, 4] }}]\n\
             object = [{{ type = \"sphere\", radius = 1, material = \"m\" }}]"
        )
    };
    let mixed =
        render(&text("material.m = { type = \"mix\", materials = [\"a\", \"b\"], weights = [0.25] }")).0;
    let mean = render(&text("material.m = { color = [0.75, 0, 0.25] }")).0;
    for (a, b) in mixed.linear.iter().zip(&mean.linear) {
        for i in 0..4 {
            assert!((a[i] - b[i]).abs() < 1e-6, "{a:?} {b:?}");
        }
    }
}

#[test]
fn mixes_come_with_errors_at_their_place() {
    let refused = |materials: &str| {
        let text = format!("integrator.type = \"path\"\n{materials}\nobject = [{{ type = \"sphere\" }}]");
        describe(&text).prepare(&Default::default()).expect_err("refused").to_string()
    };
    let own = refused("material.a = { type = \"mix\", materials = [\"a\", \"a\"] }");
    assert!(own.contains("contains itself"), "{own}");
    let few = refused("material.a = { type = \"mix\", materials = [{}] }");
    assert!(few.contains("two materials"), "{few}");
    let many = refused("material.a = { type = \"mix\", materials = [{}, {}], weights = [1, 2, 3] }");
    assert!(many.contains("expected 1 or 2 weights"), "{many}");
}
