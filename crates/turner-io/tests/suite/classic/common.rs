//! Helpers of tests that render scenes from text.

use std::sync::atomic::AtomicBool;

use turner::description::SceneDesc;
use turner::film::Picture;
use turner::integrator::RayStats;
use turner::render::{PassOptions, Renderer};
use turner::schema::PrepareOptions;
use turner_io::assets::MemoryAssets;
use turner_io::scene::{LoadOptions, load_text};

pub(crate) fn describe(text: &str) -> SceneDesc {
    match load_text(text.to_owned(), "test.toml", &MemoryAssets::default(), &LoadOptions::default()) {
        Ok(loaded) => loaded.desc,
        Err(error) => panic!("{error}\n{text}"),
    }
}

/// Renders with the given number of threads and samples per pass.
pub(crate) fn render_with(desc: &SceneDesc, threads: usize, pass: u32) -> (Picture, RayStats) {
    let scene = desc.prepare(&PrepareOptions { threads, ..Default::default() }).unwrap();
    let mut renderer = Renderer::new(scene).unwrap();
    let cancel = AtomicBool::new(false);
    while !renderer.is_complete() {
        assert!(renderer.pass(pass, &PassOptions { threads, cancel: &cancel, progress: None }).unwrap());
    }
    assert_eq!(renderer.film.non_finite.count, 0);
    (renderer.develop(), renderer.stats)
}
