//! The settled picture is that of the offline render, to the byte.

use std::sync::Arc;
use std::time::Duration;

use turner::SceneDesc;
use turner::camera::CameraDesc;
use turner::film::{Antialias, Aov, Aovs, Denoise};
use turner::integrator::IntegratorDesc;
use turner_live::camera;
use turner_live::document::{Document, STARTS};
use turner_live::engine::{Engine, Look, Order, Stage};

use super::common::*;

#[test]
fn scenes_of_all_kinds() {
    let start = |name: &str, change: fn(&mut SceneDesc)| {
        let start = STARTS.iter().find(|start| start.name == name).unwrap();
        let mut desc = SceneDesc::clone(Document::start(start).unwrap().desc());
        (desc.film.width, desc.film.height) = (64, 48);
        change(&mut desc);
        Arc::new(desc)
    };
    let scenes = [
        ("path", balls("path", |_| {})),
        ("direct", balls("direct", |_| {})),
        ("denoised", balls("path", |desc| desc.film.denoise = Denoise::On)),
        ("denoised fast", balls("path", |desc| desc.film.denoise = Denoise::Fast)),
        ("adaptive", balls("path", |desc| (desc.film.adaptive_sampling, desc.film.samples) = (true, 16))),
        ("wide filter", balls("path", |desc| desc.film.filter = turner::filter::FilterKind::Gaussian)),
        ("cropped", balls("path", |desc| desc.film.crop = Some([10, 6, 31, 17]))),
        ("with AOVs", balls("path", |desc| desc.film.aovs = Aovs::new(&[Aov::Albedo, Aov::LightGroups]))),
        ("automatic exposure", balls("path", |desc| desc.film.auto_exposure = true)),
        ("grid", balls("path", |desc| desc.film.antialias = Antialias::Grid)),
        ("classic", start("The paper's example", |_| {})),
        ("classic, adaptive", start("The paper's example", |desc| desc.film.antialias = Antialias::Adaptive)),
        ("classic, mean", start("3. Two lights", |desc| desc.film.antialias = Antialias::Mean)),
        ("caustics", start("Pool", |desc| desc.film.samples = 2)),
        ("fog", start("Foggy beam", |desc| desc.film.samples = 2)),
    ];
    let engine = Engine::new(|| {});
    for (name, desc) in &scenes {
        let number = engine.order(order(desc));
        assert_same(name, &settled(&engine, number), &rendered(desc));
    }
}

#[test]
fn every_integrator_as_a_look_of_a_scene() {
    let desc = balls("path", |_| {});
    let engine = Engine::new(|| {});
    for entry in IntegratorDesc::DOC.entries {
        let look = Look { integrator: IntegratorDesc::of_type(entry.name), ..Look::default() };
        // Times differ from run to run.
        if entry.name == "cost" {
            continue;
        }
        let number = engine.order(Order { look: look.clone(), ..order(&desc) });
        assert_same(entry.name, &settled(&engine, number), &rendered_as(&desc, &look));
    }
}

#[test]
fn any_number_of_threads() {
    let desc = balls("path", |desc| desc.film.denoise = Denoise::On);
    let reference = rendered(&desc);
    for threads in [1, 2, 3, 8, 0] {
        let engine = Engine::new(|| {});
        let number = engine.order(Order { threads, ..order(&desc) });
        assert_same(&format!("{threads} threads"), &settled(&engine, number), &reference);
    }
}

/// The camera of the scene, turned by `angle`.
fn turned(desc: &SceneDesc, angle: f64) -> CameraDesc {
    let mut turned = desc.camera.clone().unwrap().value;
    camera::orbit(&mut turned, angle, 0.5 * angle);
    turned
}

#[test]
fn after_a_hundred_other_orders_in_between() {
    let desc = balls("path", |desc| desc.film.samples = 32);
    let reference = rendered(&desc);
    let engine = Engine::new(|| {});
    let mut random = Random(7);
    for i in 0..100 {
        let mut next = order(&desc);
        match random.below(5) {
            0 => next.look.camera = Some(turned(&desc, 0.01 * f64::from(i))),
            1 => {
                let mut moved = SceneDesc::clone(&desc);
                moved.camera = Some(turned(&desc, 0.02 * f64::from(i)).into());
                next.desc = Arc::new(moved);
            }
            2 => next.look.integrator = IntegratorDesc::of_type("normals"),
            3 => (next.size, next.paused) = ([random.below(400) as u32, random.below(400) as u32], true),
            _ => {}
        }
        next.moving = random.below(2) == 0;
        next.threads = random.below(4) as usize;
        engine.order(next);
        std::thread::sleep(Duration::from_millis(random.below(40)));
    }
    let number = engine.order(order(&desc));
    assert_same("after a hundred orders", &settled(&engine, number), &reference);
}

/// A movement that a click back ends before anything of it was prepared leaves the settled picture settled.
#[test]
fn away_and_back_at_once() {
    let desc = balls("path", |_| {});
    let reference = rendered(&desc);
    let engine = Engine::new(|| {});
    let mut number = engine.order(order(&desc));
    for i in 0..30 {
        assert_same("away and back", &settled(&engine, number), &reference);
        let look = Look { camera: Some(turned(&desc, 0.3)), ..Look::default() };
        engine.order(Order { look, moving: i % 2 == 0, ..order(&desc) });
        std::thread::sleep(Duration::from_micros(200 * i));
        number = engine.order(order(&desc));
    }
    assert_same("away and back", &settled(&engine, number), &reference);
}

#[test]
fn after_pauses() {
    let desc = balls("path", |desc| desc.film.samples = 64);
    let reference = rendered(&desc);
    let engine = Engine::new(|| {});
    for millis in [0, 1, 5, 20, 50, 100, 200, 300] {
        engine.order(Order { paused: true, ..order(&desc) });
        wait(&engine, || (engine.status().doing.is_empty() && engine.frame().is_some()).then_some(()));
        engine.order(order(&desc));
        std::thread::sleep(Duration::from_millis(millis));
    }
    // While it waits, nothing changes.
    let number = engine.order(Order { paused: true, ..order(&desc) });
    let before = frame_that(&engine, number, |_| true);
    std::thread::sleep(Duration::from_millis(300));
    assert!(Arc::ptr_eq(&before.picture, &engine.frame().unwrap().picture));
    let number = engine.order(order(&desc));
    assert_same("after pauses", &settled(&engine, number), &reference);
}

/// The exposure changes no sample: the film continues, so the finished picture is there with the first frame.
#[test]
fn a_change_of_the_display_continues_the_film() {
    let desc = balls("path", |desc| desc.film.samples = 48);
    let frames = Arc::new(std::sync::Mutex::new(Vec::<(u64, Stage)>::new()));
    let engine: Arc<std::sync::OnceLock<&'static Engine>> = Arc::default();
    let (seen, of_wake) = (Arc::clone(&frames), Arc::clone(&engine));
    // Called by the engine's thread after each frame, so that none is missed. The engine lives as long as the process.
    let started = Engine::new(move || {
        if let Some(frame) = of_wake.get().and_then(|engine| engine.frame()) {
            seen.lock().unwrap().push((frame.order, frame.stage));
        }
    });
    engine.set(Box::leak(Box::new(started))).ok().unwrap();
    let engine = *engine.get().unwrap();
    let first = engine.order(order(&desc));
    settled(engine, first);
    for exposure in [1.0, -0.5, 0.0] {
        let mut brighter = SceneDesc::clone(&desc);
        brighter.film.exposure = exposure;
        let brighter = Arc::new(brighter);
        let number = engine.order(order(&brighter));
        assert_same("another exposure", &settled(engine, number), &rendered(&brighter));
        let frames = frames.lock().unwrap();
        let own: Vec<Stage> =
            frames.iter().filter(|(order, _)| *order == number).map(|(_, stage)| *stage).collect();
        assert!(!own.is_empty() && own.iter().all(|stage| *stage == Stage::Settled), "{own:?}");
    }
}

/// An exposure that changes while the film is at work keeps its samples and changes the rest of the way.
#[test]
fn exposure_while_it_renders() {
    let desc = balls("path", |desc| desc.film.samples = 128);
    let engine = Engine::new(|| {});
    let mut last = Arc::clone(&desc);
    for i in 0..12 {
        let mut next = SceneDesc::clone(&desc);
        next.film.exposure = f64::from(i) * 0.1;
        last = Arc::new(next);
        engine.order(order(&last));
        std::thread::sleep(Duration::from_millis(60));
    }
    let number = engine.order(order(&last));
    assert_same("exposure at work", &settled(&engine, number), &rendered(&last));
}

#[test]
fn the_smallest_film_and_the_smallest_view() {
    let engine = Engine::new(|| {});
    for kind in ["path", "classic", "normals"] {
        let desc = balls(kind, |desc| (desc.film.width, desc.film.height) = (1, 1));
        let number = engine.order(order(&desc));
        assert_same("1 x 1", &settled(&engine, number), &rendered(&desc));
    }
    let desc = balls("path", |_| {});
    for size in [[0, 0], [1, 0], [0, 900], [1, 1], [100_000, 100_000]] {
        let number = engine.order(Order { size, moving: true, ..order(&desc) });
        let frame = frame_that(&engine, number, |_| true);
        assert!(frame.picture.width >= 1 && frame.picture.width <= 72, "{size:?}");
        let number = engine.order(Order { size, ..order(&desc) });
        assert_same(&format!("{size:?}"), &settled(&engine, number), &rendered(&desc));
    }
}
