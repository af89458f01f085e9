//! One level of subdivision: new vertices, and the faces between them.
//!
//! ```text
//!   Catmull–Clark                              Loop
//!   new vertex of a face: mean of its corners
//!   of an edge: mean of its ends and the       1/8                 β     β
//!   new vertices of its two faces              / \                  \   /
//!   of a vertex with n neighbours e:        3/8 ● 3/8           β ── 1−nβ ── β
//!   (n−2)/n v + Σe/n² + Σf/n²                  \ /                  /   \
//!                                              1/8                 β     β
//!   sharp edges of both: edge 1/2 ● 1/2, vertex 1/8 ─ 3/4 ─ 1/8; vertices of three and more sharp edges stay
//! ```

use super::control::{NONE, Surface};
use super::masks::{Around, child, loop_beta};
use crate::math::DVec3;

impl Surface {
    /// Numbers the edges; returns the number of each half-edge, and a half-edge of each edge.
    fn edges(&self) -> (Vec<u32>, Vec<u32>) {
        let (mut number, mut first) = (vec![0; self.origin.len()], Vec::new());
        for h in 0..self.half_edges() {
            let twin = self.twin[h as usize];
            if twin == NONE || h < twin {
                number[h as usize] = first.len() as u32;
                first.push(h);
            } else {
                number[h as usize] = number[twin as usize];
            }
        }
        (number, first)
    }

    fn ends(&self, h: u32) -> [DVec3; 2] {
        [self.origin[h as usize], self.end(h)].map(|v| self.points[v as usize])
    }

    /// The edges and faces that meet at each vertex.
    fn around(&self, edges: &[u32]) -> Vec<Around> {
        let mut all = vec![Around::default(); self.points.len()];
        for &h in edges {
            let (a, b) = (self.origin[h as usize], self.end(h));
            for (v, other) in [(a, b), (b, a)] {
                all[v as usize].add_edge(self.points[other as usize], self.sharp[h as usize]);
            }
        }
        all
    }

    /// The mean of the values of corners.
    fn mix(&self, corners: impl ExactSizeIterator<Item = u32> + Clone, out: &mut Vec<f32>) {
        let count = corners.len() as f32;
        for k in 0..self.width {
            // A sum of two has the same bits from both sides of an edge.
            let sum: f32 = corners.clone().map(|h| self.values[h as usize * self.width + k]).sum();
            out.push(sum / count);
        }
    }

    /// An empty surface of the next level with `faces` faces of `corners` corners.
    fn next_level(&self, faces: usize, corners: usize, vertices: usize) -> Surface {
        let count = faces * corners;
        Surface {
            points: Vec::with_capacity(vertices),
            corners: Vec::with_capacity(vertices),
            origin: Vec::with_capacity(count),
            twin: Vec::with_capacity(count),
            sharp: Vec::with_capacity(count),
            starts: (0..=faces as u32).map(|face| face * corners as u32).collect(),
            face: (0..count as u32).map(|h| h / corners as u32).collect(),
            values: Vec::with_capacity(count * self.width),
            width: self.width,
            materials: Vec::with_capacity(if self.materials.is_empty() { 0 } else { faces }),
        }
    }

    /// One level of Catmull–Clark. A corner h becomes the quadrilateral of its vertex, the new vertex of edge h, that of
    /// the face, and that of the edge before.
    pub(super) fn catmull_clark(&self) -> Surface {
        let (number, edges) = self.edges();
        let (vertices, faces) = (self.points.len(), self.starts.len() - 1);
        let total = vertices + edges.len() + faces;
        let mut out = self.next_level(self.origin.len(), 4, total);
        let corners = |face: usize| self.starts[face]..self.starts[face + 1];
        let centers: Vec<DVec3> = (0..faces)
            .map(|face| {
                let sum: DVec3 = corners(face).map(|h| self.points[self.origin[h as usize] as usize]).sum();
                sum / f64::from(self.starts[face + 1] - self.starts[face])
            })
            .collect();
        let mut around = self.around(&edges);
        for h in 0..self.origin.len() {
            around[self.origin[h] as usize].add_face(centers[self.face[h] as usize]);
        }
        for ((p, around), corner) in self.points.iter().zip(&around).zip(&self.corners) {
            out.points.push(around.moved(*p, *corner, || around.catmull_clark(*p)));
            out.corners.push(child(*corner));
        }
        for &h in &edges {
            let [a, b] = self.ends(h);
            let (middle, sharp) = (0.5 * (a + b), f64::from(self.sharp[h as usize]));
            let twin = self.twin[h as usize];
            let smooth = || {
                let [f, g] = [h, twin].map(|h| centers[self.face[h as usize] as usize]);
                0.25 * ((a + b) + (f + g))
            };
            out.points.push(if twin == NONE || sharp >= 1.0 { middle } else { smooth().lerp(middle, sharp) });
            out.corners.push(0.0);
        }
        out.points.extend(&centers);
        out.corners.resize(total, 0.0);
        let edge = |h: u32| vertices as u32 + number[h as usize];
        let mut center_values = Vec::new();
        for h in 0..self.half_edges() {
            let (next, previous) = (self.next(h), self.previous(h));
            let face = self.face[h as usize];
            if h == self.starts[face as usize] {
                center_values.clear();
                self.mix(corners(face as usize), &mut center_values);
            }
            let center = (vertices + edges.len()) as u32 + face;
            out.origin.extend([self.origin[h as usize], edge(h), center, edge(previous)]);
            let [ahead, behind] = [h, previous].map(|h| self.twin[h as usize]);
            out.twin.extend([
                if ahead == NONE { NONE } else { 4 * self.next(ahead) + 3 },
                4 * next + 2,
                4 * previous + 1,
                if behind == NONE { NONE } else { 4 * behind },
            ]);
            let [s, t] = [h, previous].map(|h| child(self.sharp[h as usize]));
            out.sharp.extend([s, 0.0, 0.0, t]);
            self.mix([h].into_iter(), &mut out.values);
            self.mix([h, next].into_iter(), &mut out.values);
            out.values.extend(&center_values);
            self.mix([previous, h].into_iter(), &mut out.values);
            out.materials.extend(self.materials.get(face as usize));
        }
        out
    }

    /// One level of Loop: a triangle becomes one at each corner and one in the middle.
    pub(super) fn of_loop(&self) -> Surface {
        let (number, edges) = self.edges();
        let (vertices, faces) = (self.points.len(), self.starts.len() - 1);
        let mut out = self.next_level(4 * faces, 3, vertices + edges.len());
        let around = self.around(&edges);
        for ((p, around), corner) in self.points.iter().zip(&around).zip(&self.corners) {
            out.points.push(around.moved(*p, *corner, || {
                let n = f64::from(around.edges);
                let beta = loop_beta(around.edges);
                *p * (1.0 - n * beta) + around.ends * beta
            }));
            out.corners.push(child(*corner));
        }
        for &h in &edges {
            let [a, b] = self.ends(h);
            let (middle, sharp) = (0.5 * (a + b), f64::from(self.sharp[h as usize]));
            let twin = self.twin[h as usize];
            let smooth = || {
                let [c, d] = [h, twin].map(|h| self.points[self.origin[self.previous(h) as usize] as usize]);
                0.375 * (a + b) + 0.125 * (c + d)
            };
            out.points.push(if twin == NONE || sharp >= 1.0 { middle } else { smooth().lerp(middle, sharp) });
            out.corners.push(0.0);
        }
        let edge = |h: u32| vertices as u32 + number[h as usize];
        // The triangle at corner h is number h + h / 3 of the next level: three corners and the middle per triangle.
        let at_corner = |h: u32| 3 * (h + h / 3);
        for h in (0..self.half_edges()).step_by(3) {
            let triangle = [h, h + 1, h + 2];
            let middle = 4 * h + 9;
            for k in 0..3 {
                let (h, next, previous) = (triangle[k], triangle[(k + 1) % 3], triangle[(k + 2) % 3]);
                out.origin.extend([self.origin[h as usize], edge(h), edge(previous)]);
                let [ahead, behind] = [h, previous].map(|h| self.twin[h as usize]);
                out.twin.extend([
                    if ahead == NONE { NONE } else { at_corner(self.next(ahead)) + 2 },
                    middle + (k as u32 + 2) % 3,
                    if behind == NONE { NONE } else { at_corner(behind) },
                ]);
                let [s, t] = [h, previous].map(|h| child(self.sharp[h as usize]));
                out.sharp.extend([s, 0.0, t]);
                self.mix([h].into_iter(), &mut out.values);
                self.mix([h, next].into_iter(), &mut out.values);
                self.mix([previous, h].into_iter(), &mut out.values);
            }
            for k in 0..3 {
                let (h, next) = (triangle[k], triangle[(k + 1) % 3]);
                out.origin.push(edge(h));
                out.twin.push(at_corner(next) + 1);
                out.sharp.push(0.0);
                self.mix([h, next].into_iter(), &mut out.values);
            }
            if let Some(material) = self.materials.get(self.face[h as usize] as usize) {
                out.materials.extend([*material; 4]);
            }
        }
        out
    }
}
