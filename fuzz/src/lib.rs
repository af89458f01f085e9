//! Entry points of the fuzz targets: read arbitrary bytes as a file of a format and check that the result is
//! consistent.

use std::sync::LazyLock;

use turner::description::SceneDesc;
use turner::film::{Film, checksum};
use turner::integrator::{Caustics, IntegratorDesc, SharedPathsMode};
use turner_io::assets::MemoryAssets;
use turner_io::import::{ImportOptions, import};
use turner_io::scene::{LoadOptions, load_text};
use turner_io::testing::seeds::{Seed, companions, seeds};

/// The seeds, generated once, because that takes longer than reading most files.
static SEEDS: LazyLock<Vec<Seed>> = LazyLock::new(seeds);

/// The files that seeds refer to.
static COMPANIONS: LazyLock<MemoryAssets> = LazyLock::new(|| {
    let files = companions().into_iter().map(|(name, bytes)| (name.to_owned(), bytes));
    MemoryAssets { files: files.collect() }
});

/// Most samples (bytes of images and meshes, and pixels) of a scene that is prepared.
const SMALL: usize = 1 << 20;

/// The companion files and this file.
fn assets(name: &str, data: &[u8]) -> MemoryAssets {
    let mut assets = COMPANIONS.clone();
    assets.files.insert(name.to_owned(), data.to_vec());
    assets
}

/// Of this many small scenes, one is prepared completely, and eight without the test renderings that choose caustics
/// and shared paths. These take hundreds of times as long as reading the file and test the reader little. A hash of
/// the bytes decides, so that each file is always treated the same.
const ONE_OF: u64 = 64;

/// The hash FNV-1a (Fowler, Noll and Vo 1991).
fn hash(data: &[u8]) -> u64 {
    data.iter().fold(0xcbf2_9ce4_8422_2325, |h, &b| (h ^ u64::from(b)).wrapping_mul(0x100_0000_01b3))
}

/// Checks that mesh indices are valid, and that small scenes can be prepared without a panic.
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
        (path.caustics, path.shared_paths) = (Caustics::Off, SharedPathsMode::Off);
    }
    let _ = scene.prepare(&turner::schema::PrepareOptions { threads: 1, ..Default::default() });
}

/// Reads a model, or another renderer's scene, by its file name.
pub fn model(name: &str, data: &[u8]) {
    let options = ImportOptions { threads: 1, ..ImportOptions::default() };
    match import(data.to_vec(), name, &assets(name, data), &options) {
        Ok(scene) => check(scene, data),
        Err(error) => assert!(!error.message.is_empty() && !error.message.contains('\u{1b}')),
    }
}

/// Reads a TOML scene.
pub fn scene(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let options = LoadOptions { threads: 1, ..LoadOptions::default() };
    match load_text(text.to_owned(), "scene.toml", &assets("scene.toml", data), &options) {
        Ok(loaded) => check(loaded.desc, data),
        Err(error) => drop(error.to_string()),
    }
}

/// Reads a file through the seed scene that refers to it.
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

/// Reads an image by its bytes, or TGA by its name. Panics inside decoding crates are contained and are not findings.
pub fn picture(name: &str, data: &[u8]) {
    turner_io::image::silence_contained_panics();
    let limits = turner_io::image::DecodeLimits { max_pixels: SMALL as u64, ..Default::default() };
    if let Ok(image) = turner_io::image::decode(data, name, &limits) {
        assert!(image.is_consistent());
    }
    // Layers of EXR files have readers of their own.
    if data.starts_with(b"\x76\x2f\x31\x01") {
        use turner_io::image::exr;
        let _ = exr::parts(data, name);
        let _ = exr::decode_layer(data, name, "N", &limits);
        let _ = exr::read_channels(data, name, 0, |_| true, &limits);
    }
}

/// Reads a film, as given and with a valid checksum appended. A film that is read can be merged, developed, written
/// and read again.
pub fn film(data: &[u8]) {
    let memory = turner::schema::Memory::new(1 << 24, || Some(0));
    let limits = turner::schema::Limits { memory: std::sync::Arc::new(memory), ..Default::default() };
    let sealed = [data, &checksum(data).to_le_bytes()].concat();
    for bytes in [data, &sealed] {
        match Film::from_bytes(bytes, &limits) {
            Ok(mut film) => {
                let other = film.clone();
                let _ = film.merge(&other);
                film.develop(&SceneDesc::default().film, 1);
                assert!(Film::from_bytes(&film.to_bytes(), &limits).is_ok());
            }
            Err(error) => assert!(!error.message.is_empty() && !error.message.contains('\u{1b}')),
        }
    }
}

/// Reads a checkpoint, as given and with the right hashes. A checkpoint that is read can be written and read
/// again.
pub fn checkpoint(data: &[u8]) {
    use turner_io::checkpoint::{from_bytes, resealed, to_bytes};
    let memory = turner::schema::Memory::new(1 << 24, || Some(0));
    let limits = turner::schema::Limits { memory: std::sync::Arc::new(memory), ..Default::default() };
    let sealed = resealed(data);
    for bytes in [data, &sealed] {
        match from_bytes(bytes, "fuzz", &limits) {
            Ok(read) => {
                // With line breaks, the header may become too large.
                if let Ok(bytes) = to_bytes(&read.header, &read.film) {
                    assert!(from_bytes(&bytes, "fuzz", &limits).is_ok());
                }
            }
            Err(error) => assert!(!error.message.is_empty() && !error.message.contains('\u{1b}')),
        }
    }
}
