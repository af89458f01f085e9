//! A sphere displaced by noise, like a scanned stone: fine triangles of similar size.

use std::collections::HashMap;

use super::math::{add, normalize, scale};
use super::noise::fractal3;
use super::{Camera, Mesh, Scene};

pub(super) fn scene(size: usize) -> Scene {
    let levels = (0..12).rev().find(|&l| 20 << (2 * l) <= size.max(20)).unwrap_or(0);
    let camera =
        Camera { eye: [1.1, 1.3, 3.0], target: [0.0, 0.0, 0.0], up: [0.0, 1.0, 0.0], half_width: 0.42 };
    Scene::of(noisy_icosphere(levels, 0.12, 1), camera, [3.0, 4.0, 2.0])
}

/// A unit sphere of `20 * 4^levels` triangles. Each vertex is moved along its radius by fractal noise of this strength.
///
/// # Panics
///
/// If `levels` is more than 12.
pub fn noisy_icosphere(levels: u32, strength: f32, seed: u32) -> Mesh {
    assert!(levels <= 12, "more triangles than indices can number");
    let mut mesh = icosahedron();
    for _ in 0..levels {
        subdivide(&mut mesh);
    }
    // Octaves down to the size of the triangles.
    let octaves = levels + 1;
    for p in &mut mesh.positions {
        let height = fractal3(p.map(|x| 2.0 * x), octaves, seed);
        *p = scale(1.0 + strength * height, *p);
    }
    mesh
}

fn icosahedron() -> Mesh {
    // The golden ratio.
    const G: f32 = 1.618_034;
    let mut mesh = Mesh::default();
    for (a, b) in [(-1.0, G), (1.0, G), (-1.0, -G), (1.0, -G)] {
        mesh.positions.extend([[a, b, 0.0], [0.0, a, b], [b, 0.0, a]]);
    }
    mesh.positions.iter_mut().for_each(|p| *p = normalize(*p));
    // The faces are the triples of adjacent vertices, found by distance and oriented outwards.
    let near = |a: usize, b: usize| {
        let (p, q) = (mesh.positions[a], mesh.positions[b]);
        (0..3).map(|i| (p[i] - q[i]) * (p[i] - q[i])).sum::<f32>() < 1.2
    };
    let mut faces = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(c, a) {
                    faces.push([a as u32, b as u32, c as u32]);
                }
            }
        }
    }
    for face in &mut faces {
        let [p, q, r] = face.map(|i| mesh.positions[i as usize]);
        let triple: f32 = (0..3)
            .map(|i| {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                p[i] * (q[j] * r[k] - q[k] * r[j])
            })
            .sum();
        if triple < 0.0 {
            face.swap(1, 2);
        }
    }
    mesh.triangles = faces;
    mesh
}

/// Splits each triangle into four.
fn subdivide(mesh: &mut Mesh) {
    let old = std::mem::take(&mut mesh.triangles);
    mesh.triangles.reserve_exact(4 * old.len());
    mesh.positions.reserve_exact(old.len() * 3 / 2);
    let mut middles = HashMap::with_capacity(old.len() * 3 / 2);
    for [a, b, c] in old {
        let [d, e, f] = [(a, b), (b, c), (c, a)].map(|(a, b)| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let middle = add(mesh.positions[a as usize], mesh.positions[b as usize]);
                mesh.vertex(normalize(middle))
            })
        });
        mesh.triangles.extend([[a, d, f], [d, b, e], [f, e, c], [d, e, f]]);
    }
}
