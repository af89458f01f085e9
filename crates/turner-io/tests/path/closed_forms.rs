//! Radiance known by formula.

use std::f64::consts::PI;

use crate::statistics::mean;

/// Looks straight down at the origin.
const DOWN: &str = "camera = { position = [0, 0.2, 0], look_at = [0, 0, 0], up = [0, 0, -1], fov = 0.001 }\n";

/// A Lambertian surface and nothing else.
const MATTE: &str = "type = \"principled\", specular_weight = 0";

fn integrator(how: &str) -> String {
    format!("integrator = {{ type = \"path\", {how} }}\n")
}

const WAYS: [&str; 3] =
    ["light_sampling = \"both\"", "light_sampling = \"bsdf\"", "light_sampling = \"light\""];

#[test]
fn a_convex_surface_among_light_shows_its_albedo() {
    for around in ["background.color = 1", "light = [{ type = \"ambient\", intensity = 1 }]"] {
        for albedo in [0.0, 0.3, 1.0] {
            let m = mean(
                16,
                &format!(
                    "{}camera = {{ position = [0, 0, 4], look_at = [0, 0, 0], fov = 10 }}\n{around}\n\
                     object = [{{ type = \"sphere\", radius = 1, material = {{ {MATTE}, base_color = {albedo} }} }}]",
                    integrator("rr_start = 1000")
                ),
            );
            for v in m.value() {
                assert!((v - albedo).abs() < 2e-6, "{m:?}");
            }
        }
    }
}

#[test]
fn shining_surfaces_are_seen_as_they_are() {
    let shine = "type = \"principled\", emission_luminance = 3, emission_color = [1, 0.5, 0.25], base_weight = 0, specular_weight = 0";
    for shape in
        ["\"sphere\", radius = 0.1", "\"rectangle\", edge_u = [1, 0, 0], edge_v = [0, 0, -1]", "\"cylinder\""]
    {
        for how in WAYS {
            let m = mean(
                4,
                &format!(
                    "{}{DOWN}object = [{{ type = {shape}, material = {{ {shine} }} }}]",
                    integrator(how)
                ),
            );
            m.is([3.0, 1.5, 0.75], 0.0);
        }
    }
    // Of one side only.
    let back = "\"rectangle\", edge_u = [1, 0, 0], edge_v = [0, 0, 1]";
    let m = mean(
        4,
        &format!(
            "{}{DOWN}object = [{{ type = {back}, material = {{ {shine}, double_sided = false }} }}]\nbackground.color = 0.125",
            integrator("max_depth = 3")
        ),
    );
    m.is_grey(0.125, 0.0);
}

#[test]
fn lights_without_extent_on_a_matte_plane() {
    let plane =
        format!("object = [{{ type = \"plane\", material = {{ {MATTE}, base_color = [0.5, 0.25, 1] }} }}]\n");
    let lit = |light: &str| mean(1, &format!("{}{DOWN}{plane}light = [{{ {light} }}]", integrator("")));
    let expected = |e: f64| [0.5, 0.25, 1.0].map(|c| c / PI * e);
    // 60 degrees from the normal at the distance 2: intensity / 4 · cos.
    let at = "position = [1.7320508075688772, 1, 0]";
    lit(&format!("type = \"point\", {at}, intensity = 8, attenuation = \"inverse-square\""))
        .is(expected(1.0), 0.0);
    lit(&format!("type = \"point\", {at}, intensity = 8")).is(expected(4.0), 0.0);
    lit("type = \"directional\", from = [1.7320508075688772, 1, 0], intensity = 8").is(expected(4.0), 0.0);
    lit(&format!("type = \"spot\", {at}, intensity = 8, attenuation = \"inverse-square\""))
        .is(expected(1.0), 0.0);
}

/// The form factor from a place to a rectangle parallel to it, above it with a corner, of sides a and b times the height.
fn corner_factor(a: f64, b: f64) -> f64 {
    let part = |a: f64, b: f64| a / (1.0 + a * a).sqrt() * (b / (1.0 + a * a).sqrt()).atan();
    (part(a, b) + part(b, a)) / (2.0 * PI)
}

#[test]
fn shapes_that_shine_above_a_matte_plane() {
    let plane = format!("{{ type = \"plane\", material = {{ {MATTE}, base_color = 0.5 }} }}");
    let shine = "type = \"principled\", emission_luminance = 4, base_weight = 0, specular_weight = 0";
    let box_factor = 4.0 * corner_factor(0.5, 1.0);
    let cases = [
        ("type = \"rectangle\", center = [0, 1, 0], edge_u = [1, 0, 0], edge_v = [0, 0, 2]", box_factor),
        // Larger than its height: by solid angle, and a parallelogram of the same area by area.
        (
            "type = \"rectangle\", center = [0, 1, 0], edge_u = [8, 0, 0], edge_v = [0, 0, 6]",
            4.0 * corner_factor(4.0, 3.0),
        ),
        ("type = \"box\", min = [-0.5, 1, -1], max = [0.5, 3, 1]", box_factor),
        ("type = \"disk\", center = [0, 2, 0], radius = 1.5", 2.25 / (2.25 + 4.0)),
        ("type = \"sphere\", center = [0, 2, 0], radius = 1.5", 2.25 / 4.0),
        (
            "type = \"sphere\", radius = 1, transform = [{ scale = 1.5 }, { translate = [0, 2, 0] }]",
            2.25 / 4.0,
        ),
        (
            "type = \"rectangle\", edge_u = [1, 0, 0], edge_v = [0, 1, 0], transform = [{ scale = [-1, 2, 1] }, { rotate = [90, 0, 0] }, { translate = [0, 1, 0] }]",
            box_factor,
        ),
    ];
    for (shape, factor) in cases {
        for (how, cap) in WAYS.iter().zip([0.004, 0.05, 0.01]) {
            // What the camera sees through from above counts for nothing: the camera is below all lights.
            let m = mean(
                256,
                &format!(
                    "{}{DOWN}object = [{plane}, {{ {shape}, material = {{ {shine} }} }}]",
                    integrator(&format!("max_depth = 1, {how}"))
                ),
            );
            m.is_grey(0.5 * 4.0 * factor, cap);
        }
    }
}

#[test]
fn depth_limits_cut_a_geometric_series() {
    // Inside a sphere that shines with 1 and returns half: 1 + 1/2 + 1/4 + …
    for depth in [0u32, 1, 2, 3, 7] {
        let inside = |limit: &str| {
            mean(
                8,
                &format!(
                    "{}camera = {{ position = [0.1, 0, 0], look_at = [0, 0, 1] }}\n\
                 object = [{{ type = \"sphere\", radius = 1, material = {{ {MATTE}, base_color = 0.5, emission_luminance = 1 }} }}]",
                    integrator(&format!("{limit}, rr_start = 1000, light_sampling = \"bsdf\""))
                ),
            )
        };
        let expected = 2.0 - 0.5f64.powi(depth as i32);
        inside(&format!("max_depth = {depth}")).is_grey(expected, 1e-6);
        inside(&format!("max_depth = 100, max_diffuse = {depth}")).is_grey(expected, 1e-6);
        inside(&format!("max_depth = {depth}, max_glossy = 0, max_transmission = 0")).is_grey(expected, 1e-6);
    }
    // The direct integrator stops after the first.
    let m = mean(
        8,
        &format!(
            "integrator = {{ type = \"direct\", light_sampling = \"bsdf\" }}\ncamera = {{ position = [0.1, 0, 0], look_at = [0, 0, 1] }}\n\
         object = [{{ type = \"sphere\", radius = 1, material = {{ {MATTE}, base_color = 0.5, emission_luminance = 1 }} }}]"
        ),
    );
    m.is_grey(1.5, 1e-6);
}

#[test]
fn parallel_planes_and_russian_roulette() {
    let plane = |y: i32, n: i32| {
        format!(
            "{{ type = \"plane\", point = [0, {y}, 0], normal = [0, {n}, 0], material = {{ {MATTE}, base_color = [0.5, 0.9, 0.1], emission_luminance = 1 }} }}"
        )
    };
    let m = mean(
        256,
        &format!(
            "{}camera = {{ position = [0, 0, 0], look_at = [0, -1, 0.2] }}\nobject = [{}, {}]",
            integrator("max_depth = 1000, rr_start = 1"),
            plane(-1, 1),
            plane(1, -1)
        ),
    );
    m.is([2.0, 10.0, 1.0 / 0.9], 0.02);
}

#[test]
fn surfaces_that_cover_a_share() {
    let sheet = |more: &str| {
        format!(
            "{{ type = \"rectangle\", center = [0, 0.15, 0], edge_u = [8, 0, 0], edge_v = [0, 0, 8], material = {{ type = \"principled\", specular_weight = 0, base_weight = 0, alpha_mode = \"blend\", opacity = 0.25{more} }} }}"
        )
    };
    // Alpha and colour over a transparent background.
    let m = mean(
        64,
        &format!(
            "{}{DOWN}background.transparent = true\nobject = [{}]",
            integrator(""),
            sheet(", emission_luminance = 2")
        ),
    );
    assert!((m.alpha() - 0.25).abs() < 0.003, "{m:?}");
    m.is_grey(0.5, 0.02);
    // What is behind shows by three quarters, and is lit by three quarters.
    let lit = mean(
        64,
        &format!(
            "{}camera = {{ position = [0, 0.1, 0], look_at = [0, 0, 0], up = [0, 0, -1], fov = 0.001 }}\n\
         light = [{{ type = \"directional\", from = [0.2, 1, 0], intensity = 2 }}]\n\
         object = [{}, {{ type = \"plane\", material = {{ {MATTE}, base_color = 0.5 }} }}]",
            integrator("max_depth = 1"),
            sheet("")
        ),
    );
    let cos = 1.0 / 1.04f64.sqrt();
    lit.is_grey(0.75 * 0.5 / PI * 2.0 * cos, 1e-6);
    // Unlit things show their colour and stop light.
    let unlit = "material = { type = \"principled\", unlit = true, base_color = 0.75 }";
    let m = mean(
        1,
        &format!(
            "{}{DOWN}light = [{{ type = \"ambient\", intensity = 1 }}]\nobject = [{{ type = \"plane\", {unlit} }}]",
            integrator("")
        ),
    );
    m.is_grey(0.75, 0.0);
}
