//! Helpers of the tests of damaged files: random numbers, a source of files that records what is read, and the size
//! of a scene.

use std::sync::Mutex;

use turner::description::SceneDesc;
use turner_io::assets::{AssetError, AssetSource, MemoryAssets};

/// A small deterministic random number generator.
pub(super) struct Random(pub(super) u64);

impl Random {
    pub(super) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub(super) fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }
}

/// Files that a scene may read, with a record of the names requested.
pub(super) struct Watched {
    pub(super) inner: MemoryAssets,
    pub(super) asked: Mutex<Vec<String>>,
}

impl AssetSource for Watched {
    fn read(&self, uri: &str, limit: u64) -> Result<Vec<u8>, AssetError> {
        self.asked.lock().unwrap().push(uri.to_owned());
        self.inner.read(uri, limit)
    }
    fn describe(&self, uri: &str) -> String {
        uri.to_owned()
    }
}

/// Bytes of memory of a scene.
pub(super) fn memory(scene: &SceneDesc) -> usize {
    let meshes: usize = scene.meshes.iter().map(|m| m.data.memory()).sum();
    let images: usize = scene.images.iter().map(|i| i.data.memory()).sum();
    meshes + images + size_of_val(&scene.objects[..])
}
