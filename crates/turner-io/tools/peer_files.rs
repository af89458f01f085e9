//! Writes the files that `scenes/peers/s4.toml` refers to, a mesh of 10 MB and an environment map of 20 MB:
//! `cargo run --release -p turner-io --features tools --example peer_files [FOLDER]`.

use std::path::PathBuf;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args_os().nth(1).map_or_else(|| "scenes/peers".into(), PathBuf::from);
    std::fs::write(folder.join("s4-blob.ply"), turner_io::testing::noisy_sphere_ply(200))?;
    std::fs::write(folder.join("s4-sky.exr"), turner_io::testing::sky_exr(1024)?)?;
    Ok(())
}
