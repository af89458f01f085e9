//! Meshes whose triangles share no vertices.

use turner::schema::MeshData;

/// Bytes of the vertices and triangles of [`with_own_vertices`].
pub(crate) fn bytes(mesh: &MeshData) -> u64 {
    let lists = [
        (!mesh.positions.is_empty(), 12),
        (!mesh.normals.is_empty(), 12),
        (!mesh.uvs.is_empty(), 8),
        (!mesh.tangents.is_empty(), 16),
        (!mesh.colors.is_empty(), 16),
    ];
    let vertex: u64 = lists.iter().filter(|(is_given, _)| *is_given).map(|(_, bytes)| bytes).sum();
    let vertex = vertex + 8 * mesh.more_uvs.len() as u64;
    (3 * vertex + 12) * mesh.triangles.len() as u64
}

/// The mesh with three vertices of its own for each triangle, in the order of the triangles. `None` if memory is short or
/// if there would be more vertices than indices have.
pub(crate) fn with_own_vertices(mesh: &MeshData) -> Option<MeshData> {
    fn copied<T: Copy + Default>(list: &[T], triangles: &[[u32; 3]]) -> Option<Vec<T>> {
        let mut out = Vec::new();
        if !list.is_empty() {
            out.try_reserve_exact(triangles.len().checked_mul(3)?).ok()?;
            let of = |i: u32| list.get(i as usize).copied().unwrap_or_default();
            out.extend(triangles.iter().flatten().map(|&i| of(i)));
        }
        Some(out)
    }
    let count = u32::try_from(mesh.triangles.len()).ok().filter(|n| *n <= u32::MAX / 3)?;
    let mut triangles = Vec::new();
    triangles.try_reserve_exact(count as usize).ok()?;
    triangles.extend((0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]));
    Some(MeshData {
        positions: copied(&mesh.positions, &mesh.triangles)?,
        normals: copied(&mesh.normals, &mesh.triangles)?,
        uvs: copied(&mesh.uvs, &mesh.triangles)?,
        more_uvs: mesh.more_uvs.iter().map(|set| copied(set, &mesh.triangles)).collect::<Option<_>>()?,
        tangents: copied(&mesh.tangents, &mesh.triangles)?,
        colors: copied(&mesh.colors, &mesh.triangles)?,
        triangles,
        polygons: mesh.polygons.clone(),
        face_materials: mesh.face_materials.clone(),
        material_names: mesh.material_names.clone(),
        ..MeshData::default()
    })
}
