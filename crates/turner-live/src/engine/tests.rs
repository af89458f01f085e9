use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use turner::{PassOptions, PrepareOptions, Renderer, SceneDesc};

use super::*;
use crate::document::{Document, STARTS};

fn start(name: &str, size: [u32; 2], samples: u32) -> Arc<SceneDesc> {
    let start = STARTS.iter().find(|start| start.name == name).unwrap();
    let mut desc = SceneDesc::clone(Document::start(start).unwrap().desc());
    (desc.film.width, desc.film.height) = (size[0], size[1]);
    desc.film.samples = samples;
    Arc::new(desc)
}

/// The picture of the library's own render.
fn rendered(desc: &SceneDesc) -> turner::Picture {
    let mut renderer = Renderer::new(desc.prepare(&PrepareOptions::default()).unwrap()).unwrap();
    let options = PassOptions { threads: 0, cancel: &AtomicBool::new(false), progress: None };
    assert!(renderer.pass(u32::MAX, &options).unwrap());
    renderer.develop()
}

/// Waits for the finished picture of an order.
fn settled(engine: &Engine, order: u64) -> Arc<Frame> {
    let begun = Instant::now();
    loop {
        let frame = engine.frame().filter(|frame| frame.order >= order && frame.stage == Stage::Settled);
        if let Some(frame) = frame {
            return frame;
        }
        assert!(begun.elapsed() < Duration::from_secs(120), "{:?}", engine.status());
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn the_settled_picture_is_that_of_the_offline_render() {
    for (name, samples) in [("Material balls", 4), ("13. Thirty spheres", 1), ("Cornell box", 4)] {
        let desc = start(name, [96, 64], samples);
        let engine = Engine::new(|| {});
        let number = engine.order(Order::new(Arc::clone(&desc)));
        let frame = settled(&engine, number);
        let reference = rendered(&desc);
        assert!(frame.picture.display == reference.display, "{name}");
        assert!(frame.picture.linear == reference.linear, "{name}");
    }
}

#[test]
fn a_picture_of_the_film_is_cancelled_and_shown_later() {
    let desc = start("Cornell box", [96, 64], 4);
    let prepared = Order::new(Arc::clone(&desc)).prepared_desc().prepare(&PrepareOptions::default()).unwrap();
    let mut film = settle::Settle::new(&prepared, desc.film.denoise).unwrap();
    let (go_on, cancelled) = (AtomicBool::new(false), AtomicBool::new(true));
    while !film.is_covered() {
        film.step(&go_on, 1, Duration::from_millis(250)).unwrap();
        go_on.store(false, Ordering::SeqCst);
    }
    let look = Look::default();
    assert!(film.picture(&look, 1, &cancelled).is_none());
    assert!(film.picture(&look, 1, &go_on).is_some());
}

#[test]
fn orders_of_the_same_picture_do_not_lose_its_last_frame() {
    let desc = start("Cornell box", [160, 120], 2);
    let engine = Engine::new(|| {});
    let reference = rendered(&desc);
    let begun = Instant::now();
    let mut number = engine.order(Order::new(Arc::clone(&desc)));
    // Some of these stop the film while it is developed.
    for i in 0.. {
        let settled = engine.status().settled && i >= 40;
        if settled || begun.elapsed() > Duration::from_secs(20) {
            break;
        }
        std::thread::sleep(Duration::from_millis(17));
        number = engine.order(Order { size: [160 - i % 2, 120], ..Order::new(Arc::clone(&desc)) });
    }
    assert!(settled(&engine, number).picture.display == reference.display);
}

#[test]
fn the_engine_in_turns_gives_the_picture_of_the_offline_render() {
    for (name, denoise) in
        [("Material balls", turner::film::Denoise::On), ("13. Thirty spheres", turner::film::Denoise::Off)]
    {
        let mut desc = SceneDesc::clone(&start(name, [48, 32], 2));
        desc.film.denoise = denoise;
        let mut stepper = Stepper::new(Duration::from_millis(20));
        // An order that a newer one replaces leaves nothing behind.
        stepper.order(Order::new(start("Cornell box", [32, 24], 1)));
        stepper.step();
        stepper.order(Order::new(Arc::new(desc.clone())));
        // Another thread may end any step.
        for i in 0.. {
            if i % 3 == 0 {
                stepper.stop().store(true, Ordering::SeqCst);
            }
            if !stepper.step() {
                break;
            }
            assert!(i < 1_000_000, "{name}: {:?}", stepper.status());
        }
        let frame = stepper.frame().unwrap();
        assert_eq!(frame.stage, Stage::Settled, "{name}");
        assert!(frame.picture.display == rendered(&desc).display, "{name}");
    }
}

/// What a status says of a settled film is about the newest order.
#[test]
fn a_new_order_is_not_settled_by_the_last_one() {
    let desc = start("Cornell box", [32, 24], 1);
    let engine = Engine::new(|| {});
    for layers in [Layers::Groups, Layers::Parts, Layers::Lobes, Layers::None, Layers::Parts] {
        let look = Look { layers, ..Look::default() };
        engine.order(Order { look, ..Order::new(Arc::clone(&desc)) });
        let begun = Instant::now();
        let status = loop {
            let status = engine.status();
            if status.settled {
                break status;
            }
            assert!(begun.elapsed() < Duration::from_secs(60), "{layers:?}");
        };
        let has = |name: &str| status.layers.iter().any(|layer| layer == name);
        let found = (has("light.default"), has("indirect"), has("direct_specular"));
        let wanted = (layers == Layers::Groups, layers == Layers::Parts, layers == Layers::Lobes);
        assert_eq!(found, wanted, "{layers:?}: {:?}", status.layers);
    }
}
