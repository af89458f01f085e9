//! Different estimators of the same radiance must agree.

use turner::testing::{CompareOptions, compare};

use super::check::{Check, Finding};

pub(super) const ROOM: &str = r#"
camera = { position = [0, 1, 3.4], look_at = [0, 0.9, 0], fov = 45 }
[material.wall]
type = "matte"
color = [0.7, 0.6, 0.5]
[material.gloss]
type = "metal"
color = [0.9, 0.6, 0.2]
roughness = 0.4
[material.paint]
type = "plastic"
[material.lamp]
type = "emissive"
strength = 5
[[object]]
type = "plane"
material = "wall"
[[object]]
type = "plane"
point = [0, 0, -2]
normal = [0, 0, 1]
material = "paint"
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
type = "mesh"
positions = [[1.1, 0, 0.5], [1.6, 0, 0.5], [1.3, 0.6, 0.7], [1.3, 0.1, 1.0]]
triangles = [[0, 1, 2], [1, 3, 2], [3, 0, 2], [0, 3, 1]]
material = "lamp"
"#;

const SKY: &str = "light = [{ type = \"environment\", rotation = 40, tint = [1, 0.8, 0.6] }]\n";

/// Two integrators with their samples per pixel and run. `cap` is the largest standard error of the ratio of means.
struct Pair {
    name: &'static str,
    lights: &'static str,
    one: (&'static str, u32),
    other: (&'static str, u32),
    cap: f64,
}

const PAIRS: [Pair; 7] = [
    Pair {
        name: "mis-and-bsdf-sampling",
        lights: "",
        one: ("type = \"path\", max_depth = 4", 16),
        other: ("type = \"path\", max_depth = 4, light_sampling = \"bsdf\"", 96),
        cap: 0.01,
    },
    Pair {
        name: "mis-and-light-sampling",
        lights: "",
        one: ("type = \"path\", max_depth = 4", 16),
        other: ("type = \"path\", max_depth = 4, light_sampling = \"light\"", 16),
        cap: 0.01,
    },
    Pair {
        name: "environment-mis-and-bsdf-sampling",
        lights: SKY,
        one: ("type = \"path\", max_depth = 3", 16),
        other: ("type = \"path\", max_depth = 3, light_sampling = \"bsdf\"", 96),
        cap: 0.01,
    },
    Pair {
        name: "environment-mis-and-light-sampling",
        lights: SKY,
        one: ("type = \"path\", max_depth = 3", 16),
        other: ("type = \"path\", max_depth = 3, light_sampling = \"light\"", 32),
        cap: 0.01,
    },
    Pair {
        name: "direct-and-path-of-depth-1",
        lights: "",
        one: ("type = \"path\", max_depth = 1", 16),
        other: ("type = \"direct\", max_depth = 0", 16),
        cap: 0.01,
    },
    Pair {
        name: "russian-roulette",
        lights: "",
        one: ("type = \"path\", max_depth = 12, rr_start = 1000", 16),
        other: ("type = \"path\", max_depth = 12, rr_start = 1", 32),
        cap: 0.01,
    },
    Pair {
        name: "two-seeds",
        lights: SKY,
        one: ("type = \"path\"", 16),
        other: ("type = \"path\"", 16),
        cap: 0.01,
    },
];

pub(super) fn checks() -> Vec<Check> {
    PAIRS
        .iter()
        .map(|pair| {
            Check::chance(format!("estimators/{}", pair.name), move |cx| {
                let render = |(integrator, samples): (&str, u32), which: &str| {
                    let text = format!("integrator = {{ {integrator} }}\n{}{ROOM}", pair.lights);
                    let scene = cx.scene([24, 24], cx.times(samples), &text)?;
                    cx.runs(&scene, 12, &format!("{}/{which}", pair.name))
                };
                let (one, other) = (render(pair.one, "one")?, render(pair.other, "other")?);
                let found = compare(&one, &other, &CompareOptions::default());
                Ok(Finding::comparison(&found, pair.cap))
            })
        })
        .collect()
}
