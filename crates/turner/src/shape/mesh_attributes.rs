//! What a mesh stores per vertex, interpolated at a hit, and per triangle.

use super::ShapeHit;
use super::triangle_mesh::{TriangleMesh, wide};
use crate::math::{DVec2, DVec3};

impl TriangleMesh {
    /// An interpolated vertex attribute; `None` if the mesh lacks it.
    fn interpolate<const N: usize>(&self, hit: &ShapeHit, values: &[[f32; N]]) -> Option<[f64; N]> {
        if values.is_empty() {
            return None;
        }
        let [a, b, c] = self.data.triangles[hit.part as usize].map(|i| values[i as usize].map(f64::from));
        let w = 1.0 - hit.u - hit.v;
        Some(std::array::from_fn(|i| w * a[i] + hit.u * b[i] + hit.v * c[i]))
    }

    /// The mesh's own (u, v), or the barycentric weights of the second and third vertex.
    pub fn uv(&self, hit: &ShapeHit) -> DVec2 {
        self.uv_set(hit, 0)
    }

    /// (u, v) of a set; of set 0 if there is no such set.
    pub fn uv_set(&self, hit: &ShapeHit, set: usize) -> DVec2 {
        let other = set.checked_sub(1).and_then(|i| self.data.more_uvs.get(i));
        let found = self.interpolate(hit, other.unwrap_or(&self.data.uvs));
        found.map_or(DVec2::new(hit.u, hit.v), DVec2::from)
    }

    /// The vertex colour, linear RGB and opacity, if the mesh has colours.
    pub fn color(&self, hit: &ShapeHit) -> Option<[f32; 4]> {
        self.interpolate(hit, &self.data.colors).map(|c| c.map(|x| x as f32))
    }

    /// The unit tangent along u, and the side of the bitangent (1 or -1), if the mesh has tangents.
    pub fn tangent(&self, hit: &ShapeHit) -> Option<(DVec3, f64)> {
        let [x, y, z, side] = self.interpolate(hit, &self.data.tangents)?;
        let tangent = DVec3::new(x, y, z).try_normalize()?;
        Some((tangent, if side < 0.0 { -1.0 } else { 1.0 }))
    }

    /// The directions in which u and v of a set increase, of any length; `None` where they are undefined.
    pub fn uv_directions(&self, hit: &ShapeHit, set: usize) -> Option<(DVec3, DVec3)> {
        let other = set.checked_sub(1).and_then(|i| self.data.more_uvs.get(i));
        let uvs = other.unwrap_or(&self.data.uvs);
        if uvs.is_empty() {
            return None;
        }
        let [a, b, c] =
            self.data.triangles[hit.part as usize].map(|i| DVec2::from(uvs[i as usize].map(f64::from)));
        let (b, c) = (b - a, c - a);
        let [p, q, r] = self.corners(hit.part).map(wide);
        let (q, r) = (q - p, r - p);
        let area = b.x * c.y - b.y * c.x;
        let along_u = (q * c.y - r * b.y) * area.signum();
        let along_v = (r * b.x - q * c.x) * area.signum();
        let known = area != 0.0 && along_u.is_finite() && along_v.is_finite();
        known.then_some((along_u, along_v))
    }

    /// Index of a triangle's material within the mesh; 0 if it has none.
    pub fn face_material(&self, part: u32) -> usize {
        self.data.face_materials.get(part as usize).map_or(0, |&m| usize::from(m))
    }
}
