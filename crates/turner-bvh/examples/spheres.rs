//! `BoxBvh` and `Bvh2` over spheres: million rays per second on one thread, and build and refit times. Methods take
//! turns.
//!
//! `cargo run --release -p turner-bvh --example spheres`

use std::hint::black_box;
use std::time::Instant;

use turner_bvh::generate::{Random, SceneKind, rays};
use turner_bvh::{Aabb, BoxBvh, BuildOptions, Bvh2, Bvh2Options, Ray};

fn main() {
    spheres(10_000);
    spheres(1_000_000);
}

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

fn spheres(count: usize) {
    let mut random = Random::new(1);
    let size = 0.6 / (0..60).fold(count as f32, |y, _| (2.0 * y + count as f32 / (y * y)) / 3.0);
    let spheres: Vec<Sphere> = (0..count)
        .map(|_| Sphere { center: random.in_cube(), radius: size * random.between(0.3, 1.0) })
        .collect();
    let boxes: Vec<Aabb> = spheres.iter().map(Sphere::bounds).collect();
    let time = Instant::now();
    let old = Bvh2::build(&boxes, &Bvh2Options { threads: 1, ..Bvh2Options::default() }).unwrap();
    let old_build = time.elapsed().as_secs_f64();
    let time = Instant::now();
    let new = BoxBvh::build(&boxes, &BuildOptions { threads: 1, ..BuildOptions::default() }).unwrap();
    let new_build = time.elapsed().as_secs_f64();
    let mut moved = new.clone();
    let time = Instant::now();
    moved.refit(&boxes).unwrap();
    let refit = time.elapsed().as_secs_f64();
    println!(
        "{count} spheres: Bvh2 {:.1} ms, {:.1} bytes each; BoxBvh {:.1} ms (refitted in {:.1} ms), {:.1} bytes each",
        old_build * 1e3,
        old.stats().bytes as f64 / count as f64,
        new_build * 1e3,
        refit * 1e3,
        new.bytes() as f64 / count as f64
    );
    let of_old: Vec<Sphere> = old.order().iter().map(|&i| spheres[i as usize]).collect();
    let of_new: Vec<Sphere> = new.order().iter().map(|&i| spheres[i as usize]).collect();
    let camera = SceneKind::Instances1k.generate(1).camera;
    let far: Vec<Ray> = rays::primary(&camera, 512);
    let inside: Vec<Ray> = (0..1 << 17).map(|_| Ray::new(random.in_cube(), random.direction())).collect();
    for (name, rays) in [("primary", &far), ("random", &inside)] {
        let mut found = vec![(f32::INFINITY, u32::MAX); rays.len()];
        let mut any = vec![false; rays.len()];
        let (mut a, mut b) = (vec![0.0; rays.len()], vec![0.0; rays.len()]);
        let rates = in_turn(
            rays.len(),
            &mut [
                ("Bvh2", &mut || {
                    for (ray, out) in rays.iter().zip(&mut a) {
                        let nearest = |range: std::ops::Range<u32>, t| {
                            let leaf = &of_old[range.start as usize..range.end as usize];
                            leaf.iter().fold(t, |t, sphere| sphere.hit(ray, t).unwrap_or(t))
                        };
                        *out = old.closest(ray, nearest);
                    }
                }),
                ("BoxBvh", &mut || {
                    for (ray, out) in rays.iter().zip(&mut b) {
                        let nearest = |range: std::ops::Range<u32>, t| {
                            let leaf = &of_new[range.start as usize..range.end as usize];
                            leaf.iter().fold(t, |t, sphere| sphere.hit(ray, t).unwrap_or(t))
                        };
                        *out = new.closest(ray, nearest);
                    }
                }),
                ("batch", &mut || {
                    found.fill((f32::INFINITY, u32::MAX));
                    new.closest_batch(rays, |i, range, mut t| {
                        for at in range {
                            if let Some(closer) = of_new[at as usize].hit(&rays[i], t) {
                                t = closer;
                                found[i] = (t, at);
                            }
                        }
                        t
                    });
                }),
                ("any: Bvh2", &mut || {
                    for ray in rays {
                        black_box(
                            old.any(ray, |mut r| r.any(|i| of_old[i as usize].hit(ray, ray.t_max).is_some())),
                        );
                    }
                }),
                ("BoxBvh", &mut || {
                    for ray in rays {
                        black_box(
                            new.any(ray, |mut r| r.any(|i| of_new[i as usize].hit(ray, ray.t_max).is_some())),
                        );
                    }
                }),
                ("batch", &mut || {
                    new.any_batch(rays, &mut any, |i, mut range| {
                        range.any(|at| of_new[at as usize].hit(&rays[i], f32::INFINITY).is_some())
                    });
                }),
            ],
        );
        println!("  {name:8} {rates}");
        assert!(a == b && b.iter().zip(&found).all(|(b, f)| *b == f.0));
    }
}

/// Million rays per second of each method, as medians; the methods take turns.
fn in_turn(count: usize, all: &mut [(&str, &mut dyn FnMut())]) -> String {
    let mut seconds = vec![Vec::new(); all.len()];
    for _ in 0..7 {
        for ((_, work), seconds) in all.iter_mut().zip(&mut seconds) {
            let start = Instant::now();
            work();
            seconds.push(start.elapsed().as_secs_f64());
        }
    }
    let median = |seconds: &mut Vec<f64>| {
        seconds.sort_by(f64::total_cmp);
        count as f64 / 1e6 / seconds[seconds.len() / 2]
    };
    let rates = all.iter().zip(&mut seconds).map(|((name, _), s)| format!("{name} {:.2}", median(s)));
    rates.collect::<Vec<_>>().join(", ")
}
