//! Rough outlines of objects, for drawings of a few rays and what they hit.

use crate::math::DVec3;
use crate::scene::Scene;
use crate::scene::scene::{NO_TRANSFORM, ObjectTransform, Primitive};
use crate::shape::Shape;

/// The extent of a primitive in world space at shutter open.
#[derive(Clone, Debug, PartialEq)]
pub enum Outline {
    /// A sphere.
    Sphere {
        /// Its centre.
        center: DVec3,
        /// Its radius.
        radius: f64,
    },
    /// An infinite plane.
    Plane {
        /// One of its points.
        point: DVec3,
        /// Its normal, unit.
        normal: DVec3,
    },
    /// Points with approximately the same convex hull as the object.
    Points(Vec<DVec3>),
}

/// More primitives than this count by a few of their points each.
const MANY: usize = 2000;

/// Points whose convex hull approximates that of primitives in world space at shutter open; unbounded shapes have none.
pub(crate) fn hull_points(primitives: &[&Primitive], transforms: &[ObjectTransform]) -> Vec<DVec3> {
    let mut out = Vec::new();
    for primitive in primitives {
        let transform = transforms.get(primitive.transform as usize).map(|t| t.to_world);
        let to_world = |p: DVec3| transform.map_or(p, |t| t.transform_point3(p));
        // Many objects are small ones.
        let most = if primitives.len() > MANY { 8 } else { usize::MAX };
        let points = primitive.shape.hull_points();
        let step = points.len() / most + 1;
        out.extend(points.into_iter().step_by(step).map(to_world));
    }
    out
}

impl Scene {
    /// Points whose convex hull approximates that of all bounded objects at shutter open.
    pub fn hull_points(&self) -> Vec<DVec3> {
        hull_points(&self.primitives.iter().collect::<Vec<_>>(), &self.transforms)
    }

    /// The outlines of primitives, given by their IDs in ascending order; `None` for unknown IDs.
    pub fn outlines(&self, primitives: &[u32]) -> Vec<Option<Outline>> {
        let mut out = vec![None; primitives.len()];
        for primitive in &self.primitives[..] {
            let Ok(index) = primitives.binary_search(&primitive.id) else { continue };
            let transform = self.transforms.get(primitive.transform as usize).map(|t| t.to_world);
            let untransformed = primitive.transform == NO_TRANSFORM;
            let to_world = |p: DVec3| transform.map_or(p, |t| t.transform_point3(p));
            let outline = match &primitive.shape {
                Shape::Sphere(s) if untransformed => Outline::Sphere { center: s.center, radius: s.radius },
                Shape::Plane(plane) => {
                    let normal =
                        transform.map_or(plane.normal, |t| t.matrix3.inverse().transpose() * plane.normal);
                    Outline::Plane { point: to_world(plane.point), normal: normal.normalize_or_zero() }
                }
                shape => Outline::Points(shape.hull_points().into_iter().map(to_world).collect()),
            };
            if let Some(slot) = out.get_mut(index) {
                *slot = Some(outline);
            }
        }
        out
    }
}
