//! Triangle meshes.

/// A mesh as a file gives it: flat lists, indices checked by [`MeshData::check`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    /// Vertex positions.
    pub positions: Vec<[f32; 3]>,
    /// Vertex normals: none, or one per vertex.
    pub normals: Vec<[f32; 3]>,
    /// Vertex (u, v): none, or one per vertex.
    pub uvs: Vec<[f32; 2]>,
    /// Triangles, three vertices each.
    pub triangles: Vec<[u32; 3]>,
}
