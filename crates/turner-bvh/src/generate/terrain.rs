//! A height field of fractal noise over a square.

use super::noise::{fractal2, noise2};
use super::{Camera, Mesh, Scene};

/// Half the side of the square.
const HALF: f32 = 10.0;

pub(super) fn scene(size: usize) -> Scene {
    let cells = (size / 2).isqrt().clamp(1, 40_000);
    let side = cells + 1;
    let mut mesh =
        Mesh { positions: Vec::with_capacity(side * side), triangles: Vec::with_capacity(2 * cells * cells) };
    // Octaves down to the size of the cells.
    let octaves = cells.ilog2() + 1;
    for j in 0..side {
        for i in 0..side {
            let [x, z] = [i, j].map(|n| HALF * (2.0 * n as f32 / cells as f32 - 1.0));
            mesh.positions.push([x, height([x, z], octaves), z]);
        }
    }
    for j in 0..cells {
        for i in 0..cells {
            let a = (j * side + i) as u32;
            let (b, c, d) = (a + 1, a + side as u32, a + side as u32 + 1);
            mesh.triangles.extend([[a, c, b], [b, c, d]]);
        }
    }
    let camera =
        Camera { eye: [-8.5, 3.2, -8.5], target: [0.5, -0.6, 0.5], up: [0.0, 1.0, 0.0], half_width: 0.6 };
    Scene::of(mesh, camera, [4.0, 9.0, -6.0])
}

/// Height of plains and mountains.
fn height([x, z]: [f32; 2], octaves: u32) -> f32 {
    let mountains = 0.5 + 0.5 * noise2([0.17 * x, 0.17 * z], 77);
    let height = fractal2([0.35 * x, 0.35 * z], octaves, 3);
    height * (0.25 + 1.2 * mountains * mountains)
}
