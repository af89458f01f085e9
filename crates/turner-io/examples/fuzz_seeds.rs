//! Writes the seeds of the fuzz targets: `cargo run --release -p turner-io --example fuzz_seeds -- fuzz/corpus` makes a folder for each.

use std::path::PathBuf;
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
    Ok(())
}
