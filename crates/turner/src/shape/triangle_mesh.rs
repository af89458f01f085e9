//! Triangle meshes ready to be traced.
//!
//! Memory: 36 bytes for the vertices and 4 for the place of each triangle, at most 68 for the tree; with vertex
//! normals or (u, v), 12 more per triangle and 12 and 8 per vertex. A faceted mesh takes at most 108 bytes per
//! triangle, a smooth one with (u, v) about 130.

use turner_bvh::{Aabb, Bvh2, Bvh2Options, Bvh4};

use super::mesh::MeshData;
use super::traversal::TraversalFrame;
use super::triangle::RayShear;
use super::{ROUNDING, ShapeHit, SurfacePoint};
use crate::math::{Bounds, DVec2, DVec3, Ray};
use crate::scene::{ErrorCode, SceneError};

/// A triangle mesh with its tree.
#[derive(Clone, Debug)]
pub struct TriangleMesh {
    bounds: Bounds,
    frame: TraversalFrame,
    tree: Bvh4,
    /// Vertices of the triangles in leaf order.
    vertices: Vec<[[f32; 3]; 3]>,
    /// For each triangle as numbered in the mesh, its place in leaf order; `u32::MAX` for those left out.
    places: Vec<u32>,
    /// Indices of the vertices, by triangle as numbered in the mesh; empty without normals and uvs.
    corners: Vec<[u32; 3]>,
    normals: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    error: f64,
}

/// Triangles that a mesh has but that cannot be shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LeftOut {
    /// With a vertex that is NaN or infinite.
    pub non_finite: usize,
    /// Without area.
    pub flat: usize,
}

fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}

/// The normal with the length of twice the area; zero or not finite for a triangle without area.
fn area_normal(v: &[[f32; 3]; 3]) -> DVec3 {
    let [a, b, c] = v.map(wide);
    (b - a).cross(c - a)
}

impl TriangleMesh {
    /// Checks the data and builds the tree. With `smooth`, normals that are missing are computed.
    pub fn build(data: &MeshData, smooth: bool) -> Result<(TriangleMesh, LeftOut), SceneError> {
        data.check()?;
        let mut left_out = LeftOut::default();
        let corners = |t: &[u32; 3]| t.map(|i| data.positions[i as usize]);
        let mut bounds = Bounds::EMPTY;
        let mut shown = |v: &[[f32; 3]; 3]| {
            if !v.iter().flatten().all(|x| x.is_finite()) {
                left_out.non_finite += 1;
                return false;
            }
            if area_normal(v).try_normalize().is_none() {
                left_out.flat += 1;
                return false;
            }
            bounds = bounds.union(&Bounds::of(v.map(wide)));
            true
        };
        let shown: Vec<bool> = data.triangles.iter().map(|t| shown(&corners(t))).collect();
        let frame = TraversalFrame::new(&bounds);
        let boxes: Vec<Aabb> = data
            .triangles
            .iter()
            .zip(&shown)
            .map(
                |(t, &shown)| {
                    if shown { frame.aabb(&Bounds::of(corners(t).map(wide))) } else { Aabb::EMPTY }
                },
            )
            .collect();
        let tree = Bvh2::build(&boxes, &Bvh2Options::default())
            .map_err(|e| SceneError::new(ErrorCode::TooLarge, e.to_string()))?;
        let tree = Bvh4::collapse(&tree);
        drop(boxes);
        let vertices = tree.order().iter().map(|&i| corners(&data.triangles[i as usize])).collect();
        let mut places = vec![u32::MAX; data.triangles.len()];
        for (place, &i) in (0..).zip(tree.order()) {
            places[i as usize] = place;
        }
        let normals = match (smooth, data.normals.is_empty()) {
            (false, _) => Vec::new(),
            (true, false) => data.normals.clone(),
            (true, true) => vertex_normals(data, &shown),
        };
        let uvs = data.uvs.clone();
        let corners = if normals.is_empty() && uvs.is_empty() { Vec::new() } else { data.triangles.clone() };
        let far = if bounds.is_empty() { 0.0 } else { bounds.min.abs().max(bounds.max.abs()).max_element() };
        let mesh = TriangleMesh {
            bounds,
            frame,
            tree,
            vertices,
            places,
            corners,
            normals,
            uvs,
            error: ROUNDING * far,
        };
        Ok((mesh, left_out))
    }

    /// The box around it; empty if it has no triangles.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Triangles that can be hit.
    pub fn triangle_count(&self) -> usize {
        self.vertices.len()
    }

    /// Bytes it takes.
    pub fn memory(&self) -> usize {
        size_of_val(self)
            + self.tree.bytes()
            + size_of_val(&self.vertices[..])
            + size_of_val(&self.places[..])
            + size_of_val(&self.corners[..])
            + size_of_val(&self.normals[..])
            + size_of_val(&self.uvs[..])
    }

    /// The nearest triangle, of several at the same t the one with the lowest number.
    pub fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let search = self.frame.ray(ray)?;
        let shear = RayShear::new(ray);
        let mut best = ShapeHit { t: ray.t_max, part: u32::MAX, u: 0.0, v: 0.0 };
        self.tree.closest(&search.ray, |range, end| {
            let range = range.start as usize..range.end as usize;
            let mut found = false;
            for (vertices, &part) in self.vertices[range.clone()].iter().zip(&self.tree.order()[range]) {
                if let Some(hit) = shear.triangle(vertices)
                    && hit.t >= ray.t_min
                    && (hit.t < best.t || hit.t == best.t && part < best.part)
                    && hit.t < f64::INFINITY
                {
                    best = ShapeHit { t: hit.t, part, u: hit.u, v: hit.v };
                    found = true;
                }
            }
            if found { search.end(best.t) } else { end }
        });
        (best.part != u32::MAX).then_some(best)
    }

    /// Whether any triangle is hit.
    pub fn occludes(&self, ray: &Ray) -> bool {
        let Some(search) = self.frame.ray(ray) else { return false };
        let shear = RayShear::new(ray);
        self.tree.any(&search.ray, |range| {
            self.vertices[range.start as usize..range.end as usize]
                .iter()
                .any(|v| shear.triangle(v).is_some_and(|hit| ray.contains(hit.t)))
        })
    }

    /// The surface at a hit: the point from its weights, the shading normal on the side of the geometric one.
    pub fn surface(&self, hit: &ShapeHit) -> SurfacePoint {
        let vertices = &self.vertices[self.places[hit.part as usize] as usize];
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let mix = |v: [DVec3; 3]| weights[0] * v[0] + weights[1] * v[1] + weights[2] * v[2];
        let ng = area_normal(vertices).normalize();
        let mut ns = ng;
        if !self.normals.is_empty() {
            let corners = self.corners[hit.part as usize].map(|i| wide(self.normals[i as usize]));
            if let Some(n) = mix(corners).try_normalize() {
                let side = n.dot(ng);
                ns = match side {
                    s if s > 0.0 => n,
                    s if s < 0.0 => -n,
                    _ => ng,
                };
            }
        }
        SurfacePoint { p: mix(vertices.map(wide)), error: self.error, ng, ns }
    }

    /// The mesh's own (u, v), or the weights of the second and third vertex.
    pub fn uv(&self, hit: &ShapeHit) -> DVec2 {
        if self.uvs.is_empty() {
            return DVec2::new(hit.u, hit.v);
        }
        let [a, b, c] =
            self.corners[hit.part as usize].map(|i| DVec2::from(self.uvs[i as usize].map(f64::from)));
        (1.0 - hit.u - hit.v) * a + hit.u * b + hit.v * c
    }
}

/// Sums of the normals around each vertex, weighted by area.
fn vertex_normals(data: &MeshData, shown: &[bool]) -> Vec<[f32; 3]> {
    let mut sums = vec![DVec3::ZERO; data.positions.len()];
    for (t, _) in data.triangles.iter().zip(shown).filter(|(_, shown)| **shown) {
        let n = area_normal(&t.map(|i| data.positions[i as usize]));
        for &i in t {
            sums[i as usize] += n;
        }
    }
    sums.into_iter().map(|n| n.normalize_or_zero().as_vec3().to_array()).collect()
}

#[cfg(test)]
#[path = "triangle_mesh_tests.rs"]
mod tests;
