//! Paths that neighbouring pixels use together: the same light with less noise, the same bytes whatever is rendered beside it.

use turner::description::SceneDesc;
use turner::film::{Picture, PixelSum};
use turner::integrator::path::{PathRecord, replay};
use turner::integrator::{IntegratorDesc, PathReuse, Prepared};
use turner::render::sample;
use turner::schema::PrepareOptions;

use crate::classic::common::{describe, render_with};

const WIDTH: u32 = 44;
const HEIGHT: u32 = 27;

/// A room of diffuse walls, a smooth mesh, a textured ball, glass, a rough mirror, a hole by chance and a pane of glass.
const ROOM: &str = r#"
camera = { position = [0, 1, 3.6], look_at = [0, 0.9, 0], fov = 48 }
integrator = { type = "path", caustics = "off" }
film = { width = 44, height = 27, antialias = "monte-carlo", samples = 5 }
[material.wall]
type = "matte"
color = [0.8, 0.6, 0.4]
[material.lamp]
type = "emissive"
strength = 12
[[object]]
type = "box"
min = [-1.2, 0, -1]
max = [1.2, 2, 4]
material = "wall"
[[object]]
type = "rectangle"
center = [0.3, 1.98, 0.5]
edge_u = [0.4, 0, 0]
edge_v = [0, 0, 0.4]
material = "lamp"
[[object]]
type = "sphere"
center = [-0.5, 0.4, 0]
radius = 0.4
material = { type = "matte", color = { type = "chessboard", even = "ivory", odd = "tomato", density = 8 } }
[[object]]
type = "mesh"
positions = [[0.2, 0, 0.2], [0.9, 0, 0.4], [0.6, 0.9, 0], [0.5, 0, -0.4]]
normals = [[-0.5, 0.2, 0.6], [0.6, 0.2, 0.6], [0, 1, 0.1], [0, 0.2, -1]]
triangles = [[0, 1, 2], [1, 3, 2], [3, 0, 2]]
material = { type = "matte", color = [0.3, 0.5, 0.8] }
[[object]]
type = "sphere"
center = [0.1, 0.2, 0.9]
radius = 0.2
material = { type = "dielectric", ior = 1.5 }
[[object]]
type = "rectangle"
center = [-0.8, 0.9, 0.8]
edge_u = [0.5, 0, 0]
edge_v = [0, 0.9, 0.1]
material = { type = "principled", specular_weight = 0, base_color = [0.6, 0.9, 0.6], alpha_mode = "blend", opacity = 0.5, double_sided = true }
[[object]]
type = "rectangle"
center = [0.9, 1.2, 1]
edge_u = [0.5, 0, 0.1]
edge_v = [0, 0.8, 0]
material = { type = "dielectric", thin = true }
"#;

fn room(reuse: PathReuse) -> SceneDesc {
    let mut desc = describe(ROOM);
    set(&mut desc, reuse);
    desc
}

fn set(desc: &mut SceneDesc, reuse: PathReuse) {
    let IntegratorDesc::Path(path) = &mut desc.integrator else { panic!("path") };
    path.reuse = reuse;
}

fn prepared(desc: &SceneDesc) -> Prepared {
    desc.prepare(&PrepareOptions { threads: 1, ..Default::default() }).unwrap()
}

fn picture(desc: &SceneDesc) -> Picture {
    render_with(desc, 2, u32::MAX).0
}

#[test]
fn samples_are_sums_of_their_own_path_and_of_what_neighbours_lend() {
    let desc = room(PathReuse::Always);
    let (scene, picture) = (prepared(&desc), picture(&desc));
    let (mut lent, mut kept, mut neighbours) = (0, 0, 0);
    for i in 0..160 {
        let (x, y) = (i * 17 % WIDTH, i * 5 % HEIGHT);
        let mut pixel = PixelSum::default();
        for index in 0..5 {
            let path = replay(&scene, x, y, index).unwrap();
            let rendered = sample(&scene, x, y, index).unwrap();
            assert_eq!(path.sum(), rendered.color, "{x},{y} sample {index}");
            assert_eq!(path.radiance, rendered);
            assert!(pixel.add_or_leave_out(rendered.color, rendered.alpha));
            let shared = path.shared.as_ref().unwrap();
            let own = shared.parts.iter().find(|p| p.id == path.id);
            match shared.from {
                Some(from) => {
                    lent += 1;
                    // What the path found from there on is what its group gets shares of.
                    assert_eq!(own.map(|p| p.radiance), Some(found_from(&path, from)));
                }
                None => kept += usize::from(own.is_none()),
            }
            neighbours += shared.parts.len() - usize::from(own.is_some());
        }
        let shown = picture.linear[(y * WIDTH + x) as usize];
        assert_eq!(pixel.mean().unwrap(), shown, "{x},{y}");
    }
    assert!(lent > 200 && kept > 100 && neighbours > 5 * lent, "{lent} {kept} {neighbours}");
}

/// What a path adds up from a vertex on.
fn found_from(path: &PathRecord, from: usize) -> turner::color::Spectrum {
    let mut rest = path.clone();
    rest.shared = None;
    rest.vertices.drain(..from);
    rest.sum()
}

#[test]
fn the_mean_is_that_of_paths_by_themselves() {
    const SEEDS: u32 = 48;
    // Sums over cells of 4 x 3, for their pixels' noise has much in common.
    let cells = |reuse: PathReuse, first: u32| -> Vec<Vec<f64>> {
        (first..first + SEEDS)
            .map(|seed| {
                let mut desc = room(reuse);
                (desc.film.samples, desc.film.seed) = (4, seed);
                let picture = picture(&desc);
                let mut sums = vec![0.0; (11 * 9) as usize];
                for (i, p) in picture.linear.iter().enumerate() {
                    let (x, y) = (i as u32 % WIDTH, i as u32 / WIDTH);
                    sums[(y / 3 * 11 + x / 4) as usize] += f64::from(p[0] + p[1] + p[2]);
                }
                sums
            })
            .collect()
    };
    let (alone, together) = (cells(PathReuse::Off, 1), cells(PathReuse::Always, 1001));
    let of = |runs: &[Vec<f64>], cell: usize| {
        let n = runs.len() as f64;
        let mean = runs.iter().map(|r| r[cell]).sum::<f64>() / n;
        let variance = runs.iter().map(|r| (r[cell] - mean) * (r[cell] - mean)).sum::<f64>() / (n - 1.0);
        (mean, variance / n)
    };
    let (mut squares, mut largest, mut variances) = (0.0, 0.0f64, [0.0; 2]);
    for cell in 0..99 {
        let ((a, va), (b, vb)) = (of(&alone, cell), of(&together, cell));
        let z = (a - b) / (va + vb).sqrt();
        squares += z * z;
        largest = largest.max(z.abs());
        variances[0] += va / (a * a);
        variances[1] += vb / (a * a);
    }
    // 99 numbers of mean square 1 and a variance of a little more than 2 (Student's t).
    let rms = (squares / 99.0f64).sqrt();
    assert!((0.75..1.3).contains(&rms) && largest < 4.8, "rms {rms}, largest {largest}");
    assert!(variances[1] < 0.8 * variances[0], "{variances:?}");
}

#[test]
fn pixels_have_less_noise() {
    // The room and its lamp alone, seen finely: most of the noise is light by way of another wall.
    let empty: Vec<&str> = ROOM.split("[[object]]").take(3).collect();
    let empty = empty.join("[[object]]").replace("width = 44, height = 27", "width = 120, height = 90");
    let noise = |reuse: PathReuse| -> f64 {
        let of = |seed: u32| {
            let mut desc = describe(&empty);
            set(&mut desc, reuse);
            desc.film.seed = seed;
            picture(&desc).linear
        };
        let (a, b) = (of(1), of(2));
        let square = |(a, b): (&[f32; 4], &[f32; 4])| {
            f64::from((a[1] - b[1]) * (a[1] - b[1]) / (a[1] + b[1] + 0.1).powi(2))
        };
        a.iter().zip(&b).map(square).sum()
    };
    let (alone, together) = (noise(PathReuse::Off), noise(PathReuse::Always));
    assert!(together < 0.5 * alone, "{together} {alone}");
}

#[test]
fn the_same_bytes_for_threads_passes_and_crops() {
    let desc = room(PathReuse::Always);
    let (whole, stats) = render_with(&desc, 1, u32::MAX);
    for (threads, pass) in [(2, u32::MAX), (5, 1), (3, 2)] {
        let (again, counted) = render_with(&desc, threads, pass);
        assert!(whole.linear == again.linear, "{threads} threads, passes of {pass}");
        assert_eq!(stats, counted);
    }
    for crop in [[13, 9, 11, 7], [0, 0, 1, 1], [40, 20, 4, 7], [7, 8, 30, 1]] {
        let mut part = desc.clone();
        part.film.crop = Some(crop);
        let [left, top, width, height] = crop;
        let part = picture(&part).linear;
        assert_eq!(part.len() as u32, width * height);
        for (i, p) in part.iter().enumerate() {
            let (x, y) = (left + i as u32 % width, top + i as u32 / width);
            assert_eq!(*p, whole.linear[(y * WIDTH + x) as usize], "{x},{y} of {crop:?}");
        }
    }
}

#[test]
fn where_it_is_not_right_it_is_not_done() {
    for (what, from, to) in [
        ("motion", "radius = 0.4\n", "radius = 0.4\nmotion = { translate = [0.1, 0, 0] }\n"),
        ("a medium", "[material.wall]", "[background]\nmedium = { extinction = 0.05 }\n[material.wall]"),
        ("a clamp", "caustics = \"off\"", "caustics = \"off\", clamp_indirect = 1"),
        ("chance at once", "caustics = \"off\"", "caustics = \"off\", rr_start = 1"),
        ("adaptive", "antialias = \"monte-carlo\", samples = 5", "antialias = \"adaptive\""),
        ("direct light", "type = \"path\", caustics = \"off\"", "type = \"direct\""),
    ] {
        let text = ROOM.replace(from, to);
        assert_ne!(text, ROOM, "{what}");
        let mut desc = describe(&text);
        if let IntegratorDesc::Path(path) = &mut desc.integrator {
            path.reuse = PathReuse::Always;
        }
        assert!(!prepared(&desc).integrator.shares_paths(), "{what}");
        if let IntegratorDesc::Path(_) = desc.integrator {
            let shared = picture(&desc).linear;
            set(&mut desc, PathReuse::Off);
            assert!(shared == picture(&desc).linear, "{what}");
        }
    }
    assert!(prepared(&room(PathReuse::Always)).integrator.shares_paths());
}

/// The test that decides looks at noise: a room profits, a ball in the open does not.
#[test]
fn a_test_decides() {
    assert!(prepared(&room(PathReuse::Auto)).integrator.shares_paths());
    let desc = describe(
        "integrator = { type = \"path\" }\nfilm = { width = 64, height = 48, antialias = \"monte-carlo\", samples = 4 }\n\
         light = [{ type = \"environment\" }]\n\
         object = [{ type = \"sphere\", material = { type = \"metal\", roughness = 0.3 } }]\n",
    );
    assert!(!prepared(&desc).integrator.shares_paths());
}
