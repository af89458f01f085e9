//! Whether a mesh encloses a volume.

use crate::schema::MeshData;

/// The number of edges of a mesh that do not have equally many triangles on both sides; 0 for a closed mesh whose
/// triangles are oriented alike. Vertices at one position count as one.
pub(in crate::shape) fn open_edges(mesh: &MeshData) -> usize {
    // Adding 0 turns −0 into 0.
    let key = |i: u32| mesh.positions.get(i as usize).map_or([0; 3], |p| p.map(|v| (v + 0.0).to_bits()));
    let mut order: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    order.sort_unstable_by_key(|i| key(*i));
    let mut same = vec![0u32; order.len()];
    for alike in order.chunk_by(|a, b| key(*a) == key(*b)) {
        alike.iter().for_each(|i| same[*i as usize] = alike[0]);
    }
    let mut edges = Vec::with_capacity(3 * mesh.triangles.len());
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| same.get(i as usize).copied().unwrap_or(i));
        for (from, to) in [(a, b), (b, c), (c, a)] {
            if from != to {
                edges.push((from.min(to), from.max(to), if from < to { 1i32 } else { -1 }));
            }
        }
    }
    edges.sort_unstable();
    let alike = |a: &(u32, u32, i32), b: &(u32, u32, i32)| (a.0, a.1) == (b.0, b.1);
    edges.chunk_by(alike).filter(|all| all.iter().map(|edge| edge.2).sum::<i32>() != 0).count()
}

/// Bytes that [`open_edges`] needs.
pub(super) fn open_edges_bytes(mesh: &MeshData) -> u64 {
    8 * mesh.positions.len() as u64 + 36 * mesh.triangles.len() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tetrahedron whose faces have vertices of their own.
    fn tetrahedron() -> MeshData {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.0, 0.0, 1.0]];
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
        let positions: Vec<[f32; 3]> = faces.iter().flatten().map(|i| corners[*i as usize]).collect();
        let triangles = (0..4).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        MeshData { positions, triangles, ..MeshData::default() }
    }

    #[test]
    fn closed_open_and_flipped() {
        let mut mesh = tetrahedron();
        assert_eq!(open_edges(&mesh), 0);
        mesh.triangles[1].swap(0, 1);
        assert_eq!(open_edges(&mesh), 3, "one face is turned over");
        mesh.triangles.remove(1);
        assert_eq!(open_edges(&mesh), 3, "one face is missing");
        assert_eq!(open_edges(&MeshData::default()), 0);
    }
}
