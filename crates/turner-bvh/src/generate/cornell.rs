//! The Cornell box with the published measurements, in millimetres.

use super::{Camera, Mesh, Scene};

pub(super) fn scene() -> Scene {
    let mut mesh = Mesh::default();
    const SIZE: f32 = 555.0;
    let (x, y, z) = ([SIZE, 0.0, 0.0], [0.0, SIZE, 0.0], [0.0, 0.0, SIZE]);
    let at = |corner: [f32; 3], a: [f32; 3], b: [f32; 3]| -> [[f32; 3]; 4] {
        let add = |p: [f32; 3], q: [f32; 3]| -> [f32; 3] { std::array::from_fn(|i| p[i] + q[i]) };
        [corner, add(corner, a), add(add(corner, a), b), add(corner, b)]
    };
    // Floor, ceiling, back wall, two sides, light: twelve triangles.
    mesh.quad(at([0.0; 3], x, z));
    mesh.quad(at(y, x, z));
    mesh.quad(at(z, x, y));
    mesh.quad(at([0.0; 3], y, z));
    mesh.quad(at(x, y, z));
    mesh.quad(at([213.0, 554.0, 227.0], [130.0, 0.0, 0.0], [0.0, 0.0, 105.0]));
    // The short and the tall block: twelve triangles each.
    mesh.block([130.0, 0.0, 65.0], [[-48.0, 0.0, 160.0], [158.0, 0.0, 47.0], [0.0, 165.0, 0.0]]);
    mesh.block([423.0, 0.0, 247.0], [[-158.0, 0.0, 49.0], [49.0, 0.0, 159.0], [0.0, 330.0, 0.0]]);
    let camera = Camera {
        eye: [278.0, 273.0, -780.0],
        target: [278.0, 273.0, 0.0],
        up: [0.0, 1.0, 0.0],
        half_width: 0.3535,
    };
    Scene::of(mesh, camera, [278.0, 540.0, 279.5])
}
