//! Writes a pbrt scene with one large mesh as text, to measure how fast such files are read:
//!
//! ```sh
//! cargo run --release -p turner-io --features tools --example pbrt_text -- 300 big.pbrt    # megabytes, file
//! cargo run --release -p turner-io --features tools --example pbrt_speed -- big.pbrt
//! ```

use std::io::{BufWriter, Write};

fn main() -> std::io::Result<()> {
    let mut args = std::env::args().skip(1);
    let megabytes: usize = args.next().and_then(|a| a.parse().ok()).unwrap_or(300);
    let name = args.next().unwrap_or_else(|| "big.pbrt".into());
    // A vertex takes about 113 bytes, including its normal, (u, v) and two triangles.
    let side = ((megabytes * 1_000_000 / 113) as f64).sqrt() as usize;
    let mut out = BufWriter::new(std::fs::File::create(name)?);
    writeln!(out, "WorldBegin\nShape \"trianglemesh\" \"point3 P\" [")?;
    let height = |x: usize, y: usize| (((x * 37 + y * 91) % 1000) as f64) * 1e-3;
    let at = |v: usize| v as f64 / side as f64;
    for y in 0..side {
        for x in 0..side {
            writeln!(out, "{:.6} {:.6} {:.6}", at(x), height(x, y), at(y))?;
        }
    }
    writeln!(out, "] \"normal N\" [")?;
    for y in 0..side {
        for x in 0..side {
            writeln!(out, "{:.5} {:.6} {:.5}", 0.1 - height(y, x) * 0.2, 0.99, height(x, y) * 0.1)?;
        }
    }
    writeln!(out, "] \"point2 uv\" [")?;
    for y in 0..side {
        for x in 0..side {
            writeln!(out, "{:.6} {:.6}", at(x), at(y))?;
        }
    }
    writeln!(out, "] \"integer indices\" [")?;
    for y in 1..side {
        for x in 1..side {
            let d = y * side + x;
            let (a, b, c) = (d - side - 1, d - side, d - 1);
            writeln!(out, "{a} {c} {b} {b} {c} {d}")?;
        }
    }
    writeln!(out, "]")
}
