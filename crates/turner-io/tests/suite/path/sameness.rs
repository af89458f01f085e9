//! The same picture, to the last bit, for any number of threads, passes and brightness.

use crate::classic::common::{describe, pixel, render, render_with};

const SCENE: &str = r#"
camera = { type = "thin-lens", position = [0, 1, 4], look_at = [0, 0.5, 0], fov = 40, focus = 4, lens_radius = 0.05 }
integrator = { type = "path", max_depth = 6 }
[film]
width = 50
height = 37
antialias = "monte-carlo"
samples = 6
[material.glass]
type = "principled"
transmission_weight = 1
specular_roughness = 0.1
[material.sheet]
type = "principled"
alpha_mode = "blend"
opacity = 0.5
double_sided = false
[material.lamp]
type = "principled"
emission_luminance = BRIGHT
[[light]]
type = "point"
position = [2, 3, 2]
intensity = BRIGHT
attenuation = "inverse-square"
[[object]]
type = "plane"
material = { type = "principled", base_color = { type = "chessboard" } }
[[object]]
type = "sphere"
center = [0, 0.5, 0]
radius = 0.5
material = "glass"
[[object]]
type = "rectangle"
center = [-0.5, 0.8, 0.7]
edge_u = [1, 0, 0]
edge_v = [0, 1, 0.2]
material = "sheet"
[[object]]
type = "sphere"
center = [1, 1.5, -1]
radius = 0.3
material = "lamp"
"#;

#[test]
fn any_number_of_threads_and_any_split_into_passes() {
    let desc = describe(&SCENE.replace("BRIGHT", "4"));
    let (first, stats) = render_with(&desc, 1, u32::MAX);
    for (threads, pass) in [(2, u32::MAX), (7, 1), (2, 4), (1, 5)] {
        let (again, counted) = render_with(&desc, threads, pass);
        assert!(first.linear == again.linear, "{threads} threads, passes of {pass}");
        assert_eq!(stats, counted);
    }
    // Something is seen.
    assert!(first.linear.iter().any(|p| p[0] > 0.1));
}

/// A part of the picture is the same as in the whole: no sample looks at its neighbours.
#[test]
fn a_crop_is_a_part_of_the_whole() {
    let text = SCENE.replace("BRIGHT", "4");
    let whole = render(&text).0;
    let part = render(&text.replace("samples = 6", "samples = 6\ncrop = [13, 9, 11, 7]")).0;
    for y in 0..7 {
        for x in 0..11 {
            assert_eq!(pixel(&part, x, y), pixel(&whole, x + 13, y + 9), "{x}, {y}");
        }
    }
}

#[test]
fn twice_the_light_is_twice_the_picture() {
    // A path's end does not depend on light, and powers of two are exact.
    let one = render(&SCENE.replace("BRIGHT", "4")).0;
    let two = render(&SCENE.replace("BRIGHT", "8")).0;
    for (a, b) in one.linear.iter().zip(&two.linear) {
        for i in 0..3 {
            // The film's sums have a smallest step.
            assert!((2.0 * a[i] - b[i]).abs() <= 1e-6 * b[i].abs() + 1e-13, "{a:?} {b:?}");
        }
    }
}
