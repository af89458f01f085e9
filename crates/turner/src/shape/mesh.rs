//! Triangle meshes as a scene describes them.

use std::collections::HashMap;
use std::sync::Arc;

use super::triangle_mesh::TriangleMesh;
use crate::math::{DVec2, DVec3};
use crate::scene::read::ReadContext;
use crate::scene::schema::{EntryDoc, TableReader, params};
use crate::scene::{Asset, ErrorCode, MeshId, SceneError};

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

impl MeshData {
    /// Refuses lists that do not fit together.
    pub fn check(&self) -> Result<(), SceneError> {
        let count = self.positions.len();
        for (what, found) in [("normals", self.normals.len()), ("uvs", self.uvs.len())] {
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
        Ok(())
    }
}

params! {
    /// A mesh of triangles, from an OBJ or PLY file or written in place. (u, v) are the file's; without any, they are the
    /// weights of a triangle's second and third vertex. The normal points to the side from which the vertices turn
    /// counter-clockwise.
    pub struct MeshKeys as "mesh" {
        /// A .obj or .ply file.
        file: Option<String> = None;
        /// Vertices, instead of `file`.
        positions: Option<Vec<DVec3>> = None;
        /// Triangles of three vertices each, counted from 0.
        triangles: Option<Vec<[u32; 3]>> = None;
        /// Normals for smooth shading, one per vertex.
        normals: Option<Vec<DVec3>> = None;
        /// Surface coordinates, one pair per vertex.
        uvs: Option<Vec<DVec2>> = None;
        /// Whether to shade with vertex normals. If not given: where the mesh has normals. `true` for a mesh without normals
        /// computes them from the triangles around each vertex, weighted by area; `false` shows every facet.
        smooth: Option<bool> = None;
    }
    example r#"[[object]]
type = "mesh"
positions = [[-1, 0, 1], [1, 0, 1], [0, 0, -1], [0, 1.5, 0]]
triangles = [[0, 1, 3], [1, 2, 3], [2, 0, 3], [0, 2, 1]]
material = { color = "salmon" }
"#
}

/// A mesh, its data in the scene's list.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshDesc {
    /// Which mesh.
    pub mesh: MeshId,
    /// Whether to shade with vertex normals; by default if the mesh has any.
    pub smooth: Option<bool>,
}

impl MeshDesc {
    /// Its documentation.
    pub const DOC: EntryDoc = MeshKeys::DOC;

    /// Reads its keys; puts data written in place into the scene's list of meshes.
    pub fn read(table: &mut TableReader<'_>, cx: &mut ReadContext<'_>) -> Result<MeshDesc, SceneError> {
        let keys = MeshKeys::read(table, cx)?;
        let (smooth, span) = (keys.smooth, table.span());
        let inline = keys.positions.is_some()
            || keys.triangles.is_some()
            || keys.normals.is_some()
            || keys.uvs.is_some();
        let mesh = match keys.file {
            Some(_) if inline => {
                let message =
                    "a mesh has either a `file` or `positions`, `triangles`, `normals`, `uvs` in place";
                return Err(SceneError::at(ErrorCode::Conflict, table.span_of("file"), message)
                    .help("remove one of the two"));
            }
            Some(uri) => cx.mesh_file(&uri, table.span_of("file"))?,
            None => {
                let (Some(positions), Some(triangles)) = (keys.positions, keys.triangles) else {
                    let message = "a mesh needs a `file`, or `positions` and `triangles`";
                    return Err(SceneError::at(ErrorCode::MissingKey, span, message)
                        .help("add `file = \"model.obj\"`"));
                };
                let single = |v: Vec<DVec3>| v.into_iter().map(|p| p.as_vec3().to_array()).collect();
                let data = MeshData {
                    positions: single(positions),
                    normals: single(keys.normals.unwrap_or_default()),
                    uvs: keys.uvs.unwrap_or_default().iter().map(|p| p.as_vec2().to_array()).collect(),
                    triangles,
                };
                data.check().map_err(|e| e.or_at(Some(span)))?;
                cx.inline_mesh(data)
            }
        };
        Ok(MeshDesc { mesh, smooth })
    }
}

/// The meshes of a scene, prepared at first use and then shared by all objects that show them the same way.
#[derive(Debug)]
pub struct MeshCache<'a> {
    meshes: &'a [Asset<MeshData>],
    prepared: HashMap<(MeshId, bool), Arc<TriangleMesh>>,
    /// What was left out of the meshes prepared so far, a sentence each.
    pub warnings: Vec<String>,
}

impl<'a> MeshCache<'a> {
    /// Over the scene's list, by [`MeshId`].
    pub fn new(meshes: &'a [Asset<MeshData>]) -> MeshCache<'a> {
        MeshCache { meshes, prepared: HashMap::new(), warnings: Vec::new() }
    }

    /// The meshes prepared so far.
    pub fn prepared(&self) -> impl Iterator<Item = &TriangleMesh> {
        self.prepared.values().map(Arc::as_ref)
    }

    /// The mesh an object shows.
    pub fn get(&mut self, desc: &MeshDesc) -> Result<Arc<TriangleMesh>, SceneError> {
        let Some(asset) = self.meshes.get(desc.mesh.index()) else {
            let message =
                format!("an object names mesh {}, but the scene has {}", desc.mesh.0, self.meshes.len());
            return Err(SceneError::new(ErrorCode::Mesh, message));
        };
        let smooth = desc.smooth.unwrap_or(!asset.data.normals.is_empty());
        if let Some(mesh) = self.prepared.get(&(desc.mesh, smooth)) {
            return Ok(Arc::clone(mesh));
        }
        let (mesh, left_out) = TriangleMesh::build(&asset.data, smooth)?;
        let name = match asset.uri.as_str() {
            "" => "a mesh".to_owned(),
            uri => format!("the mesh \"{}\"", crate::scene::error::escape(uri)),
        };
        // Once per mesh, not once for each way it is shaded.
        if !self.prepared.contains_key(&(desc.mesh, !smooth)) {
            for (count, why) in
                [(left_out.non_finite, "with a vertex that is not finite"), (left_out.flat, "without area")]
            {
                if count > 0 {
                    self.warnings.push(format!("{count} triangles {why} left out of {name}"));
                }
            }
            if mesh.triangle_count() == 0 {
                self.warnings.push(format!("{name} has no triangles to show"));
            }
        }
        let mesh = Arc::new(mesh);
        self.prepared.insert((desc.mesh, smooth), Arc::clone(&mesh));
        Ok(mesh)
    }
}
