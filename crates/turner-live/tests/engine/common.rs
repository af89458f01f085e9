//! Scenes, the offline render, and waiting for frames.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use turner::integrator::IntegratorDesc;
use turner::{PassOptions, Picture, PrepareOptions, Renderer, SceneDesc};
use turner_io::assets::MemoryAssets;
use turner_live::engine::{Engine, Frame, Look, Order, Stage};

/// Balls on a floor, one of glass and one of metal, under two lights.
const BALLS: &str = r#"
[film]
width = 72
height = 48
samples = 6

[camera]
position = [0, 2, 6]
look_at = [0, 0.8, 0]
fov = 40

[integrator]
type = "path"

[background]
color = [0.2, 0.3, 0.5]

[[light]]
type = "point"
position = [3, 5, 4]
intensity = 40
group = "key"

[[object]]
type = "plane"
material = { type = "matte", color = [0.5, 0.5, 0.5] }

[[object]]
type = "sphere"
center = [-1.1, 1, 0]
material = { type = "principled", specular_roughness = 0.3, base_metalness = 1, base_color = [0.9, 0.6, 0.3] }

[[object]]
type = "sphere"
center = [1.1, 1, 0]
material = { type = "principled", transmission_weight = 1, specular_roughness = 0 }

[[object]]
type = "sphere"
center = [0, 3.2, 0]
radius = 0.4
light_group = "lamp"
material = { type = "principled", base_weight = 0, specular_weight = 0, emission_color = [1, 0.8, 0.5], emission_luminance = 3 }
"#;

/// A scene from its text.
pub(crate) fn scene(text: &str) -> SceneDesc {
    let loaded = turner_io::scene::load_text(
        text.to_owned(),
        "test.toml",
        &MemoryAssets::default(),
        &Default::default(),
    );
    loaded.unwrap_or_else(|e| panic!("{}", e.error.message)).desc
}

/// The scene of balls with the integrator `kind`, changed by `change`.
pub(crate) fn balls(kind: &str, change: impl FnOnce(&mut SceneDesc)) -> Arc<SceneDesc> {
    let mut desc = scene(BALLS);
    desc.integrator = IntegratorDesc::of_type(kind).unwrap();
    change(&mut desc);
    Arc::new(desc)
}

/// The picture of the library's own render: all samples in one pass.
pub(crate) fn rendered(desc: &SceneDesc) -> Picture {
    let mut renderer = Renderer::new(desc.prepare(&PrepareOptions::default()).unwrap()).unwrap();
    let options = PassOptions { threads: 0, cancel: &AtomicBool::new(false), progress: None };
    assert!(renderer.pass(u32::MAX, &options).unwrap());
    renderer.develop()
}

/// What the offline render of a look of a scene is.
pub(crate) fn rendered_as(desc: &SceneDesc, look: &Look) -> Picture {
    let mut desc = desc.clone();
    if let Some(integrator) = &look.integrator {
        desc.integrator = integrator.clone();
    }
    if let Some(camera) = &look.camera {
        desc.camera = Some(camera.clone().into());
    }
    rendered(&desc)
}

pub(crate) fn order(desc: &Arc<SceneDesc>) -> Order {
    Order { threads: 2, ..Order::new(Arc::clone(desc)) }
}

/// Waits until `ready` gives something; fails after two minutes.
pub(crate) fn wait<T>(engine: &Engine, mut ready: impl FnMut() -> Option<T>) -> T {
    let begun = Instant::now();
    loop {
        if let Some(value) = ready() {
            return value;
        }
        assert!(begun.elapsed() < Duration::from_secs(120), "{:?}", engine.status());
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Waits for a frame of an order that `is` says is right.
pub(crate) fn frame_that(engine: &Engine, number: u64, is: impl Fn(&Frame) -> bool) -> Arc<Frame> {
    wait(engine, || engine.frame().filter(|frame| frame.order >= number && is(frame)))
}

/// Waits for the settled picture of an order, and for the status to say so.
pub(crate) fn settled(engine: &Engine, number: u64) -> Arc<Frame> {
    let frame = frame_that(engine, number, |frame| frame.stage == Stage::Settled);
    let status = wait(engine, || Some(engine.status()).filter(|status| status.settled));
    assert_eq!(status.doing, "");
    assert!(status.error.is_none());
    frame
}

/// Fails unless both pictures have the same bytes.
pub(crate) fn assert_same(what: &str, frame: &Frame, reference: &Picture) {
    let picture = &frame.picture;
    assert_eq!((picture.width, picture.height), (reference.width, reference.height), "{what}");
    let bits = |p: &Picture| -> Vec<[u32; 4]> { p.linear.iter().map(|v| v.map(f32::to_bits)).collect() };
    let differing = bits(picture).iter().zip(&bits(reference)).filter(|(a, b)| a != b).count();
    assert_eq!(differing, 0, "{what}: pixels whose scene values differ");
    assert!(picture.display == reference.display, "{what}: display values differ");
    assert_eq!(picture.has_alpha, reference.has_alpha, "{what}");
}

/// A sequence of numbers that looks random (SplitMix64).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn below(&mut self, count: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ (z >> 31)) % count
    }
}
