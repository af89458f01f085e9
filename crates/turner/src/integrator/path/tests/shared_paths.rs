//! Shared paths: the same light with less noise, and the same bytes for any tiles, crops, threads and passes.

use crate::color::Spectrum;
use crate::description::{ObjectDesc, SceneDesc};
use crate::film::{Antialias, Picture, PixelSum};
use crate::integrator::path::{DonorPart, DonorRecord, PathRecord, replay};
use crate::integrator::{Caustics, DirectDesc, IntegratorDesc, PathDesc, Prepared, SharedPathsMode};
use crate::light::{EnvironmentDesc, LightDesc};
use crate::material::{AlphaMode, DielectricMaterial, MetalMaterial, PrincipledMaterial};
use crate::math::{DAffine3, DVec3};
use crate::medium::HomogeneousMedium;
use crate::render::sample;
use crate::schema::{MeshData, PrepareOptions, Transform};
use crate::testing::scenes::{
    called, cuboid, emissive, even, grey, matte, mean_of, path, rectangle, render, render_prepared, rgb,
    sphere, v,
};
use crate::texture::{CheckerboardDesc, TextureDesc};

const WIDTH: u32 = 44;
const HEIGHT: u32 = 27;

/// Diffuse walls and a light.
fn empty_room() -> SceneDesc {
    path(PathDesc { caustics: Caustics::Off, ..PathDesc::default() })
        .seen_at(v(0.0, 1.0, 3.6), v(0.0, 0.9, 0.0), 48.0)
        .filmed([WIDTH, HEIGHT], 5)
        .with(cuboid(v(-1.2, 0.0, -1.0), v(1.2, 2.0, 4.0)), matte(rgb([0.8, 0.6, 0.4])))
        .with(rectangle(v(0.3, 1.98, 0.5), v(0.4, 0.0, 0.0), v(0.0, 0.0, 0.4)), emissive(12.0, grey(1.0)))
}

/// A room with diffuse walls, a smooth mesh, a textured ball, glass, a rough mirror, stochastic opacity and a glass
/// pane.
fn room(shared_paths: SharedPathsMode) -> SceneDesc {
    let mut desc = empty_room();
    set(&mut desc, shared_paths);
    let board =
        CheckerboardDesc { even: called("ivory"), odd: called("tomato"), density: 8.0, ..Default::default() };
    let board = desc.texture(TextureDesc::Checkerboard(board));
    let mesh = desc.mesh(MeshData {
        positions: vec![[0.2, 0.0, 0.2], [0.9, 0.0, 0.4], [0.6, 0.9, 0.0], [0.5, 0.0, -0.4]],
        normals: vec![[-0.5, 0.2, 0.6], [0.6, 0.2, 0.6], [0.0, 1.0, 0.1], [0.0, 0.2, -1.0]],
        triangles: vec![[0, 1, 2], [1, 3, 2], [3, 0, 2]],
        ..MeshData::default()
    });
    let sheet = PrincipledMaterial {
        alpha_mode: AlphaMode::Blend,
        opacity: grey(0.5),
        ..matte(rgb([0.6, 0.9, 0.6]))
    };
    let pane = DielectricMaterial { thin: true, ..DielectricMaterial::default() };
    desc.with(sphere(v(-0.5, 0.4, 0.0), 0.4), matte(board))
        .with(mesh, matte(rgb([0.3, 0.5, 0.8])))
        .with(sphere(v(0.1, 0.2, 0.9), 0.2), DielectricMaterial::default())
        .with(rectangle(v(-0.8, 0.9, 0.8), v(0.5, 0.0, 0.0), v(0.0, 0.9, 0.1)), sheet)
        .with(rectangle(v(0.9, 1.2, 1.0), v(0.5, 0.0, 0.1), v(0.0, 0.8, 0.0)), pane)
}

/// A room of plastic, rough and smooth, with metal and a mirror, lit by a lamp and a bright ball.
fn glossy_room(shared_paths: SharedPathsMode) -> SceneDesc {
    let plastic = |color: [f64; 3], roughness: f64| PrincipledMaterial {
        base_color: rgb(color),
        specular_roughness: grey(roughness),
        ..PrincipledMaterial::default()
    };
    let metal = |roughness: f64| MetalMaterial { roughness: grey(roughness), ..MetalMaterial::default() };
    let room = cuboid(v(-1.2, 0.0, -1.0), v(1.2, 2.0, 4.0));
    let caustics = Caustics::Off;
    path(PathDesc { caustics, shared_paths, ..PathDesc::default() })
        .seen_at(v(0.0, 1.0, 3.6), v(0.0, 0.9, 0.0), 48.0)
        .filmed([WIDTH, HEIGHT], 5)
        .with(room, plastic([0.8, 0.6, 0.4], 0.3))
        .with(cuboid(v(-1.0, 0.0, -0.5), v(1.0, 0.1, 1.5)), plastic([0.2, 0.3, 0.6], 0.12))
        .with(sphere(v(-0.5, 0.5, 0.0), 0.4), plastic([0.6, 0.1, 0.1], 0.0))
        .with(sphere(v(0.5, 0.4, 0.3), 0.3), metal(0.3))
        .with(rectangle(v(0.9, 1.2, 0.0), v(0.3, 0.0, 0.9), v(0.0, 0.8, 0.0)), metal(0.0))
        .with(sphere(v(0.3, 1.3, -0.3), 0.1), emissive(9.0, rgb([1.0, 0.8, 0.6])))
        .with(rectangle(v(0.3, 1.98, 0.5), v(0.4, 0.0, 0.0), v(0.0, 0.0, 0.4)), emissive(12.0, grey(1.0)))
}

type Room = fn(SharedPathsMode) -> SceneDesc;

/// Rooms, and numbers of pixels that share paths.
const CASES: [(Room, u32); 4] = [(room, 16), (glossy_room, 16), (room, 8), (glossy_room, 4)];

/// A scene in which this number of pixels share paths.
fn shared_among(desc: &SceneDesc, size: u32) -> Prepared {
    let options = PrepareOptions { threads: 1, ..Default::default() };
    let scene = desc.prepare_unchosen(desc.integrator.integrator(), &options).unwrap();
    scene.path().unwrap().share_among(size);
    scene
}

fn settings(desc: &mut SceneDesc) -> &mut PathDesc {
    let IntegratorDesc::Path(path) = &mut desc.integrator else { panic!("path") };
    path
}

fn set(desc: &mut SceneDesc, shared_paths: SharedPathsMode) {
    settings(desc).shared_paths = shared_paths;
}

fn prepared(desc: &SceneDesc) -> Prepared {
    desc.prepare(&PrepareOptions { threads: 1, ..Default::default() }).unwrap()
}

fn picture(desc: &SceneDesc) -> Picture {
    render(desc).0
}

#[test]
fn samples_are_sums_of_their_own_path_and_of_donors() {
    let counts = CASES.map(|(room, size)| sums_of_samples(room, size));
    for ([donated, kept, neighbours, _], (_, size)) in counts.iter().zip(CASES) {
        let least = size as usize * donated / 3;
        assert!(*donated > 200 && *kept > 60 && *neighbours > least, "{counts:?}");
    }
    let [[.., without], [.., taken_back], ..] = counts;
    assert!(without == 0 && taken_back > 3, "{counts:?}");
}

/// Numbers of paths that are donated and not, of parts from neighbours, and of paths that continue for their own pixel.
fn sums_of_samples(room: Room, size: u32) -> [usize; 4] {
    let scene = shared_among(&room(SharedPathsMode::Always), size);
    let (picture, _) = render_prepared(scene.clone(), 2, u32::MAX);
    let (mut donated, mut kept, mut neighbours, mut taken_back) = (0, 0, 0, 0);
    for i in 0..160 {
        let (x, y) = (i * 17 % WIDTH, i * 5 % HEIGHT);
        let mut pixel = PixelSum::default();
        for index in 0..5 {
            let path = replay(&scene, x, y, index).unwrap();
            let rendered = sample(&scene, x, y, index).unwrap();
            assert_eq!(path.sum(), rendered.color, "{x},{y} sample {index}");
            assert_eq!(path.radiance, rendered);
            assert!(pixel.add_or_omit(rendered.color, rendered.alpha));
            let shared = path.shared.as_ref().unwrap();
            let own: Vec<&DonorRecord> = shared.parts.iter().filter(|p| p.id == path.id).collect();
            match shared.from {
                Some(from) => {
                    donated += 1;
                    taken_back += usize::from(shared.until.is_some());
                    // The light found from there on is what the cluster shares.
                    for part in &own {
                        assert_eq!(
                            part.radiance,
                            found_from(&path, from, part.part),
                            "{x},{y} sample {index}"
                        );
                    }
                    let none = shared.until.is_none() && own.is_empty();
                    assert!(!none || found_from(&path, from, DonorPart::Radiance).is_black());
                }
                None => kept += usize::from(own.is_empty()),
            }
            neighbours += shared.parts.len() - own.len();
        }
        let shown = picture.linear[(y * WIDTH + x) as usize];
        assert_eq!(pixel.mean().unwrap(), shown, "{x},{y}");
    }
    [donated, kept, neighbours, taken_back]
}

/// The sum of a path's contributions from a vertex on, or one part of it.
fn found_from(path: &PathRecord, from: usize, part: DonorPart) -> Spectrum {
    let mut rest = path.clone();
    rest.shared = None;
    match part {
        DonorPart::Radiance => drop(rest.vertices.drain(..from)),
        DonorPart::Next => drop(rest.vertices.drain(..=from)),
        DonorPart::Direct => {
            let light = path.vertices[from].lights.first().filter(|l| l.visible.is_some());
            return light.map_or(Spectrum::BLACK, |l| l.contribution);
        }
    }
    rest.sum()
}

#[test]
fn the_mean_is_that_of_separate_paths() {
    CASES.into_iter().for_each(|(room, size)| compare_means(room, size));
}

fn compare_means(room: Room, size: u32) {
    const SEEDS: u32 = 48;
    // Sums over cells of 4 x 3 pixels, because the noise of pixels in a cell is correlated.
    let cells = |shared_paths: SharedPathsMode, first: u32| -> Vec<Vec<f64>> {
        (first..first + SEEDS)
            .map(|seed| {
                let mut desc = room(shared_paths);
                (desc.film.samples, desc.film.seed) = (4, seed);
                let size = if shared_paths == SharedPathsMode::Off { 1 } else { size };
                let (picture, _) = render_prepared(shared_among(&desc, size), 2, u32::MAX);
                let mut sums = vec![0.0; (11 * 9) as usize];
                for (i, p) in picture.linear.iter().enumerate() {
                    let (x, y) = (i as u32 % WIDTH, i as u32 / WIDTH);
                    sums[(y / 3 * 11 + x / 4) as usize] += f64::from(p[0] + p[1] + p[2]);
                }
                sums
            })
            .collect()
    };
    let (independent, shared) = (cells(SharedPathsMode::Off, 1), cells(SharedPathsMode::Always, 1001));
    let of = |runs: &[Vec<f64>], cell: usize| {
        let n = runs.len() as f64;
        let mean = runs.iter().map(|r| r[cell]).sum::<f64>() / n;
        let variance = runs.iter().map(|r| (r[cell] - mean) * (r[cell] - mean)).sum::<f64>() / (n - 1.0);
        (mean, variance / n)
    };
    let (mut squares, mut largest, mut variances) = (0.0, 0.0f64, [0.0; 2]);
    for cell in 0..99 {
        let ((a, va), (b, vb)) = (of(&independent, cell), of(&shared, cell));
        let z = (a - b) / (va + vb).sqrt();
        squares += z * z;
        largest = largest.max(z.abs());
        variances[0] += va / (a * a);
        variances[1] += vb / (a * a);
    }
    // 99 values with mean square 1 and a variance of a little more than 2 (Student's t).
    let rms = (squares / 99.0f64).sqrt();
    assert!((0.75..1.3).contains(&rms) && largest < 4.8, "rms {rms}, largest {largest}");
    // Sums over cells hide much of what small clusters gain.
    let most = if size == 16 { 0.8 } else { 0.9 };
    assert!(variances[1] < most * variances[0], "{variances:?}");
}

/// Whether a first vertex is one for its neighbours must not depend on its own path: that of smooth plastic often continues
/// by the delta lobe. Stripes a pixel wide, so that clusters hold plastic and white paint.
#[test]
fn smooth_plastic_beside_paint_keeps_the_mean() {
    let plastic = PrincipledMaterial {
        base_color: grey(0.03),
        specular_roughness: grey(0.0),
        ..PrincipledMaterial::default()
    };
    let by = |shared_paths| {
        let desc = path(PathDesc { caustics: Caustics::Off, shared_paths, ..PathDesc::default() })
            .seen_at(v(0.0, 1.0, 1.0), v(0.0, 1.0, 0.0), 60.0)
            .with(cuboid(v(-2.0, 0.0, -2.0), v(2.0, 2.0, 2.0)), matte(grey(0.7)))
            .with(rectangle(v(-1.0, 0.0, 0.0), v(2.0, 0.0, 0.0), v(0.0, 2.0, 0.0)), plastic.clone())
            .with(
                rectangle(v(-0.2, 0.0, 1.9), v(0.4, 0.0, 0.0), v(0.0, 0.4, 0.0)),
                emissive(12.0, grey(1.0)),
            );
        let desc = (0..24).fold(desc, |desc, i| {
            let left = v(-1.0 + f64::from(i) / 12.0, 0.0, 0.001);
            desc.with(rectangle(left, v(1.0 / 24.0, 0.0, 0.0), v(0.0, 2.0, 0.0)), matte(grey(0.9)))
        });
        mean_of(24, 512, desc)
    };
    by(SharedPathsMode::Always).agrees(&by(SharedPathsMode::Off), 0.02);
}

#[test]
fn pixels_have_less_noise() {
    // The empty room at higher resolution: most of its noise is indirect light.
    let noise = |shared_paths: SharedPathsMode| -> f64 {
        let of = |seed: u32| {
            let mut desc = empty_room().filmed([120, 90], 5);
            set(&mut desc, shared_paths);
            desc.film.seed = seed;
            picture(&desc).linear
        };
        let (a, b) = (of(1), of(2));
        let square = |(a, b): (&[f32; 4], &[f32; 4])| {
            f64::from((a[1] - b[1]) * (a[1] - b[1]) / (a[1] + b[1] + 0.1).powi(2))
        };
        a.iter().zip(&b).map(square).sum()
    };
    let (independent, shared) = (noise(SharedPathsMode::Off), noise(SharedPathsMode::Always));
    assert!(shared < 0.5 * independent, "{shared} {independent}");
}

#[test]
fn the_same_bytes_for_threads_passes_and_crops() {
    CASES.into_iter().for_each(|(room, size)| compare_bytes(room, size));
}

fn compare_bytes(room: Room, size: u32) {
    let desc = room(SharedPathsMode::Always);
    let (whole, stats) = render_prepared(shared_among(&desc, size), 1, u32::MAX);
    for (threads, pass) in [(2, u32::MAX), (5, 1), (3, 2)] {
        let (again, counted) = render_prepared(shared_among(&desc, size), threads, pass);
        assert!(whole.linear == again.linear, "{threads} threads, passes of {pass}");
        assert_eq!(stats, counted);
    }
    for crop in [[13, 9, 11, 7], [0, 0, 1, 1], [40, 20, 4, 7], [7, 8, 30, 1]] {
        let mut part = desc.clone();
        part.film.crop = Some(crop);
        let [left, top, width, height] = crop;
        let part = render_prepared(shared_among(&part, size), 2, u32::MAX).0.linear;
        assert_eq!(part.len() as u32, width * height);
        for (i, p) in part.iter().enumerate() {
            let (x, y) = (left + i as u32 % width, top + i as u32 / width);
            assert_eq!(*p, whole.linear[(y * WIDTH + x) as usize], "{x},{y} of {crop:?}");
        }
    }
}

#[test]
fn paths_are_not_shared_where_it_would_be_wrong() {
    type Change = fn(&mut SceneDesc);
    let cases: [(&str, Change); 6] = [
        ("motion", |desc| {
            let ball: &mut ObjectDesc = &mut desc.objects[2];
            ball.motion = Some(Transform(DAffine3::from_translation(v(0.1, 0.0, 0.0))));
        }),
        ("a medium", |desc| {
            let fog = HomogeneousMedium { extinction: even(0.05), ..HomogeneousMedium::default() };
            desc.background.medium = desc.medium(fog);
        }),
        ("a clamp", |desc| settings(desc).clamp_indirect = 1.0),
        ("chance at once", |desc| settings(desc).rr_start = Some(1)),
        ("adaptive", |desc| (desc.film.antialias, desc.film.samples) = (Antialias::Adaptive, 16)),
        ("direct light", |desc| desc.integrator = IntegratorDesc::Direct(DirectDesc::default())),
    ];
    for (what, change) in cases {
        let mut desc = room(SharedPathsMode::Always);
        change(&mut desc);
        assert!(!prepared(&desc).integrator.shares_paths(), "{what}");
        if let IntegratorDesc::Path(_) = desc.integrator {
            let shared = picture(&desc).linear;
            set(&mut desc, SharedPathsMode::Off);
            assert!(shared == picture(&desc).linear, "{what}");
        }
    }
    assert!(prepared(&room(SharedPathsMode::Always)).integrator.shares_paths());
}

/// The pilot run measures noise: an indoor room gains, a ball in the open does not.
#[test]
fn the_pilot_run_decides() {
    assert!(prepared(&room(SharedPathsMode::Auto)).integrator.shares_paths());
    let metal = MetalMaterial { roughness: grey(0.3), ..MetalMaterial::default() };
    let open = path(PathDesc::default())
        .filmed([64, 48], 4)
        .lit(LightDesc::Environment(EnvironmentDesc::default()))
        .with(sphere(DVec3::ZERO, 1.0), metal);
    assert!(!prepared(&open).integrator.shares_paths());
}
