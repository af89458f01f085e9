//! Pictures whose pixels are known by formula.

use turner::film::Picture;

use crate::classic::common::{describe, pixel, render, render_with};

/// One pixel of a scene.
fn one_pixel(text: &str) -> [f32; 3] {
    let picture = render(&format!("film = {{ width = 1, height = 1 }}\n{text}")).0;
    pixel(&picture, 0, 0)
}

fn close(got: [f32; 3], expected: [f64; 3], tolerance: f64) {
    for (g, e) in got.iter().zip(expected) {
        assert!((f64::from(*g) - e).abs() <= tolerance, "{got:?} and {expected:?}");
    }
}

#[test]
fn lambert_and_phong_at_a_point() {
    // The camera looks straight down at the origin of a plane; the light stands 60 degrees from its normal.
    let scene = |material: &str, light: &str| {
        one_pixel(&format!(
            "camera = {{ position = [0, 4, 0], look_at = [0, 0, 0], up = [0, 0, -1], fov = 0.001 }}\n\
             light = [{{ type = \"point\", position = [1.7320508075688772, 1, 0]{light} }}]\n\
             object = [{{ type = \"plane\", material = {{ color = [0.8, 0.4, 0.2], {material} }} }}]"
        ))
    };
    // N·L = cos 60° = 1/2.
    close(scene("kd = 1", ""), [0.4, 0.2, 0.1], 1e-6);
    // R·V = cos 60° too: (1/2)^3 = 1/8 on every channel.
    close(scene("kd = 0, ks = 1, shininess = 3", ""), [0.125; 3], 1e-6);
    // A non-whole exponent.
    close(scene("kd = 0, ks = 1, shininess = 2.5", ""), [0.5f64.powf(2.5); 3], 1e-6);
    // The distance is 2: a quarter of the light.
    close(scene("kd = 1", ", attenuation = \"inverse-square\""), [0.1, 0.05, 0.025], 1e-6);
    close(scene("kd = 1", ", attenuation = [1, 0.5, 0.5]"), [0.1, 0.05, 0.025], 1e-6);
}

#[test]
fn spot_light_rim_and_ambient() {
    let scene = |x: f64| {
        one_pixel(&format!(
            "camera = {{ position = [{x}, 4, 0], look_at = [{x}, 0, 0], up = [0, 0, -1], fov = 0.001 }}\n\
             light = [{{ type = \"ambient\", intensity = 0.25 }}, {{ type = \"spot\", position = [0, 1, 0], look_at = [0, 0, 0], angle = 45, penumbra = 0, intensity = 0.5 }}]\n\
             object = [{{ type = \"plane\", material = {{ color = 1, ka = 0.5 }} }}]"
        ))
    };
    close(scene(0.0), [0.125 + 0.5; 3], 1e-6);
    close(scene(0.99), [0.125 + 0.5 / (1.0 + 0.99f64 * 0.99).sqrt(); 3], 1e-6);
    close(scene(1.01), [0.125; 3], 1e-6);
}

#[test]
fn facing_mirrors_show_exactly_max_depth_images() {
    // Two mirrors of brightness 1: one for the mirror the camera sees and one for each image in it.
    for depth in [0, 1, 2, 5, 20, 1000] {
        let got = one_pixel(&format!(
            "camera = {{ position = [0, 0, 0], look_at = [0, 0, -1] }}\n\
             integrator = {{ max_depth = {depth}, at_depth = \"black\", combine = \"add\" }}\n\
             light = [{{ type = \"ambient\", intensity = 1 }}]\n\
             object = [{{ type = \"plane\", point = [0, 0, -2], normal = [0, 0, 1], material = \"mirror\" }}, {{ type = \"plane\", point = [0, 0, 2], normal = [0, 0, -1], material = \"mirror\" }}]\n\
             material.mirror = {{ color = 1, kd = 0, k_reflect = 1 }}"
        ));
        close(got, [f64::from(depth) + 1.0; 3], 0.0);
    }
}

#[test]
fn a_glass_slab_shifts_a_ray_by_the_textbook_amount() {
    // Incidence 40 degrees on a slab 1 thick: the shift is sin(i − t) / cos(t).
    let i = 40f64.to_radians();
    let t = (i.sin() / 1.5).asin();
    let shift = (i - t).sin() / t.cos();
    let (dx, dz) = (i.sin(), -i.cos());
    let hit = |extra: f64| {
        // The undisturbed ray goes through the origin; perpendicular to it, in the plane of incidence, lies (dz, −dx).
        let s = shift + extra;
        let (x, z) = (dx * 5.0 + dz * s, dz * 5.0 - dx * s);
        one_pixel(&format!(
            "camera = {{ position = [{}, 0, {}], look_at = [0, 0, 0], fov = 1e-6 }}\n\
             light = [{{ type = \"ambient\", intensity = 1 }}]\n\
             object = [{{ type = \"box\", min = [-50, -50, -2], max = [50, 50, -1], material = {{ kd = 0, ka = 0, k_refract = 1, ior = 1.5 }} }},\n\
             {{ type = \"sphere\", center = [{x}, 0, {z}], radius = 0.001, material = {{ color = [0, 1, 0] }} }}]",
            -dx * 5.0,
            -dz * 5.0
        ))
    };
    close(hit(0.0), [0.0, 1.0, 0.0], 0.0);
    close(hit(0.0009), [0.0, 1.0, 0.0], 0.0);
    close(hit(0.0011), [0.0; 3], 0.0);
    close(hit(-0.0011), [0.0; 3], 0.0);
}

#[test]
fn the_ray_tree_has_at_most_two_to_the_depth_leaves() {
    for depth in 0..7u32 {
        let (picture, stats) = render(&format!(
            "film = {{ width = 24, height = 24 }}\ncamera = {{ position = [0, 0, 4], look_at = [0, 0, 0] }}\n\
             integrator = {{ max_depth = {depth} }}\nbackground = {{ color = 1 }}\n\
             object = [{{ type = \"sphere\", material = {{ kd = 0, k_reflect = 0.5, k_refract = 0.5 }} }}]"
        ));
        let most = stats.camera * ((2u64 << depth) - 2);
        assert!(stats.reflected + stats.refracted <= most);
        assert!(depth == 0 || stats.refracted > 0);
        // Glass without loss before a white background is white.
        assert!(picture.linear.iter().all(|p| (p[0] - 1.0).abs() < 1e-5));
    }
}

#[test]
fn total_internal_reflection_loses_nothing() {
    // From inside a dense sphere, looking past the critical angle.
    for fresnel in ["off", "schlick", "exact"] {
        let got = one_pixel(&format!(
            "camera = {{ position = [0, 0.95, 0], look_at = [1, 0.95, 0], fov = 1 }}\nbackground = {{ color = 1 }}\n\
             integrator = {{ max_depth = 50, at_depth = \"background\" }}\n\
             object = [{{ type = \"sphere\", material = {{ kd = 0, ka = 0, k_reflect = {}, k_refract = 1, ior = 2, fresnel = \"{fresnel}\" }} }}]",
            if fresnel == "off" { 0 } else { 1 }
        ));
        close(got, [1.0; 3], 1e-5);
    }
}

#[test]
fn a_tinted_shadow_has_the_colour_of_its_glass() {
    let got = one_pixel(
        "camera = { position = [0, 0.1, 3], look_at = [0, 0, 0], fov = 0.01 }\n\
         light = [{ type = \"directional\", from = [0, 1, 0] }]\n\
         object = [{ type = \"plane\", material = { color = 1 } },\n\
         { type = \"sphere\", center = [0, 2, 0], radius = 0.5, material = { color = [1, 0.5, 0], k_refract = 0.8, shadow = \"tinted\" } }]",
    );
    // In and out: (0.8·colour)².
    close(got, [0.64, 0.16, 0.0], 1e-6);
}

#[test]
fn a_soft_shadow_is_the_visible_share_of_the_light() {
    // Half of a rectangle light is hidden by a wall's edge.
    let got = one_pixel(
        "camera = { position = [0, 1, 0], look_at = [0, 0, 0], up = [0, 0, -1], fov = 0.001 }\n\
         light = [{ type = \"rectangle\", center = [0, 1000, 0], edge_u = [2, 0, 0], edge_v = [0, 0, 2], samples = 64 }]\n\
         object = [{ type = \"plane\", material = { color = 1 } },\n\
         { type = \"rectangle\", center = [5, 500, 0], edge_u = [10, 0, 0], edge_v = [0, 0, 20] }]",
    );
    close(got, [0.5; 3], 1e-5);
}

#[test]
fn the_papers_shadow_reduces_light_by_a_factor() {
    let got = one_pixel(
        "camera = { position = [0, 0.1, 3], look_at = [0, 0, 0], fov = 0.01 }\nintegrator = { shadow_factor = 0.3 }\n\
         light = [{ type = \"directional\", from = [0, 1, 0] }]\n\
         object = [{ type = \"plane\", material = { color = 1 } }, { type = \"sphere\", center = [0, 2, 0], radius = 0.5 }]",
    );
    close(got, [0.3; 3], 1e-6);
}

#[test]
fn effects_are_switched_one_by_one() {
    let scene = |off: &str| {
        one_pixel(&format!(
            "camera = {{ position = [0, 4, 0], look_at = [0, 0, 0], up = [0, 0, -1], fov = 0.001 }}\n\
             integrator = {{ {off} }}\nbackground = {{ color = [0, 0, 1] }}\n\
             light = [{{ type = \"ambient\", intensity = 0.5 }}, {{ type = \"directional\", from = [0, 1, 0], intensity = 0.25 }}]\n\
             object = [{{ type = \"plane\", material = {{ color = [1, 0, 0], ks = 0.5, k_reflect = 0.5 }} }}, {{ type = \"disk\", center = [0, 100, 0], normal = [0, -1, 0], material = {{ color = [0, 0, 0], ka = 0, shadow = \"opaque\" }} }}]"
        ))
    };
    // In shadow, ambient alone and the black disk in the mirror.
    close(scene(""), [0.25, 0.0, 0.0], 1e-6);
    close(scene("shadows = false"), [0.5 * (0.5 + 0.25 + 0.125), 0.0625, 0.0625], 1e-6);
    close(scene("shadows = false, highlights = false"), [0.375, 0.0, 0.0], 1e-6);
    close(scene("shadows = false, diffuse = false"), [0.5 * (0.5 + 0.125), 0.0625, 0.0625], 1e-6);
    close(scene("shadows = false, ambient = false, highlights = false"), [0.125, 0.0, 0.0], 1e-6);
    close(scene("reflection = false"), [0.5, 0.0, 0.0], 1e-6);
}

/// A scene with everything small enough to scale.
fn scaled(k: f64) -> String {
    let s = |v: f64| v * k;
    format!(
        "film = {{ width = 64, height = 48 }}\nbackground = {{ color = [0.2, 0.3, 0.4] }}\n\
         camera = {{ position = [0, {}, {}], look_at = [0, {}, 0] }}\n\
         light = [{{ type = \"ambient\", intensity = 0.2 }}, {{ type = \"point\", position = [{}, {}, {}], intensity = 0.8 }}]\n\
         object = [{{ type = \"sphere\", center = [0, {}, 0], radius = {}, material = {{ color = \"khaki\", k_reflect = 0.2 }} }},\n\
         {{ type = \"sphere\", center = [0, {}, 0], radius = {}, material = {{ color = \"tomato\", ks = 0.5, k_reflect = 0.3 }} }},\n\
         {{ type = \"sphere\", center = [{}, {}, {}], radius = {}, material = {{ kd = 0.1, k_reflect = 0.1, k_refract = 0.8 }} }},\n\
         {{ type = \"torus\", center = [{}, {}, 0], axis = [1, 2, 2], radius = {}, tube_radius = {}, material = {{ color = \"teal\" }} }}]",
        s(2.0),
        s(6.0),
        s(1.0),
        s(3.0),
        s(5.0),
        s(4.0),
        s(-5000.0),
        s(5000.0),
        s(1.0),
        s(1.0),
        s(1.5),
        s(0.7),
        s(1.0),
        s(0.7),
        s(-2.0),
        s(1.0),
        s(0.7),
        s(0.3)
    )
}

fn different(a: &Picture, b: &Picture) -> usize {
    a.display
        .iter()
        .zip(&b.display)
        .filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 1))
        .count()
}

#[test]
fn the_scale_of_a_scene_does_not_matter() {
    let one = render(&scaled(1.0)).0;
    for k in [1e-6, 1e-4, 1e5, 1e7] {
        let other = render(&scaled(k)).0;
        assert!(different(&one, &other) <= 64 * 48 / 200, "scale {k}: {} pixels", different(&one, &other));
    }
    // Scaled by a power of two all arithmetic is the same, bit for bit.
    assert_eq!(one.linear, render(&scaled(1024.0)).0.linear);
}

#[test]
fn bytes_do_not_depend_on_threads_or_passes() {
    for antialias in ["none", "mean", "grid", "adaptive", "monte-carlo"] {
        let text = scaled(1.0).replace("height = 48", &format!("height = 48, antialias = \"{antialias}\", samples = 9"))
            .replacen("light = [", "light = [{ type = \"sphere\", center = [-4, 6, 2], radius = 1, samples = 4, intensity = 0.3 }, ", 1);
        let desc = describe(&text);
        let first = render_with(&desc, 1, u32::MAX).0;
        for (threads, pass) in [(2, 1), (7, 4), (16, 2)] {
            assert_eq!(
                first.linear,
                render_with(&desc, threads, pass).0.linear,
                "{antialias}, {threads} threads"
            );
        }
    }
}

#[test]
fn a_crop_is_a_part_of_the_picture() {
    for antialias in ["none", "mean", "grid", "adaptive", "monte-carlo"] {
        let text = scaled(1.0)
            .replace("height = 48", &format!("height = 48, antialias = \"{antialias}\", samples = 4"));
        let mut desc = describe(&text);
        let full = render_with(&desc, 2, 8).0;
        desc.film.crop = Some([13, 7, 30, 25]);
        let part = render_with(&desc, 2, 8).0;
        for y in 0..25 {
            for x in 0..30 {
                assert_eq!(pixel(&part, x, y), pixel(&full, x + 13, y + 7), "{antialias} at {x}, {y}");
            }
        }
    }
}

/// A handful of shapes is searched one by one, some dozens by a sieve, more by a tree: the picture is the same.
#[test]
fn the_way_of_searching_does_not_show() {
    let scene = |hidden: usize| {
        let mut text = scaled(1.0).replacen(
            "object = [",
            "object = [{ type = \"plane\", point = [0, -0.5, 0], material = { color = \"gray\", k_reflect = 0.3 } }, ",
            1,
        );
        // Below an endless floor nothing is seen, mirrored or shaded.
        let below: String = (0..hidden)
            .map(|i| {
                format!(", {{ type = \"sphere\", center = [{}, -3, {}], radius = 0.2 }}", i % 17, i / 17)
            })
            .collect();
        text.truncate(text.rfind(']').unwrap());
        render(&(text + &below + "]")).0
    };
    let few = scene(0);
    for hidden in [1, 20, 70, 500] {
        assert_eq!(few.linear, scene(hidden).linear, "{hidden} hidden shapes");
    }
}

/// A tree of rays that would never end is cut, and counted.
#[test]
fn a_thousand_generations_of_glass_end() {
    let (_, stats) = render(
        "film = { width = 4, height = 4 }\ncamera = { position = [0, 0, 4], look_at = [0, 0, 0] }\n\
         integrator = { max_depth = 1000 }\nbackground = { color = 1 }\n\
         object = [{ type = \"sphere\", material = \"glass\" }, { type = \"sphere\", radius = 0.8, material = \"glass\" }, { type = \"sphere\", radius = 0.6, material = \"glass\" }]\n\
         material.glass = { kd = 0, k_reflect = 0.5, k_refract = 0.5 }",
    );
    assert!(stats.dropped > 0 && stats.dropped <= 16);
    assert!(stats.total() < 16 * 17_000);
}
