//! What importing model files finds: `cargo run --example gltf_report -- FILE…`

use std::path::Path;
use turner_io::assets::{AssetSource, FolderAssets};
use turner_io::gltf::import;
use turner_io::import::ImportOptions;

fn main() {
    for file in std::env::args().skip(1) {
        let path = Path::new(&file);
        let start = std::time::Instant::now();
        let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let read = FolderAssets::new(path.parent().unwrap_or(Path::new("")))
            .and_then(|assets| Ok((assets.read(&name, u64::MAX)?, assets)))
            .map_err(|e| e.to_string())
            .and_then(|(bytes, assets)| {
                import(bytes, &name, &assets, &ImportOptions::default())
                    .map_err(|e| format!("error[{}]: {}\n  help: {:?}", e.code.as_str(), e.message, e.help))
            });
        match read {
            Err(message) => println!("{message}"),
            Ok(scene) => {
                println!("{name}: {:.1} ms", start.elapsed().as_secs_f64() * 1e3);
                for (what, count) in &scene.imports[0].counts {
                    print!(" {count} {what}");
                }
                println!(
                    "\n  {} objects, {} meshes, {} textures",
                    scene.objects.len(),
                    scene.meshes.len(),
                    scene.textures.len()
                );
                for w in &scene.warnings {
                    println!("  {}: {} ({}x)", w.kind.word(), w.message, w.count);
                }
            }
        }
    }
}
