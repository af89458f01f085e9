//! Many instances of one noisy sphere, rotated, scaled and sheared, in a cube.

use super::math::{cross, normalize, scale};
use super::{Camera, Instance, Random, Scene, noisy_icosphere};

pub(super) fn scene(count: usize, levels: u32) -> Scene {
    let mut random = Random::new(5);
    // Together they fill about a third of the cube of volume 8.
    let radius = 0.6 / cube_root(count.max(1) as f32) as f32;
    let instance = |random: &mut Random| {
        let [x, y, z] = rotation(random);
        let stretch: [f32; 3] = std::array::from_fn(|_| radius * random.between(0.6, 1.4));
        let shear = random.between(-0.3, 0.3);
        let center = random.in_cube();
        // Columns are the images of the axes.
        let columns = [
            scale(stretch[0], x),
            std::array::from_fn(|i| stretch[1] * (y[i] + shear * x[i])),
            scale(stretch[2], z),
        ];
        Instance {
            mesh: 0,
            transform: std::array::from_fn(|row| {
                [columns[0][row], columns[1][row], columns[2][row], center[row]]
            }),
        }
    };
    let camera =
        Camera { eye: [1.5, 1.1, 3.0], target: [0.0, 0.0, 0.0], up: [0.0, 1.0, 0.0], half_width: 0.5 };
    Scene {
        meshes: vec![noisy_icosphere(levels, 0.15, 9)],
        instances: (0..count).map(|_| instance(&mut random)).collect(),
        camera,
        light: [3.0, 5.0, 3.0],
    }
}

/// Three orthonormal vectors.
fn rotation(random: &mut Random) -> [[f32; 3]; 3] {
    let x = random.direction();
    loop {
        let other = cross(x, random.direction());
        if other.iter().any(|a| a.abs() > 0.1) {
            let y = normalize(other);
            return [x, y, cross(x, y)];
        }
    }
}

/// Newton's method: the platform's function differs between machines.
fn cube_root(x: f32) -> f64 {
    let x = f64::from(x);
    let mut root = x.max(1.0);
    for _ in 0..80 {
        root -= (root - x / (root * root)) / 3.0;
    }
    root
}
