//! Reads a pbrt scene and prints the speed, the size of its meshes and the peak memory (Linux).

use std::path::Path;

use turner_io::assets::FolderAssets;
use turner_io::import::ImportOptions;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: pbrt_speed FILE.pbrt")?;
    let path = Path::new(&path);
    let size = std::fs::metadata(path)?.len() as f64;
    let assets = FolderAssets::new(path.parent().unwrap_or(Path::new("")))?;
    let name = path.file_name().and_then(|n| n.to_str()).ok_or("the file name is not UTF-8")?;
    let start = std::time::Instant::now();
    let scene = turner_io::import::import_file(name, &assets, &ImportOptions::default())?;
    let seconds = start.elapsed().as_secs_f64();
    let bytes: usize = scene.meshes.iter().map(|m| m.data.memory()).sum();
    let peak = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = peak.lines().find_map(|l| l.strip_prefix("VmHWM:")).unwrap_or(" ?").trim().to_owned();
    println!(
        "{:.0} MB in {seconds:.2} s: {:.0} MB/s; meshes {:.0} MB, peak {peak}",
        size / 1e6,
        size / 1e6 / seconds,
        bytes as f64 / 1e6
    );
    Ok(())
}
