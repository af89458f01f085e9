//! Triangle meshes, point clouds and curves, as read from files.

use crate::schema::{ErrorCode, SceneError};

/// A mesh as read from a file: flat lists. [`MeshData::check`] validates the indices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    /// Vertex positions.
    pub positions: Vec<[f32; 3]>,
    /// Vertex normals: none, or one per vertex.
    pub normals: Vec<[f32; 3]>,
    /// The first set of vertex (u, v): none, or one per vertex.
    pub uvs: Vec<[f32; 2]>,
    /// The other sets of (u, v), each with one per vertex. Textures select a set by its index; these start at 1.
    pub more_uvs: Vec<Vec<[f32; 2]>>,
    /// Tangents along u, with the sign of the bitangent (1 or −1) as the fourth component: none, or one per vertex.
    pub tangents: Vec<[f32; 4]>,
    /// Vertex colours, linear red, green, blue and opacity: none, or one per vertex.
    pub colors: Vec<[f32; 4]>,
    /// Triangles as three vertex indices each.
    pub triangles: Vec<[u32; 3]>,
    /// The number of consecutive triangles of each polygon that they were cut from: none if all polygons are triangles.
    /// Subdivision divides the polygons.
    pub polygons: Vec<u32>,
    /// The material index of each triangle within the mesh: none, or one per triangle.
    pub face_materials: Vec<u16>,
    /// The names of the mesh's materials.
    pub material_names: Vec<String>,
    /// Of curves, the number of points of each: none, or together one per vertex. Without them all vertices are one curve.
    pub strands: Vec<u32>,
    /// Of curves, the width at each vertex: none, or one per vertex.
    pub widths: Vec<f32>,
}

impl MeshData {
    /// Checks that list lengths agree and indices are in range.
    pub fn check(&self) -> Result<(), SceneError> {
        let count = self.positions.len();
        let mut lists = vec![
            ("normals", self.normals.len()),
            ("uvs", self.uvs.len()),
            ("tangents", self.tangents.len()),
            ("colors", self.colors.len()),
            ("widths", self.widths.len()),
        ];
        lists.extend(self.more_uvs.iter().map(|set| ("uvs", set.len())));
        for (what, found) in lists {
            if found != 0 && found != count {
                let message = format!("{found} {what} for {count} vertices of a mesh");
                return Err(SceneError::new(ErrorCode::Mesh, message)
                    .help(format!("give one per vertex, or no {what}")));
            }
        }
        let in_strands: u64 = self.strands.iter().map(|n| u64::from(*n)).sum();
        if !self.strands.is_empty() && in_strands != count as u64 {
            let message =
                format!("{} curves have {in_strands} points, but there are {count}", self.strands.len());
            return Err(SceneError::new(ErrorCode::Mesh, message)
                .help("the numbers of points of all curves sum to the number of points"));
        }
        for (i, triangle) in self.triangles.iter().enumerate() {
            if let Some(&bad) = triangle.iter().find(|&&v| v as usize >= count) {
                let message =
                    format!("triangle {i} of a mesh names vertex {bad}, but it has {count} vertices");
                return Err(SceneError::new(ErrorCode::Mesh, message).help("vertices are counted from 0"));
            }
        }
        let (found, count) = (self.face_materials.len(), self.triangles.len());
        let sum: u64 = self.polygons.iter().map(|n| u64::from(*n)).sum();
        if !self.polygons.is_empty() && (sum != count as u64 || self.polygons.contains(&0)) {
            let message =
                format!("the polygons of a mesh have {sum} triangles, but it has {count} triangles");
            return Err(SceneError::new(ErrorCode::Mesh, message).help("each has at least one triangle"));
        }
        if found != 0 && found != count {
            let message = format!("{found} materials for {count} triangles of a mesh");
            return Err(SceneError::new(ErrorCode::Mesh, message).help("give one per triangle, or none"));
        }
        Ok(())
    }

    /// Memory in bytes.
    pub fn memory(&self) -> usize {
        size_of_val(self)
            + size_of_val(&self.positions[..])
            + size_of_val(&self.normals[..])
            + size_of_val(&self.uvs[..])
            + self.more_uvs.iter().map(|set| size_of_val(&set[..])).sum::<usize>()
            + size_of_val(&self.tangents[..])
            + size_of_val(&self.colors[..])
            + size_of_val(&self.triangles[..])
            + size_of_val(&self.polygons[..])
            + size_of_val(&self.face_materials[..])
            + size_of_val(&self.strands[..])
            + size_of_val(&self.widths[..])
    }

    /// The number of points of each curve.
    pub fn curve_counts(&self) -> impl Iterator<Item = u32> + '_ {
        let all = self.strands.is_empty() && !self.positions.is_empty();
        self.strands.iter().copied().chain(all.then_some(self.positions.len() as u32))
    }

    /// The number of materials its triangles refer to, at least 1.
    pub fn material_count(&self) -> usize {
        self.face_materials.iter().map(|&m| usize::from(m) + 1).max().unwrap_or(1)
    }
}
