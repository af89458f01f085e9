//! Prisms: outlines that are extended along y.

use super::outline::Outline;
use super::{PrepareSolid, Solid, SolidGeometry};
use crate::math::{Bounds, DVec2, DVec3, Ray};
use crate::schema::{ErrorCode, SceneError, params};
use crate::shape::{MeshCache, ROUNDING, ShapeHit, SurfacePoint};

params! {
    /// A prism: an outline in the xz plane, extended from `bottom` to `top` along y, with holes. Sides: u runs along the
    /// outline, v from 0 at the bottom to 1 at the top. Top and bottom: u and v run along x and z over the bounding box
    /// of the outline.
    pub struct PrismDesc as "prism" {
        /// The corners of the outline: [[x, z], …], in either direction. The last one is joined to the first.
        points: Vec<DVec2>, required, default [(-1.0, -1.0), (1.0, -1.0), (0.0, 1.0)].map(DVec2::from).to_vec();
        /// Holes, and islands within holes: outlines as `points` has them. What an odd number of outlines contain is
        /// solid.
        holes: Vec<Vec<DVec2>> = Vec::new();
        /// Whether outlines are cubic Bézier curves: each point is followed by two control points.
        curved: bool = false;
        /// Height of the bottom.
        bottom: f64 = 0.0;
        /// Height of the top.
        top: f64 = 1.0;
    }
    example r#"[[object]]
type = "prism"
points = [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]]
holes = [[[0.3, 0.3], [0.7, 0.3], [0.7, 0.7], [0.3, 0.7]]]
top = 0.5
material = { color = "slategray" }
"#
}

/// A prism. Parts: 0 are the sides, 1 is the bottom, 2 the top. Hits on sides have the position along a segment in u
/// and the index of the segment in v.
#[derive(Clone, Debug)]
pub struct Prism {
    outline: Outline,
    bottom: f64,
    top: f64,
    error: f64,
}

impl PrepareSolid for PrismDesc {
    fn prepare_solid(&self, _: &mut MeshCache<'_>) -> Result<Solid, SceneError> {
        if !(self.bottom < self.top) {
            let message = format!("`top` ({}) of a prism must be above `bottom` ({})", self.top, self.bottom);
            return Err(SceneError::new(ErrorCode::OutOfRange, message).help("exchange the two"));
        }
        let mut contours = vec![self.points.as_slice()];
        contours.extend(self.holes.iter().map(Vec::as_slice));
        Prism::new(Outline::new(&contours, self.curved)?, self.bottom, self.top).map(Solid::Prism)
    }
}

impl Prism {
    fn new(outline: Outline, bottom: f64, top: f64) -> Result<Prism, SceneError> {
        let [min, max] = outline.bounds();
        let size = min.abs().max(max.abs()).max_element() + bottom.abs().max(top.abs());
        Ok(Prism { outline, bottom, top, error: 2.0 * ROUNDING * size })
    }
}

impl SolidGeometry for Prism {
    fn bounds(&self) -> Option<Bounds> {
        let [min, max] = self.outline.bounds();
        let (min, max) = (DVec3::new(min.x, self.bottom, min.y), DVec3::new(max.x, self.top, max.y));
        Some(Bounds::new(min - self.error, max + self.error))
    }

    fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        if !ray.is_finite() || ray.direction == DVec3::ZERO {
            return None;
        }
        let mut best: Option<ShapeHit> = None;
        let mut add = |hit: ShapeHit| {
            if ray.contains(hit.t) && best.is_none_or(|b| hit.t < b.t) {
                best = Some(hit);
            }
        };
        let flat = |v: DVec3| DVec2::new(v.x, v.z);
        for (part, height) in [(1, self.bottom), (2, self.top)] {
            let t = (height - ray.origin.y) / ray.direction.y;
            if ray.contains(t) && self.outline.contains(flat(ray.at(t))) {
                add(ShapeHit { t, part, u: 0.0, v: 0.0 });
            }
        }
        let (o, d) = (flat(ray.origin), flat(ray.direction));
        let squared = d.length_squared();
        if squared > 0.0 {
            for (i, segment) in self.outline.segments().iter().enumerate() {
                segment.crossings(o, d, |s| {
                    let t = (segment.at(s) - o).dot(d) / squared;
                    let y = ray.origin.y + t * ray.direction.y;
                    if y >= self.bottom && y <= self.top {
                        add(ShapeHit { t, part: 0, u: s, v: i as f64 });
                    }
                });
            }
        }
        best
    }

    fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        let mut p = ray.at(hit.t);
        let n = match (hit.part, self.outline.segments().get(hit.v as usize)) {
            (0, Some(segment)) => {
                let (q, n) = (segment.at(hit.u), segment.normal(hit.u));
                p = DVec3::new(q.x, p.y.clamp(self.bottom, self.top), q.y);
                DVec3::new(n.x, 0.0, n.y)
            }
            (1, _) => {
                p.y = self.bottom;
                DVec3::NEG_Y
            }
            _ => {
                p.y = self.top;
                DVec3::Y
            }
        };
        SurfacePoint { p, error: self.error, ng: n, ns: n }
    }

    fn uv(&self, hit: &ShapeHit, point: &SurfacePoint) -> DVec2 {
        let p = DVec2::new(point.p.x, point.p.z);
        if hit.part != 0 {
            let [min, max] = self.outline.bounds();
            return ((p - min) / (max - min)).clamp(DVec2::ZERO, DVec2::ONE);
        }
        let s = self.outline.parameter(hit.v as usize, hit.u, p);
        let count = self.outline.segments().len() as f64;
        let v = (point.p.y - self.bottom) / (self.top - self.bottom);
        DVec2::new(((hit.v + s) / count).clamp(0.0, 1.0), v.clamp(0.0, 1.0))
    }

    fn curvature(&self, _: &ShapeHit) -> f64 {
        0.0
    }

    fn hull_points(&self) -> Vec<DVec3> {
        let at = |y: f64| self.outline.points().map(move |p| DVec3::new(p.x, y, p.y));
        at(self.bottom).chain(at(self.top)).collect()
    }

    fn memory(&self) -> usize {
        size_of_val(self.outline.segments())
    }
}
