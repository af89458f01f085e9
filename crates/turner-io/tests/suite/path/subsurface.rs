//! Translucent bodies: albedos known by formula, bodies beside the media that they are made of, and one estimator against another.

use turner::color::Spectrum;
use turner::medium::scattering_albedo;

use crate::classic::common::{describe, render_with};
use crate::path::statistics::{mean, mean_of};

/// Looks at the origin from 10 above it, a little aside.
const DOWN: &str = "camera = { position = [1, 10, 0.5], look_at = [0, 0, 0], fov = 5 }\n";
const ASIDE: &str = "camera = { position = [0, 0, 4], look_at = [0, 0, 0], fov = 20 }\n";
const WHITE: &str = "background.color = 1\n";

fn path(more: &str) -> String {
    format!("integrator = {{ type = \"path\", max_depth = 1000, rr_start = 1000, {more} }}\n")
}

fn wax(more: &str) -> String {
    format!("{{ type = \"principled\", specular_weight = 0, subsurface_weight = 1, {more} }}")
}

/// Where everything shines with 1 and nothing absorbs, everything is 1.
#[test]
fn a_white_body_returns_all_light() {
    let mesh = "type = \"mesh\", positions = [[-1, -1, -1], [1, -1, -1], [0, -1, 1], [0, 1, 0]], triangles = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]";
    let twice = "transform = [{ scale = [1, 2, 0.5] }, { rotate = [20, 30, 40] }]";
    let layers =
        "type = \"principled\", subsurface_weight = 1, subsurface_color = 1, subsurface_radius = 0.1";
    for (object, tolerance) in [
        (
            format!("type = \"sphere\", material = {}", wax("subsurface_color = 1, subsurface_radius = 0.2")),
            1e-3,
        ),
        (
            format!(
                "type = \"box\", min = [-0.5, -0.5, -0.5], max = [0.5, 0.5, 0.5], transform = {{ rotate = [10, 20, 30] }}, material = {}",
                wax("subsurface_color = 1, subsurface_radius_scale = 1, subsurface_scatter_anisotropy = 0.8")
            ),
            1e-3,
        ),
        (
            format!("{mesh}, {twice}, material = {}", wax("subsurface_color = 1, subsurface_radius = 0.1")),
            1e-3,
        ),
        // Under layers as much as any diffuse body: what these lose of their own is 1e-3 at most.
        (format!("type = \"sphere\", material = {{ {layers} }}"), 2e-3),
        (
            format!(
                "type = \"sphere\", material = {{ {layers}, coat_weight = 1, specular_roughness = 0.1 }}"
            ),
            2e-3,
        ),
    ] {
        let m = mean(512, &format!("{}{ASIDE}{WHITE}object = [{{ {object} }}]\n", path("")));
        for (v, e) in m.value().into_iter().zip(m.error()) {
            assert!(e < 4e-3, "{object}: {m:?}");
            assert!((v - 1.0).abs() < tolerance + 4.0 * e, "{object}: {:?} ± {:?}", m.value(), m.error());
        }
    }
}

/// Half of space, under light from all around, has the colour that was asked for.
#[test]
fn a_thick_body_has_its_colour() {
    for (g, tolerance) in [(0.0, 0.003), (0.5, 0.003), (0.9, 0.003), (-0.5, 0.012)] {
        for (color, radius) in [([0.9, 0.5, 0.2], 1.0), ([0.05, 0.3, 0.7], 0.01)] {
            let body = wax(&format!(
                "subsurface_color = {color:?}, subsurface_radius = {radius}, subsurface_scatter_anisotropy = {g}"
            ));
            let scene =
                format!("{}{DOWN}{WHITE}object = [{{ type = \"plane\", material = {body} }}]\n", path(""));
            let m = mean(256, &scene);
            for (band, (v, e)) in m.value().into_iter().zip(m.error()).enumerate() {
                assert!(e < 5e-3, "{m:?}");
                let slack = tolerance + 4.0 * e;
                assert!(
                    (v - color[band]).abs() < slack,
                    "g {g}, {color:?}: {:?} ± {:?}",
                    m.value(),
                    m.error()
                );
            }
        }
    }
}

/// What is not scattered: the mean over chords 2Rµ of a sphere, which light enters by the law of cosines.
#[test]
fn what_goes_straight_through_is_that_of_the_mean_ways() {
    let body = wax("subsurface_color = 1e-5, subsurface_radius = 0.8");
    let m = mean(
        1024,
        &format!("{}{ASIDE}{WHITE}object = [{{ type = \"sphere\", material = {body} }}]\n", path("")),
    );
    let expected = [0.8, 0.4, 0.2].map(|way: f64| {
        let a = 2.0 / way;
        2.0 * (1.0 - (1.0 + a) * (-a).exp()) / (a * a)
    });
    for (band, (v, e)) in m.value().into_iter().zip(m.error()).enumerate() {
        assert!(e < 0.01 * expected[band] + 1e-3, "{m:?}");
        assert!(
            (v - expected[band]).abs() < 2e-4 + 4.0 * e,
            "{:?} ± {:?}, not {expected:?}",
            m.value(),
            m.error()
        );
    }
}

/// Seen by parallel rays, a sphere of the medium is entered by the law of cosines, as the body is: on average over the disc they are the same.
#[test]
fn a_body_is_as_bright_as_a_sphere_of_its_medium() {
    let (color, g) = ([0.9, 0.6, 0.3], 0.4);
    let ways = [0.5, 0.25, 0.125];
    let albedo = color.map(|c| scattering_albedo(c, g));
    let scattering: Vec<f64> = albedo.iter().zip(ways).map(|(a, way)| a / way).collect();
    let absorption: Vec<f64> = albedo.iter().zip(ways).map(|(a, way)| (1.0 - a) / way).collect();
    let view =
        "camera = { type = \"orthographic\", position = [0, 0, 4], look_at = [0, 0, 0], viewport = 2 }\n";
    let scene = |what: &str| format!("{}{view}{WHITE}object = [{{ type = \"sphere\", {what} }}]\n", path(""));
    let body = mean_of(
        16,
        128,
        &scene(&format!(
            "material = {}",
            wax(&format!(
                "subsurface_color = {color:?}, subsurface_radius = 0.5, subsurface_scatter_anisotropy = {g}"
            ))
        )),
    );
    let medium = mean_of(
        16,
        128,
        &scene(&format!(
            "medium = {{ scattering = {scattering:?}, absorption = {absorption:?}, anisotropy = {g} }}"
        )),
    );
    for band in 0..3 {
        let (a, b) = (body.value()[band], medium.value()[band]);
        let error = body.error()[band].hypot(medium.error()[band]);
        assert!(error < 3e-3 && (a - b).abs() < 4.0 * error + 1e-4, "band {band}: {a} and {b} ± {error}");
    }
}

const LIT: &str = "light = [{ type = \"point\", position = [2, 3, 2], intensity = 20, attenuation = \"inverse-square\" }]\n";

/// The same, ten times as large, with light from a lamp and an environment.
#[test]
fn lengths_are_those_of_the_scene() {
    let scene = |k: f64, radius: f64| {
        format!(
            "{}camera = {{ position = [0, 0, {}], look_at = [0, 0, 0], fov = 30 }}\nbackground.color = [0.1, 0.2, 0.3]\n\
             light = [{{ type = \"point\", position = [{}, {}, {}], intensity = {}, attenuation = \"inverse-square\" }}]\n\
             object = [{{ type = \"sphere\", radius = {k}, material = {} }}]\n",
            path(""),
            4.0 * k,
            2.0 * k,
            3.0 * k,
            2.0 * k,
            20.0 * k * k,
            wax(&format!("subsurface_radius = {radius}"))
        )
    };
    let one = mean_of(8, 256, &scene(1.0, 0.2));
    one.agrees(&mean_of(8, 256, &scene(10.0, 2.0)), 0.03);
    // With another mean way less comes out on this side.
    let (a, b) = (one.value()[0], mean_of(8, 64, &scene(1.0, 1.0)).value()[0]);
    assert!(b < 0.97 * a, "{a} {b}");
}

/// Lights are sampled where walks come out, found by chance after that, or both.
#[test]
fn ways_to_find_lights_agree() {
    let scene = |how: &str| {
        format!(
            "{}{ASIDE}object = [{{ type = \"sphere\", material = {} }}, {{ type = \"plane\", point = [0, -1, 0], material = {{ type = \"matte\" }} }},\n\
             {{ type = \"sphere\", center = [2, 2, 1], radius = 0.7, material = {{ type = \"emissive\", strength = 5 }} }}]\n",
            path(how).replace("max_depth = 1000", "max_depth = 4"),
            wax("subsurface_radius = 0.2, coat_weight = 0.5, coat_roughness = 0.3")
        )
    };
    let [both, bsdf, light] =
        ["light_sampling = \"both\"", "light_sampling = \"bsdf\"", "light_sampling = \"light\""]
            .map(|how| mean_of(8, 256, &scene(how)));
    both.agrees(&bsdf, 0.03);
    both.agrees(&light, 0.03);
}

/// A box within another one is one body with it; boundaries of media and glass within change nothing.
#[test]
fn bodies_that_overlap_are_one() {
    let scene = |objects: &str| {
        format!(
            "{}camera = {{ position = [1, 2, 5], look_at = [0, 0, 0], fov = 25 }}\nbackground.color = [0.1, 0.2, 0.3]\n{LIT}material.wax = {}\nobject = [{objects}]\n",
            path(""),
            wax("subsurface_radius = 0.5")
        )
    };
    let one = mean_of(
        8,
        256,
        &scene("{ type = \"box\", min = [-1, -1, -1], max = [1, 1, 1], material = \"wax\" }"),
    );
    for parts in [
        "{ type = \"box\", min = [-0.9, -0.5, -0.3], max = [0.3, 0.9, 0.8], material = \"wax\" }, { type = \"box\", min = [-1, -1, -1], max = [1, 1, 1], material = \"wax\" }",
        "{ type = \"box\", min = [-1, -1, -1], max = [1, 1, 1], material = \"wax\" }, { type = \"sphere\", radius = 0.8, material = { type = \"boundary\" } }, \
         { type = \"sphere\", center = [0.3, 0, 0], radius = 0.6, material = { type = \"dielectric\" } }",
    ] {
        one.agrees(&mean_of(8, 256, &scene(parts)), 0.03);
    }
}

/// Without a mean way it is the diffuse surface of its colour; in a thin wall light goes through.
#[test]
fn limits_are_diffuse() {
    let scene = |material: &str| {
        format!(
            "{}{ASIDE}{LIT}object = [{{ type = \"sphere\", material = {{ type = \"principled\", {material} }} }}]\n",
            path("")
        )
    };
    let picture = |material: &str| {
        let film = "film = { width = 16, height = 16, antialias = \"monte-carlo\", samples = 4 }\n";
        render_with(&describe(&(film.to_owned() + &scene(material))), 1, u32::MAX).0.linear
    };
    let diffuse = picture("base_color = [0.9, 0.5, 0.2]");
    assert!(
        diffuse
            == picture("subsurface_weight = 1, subsurface_color = [0.9, 0.5, 0.2], subsurface_radius = 0")
    );
    // A short way is nearly that.
    let near = mean_of(
        8,
        256,
        &scene("subsurface_weight = 1, subsurface_color = [0.9, 0.5, 0.2], subsurface_radius = 0.002"),
    );
    let flat = mean_of(8, 64, &scene("base_color = [0.9, 0.5, 0.2]"));
    for band in 0..3 {
        let (a, b) = (near.value()[band], flat.value()[band]);
        assert!((a - b).abs() < 0.01 * b + 4.0 * near.error()[band], "{:?} {:?}", near.value(), flat.value());
    }
}

const SCENE: &str = r#"
camera = { position = [0, 1.2, 5], look_at = [0, 0.8, 0], fov = 40 }
integrator = { type = "path", max_depth = 8 }
film = { width = 37, height = 29, antialias = "monte-carlo", samples = 6 }
background = { medium = { extinction = 0.05, albedo = 0.8 } }
light = [{ type = "point", position = [2, 3, 1], intensity = 20, attenuation = "inverse-square" }]
[[object]]
type = "plane"
material = { type = "matte" }
[[object]]
type = "sphere"
center = [0, 1, 0]
motion = { translate = [0.3, 0, 0] }
material = { type = "principled", subsurface_weight = 1, subsurface_radius = 0.3 }
[[object]]
type = "sphere"
center = [-1.5, 0.6, 0.5]
radius = 0.6
material = { type = "principled", subsurface_weight = 0.5, subsurface_color = { type = "marble" }, subsurface_scatter_anisotropy = 0.7 }
[[object]]
type = "sphere"
center = [1.5, 0.5, 1]
radius = 0.5
material = { type = "dielectric" }
"#;

#[test]
fn threads_and_passes_change_nothing() {
    for integrator in ["\"path\", max_depth = 8", "\"direct\""] {
        let desc = describe(&SCENE.replace("\"path\", max_depth = 8", integrator));
        let (reference, _) = render_with(&desc, 1, u32::MAX);
        assert!(reference.linear.iter().any(|p| p[0] > 0.0));
        for (threads, pass) in [(2, u32::MAX), (3, 1), (1, 4)] {
            let again = render_with(&desc, threads, pass).0;
            assert!(
                again.linear == reference.linear,
                "{integrator}: {threads} threads, {pass} samples a pass"
            );
        }
    }
}

/// Light paths bring what they can to the surface of a body; what goes through it camera paths find by themselves.
#[test]
fn light_paths_leave_bodies_to_camera_paths() {
    let scene = |caustics: &str| {
        format!(
            "{}camera = {{ position = [0, 2, 4], look_at = [0, 0, 0], fov = 30 }}\n\
             object = [{{ type = \"box\", min = [-1, -1, -1], max = [1, 0, 1], material = {} }},\n\
             {{ type = \"sphere\", center = [0, 0.8, 0], radius = 0.5, material = {{ type = \"dielectric\", roughness = 0.3 }} }},\n\
             {{ type = \"sphere\", center = [0, 3, 0], radius = 0.8, material = {{ type = \"emissive\", strength = 5 }} }}]\n",
            path(&format!("caustics = \"{caustics}\"")).replace("max_depth = 1000", "max_depth = 6"),
            wax("subsurface_radius = 0.1")
        )
    };
    let off = mean_of(8, 512, &scene("off"));
    off.agrees(&mean_of(8, 512, &scene("light-tracing")), 0.05);
}

#[test]
fn white_and_black_are_what_they_are() {
    assert_eq!(Spectrum::WHITE.to_array().map(|c| scattering_albedo(f64::from(c), 0.5)), [1.0; 3]);
    assert!(scattering_albedo(0.0, 0.5).abs() < 1e-4);
}
