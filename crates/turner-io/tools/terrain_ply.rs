//! Writes a terrain with a given number of triangles as a binary PLY file, with a scene next to it, to measure the
//! memory and time of large meshes:
//!
//! ```sh
//! cargo run --release -p turner-io --features tools --example terrain_ply -- 10000000 terrain.ply
//! /usr/bin/time -v turner render terrain.toml
//! ```

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Height of the terrain at (x, z) in 0..1: ten octaves of waves.
fn height(x: f32, z: f32) -> f32 {
    // A triangle wave, which needs no platform-dependent functions.
    let wave = |v: f32| (v - v.floor() - 0.5).abs() - 0.25;
    let (mut sum, mut size, mut step) = (0.0, 0.35, 2.0);
    for octave in 0..10 {
        let turn = octave as f32 * 0.37;
        sum += size * wave(x * step + turn + 0.3 * wave(z * step)) * wave(z * step * 0.9 - turn);
        size *= 0.55;
        step *= 1.9;
    }
    sum
}

fn write(count: usize, path: &Path) -> std::io::Result<()> {
    let cells = (count / 2).isqrt().max(1);
    let side = cells + 1;
    let mut out = BufWriter::with_capacity(1 << 20, File::create(path)?);
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        side * side,
        2 * cells * cells
    )?;
    for j in 0..side {
        for i in 0..side {
            let (x, z) = (i as f32 / cells as f32, j as f32 / cells as f32);
            for v in [4.0 * x - 2.0, height(x, z), 4.0 * z - 2.0] {
                out.write_all(&v.to_le_bytes())?;
            }
        }
    }
    for j in 0..cells {
        for i in 0..cells {
            let a = j * side + i;
            for [a, b, c] in [[a, a + side, a + 1], [a + 1, a + side, a + side + 1]] {
                out.write_all(&[3])?;
                for v in [a, b, c] {
                    out.write_all(&(v as u32).to_le_bytes())?;
                }
            }
        }
    }
    out.flush()
}

fn main() -> std::io::Result<()> {
    let mut args = std::env::args().skip(1);
    let (Some(count), Some(path)) = (args.next().and_then(|n| n.parse().ok()), args.next()) else {
        eprintln!("usage: terrain_ply TRIANGLES FILE.ply");
        std::process::exit(2);
    };
    let path = Path::new(&path);
    write(count, path)?;
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let scene = format!(
        "[camera]\nposition = [2.2, 1.2, 2.6]\nlook_at = [0, -0.1, 0]\nfov = 40\n\n[film]\nwidth = 1024\nheight = 768\n\n\
         [background]\ncolor = [0.5, 0.7, 0.9]\n\n[[light]]\ntype = \"directional\"\ndirection = [-1, -1, 0.4]\n\n\
         [[light]]\ntype = \"ambient\"\ncolor = 0.1\n\n[[object]]\ntype = \"mesh\"\nfile = {name:?}\n\
         material = {{ color = [0.5, 0.6, 0.3] }}\n"
    );
    std::fs::write(path.with_extension("toml"), scene)
}
