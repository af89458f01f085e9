//! Work stops when nobody wants it.

use std::time::{Duration, Instant};

use turner_live::document::{Document, STARTS};
use turner_live::engine::{Engine, Order};

use super::common::*;

/// The longest time that stopping may take: far less than the work, far more than a busy machine needs.
const SOON: Duration = Duration::from_secs(3);

#[test]
fn dropping_the_engine_while_it_renders_returns_quickly() {
    // Hours of work, each.
    let heavy = [
        balls("path", |desc| (desc.film.width, desc.film.height, desc.film.samples) = (1280, 720, 65536)),
        balls("direct", |desc| (desc.film.width, desc.film.height, desc.film.samples) = (1280, 720, 65536)),
        balls("classic", |desc| {
            (desc.film.width, desc.film.height, desc.film.samples) = (1280, 720, 65536);
            desc.film.antialias = turner::film::Antialias::MonteCarlo;
        }),
    ];
    for desc in &heavy {
        for millis in [0, 10, 100, 1500] {
            let engine = Engine::new(|| {});
            engine.order(order(desc));
            std::thread::sleep(Duration::from_millis(millis));
            let begun = Instant::now();
            drop(engine);
            assert!(begun.elapsed() < SOON, "after {millis} ms: {:?}", begun.elapsed());
        }
    }
}

#[test]
fn a_new_order_stops_the_work_on_the_last() {
    let heavy =
        balls("path", |desc| (desc.film.width, desc.film.height, desc.film.samples) = (1280, 720, 65536));
    let light = balls("normals", |_| {});
    let engine = Engine::new(|| {});
    for millis in [1, 50, 900] {
        engine.order(order(&heavy));
        std::thread::sleep(Duration::from_millis(millis));
        let begun = Instant::now();
        let number = engine.order(order(&light));
        settled(&engine, number);
        assert!(begun.elapsed() < SOON + SOON, "{:?}", begun.elapsed());
    }
}

/// Every scene of the gallery shows something at once, and stops.
#[test]
fn every_start_has_a_first_frame() {
    let engine = Engine::new(|| {});
    for start in STARTS {
        let document = Document::start(start).unwrap();
        let small = Order { size: [64, 64], threads: 2, ..Order::new(document.desc().clone()) };
        let number = engine.order(small);
        let frame = frame_that(&engine, number, |_| true);
        assert!(frame.picture.width <= document.desc().film.width, "{}", start.name);
        let first = frame.picture.display.first();
        assert!(
            frame.picture.display.iter().any(|pixel| Some(pixel) != first),
            "{} shows one colour",
            start.name
        );
    }
}
