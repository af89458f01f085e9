//! A pause keeps the film waiting, not the first picture.

use std::sync::Arc;

use turner_live::engine::{Display, Engine, Look, Order, Stage};

use super::common::*;

/// A window orders a picture before it knows its own size, and another one of the right size right after it: the second
/// order stops the first one's frame, and must draw its own.
#[test]
fn an_order_that_stops_the_frame_of_the_same_picture_draws_one() {
    for millis in [0, 0, 1, 2, 5, 10] {
        let desc = balls("path", |desc| (desc.film.width, desc.film.height) = (640, 480));
        let engine = Engine::new(|| {});
        let paused = Order { paused: true, ..order(&desc) };
        engine.order(paused.clone());
        std::thread::sleep(std::time::Duration::from_millis(millis));
        let number = engine.order(Order { size: [64, 64], ..paused });
        let frame = frame_that(&engine, number, |_| true);
        assert_eq!(frame.stage, Stage::Preview);
        assert!(Arc::ptr_eq(&frame.stand.desc, &desc));
    }
}

/// While it is paused, another size and other colours are shown.
#[test]
fn a_paused_preview_follows_the_window_and_the_display() {
    let desc = balls("path", |desc| (desc.film.width, desc.film.height) = (320, 240));
    let engine = Engine::new(|| {});
    let paused = Order { paused: true, size: [32, 32], ..order(&desc) };
    let number = engine.order(paused.clone());
    let small = frame_that(&engine, number, |_| true);
    assert!(small.picture.width <= 32);
    let larger = Order { size: [160, 160], ..paused };
    let number = engine.order(larger.clone());
    let large = frame_that(&engine, number, |frame| frame.picture.width == 160);
    let look = Look { display: Display::FalseColor, ..Look::default() };
    let number = engine.order(Order { look, ..larger });
    let colors = frame_that(&engine, number, |frame| frame.picture.display != large.picture.display);
    assert_eq!(colors.stage, Stage::Preview);
    assert_eq!(engine.status().samples.0, 0, "the film waits");
}
