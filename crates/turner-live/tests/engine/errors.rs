//! Orders without a picture, and faults.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use turner::camera::{CameraDesc, PinholeDesc};
use turner_live::engine::{Engine, Look, Order};

use super::common::*;

/// A camera that looks at itself.
fn broken() -> CameraDesc {
    let camera = PinholeDesc::default();
    CameraDesc::Pinhole(PinholeDesc { look_at: camera.position, ..camera })
}

#[test]
fn an_order_with_an_error_keeps_the_last_frame_and_says_why() {
    let desc = balls("path", |_| {});
    let reference = rendered(&desc);
    let engine = Engine::new(|| {});
    let number = engine.order(order(&desc));
    let good = settled(&engine, number);
    for _ in 0..3 {
        let bad = balls("path", |desc| desc.camera = Some(broken().into()));
        let wrong = bad.prepare(&Default::default()).expect_err("the offline render refuses it, too");
        engine.order(order(&bad));
        let error = wait(&engine, || engine.status().error);
        assert_eq!(error.message, wrong.message);
        assert_eq!(error.help, wrong.help);
        let status = engine.status();
        assert!(!status.settled && status.doing.is_empty(), "{status:?}");
        assert!(Arc::ptr_eq(&good.picture, &engine.frame().unwrap().picture));
        // A pause or another size does not hide the error.
        engine.order(Order { paused: true, size: [10, 10], ..order(&bad) });
        std::thread::sleep(std::time::Duration::from_millis(100));
        assert_eq!(wait(&engine, || engine.status().error).message, wrong.message);
    }
    let number = engine.order(order(&desc));
    assert_same("after errors", &settled(&engine, number), &reference);
}

#[test]
fn a_camera_without_axes_as_a_look_is_an_error_as_well() {
    let desc = balls("path", |_| {});
    let engine = Engine::new(|| {});
    engine.order(Order { look: Look { camera: Some(broken()), ..Look::default() }, ..order(&desc) });
    let error = wait(&engine, || engine.status().error);
    assert!(!error.message.is_empty());
    assert!(engine.frame().is_none());
    let number = engine.order(order(&desc));
    settled(&engine, number);
}

/// The function that the caller gave is called by the engine's thread: a fault in it is one in the thread.
#[test]
fn a_panic_is_reported_and_the_next_order_works() {
    let desc = balls("path", |_| {});
    let (armed, fired) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
    let (of_armed, of_fired) = (Arc::clone(&armed), Arc::clone(&fired));
    let engine = Engine::new(move || {
        if of_armed.swap(false, Ordering::SeqCst) {
            of_fired.store(true, Ordering::SeqCst);
            panic!("a fault for the test");
        }
    });
    for _ in 0..3 {
        armed.store(true, Ordering::SeqCst);
        engine.order(order(&desc));
        let error = wait(&engine, || engine.status().error);
        assert!(error.message.contains("a fault for the test"), "{}", error.message);
        assert!(error.help.is_some());
        assert!(fired.swap(false, Ordering::SeqCst));
        let number = engine.order(order(&desc));
        assert_same("after a fault", &settled(&engine, number), &rendered(&desc));
    }
}
