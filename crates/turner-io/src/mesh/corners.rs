//! Converts corners with separate indices of position, (u, v) and normal into vertices: one per distinct combination.

use std::collections::HashMap;

use turner::schema::MeshData;

use super::MeshError;
use super::error::{push, reserve};

/// Index of a missing (u, v) or normal.
const NONE: u32 = u32::MAX;
/// Most vertices of one position that are searched linearly; further ones are in a hash map.
const CHAIN: u32 = 16;

/// Attribute values, by index.
#[derive(Debug, Default)]
pub(super) struct Attributes {
    pub(super) positions: Vec<[f32; 3]>,
    /// As many as positions, or empty.
    pub(super) colors: Vec<[f32; 4]>,
    pub(super) uvs: Vec<[f32; 2]>,
    pub(super) normals: Vec<[f32; 3]>,
}

/// Triangles as corner indices: of positions, and of (u, v) and normals (as many triangles, or empty).
#[derive(Debug, Default)]
pub(super) struct Corners {
    pub(super) positions: Vec<[u32; 3]>,
    pub(super) uvs: Vec<[u32; 3]>,
    pub(super) normals: Vec<[u32; 3]>,
}

/// Creates one vertex per distinct corner. All indices must be valid. Unreferenced positions may be dropped.
pub(super) fn unify(attributes: Attributes, corners: Corners, name: &str) -> Result<MeshData, MeshError> {
    let Attributes { positions, colors, uvs, normals } = attributes;
    let count = positions.len();
    // Many programs write all attributes in the same order: then positions are already vertices.
    let same = |list: &[[u32; 3]], len: usize| list.is_empty() || len == count && list == corners.positions;
    if same(&corners.uvs, uvs.len()) && same(&corners.normals, normals.len()) {
        let uvs = if corners.uvs.is_empty() { Vec::new() } else { uvs };
        let normals = if corners.normals.is_empty() { Vec::new() } else { normals };
        return Ok(MeshData {
            positions,
            colors,
            uvs,
            normals,
            triangles: corners.positions,
            ..MeshData::default()
        });
    }
    let Corners { positions: mut triangles, uvs: uv_corners, normals: normal_corners } = corners;
    let mut table = Table { first: Vec::new(), vertices: Vec::new(), map: HashMap::new(), name };
    reserve(&mut table.first, count, name)?;
    table.first.resize(count, NONE);
    // Vertex indices replace position indices in place.
    for (i, triangle) in triangles.iter_mut().enumerate() {
        let (uv, normal) = (uv_corners.get(i), normal_corners.get(i));
        for (k, slot) in triangle.iter_mut().enumerate() {
            *slot = table.vertex(*slot, uv.map_or(0, |t| t[k]), normal.map_or(0, |t| t[k]))?;
        }
    }
    let vertices = table.vertices;
    let (has_uvs, has_normals) = (!uv_corners.is_empty(), !normal_corners.is_empty());
    drop((uv_corners, normal_corners, table.first, table.map));
    let mut mesh = MeshData { triangles, ..MeshData::default() };
    fill(&mut mesh.positions, &vertices, |v| positions[v.corner[0] as usize], name)?;
    drop(positions);
    if !colors.is_empty() {
        fill(&mut mesh.colors, &vertices, |v| colors[v.corner[0] as usize], name)?;
    }
    if has_uvs {
        fill(&mut mesh.uvs, &vertices, |v| uvs[v.corner[1] as usize], name)?;
    }
    if has_normals {
        fill(&mut mesh.normals, &vertices, |v| normals[v.corner[2] as usize], name)?;
    }
    Ok(mesh)
}

fn fill<T>(
    out: &mut Vec<T>,
    vertices: &[Vertex],
    value: impl Fn(&Vertex) -> T,
    name: &str,
) -> Result<(), MeshError> {
    reserve(out, vertices.len(), name)?;
    out.extend(vertices.iter().map(value));
    Ok(())
}

struct Vertex {
    corner: [u32; 3],
    /// The next vertex with the same position.
    next: u32,
}

/// Vertices by corner: a linked list per position, with a hash map for long lists.
struct Table<'a> {
    first: Vec<u32>,
    vertices: Vec<Vertex>,
    map: HashMap<[u32; 3], u32>,
    name: &'a str,
}

impl Table<'_> {
    #[inline]
    fn vertex(&mut self, position: u32, uv: u32, normal: u32) -> Result<u32, MeshError> {
        let corner = [position, uv, normal];
        let start = self.first[position as usize];
        let (mut at, mut steps) = (start, 0);
        while at != NONE && steps < CHAIN {
            let vertex = &self.vertices[at as usize];
            if vertex.corner == corner {
                return Ok(at);
            }
            (at, steps) = (vertex.next, steps + 1);
        }
        let new = self.vertices.len() as u32;
        if steps == CHAIN {
            if let Some(&known) = self.map.get(&corner) {
                return Ok(known);
            }
            self.map.insert(corner, new);
            push(&mut self.vertices, Vertex { corner, next: NONE }, self.name)?;
        } else {
            push(&mut self.vertices, Vertex { corner, next: start }, self.name)?;
            self.first[position as usize] = new;
        }
        Ok(new)
    }
}
