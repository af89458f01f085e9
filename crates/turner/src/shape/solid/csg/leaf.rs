//! A leaf of constructive solid geometry: a shape with its place.

use crate::math::{Bounds, DAffine3, DMat3, DVec3, Ray};
use crate::shape::{Shape, ShapeHit, SurfacePoint, TriangleMesh};

/// Slopes of rays against surfaces count as at least this: a grazing ray would make any two crossings coincide.
const LEAST_SLOPE: f64 = 1e-3;

/// A transform and what follows from it.
#[derive(Clone, Debug)]
struct Placement {
    to_object: DAffine3,
    to_leaf: DAffine3,
    /// Normals transform by the inverse transpose.
    normal: DMat3,
    /// Upper bound of the factor by which lengths grow.
    stretch: f64,
    /// The mean factor.
    scale: f64,
}

/// A shape of the expression.
#[derive(Clone, Debug)]
pub(super) struct Leaf {
    shape: Shape,
    place: Option<Box<Placement>>,
    /// The operation that it is a part of.
    pub(super) node: u16,
    /// Whether that operation takes what is outside the shape.
    pub(super) inverted: bool,
    /// Whether its surface faces into the shape: it is inverted an odd number of times.
    pub(super) flipped: bool,
    /// Bounds in object space.
    bounds: Option<Bounds>,
    first_slot: usize,
}

/// Where a ray crosses a leaf.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    pub(super) hit: ShapeHit,
    /// Whether the ray leaves the leaf.
    pub(super) exits: bool,
    /// How far t may be from the exact crossing.
    pub(super) error: f64,
}

impl Leaf {
    pub(super) fn new(
        shape: Shape,
        to_object: &DAffine3,
        (node, inverted, flipped): (u16, bool, bool),
        first_slot: usize,
    ) -> Leaf {
        let place = (*to_object != DAffine3::IDENTITY).then(|| {
            let to_leaf = to_object.inverse();
            let m = to_object.matrix3;
            let squares = [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.length_squared());
            Box::new(Placement {
                to_object: *to_object,
                to_leaf,
                normal: to_leaf.matrix3.transpose(),
                stretch: squares.iter().sum::<f64>().sqrt(),
                scale: (squares.iter().sum::<f64>() / 3.0).sqrt(),
            })
        });
        let bounds = shape.bounds().map(|b| if place.is_some() { b.transformed(to_object) } else { b });
        Leaf { shape, place, node, inverted, flipped, bounds, first_slot }
    }

    pub(super) fn shape(&self) -> &Shape {
        &self.shape
    }

    pub(super) fn bounds(&self) -> Option<Bounds> {
        self.bounds
    }

    pub(super) fn mesh(&self) -> Option<&TriangleMesh> {
        match &self.shape {
            Shape::Mesh(mesh) => Some(mesh),
            _ => None,
        }
    }

    fn local(&self, ray: &Ray) -> Ray {
        match &self.place {
            Some(place) => ray.transformed(&place.to_leaf),
            None => *ray,
        }
    }

    /// Whether a ray may hit it from `t_min` on: a test of the bounds, with a margin for rounding. `inverse` has the
    /// reciprocals of its direction.
    pub(super) fn may_be_hit(&self, ray: &Ray, inverse: DVec3, t_min: f64) -> bool {
        let Some(b) = self.bounds else { return true };
        let margin = 1e-12 * (ray.origin.abs().max_element() + b.min.abs().max(b.max.abs()).max_element());
        let near = (b.min - margin - ray.origin) * inverse;
        let far = (b.max + margin - ray.origin) * inverse;
        // 0 · ∞ is NaN where the ray runs in the plane of a face: min and max ignore it.
        let enter = near.x.min(far.x).max(near.y.min(far.y)).max(near.z.min(far.z));
        let exit = near.x.max(far.x).min(near.y.max(far.y)).min(near.z.max(far.z));
        !(enter > exit || exit < t_min)
    }

    /// The next crossing with t >= `t_min`, without an upper limit.
    pub(super) fn next(&self, ray: &Ray, t_min: f64) -> Option<Crossing> {
        let ray = Ray { t_min, t_max: f64::INFINITY, ..self.local(ray) };
        let hit = self.shape.intersect(&ray)?;
        let surface = self.shape.surface(&ray, &hit);
        let (speed, along) = (ray.direction.length(), ray.direction.dot(surface.ng));
        let size = ray.origin.abs().max_element() + hit.t.abs() * speed;
        let distance = surface.error + 8.0 * f64::EPSILON * size;
        Some(Crossing { hit, exits: along > 0.0, error: distance / along.abs().max(LEAST_SLOPE * speed) })
    }

    /// Whether the ray is inside after its last crossing: never, except for unbounded shapes.
    pub(super) fn contains_far_end(&self, ray: &Ray) -> bool {
        self.bounds.is_none() && self.shape.contains_far_end(&self.local(ray))
    }

    pub(super) fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        let mut s = self.shape.surface(&self.local(ray), hit);
        if let Some(place) = &self.place {
            let p = place.to_object.transform_point3(s.p);
            let size = p.abs().max_element() + place.to_object.translation.abs().max_element();
            s = SurfacePoint {
                p,
                error: s.error * place.stretch + 1e-15 * size,
                ng: (place.normal * s.ng).normalize(),
                ns: (place.normal * s.ns).normalize(),
            };
        }
        // A ray that leaves has to be beyond another leaf's face at the same place, too.
        s.error *= 2.0;
        if self.flipped { SurfacePoint { ng: -s.ng, ns: -s.ns, ..s } } else { s }
    }

    /// A point of the surface in the space of the leaf.
    pub(super) fn local_point(&self, point: &SurfacePoint) -> SurfacePoint {
        let mut s = *point;
        if let Some(place) = &self.place {
            let turned = place.to_object.matrix3.transpose();
            s.p = place.to_leaf.transform_point3(s.p);
            s.ng = (turned * s.ng).normalize_or(s.ng);
            s.ns = (turned * s.ns).normalize_or(s.ns);
        }
        if self.flipped { SurfacePoint { ng: -s.ng, ns: -s.ns, ..s } } else { s }
    }

    pub(super) fn curvature(&self, hit: &ShapeHit) -> f64 {
        let scale = self.place.as_ref().map_or(1.0, |place| place.scale);
        let curvature = self.shape.curvature(hit) / scale;
        if self.flipped { -curvature } else { curvature }
    }

    /// Points on the hull; none for a leaf that is taken away.
    pub(super) fn hull_points(&self) -> Vec<DVec3> {
        let points = if self.flipped { Vec::new() } else { self.shape.hull_points() };
        match &self.place {
            Some(place) => points.into_iter().map(|p| place.to_object.transform_point3(p)).collect(),
            None => points,
        }
    }

    pub(super) fn material_slot(&self, hit: &ShapeHit) -> usize {
        self.first_slot + self.mesh().map_or(0, |mesh| mesh.face_material(hit.part))
    }

    pub(super) fn memory(&self) -> usize {
        self.shape.memory() + self.place.as_ref().map_or(0, |_| size_of::<Placement>())
    }
}
