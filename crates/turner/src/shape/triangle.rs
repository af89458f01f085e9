//! Watertight ray-triangle intersection (Woop, Benthin and Wald 2013, "Watertight ray/triangle intersection") in f64.
//!
//! The vertices are translated and sheared so that the ray starts at the origin and runs along z. The ray then hits
//! the triangle if the 2D origin is inside the projected triangle, which the signs of three edge functions decide:
//!
//! ```text
//!           c
//!          / \         u = c × b,  v = a × c,  w = b × a   (2D cross products)
//!         / + \        hit if no two have opposite signs
//!        a-----b       t = (u a.z + v b.z + w c.z) / (u + v + w)
//! ```
//!
//! Two triangles that share an edge compute the same value for it up to its sign, rounding is monotone, and an edge
//! belongs to both triangles: no ray passes between them. The vertices are f32 and the arithmetic is f64, so a vertex
//! near the ray's origin loses no digits.

use crate::math::Ray;

/// Precomputed values of a ray, for any number of triangles.
#[derive(Clone, Copy, Debug)]
pub struct RayShear {
    /// Permuted as `axes`.
    origin: [f64; 3],
    /// Axis permutation; the axis with the largest direction component is last.
    axes: [usize; 3],
    shear: [f64; 3],
}

/// Where a ray hits a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Parameter along the ray.
    pub t: f64,
    /// Barycentric weight of the second vertex.
    pub u: f64,
    /// Barycentric weight of the third vertex.
    pub v: f64,
}

impl RayShear {
    /// For a ray with a finite, non-zero direction.
    #[inline]
    pub fn new(ray: &Ray) -> RayShear {
        let d = ray.direction.abs();
        let z = if d.x > d.y {
            if d.x > d.z { 0 } else { 2 }
        } else if d.y > d.z {
            1
        } else {
            2
        };
        let (o, d) = (ray.origin, ray.direction);
        let (axes, origin, [x, y, z]) = match z {
            0 => ([1, 2, 0], [o.y, o.z, o.x], [d.y, d.z, d.x]),
            1 => ([2, 0, 1], [o.z, o.x, o.y], [d.z, d.x, d.y]),
            _ => ([0, 1, 2], [o.x, o.y, o.z], [d.x, d.y, d.z]),
        };
        let inv = 1.0 / z;
        RayShear { origin, axes, shear: [x * inv, y * inv, inv] }
    }

    /// Vertices permuted as `axes`, relative to the origin, sheared.
    #[inline(always)]
    fn sheared(&self, vertices: &[[f32; 3]; 3]) -> [[f64; 3]; 3] {
        let ordered = match self.axes[2] {
            0 => vertices.map(|[x, y, z]| [y, z, x]),
            1 => vertices.map(|[x, y, z]| [z, x, y]),
            _ => *vertices,
        };
        ordered.map(|v| {
            let [x, y, z] = std::array::from_fn(|i| f64::from(v[i]) - self.origin[i]);
            [x - self.shear[0] * z, y - self.shear[1] * z, z]
        })
    }

    /// The hit at any t, from either side. Edges and vertices belong to the triangle; a triangle seen exactly edge-on
    /// is missed.
    #[inline]
    pub fn triangle(&self, vertices: &[[f32; 3]; 3]) -> Option<TriangleHit> {
        let [a, b, c] = self.sheared(vertices);
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let det = u + v + w;
        if det == 0.0 {
            return None;
        }
        let inv = 1.0 / det;
        let (u, v, w) = (u * inv, v * inv, w * inv);
        let t = (u * a[2] + v * b[2] + w * c[2]) * self.shear[2];
        Some(TriangleHit { t, u: v, v: w })
    }

    /// By how much the ray misses the triangle: a bound on the distance to the point with the same barycentric
    /// weights, negative ones set to 0.
    pub fn miss(&self, vertices: &[[f32; 3]; 3]) -> f64 {
        let [a, b, c] = self.sheared(vertices);
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        let side = if u + v + w < 0.0 { -1.0 } else { 1.0 };
        let [u, v, w] = [u, v, w].map(|x| (x * side).max(0.0));
        let sum = u + v + w;
        let [x, y] = [0, 1].map(|i| (u * a[i] + v * b[i] + w * c[i]) / sum);
        if sum > 0.0 { x.abs() + y.abs() } else { f64::INFINITY }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::DVec3;

    #[test]
    fn weights_and_distance() {
        let triangle = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        let hit = |x: f64, y: f64, z: f64| {
            let ray = Ray::new(DVec3::new(x, y, z), DVec3::new(0.0, 0.0, -z));
            RayShear::new(&ray).triangle(&triangle)
        };
        assert_eq!(hit(0.5, 1.0, 5.0), Some(TriangleHit { t: 1.0, u: 0.25, v: 0.25 }));
        assert_eq!(hit(0.5, 1.0, -5.0), Some(TriangleHit { t: 1.0, u: 0.25, v: 0.25 }));
        assert_eq!(hit(2.0, 0.0, 5.0).map(|h| h.u), Some(1.0));
        assert_eq!(hit(1.0, 2.1, 5.0), None);
        let along = Ray::new(DVec3::new(-1.0, 1.0, 0.0), DVec3::X);
        assert_eq!(RayShear::new(&along).triangle(&triangle), None);
    }
}
