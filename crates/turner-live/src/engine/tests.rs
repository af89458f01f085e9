use std::sync::Arc;
use std::sync::atomic::AtomicBool;
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
