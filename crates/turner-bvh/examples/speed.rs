//! Million rays per second on one thread and build times of `Bvh2` for random spheres.
//!
//! `cargo run --release -p turner-bvh --example speed [NUMBER OF SPHERES]...`

use std::hint::black_box;
use std::time::Instant;

use turner_bvh::{Aabb, Bvh2, Bvh2Options, Ray};

#[derive(Clone, Copy)]
struct Sphere {
    center: [f32; 3],
    radius: f32,
}

impl Sphere {
    fn bounds(&self) -> Aabb {
        // Slightly larger than the sphere, for the rounding in `hit`.
        let r = self.radius * 1.00001;
        Aabb::new(self.center.map(|c| c - r), self.center.map(|c| c + r))
    }

    /// The nearest intersection with `t_min <= t <= t_max`, for a normalised direction.
    #[inline(always)]
    fn hit(&self, ray: &Ray, t_max: f32) -> Option<f32> {
        let [x, y, z] = std::array::from_fn(|i| self.center[i] - ray.origin[i]);
        let [u, v, w] = ray.direction;
        let b = x * u + y * v + z * w;
        let (p, q, r) = (x - b * u, y - b * v, z - b * w);
        let d = self.radius * self.radius - (p * p + q * q + r * r);
        if d < 0.0 {
            return None;
        }
        let root = d.sqrt();
        let near = b - root;
        let t = if near >= ray.t_min { near } else { b + root };
        (t >= ray.t_min && t <= t_max).then_some(t)
    }
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

    fn in_cube(&mut self) -> [f32; 3] {
        [0; 3].map(|_| 2.0 * self.next() - 1.0)
    }

    fn direction(&mut self) -> [f32; 3] {
        loop {
            let v = self.in_cube();
            let length2: f32 = v.iter().map(|x| x * x).sum();
            if length2 > 0.01 && length2 <= 1.0 {
                return v.map(|x| x / length2.sqrt());
            }
        }
    }
}

fn main() {
    let requested: Vec<u32> = std::env::args().skip(1).filter_map(|count| count.parse().ok()).collect();
    for count in if requested.is_empty() { vec![4, 30, 10_000, 1_000_000] } else { requested } {
        let mut random = Random(1);
        let size = 0.6 / cube_root(count as f32);
        let spheres: Vec<Sphere> = (0..count)
            .map(|_| Sphere { center: random.in_cube(), radius: size * (0.3 + 0.7 * random.next()) })
            .collect();
        let boxes: Vec<Aabb> = spheres.iter().map(Sphere::bounds).collect();
        let built: Vec<(Bvh2, f64)> = [1, 2]
            .map(|threads| {
                let start = Instant::now();
                let bvh = Bvh2::build(&boxes, &Bvh2Options { threads, ..Bvh2Options::default() }).unwrap();
                (bvh, start.elapsed().as_secs_f64())
            })
            .into();
        let bvh = &built[0].0;
        let stats = bvh.stats();
        println!(
            "{count} spheres: built in {:.1} ms, {:.1} ms with two threads; {} nodes, depth {}, SAH cost {:.1}, \
             {:.1} bytes each",
            built[0].1 * 1e3,
            built[1].1 * 1e3,
            stats.nodes,
            stats.max_depth,
            stats.sah_cost,
            stats.bytes as f64 / f64::from(count)
        );
        let spheres: Vec<Sphere> = bvh.order().iter().map(|&i| spheres[i as usize]).collect();
        measure("primary", bvh, &spheres, &primary_rays());
        measure("random ", bvh, &spheres, &random_rays());
    }
}

/// Newton's method.
fn cube_root(x: f32) -> f32 {
    (0..60).fold(x, |y, _| (2.0 * y + x / (y * y)) / 3.0)
}

/// Camera rays from in front of the cube, in 8 x 8 tiles.
fn primary_rays() -> Vec<Ray> {
    let size = 512;
    (0..size * size)
        .map(|i| {
            let (tile, pixel) = (i / 64, i % 64);
            let x = tile % (size / 8) * 8 + pixel % 8;
            let y = tile / (size / 8) * 8 + pixel / 8;
            let v = [x as f32 / size as f32 - 0.5, y as f32 / size as f32 - 0.5, 1.2];
            let length = v.iter().map(|x| x * x).sum::<f32>().sqrt();
            Ray::new([0.0, 0.0, -3.2], v.map(|x| x / length))
        })
        .collect()
}

fn random_rays() -> Vec<Ray> {
    let mut random = Random(2);
    (0..1 << 18).map(|_| Ray::new(random.in_cube(), random.direction())).collect()
}

fn measure(name: &str, bvh: &Bvh2, spheres: &[Sphere], rays: &[Ray]) {
    let mut hits = 0;
    let closest = best_time(|| hits = rays.iter().filter(|ray| closest(bvh, spheres, ray).is_some()).count());
    let any = best_time(|| {
        black_box(rays.iter().filter(|ray| any(bvh, spheres, ray)).count());
    });
    let millions = rays.len() as f64 / 1e6;
    let percent = 100.0 * hits as f64 / rays.len() as f64;
    println!(
        "  {name}: closest {:6.2} M/s, any {:6.2} M/s, {percent:.0} % hit",
        millions / closest,
        millions / any
    );
}

#[inline(never)]
fn closest(bvh: &Bvh2, spheres: &[Sphere], ray: &Ray) -> Option<(f32, u32)> {
    let mut hit = None;
    bvh.closest(ray, |range, mut t_max| {
        for i in range {
            if let Some(t) = spheres[i as usize].hit(ray, t_max) {
                t_max = t;
                hit = Some((t, i));
            }
        }
        t_max
    });
    hit
}

#[inline(never)]
fn any(bvh: &Bvh2, spheres: &[Sphere], ray: &Ray) -> bool {
    bvh.any(ray, |mut range| range.any(|i| spheres[i as usize].hit(ray, ray.t_max).is_some()))
}

/// Seconds of the fastest of several runs.
fn best_time(mut work: impl FnMut()) -> f64 {
    (0..15).fold(f64::INFINITY, |best, _| {
        let start = Instant::now();
        work();
        best.min(start.elapsed().as_secs_f64())
    })
}
