//! Any bytes as a Mitsuba scene, or as a mesh that one names: a scene or an error, never a panic, and meshes whose numbers fit together.

#![no_main]

use libfuzzer_sys::fuzz_target;
use turner_io::assets::MemoryAssets;
use turner_io::import::{ImportOptions, import};

/// Names the bytes as each kind of file.
const AROUND: &[u8] = br#"<scene version="3.0.0"><shape type="serialized"><string name="filename" value="a.bin"/></shape>
<shape type="cube"><bsdf type="null"/><medium name="interior" type="heterogeneous"><volume name="sigma_t" type="gridvolume">
<string name="filename" value="a.bin"/></volume></medium></shape></scene>"#;

fuzz_target!(|data: &[u8]| {
    let mut assets = MemoryAssets::default();
    assets.files.insert("a.bin".into(), data.to_vec());
    assets.files.insert("a.xml".into(), data.to_vec());
    for text in [data, AROUND] {
        if let Ok(scene) = import(text.to_vec(), "a.xml", &assets, &ImportOptions::default()) {
            scene.meshes.iter().for_each(|m| m.data.check().expect("indices are checked"));
        }
    }
});
