//! Million rays per second on one thread in generated scenes, for nearest hits and any hits.
//!
//! `cargo bench -p turner-bvh --bench rays -- [--full] [SCENE]...`
//!
//! Scenes are small unless `--full` is given. `turner-lab rays` also compares with Embree and uses several threads.

use std::hint::black_box;
use std::time::Instant;

use turner_bvh::generate::{Scene, SceneKind, rays};
use turner_bvh::{BuildOptions, Bvh, Hit, Ray, Triangles};

/// Scenes of one mesh.
const SCENES: [SceneKind; 5] =
    [SceneKind::Cornell, SceneKind::Architecture, SceneKind::Scan, SceneKind::Sticks, SceneKind::Terrain];

fn main() {
    // Cargo adds `--bench`.
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let full = arguments.iter().any(|a| a == "--full");
    let names: Vec<&str> = arguments.iter().map(String::as_str).filter(|a| *a != "--full").collect();
    let valid: Vec<&str> = SCENES.iter().map(|s| s.name()).collect();
    if let Some(unknown) = names.iter().find(|n| !valid.contains(n)) {
        eprintln!("unknown scene \"{unknown}\"; valid: {}", valid.join(", "));
        std::process::exit(2);
    }
    println!(
        "{:14} {:>9} {:>9} {:>8}  {:>8} {:>8} {:>8} {:>8}",
        "", "triangles", "Mtri/s", "bytes", "primary", "shadow", "diffuse", "ambient"
    );
    for kind in SCENES.into_iter().filter(|k| names.is_empty() || names.contains(&k.name())) {
        let usual = kind.default_size();
        let size = if full { usual } else { usual.min(50_000) };
        measure(kind, &kind.generate(size), if full { 512 } else { 128 });
    }
}

fn measure(kind: SceneKind, scene: &Scene, resolution: u32) {
    let start = Instant::now();
    let mesh = &scene.meshes[0];
    let triangles = Triangles { positions: &mesh.positions, triangles: &mesh.triangles };
    let options = BuildOptions { threads: 1, ..BuildOptions::default() };
    let tree = Bvh::build(&triangles, &options).expect("generated scenes fit into a BVH");
    let seconds = start.elapsed().as_secs_f64();
    let count = scene.triangles();
    let extent = scene.extent();
    let primary = rays::primary(&scene.camera, resolution);
    let points: Vec<rays::Point> = primary
        .iter()
        .filter_map(|ray| {
            let hit = tree.intersect(ray)?;
            rays::point(scene, extent, ray, hit.t, u32::MAX, hit.primitive)
        })
        .collect();
    let nearest = |rays: &[Ray]| {
        let mut hits = vec![Hit::MISS; rays.len()];
        rate(rays.len(), || tree.intersect_batch(black_box(rays), &mut hits))
    };
    let any = |rays: &[Ray]| {
        let mut hits = vec![false; rays.len()];
        rate(rays.len(), || tree.occluded_batch(black_box(rays), &mut hits))
    };
    let rates = [
        nearest(&primary),
        any(&rays::shadow(&points, scene.light)),
        nearest(&rays::diffuse(&points)),
        any(&rays::ambient(&points, 0.07 * extent)),
    ];
    let bytes = tree.stats().bytes as f64 / count as f64;
    print!("{:14} {count:>9} {:>9.3} {bytes:>8.1} ", kind.name(), count as f64 / 1e6 / seconds);
    println!("{}", rates.map(|rate| format!(" {rate:>8.3}")).concat());
}

/// Million rays per second: the median of five runs.
fn rate(count: usize, mut work: impl FnMut()) -> f64 {
    let mut seconds = [0.0; 5].map(|_: f64| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    });
    seconds.sort_by(f64::total_cmp);
    count as f64 / 1e6 / seconds[2].max(1e-9)
}
