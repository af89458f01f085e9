//! A recorded sample has the same bits as the rendered sample, its parts add up to it, and the samples add up to the
//! pixel.

use std::path::Path;

use turner::color::Spectrum;
use turner::description::SceneDesc;
use turner::film::Antialias;
use turner::integrator::classic::{RayEnd, RayKind, TreeRecord, replay_at};
use turner::integrator::{IntegratorDesc, Prepared};
use turner::render::{PixelRecord, pixel, sample};
use turner::schema::PrepareOptions;
use turner_io::scene::{LoadOptions, load};

use crate::classic::common::{describe, render_with};

fn bits(s: Spectrum) -> [u32; 3] {
    s.to_array().map(f32::to_bits)
}

fn prepared(desc: &SceneDesc) -> Prepared {
    desc.prepare(&PrepareOptions { threads: 1, ..Default::default() }).unwrap()
}

/// All classic scenes, at a small size.
fn classic_scenes() -> Vec<(String, SceneDesc)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/classic");
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|e| e == "toml"));
    paths.sort();
    let load = |path: &Path| {
        let mut desc = load(path, &LoadOptions::default()).map_err(|e| e.to_string()).unwrap().desc;
        (desc.film.width, desc.film.height) = (48, 36);
        (path.file_name().unwrap().to_string_lossy().into_owned(), desc)
    };
    paths.iter().map(|path| load(path)).collect()
}

/// Pixels spread over the picture, different for each salt.
fn places(salt: u32, (width, height): (u32, u32)) -> impl Iterator<Item = (u32, u32)> {
    let mut state = salt.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    std::iter::repeat_with(move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        ((state >> 8) % width, (state >> 20) % height)
    })
}

/// Traces a pixel's samples with a recorder and checks the records; returns the trees.
fn explained(scene: &Prepared, at: &PixelRecord, name: &str) -> Vec<TreeRecord> {
    let each = at.samples.iter().map(|s| {
        let tree = replay_at(scene, s.id, s.place).unwrap();
        let what = || format!("{name}: {},{} sample at {:?}", at.x, at.y, s.place);
        assert_eq!(bits(tree.sum()), bits(s.radiance.color), "{}: {tree:?}", what());
        assert_eq!(tree.radiance, s.radiance, "{}", what());
        assert_eq!(tree.unwritten, 0);
        check(&tree, &what());
        tree
    });
    each.collect()
}

/// Checks the consistency of a tree: each value follows from the others.
fn check(tree: &TreeRecord, what: &str) {
    for (i, ray) in tree.rays.iter().enumerate() {
        let parent = ray.parent.map(|p| &tree.rays[p as usize]);
        assert_eq!(parent.is_none(), i == 0 && ray.kind == RayKind::Camera, "{what}");
        if let Some(parent) = parent {
            let RayEnd::Hit(hit) = &parent.end else { panic!("{what}: ray {i} begins nowhere") };
            assert_eq!(ray.depth, parent.depth + 1);
            let share = hit.weights[if ray.kind == RayKind::Reflected { 1 } else { 2 }];
            assert_eq!(ray.weight, parent.weight * share, "{what}: ray {i}");
            assert!(ray.origin.distance(hit.p) <= 1e-6 * (1.0 + hit.p.length()), "{what}: ray {i}");
            // Reflected rays stay on the same side of the surface; refracted rays change it.
            let sides = ray.direction.dot(hit.ng) * parent.direction.dot(hit.ng);
            assert_eq!(sides < 0.0, ray.kind == RayKind::Reflected, "{what}: ray {i}");
        }
        let RayEnd::Hit(hit) = &ray.end else { continue };
        assert!((ray.origin + hit.t * ray.direction).distance(hit.p) < 1e-6 * (1.0 + hit.t), "{what}");
        assert_eq!(hit.entering, ray.direction.dot(hit.ng) <= 0.0);
        let local = hit.lights.iter().fold(hit.ambient, |sum, term| sum + term.added);
        assert_eq!(bits(local), bits(hit.local), "{what}: ray {i}");
        match hit.contribution {
            Some(c) => assert_eq!(bits(c), bits(hit.local * (ray.weight * hit.weights[0]) as f32), "{what}"),
            None => assert_eq!(hit.weights[0], 0.0),
        }
        for term in &hit.lights {
            let blocked = term.shadow.as_ref().is_some_and(|s| s.through.is_black());
            let casters = term.shadow.iter().flat_map(|s| &s.casters).count();
            assert!(!blocked || casters > 0, "{what}: a shadow of nothing: {term:?}");
            let lit = term.reaches && term.n_dot_l > 0.0 && !term.diffuse.is_black();
            assert!(!lit || term.shadow.is_some() || !term.added.is_black(), "{what}: {term:?}");
        }
    }
}

#[test]
fn every_classic_scene_is_explained_to_the_last_bit() {
    let mut met = [false; 3];
    for (i, (name, desc)) in classic_scenes().into_iter().enumerate() {
        let size = (desc.film.width, desc.film.height);
        let modes = ["none", "mean", "grid", "adaptive", "monte-carlo"];
        // The scene's own integrator is tested at more pixels than the others.
        let own = desc.film.antialias.word();
        for mode in modes {
            let mut desc = desc.clone();
            desc.film.antialias = match mode {
                "none" => Antialias::None,
                "mean" => Antialias::Mean,
                "grid" => Antialias::Grid,
                "adaptive" => Antialias::Adaptive,
                _ => Antialias::MonteCarlo,
            };
            desc.film.samples = 4;
            let scene = prepared(&desc);
            let IntegratorDesc::Classic(integrator) = &desc.integrator else { panic!("{name}") };
            let picture = render_with(&desc, 2, u32::MAX).0;
            for (x, y) in places(i as u32, size).take(if mode == own { 40 } else { 10 }) {
                let at = pixel(&scene, x, y).unwrap();
                let shown = picture.linear[(y * size.0 + x) as usize];
                assert_eq!(at.color.map(f32::to_bits), shown.map(f32::to_bits), "{name} {mode}: {x},{y}");
                assert_eq!(at.count, at.samples.len() as u64);
                let shares: f64 = at.samples.iter().map(|s| s.weight).sum();
                assert!((shares - 1.0).abs() < 1e-12, "{name} {mode}: {shares}");
                let mean = |c: fn(&Spectrum) -> f32| {
                    at.samples.iter().map(|s| s.weight * f64::from(c(&s.radiance.color))).sum::<f64>()
                };
                for (mean, shown) in [mean(|c| c.r), mean(|c| c.g), mean(|c| c.b)].into_iter().zip(at.color) {
                    assert!((mean - f64::from(shown)).abs() < 1e-6, "{name} {mode}: {mean} {shown}");
                }
                for tree in explained(&scene, &at, &format!("{name} {mode}")) {
                    assert!(tree.rays.iter().all(|ray| ray.depth <= integrator.max_depth));
                    for ray in &tree.rays {
                        met[0] |= ray.kind == RayKind::Reflected;
                        met[1] |= ray.kind == RayKind::Refracted;
                        let RayEnd::Hit(hit) = &ray.end else { continue };
                        met[2] |= hit
                            .lights
                            .iter()
                            .any(|l| l.shadow.as_ref().is_some_and(|s| s.through.is_black()));
                    }
                }
            }
        }
    }
    assert_eq!(met, [true; 3]);
}

#[test]
fn what_a_tree_says_is_the_scene() {
    let text = r#"
        camera = { position = [0, 1, 6], look_at = [0, 1, 0] }
        film = { width = 3, height = 3 }
        integrator = { max_depth = 3 }
        [[object]]
        name = "ball"
        type = "sphere"
        center = [0, 1, 0]
        material = { color = "white", kd = 0.5, ks = 0.25, k_reflect = 0.5, k_local = 1 }
        [[object]]
        name = "floor"
        type = "plane"
        [[object]]
        name = "screen"
        type = "box"
        min = [-1, 3, -1]
        max = [1, 3.5, 4]
        [[light]]
        type = "point"
        position = [0, 9, 3]
        [[light]]
        type = "directional"
        from = [0, 0, 1]
    "#;
    let scene = prepared(&describe(text));
    let at = pixel(&scene, 1, 1).unwrap();
    assert_eq!((at.count, at.samples[0].weight), (1, 1.0));
    let tree = &explained(&scene, &at, "by hand")[0];
    let RayEnd::Hit(hit) = &tree.rays[0].end else { panic!("{tree:?}") };
    assert_eq!(scene.scene.object_name(hit.primitive).own, Some("ball"));
    assert_eq!((hit.shape, hit.t, hit.entering), ("sphere", 5.0, true));
    assert_eq!(hit.weights, [1.0, 0.5, 0.0]);
    let [above, front] = &hit.lights[..] else { panic!("{hit:?}") };
    // The first light is behind the screen; the second one faces the ball.
    let shadow = above.shadow.as_ref().unwrap();
    assert!(shadow.through.is_black() && above.added.is_black());
    assert_eq!(scene.scene.object_name(shadow.casters[0].primitive).own, Some("screen"));
    assert_eq!((shadow.casters.len(), shadow.t_max), (1, 1.0));
    assert_eq!((front.n_dot_l, front.r_dot_v), (1.0, 1.0));
    assert_eq!((front.diffuse.r, front.highlight.r, front.added.r), (0.5, 0.25, 0.75));
    // The reflected ray goes back past the camera and leaves the scene.
    assert_eq!((tree.rays.len(), tree.rays[1].kind, tree.rays[1].parent), (2, RayKind::Reflected, Some(0)));
    assert!(matches!(tree.rays[1].end, RayEnd::Miss(_)));
    assert_eq!(bits(sample(&scene, 1, 1, 0).unwrap().color), bits(tree.sum()));
    assert_eq!(scene.scene.light_sources, [Some(0), Some(1)]);
}

#[test]
fn total_internal_reflection_is_said() {
    let text = r#"
        camera = { position = [0, 0, 0], look_at = [1, 0, -0.95] }
        film = { width = 3, height = 3 }
        integrator = { max_depth = 2 }
        [[object]]
        type = "box"
        min = [-1, -1, -1]
        max = [1, 1, 1]
        material = { color = "white", k_refract = 1, k_local = 0, ior = 1.5 }
    "#;
    let scene = prepared(&describe(text));
    let tree = &explained(&scene, &pixel(&scene, 1, 1).unwrap(), "in glass")[0];
    // Twice beyond the critical angle of 41.8°; then the recursion ends.
    assert_eq!(tree.rays.iter().map(|r| r.kind).collect::<Vec<_>>()[1..], [RayKind::Reflected; 2]);
    for (i, ray) in tree.rays.iter().enumerate() {
        let RayEnd::Hit(hit) = &ray.end else { panic!("{tree:?}") };
        assert!(hit.total_internal_reflection && !hit.entering);
        assert_eq!((hit.weights, hit.cut.len()), ([0.0, 1.0, 0.0], usize::from(i == 2)));
    }
    let outside = describe(&text.replace("[0, 0, 0]", "[4, 0, 0]").replace("-0.95", "0"));
    let tree =
        replay_at(&prepared(&outside), pixel(&prepared(&outside), 1, 1).unwrap().samples[0].id, [1.5, 1.5]);
    let RayEnd::Hit(hit) = &tree.unwrap().rays[0].end.clone() else { panic!() };
    assert!(!hit.total_internal_reflection && hit.entering);
}
