//! From the last level to triangles on the limit surface.

use super::SubdivisionScheme;
use super::control::{NONE, Surface};
use super::masks::{Around, Rule, crease_normal, smooth_normal};
use crate::math::DVec3;
use crate::schema::MeshData;

/// Corners of a vertex whose (u, v) and colours are compared before a new vertex is made.
const COMPARED: usize = 16;

/// The triangles of a surface of quadrilaterals (Catmull–Clark) or triangles (Loop). `data` is the mesh that it was
/// made of.
pub(super) fn triangles(surface: &Surface, scheme: SubdivisionScheme, data: &MeshData) -> MeshData {
    let around = around(surface, scheme);
    let places = surface.points.iter().zip(&around).zip(&surface.corners);
    let points: Vec<DVec3> = places.map(|((p, a), corner)| a.limit(*p, hard(*corner), scheme)).collect();
    let mut out = Output { mesh: MeshData::default(), vertex: vec![NONE; surface.origin.len()], surface };
    out.mesh.more_uvs = vec![Vec::new(); data.more_uvs.len()];
    let mut ring = Vec::new();
    let (mut edges, mut faces) = (Vec::new(), Vec::new());
    for h in 0..surface.half_edges() {
        if out.vertex[h as usize] != NONE {
            continue;
        }
        let v = surface.origin[h as usize] as usize;
        let rule = around[v].rule(0, hard(surface.corners[v]));
        // A crease that ends here does not divide the faces.
        let closed =
            surface.fan(h, |edge| rule != Rule::Smooth && surface.sharp[edge as usize] >= 1.0, &mut ring);
        edges.clear();
        edges.extend(ring.iter().map(|c| surface.points[surface.end(*c) as usize]));
        if let (false, Some(last)) = (closed, ring.last()) {
            edges.push(surface.points[surface.origin[surface.previous(*last) as usize] as usize]);
        }
        faces.clear();
        faces.extend(ring.iter().map(|c| surface.points[opposite(surface, *c) as usize]));
        let p = surface.points[v];
        let exact = match (rule, closed) {
            (Rule::Smooth, true) => smooth_normal(&edges, &faces, scheme),
            (Rule::Crease, false) => crease_normal(p, &edges, &faces, scheme),
            (Rule::Corner, false) => (edges[0] - p).cross(edges[edges.len() - 1] - p),
            _ => DVec3::ZERO,
        };
        // Where tangents are parallel, and at reflex corners, the normals of the faces decide.
        let flat: DVec3 = ring.iter().map(|c| face_normal(surface, &points, *c)).sum();
        let normal = exact.normalize_or_zero();
        let normal = if normal.dot(flat) > 0.0 { normal } else { flat.normalize_or(DVec3::Y) };
        out.sector(&ring, points[v], normal, data);
    }
    out.faces(scheme);
    MeshData { material_names: data.material_names.clone(), ..out.mesh }
}

/// Sharpness that is left after the last level counts for ever.
fn hard(sharp: f32) -> f32 {
    if sharp >= 1.0 { f32::INFINITY } else { 0.0 }
}

/// The corner opposite corner `h` of a quadrilateral.
fn opposite(surface: &Surface, h: u32) -> u32 {
    surface.end(surface.next(h))
}

fn around(surface: &Surface, scheme: SubdivisionScheme) -> Vec<Around> {
    let mut all = vec![Around::default(); surface.points.len()];
    for h in 0..surface.half_edges() {
        let (a, b, twin) = (surface.origin[h as usize], surface.end(h), surface.twin[h as usize]);
        if twin == NONE || h < twin {
            let sharp = hard(surface.sharp[h as usize]);
            all[a as usize].add_edge(surface.points[b as usize], sharp);
            all[b as usize].add_edge(surface.points[a as usize], sharp);
        }
        if scheme == SubdivisionScheme::CatmullClark {
            all[a as usize].add_face(surface.points[opposite(surface, h) as usize]);
        }
    }
    all
}

/// The normal of the triangle at a corner.
fn face_normal(surface: &Surface, points: &[DVec3], h: u32) -> DVec3 {
    let [p, a, b] =
        [surface.origin[h as usize], surface.end(h), surface.origin[surface.previous(h) as usize]]
            .map(|v| points[v as usize]);
    (a - p).cross(b - p)
}

/// A mesh that is being made.
struct Output<'a> {
    surface: &'a Surface,
    mesh: MeshData,
    /// The vertex of the mesh at each corner.
    vertex: Vec<u32>,
}

impl Output<'_> {
    /// Makes the vertices of corners around one vertex that share a normal.
    fn sector(&mut self, ring: &[u32], p: DVec3, normal: DVec3, data: &MeshData) {
        let width = self.surface.width;
        let values = |h: u32| &self.surface.values[h as usize * width..(h as usize + 1) * width];
        let mut made: Vec<u32> = Vec::new();
        for &h in ring {
            let own = values(h);
            let same = made.iter().rev().take(COMPARED).find(|c| values(**c) == own);
            if let Some(c) = same {
                self.vertex[h as usize] = self.vertex[*c as usize];
                continue;
            }
            made.push(h);
            let mesh = &mut self.mesh;
            self.vertex[h as usize] = mesh.positions.len() as u32;
            mesh.positions.push(p.as_vec3().to_array());
            mesh.normals.push(normal.as_vec3().to_array());
            let mut rest = own;
            let mut take = || {
                let (pair, after) = rest.split_at_checked(2).unwrap_or((&[0.0; 2], &[]));
                rest = after;
                [pair[0], pair[1]]
            };
            if !data.uvs.is_empty() {
                mesh.uvs.push(take());
            }
            mesh.more_uvs.iter_mut().for_each(|set| set.push(take()));
            if !data.colors.is_empty() {
                let ([r, g], [b, a]) = (take(), take());
                mesh.colors.push([r, g, b, a]);
            }
        }
    }

    fn faces(&mut self, scheme: SubdivisionScheme) {
        let (corners, each) = match scheme {
            SubdivisionScheme::CatmullClark => (4, 2),
            SubdivisionScheme::Loop => (3, 1),
        };
        self.mesh.triangles.reserve_exact(self.vertex.len() / corners * each);
        for face in self.vertex.chunks_exact(corners) {
            for i in 0..each {
                self.mesh.triangles.push([face[0], face[i + 1], face[i + 2]]);
            }
        }
        for material in &self.surface.materials {
            self.mesh.face_materials.extend(std::iter::repeat_n(*material, each));
        }
    }
}
