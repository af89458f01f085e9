//! What moves while the shutter is open.

use crate::classic::common::{describe, pixel, render, render_with};
use crate::path::statistics::mean;

const SHINES: &str = "type = \"principled\", base_weight = 0, specular_weight = 0, emission_luminance = 1";

/// Pixels of one unit, seen straight from above, and an object that shines.
fn strip(film: &str, object: &str, more: &str) -> Vec<f64> {
    let text = format!(
        "camera = {{ type = \"orthographic\", position = [0, 5, 0], look_at = [0, 0, 0], up = [0, 0, -1], viewport = [12, 4] }}\n\
         film = {{ width = 12, height = 4, antialias = \"monte-carlo\", samples = 4096{film} }}\n\
         integrator = {{ type = \"path\" }}\n\
         object = [{{ {object}, material = {{ {SHINES} }} }},\n{more}]\n"
    );
    let picture = render(&text).0;
    (0..12).map(|x| f64::from(pixel(&picture, x, 1)[0])).collect()
}

/// The mean over `open..close` of how much of the pixel at `x` something of two units' width covers, its left edge at −5 + 8·time.
fn covered(x: usize, open: f64, close: f64) -> f64 {
    let left = x as f64 - 6.0;
    let n = 4000;
    let share = |i: i32| {
        let edge = -5.0 + 8.0 * (open + (close - open) * (f64::from(i) + 0.5) / f64::from(n));
        ((left + 1.0).min(edge + 2.0) - left.max(edge)).max(0.0)
    };
    (0..n).map(share).sum::<f64>() / f64::from(n)
}

#[test]
fn a_bar_that_passes_leaves_its_share_of_light() {
    let go = "transform = { translate = [-4, 0, 0] }, motion = { translate = [4, 0, 0] }";
    let bar = format!("type = \"rectangle\", edge_u = [2, 0, 0], edge_v = [0, 0, -10], {go}");
    let boxed = format!("type = \"box\", size = [2, 1, 10], {go}");
    let mesh = format!(
        "type = \"mesh\", positions = [[-1, 0, -5], [1, 0, -5], [1, 0, 5], [-1, 0, 5]], triangles = [[0, 2, 1], [0, 3, 2]], {go}"
    );
    // Among others: in a sieve, in a tree, beside gathered meshes.
    let far = |n: usize, what: &str| {
        format!("{{ {what}, transform = {{ translate = [500, 0, 0] }} }},\n").repeat(n)
    };
    let others = [
        String::new(),
        far(9, "type = \"sphere\""),
        far(80, "type = \"sphere\""),
        far(3, "type = \"mesh\", positions = [[0, 0, 0], [1, 0, 0], [0, 1, 0]], triangles = [[0, 1, 2]]"),
    ];
    for object in [&bar, &boxed, &mesh] {
        for more in &others {
            for (film, open, close) in [("", 0.0, 1.0), (", shutter = [0.25, 0.5]", 0.25, 0.5)] {
                for (x, value) in strip(film, object, more).into_iter().enumerate() {
                    let expected = covered(x, open, close);
                    assert!((value - expected).abs() < 0.01, "{object}{film} {x}: {value}, not {expected}");
                }
            }
        }
    }
}

#[test]
fn a_moment_is_a_picture_without_motion() {
    let moving = "type = \"box\", size = [2, 1, 1], transform = { translate = [-4, 0, 0] }, motion = { rotate = [0, 90, 0], translate = [4, 0, 0] }";
    let still = |at: &str| format!("type = \"box\", size = [2, 1, 1], transform = {{ {at} }}");
    for (film, at) in [
        (", shutter = [0, 0]", "translate = [-4, 0, 0]"),
        (", shutter = [1, 1]", "rotate = [0, 90, 0], translate = [4, 0, 0]"),
        (", shutter = [0.5, 0.5]", "rotate = [0, 45, 0], translate = [0, 0, 0]"),
    ] {
        for (a, b) in strip(film, moving, "").into_iter().zip(strip("", &still(at), "")) {
            assert!((a - b).abs() < 1e-3, "{film}: {a} {b}");
        }
    }
    // Integrators that are not physical show the moment at which the shutter opens.
    let text = |object: &str, film: &str| {
        format!(
            "film = {{ width = 24, height = 16{film} }}\ncamera = {{ position = [0, 1, 9], look_at = [0, 0, 0] }}\n\
             object = [{{ {object} }}]\nlight = [{{ type = \"point\", position = [3, 5, 5] }}]\n"
        )
    };
    let classic = render(&text(moving, "")).0.linear;
    assert!(classic == render(&text(&still("translate = [-4, 0, 0]"), "")).0.linear);
    assert!(classic != render(&text(moving, ", shutter = [0.5, 1]")).0.linear);
}

#[test]
fn shadows_and_mirrors_see_the_same_moment() {
    let down = "camera = { position = [0, 0.2, 0], look_at = [0, 0, 0], up = [0, 0, -1], fov = 0.001 }\nintegrator = { type = \"path\" }\n";
    let light = "light = [{ type = \"directional\", from = [0, 1, 0] }]\n";
    // For a quarter of the time the blind is between the light and the place.
    let blind = "{ type = \"rectangle\", center = [0, 1, 0], edge_u = [2, 0, 0], edge_v = [0, 0, 2], transform = { translate = [-2, 0, 0] }, motion = { translate = [6, 0, 0] }, material = { type = \"matte\", color = 0 } }";
    let plane = "{ type = \"plane\", material = { type = \"matte\", color = 1 } }";
    let m = mean(256, &format!("{down}{light}object = [{plane}, {blind}]\n"));
    m.is_grey(0.75 / std::f64::consts::PI, 0.02);
    // A mirror that rocks shows the lamp above it for as long as it is level enough: from −9 to 9 degrees, the lamp in ±6 of them.
    let mirror = "{ type = \"rectangle\", edge_u = [4, 0, 0], edge_v = [0, 0, -4], transform = { rotate = [0, 0, -9] }, motion = { rotate = [0, 0, 9] }, \
                  material = { type = \"principled\", base_metalness = 1, base_color = 1, specular_roughness = 0 } }";
    let lamp = "light = [{ type = \"directional\", from = [0, 1, 0], intensity = 1, angle = 12 }]\n";
    let m = mean(256, &format!("{down}{lamp}object = [{mirror}]\n"));
    // Turned by a, it shows 2a: ±3 degrees of ±9.
    let radiance = 1.0 / (std::f64::consts::PI * 6f64.to_radians().sin().powi(2));
    m.is_grey(radiance / 3.0, 0.02);
}

#[test]
fn groups_move_with_what_is_in_them_and_all_bytes_stay() {
    let text = "camera = { position = [0, 3, 9], look_at = [0, 0, 0] }\nintegrator.type = \"path\"\n\
        film = { width = 30, height = 20, antialias = \"monte-carlo\", samples = 8 }\nlight = [{ type = \"sky\" }]\n\
        object = [{ type = \"instance\", group = \"two\", motion = { rotate = [0, 80, 0], translate = [0, 1, 0] } }, { type = \"plane\", normal = [0, 1, 0], point = [0, -1, 0] }]\n\
        [[group.two.object]]\ntype = \"sphere\"\ncenter = [2, 0, 0]\n\
        [[group.two.object]]\ntype = \"box\"\nsize = [1, 1, 1]\nmotion = { rotate = [90, 0, 0] }\nmaterial = { type = \"principled\", emission_luminance = 2 }\n";
    let desc = describe(text);
    let (first, stats) = render_with(&desc, 1, u32::MAX);
    for (threads, pass) in [(2, u32::MAX), (5, 3)] {
        let (again, counted) = render_with(&desc, threads, pass);
        assert!(first.linear == again.linear && stats == counted);
    }
    let still = render(&text.replace("motion", "transform")).0;
    assert!(first.linear != still.linear);
}

#[test]
fn motions_that_cannot_be_are_errors() {
    let prepare = |film: &str, motion: &str| {
        let text =
            format!("film = {{ {film} }}\nobject = [{{ type = \"sphere\", motion = {{ {motion} }} }}]\n");
        describe(&text).prepare(&Default::default()).err().map(|e| e.code.as_str())
    };
    assert_eq!(prepare("shutter = [0.1, 0.9]", "scale = [2, 2, 2]"), None);
    assert_eq!(prepare("", "scale = [-1, 1, 1]"), Some("E0301"));
    assert_eq!(prepare("shutter = [0.6, 0.5]", "translate = [1, 0, 0]"), Some("E0107"));
}
