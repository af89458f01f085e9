//! Writes the seed corpus of the fuzz targets, in a folder per target: `cargo run --release -p turner-io --features
//! tools --example fuzz_seeds -- fuzz/corpus`

use std::path::{Path, PathBuf};

use turner::color::Spectrum;
use turner::description::SceneDesc;
use turner::film::{Film, NonFinite};
use turner_io::checkpoint::{Header, fingerprint, to_bytes};
use turner_io::testing::seeds::seeds;

fn main() -> std::io::Result<()> {
    let root = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "fuzz/corpus".to_owned()));
    for seed in seeds() {
        let extension = seed.name.rsplit('.').next().unwrap_or_default();
        let target = match extension {
            "toml" => "scene",
            "spd" => "spectrum",
            "jpg" => "jpeg",
            "xml" => "mitsuba",
            "pbrt" if seed.bytes.starts_with(&[0x1f, 0x8b]) => "gzip",
            same => same,
        };
        let bytes = if target == "gzip" { &seed.bytes[2..] } else { &seed.bytes[..] };
        let folder = root.join(target);
        std::fs::create_dir_all(&folder)?;
        std::fs::write(folder.join(seed.name), bytes)?;
    }
    let film = film(&root.join("film"))?;
    checkpoint(&root.join("checkpoint"), film)
}

/// Writes the seed for checkpoints, without the checksum, which the fuzz target appends.
fn checkpoint(folder: &Path, mut film: Film) -> std::io::Result<()> {
    let header = Header { scene_hash: "0123456789abcdef".repeat(2), ..Header::default() };
    film.set_scene(fingerprint(&header.scene_hash));
    let bytes = to_bytes(&header, &film).map_err(std::io::Error::other)?;
    std::fs::create_dir_all(folder)?;
    std::fs::write(folder.join("small.turner-checkpoint"), &bytes[..bytes.len() - 8])
}

/// Writes the seed for films, without the checksum, which the fuzz target appends.
fn film(folder: &Path) -> std::io::Result<Film> {
    let mut desc = SceneDesc::default().film;
    (desc.width, desc.height) = (20, 6);
    let mut film = Film::new(&desc).map_err(std::io::Error::other)?;
    let samples = (0..96u8).map(|i| (Spectrum::grey(f32::from(i) / 64.0), 1.0));
    film.share().deposit_samples(0, samples, &NonFinite::default());
    film.take_light(7).map_err(std::io::Error::other)?;
    let bytes = film.to_bytes();
    std::fs::create_dir_all(folder)?;
    std::fs::write(folder.join("small.film"), &bytes[..bytes.len() - 8])?;
    Ok(film)
}
