//! What of the picture counts for a pixel, and where it looks.

use turner::schema::PrepareOptions;

use crate::classic::common::{describe, pixel, render};

/// Pixels of one unit, seen straight from above; everything to the right of the picture's middle shines.
fn edge(filter: &str, integrator: &str) -> Vec<f64> {
    let surface = "type = \"rectangle\", center = [50, 0, 0], edge_u = [100, 0, 0], edge_v = [0, 0, -100]";
    let text = format!(
        "camera = {{ type = \"orthographic\", position = [0, 1, 0], look_at = [0, 0, 0], up = [0, 0, -1], viewport = [12, 4] }}\n\
         film = {{ width = 12, height = 4, antialias = \"monte-carlo\", samples = 4096, {filter} }}\n\
         integrator = {{ type = \"{integrator}\" }}\n\
         light = [{{ type = \"ambient\", intensity = 1 }}]\n\
         object = [{{ {surface}, material = {{ MATERIAL }} }}]\n"
    );
    let physical = "type = \"principled\", base_weight = 0, specular_weight = 0, emission_luminance = 1";
    let text = match integrator {
        "classic" => text.replace("MATERIAL", "color = 1, ka = 1, kd = 0"),
        _ => text.replace("MATERIAL", physical),
    };
    let picture = render(&text).0;
    (0..12).map(|x| f64::from(pixel(&picture, x, 1)[0])).collect()
}

/// The share of the filter f, even and 0 beyond r, that lies beyond `from`, by Simpson's rule.
fn share(f: impl Fn(f64) -> f64, r: f64, from: f64) -> f64 {
    let integral = |from: f64, to: f64| {
        let (n, h) = (2000, (to - from) / 2000.0);
        let inner: f64 = (1..n).map(|i| f(from + h * f64::from(i)) * f64::from(2 + 2 * (i % 2))).sum();
        (f(from) + f(to) + inner) * h / 3.0
    };
    integral(from.clamp(-r, r), r) / integral(-r, r)
}

#[test]
fn an_edge_shows_the_filter() {
    use std::f64::consts::PI;
    type Profile = fn(f64) -> f64;
    let blackman = |x: f64| {
        let c = |n: f64| (n * PI * x / 1.5).cos();
        0.35875 + 0.48829 * c(1.0) + 0.14128 * c(2.0) + 0.01168 * c(3.0)
    };
    let cases: [(&str, f64, Profile); 6] = [
        ("", 0.5, |_| 1.0),
        ("filter = \"box\", filter_radius = 2.25", 2.25, |_| 1.0),
        ("filter = \"tent\"", 1.0, |x| 1.0 - x.abs()),
        ("filter = \"gaussian\"", 1.5, |x| (-2.0 * x * x).exp() - (-4.5f64).exp()),
        ("filter = \"gaussian\", filter_radius = 3", 3.0, |x| (-0.5 * x * x).exp() - (-4.5f64).exp()),
        ("filter = \"blackman-harris\"", 1.5, blackman),
    ];
    for (filter, r, f) in cases {
        for (integrator, tolerance) in [("path", 1.5e-3), ("direct", 1.5e-3), ("classic", 8e-3)] {
            for (x, value) in edge(filter, integrator).into_iter().enumerate() {
                // The edge lies so far from the pixel's middle.
                let expected = share(f, r, 5.5 - x as f64);
                assert!(
                    (value - expected).abs() < tolerance,
                    "{integrator} {filter} {x}: {value}, not {expected}"
                );
            }
        }
    }
}

#[test]
fn the_box_is_what_there_is_without_a_filter() {
    for integrator in ["path", "classic"] {
        assert_eq!(edge("", integrator), edge("filter = \"box\", filter_radius = 0.5", integrator));
    }
}

#[test]
fn a_white_picture_stays_white_under_every_filter() {
    for filter in ["box", "tent", "gaussian", "blackman-harris"] {
        let text = format!(
            "background.color = [1, 0.5, 0.25]\nintegrator.type = \"path\"\n\
             film = {{ width = 7, height = 5, antialias = \"monte-carlo\", samples = 7, filter = \"{filter}\", filter_radius = 4 }}\n"
        );
        assert!(render(&text).0.linear.iter().all(|p| *p == [1.0, 0.5, 0.25, 1.0]), "{filter}");
    }
}

/// A panorama taken within an environment is the environment's picture.
#[test]
fn a_panorama_of_the_studio_is_the_studio() {
    let scene = |camera: &str, integrator: &str| {
        format!(
            "camera = {{ type = \"{camera}\", position = [3, 1, 2], look_at = [3, 1, 1] }}\n\
             film = {{ width = 64, height = 32 }}\nintegrator.type = \"{integrator}\"\n\
             light = [{{ type = \"environment\" }}]\n"
        )
    };
    let studio = turner::light::EnvironmentDesc::studio().prepare(&[], false).unwrap();
    for integrator in ["path", "direct", "classic", "normals"] {
        let picture = render(&scene("equirectangular", integrator)).0;
        for (x, y) in (0..32).flat_map(|y| (0..64).map(move |x| (x, y))) {
            let (lon, lat) = ((f64::from(x) - 31.5) / 32.0 * 180.0, (15.5 - f64::from(y)) / 16.0 * 90.0);
            let ((sin, cos), (up, flat)) = (lon.to_radians().sin_cos(), lat.to_radians().sin_cos());
            let expected = studio.radiance(turner::math::DVec3::new(sin * flat, up, -cos * flat));
            let found = pixel(&picture, x, y);
            assert!(
                (found[1] - expected.g).abs() < 1e-5 * (1.0 + expected.g),
                "{x} {y}: {found:?} {expected:?}"
            );
        }
        // A fisheye shows the same in its circle, and black beyond it.
        let picture = render(&scene("fisheye", integrator)).0;
        let front = studio.radiance(turner::math::DVec3::new(0.02, 0.02, -1.0));
        assert!((pixel(&picture, 32, 15)[0] - front.g).abs() < 0.02, "{:?}", pixel(&picture, 32, 15));
        for (x, y) in [(0, 0), (14, 15), (49, 15), (32 + 12, 3)] {
            assert_eq!(pixel(&picture, x, y), [0.0; 3], "{integrator}");
            assert_eq!(picture.linear[(y * 64 + x) as usize][3], 1.0);
        }
    }
    let text = scene("fisheye", "path") + "background.transparent = true\n";
    assert!(render(&text).0.linear.iter().all(|p| p[3] == 0.0));
}

/// Rays that the camera does not have hit nothing, whatever is there.
#[test]
fn nothing_is_hit_beyond_the_circle_of_a_fisheye() {
    let around = |integrator: &str, material: &str| {
        format!(
            "camera = {{ type = \"fisheye\", position = [0, 0, 0], look_at = [0, 0, -1], angle = 360 }}\n\
             film = {{ width = 24, height = 24, antialias = \"monte-carlo\", samples = 2 }}\nintegrator.type = \"{integrator}\"\n\
             object = [{{ type = \"box\", size = [2, 2, 2], material = {{ {material} }} }},\n{}]\nlight = [{{ type = \"point\", position = [0, 0, 0.5] }}]\n",
            "{ type = \"sphere\", center = [0, 0, -0.5], radius = 0.1 },\n".repeat(9)
        )
    };
    for integrator in ["path", "classic", "normals"] {
        let picture = render(&around(integrator, "color = \"white\"")).0;
        assert_eq!(pixel(&picture, 0, 0), [0.0; 3]);
        for (x, y) in [(12, 12), (1, 12), (12, 22)] {
            assert!(pixel(&picture, x, y)[0] > 0.0, "{integrator} {x} {y}");
        }
    }
}

#[test]
fn samples_are_cut_where_the_film_says_so() {
    let scene = |film: &str| {
        format!(
            "camera = {{ type = \"orthographic\", position = [0, 1, 0], look_at = [0, 0, 0], up = [0, 0, -1], viewport = [12, 4] }}\n\
             film = {{ width = 12, height = 4, {film} }}\nintegrator.type = \"path\"\nbackground.color = [1, 2, 3]\n\
             [[object]]\ntype = \"rectangle\"\ncenter = [50.25, 0, 0]\nedge_u = [100, 0, 0]\nedge_v = [0, 0, -100]\n\
             material = {{ type = \"emissive\", color = [1, 0.5, 0], strength = 20 }}\n"
        )
    };
    for antialias in ["none", "mean", "grid", "adaptive", "monte-carlo"] {
        let film = format!("antialias = \"{antialias}\", samples = 64, max_sample");
        let at = |most: f64, x: u32| pixel(&render(&scene(&format!("{film} = {most}"))).0, x, 1);
        assert_eq!(at(0.0, 10), [20.0, 10.0, 0.0], "{antialias}");
        // The background stays as it is: it is not brighter.
        for (x, expected) in [(2, [1.0, 2.0, 3.0]), (10, [4.0, 2.0, 0.0])] {
            assert_eq!(at(4.0, x), expected, "{antialias} {x}");
        }
        // Samples are cut, not the pixel that they make: red is below 4 and above what its mean would be of uncut ones that are cut then.
        let [r, g, b] = at(4.0, 6);
        let lamp = f64::from(r - 1.0) / 3.0;
        let mixed = [1.0 + 3.0 * lamp, 2.0, 3.0 - 3.0 * lamp];
        let found = [r, g, b].map(f64::from);
        assert!(
            found.iter().zip(mixed).all(|(v, e)| (v - e).abs() < 1e-5),
            "{antialias}: {found:?}, {mixed:?}"
        );
        let scene = describe(&scene(&format!("{film} = 4"))).prepare(&PrepareOptions::default()).unwrap();
        let record = turner::render::pixel(&scene, 6, 1).unwrap();
        let sum = |c: fn(&turner::color::Spectrum) -> f32| -> f64 {
            record.samples.iter().map(|s| s.weight * f64::from(c(&s.radiance.color))).sum()
        };
        for (sum, value) in [sum(|c| c.r), sum(|c| c.g), sum(|c| c.b)].into_iter().zip(record.color) {
            assert!((sum - f64::from(value)).abs() < 1e-5, "{antialias}: {sum}, {value}");
        }
    }
}
