//! What the targets do with any bytes: read them as a file of a format, and see that what comes of it fits together.

use std::sync::LazyLock;

use turner::description::SceneDesc;
use turner::film::{Film, checksum};
use turner::integrator::{Caustics, IntegratorDesc, SharedPathsMode};
use turner_io::assets::MemoryAssets;
use turner_io::import::{ImportOptions, import};
use turner_io::scene::{LoadOptions, load_text};
use turner_io::testing::seeds::{Seed, companions, seeds};

/// Made once: it takes longer than reading most files.
static SEEDS: LazyLock<Vec<Seed>> = LazyLock::new(seeds);

/// The files that seeds name.
static COMPANIONS: LazyLock<MemoryAssets> = LazyLock::new(|| {
    let files = companions().into_iter().map(|(name, bytes)| (name.to_owned(), bytes));
    MemoryAssets { files: files.collect() }
});

/// Most samples that a scene may make the fuzzer prepare.
const SMALL: usize = 1 << 20;

/// The files that seeds name, and this one.
fn assets(name: &str, data: &[u8]) -> MemoryAssets {
    let mut assets = COMPANIONS.clone();
    assets.files.insert(name.to_owned(), data.to_vec());
    assets
}

/// Of so many files whose scene is small one is prepared with all its probes, and eight are without the probes of caustics and
/// shared paths: these take hundreds of times as long as reading the file, and say little of its reader. A number made of the
/// file's bytes decides, so that each file is treated alike every time.
const ONE_OF: u64 = 64;

/// FNV-1a (Fowler, Noll and Vo 1991).
fn hash(data: &[u8]) -> u64 {
    data.iter().fold(0xcbf2_9ce4_8422_2325, |h, &b| (h ^ u64::from(b)).wrapping_mul(0x100_0000_01b3))
}

/// Meshes have sound indices; what is small can be prepared.
fn check(mut scene: SceneDesc, data: &[u8]) {
    scene.meshes.iter().for_each(|m| m.data.check().expect("indices are checked"));
    let images: usize = scene.images.iter().map(|i| i.data.memory()).sum();
    let meshes: usize = scene.meshes.iter().map(|m| m.data.memory()).sum();
    let film = scene.film.width as usize * scene.film.height as usize;
    let lot = (hash(data) >> 32) % ONE_OF;
    if lot > 8 || images + meshes + film > SMALL || scene.objects.len() + scene.groups.len() >= 1000 {
        return;
    }
    if let (1.., IntegratorDesc::Path(path)) = (lot, &mut scene.integrator) {
        (path.caustics, path.reuse) = (Caustics::Off, SharedPathsMode::Off);
    }
    let _ = scene.prepare(&turner::schema::PrepareOptions { threads: 1, ..Default::default() });
}

/// A model, or a scene of another renderer, by its name.
pub fn model(name: &str, data: &[u8]) {
    let options = ImportOptions { threads: 1, ..ImportOptions::default() };
    match import(data.to_vec(), name, &assets(name, data), &options) {
        Ok(scene) => check(scene, data),
        Err(error) => assert!(!error.message.is_empty() && !error.message.contains('\u{1b}')),
    }
}

/// A scene in TOML.
pub fn scene(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let options = LoadOptions { threads: 1, ..LoadOptions::default() };
    match load_text(text.to_owned(), "scene.toml", &assets("scene.toml", data), &options) {
        Ok(loaded) => check(loaded.desc, data),
        Err(error) => drop(error.to_string()),
    }
}

/// A file that a seed's scene names, through that scene.
pub fn named(name: &str, data: &[u8]) {
    let Some((scene, text)) = SEEDS.iter().find(|s| s.name == name).and_then(|s| s.scene.clone()) else { return };
    let assets = assets(name, data);
    if !scene.ends_with(".toml") {
        let options = ImportOptions { threads: 1, ..ImportOptions::default() };
        let _ = import(text.into_bytes(), scene, &assets, &options).map(|scene| check(scene, data));
        return;
    }
    let options = LoadOptions { threads: 1, ..LoadOptions::default() };
    let _ = load_text(text, scene, &assets, &options).map(|loaded| check(loaded.desc, data));
}

/// A picture by its bytes; TGA by its name alone. A decoder of others may give up by a panic: that is contained, and no finding.
pub fn picture(name: &str, data: &[u8]) {
    turner_io::image::silence_contained_panics();
    let limits = turner_io::image::DecodeLimits { max_pixels: SMALL as u64, ..Default::default() };
    if let Ok(image) = turner_io::image::decode(data, name, &limits) {
        assert!(image.is_consistent());
    }
}

/// A film: as it is, and under a checksum that is right. What is read can be shown, written and read again.
pub fn film(data: &[u8]) {
    let memory = turner::schema::Memory::new(1 << 24, || Some(0));
    let limits = turner::schema::Limits { memory: std::sync::Arc::new(memory), ..Default::default() };
    let sealed = [data, &checksum(data).to_le_bytes()].concat();
    for bytes in [data, &sealed] {
        match Film::from_bytes(bytes, &limits) {
            Ok(mut film) => {
                let other = film.clone();
                let _ = film.merge(&other);
                film.develop(&SceneDesc::default().film);
                assert!(Film::from_bytes(&film.to_bytes(), &limits).is_ok());
            }
            Err(error) => assert!(!error.message.is_empty() && !error.message.contains('\u{1b}')),
        }
    }
}
