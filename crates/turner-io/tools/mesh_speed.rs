//! Measures how long a mesh takes to read with different numbers of threads, and the peak memory of the process
//! (Linux), which includes the file's bytes and the mesh.

use std::time::Instant;

use turner_io::assets::MemoryAssets;
use turner_io::import::{ImportOptions, import};

/// Peak resident set size so far, in bytes.
fn peak() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|l| l.starts_with("VmHWM:")).unwrap_or_default();
    line.split_whitespace().nth(1).and_then(|n| n.parse::<u64>().ok()).unwrap_or(0) * 1024
}

fn main() {
    let Some(path) = std::env::args().nth(1) else {
        eprintln!("usage: mesh_speed FILE [THREADS]");
        std::process::exit(2);
    };
    let threads = std::env::args().nth(2).and_then(|n| n.parse().ok());
    for threads in threads.map_or(vec![1, 2], |n| vec![n]) {
        let bytes = match std::fs::read(&path) {
            Ok(bytes) => bytes,
            Err(error) => return eprintln!("{path}: {error}"),
        };
        let size = bytes.len() as f64;
        let options = ImportOptions { threads, ..ImportOptions::default() };
        let start = Instant::now();
        match import(bytes, &path, &MemoryAssets::default(), &options) {
            Ok(scene) => {
                let seconds = start.elapsed().as_secs_f64();
                let mesh = scene.meshes[0].data.memory() as f64;
                println!(
                    "{threads} threads: {seconds:.3} s, {:.0} MB/s; file {:.0} MB, mesh {:.0} MB, peak so far {:.0} MB",
                    size / seconds / 1e6,
                    size / 1e6,
                    mesh / 1e6,
                    peak() as f64 / 1e6
                );
            }
            Err(error) => eprintln!("{error}"),
        }
    }
}
