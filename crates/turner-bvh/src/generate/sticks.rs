//! Long thin sticks in a cube: their boxes are mostly empty and overlap.

use super::math::{add, cross, normalize, scale};
use super::{Camera, Mesh, Random, Scene};

/// Triangles of a stick: three quadrilaterals.
const TRIANGLES: usize = 6;

pub(super) fn scene(size: usize) -> Scene {
    let mut random = Random::new(2);
    let mut mesh = Mesh::default();
    let sticks = (size / TRIANGLES).max(1);
    for _ in 0..sticks {
        let middle = random.in_cube();
        let along = random.direction();
        let half = random.between(0.02, 0.12);
        let radius = random.between(0.0004, 0.0012);
        stick(&mut mesh, middle, scale(half, along), radius);
    }
    let camera =
        Camera { eye: [1.6, 1.2, 3.2], target: [0.0, 0.0, 0.0], up: [0.0, 1.0, 0.0], half_width: 0.5 };
    Scene::of(mesh, camera, [2.0, 3.0, 2.5])
}

/// A triangular prism around `middle`, extending by `half` in both directions.
fn stick(mesh: &mut Mesh, middle: [f32; 3], half: [f32; 3], radius: f32) {
    let along = normalize(half);
    let least = if along[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let x = normalize(cross(along, least));
    let y = cross(along, x);
    // The corners of an equilateral triangle.
    const CORNERS: [[f32; 2]; 3] = [[1.0, 0.0], [-0.5, 0.866_025_4], [-0.5, -0.866_025_4]];
    let first = mesh.positions.len() as u32;
    for end in [-1.0, 1.0] {
        for [a, b] in CORNERS {
            let side = add(scale(radius * a, x), scale(radius * b, y));
            mesh.vertex(add(add(middle, scale(end, half)), side));
        }
    }
    for i in 0..3 {
        let (a, b) = (first + i, first + (i + 1) % 3);
        mesh.triangles.extend([[a, b, b + 3], [a, b + 3, a + 3]]);
    }
}
