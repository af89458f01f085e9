//! Scenes of which the radiance is known by formula, at ten by ten pixels.

use std::f64::consts::PI;

use turner::math::elementary::{atan2, pow};
use turner::testing::{CompareOptions, Reference, compare};

use super::check::{Check, Finding};

/// Looks straight down at the origin.
const DOWN: &str = "camera = { position = [0, 0.2, 0], look_at = [0, 0, 0], up = [0, 0, -1], fov = 0.001 }\n";
/// Looks along −z at a wall that shines with 1, all else black; what is between follows in the list of objects.
const ALONG: &str = "camera = { position = [0, 0, 10], look_at = [0, 0, 0], fov = 0.001 }\nintegrator = { type = \"path\", max_depth = 200 }\n";
const WALL: &str = "{ type = \"rectangle\", center = [0, 0, -10], edge_u = [9, 0, 0], edge_v = [0, 9, 0], material = { type = \"emissive\" } }";
const FLOOR: &str = "{ type = \"plane\", material = { type = \"matte\", color = 0.5 } }";

struct Case {
    name: &'static str,
    scene: String,
    expected: [f64; 3],
    /// Samples per pixel and run.
    samples: u32,
    /// Largest standard error, in relation to the value.
    cap: f64,
}

/// The form factor from a place to a rectangle parallel to it, above it with a corner, of sides a and b times the height.
fn corner_factor(a: f64, b: f64) -> f64 {
    let part = |a: f64, b: f64| {
        let root = (1.0 + a * a).sqrt();
        a / root * atan2(b, root)
    };
    (part(a, b) + part(b, a)) / (2.0 * PI)
}

/// Of a slab with reflecting faces r and s and the share a left after one way through it, all ways between them counted.
fn passes(r: f64, s: f64, a: f64) -> f64 {
    (1.0 - r) * (1.0 - s) * a / (1.0 - r * s * a * a)
}

fn reflectance(a: f64, b: f64) -> f64 {
    let r = (a - b) / (a + b);
    r * r
}

fn cases() -> Vec<Case> {
    let mut out = Vec::new();
    let mut add = |name, scene: String, expected, samples, cap| {
        out.push(Case { name, scene, expected, samples, cap });
    };
    let path = |more: &str| format!("integrator = {{ type = \"path\"{more} }}\n");
    for (name, around) in [
        ("background", "background.color = 1"),
        ("ambient", "light = [{ type = \"ambient\", intensity = 1 }]"),
    ] {
        let scene = format!(
            "{}camera = {{ position = [0, 0, 4], look_at = [0, 0, 0], fov = 10 }}\n{around}\n\
             object = [{{ type = \"sphere\", radius = 1, material = {{ type = \"matte\", color = [0.3, 0, 1] }} }}]",
            path(", rr_start = 1000")
        );
        let name = if name == "ambient" { "sphere-in-ambient-light" } else { "sphere-in-a-furnace" };
        add(name, scene, [0.3, 0.0, 1.0], 8, 1e-5);
    }
    // 60 degrees from the normal at the distance 2.
    let at = "position = [1.7320508075688772, 1, 0]";
    for (name, light, e) in [
        ("point", format!("type = \"point\", {at}, intensity = 8, attenuation = \"inverse-square\""), 1.0),
        (
            "directional",
            "type = \"directional\", from = [1.7320508075688772, 1, 0], intensity = 8".into(),
            4.0,
        ),
        ("spot", format!("type = \"spot\", {at}, intensity = 8, attenuation = \"inverse-square\""), 1.0),
    ] {
        let name = match name {
            "point" => "point-light-on-a-plane",
            "spot" => "spot-on-a-plane",
            _ => "directional-light-on-a-plane",
        };
        let scene = format!("{}{DOWN}light = [{{ {light} }}]\nobject = [{FLOOR}]", path(""));
        add(name, scene, [0.5 / PI * e; 3], 2, 1e-5);
    }
    let box_factor = 4.0 * corner_factor(0.5, 1.0);
    for (name, shape, factor) in [
        (
            "rectangle-above-a-plane",
            "type = \"rectangle\", center = [0, 1, 0], edge_u = [1, 0, 0], edge_v = [0, 0, 2]",
            box_factor,
        ),
        (
            "large-rectangle-above-a-plane",
            "type = \"rectangle\", center = [0, 1, 0], edge_u = [8, 0, 0], edge_v = [0, 0, 6]",
            4.0 * corner_factor(4.0, 3.0),
        ),
        ("box-above-a-plane", "type = \"box\", min = [-0.5, 1, -1], max = [0.5, 3, 1]", box_factor),
        ("disk-above-a-plane", "type = \"disk\", center = [0, 2, 0], radius = 1.5", 2.25 / (2.25 + 4.0)),
        ("sphere-above-a-plane", "type = \"sphere\", center = [0, 2, 0], radius = 1.5", 2.25 / 4.0),
        (
            "mirrored-rectangle-above-a-plane",
            "type = \"rectangle\", edge_u = [1, 0, 0], edge_v = [0, 1, 0], transform = [{ scale = [-1, 2, 1] }, { rotate = [90, 0, 0] }, { translate = [0, 1, 0] }]",
            box_factor,
        ),
        (
            "mesh-above-a-plane",
            "type = \"mesh\", positions = [[-0.5, 1, -1], [0.5, 1, -1], [0.5, 1, 1], [-0.5, 1, 1]], triangles = [[0, 1, 2], [0, 2, 3]]",
            box_factor,
        ),
    ] {
        let scene = format!(
            "{}{DOWN}object = [{FLOOR}, {{ {shape}, material = {{ type = \"emissive\", strength = 4 }} }}]",
            path(", max_depth = 1")
        );
        add(name, scene, [2.0 * factor; 3], 64, 0.01);
    }
    for (name, ior) in [("water-slab", 1.33), ("glass-slab", 1.5), ("diamond-slab", 2.42)] {
        let scene = format!(
            "{ALONG}object = [{{ type = \"box\", min = [-5, -5, -1], max = [5, 5, 1], material = {{ type = \"dielectric\", ior = {ior} }} }}, {WALL}]"
        );
        let r = reflectance(1.0, ior);
        add(name, scene, [passes(r, r, 1.0); 3], 64, 0.01);
    }
    let scene = format!(
        "{ALONG}object = [{{ type = \"box\", min = [-5, -5, -1], max = [5, 5, 1], material = {{ type = \"dielectric\", color = [0.25, 0.5, 1], depth = 4 }} }}, {WALL}]"
    );
    let r = reflectance(1.0, 1.5);
    let beer = [0.25, 0.5, 1.0].map(|c| passes(r, r, pow(c, 0.5)));
    add("glass-that-absorbs", scene, beer, 64, 0.01);
    // Inside a sphere that shines with 1 and returns half: 1 + 1/2 + 1/4 + …
    let inside = |more: &str| {
        format!(
            "{}camera = {{ position = [0.1, 0, 0], look_at = [0, 0, 1] }}\n\
             object = [{{ type = \"sphere\", radius = 1, material = {{ type = \"principled\", specular_weight = 0, base_color = 0.5, emission_luminance = 1 }} }}]",
            path(more)
        )
    };
    let series = inside(", max_depth = 7, rr_start = 1000, light_sampling = \"bsdf\"");
    add("inside-a-shining-sphere", series, [2.0 - 1.0 / 128.0; 3], 4, 1e-5);
    add(
        "inside-a-shining-sphere-with-roulette",
        inside(", max_depth = 1000, rr_start = 1"),
        [2.0; 3],
        64,
        0.01,
    );
    let plane = |y: i32| {
        format!(
            "{{ type = \"plane\", point = [0, {y}, 0], normal = [0, {}, 0], material = {{ type = \"principled\", specular_weight = 0, base_color = [0.5, 0.9, 0.1], emission_luminance = 1 }} }}",
            -y
        )
    };
    let scene = format!(
        "{}camera = {{ position = [0, 0, 0], look_at = [0, -1, 0.2] }}\nobject = [{}, {}]",
        path(", max_depth = 1000, rr_start = 1"),
        plane(-1),
        plane(1)
    );
    add("between-parallel-planes", scene, [2.0, 10.0, 1.0 / 0.9], 128, 0.02);
    // A sheet that covers a quarter, shining, over a background.
    let scene = format!(
        "{}{DOWN}background.color = 1\nobject = [{{ type = \"rectangle\", edge_u = [8, 0, 0], edge_v = [0, 0, 8], material = {{ type = \"principled\", specular_weight = 0, base_weight = 0, alpha_mode = \"blend\", opacity = 0.25, emission_luminance = 2 }} }}]",
        path("")
    );
    add("a-sheet-that-covers-a-quarter", scene, [0.75 + 0.5; 3], 64, 0.01);
    out
}

pub(super) fn checks() -> Vec<Check> {
    cases()
        .into_iter()
        .map(|case| {
            Check::chance(format!("closed/{}", case.name), move |cx| {
                let mut scene = cx.scene([10, 10], cx.times(case.samples), &case.scene)?;
                let runs = cx.runs(&mut scene, 16, case.name)?;
                let exact = Reference::constant(10, 10, case.expected);
                let options = CompareOptions { block: 10, tolerance: 4e-6, ..CompareOptions::default() };
                Ok(Finding::comparison(&compare(&runs, &exact, &options), case.cap))
            })
        })
        .collect()
}
