//! The control mesh: faces, and the neighbours of each of their edges.

use super::{FOR_EVER, Subdivision, SubdivisionScheme};
use crate::math::DVec3;
use crate::math::elementary::cos;
use crate::schema::{ErrorCode, MeshData, SceneError};

/// No half-edge.
pub(super) const NONE: u32 = u32::MAX;

/// A surface of polygons. A half-edge is one side of an edge: it belongs to a face, starts at a vertex and runs
/// counter-clockwise to the next half-edge of the face. It is also the corner of the face at that vertex.
#[derive(Clone, Debug, Default)]
pub(super) struct Surface {
    pub(super) points: Vec<DVec3>,
    /// The sharpness of each vertex, infinite for those that stay in place.
    pub(super) corners: Vec<f32>,
    /// The vertex where each half-edge starts.
    pub(super) origin: Vec<u32>,
    /// The other side of the edge; [`NONE`] at borders.
    pub(super) twin: Vec<u32>,
    /// The sharpness of the edge; infinite at borders.
    pub(super) sharp: Vec<f32>,
    /// The first half-edge of each face, and the number of half-edges.
    pub(super) starts: Vec<u32>,
    /// The face of each half-edge.
    pub(super) face: Vec<u32>,
    /// Values of each corner of a face: all (u, v), then colours.
    pub(super) values: Vec<f32>,
    /// How many values a corner has.
    pub(super) width: usize,
    /// The material of each face, or empty.
    pub(super) materials: Vec<u16>,
}

impl Surface {
    /// The control mesh of a mesh whose lists are consistent, and the number of faces that were omitted.
    ///
    /// Errors: creases that are no edges.
    pub(super) fn new(data: &MeshData, by: &Subdivision) -> Result<(Surface, usize), SceneError> {
        let vertices = vertices(data, by.join);
        let mut surface = Surface { starts: vec![0], ..Surface::default() };
        surface.width = 2 * usize::from(!data.uvs.is_empty())
            + 2 * data.more_uvs.len()
            + 4 * usize::from(!data.colors.is_empty());
        surface.points = vec![DVec3::ZERO; data.positions.len()];
        for (v, p) in vertices.iter().zip(&data.positions) {
            surface.points[*v as usize] = DVec3::from(p.map(f64::from));
        }
        let (mut omitted, mut polygon, mut sorted) = (0, Vec::new(), Vec::new());
        let mut add = |corners: &[u32], triangle: usize| {
            polygon.clear();
            polygon.extend_from_slice(corners);
            // Edges without length are no edges.
            polygon.dedup_by_key(|c| vertices[*c as usize]);
            while polygon.len() > 1
                && vertices[polygon[0] as usize] == vertices[polygon[polygon.len() - 1] as usize]
            {
                polygon.pop();
            }
            sorted.clear();
            sorted.extend(polygon.iter().map(|c| vertices[*c as usize]));
            sorted.sort_unstable();
            let finite = polygon.iter().all(|c| data.positions[*c as usize].iter().all(|x| x.is_finite()));
            if polygon.len() < 3 || !finite || sorted.windows(2).any(|pair| pair[0] == pair[1]) {
                omitted += 1;
                return;
            }
            surface.add_face(&polygon, &vertices, data);
            if let Some(material) = data.face_materials.get(triangle) {
                surface.materials.push(*material);
            }
        };
        let mut at = 0;
        for triangles in data.polygon_triangles() {
            match crate::schema::boundary(triangles) {
                Some(corners) if by.scheme == SubdivisionScheme::CatmullClark => add(&corners, at),
                _ => triangles.iter().enumerate().for_each(|(i, t)| add(t, at + i)),
            }
            at += triangles.len();
        }
        surface.corners = vec![0.0; surface.points.len()];
        surface.join_edges(&vertices, by)?;
        surface.fix_corners(by.keep_corners);
        Ok((surface, omitted))
    }

    fn add_face(&mut self, polygon: &[u32], vertices: &[u32], data: &MeshData) {
        let face = self.starts.len() as u32 - 1;
        for &c in polygon {
            let c = c as usize;
            self.origin.push(vertices[c]);
            self.face.push(face);
            let uvs = data.uvs.get(c).into_iter().chain(data.more_uvs.iter().filter_map(|set| set.get(c)));
            self.values.extend(uvs.flatten());
            self.values.extend(data.colors.get(c).into_iter().flatten());
        }
        self.starts.push(self.origin.len() as u32);
    }

    pub(super) fn next(&self, h: u32) -> u32 {
        let face = self.face[h as usize] as usize;
        if h + 1 == self.starts[face + 1] { self.starts[face] } else { h + 1 }
    }

    pub(super) fn previous(&self, h: u32) -> u32 {
        let face = self.face[h as usize] as usize;
        if h == self.starts[face] { self.starts[face + 1] - 1 } else { h - 1 }
    }

    /// The vertex where a half-edge ends.
    pub(super) fn end(&self, h: u32) -> u32 {
        self.origin[self.next(h) as usize]
    }

    pub(super) fn half_edges(&self) -> u32 {
        self.origin.len() as u32
    }

    /// The normal of a face with twice its area as length (Newell's method).
    fn normal(&self, face: u32) -> DVec3 {
        let corners = self.starts[face as usize]..self.starts[face as usize + 1];
        let origin = self.points[self.origin[corners.start as usize] as usize];
        corners.fold(DVec3::ZERO, |sum, h| {
            let [a, b] = [h, self.next(h)].map(|h| self.points[self.origin[h as usize] as usize] - origin);
            sum + a.cross(b)
        })
    }

    /// Finds the other side of each edge, and the sharpness. An edge of more than two faces, or of two that are not
    /// oriented alike, is a border of each.
    fn join_edges(&mut self, vertices: &[u32], by: &Subdivision) -> Result<(), SceneError> {
        let count = self.half_edges();
        self.twin = vec![NONE; count as usize];
        self.sharp = vec![f32::INFINITY; count as usize];
        let mut edges: Vec<(u32, u32, u32)> = Vec::with_capacity(count as usize);
        for h in 0..count {
            let (a, b) = (self.origin[h as usize], self.end(h));
            edges.push((a.min(b), a.max(b), h));
        }
        edges.sort_unstable();
        let creases = creases(&by.creases, vertices, &mut self.corners)?;
        let cosine = by.crease_angle.map(|angle| cos(angle.to_radians()));
        let mut found = vec![false; creases.len()];
        for same in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let crease = creases.binary_search_by_key(&(same[0].0, same[0].1), |c| (c.0, c.1)).ok();
            if let Some(i) = crease {
                found[i] = true;
            }
            let &[(_, _, g), (_, _, h)] = same else { continue };
            if self.origin[g as usize] == self.origin[h as usize] {
                continue;
            }
            (self.twin[g as usize], self.twin[h as usize]) = (h, g);
            let mut sharp = crease.map_or(0.0, |i| creases[i].2);
            let [m, n] = [g, h].map(|h| self.normal(self.face[h as usize]).normalize_or_zero());
            if cosine.is_some_and(|cosine| m.dot(n) < cosine) {
                sharp = f32::INFINITY;
            }
            (self.sharp[g as usize], self.sharp[h as usize]) = (sharp, sharp);
        }
        match found.iter().position(|found| !found) {
            Some(i) => {
                let message = format!(
                    "`creases` of a mesh names vertices {} and {}, which no edge joins",
                    creases[i].3[0], creases[i].3[1]
                );
                Err(SceneError::new(ErrorCode::Mesh, message).help("vertices are counted from 0"))
            }
            None => Ok(()),
        }
    }

    /// Lets vertices stay in place that join parts of the surface which share no edge there; with `keep_corners`, also
    /// those of only one face.
    fn fix_corners(&mut self, keep_corners: bool) {
        let mut faces = vec![0u32; self.points.len()];
        self.origin.iter().for_each(|v| faces[*v as usize] += 1);
        let (mut seen, mut ring) = (vec![false; self.points.len()], Vec::new());
        for h in 0..self.half_edges() {
            let v = self.origin[h as usize] as usize;
            if std::mem::replace(&mut seen[v], true) {
                continue;
            }
            self.fan(h, |_| false, &mut ring);
            if ring.len() != faces[v] as usize || keep_corners && faces[v] == 1 {
                self.corners[v] = f32::INFINITY;
            }
        }
    }

    /// Collects in `ring` the half-edges around the vertex of `h`, counter-clockwise, up to a border or an edge for which
    /// `cut` holds on either side. Returns whether they go all the way round.
    pub(super) fn fan(&self, h: u32, cut: impl Fn(u32) -> bool, ring: &mut Vec<u32>) -> bool {
        ring.clear();
        let mut first = h;
        loop {
            // Clockwise, across the edge that starts here.
            let twin = self.twin[first as usize];
            if twin == NONE || cut(first) {
                break;
            }
            first = self.next(twin);
            if first == h {
                break;
            }
        }
        let mut at = first;
        loop {
            ring.push(at);
            let incoming = self.previous(at);
            let twin = self.twin[incoming as usize];
            if twin == NONE || cut(incoming) {
                return false;
            }
            if twin == first {
                return true;
            }
            at = twin;
        }
    }
}

/// The vertex of each vertex of the file: with `join`, the first one at the same position.
fn vertices(data: &MeshData, join: bool) -> Vec<u32> {
    let mut out: Vec<u32> = (0..data.positions.len() as u32).collect();
    if join {
        // Adding 0 turns −0 into 0.
        let key = |i: u32| data.positions[i as usize].map(|v| (v + 0.0).to_bits());
        let mut order = out.clone();
        order.sort_unstable_by_key(|i| (key(*i), *i));
        for same in order.chunk_by(|a, b| key(*a) == key(*b)) {
            same.iter().for_each(|i| out[*i as usize] = same[0]);
        }
    }
    out
}

/// A crease: its vertices, the lower number first, its sharpness, and the vertices as given.
type Crease = (u32, u32, f32, [f64; 2]);

/// The creases, sorted by their vertices; sharp vertices go to `corners`.
fn creases(list: &[[f64; 3]], vertices: &[u32], corners: &mut [f32]) -> Result<Vec<Crease>, SceneError> {
    let mut out = Vec::with_capacity(list.len());
    for &[a, b, sharpness] in list {
        let vertex = |v: f64| {
            let known = v >= 0.0 && v.floor() == v && v < vertices.len() as f64;
            let message =
                || format!("`creases` of a mesh names vertex {v}, but it has {} vertices", vertices.len());
            known.then(|| vertices[v as usize]).ok_or_else(|| {
                SceneError::new(ErrorCode::Mesh, message()).help("vertices are counted from 0")
            })
        };
        if !(sharpness >= 0.0) {
            let message = format!("the sharpness {sharpness} of a crease; expected 0 or more");
            return Err(SceneError::new(ErrorCode::OutOfRange, message).help("10 is sharp for ever"));
        }
        let (from, to) = (vertex(a)?, vertex(b)?);
        let sharp = if sharpness as f32 >= FOR_EVER { f32::INFINITY } else { sharpness as f32 };
        if from == to {
            corners[from as usize] = sharp;
        } else {
            out.push((from.min(to), from.max(to), sharp, [a, b]));
        }
    }
    out.sort_by_key(|c| (c.0, c.1));
    // Of several for one edge, the last one counts.
    out.dedup_by(|next, kept| {
        let same = (next.0, next.1) == (kept.0, kept.1);
        if same {
            kept.2 = next.2;
        }
        same
    });
    Ok(out)
}
