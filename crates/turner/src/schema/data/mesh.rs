//! Triangle meshes and clouds of points, as files hold them.

use crate::schema::{ErrorCode, SceneError};

/// A mesh as a file gives it: flat lists, indices checked by [`MeshData::check`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    /// Vertex positions.
    pub positions: Vec<[f32; 3]>,
    /// Vertex normals: none, or one per vertex.
    pub normals: Vec<[f32; 3]>,
    /// Vertex (u, v), the first set: none, or one per vertex.
    pub uvs: Vec<[f32; 2]>,
    /// The other sets of (u, v), one per vertex each; textures choose by their number, the second set being 1.
    pub more_uvs: Vec<Vec<[f32; 2]>>,
    /// Tangents along u, and 1 or -1 for the side of the bitangent: none, or one per vertex.
    pub tangents: Vec<[f32; 4]>,
    /// Vertex colours, linear red, green, blue and opacity: none, or one per vertex.
    pub colors: Vec<[f32; 4]>,
    /// Triangles, three vertices each.
    pub triangles: Vec<[u32; 3]>,
    /// Which of the mesh's materials each triangle has: none, or one per triangle.
    pub face_materials: Vec<u16>,
    /// The names of these materials.
    pub material_names: Vec<String>,
}

impl MeshData {
    /// Refuses lists that do not fit together.
    pub fn check(&self) -> Result<(), SceneError> {
        let count = self.positions.len();
        let mut lists = vec![
            ("normals", self.normals.len()),
            ("uvs", self.uvs.len()),
            ("tangents", self.tangents.len()),
            ("colors", self.colors.len()),
        ];
        lists.extend(self.more_uvs.iter().map(|set| ("uvs", set.len())));
        for (what, found) in lists {
            if found != 0 && found != count {
                let message = format!("{found} {what} for {count} vertices of a mesh");
                return Err(SceneError::new(ErrorCode::Mesh, message)
                    .help(format!("give one per vertex, or no {what}")));
            }
        }
        for (i, triangle) in self.triangles.iter().enumerate() {
            if let Some(&bad) = triangle.iter().find(|&&v| v as usize >= count) {
                let message =
                    format!("triangle {i} of a mesh names vertex {bad}, but it has {count} vertices");
                return Err(SceneError::new(ErrorCode::Mesh, message).help("vertices are counted from 0"));
            }
        }
        let (found, count) = (self.face_materials.len(), self.triangles.len());
        if found != 0 && found != count {
            let message = format!("{found} materials for {count} triangles of a mesh");
            return Err(SceneError::new(ErrorCode::Mesh, message).help("give one per triangle, or none"));
        }
        Ok(())
    }

    /// Bytes it takes.
    pub fn memory(&self) -> usize {
        size_of_val(self)
            + size_of_val(&self.positions[..])
            + size_of_val(&self.normals[..])
            + size_of_val(&self.uvs[..])
            + self.more_uvs.iter().map(|set| size_of_val(&set[..])).sum::<usize>()
            + size_of_val(&self.tangents[..])
            + size_of_val(&self.colors[..])
            + size_of_val(&self.triangles[..])
            + size_of_val(&self.face_materials[..])
    }

    /// How many materials its triangles tell apart, at least 1.
    pub fn material_count(&self) -> usize {
        self.face_materials.iter().map(|&m| usize::from(m) + 1).max().unwrap_or(1)
    }
}
