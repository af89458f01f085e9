//! Build speed, size and SAH cost of BVHs over triangles.
//!
//! `cargo run --release -p turner-bvh --example build_speed [FRACTION OF TRIANGLES] [RUNS] [SCENE]...`

use std::time::Instant;

use turner_bvh::{Aabb, BuildOptions, Quality, build_stats, build_stats_of_boxes};

struct Mesh {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

struct Random(u64);

impl Random {
    /// Uniform in [0, 1); splitmix64.
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1 << 24) as f32
    }

    fn point(&mut self) -> [f32; 3] {
        [0; 3].map(|_| self.next())
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let fraction: f32 = arguments.first().and_then(|a| a.parse().ok()).unwrap_or(1.0);
    let runs: usize = arguments.get(1).and_then(|a| a.parse().ok()).unwrap_or(3);
    let wanted = |name: &str| arguments.len() < 3 || arguments[2..].iter().any(|a| a == name);
    println!(
        "{:12} {:9} {:>9} {:>8} {:>8} {:>7} {:>8} {:>6} {:>6}",
        "scene", "quality", "triangles", "1 thread", "2", "B/tri", "SAH", "depth", "refs"
    );
    type Generator = fn(f32) -> Mesh;
    let scenes: [(&str, Generator); 5] = [
        ("architecture", architecture),
        ("sphere", sphere),
        ("sticks", sticks),
        ("terrain", terrain),
        ("boxes", spread),
    ];
    for (name, generate) in scenes {
        if !wanted(name) {
            continue;
        }
        let mesh = generate(fraction);
        let boxes = (name == "boxes").then(|| mesh_boxes(&mesh));
        for quality in [Quality::Fast, Quality::Balanced, Quality::High] {
            measure(name, &mesh, boxes.as_deref(), quality, runs);
        }
    }
}

/// Alternates builds with one and with two threads.
fn measure(name: &str, mesh: &Mesh, boxes: Option<&[Aabb]>, quality: Quality, runs: usize) {
    let mut seconds = [const { Vec::new() }; 2];
    let mut stats = None;
    for _ in 0..runs {
        for (threads, seconds) in (1..).zip(&mut seconds) {
            let options = BuildOptions { quality, threads, ..BuildOptions::default() };
            let start = (Instant::now(), cpu_seconds());
            let found = match boxes {
                Some(boxes) => build_stats_of_boxes(boxes, &options),
                None => build_stats(&mesh.positions, &mesh.triangles, &options),
            };
            // On a busy machine, the CPU time of the thread is more precise than the clock.
            let cpu = cpu_seconds().zip(start.1).filter(|_| threads == 1);
            seconds.push(cpu.map_or(start.0.elapsed().as_secs_f64(), |(end, start)| end - start));
            stats = Some(found.expect("the meshes are valid"));
        }
    }
    let stats = stats.expect("at least one run");
    let count = mesh.triangles.len();
    let [one, two] = seconds.map(|mut seconds| {
        seconds.sort_by(f64::total_cmp);
        count as f64 / seconds[seconds.len() / 2] / 1e6
    });
    println!(
        "{name:12} {:9} {count:9} {one:6.2}/s {two:6.2}/s {:7.1} {:8.2} {:6} {:6.2}",
        format!("{quality:?}"),
        stats.bytes as f64 / count as f64,
        stats.sah_cost,
        stats.max_depth,
        stats.references as f64 / count as f64,
    );
}

/// CPU time of this thread, where the system reports it.
fn cpu_seconds() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    Some(text.split(' ').next()?.parse::<f64>().ok()? * 1e-9)
}

/// A million small triangles scattered over a cube.
fn spread(fraction: f32) -> Mesh {
    let mut random = Random(4);
    let count = (1e6 * fraction) as u32;
    let positions = (0..count)
        .flat_map(|_| {
            let p = random.point();
            [(); 3].map(|()| random.point()).map(|d| std::array::from_fn(|i| p[i] + 0.01 * d[i]))
        })
        .collect();
    Mesh { positions, triangles: (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect() }
}

fn mesh_boxes(mesh: &Mesh) -> Vec<Aabb> {
    let bounds = |t: &[u32; 3]| t.iter().fold(Aabb::EMPTY, |b, &v| b.grow(mesh.positions[v as usize]));
    mesh.triangles.iter().map(bounds).collect()
}

/// A height field.
fn terrain(fraction: f32) -> Mesh {
    let size = (2236.0 * fraction.sqrt()) as u32;
    let octave_height = |x: f32, f: f32| triangle_wave(x * f);
    let height = |x: f32, y: f32| {
        (0..9).fold(0.0, |h, octave| {
            let f = (1 << octave) as f32;
            h + (octave_height(x + 0.37 * y, f) * octave_height(y - 0.21 * x + 0.3, f)) * 0.15 / f
        })
    };
    grid(size, |u, v| [u, v, height(u, v)])
}

/// 0 at the integers, 1 half-way between them.
fn triangle_wave(x: f32) -> f32 {
    let x = 2.0 * (x - x.floor()) - 1.0;
    1.0 - x * x
}

fn grid(size: u32, point: impl Fn(f32, f32) -> [f32; 3]) -> Mesh {
    let at = |i: u32| i as f32 / size as f32;
    let positions =
        (0..=size).flat_map(|j| (0..=size).map(move |i| (i, j))).map(|(i, j)| point(at(i), at(j))).collect();
    let triangles = (0..size)
        .flat_map(|j| (0..size).map(move |i| j * (size + 1) + i))
        .flat_map(|a| [[a, a + 1, a + size + 2], [a, a + size + 2, a + size + 1]])
        .collect();
    Mesh { positions, triangles }
}

/// A sphere with noise, like a scan: six grids.
fn sphere(fraction: f32) -> Mesh {
    let size = (330.0 * fraction.sqrt()) as u32;
    let mut random = Random(1);
    let mut mesh = Mesh { positions: Vec::new(), triangles: Vec::new() };
    for side in 0..6 {
        let face = grid(size, |u, v| {
            let mut p = [0.0; 3];
            p[side / 2] = if side % 2 == 0 { -1.0 } else { 1.0 };
            p[(side / 2 + 1) % 3] = 2.0 * u - 1.0;
            p[(side / 2 + 2) % 3] = 2.0 * v - 1.0;
            p
        });
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(face.positions.iter().map(|p| {
            let length = p.iter().map(|x| x * x).sum::<f32>().sqrt();
            p.map(|x| x / length * (1.0 + 0.005 * random.next()))
        }));
        mesh.triangles.extend(face.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    mesh
}

/// Long thin triangles in all directions.
fn sticks(fraction: f32) -> Mesh {
    let mut random = Random(2);
    let count = (500_000.0 * fraction) as u32;
    let positions = (0..count)
        .flat_map(|_| {
            let (p, d) = (random.point(), random.point().map(|x| 0.2 * (x - 0.5)));
            let w = random.point().map(|x| 0.002 * (x - 0.5));
            [p, std::array::from_fn(|i| p[i] + w[i]), std::array::from_fn(|i| p[i] + d[i])]
        })
        .collect();
    Mesh { positions, triangles: (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect() }
}

/// Floors and walls of two triangles each, columns, and small objects.
fn architecture(fraction: f32) -> Mesh {
    let mut random = Random(3);
    let mut mesh = Mesh { positions: Vec::new(), triangles: Vec::new() };
    let cuboid = |mesh: &mut Mesh, min: [f32; 3], max: [f32; 3], turn: f32| {
        let first = mesh.positions.len() as u32;
        let (c, s) = (1.0 - turn * turn / 2.0, turn);
        for i in 0..8 {
            let p: [f32; 3] = std::array::from_fn(|k| if i >> k & 1 == 0 { min[k] } else { max[k] });
            mesh.positions.push([c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]]);
        }
        for [a, b, c, d] in
            [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]]
        {
            mesh.triangles.extend([[a, b, c], [a, c, d]].map(|t| t.map(|v| v + first)));
        }
    };
    let floors = 4;
    for floor in 0..floors {
        let z = floor as f32 * 3.0;
        cuboid(&mut mesh, [0.0, 0.0, z - 0.2], [40.0, 25.0, z], 0.1);
        for i in 0..=8 {
            let x = i as f32 * 5.0;
            cuboid(&mut mesh, [x, 0.0, z], [x + 0.15, 10.0, z + 2.8], 0.1);
            cuboid(&mut mesh, [x, 14.0, z], [x + 0.15, 25.0, z + 2.8], 0.1);
        }
        for y in [0.0, 10.0, 14.0, 25.0] {
            cuboid(&mut mesh, [0.0, y, z], [40.0, y + 0.15, z + 2.8], 0.1);
        }
    }
    let objects = (5200.0 * fraction) as u32;
    for _ in 0..objects {
        let p = random.point();
        let floor = (p[2] * floors as f32).floor() * 3.0;
        let size = random.point().map(|x| 0.02 + 1.2 * x * x * x);
        let min = [p[0] * 38.0, p[1] * 24.0, floor];
        cuboid(&mut mesh, min, std::array::from_fn(|i| min[i] + size[i]), 0.1 + 0.3 * random.next());
    }
    mesh
}
