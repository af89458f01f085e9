//! Bytes that must not depend on threads, tiles and instruction sets; a limited stack; finite samples.

use std::sync::atomic::AtomicBool;

use turner::film::{Picture, PixelRect};
use turner::integrator::Prepared;
use turner::render::{PassOptions, Renderer};
use turner::schema::SceneError;
use turner_bvh::InstructionSet;
use turner_io::assets::MemoryAssets;

use super::check::{Check, Context, Finding, Verdict, fault};

/// Glass, rough metal, meshes, matte materials, a thin lens, textures, several types of lights.
const SCENE: &str = r#"
camera = { type = "thin-lens", position = [0, 1, 4], look_at = [0, 0.5, 0], fov = 40, focus_distance = 4, lens_radius = 0.05 }
integrator = { type = "path", max_depth = 6 }
[material.glass]
type = "dielectric"
roughness = 0.2
[material.sheet]
type = "principled"
alpha_mode = "blend"
opacity = 0.5
double_sided = false
[material.lamp]
type = "emissive"
strength = 4
[[light]]
type = "point"
position = [2, 3, 2]
intensity = 4
attenuation = "inverse-square"
[[light]]
type = "environment"
strength = 0.2
[[object]]
type = "plane"
material = { type = "matte", color = { type = "checkerboard" } }
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
[[object]]
type = "mesh"
positions = [[1.1, 0, 0.5], [1.6, 0, 0.5], [1.3, 0.6, 0.7], [1.3, 0.1, 1.0]]
triangles = [[0, 1, 2], [1, 3, 2], [3, 0, 2], [0, 3, 1]]
material = { type = "metal", name = "gold" }
[[object]]
type = "mesh"
positions = [[-3, 0.01, -2], [3, 0.01, -2], [3, 2, -3], [-3, 2, -3]]
triangles = [[0, 1, 2], [0, 2, 3]]
material = { type = "matte", color = [0.7, 0.5, 0.3] }
[[object]]
type = "mesh"
positions = [[-1.5, 0, 0], [-1.2, 0, 0.8], [-1.4, 1, 0.4]]
triangles = [[0, 1, 2]]
material = { type = "principled", base_weight = 0, specular_ior = 0, specular_roughness = 0.3 }
"#;

const SIZE: [u32; 2] = [50, 37];

fn render(cx: &Context, scene: &Prepared, threads: usize, pass: u32) -> Result<Picture, SceneError> {
    let mut renderer = Renderer::new(scene.clone())?;
    let never = AtomicBool::new(false);
    while !renderer.is_complete() {
        renderer.pass(pass, &PassOptions { threads, cancel: &never, progress: None })?;
    }
    cx.count(&renderer.film.non_finite, renderer.film.samples());
    Ok(renderer.film.develop(&scene.view.film, 1))
}

/// Number of pixels that differ in any bit.
fn differing(a: &[[f32; 4]], b: &[[f32; 4]]) -> usize {
    let bits = |p: &[f32; 4]| p.map(f32::to_bits);
    a.iter().zip(b).filter(|(a, b)| bits(a) != bits(b)).count() + a.len().abs_diff(b.len())
}

fn prepared(cx: &Context) -> Result<Prepared, SceneError> {
    let mut scene = cx.scene(SIZE, 6, SCENE)?;
    scene.view.film.seed = cx.seed_for("sameness") as u32;
    Ok(scene)
}

pub(super) fn checks() -> Vec<Check> {
    vec![
        Check::limit("bytes/threads-and-passes", |cx| {
            let scene = prepared(cx)?;
            let first = render(cx, &scene, 1, u32::MAX)?;
            let settings = [(2, u32::MAX), (5, u32::MAX), (2, 4), (5, 1), (1, 5)];
            let mut wrong = 0;
            for (threads, pass) in settings {
                wrong += differing(&first.linear, &render(cx, &scene, threads, pass)?.linear);
            }
            Ok(pixels(wrong, "1, 2 and 5 threads, passes of 1, 4, 5 and 6 samples"))
        }),
        Check::limit("bytes/tiles", |cx| {
            // The tiles of a crop start at its corner: each crop divides the picture differently.
            let mut scene = prepared(cx)?;
            let full = render(cx, &scene, cx.threads, u32::MAX)?;
            let mut wrong = 0;
            for crop in [[13, 9, 31, 25], [1, 1, 49, 36], [7, 0, 9, 37]] {
                scene.view.film.crop = Some(crop);
                let part = render(cx, &scene, cx.threads, u32::MAX)?;
                let [x, y, width, height] = crop;
                let rect = PixelRect { x, y, width, height };
                let row = |y: u32| {
                    let from = (y * SIZE[0] + rect.x) as usize;
                    full.linear[from..from + rect.width as usize].iter().copied()
                };
                let expected: Vec<_> = (rect.y..rect.y + rect.height).flat_map(row).collect();
                wrong += differing(&expected, &part.linear);
            }
            Ok(pixels(wrong, "three ways to divide the picture into tiles"))
        }),
        Check::limit("bytes/instruction-sets", |cx| {
            let (mut wrong, mut names, mut first) = (0, Vec::new(), None);
            for set in InstructionSet::available() {
                let mut scene = cx.scene_by(set, SIZE, 6, SCENE, &MemoryAssets::default())?;
                scene.view.film.seed = cx.seed_for("sameness") as u32;
                let picture = render(cx, &scene, cx.threads, u32::MAX)?;
                names.push(set.name());
                let first = first.get_or_insert_with(|| picture.linear.clone());
                wrong += differing(first, &picture.linear);
            }
            Ok(pixels(wrong, &names.join(", ")))
        }),
        Check::limit("stack/256-shells", |cx| within_small_stack(cx, &shells(), 1.0)),
        Check::limit("stack/depth-1000", |cx| within_small_stack(cx, MIRRORS, 1.001)),
    ]
}

/// Counts the non-finite samples of all checks; it runs last.
pub(super) fn all_finite() -> Check {
    Check::limit("finite/all-samples", |cx| {
        let (bad, samples) = *cx.rendered.lock().unwrap_or_else(|e| e.into_inner());
        let found = format!("{} of {} samples are non-finite", bad.count, crate::text::count(samples as f64));
        Ok(Finding { verdict: Verdict::Limit(bad.count as f64, 0.0), found })
    })
}

fn pixels(wrong: usize, what: &str) -> Finding {
    Finding::limit(wrong as f64, 0.0, format!("{wrong} pixels differ: {what}"))
}

/// The stack of the rendering thread, bytes.
const STACK: usize = 256 << 10;

/// Inside a perfect mirror with emitted radiance 0.001: a path with 1000 reflections collects it 1001 times.
const MIRRORS: &str = r#"
camera = { position = [0.3, 0.2, 0], look_at = [0, 0.1, 1] }
integrator = { type = "path", max_depth = 1000, rr_start = 1000000, light_sampling = "bsdf" }
[[object]]
type = "sphere"
radius = 3
[object.material]
type = "principled"
base_weight = 0
specular_ior = 0
specular_roughness = 0
emission_luminance = 0.001
"#;

/// 256 nested glass spheres with different indices of refraction.
fn shells() -> String {
    let mut text = "camera = { position = [0, 0, 3], look_at = [0, 0, 0], fov = 45 }\n\
        integrator = { type = \"path\", max_depth = 1000, rr_start = 1000000 }\nbackground.color = 1\n"
        .to_owned();
    for i in 0..256 {
        let (radius, ior) = (1.0 - 0.0035 * f64::from(i), 1.3 + 0.05 * f64::from(i % 5));
        text += &format!(
            "[[object]]\ntype = \"sphere\"\nradius = {radius:?}\nmaterial = {{ type = \"dielectric\", ior = {ior:?} }}\n"
        );
    }
    text
}

/// Renders on a thread with a small stack. If it overflows, the program aborts.
fn within_small_stack(cx: &Context, text: &str, expected: f32) -> Result<Finding, SceneError> {
    let scene = cx.scene([16, 16], cx.times(2), text)?;
    let work = || render(cx, &scene, 1, u32::MAX);
    let picture = std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, work);
        let thread = thread.map_err(|e| fault(format!("cannot start a thread: {e}")))?;
        thread.join().unwrap_or_else(|_| Err(fault("the thread ended unexpectedly")))
    })?;
    // Nothing absorbs here, so every path returns nearly the expected radiance.
    let colors = picture.linear.iter().flat_map(|p| p[..3].iter().copied());
    let off = colors.map(|v| (v - expected).abs()).fold(0.0f32, f32::max);
    let found = format!("stack of {} KiB; radiance {expected} within {off:.1e}", STACK >> 10);
    Ok(Finding::limit(f64::from(off), 1e-3, found))
}
