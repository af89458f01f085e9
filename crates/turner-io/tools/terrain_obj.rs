//! Writes a terrain with a given number of triangles as an OBJ file with (u, v) and normals, to measure how fast
//! large files are read:
//!
//! ```sh
//! cargo run --release -p turner-io --features tools --example terrain_obj -- 1600000 terrain.obj
//! cargo run --release -p turner-io --features tools --example mesh_speed -- terrain.obj
//! ```

use std::fs::File;
use std::io::{BufWriter, Write};

fn main() -> std::io::Result<()> {
    let mut args = std::env::args().skip(1);
    let (Some(count), Some(path)) = (args.next().and_then(|n| n.parse::<usize>().ok()), args.next()) else {
        eprintln!("usage: terrain_obj TRIANGLES FILE.obj");
        std::process::exit(2);
    };
    let cells = (count / 2).isqrt().max(1);
    let side = cells + 1;
    let mut out = BufWriter::with_capacity(1 << 20, File::create(path)?);
    // A triangle wave, which needs no platform-dependent functions.
    let wave = |v: f32| (v - v.floor() - 0.5).abs() - 0.25;
    for j in 0..side {
        for i in 0..side {
            let (u, v) = (i as f32 / cells as f32, j as f32 / cells as f32);
            let height = wave(3.0 * u) * wave(5.0 * v) + 0.1 * wave(31.0 * u + 17.0 * v);
            writeln!(out, "v {:.6} {:.6} {:.6}", 4.0 * u - 2.0, height, 4.0 * v - 2.0)?;
            writeln!(out, "vt {u:.6} {v:.6}\nvn {:.4} {:.4} {:.4}", 0.1 * height, 0.99, -0.2 * height)?;
        }
    }
    for j in 0..cells {
        for i in 0..cells {
            let a = j * side + i + 1;
            for [a, b, c] in [[a, a + side, a + 1], [a + 1, a + side, a + side + 1]] {
                writeln!(out, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}")?;
            }
        }
    }
    out.flush()
}
