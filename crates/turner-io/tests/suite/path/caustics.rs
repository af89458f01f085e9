//! Light that mirrors and glass gather, found in every way: all give the same picture.

use crate::classic::common::{describe, render_with};
use crate::path::statistics::{Mean, mean_of};

/// A ball of glass, one of polished and one of brushed metal in the corner of a room.
const TABLE: &str = r#"
camera = { position = [0, 1.6, 3.4], look_at = [0, 0.5, 0], fov = 45 }
material.wall = { type = "principled", base_color = [0.7, 0.6, 0.5], specular_weight = 0 }
material.glass = { type = "dielectric", ior = 1.5 }
material.mirror = { type = "metal", roughness = 0 }
material.brushed = { type = "metal", roughness = 0.25 }
material.lamp = { type = "principled", base_weight = 0, specular_weight = 0, emission_luminance = 4 }
material.bulb = { type = "principled", base_weight = 0, specular_weight = 0, emission_luminance = 400 }
material.pane = { type = "principled", transmission_weight = 1, thin_walled = true, specular_roughness = 0 }
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
center = [0.7, 0.5, 0]
radius = 0.5
material = "glass"
[[object]]
type = "box"
min = [-0.3, 0, -0.6]
max = [0.1, 0.8, -0.3]
material = "mirror"
[[object]]
type = "cylinder"
from = [-0.8, 0, 0.4]
to = [-0.8, 0.5, 0.4]
radius = 0.3
material = "brushed"
"#;

fn estimate(samples: u32, caustics: &str, scene: &str) -> Mean {
    let integrator =
        format!("integrator = {{ type = \"path\", max_depth = 6, caustics = \"{caustics}\" }}\n");
    mean_of(24, samples, &format!("{integrator}{TABLE}{scene}"))
}

/// Metal polished, but no mirror: it gathers light by a narrow lobe, and shows what others gather.
#[test]
fn of_polished_metal() {
    let lamp = "[[object]]\ntype = \"rectangle\"\ncenter = [-0.5, 2.6, 0.5]\nedge_u = [1.4, 0, 0]\nedge_v = [0, 0, 1.4]\nmaterial = \"lamp\"\n";
    let metal = "[[object]]\ntype = \"sphere\"\ncenter = [0.1, 0.35, 0.9]\nradius = 0.35\nmaterial = { type = \"metal\", roughness = 0.12 }\n\
                 [[object]]\ntype = \"cylinder\"\nfrom = [-0.2, 0, 0.4]\nto = [-0.2, 0.4, 0.4]\nradius = 0.35\ncapped = false\nmaterial = { type = \"metal\", roughness = 0.12 }\n";
    let scene = format!("{lamp}{metal}");
    let alone = estimate(256, "off", &scene);
    alone.agrees(&estimate(64, "light-tracing", &scene), 0.02);
    // In so small a picture photons would be blurred over the whole of it.
    let integrator =
        "integrator = { type = \"path\", max_depth = 6, caustics = \"full\", photon_radius = 0.03 }\n";
    alone.agrees(&mean_of(24, 64, &format!("{integrator}{TABLE}{scene}")), 0.02);
}

/// Camera paths alone, with light paths, and with photons.
fn all_agree(scene: &str, off: u32, tolerance: f64) {
    let alone = estimate(off, "off", scene);
    alone.agrees(&estimate(off / 4, "light-tracing", scene), tolerance);
    alone.agrees(&estimate(off / 4, "full", scene), tolerance);
}

#[test]
fn of_shapes_that_shine() {
    all_agree(
        "[[object]]\ntype = \"rectangle\"\ncenter = [-0.5, 2.6, 0.5]\nedge_u = [1.4, 0, 0]\nedge_v = [0, 0, 1.4]\nmaterial = \"lamp\"\n\
         [[object]]\ntype = \"sphere\"\ncenter = [1.8, 1.6, 0.5]\nradius = 0.5\nmaterial = \"lamp\"\n",
        256,
        0.02,
    );
}

#[test]
fn of_light_from_around() {
    all_agree(
        "[[light]]\ntype = \"environment\"\nrotation = 40\ntint = [1, 0.8, 0.6]\n\
         [[light]]\ntype = \"directional\"\nfrom = [0.5, 1, 0.6]\nangle = 25\nintensity = 2\n",
        256,
        0.02,
    );
}

/// A small ball that shines is a point to the rest; camera paths never find points behind glass, light paths do.
#[test]
fn of_points() {
    let ball = "[[object]]\ntype = \"sphere\"\ncenter = [0.5, 2.4, 1]\nradius = 0.05\nmaterial = \"bulb\"\n";
    // Radiant intensity π r² L.
    let intensity = std::f64::consts::PI * 0.05 * 0.05 * 400.0;
    let point = format!(
        "[[light]]\ntype = \"point\"\nposition = [0.5, 2.4, 1]\nintensity = {intensity}\nattenuation = \"inverse-square\"\n"
    );
    let ball = estimate(128, "light-tracing", ball);
    let point_light = estimate(128, "light-tracing", &point);
    // The ball blocks a little light of its own, and is seen in mirrors.
    ball.agrees(&point_light, 0.03);
    let without = estimate(128, "off", &point);
    let (without, with) = (without.value()[1], point_light.value()[1]);
    assert!(without < 0.985 * with, "{without} {with}");
}

#[test]
fn through_panes_and_with_many_lamps() {
    let mut scene = String::from(
        "[[object]]\ntype = \"rectangle\"\ncenter = [0, 2.2, 0.5]\nedge_u = [4, 0, 0]\nedge_v = [0, 0, 4]\nmaterial = \"pane\"\n",
    );
    // More than a table holds: a tree chooses.
    for i in 0..70 {
        let (x, z) = (f64::from(i % 10) * 0.3 - 1.5, f64::from(i / 10) * 0.3 - 0.5);
        scene += &format!(
            "[[object]]\ntype = \"sphere\"\ncenter = [{x}, 2.8, {z}]\nradius = 0.12\nmaterial = \"lamp\"\n"
        );
    }
    all_agree(&scene, 256, 0.02);
}

#[test]
fn any_number_of_threads_and_any_split_into_passes() {
    let lamp = "[[object]]\ntype = \"rectangle\"\ncenter = [-0.5, 2.6, 0.5]\nedge_u = [0.6, 0, 0]\nedge_v = [0, 0, 0.6]\nmaterial = \"lamp\"\n";
    for caustics in ["light-tracing", "full"] {
        let scene = format!(
            "film = {{ width = 80, height = 50, antialias = \"monte-carlo\", samples = 5, filter = \"gaussian\" }}\n\
             integrator = {{ type = \"path\", caustics = \"{caustics}\" }}\n{TABLE}{lamp}"
        );
        let desc = describe(&scene);
        let bits = |threads, pass| {
            let picture = render_with(&desc, threads, pass).0;
            picture.linear.iter().map(|p| p.map(f32::to_bits)).collect::<Vec<_>>()
        };
        let whole = bits(1, u32::MAX);
        for (threads, pass) in [(2, u32::MAX), (5, 1), (3, 2)] {
            assert!(bits(threads, pass) == whole, "{caustics}: {threads} threads, passes of {pass}");
        }
    }
}
