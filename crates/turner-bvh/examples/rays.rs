//! temp
use std::time::Instant;
use turner_bvh::*;
struct R(u64);
impl R {
    fn u(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        let x = self.0;
        (((x >> 22) ^ x) >> (22 + (x >> 61)) & 0xffffff) as f32 / 16777216.0
    }
}
fn sphere(n: usize, noise: f32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let mut p = vec![];
    let mut t = vec![];
    let m = 2 * n;
    let mut r = R(1);
    for i in 0..=n {
        for j in 0..=m {
            let th = i as f32 / n as f32 * std::f32::consts::PI;
            let ph = j as f32 / m as f32 * 2.0 * std::f32::consts::PI;
            let k = 1.0 + noise * (r.u() - 0.5);
            p.push([k * th.sin() * ph.cos(), k * th.cos(), k * th.sin() * ph.sin()]);
        }
    }
    let w = (m + 1) as u32;
    for i in 0..n as u32 {
        for j in 0..m as u32 {
            let a = i * w + j;
            t.push([a, a + 1, a + w]);
            t.push([a + 1, a + w + 1, a + w]);
        }
    }
    (p, t)
}
fn main() {
    let n: usize = std::env::args().nth(1).map_or(570, |s| s.parse().unwrap());
    let (p, t) = sphere(n, 3.0 / n as f32);
    let s = Instant::now();
    let bvh = Bvh::build(&Triangles { positions: &p, triangles: &t }, &BuildOptions::default()).unwrap();
    println!(
        "{} triangles, build {:.2}s {} nodes {} blocks",
        t.len(),
        s.elapsed().as_secs_f64(),
        bvh.stats().nodes,
        bvh.stats().blocks
    );
    let mut r = R(7);
    let mut primary = vec![];
    let res = 512;
    for by in 0..res / 4 {
        for bx in 0..res / 4 {
            for k in 0..16 {
                let x = (bx * 4 + k % 4) as f32 + 0.5;
                let y = (by * 4 + k / 4) as f32 + 0.5;
                primary.push(Ray::new(
                    [0.0, 0.3, -2.5],
                    [x / res as f32 - 0.5, y / res as f32 - 0.5 - 0.1, 1.0],
                ));
            }
        }
    }
    let mut hits = vec![Hit::MISS; primary.len()];
    bvh.intersect_batch(&primary, &mut hits);
    let nh = hits.iter().filter(|h| h.is_hit()).count();
    let mut diffuse = vec![];
    for (q, h) in primary.iter().zip(&hits) {
        if h.is_hit() {
            let pt = q.at(h.t * 0.9999);
            let d = loop {
                let d = [r.u() * 2.0 - 1.0, r.u() * 2.0 - 1.0, r.u() * 2.0 - 1.0];
                let l = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                if l < 1.0 && l > 0.01 {
                    break d;
                }
            };
            let s = d[0] * pt[0] + d[1] * pt[1] + d[2] * pt[2];
            let d = if s < 0.0 { d.map(|x| -x) } else { d };
            diffuse.push(Ray::new(pt, d));
        }
    }
    // inside rays: from centre region
    let inside: Vec<Ray> = (0..200000)
        .map(|_| Ray::new([r.u() - 0.5, r.u() - 0.5, r.u() - 0.5], [r.u() - 0.5, r.u() - 0.5, r.u() - 0.5]))
        .collect();
    println!("{nh} hits");
    for (name, rays) in [("primary", &primary), ("diffuse", &diffuse), ("inside", &inside)] {
        for k in Kernel::available() {
            k.force();
            let mut h = vec![Hit::MISS; rays.len()];
            let mut o = vec![false; rays.len()];
            let (mut b1, mut bb, mut a1, mut ab) = (0f64, 0f64, 0f64, 0f64);
            for _ in 0..5 {
                let s = Instant::now();
                bvh.intersect_batch(rays, &mut h);
                bb = bb.max(rays.len() as f64 / s.elapsed().as_secs_f64() / 1e6);
                let s = Instant::now();
                for (r, h) in rays.iter().zip(&mut h) {
                    *h = bvh.intersect(r).unwrap_or(Hit::MISS);
                }
                b1 = b1.max(rays.len() as f64 / s.elapsed().as_secs_f64() / 1e6);
                let s = Instant::now();
                bvh.occluded_batch(rays, &mut o);
                ab = ab.max(rays.len() as f64 / s.elapsed().as_secs_f64() / 1e6);
                let s = Instant::now();
                for (r, h) in rays.iter().zip(&mut o) {
                    *h = bvh.occluded(r);
                }
                a1 = a1.max(rays.len() as f64 / s.elapsed().as_secs_f64() / 1e6);
            }
            println!(
                "{name:8} {k:8} closest single {b1:6.2} batch {bb:6.2}  any single {a1:6.2} batch {ab:6.2}"
            );
        }
    }
}
