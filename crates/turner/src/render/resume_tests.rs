//! Passes that are cancelled, continued, split and merged always give the film of an uninterrupted render.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use proptest::prelude::*;

use super::{PassOptions, PassRange, Renderer, TileSet};
use crate::color::Spectrum;
use crate::description::{ObjectDesc, SceneDesc, SceneLight};
use crate::film::{Antialias, Aov, Aovs, Film, Fireflies, SampleSet};
use crate::filter::FilterKind;
use crate::integrator::{Caustics, IntegratorDesc, PathDesc, Prepared, SharedPathsMode};
use crate::light::{LightDesc, PointDesc};
use crate::material::{MaterialDesc, PrincipledMaterial};
use crate::math::DVec3;
use crate::schema::{ColorSource, ErrorCode, Limits, MaterialId, Named, PrepareOptions};
use crate::shape::{PlaneDesc, ShapeDesc, SphereDesc};

pub(super) const KINDS: [&str; 16] = [
    "path",
    "shared-paths",
    "light",
    "photons",
    "adaptive",
    "one",
    "tent",
    "light-gaussian",
    "shared-wide",
    "aovs",
    "shared-aovs",
    "tent-aovs",
    "adaptive-aovs",
    "one-aovs",
    "fireflies",
    "tent-fireflies",
];

/// A glass sphere and a diffuse one on a floor under a point light.
pub(super) fn scene(kind: &str) -> Prepared {
    let mut desc = SceneDesc::default();
    (desc.film.width, desc.film.height) = (53, 37);
    (desc.film.antialias, desc.film.samples) = (Antialias::MonteCarlo, 6);
    let (mut caustics, mut shared_paths) = (Caustics::Off, SharedPathsMode::Off);
    if kind.ends_with("aovs") {
        desc.film.aovs = Aovs::new(&Aov::all().collect::<Vec<_>>());
    }
    if kind.ends_with("fireflies") {
        desc.film.fireflies = Fireflies::Remove;
    }
    match kind {
        "shared-aovs" | "shared-paths" => shared_paths = SharedPathsMode::Always,
        "shared-wide" => {
            shared_paths = SharedPathsMode::Always;
            (desc.film.filter, desc.film.filter_radius) = (FilterKind::BlackmanHarris, Some(3.5));
        }
        "tent" | "tent-aovs" | "tent-fireflies" => desc.film.filter = FilterKind::Tent,
        "light" => caustics = Caustics::LightTracing,
        "light-gaussian" => {
            (caustics, desc.film.filter) = (Caustics::LightTracing, FilterKind::Gaussian);
        }
        "photons" => (caustics, desc.film.samples) = (Caustics::Full, 3),
        "adaptive" | "adaptive-aovs" => {
            (desc.film.antialias, desc.film.max_subdivisions) = (Antialias::Adaptive, 2)
        }
        "one" | "one-aovs" => desc.film.antialias = Antialias::None,
        _ => {}
    }
    desc.integrator =
        IntegratorDesc::Path(PathDesc { caustics, shared_paths, max_depth: 5, ..PathDesc::default() });
    desc.background.color = Spectrum::grey(0.1);
    let white = ColorSource::Constant(Spectrum::WHITE);
    let glass = PrincipledMaterial {
        transmission_weight: white,
        specular_roughness: ColorSource::Constant(Spectrum::BLACK),
        ..PrincipledMaterial::default()
    };
    for material in [PrincipledMaterial::default(), glass] {
        desc.materials.push(Named { name: None, span: None, value: MaterialDesc::Principled(material) });
    }
    let ball = |x: f64| ShapeDesc::Sphere(SphereDesc { center: DVec3::new(x, 0.0, 0.0), radius: 0.5 });
    let floor = PlaneDesc { point: DVec3::new(0.0, -0.5, 0.0), normal: DVec3::Y };
    for (shape, material) in [(ball(-0.6), 1), (ball(0.6), 0), (ShapeDesc::Plane(floor), 0)] {
        desc.objects.push(ObjectDesc { material: Some(MaterialId(material)), ..ObjectDesc::new(shape) });
    }
    let light = PointDesc { position: DVec3::new(-1.0, 3.0, 2.0), intensity: 3.0, ..PointDesc::default() };
    desc.lights.push(SceneLight {
        motion: None,
        name: None,
        group: None,
        span: None,
        hidden: false,
        value: LightDesc::Point(light),
    });
    let scene = desc.prepare(&PrepareOptions::default()).unwrap();
    assert_eq!(
        scene.path().is_some_and(|path| path.caustics().is_some()),
        ["light", "photons", "light-gaussian"].contains(&kind),
        "{kind}"
    );
    assert_eq!(scene.integrator.shares_paths(), kind.starts_with("shared"));
    scene
}

pub(super) fn complete_film(scene: &Prepared) -> Film {
    let mut renderer = Renderer::new(scene.clone()).unwrap();
    let options = PassOptions { threads: 2, cancel: &AtomicBool::new(false), progress: None };
    assert!(renderer.pass(u32::MAX, &options).unwrap() && renderer.is_complete());
    renderer.film
}

/// Cancels one pass after another when some tasks are done, then completes the render.
fn interrupted(scene: &Prepared, threads: usize, samples: u32, stops: &[usize]) -> Renderer {
    let mut renderer = Renderer::new(scene.clone()).unwrap();
    for stop in stops {
        let cancel = AtomicBool::new(*stop == 0);
        let progress = |done: usize, _: usize| cancel.store(done >= *stop, Ordering::Relaxed);
        let options = PassOptions { threads, cancel: &cancel, progress: Some(&progress) };
        renderer.pass(samples, &options).unwrap();
    }
    let options = PassOptions { threads, cancel: &AtomicBool::new(false), progress: None };
    while !renderer.is_complete() {
        assert!(renderer.pass(samples, &options).unwrap());
    }
    renderer
}

#[test]
fn a_cancelled_pass_that_continues_counts_nothing_twice() {
    for kind in KINDS {
        let scene = scene(kind);
        let uninterrupted = complete_film(&scene);
        for (threads, samples, stops) in
            [(1, 2, &[3][..]), (2, 6, &[1, 0, 5, 2]), (2, 1, &[7, 2, 2, 9]), (1, u32::MAX, &[13, 1])]
        {
            let renderer = interrupted(&scene, threads, samples, stops);
            assert_eq!(renderer.film.samples(), uninterrupted.samples(), "{kind}");
            assert!(
                renderer.film.to_bytes() == uninterrupted.to_bytes(),
                "{kind}: {threads} {samples} {stops:?}"
            );
            let (a, b) =
                (renderer.film.develop(&scene.view.film, 1), uninterrupted.develop(&scene.view.film, 1));
            assert!(a == b, "{kind}");
        }
    }
}

/// One tile of thousands of samples, cancelled at random moments: finished samples stay and are known.
#[test]
fn a_tile_cancelled_in_the_middle_keeps_its_finished_samples() {
    let mut scene = scene("path");
    (scene.view.film.width, scene.view.film.height, scene.view.film.samples) = (16, 16, 3000);
    let uninterrupted = complete_film(&scene);
    let mut renderer = Renderer::new(scene.clone()).unwrap();
    let mut held = Vec::new();
    for _ in 0..3 {
        let cancel = AtomicBool::new(false);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                std::thread::sleep(Duration::from_millis(20));
                cancel.store(true, Ordering::Relaxed);
            });
            let options = PassOptions { threads: 1, cancel: &cancel, progress: None };
            renderer.pass(u32::MAX, &options).unwrap();
        });
        held.push(renderer.film.held(0).len());
    }
    assert!(0 < held[0] && held[0] < held[1] && held[2] < 3000, "{held:?}");
    let options = PassOptions { threads: 1, cancel: &AtomicBool::new(false), progress: None };
    assert!(renderer.pass(u32::MAX, &options).unwrap());
    assert!(renderer.film.to_bytes() == uninterrupted.to_bytes());
}

#[test]
fn passes_over_tiles_and_samples_skip_what_is_there() {
    let scene = scene("light");
    let (never, parts) = (AtomicBool::new(false), AtomicUsize::new(0));
    let count = |_: usize, all: usize| parts.store(all, Ordering::Relaxed);
    let options = PassOptions { threads: 1, cancel: &never, progress: Some(&count) };
    let mut renderer = Renderer::new(scene.clone()).unwrap();
    let some = PassRange { samples: 1..4, tiles: TileSet::Some(vec![5, 2, 5, 9999]) };
    assert!(renderer.pass_over(&some, &options).unwrap());
    assert_eq!(parts.load(Ordering::Relaxed), 2, "two tiles, and no light without tile 0");
    let held: Vec<u64> = (0..renderer.film.tiles().count()).map(|t| renderer.film.held(t).len()).collect();
    assert_eq!(held, [0, 0, 3, 0, 0, 3, 0, 0, 0, 0, 0, 0]);
    assert!(renderer.film.splats().unwrap().held().is_empty());
    let rays = renderer.stats.total();
    assert!(renderer.pass_over(&some, &options).unwrap());
    assert_eq!(renderer.stats.total(), rays, "nothing is traced again");
    assert!(renderer.pass_over(&PassRange::all_tiles(2..3), &options).unwrap());
    assert_eq!(renderer.film.splats().unwrap().held().ranges().len(), 1);
    assert!(renderer.pass(u32::MAX, &options).unwrap() && renderer.is_complete());
    assert!(renderer.film.to_bytes() == complete_film(&scene).to_bytes());
}

/// Each (tile, sample index) is rendered into one of several films; then all are merged.
fn split_and_merged(scene: &Prepared, owners: &[u8], order: &[usize]) -> Film {
    let never = AtomicBool::new(false);
    let options = PassOptions { threads: 2, cancel: &never, progress: None };
    let mut parts: Vec<Renderer> = order.iter().map(|_| Renderer::new(scene.clone()).unwrap()).collect();
    let (tiles, samples) = (parts[0].film.tiles().count(), scene.view.film.samples_per_pixel());
    for sample in 0..samples {
        for (owner, part) in parts.iter_mut().enumerate() {
            let owned = |tile: &u32| {
                let position = sample as usize * tiles + *tile as usize;
                usize::from(owners[position * 7 % owners.len()]) % order.len() == owner
            };
            let tiles = TileSet::Some((0..tiles as u32).filter(owned).collect());
            assert!(part.pass_over(&PassRange { samples: sample..sample + 1, tiles }, &options).unwrap());
        }
    }
    let mut film = Renderer::new(scene.clone()).unwrap().film;
    for part in order {
        let bytes = parts[*part].film.to_bytes();
        film.merge(&Film::from_bytes(&bytes, &Limits::default()).unwrap()).unwrap();
    }
    film
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6, ..ProptestConfig::default() })]

    #[test]
    fn any_split_by_samples_and_tiles_merges_to_the_complete_film(
        owners in proptest::collection::vec(any::<u8>(), 5..90),
        order in Just(vec![0usize, 1, 2]).prop_shuffle(),
        kind in proptest::sample::select(&KINDS[..]),
    ) {
        let scene = scene(kind);
        let (merged, uninterrupted) = (split_and_merged(&scene, &owners, &order), complete_film(&scene));
        prop_assert!(merged.to_bytes() == uninterrupted.to_bytes(), "{}", kind);
        prop_assert_eq!(merged.develop(&scene.view.film, 1), uninterrupted.develop(&scene.view.film, 1));
    }

    #[test]
    fn any_cancels_leave_the_film_of_an_uninterrupted_render(
        stops in proptest::collection::vec(0usize..16, 0..6),
        samples in 1u32..8,
        threads in 1usize..4,
        kind in proptest::sample::select(&KINDS[..]),
    ) {
        let scene = scene(kind);
        let renderer = interrupted(&scene, threads, samples, &stops);
        prop_assert!(renderer.film.to_bytes() == complete_film(&scene).to_bytes(), "{}", kind);
    }
}

#[test]
fn renderers_of_one_scene_share_its_choices() {
    let options = PassOptions { threads: 1, cancel: &AtomicBool::new(false), progress: None };
    for kind in ["light", "photons", "shared-paths"] {
        let scene = scene(kind);
        // Both exist before the choice.
        let [mut first, mut second] = [(); 2].map(|()| {
            let mut renderer = Renderer::new(scene.clone()).unwrap();
            move || {
                renderer.pass(2, &options).unwrap();
                renderer.film.to_bytes()
            }
        });
        assert!(first() == second(), "{kind}");
    }
}

#[test]
fn merging_refuses_samples_twice_and_other_pictures() {
    let scene = scene("light");
    let never = AtomicBool::new(false);
    let options = PassOptions { threads: 2, cancel: &never, progress: None };
    let part = |samples, tiles| {
        let mut renderer = Renderer::new(scene.clone()).unwrap();
        renderer.pass_over(&PassRange { samples, tiles }, &options).unwrap();
        renderer.film
    };
    let mut film = part(0..3, TileSet::Some(vec![4, 6]));
    let before = film.to_bytes();
    let error = film.merge(&part(1..6, TileSet::Some(vec![1, 6]))).unwrap_err();
    assert_eq!(error.code, ErrorCode::Conflict);
    assert_eq!(error.message, "both films hold samples 1 to 2 of tile 6, 16x16 pixels at (32, 16)");
    assert!(film.to_bytes() == before, "an error changes nothing");
    let each = film.identity().light_paths;
    let mut light = part(2..4, TileSet::Some(vec![0]));
    light.merge(&film).unwrap();
    // The tile is another one, but the light paths belong to tile 0, which is then complete.
    let error = light.merge(&part(3..4, TileSet::Some(vec![0]))).unwrap_err();
    assert_eq!(error.message, "both films hold samples 3 to 3 of tile 0, 16x16 pixels at (0, 0)");
    let mut paths = SampleSet::default();
    paths.insert(2 * each..4 * each);
    assert_eq!(*light.splats().unwrap().held(), paths);

    let mut refuse = |change: &dyn Fn(&mut Prepared), what: &str| {
        let mut other = self::scene("light");
        change(&mut other);
        let error = film.merge(&Renderer::new(other.clone()).unwrap().film).unwrap_err();
        assert_eq!(error.message, format!("the films are of different pictures; {what}"));
        assert!(error.help.is_some_and(|help| help.contains("same settings")));
        let error = Renderer::resume(other.clone(), film.clone()).err().unwrap();
        assert!(error.help.is_some_and(|help| help.contains("same settings")));
        let resumed = error.message;
        assert!(resumed.starts_with("the film is of another picture; "), "{resumed}");
    };
    refuse(&|s| s.view.film.seed = 8, "seed: 0 and 8");
    refuse(&|s| s.view.film.samples = 9, "samples per pixel: 6 and 9");
    refuse(&|s| s.view.film.width = 54, "size: 53x37 and 54x37");
    refuse(
        &|s| s.view.film.crop = Some([2, 3, 20, 30]),
        "part that is rendered: 53x37 pixels at (0, 0) and 20x30 pixels at (2, 3)",
    );
    refuse(
        &|s| s.view.film.clamp_sample = 2.0,
        "anti-aliasing, filter, shutter or another setting of sampling",
    );
    let without = |s: &mut Prepared| {
        let path =
            PathDesc { caustics: Caustics::Off, shared_paths: SharedPathsMode::Off, ..PathDesc::default() };
        *s = s.with_integrator(&path).unwrap();
    };
    refuse(&without, &format!("light paths per sample: {each} and 0"));
    film.set_scene(0x1234);
    let error = film.merge(&Renderer::new(scene.clone()).unwrap().film).unwrap_err();
    assert_eq!(error.message, "the films are of different pictures; scene: 0000000000001234 and none");
}

/// A saved film is continued by another renderer.
#[test]
fn a_film_read_from_bytes_continues() {
    let scene = scene("photons");
    let never = AtomicBool::new(false);
    let options = PassOptions { threads: 2, cancel: &never, progress: None };
    let mut first = Renderer::new(scene.clone()).unwrap();
    assert!(first.pass(2, &options).unwrap());
    let film = Film::from_bytes(&first.film.to_bytes(), &Limits::default()).unwrap();
    let mut second = Renderer::resume(scene.clone(), film).unwrap();
    assert!(second.pass(u32::MAX, &options).unwrap() && second.is_complete());
    assert!(second.film.to_bytes() == complete_film(&scene).to_bytes());
}

#[test]
fn a_preview_shows_every_pixel_and_changes_no_byte() {
    for kind in KINDS {
        let scene = scene(kind);
        let never = AtomicBool::new(false);
        let options = PassOptions { threads: 2, cancel: &never, progress: None };
        let mut renderer = Renderer::new(scene.clone()).unwrap();
        assert!(renderer.preview_pass(&options).unwrap());
        let (coarse, rays) = (renderer.develop(), renderer.stats.camera);
        assert_eq!((coarse.missing, rays, renderer.film.samples()), (0, 14 * 10, 0), "{kind}");
        // Blocks of 4 x 4 pixels have one colour; the picture does not.
        for y in 0..37usize {
            for x in 0..53 {
                assert_eq!(coarse.linear[y * 53 + x], coarse.linear[(y - y % 4) * 53 + (x - x % 4)]);
            }
        }
        assert!(coarse.linear.iter().any(|p| *p != coarse.linear[0]));
        if kind == "one" {
            let finished = complete_film(&scene).develop(&scene.view.film, 1);
            assert!((0..37).step_by(4).all(|y| coarse.linear[y * 53 + 8] == finished.linear[y * 53 + 8]));
        }
        // Tiles with samples show them.
        let tile = PassRange { samples: 0..1, tiles: TileSet::Some(vec![5]) };
        assert!(renderer.pass_over(&tile, &options).unwrap());
        let mixed = renderer.develop();
        assert_eq!((mixed.linear[0], mixed.missing), (coarse.linear[0], 0));
        assert!((16..32).any(|x| mixed.linear[20 * 53 + x] != coarse.linear[20 * 53 + x]), "{kind}");
        assert!(renderer.pass(u32::MAX, &options).unwrap() && renderer.is_complete());
        let uninterrupted = complete_film(&scene);
        // Where pixels do not share paths, no sample is traced twice.
        let pixels = u64::from(scene.view.film.samples_per_pixel()) * 53 * 37;
        match kind {
            "path" | "light" | "one" | "tent" | "light-gaussian" | "fireflies" | "tent-fireflies" => {
                assert_eq!(renderer.stats.camera, pixels, "{kind}")
            }
            "photons" => assert_eq!(renderer.stats.camera, pixels + rays),
            _ => assert!(renderer.stats.camera > pixels, "{kind}"),
        }
        assert!(renderer.film.to_bytes() == uninterrupted.to_bytes(), "{kind}");
        assert!(
            renderer.film.develop(&scene.view.film, 1) == uninterrupted.develop(&scene.view.film, 1),
            "{kind}"
        );
    }
}

#[test]
fn a_cancelled_preview_is_coarser() {
    let scene = scene("path");
    let cancel = AtomicBool::new(false);
    for (rows, missing) in [(1, 53 * (37 - 32)), (2, 0)] {
        let stop = |done: usize, _: usize| cancel.store(done == rows, Ordering::Relaxed);
        let options = PassOptions { threads: 1, cancel: &cancel, progress: Some(&stop) };
        let mut renderer = Renderer::new(scene.clone()).unwrap();
        cancel.store(false, Ordering::Relaxed);
        assert!(!renderer.preview_pass(&options).unwrap());
        let coarse = renderer.develop();
        assert_eq!((coarse.missing, renderer.is_covered()), (missing, rows == 2));
        // Blocks of 32 x 32 pixels have one colour.
        assert!((0..32 * 53).all(|i| coarse.linear[i] == coarse.linear[i % 53 / 32 * 32]));
    }
}
