//! Tangents by MikkTSpace, for meshes that have a normal map but no tangents (glTF 2.0 §3.7.2.1).
//!
//! A normal map stores normals relative to the tangent frame (T, B, N) of the surface, with T = ∂p/∂u. Baker and
//! renderer must compute the same frame, so glTF asks for Mikkelsen's algorithm (Mikkelsen 2008, "Simulation of
//! Wrinkled Surfaces Revisited"):
//!
//! 1. For each triangle, T and its handedness follow from its positions and UVs.
//! 2. At each vertex, the triangles with the same handedness that share an edge form a group; their T is projected
//!    into the tangent plane and averaged with the corner angles as weights.
//! 3. Corners of different groups get different tangents, so a vertex on a UV mirror seam is split.
//!
//! The fourth component is the handedness: B = sign · N × T.
//!
//! The crate bevy_mikktspace, in safe Rust, implements the algorithm; the arc cosine is ours, so that the result has
//! the same bits on every machine.

use bevy_mikktspace::{Geometry, Ops, TangentSpace, generate_tangents};
use turner::math::DVec3;
use turner::math::elementary::acos;
use turner::schema::MeshData;

use super::budget::Budget;
use super::fault::Outcome;

struct Elementary;

impl Ops for Elementary {
    fn sqrt(x: f32) -> f32 {
        x.sqrt()
    }

    fn acos(x: f32) -> f32 {
        acos(f64::from(x)) as f32
    }
}

struct Faces<'a> {
    mesh: &'a MeshData,
    uvs: &'a [[f32; 2]],
    /// One per triangle corner.
    tangents: Vec<[f32; 4]>,
}

/// Replaces non-finite values, which would spread to other faces.
fn finite<const N: usize>(v: [f32; N]) -> [f32; N] {
    v.map(|x| if x.is_finite() { x } else { 0.0 })
}

impl Faces<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.mesh.triangles[face][corner] as usize
    }
}

impl Geometry<Elementary> for Faces<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.triangles.len()
    }
    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }
    fn position(&self, face: usize, vert: usize) -> [f32; 3] {
        finite(self.mesh.positions[self.vertex(face, vert)])
    }
    fn normal(&self, face: usize, vert: usize) -> [f32; 3] {
        finite(self.mesh.normals[self.vertex(face, vert)])
    }
    fn tex_coord(&self, face: usize, vert: usize) -> [f32; 2] {
        finite(self.uvs[self.vertex(face, vert)])
    }
    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, vert: usize) {
        // Zero means that the surface has no tangent frame there.
        self.tangents[3 * face + vert] = space.map_or([0.0; 4], |space| space.tangent_encoded());
    }
}

/// Gives each triangle its own vertices with the face normal: meshes without normals are flat-shaded (§3.7.2.1).
pub(super) fn flatten(mesh: &mut MeshData, budget: &Budget, pointer: &str) -> Outcome<()> {
    let corners: Vec<u32> = mesh.triangles.as_flattened().to_vec();
    budget.take(corners.len(), vertex_size(mesh), pointer)?;
    take_vertices(mesh, &corners);
    let mut normals = Vec::with_capacity(corners.len());
    for (i, triangle) in mesh.triangles.iter_mut().enumerate() {
        *triangle = [0, 1, 2].map(|k| 3 * i as u32 + k);
        let [a, b, c] = triangle.map(|v| DVec3::from(mesh.positions[v as usize].map(f64::from)));
        let n = (b - a).cross(c - a).normalize_or_zero().as_vec3().to_array();
        normals.extend([n; 3]);
    }
    mesh.normals = normals;
    Ok(())
}

/// Bytes of a vertex, as an estimate for the budget.
pub(super) fn vertex_size(mesh: &MeshData) -> usize {
    64 + 8 * mesh.more_uvs.len()
}

/// Replaces the vertices by copies of those listed.
pub(super) fn take_vertices(mesh: &mut MeshData, list: &[u32]) {
    fn take<T: Copy>(values: &mut Vec<T>, list: &[u32]) {
        if !values.is_empty() {
            *values = list.iter().map(|v| values[*v as usize]).collect();
        }
    }
    take(&mut mesh.positions, list);
    take(&mut mesh.normals, list);
    take(&mut mesh.uvs, list);
    take(&mut mesh.tangents, list);
    take(&mut mesh.colors, list);
    mesh.more_uvs.iter_mut().for_each(|set| take(set, list));
}

/// Computes tangents from one UV set; does nothing without normals or that UV set. Vertices whose corners have
/// different tangents are split.
pub(super) fn generate(mesh: &mut MeshData, uv_set: usize, budget: &Budget, pointer: &str) -> Outcome<()> {
    let uvs = match uv_set.checked_sub(1) {
        None => Some(&mesh.uvs),
        Some(other) => mesh.more_uvs.get(other),
    };
    let Some(uvs) = uvs.filter(|uvs| !uvs.is_empty() && !mesh.normals.is_empty()) else { return Ok(()) };
    let corners = 3 * mesh.triangles.len();
    // The algorithm temporarily takes about 200 bytes per corner.
    budget.take(corners, 16, pointer)?;
    let mut faces = Faces { mesh, uvs, tangents: vec![[0.0; 4]; corners] };
    // The error type has no values at present.
    if generate_tangents(&mut faces).is_err() {
        return Ok(());
    }
    let of_corners = faces.tangents;

    // The vertex keeps the tangent of its first corner; each other tangent adds a copy of the vertex. `next`
    // links the copies of a vertex.
    const NONE: u32 = u32::MAX;
    let count = mesh.positions.len();
    let mut tangents: Vec<[f32; 4]> = vec![[0.0; 4]; count];
    let mut seen = vec![false; count];
    let mut next: Vec<u32> = vec![NONE; count];
    let mut copies: Vec<u32> = Vec::new();
    for (corner, tangent) in mesh.triangles.as_flattened_mut().iter_mut().zip(of_corners) {
        let original = *corner;
        let mut at = original;
        if !std::mem::replace(&mut seen[at as usize], true) {
            tangents[at as usize] = tangent;
            continue;
        }
        while tangents[at as usize] != tangent && next[at as usize] != NONE {
            at = next[at as usize];
        }
        if tangents[at as usize] != tangent {
            let copy = tangents.len() as u32;
            next[at as usize] = copy;
            tangents.push(tangent);
            next.push(NONE);
            copies.push(original);
            at = copy;
        }
        *corner = at;
    }
    if !copies.is_empty() {
        budget.take(copies.len(), vertex_size(mesh), pointer)?;
        let list: Vec<u32> = (0..count as u32).chain(copies).collect();
        take_vertices(mesh, &list);
    }
    mesh.tangents = tangents;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square in the plane z = 0; seen from +z, u points right and v up.
    fn square() -> MeshData {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        MeshData {
            positions: corners.map(|[x, y]| [x, y, 0.0]).to_vec(),
            normals: vec![[0.0, 0.0, 1.0]; 4],
            uvs: corners.to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..MeshData::default()
        }
    }

    #[test]
    fn tangents_lead_along_u_and_the_sign_tells_mirrored_pictures() {
        let budget = Budget::of_file(0);
        let mut mesh = square();
        generate(&mut mesh, 0, &budget, "").unwrap();
        assert_eq!(mesh.tangents, vec![[1.0, 0.0, 0.0, 1.0]; 4]);
        let mut mesh = square();
        mesh.uvs.iter_mut().for_each(|uv| uv[0] = -uv[0]);
        generate(&mut mesh, 0, &budget, "").unwrap();
        assert_eq!(mesh.tangents, vec![[-1.0, 0.0, 0.0, -1.0]; 4]);
    }

    #[test]
    fn a_mirror_seam_splits_its_vertices() {
        let mut mesh = square();
        // The second triangle is mirrored in UV space.
        mesh.uvs[3] = [1.0, 0.0];
        generate(&mut mesh, 0, &Budget::of_file(0), "").unwrap();
        assert_eq!(mesh.positions.len(), 6);
        mesh.check().unwrap();
        let signs: Vec<f32> = mesh.triangles.iter().map(|t| mesh.tangents[t[0] as usize][3]).collect();
        assert_eq!(signs, [1.0, -1.0]);
    }

    #[test]
    fn broken_numbers_and_faces_do_no_harm() {
        let mut mesh = square();
        mesh.positions[1] = [f32::NAN, f32::INFINITY, 0.0];
        mesh.uvs[2] = [f32::NAN; 2];
        mesh.normals[0] = [f32::NEG_INFINITY; 3];
        mesh.triangles.extend([[0, 0, 0], [1, 1, 2], [3, 2, 3]]);
        generate(&mut mesh, 0, &Budget::of_file(0), "").unwrap();
        mesh.check().unwrap();
        assert!(mesh.tangents.iter().flatten().all(|v| v.is_finite()));
        let mut empty = MeshData { triangles: Vec::new(), ..square() };
        generate(&mut empty, 0, &Budget::of_file(0), "").unwrap();
        let mut without = MeshData { normals: Vec::new(), ..square() };
        generate(&mut without, 0, &Budget::of_file(0), "").unwrap();
        assert!(without.tangents.is_empty());
    }

    #[test]
    fn flat_faces_get_their_own_vertices() {
        let mut mesh = MeshData { normals: Vec::new(), ..square() };
        flatten(&mut mesh, &Budget::of_file(0), "").unwrap();
        assert_eq!((mesh.positions.len(), mesh.normals.len()), (6, 6));
        assert_eq!(mesh.normals[5], [0.0, 0.0, 1.0]);
        assert_eq!(mesh.uvs[5], [0.0, 1.0]);
        mesh.check().unwrap();
    }
}
