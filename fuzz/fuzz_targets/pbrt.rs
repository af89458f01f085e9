//! Any bytes as a pbrt scene: a scene or an error, never a panic, and meshes whose numbers fit together.

#![no_main]

use libfuzzer_sys::fuzz_target;
use turner_io::assets::MemoryAssets;
use turner_io::import::{ImportOptions, import};

fuzz_target!(|data: &[u8]| {
    let mut assets = MemoryAssets::default();
    assets.files.insert("a.pbrt".into(), data.to_vec());
    if let Ok(scene) = import(data.to_vec(), "a.pbrt", &assets, &ImportOptions::default()) {
        scene.meshes.iter().for_each(|m| m.data.check().expect("indices are checked"));
    }
});
