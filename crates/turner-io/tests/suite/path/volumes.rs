//! Participating media: radiance known by formula or by quadrature, and one estimator against another.

use std::f64::consts::PI;

use turner::medium::HenyeyGreenstein;
use turner::schema::{ErrorCode, PrepareOptions};

use crate::classic::common::{describe, render_with};
use crate::path::statistics::{mean, mean_of};

/// Looks along −z, from 10 above the origin.
const ALONG: &str = "camera = { position = [0, 0, 10], look_at = [0, 0, 0], fov = 0.001 }\n";
/// A wall that shines with 1 at z = −10.
const WALL: &str = "{ type = \"rectangle\", center = [0, 0, -10], edge_u = [9, 0, 0], edge_v = [0, 9, 0], material = { type = \"emissive\" } }";

fn path(how: &str) -> String {
    format!("integrator = {{ type = \"path\", max_depth = 1000, {how} }}\n")
}

const WAYS: [&str; 3] =
    ["light_sampling = \"both\"", "light_sampling = \"bsdf\"", "light_sampling = \"light\""];

#[test]
fn absorption_follows_beer_and_lambert() {
    let e = |depth: f64| (-depth).exp();
    let slab = |medium: &str| {
        format!(
            "{}{ALONG}object = [{WALL}, {{ type = \"box\", min = [-3, -3, -1], max = [3, 3, 1], medium = {{ {medium} }} }}]\n",
            path("")
        )
    };
    let m = mean(2, &slab("absorption = [0.5, 0, 2]"));
    m.is([e(1.0), 1.0, e(4.0)], 1e-6);
    let m = mean(2, &slab("extinction = [0.25, 0, 1], albedo = 0, density = 2"));
    m.is([e(1.0), 1.0, e(4.0)], 1e-6);
    // What scatters takes as much of what goes straight: the wall alone, seen with no more than zero scatterings.
    let straight = slab("scattering = [0.5, 0, 2]").replace("max_depth = 1000", "max_depth = 0");
    mean(2, &straight).is([e(1.0), 1.0, e(4.0)], 1e-6);
    // Fog all around, 20 to the wall.
    let fog = format!("{}{ALONG}background.medium = {{ absorption = 0.1 }}\nobject = [{WALL}]\n", path(""));
    mean(2, &fog).is_grey(e(2.0), 1e-6);
    // A hollow in it, 4 long; and the camera within another one.
    let hollow = format!(
        "{}{ALONG}background.medium = {{ absorption = 0.1 }}\nobject = [{WALL}, {{ type = \"sphere\", radius = 2, material = {{ type = \"boundary\" }} }}, \
         {{ type = \"box\", min = [-1, -1, 8], max = [1, 1, 11], medium = {{ absorption = 0.5 }} }}]\n",
        path("")
    );
    mean(2, &hollow).is_grey(e(0.1 * (20.0 - 4.0 - 2.0) + 0.5 * 2.0), 1e-5);
}

#[test]
fn shadow_rays_cross_boundaries_in_order() {
    // From 4 above, straight down: 2 through one medium, of which the inner 1 through another that stands first in the scene.
    let scene = format!(
        "{}camera = {{ position = [0, 0.2, 0], look_at = [0, 0, 0], up = [0, 0, -1], fov = 0.001 }}\n\
         material.inner = {{ type = \"boundary\", interior = {{ absorption = [0.3, 1, 0] }} }}\n\
         material.outer = {{ type = \"boundary\", interior = {{ absorption = [0.7, 0.2, 0] }} }}\n\
         light = [{{ type = \"point\", position = [0, 4, 0], intensity = 32, attenuation = \"inverse-square\" }}]\n\
         object = [{{ type = \"plane\", material = {{ type = \"matte\", color = 0.5 }} }},\n\
         {{ type = \"box\", min = [-1, 1, -1], max = [1, 3, 1], material = \"outer\" }},\n\
         {{ type = \"box\", min = [-0.5, 1.5, -0.5], max = [0.5, 2.5, 0.5], material = \"inner\" }}]\n",
        path("")
    );
    let e = |a: f64| 2.0 * 0.5 / PI * (-a).exp();
    mean(2, &scene).is([e(0.7 + 0.3), e(0.2 + 1.0), e(0.0)], 1e-5);
}

/// ∫ over the ray of what a point light sends there, is scattered once and comes back, by Simpson's rule.
fn single_scattering(end: f64, sigma: f64, albedo: f64, g: f64, light: [f64; 2], intensity: f64) -> f64 {
    let phase = HenyeyGreenstein { g };
    let n = 400_000;
    let f = |t: f64| {
        // The light stands `light[0]` along the ray and `light[1]` beside it.
        let (along, beside) = (light[0] - t, light[1]);
        let d = (along * along + beside * beside).sqrt();
        albedo * sigma * (-sigma * (t + d)).exp() * phase.value(along / d) * intensity / (d * d)
    };
    let h = end / f64::from(n);
    let inner: f64 = (1..n).map(|i| f(h * f64::from(i)) * if i % 2 == 1 { 4.0 } else { 2.0 }).sum();
    (f(0.0) + f(end) + inner) * h / 3.0
}

#[test]
fn light_scattered_once_is_that_of_quadrature() {
    for (g, samples) in [(0.0, 400), (0.7, 400), (-0.5, 400)] {
        for how in ["light_sampling = \"both\"", "light_sampling = \"light\""] {
            // Fog without end, by colour.
            let scene = format!(
                "{}{ALONG}background.medium = {{ extinction = [0.1, 0.3, 0.05], albedo = [0.9, 0.5, 1], anisotropy = {g} }}\n\
                 light = [{{ type = \"point\", position = [1, 0, 4], intensity = 10, attenuation = \"inverse-square\" }}]\n",
                path(how).replace("max_depth = 1000", "max_depth = 1")
            );
            let at = |sigma, albedo| single_scattering(150.0, sigma, albedo, g, [6.0, 1.0], 10.0);
            mean(samples, &scene).is([at(0.1, 0.9), at(0.3, 0.5), at(0.05, 1.0)], 0.02);
        }
        // In a box from z = 1 to z = 9, with the light in it; and with the integrator for direct light.
        for integrator in ["path\", max_depth = 1", "direct\""] {
            let scene = format!(
                "integrator = {{ type = \"{integrator} }}\n{ALONG}\
                 light = [{{ type = \"point\", position = [0, 2, 3], intensity = 10, attenuation = \"inverse-square\" }}]\n\
                 object = [{{ type = \"box\", min = [-50, -50, -1e3], max = [50, 50, 11], medium = {{ extinction = 0.2, albedo = 0.5, anisotropy = {g} }} }}]\n"
            );
            mean(samples, &scene).is_grey(single_scattering(120.0, 0.2, 0.5, g, [7.0, 2.0], 10.0), 0.02);
        }
    }
}

/// Where everything shines with 1 and nothing absorbs, everything is 1.
#[test]
fn a_furnace_with_media_stays_even() {
    // A background is found by chance alone, a shining sphere around everything by sampling it as well.
    let around = [
        ("background.color = 1", ""),
        ("", ", { type = \"sphere\", radius = 20, material = { type = \"emissive\" } }"),
    ];
    for (i, solid) in [
        "medium = { scattering = 2 }",
        "medium = { scattering = [0.5, 1, 3], anisotropy = 0.6 }",
        "medium = { scattering = 1, anisotropy = -0.5 }",
        "medium = { type = \"smoke\", scattering = [4, 8, 12], resolution = 32, anisotropy = 0.4 }",
        "material = { type = \"dielectric\", ior = 1.5, interior = { scattering = 1.5 } }",
        "material = { type = \"principled\", transmission_weight = 1, specular_roughness = 0.4, interior = { scattering = 1.5, anisotropy = 0.3 } }",
    ]
    .into_iter()
    .enumerate()
    {
        for (around, shell) in around {
            let scene = format!(
                "{}camera = {{ position = [0, 0, 4], look_at = [0, 0, 0], fov = 20 }}\n{around}\n\
                 object = [{{ type = \"sphere\", {solid} }}{shell}]\n",
                path("rr_start = 100")
            );
            let m = mean(256, &scene);
            // Rough glass loses a little of its own (single scattering in microfacets).
            let slack = if i == 5 { 0.01 } else { 1e-3 };
            for (v, e) in m.value().into_iter().zip(m.error()) {
                assert!(e < 6e-3, "{solid}: {m:?}");
                assert!((v - 1.0).abs() < slack + 4.0 * e, "{solid}{shell}: {:?} ± {:?}", m.value(), m.error());
            }
        }
    }
}

#[test]
fn a_medium_shines_through_itself() {
    let scene = format!(
        "{}{ALONG}object = [{{ type = \"box\", min = [-3, -3, -1], max = [3, 3, 1], medium = {{ absorption = [0.5, 0, 2], emission = [1, 2, 3] }} }}]\n",
        path("")
    );
    let of = |sigma: f64, emission: f64| emission * (1.0 - (-2.0 * sigma).exp()) / sigma;
    mean(2, &scene).is([of(0.5, 1.0), 4.0, of(2.0, 3.0)], 1e-6);
}

/// What absorbs and shines in balance is a furnace as well: in each place as much is emitted as is absorbed. In glass radiance is larger by the square of its index.
#[test]
fn emission_balances_absorption() {
    let shell = "{ type = \"sphere\", radius = 20, material = { type = \"emissive\" } }";
    for (i, solid) in [
        "medium = { absorption = [0.5, 1, 3], emission = [0.5, 1, 3] }",
        "medium = { absorption = [0.5, 1, 3], emission = [0.5, 1, 3], scattering = [2, 1, 0.5], anisotropy = 0.5 }",
        "medium = { type = \"smoke\", absorption = [2, 4, 1], emission = [2, 4, 1], scattering = 3, resolution = 24 }",
        "material = { type = \"dielectric\", interior = { absorption = [0.5, 1, 3], emission = [1.125, 2.25, 6.75], scattering = 1 } }",
    ]
    .into_iter()
    .enumerate()
    {
        let scene = format!(
            "{}camera = {{ position = [0, 0, 4], look_at = [0, 0, 0], fov = 20 }}\nobject = [{{ type = \"sphere\", {solid} }}, {shell}]\n",
            path("rr_start = 100")
        );
        let m = mean(512, &scene);
        for (v, e) in m.value().into_iter().zip(m.error()) {
            // Without scattering nothing is left to chance.
            assert!(if i == 0 { e < 1e-6 } else { e < 3e-3 }, "{solid}: {m:?}");
            assert!((v - 1.0).abs() < 1e-3 + 4.0 * e, "{solid}: {:?} ± {:?}", m.value(), m.error());
        }
    }
}

/// The light that goes from one square to another through a plate of rough glass full of something that scatters: as much as the other way.
#[test]
fn scattering_glass_is_reciprocal() {
    let power = |from: (f64, [f64; 2]), to: (f64, [f64; 2]), front: f64| {
        let square = |(side, [x, y]): (f64, [f64; 2]), z: f64, material: &str| {
            format!(
                "{{ type = \"rectangle\", center = [{x}, {y}, {z}], edge_u = [{side}, 0, 0], edge_v = [0, {side}, 0], material = {{ {material} }} }}"
            )
        };
        let ([x, y], view) = (to.1, 1.5 * to.0);
        let scene = format!(
            "integrator = {{ type = \"path\", max_depth = 200, max_diffuse = 1, rr_start = 20 }}\n\
             camera = {{ type = \"orthographic\", position = [{x}, {y}, {}], look_at = [{x}, {y}, {}], viewport = {view} }}\n\
             object = [{}, {}, {{ type = \"box\", min = [-4, -4, -0.2], max = [4, 4, 0.2], material = {{ type = \"dielectric\", roughness = 0.4, \
             interior = {{ scattering = [2, 1, 4], absorption = 0.1, anisotropy = 0.3 }} }} }}]\n",
            0.7 * front,
            1.5 * front,
            square(from, -1.5 * front, "type = \"emissive\""),
            square(to, 1.5 * front, "type = \"matte\", color = 0.9"),
        );
        let m = mean(1024, &scene);
        [0, 1, 2].map(|band| (m.value()[band] * view * view, m.error()[band] * view * view))
    };
    let (one, other) = ((2.0, [0.4, 0.0]), (1.2, [-0.3, 0.5]));
    let (there, back) = (power(one, other, 1.0), power(other, one, -1.0));
    for ((a, ea), (b, eb)) in there.into_iter().zip(back) {
        let error = f64::hypot(ea, eb);
        assert!(error < 0.03 * a && (a - b).abs() < 4.5 * error, "{there:?} {back:?}");
    }
}

/// Lights with an extent are found by sampling them at two places and by chance: each way alone gives the same.
#[test]
fn ways_to_find_lights_agree_in_media() {
    let scene = |how: &str| {
        format!(
            "{}camera = {{ position = [0, 1, 5], look_at = [0, 1, 0], fov = 50 }}\nbackground.medium = {{ scattering = [0.1, 0.2, 0.3], absorption = 0.02, anisotropy = 0.4 }}\n\
             object = [{{ type = \"plane\", material = {{ type = \"matte\" }} }},\n\
             {{ type = \"sphere\", center = [1, 2, 0], radius = 0.7, material = {{ type = \"emissive\", strength = 5 }} }},\n\
             {{ type = \"sphere\", center = [-1, 1, 0], medium = {{ scattering = [2, 3, 1], anisotropy = 0.8 }} }}]\n",
            path(how).replace("max_depth = 1000", "max_depth = 6")
        )
    };
    let [both, bsdf, light] = WAYS.map(|how| mean_of(8, 256, &scene(how)));
    both.agrees(&bsdf, 0.02);
    both.agrees(&light, 0.02);
}

/// What is inside one boundary may be divided by others.
#[test]
fn a_medium_in_two_parts_is_one() {
    let scene = |objects: &str| {
        format!(
            "{}camera = {{ position = [0, 1, 5], look_at = [0, 0, 0], fov = 40 }}\nbackground.color = [0.1, 0.2, 0.3]\n\
             medium.milk = {{ scattering = [1, 2, 3], absorption = 0.1 }}\n\
             light = [{{ type = \"point\", position = [2, 3, 1], intensity = 20, attenuation = \"inverse-square\" }}]\nobject = [{objects}]\n",
            path("")
        )
    };
    let one = "{ type = \"box\", min = [-1, -1, -1], max = [1, 1, 1], medium = \"milk\" }";
    let nested = "{ type = \"box\", min = [-0.5, -0.7, -0.6], max = [0.8, 0.3, 0.9], medium = \"milk\" }, { type = \"box\", min = [-1, -1, -1], max = [1, 1, 1], medium = \"milk\" }";
    let whole = mean_of(8, 256, &scene(one));
    whole.agrees(&mean_of(8, 256, &scene(nested)), 0.02);
}

/// Light goes as well from here to there as from there to here: a small lamp and the eye change places, and what comes from a matte place
/// that both look at through a cloud is, per irradiance, the same.
#[test]
fn a_scattering_slab_is_reciprocal() {
    // Both are 5 from the origin; the lamp's cosine at the floor belongs to the irradiance.
    let seen = |eye: [f64; 3], lamp: [f64; 3]| {
        let text = format!(
            "{}camera = {{ position = {eye:?}, look_at = [0, 0, 0], fov = 0.001 }}\n\
             light = [{{ type = \"point\", position = {lamp:?}, intensity = 100, attenuation = \"inverse-square\" }}]\n\
             object = [{{ type = \"disk\", radius = 0.01, normal = [0, 1, 0], material = {{ type = \"matte\", color = 0.5 }} }},\n\
             {{ type = \"box\", min = [-9, 1, -9], max = [9, 2, 9], medium = {{ absorption = [0.3, 0.1, 0.7] }} }}]\n",
            path("")
        );
        mean(2, &text).value()
    };
    let (there, back) = (seen([0.0, 4.0, 3.0], [0.0, 3.0, -4.0]), seen([0.0, 3.0, -4.0], [0.0, 4.0, 3.0]));
    for band in 0..3 {
        assert!(there[band] > 0.0);
        assert!((there[band] / 3.0 - back[band] / 4.0).abs() < 1e-5 * there[band], "{there:?} {back:?}");
    }
}

const CLOUDY: &str = r#"
camera = { position = [0, 1, 5], look_at = [0, 1, 0], fov = 40 }
integrator = { type = "path", max_depth = 12 }
film = { width = 37, height = 29, antialias = "monte-carlo", samples = 6 }
background = { medium = { extinction = 0.1, albedo = 0.8, anisotropy = 0.3 } }
light = [{ type = "point", position = [2, 3, 1], intensity = 20, attenuation = "inverse-square" }]
[[object]]
type = "plane"
material = { type = "matte" }
[[object]]
type = "sphere"
center = [0, 1, 0]
medium = { scattering = [2, 3, 1], emission = 0.1 }
[[object]]
type = "sphere"
center = [-1.5, 0.6, 0.5]
radius = 0.6
medium = { type = "smoke", center = [-1.5, 0.6, 0.5], radius = 0.6, scattering = 6, emission = [0.2, 0.1, 0], resolution = 20 }
[[object]]
type = "sphere"
center = [1.5, 0.5, 1]
radius = 0.5
material = { type = "dielectric", interior = { scattering = 3 } }
"#;

#[test]
fn threads_and_passes_change_nothing() {
    let desc = describe(CLOUDY);
    let (reference, _) = render_with(&desc, 1, u32::MAX);
    for (threads, pass) in [(2, u32::MAX), (3, 1), (1, 4)] {
        assert!(
            render_with(&desc, threads, pass).0.linear == reference.linear,
            "{threads} threads, {pass} samples a pass"
        );
    }
}

/// Integrators that know no media see neither them nor their boundaries.
#[test]
fn other_integrators_see_no_boundaries() {
    for integrator in ["classic", "normals", "depth"] {
        let with =
            describe(&CLOUDY.replace("type = \"path\", max_depth = 12", &format!("type = \"{integrator}\"")));
        let mut without = with.clone();
        without.objects.drain(1..3);
        assert!(
            render_with(&with, 2, u32::MAX).0.linear == render_with(&without, 2, u32::MAX).0.linear,
            "{integrator}"
        );
    }
}

#[test]
fn nonsense_is_an_error_at_its_place() {
    let load = |medium: &str| {
        let text =
            format!("object = [{{ type = \"sphere\", medium = {medium} }}]\nintegrator.type = \"path\"\n");
        let assets = turner_io::assets::MemoryAssets::default();
        let loaded = turner_io::scene::load_text(text, "t.toml", &assets, &Default::default());
        match loaded {
            Ok(loaded) => loaded.desc.prepare(&PrepareOptions::default()).err().map(|e| e.code.as_str()),
            Err(e) => Some(e.code()),
        }
    };
    for (medium, code) in [
        ("{ extinction = -1 }", ErrorCode::OutOfRange),
        ("{ extinction = nan }", ErrorCode::OutOfRange),
        ("{ scattering = inf }", ErrorCode::OutOfRange),
        ("{ albedo = 1.5 }", ErrorCode::OutOfRange),
        ("{ anisotropy = 1 }", ErrorCode::OutOfRange),
        ("{ emission = [0, -1, 0] }", ErrorCode::OutOfRange),
        ("{ density = -2 }", ErrorCode::OutOfRange),
        ("{ extinction = 1, absorption = 1 }", ErrorCode::Conflict),
        ("{ exctinction = 1 }", ErrorCode::UnknownKey),
        ("\"smoke\"", ErrorCode::UnknownName),
        ("{ type = \"smoke\", radius = 0 }", ErrorCode::OutOfRange),
        ("{ type = \"smoke\", resolution = 100000 }", ErrorCode::OutOfRange),
        ("{ type = \"smoke\", size = inf }", ErrorCode::OutOfRange),
        ("{ type = \"grid\", file = \"none.grid\" }", ErrorCode::File),
        ("{ type = \"steam\" }", ErrorCode::UnknownName),
        ("3", ErrorCode::WrongType),
        ("\"x\", material = { color = \"red\" }", ErrorCode::Conflict),
    ] {
        assert_eq!(load(medium), Some(code.as_str()), "{medium}");
    }
    assert_eq!(load("{ extinction = 1e29, emission = 1e14 }"), None);
}

/// A grid of one density all over is a homogeneous medium, and one with an error says so at its name.
#[test]
fn grids_come_from_files() {
    let mut assets = turner_io::assets::MemoryAssets::default();
    let even = turner_io::grid::encode([5, 9, 4], &[0.5; 180], Some(&[2.0; 180]));
    assets.files.insert("short.grid".into(), even[..even.len() - 3].to_vec());
    assets.files.insert("even.grid".into(), even);
    let scene = |medium: &str| {
        format!(
            "film = {{ width = 4, height = 4, antialias = \"monte-carlo\", samples = 4096 }}\n\
             camera = {{ position = [0, 0, 10], look_at = [0, 0, 0], fov = 0.001 }}\nintegrator.type = \"path\"\n\
             object = [{{ type = \"box\", min = [-3, -3, -2], max = [3, 3, 2], medium = {{ {medium} }} }}, {WALL}]\n"
        )
    };
    let load = |text: String| turner_io::scene::load_text(text, "t.toml", &assets, &Default::default());
    let grid = "type = \"grid\", file = \"even.grid\", min = [-2, -2, -1], max = [2, 2, 1], absorption = [1, 2, 0], emission = 0.3";
    let picture = render_with(&load(scene(grid)).unwrap().desc, 2, u32::MAX).0;
    for band in 0..3 {
        let sigma = [0.5, 1.0, 0.0][band];
        let left = f64::exp(-2.0 * sigma);
        let shines = 0.3 * if sigma > 0.0 { (1.0 - left) / sigma } else { 2.0 };
        let mean = picture.linear.iter().map(|p| f64::from(p[band])).sum::<f64>() / 16.0;
        assert!((mean - left - shines).abs() < 0.01, "{band}: {mean}, not {}", left + shines);
    }
    let error = load(scene("type = \"grid\", file = \"short.grid\"")).err().unwrap();
    assert_eq!((error.code(), error.line()), ("E0206", Some(4)));
    let empty = grid.replace("max = [2, 2, 1]", "max = [2, -2, 1]");
    let desc = load(scene(&empty)).unwrap().desc;
    assert_eq!(desc.prepare(&PrepareOptions::default()).unwrap_err().code, ErrorCode::OutOfRange);
}
