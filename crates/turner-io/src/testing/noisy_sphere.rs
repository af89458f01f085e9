//! A geodesic sphere with noise: a mesh of any size that has the same bytes on every machine.

use std::collections::HashMap;

use turner::math::DVec3;
use turner::math::elementary::sin;

use super::waves::WAVES;

/// Amplitude of the noise as a fraction of the radius.
const HEIGHT: f64 = 0.35;

/// Vertices and faces of the icosahedron.
const GOLDEN: f64 = 1.618_033_988_749_895;
const CORNERS: [[f64; 3]; 12] = [
    [-1.0, GOLDEN, 0.0],
    [1.0, GOLDEN, 0.0],
    [-1.0, -GOLDEN, 0.0],
    [1.0, -GOLDEN, 0.0],
    [0.0, -1.0, GOLDEN],
    [0.0, 1.0, GOLDEN],
    [0.0, -1.0, -GOLDEN],
    [0.0, 1.0, -GOLDEN],
    [GOLDEN, 0.0, -1.0],
    [GOLDEN, 0.0, 1.0],
    [-GOLDEN, 0.0, -1.0],
    [-GOLDEN, 0.0, 1.0],
];
const FACES: [[usize; 3]; 20] = [
    [0, 11, 5],
    [0, 5, 1],
    [0, 1, 7],
    [0, 7, 10],
    [0, 10, 11],
    [1, 5, 9],
    [5, 11, 4],
    [11, 10, 2],
    [10, 7, 6],
    [7, 1, 8],
    [3, 9, 4],
    [3, 4, 2],
    [3, 2, 6],
    [3, 6, 8],
    [3, 8, 9],
    [4, 9, 5],
    [2, 4, 11],
    [6, 2, 10],
    [8, 6, 7],
    [9, 8, 1],
];

/// A binary PLY of 20 n² triangles (n = 200 for scene S4, at most 1000). Each face of an icosahedron is divided
/// into n² triangles; their vertices are projected onto the unit sphere and displaced radially by a sum of sine
/// waves. The lowest vertex has y = 0.
pub fn noisy_sphere_ply(n: u32) -> Vec<u8> {
    let n = n.clamp(1, 1000);
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    // Faces share the vertices on their edges: positions that agree to seven digits are one vertex.
    let mut known: HashMap<[i64; 3], u32> = HashMap::new();
    for [a, b, c] in FACES.map(|face| face.map(|i| DVec3::from(CORNERS[i]).normalize())) {
        let mut at = |i: u32, j: u32| {
            let k = n - i - j;
            let flat = (f64::from(k) * a + f64::from(i) * b + f64::from(j) * c) / f64::from(n);
            let key = flat.to_array().map(|v| (v * 1e7).round_ties_even() as i64);
            *known.entry(key).or_insert_with(|| {
                points.push(moved(flat.normalize()));
                points.len() as u32 - 1
            })
        };
        for i in 0..n {
            for j in 0..n - i {
                triangles.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                if i + j + 1 < n {
                    triangles.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
    }
    let floor = points.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    write(points.iter().map(|p| [p.x, p.y - floor, p.z].map(|v| v as f32)), points.len(), &triangles)
}

fn moved(p: DVec3) -> DVec3 {
    let (mut height, mut frequency, mut amplitude) = (0.0, 2.0, 1.0);
    for octave in &WAVES {
        let wave = |[x, y, z, phase]: &[f64; 4]| sin(frequency * p.dot(DVec3::new(*x, *y, *z)) + phase);
        height += amplitude * octave.iter().map(wave).sum::<f64>() / octave.len() as f64;
        frequency *= 2.3;
        amplitude *= 0.5;
    }
    p * (1.0 + HEIGHT * height)
}

fn write(points: impl Iterator<Item = [f32; 3]>, count: usize, triangles: &[[u32; 3]]) -> Vec<u8> {
    let header = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        triangles.len()
    );
    let mut out = header.into_bytes();
    out.extend(points.flatten().flat_map(f32::to_le_bytes));
    for triangle in triangles {
        out.push(3);
        out.extend(triangle.iter().flat_map(|i| i.to_le_bytes()));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_closed_mesh_of_the_size_asked_for() {
        let bytes = noisy_sphere_ply(6);
        let text = String::from_utf8_lossy(&bytes[..200]);
        // Euler: V − E + F = 2 with E = 3 F / 2.
        assert!(text.contains("element vertex 362\n") && text.contains("element face 720\n"), "{text}");
    }
}
