//! Scenes whose radiance is known in closed form, rendered at 10 x 10 pixels.

use std::f64::consts::PI;

use turner::math::elementary::{atan2, exp, pow};
use turner::schema::SceneError;
use turner::testing::{CompareOptions, Reference, compare};
use turner_io::assets::MemoryAssets;
use turner_io::image::{ImageFormat, Metadata, OutputImage, Transfer, encode};

use super::check::{Check, Context, Finding, fault};

/// A camera that looks straight down at the origin.
const DOWN: &str = "camera = { position = [0, 0.2, 0], look_at = [0, 0, 0], up = [0, 0, -1], fov = 0.001 }\n";
/// A camera that looks along -z at [`WALL`], a wall of radiance 1 on a black background. The objects in between follow.
const ALONG: &str = "camera = { position = [0, 0, 10], look_at = [0, 0, 0], fov = 0.001 }\nintegrator = { type = \"path\", max_depth = 200 }\n";
const WALL: &str = "{ type = \"rectangle\", center = [0, 0, -10], edge_u = [9, 0, 0], edge_v = [0, 9, 0], material = { type = \"emissive\" } }";
const FLOOR: &str = "{ type = \"plane\", material = { type = \"matte\", color = 0.5 } }";

struct Case {
    name: &'static str,
    scene: String,
    expected: [f64; 3],
    /// Samples per pixel and run.
    samples: u32,
    /// Largest standard error, relative to the value.
    cap: f64,
}

/// Form factor from a differential surface to a parallel rectangle with one corner straight above it (Howell, "A
/// Catalog of Radiation Heat Transfer Configuration Factors"). `a` and `b` are the sides over the height.
///
/// ```text
///   ┌────── a ──────┐
///   b               │  height 1
///   └───────────────┘
///   |
///   dA
/// ```
fn corner_factor(a: f64, b: f64) -> f64 {
    let part = |a: f64, b: f64| {
        let root = (1.0 + a * a).sqrt();
        a / root * atan2(b, root)
    };
    (part(a, b) + part(b, a)) / (2.0 * PI)
}

/// Transmittance of a slab with the reflectances r and s of its faces and the internal transmittance a, all orders of
/// internal reflection summed: (1-r)(1-s)a Σ (rsa²)ⁿ.
fn slab_transmittance(r: f64, s: f64, a: f64) -> f64 {
    (1.0 - r) * (1.0 - s) * a / (1.0 - r * s * a * a)
}

/// Fresnel reflectance at normal incidence between the indices a and b.
fn reflectance(a: f64, b: f64) -> f64 {
    let r = (a - b) / (a + b);
    r * r
}

fn cases() -> Vec<Case> {
    let mut out = Vec::new();
    let mut add = |name, scene: String, expected, samples, cap| {
        out.push(Case { name, scene, expected, samples, cap });
    };
    lights(&mut add);
    shapes(&mut add);
    glass(&mut add);
    interreflection(&mut add);
    media(&mut add);
    out
}

fn path(more: &str) -> String {
    format!("integrator = {{ type = \"path\"{more} }}\n")
}

fn lights(add: &mut impl FnMut(&'static str, String, [f64; 3], u32, f64)) {
    for (name, light) in [
        ("background", "background.color = 1"),
        ("ambient", "light = [{ type = \"ambient\", intensity = 1 }]"),
    ] {
        let scene = format!(
            "{}camera = {{ position = [0, 0, 4], look_at = [0, 0, 0], fov = 10 }}\n{light}\n\
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
}

fn shapes(add: &mut impl FnMut(&'static str, String, [f64; 3], u32, f64)) {
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
}

fn glass(add: &mut impl FnMut(&'static str, String, [f64; 3], u32, f64)) {
    for (name, ior) in [("water-slab", 1.33), ("glass-slab", 1.5), ("diamond-slab", 2.42)] {
        let scene = format!(
            "{ALONG}object = [{{ type = \"box\", min = [-5, -5, -1], max = [5, 5, 1], material = {{ type = \"dielectric\", ior = {ior} }} }}, {WALL}]"
        );
        let r = reflectance(1.0, ior);
        add(name, scene, [slab_transmittance(r, r, 1.0); 3], 64, 0.01);
    }
    let scene = format!(
        "{ALONG}object = [{{ type = \"box\", min = [-5, -5, -1], max = [5, 5, 1], material = {{ type = \"dielectric\", color = [0.25, 0.5, 1], depth = 4 }} }}, {WALL}]"
    );
    let r = reflectance(1.0, 1.5);
    let beer = [0.25, 0.5, 1.0].map(|c| slab_transmittance(r, r, pow(c, 0.5)));
    add("absorbing-glass", scene, beer, 64, 0.01);
}

fn interreflection(add: &mut impl FnMut(&'static str, String, [f64; 3], u32, f64)) {
    // Inside a sphere of emitted radiance 1 and albedo 1/2: 1 + 1/2 + 1/4 + …
    let inside = |more: &str| {
        format!(
            "{}camera = {{ position = [0.1, 0, 0], look_at = [0, 0, 1] }}\n\
             object = [{{ type = \"sphere\", radius = 1, material = {{ type = \"principled\", specular_weight = 0, base_color = 0.5, emission_luminance = 1 }} }}]",
            path(more)
        )
    };
    let series = inside(", max_depth = 7, rr_start = 1000, light_sampling = \"bsdf\"");
    add("inside-an-emissive-sphere", series, [2.0 - 1.0 / 128.0; 3], 4, 1e-5);
    add(
        "inside-an-emissive-sphere-with-roulette",
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
    // An emissive sheet of opacity 1/4 in front of a background.
    let scene = format!(
        "{}{DOWN}background.color = 1\nobject = [{{ type = \"rectangle\", edge_u = [8, 0, 0], edge_v = [0, 0, 8], material = {{ type = \"principled\", specular_weight = 0, base_weight = 0, alpha_mode = \"blend\", opacity = 0.25, emission_luminance = 2 }} }}]",
        path("")
    );
    add("a-sheet-of-opacity-a-quarter", scene, [0.75 + 0.5; 3], 64, 0.01);
}

/// Single scattering of a point light of intensity 1 in fog, along a camera ray: the integral over t of albedo σ
/// exp(-σ(t + d)) p(cos θ) / d², with the phase function p of Henyey and Greenstein (1941), by Simpson's rule. The
/// light is `along` the ray and at the distance `lateral` from it.
///
/// ```text
///                    * light
///               d  / | lateral
/// camera ──── t ──x──┴────────>
/// ```
fn single_scattering(sigma: f64, albedo: f64, g: f64, along: f64, lateral: f64) -> f64 {
    let (n, end) = (200_000, 40.0 / sigma);
    let f = |t: f64| {
        let x = along - t;
        let d = (x * x + lateral * lateral).sqrt();
        let q = 1.0 + g * g - 2.0 * g * x / d;
        let phase = 0.25 / PI * (1.0 - g * g) / (q * q.sqrt());
        albedo * sigma * exp(-sigma * (t + d)) * phase / (d * d)
    };
    let h = end / f64::from(n);
    let inner: f64 = (1..n).map(|i| f(h * f64::from(i)) * f64::from(2 + 2 * (i % 2))).sum();
    (f(0.0) + f(end) + inner) * h / 3.0
}

/// Participating media: absorption, emission, single scattering, and furnace tests.
fn media(add: &mut impl FnMut(&'static str, String, [f64; 3], u32, f64)) {
    let slab = |medium: &str| {
        format!(
            "{ALONG}object = [{WALL}, {{ type = \"box\", min = [-5, -5, -1], max = [5, 5, 1], medium = {{ {medium} }} }}]"
        )
    };
    let transmitted = [0.5, 0.0, 2.0].map(|a| exp(-2.0 * a));
    add("an-absorbing-slab", slab("absorption = [0.5, 0, 2]"), transmitted, 2, 1e-5);
    let emitted = [0.5, 0.0, 2.0].map(|a| if a > 0.0 { (1.0 - exp(-2.0 * a)) / a } else { 2.0 });
    let both = [0, 1, 2].map(|i| transmitted[i] + emitted[i]);
    add("an-emissive-slab", slab("absorption = [0.5, 0, 2], emission = 1"), both, 2, 1e-5);
    for (name, g) in [("single-scattering-isotropic", 0.0), ("single-scattering-forward", 0.7)] {
        let scene = format!(
            "camera = {{ position = [0, 0, 10], look_at = [0, 0, 0], fov = 0.001 }}\nintegrator = {{ type = \"path\", max_depth = 1 }}\n\
             background.medium = {{ extinction = [0.1, 0.3, 0.05], albedo = [0.9, 0.5, 1], anisotropy = {g} }}\n\
             light = [{{ type = \"point\", position = [1, 0, 4], attenuation = \"inverse-square\" }}]"
        );
        let of = |sigma, albedo| single_scattering(sigma, albedo, g, 6.0, 1.0);
        add(name, scene, [of(0.1, 0.9), of(0.3, 0.5), of(0.05, 1.0)], 128, 0.01);
    }
    for (name, solid) in [
        ("white-fog-in-a-furnace", "medium = { scattering = 2, anisotropy = 0.5 }"),
        ("white-smoke-in-a-furnace", "medium = { type = \"smoke\", scattering = 8, resolution = 24 }"),
        ("milk-in-glass-in-a-furnace", "material = { type = \"dielectric\", interior = { scattering = 2 } }"),
    ] {
        let scene = format!(
            "integrator = {{ type = \"path\", max_depth = 2000, rr_start = 100 }}\nbackground.color = 1\n\
             camera = {{ position = [0, 0, 4], look_at = [0, 0, 0], fov = 10 }}\nobject = [{{ type = \"sphere\", {solid} }}]"
        );
        add(name, scene, [1.0; 3], 64, 0.01);
    }
}

pub(super) fn checks() -> Vec<Check> {
    let cases = cases().into_iter().map(|case| {
        Check::chance(format!("closed/{}", case.name), move |cx| judge(cx, &case, &MemoryAssets::default()))
    });
    cases.chain([Check::chance("closed/sphere-under-a-white-environment", white_environment)]).collect()
}

fn judge(cx: &Context, case: &Case, assets: &MemoryAssets) -> Result<Finding, SceneError> {
    let scene = cx.scene_with([10, 10], cx.times(case.samples), &case.scene, assets)?;
    let runs = cx.runs(&scene, 16, case.name)?;
    let exact = Reference::constant(10, 10, case.expected);
    let options = CompareOptions { block: 10, tolerance: 4e-6, ..CompareOptions::default() };
    Ok(Finding::comparison(&compare(&runs, &exact, &options), case.cap))
}

/// A convex diffuse object under uniform white light shows its albedo, here with an importance-sampled environment map.
fn white_environment(cx: &Context) -> Result<Finding, SceneError> {
    let picture = OutputImage {
        width: 16,
        height: 8,
        alpha: false,
        linear: Some(&[[1.0; 4]; 16 * 8]),
        transfer: Transfer::Unstated,
        metadata: &Metadata::new(),
        threads: 1,
        ..OutputImage::default()
    };
    let mut assets = MemoryAssets::default();
    assets.files.insert("white.exr".into(), encode(&picture, ImageFormat::Exr).map_err(fault)?);
    let scene = "integrator = { type = \"path\" }\ncamera = { position = [0, 0, 4], look_at = [0, 0, 0], fov = 10 }\n\
        light = [{ type = \"environment\", file = \"white.exr\" }]\n\
        object = [{ type = \"sphere\", radius = 1, material = { type = \"matte\", color = [0.3, 0, 1] } }]";
    let name = "sphere-under-a-white-environment";
    judge(cx, &Case { name, scene: scene.into(), expected: [0.3, 0.0, 1.0], samples: 64, cap: 0.01 }, &assets)
}
