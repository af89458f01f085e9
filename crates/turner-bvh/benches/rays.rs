//! Millions of rays per second on one thread, in generated scenes: the nearest hit, and any hit.
//!
//! `cargo bench -p turner-bvh --bench rays -- [--full] [SCENE]...`
//!
//! Scenes are small unless `--full` is given. `turner bench rays` measures more, beside Embree and with threads.

use std::hint::black_box;
use std::time::Instant;

use turner_bvh::generate::{Scene, SceneKind, rays};
use turner_bvh::{Aabb, Bvh2, Bvh2Options, Bvh4, Ray};

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
        eprintln!("there is no scene \"{unknown}\"; valid: {}", valid.join(", "));
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
    let tree = Tree::build(scene);
    let seconds = start.elapsed().as_secs_f64();
    let count = scene.triangles();
    let extent = scene.extent();
    let primary = rays::primary(&scene.camera, resolution);
    let points: Vec<rays::Point> = primary
        .iter()
        .filter_map(|ray| {
            let (t, primitive) = tree.intersect(ray)?;
            rays::point(scene, extent, ray, t, u32::MAX, primitive)
        })
        .collect();
    let nearest = |rays: &[Ray]| {
        rate(rays.len(), || {
            for ray in rays {
                black_box(tree.intersect(ray));
            }
        })
    };
    let any = |rays: &[Ray]| {
        rate(rays.len(), || {
            for ray in rays {
                black_box(tree.occluded(ray));
            }
        })
    };
    let rates = [
        nearest(&primary),
        any(&rays::shadow(&points, scene.light)),
        nearest(&rays::diffuse(&points)),
        any(&rays::ambient(&points, 0.07 * extent)),
    ];
    let bytes = tree.bytes() as f64 / count as f64;
    print!("{:14} {count:>9} {:>9.3} {bytes:>8.1} ", kind.name(), count as f64 / 1e6 / seconds);
    println!("{}", rates.map(|rate| format!(" {rate:>8.3}")).concat());
}

/// Millions per second: the median of five runs.
fn rate(count: usize, mut work: impl FnMut()) -> f64 {
    let mut seconds = [0.0; 5].map(|_: f64| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    });
    seconds.sort_by(f64::total_cmp);
    count as f64 / 1e6 / seconds[2].max(1e-9)
}

/// Triangles in the leaves of a tree of boxes, by Möller and Trumbore's method.
struct Tree {
    tree: Bvh4,
    /// In the order of the leaves: a vertex and two edges.
    triangles: Vec<[[f32; 3]; 3]>,
}

impl Tree {
    fn build(scene: &Scene) -> Tree {
        let mesh = &scene.meshes[0];
        let boxes: Vec<Aabb> = (0..mesh.triangles.len())
            .map(|i| mesh.triangle(i).into_iter().fold(Aabb::EMPTY, Aabb::grow))
            .collect();
        let options = Bvh2Options { threads: 1, ..Bvh2Options::default() };
        let tree = Bvh4::collapse(&Bvh2::build(&boxes, &options).expect("fewer triangles than a tree holds"));
        let triangles = tree.order().iter().map(|&i| {
            let [a, b, c] = mesh.triangle(i as usize);
            [a, sub(b, a), sub(c, a)]
        });
        Tree { triangles: triangles.collect(), tree }
    }

    fn bytes(&self) -> usize {
        self.tree.bytes() + size_of_val(self.triangles.as_slice())
    }

    fn intersect(&self, ray: &Ray) -> Option<(f32, u32)> {
        let mut hit = None;
        self.tree.closest(ray, |positions, mut t_max| {
            for i in positions {
                if let Some(t) = meet(ray, &self.triangles[i as usize], t_max) {
                    t_max = t;
                    hit = Some((t, self.tree.order()[i as usize]));
                }
            }
            t_max
        });
        hit
    }

    fn occluded(&self, ray: &Ray) -> bool {
        self.tree.any(ray, |mut positions| {
            positions.any(|i| meet(ray, &self.triangles[i as usize], ray.t_max).is_some())
        })
    }
}

fn meet(ray: &Ray, &[a, e, f]: &[[f32; 3]; 3], t_max: f32) -> Option<f32> {
    let p = cross(ray.direction, f);
    let inverse = 1.0 / dot(e, p);
    let s = sub(ray.origin, a);
    let u = dot(s, p) * inverse;
    let q = cross(s, e);
    let v = dot(ray.direction, q) * inverse;
    let t = dot(f, q) * inverse;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= ray.t_min && t <= t_max).then_some(t)
}

fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
