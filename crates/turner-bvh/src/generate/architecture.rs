//! A hall with floor, windowed walls, columns, stairs and railings; tiny ornaments fill the triangle budget.

use super::math::{add, circle, scale};
use super::{Camera, Mesh, Random, Scene, noisy_icosphere};

/// Half the length of the hall, in metres.
const LENGTH: f32 = 40.0;
/// Half the width.
const WIDTH: f32 = 12.0;
/// The height.
const HEIGHT: f32 = 14.0;
/// Half the distance between the two rows of columns.
const ROW: f32 = 7.0;
/// Distance between columns.
const STEP: f32 = 6.0;

const X: [f32; 3] = [1.0, 0.0, 0.0];
const Y: [f32; 3] = [0.0, 1.0, 0.0];
const Z: [f32; 3] = [0.0, 0.0, 1.0];

pub(super) fn scene(size: usize) -> Scene {
    let mut mesh = Mesh::default();
    shell(&mut mesh);
    for x in columns() {
        for z in [-ROW, ROW] {
            column(&mut mesh, [x, 0.0, z]);
        }
    }
    stairs(&mut mesh);
    for z in [-ROW, ROW] {
        railing(&mut mesh, z);
    }
    ornament(&mut mesh, size);
    let camera =
        Camera { eye: [-36.0, 2.6, 2.2], target: [0.0, 4.4, -1.0], up: [0.0, 1.0, 0.0], half_width: 0.75 };
    Scene::of(mesh, camera, [-6.0, 11.5, 1.5])
}

fn columns() -> impl Iterator<Item = f32> {
    (0..13).map(|i| STEP * (i as f32 - 6.0))
}

/// An axis-aligned box between two corners.
fn upright(mesh: &mut Mesh, min: [f32; 3], max: [f32; 3]) {
    let [x, y, z]: [f32; 3] = std::array::from_fn(|i| max[i] - min[i]);
    mesh.block(min, [scale(x, X), scale(y, Y), scale(z, Z)]);
}

/// Floor and ceiling of two triangles each, end walls, side walls with windows, and beams.
fn shell(mesh: &mut Mesh) {
    for y in [0.0, HEIGHT] {
        mesh.quad([[-LENGTH, y, -WIDTH], [LENGTH, y, -WIDTH], [LENGTH, y, WIDTH], [-LENGTH, y, WIDTH]]);
    }
    for x in [-LENGTH, LENGTH] {
        mesh.quad([[x, 0.0, -WIDTH], [x, 0.0, WIDTH], [x, HEIGHT, WIDTH], [x, HEIGHT, -WIDTH]]);
    }
    for z in [-WIDTH, WIDTH] {
        // Below and above the windows the wall is one box.
        for (low, high) in [(0.0, 2.0), (10.0, HEIGHT)] {
            upright(mesh, [-LENGTH, low, z - 0.3], [LENGTH, high, z + 0.3]);
        }
        for x in columns() {
            upright(mesh, [x - 1.6, 2.0, z - 0.3], [x + 1.6, 10.0, z + 0.3]);
            // Bars in the window.
            for i in 0..4 {
                let at = x + 1.95 + 0.7 * i as f32;
                upright(mesh, [at, 2.0, z - 0.02], [at + 0.04, 10.0, z + 0.02]);
            }
            for i in 0..10 {
                let at = 2.4 + 0.8 * i as f32;
                upright(mesh, [x + 1.6, at, z - 0.02], [x + 4.4, at + 0.04, z + 0.02]);
            }
        }
    }
    for x in columns() {
        upright(mesh, [x - 0.35, HEIGHT - 0.9, -WIDTH], [x + 0.35, HEIGHT, WIDTH]);
    }
}

/// A surface of revolution: rings of (radius, height), joined by bands of long triangles.
fn lathe(mesh: &mut Mesh, foot: [f32; 3], doublings: u32, profile: &[[f32; 2]]) {
    let circle = circle(doublings);
    let count = circle.len() as u32;
    let first = mesh.positions.len() as u32;
    for &[radius, height] in profile {
        mesh.positions.extend(circle.iter().map(|&[x, z]| add(foot, [radius * x, height, radius * z])));
    }
    for ring in 0..profile.len() as u32 - 1 {
        for i in 0..count {
            let a = first + ring * count + i;
            let b = first + ring * count + (i + 1) % count;
            mesh.triangles.extend([[a, a + count, b], [b, a + count, b + count]]);
        }
    }
}

/// A shaft as high as the hall on a moulded base, between two slabs.
fn column(mesh: &mut Mesh, [x, y, z]: [f32; 3]) {
    upright(mesh, [x - 0.8, y, z - 0.8], [x + 0.8, y + 0.3, z + 0.8]);
    upright(mesh, [x - 0.8, HEIGHT - 1.2, z - 0.8], [x + 0.8, HEIGHT - 0.9, z + 0.8]);
    let profile = [
        [0.75, 0.3],
        [0.78, 0.38],
        [0.72, 0.46],
        [0.6, 0.55],
        [0.5, HEIGHT - 1.7],
        [0.62, HEIGHT - 1.6],
        [0.75, HEIGHT - 1.2],
    ];
    lathe(mesh, [x, y, z], 3, &profile);
}

/// A broad flight of stairs at the far end.
fn stairs(mesh: &mut Mesh) {
    const STEPS: u32 = 24;
    for i in 0..STEPS {
        let (x, y) = (22.0 + 0.5 * i as f32, 0.17 * i as f32);
        upright(mesh, [x, 0.0, -ROW + 1.2], [LENGTH, y + 0.17, ROW - 1.2]);
        // The nosing of each step.
        upright(mesh, [x - 0.03, y + 0.14, -ROW + 1.2], [x, y + 0.17, ROW - 1.2]);
    }
}

/// A gallery with a railing of turned balusters along a row of columns.
fn railing(mesh: &mut Mesh, z: f32) {
    let (floor, inner) = (5.0, z - 0.2 * z.signum());
    let outer = WIDTH * z.signum();
    upright(mesh, [-LENGTH, floor - 0.4, z.min(outer)], [LENGTH, floor, z.max(outer)]);
    upright(mesh, [-LENGTH, floor + 1.0, inner - 0.07], [LENGTH, floor + 1.1, inner + 0.07]);
    let profile = [[0.05, 0.0], [0.03, 0.1], [0.06, 0.35], [0.025, 0.75], [0.04, 1.0]];
    let count = (2.0 * LENGTH / 1.0) as u32;
    for i in 0..count {
        lathe(mesh, [-LENGTH + 0.5 + i as f32, floor, inner], 1, &profile);
    }
}

/// Small stones around the columns and along the walls, up to `size` triangles in total.
fn ornament(mesh: &mut Mesh, size: usize) {
    let stone = noisy_icosphere(1, 0.1, 4);
    let room = size.saturating_sub(mesh.triangles.len()) / stone.triangles.len();
    let mut random = Random::new(3);
    let circle_points = circle(4);
    let feet: Vec<[f32; 2]> = columns().flat_map(|x| [[x, -ROW], [x, ROW]]).collect();
    for i in 0..room {
        let radius = random.between(0.02, 0.06);
        let position = if i % 4 == 3 {
            // Along the walls, below the windows.
            let side = if random.unit() < 0.5 { -1.0 } else { 1.0 };
            [random.between(-LENGTH, LENGTH), random.between(1.5, 1.9), side * (WIDTH - 0.32)]
        } else {
            let [x, z] = feet[i % feet.len()];
            let [c, s] = circle_points[(random.bits() % circle_points.len() as u64) as usize];
            let height = if i % 4 == 0 { 1.2 } else { HEIGHT - 2.2 };
            [x + 0.58 * c, height + random.between(-0.25, 0.25), z + 0.58 * s]
        };
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(stone.positions.iter().map(|&p| add(position, scale(radius, p))));
        mesh.triangles.extend(stone.triangles.iter().map(|t| t.map(|i| first + i)));
    }
}
