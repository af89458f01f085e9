//! Where objects are, roughly: what a drawing of a few rays needs of what they meet.

use crate::math::DVec3;
use crate::scene::Scene;
use crate::scene::scene::NO_TRANSFORM;
use crate::shape::Shape;

/// The extent of a primitive in world space, at the moment the shutter opens.
#[derive(Clone, Debug, PartialEq)]
pub enum Outline {
    /// A sphere.
    Sphere {
        /// Its middle.
        center: DVec3,
        /// Its radius.
        radius: f64,
    },
    /// A plane without end.
    Plane {
        /// One of its points.
        point: DVec3,
        /// Its normal, unit.
        normal: DVec3,
    },
    /// Points whose convex hull is that of the object, nearly.
    Points(Vec<DVec3>),
}

impl Scene {
    /// The outlines of some primitives, given by their numbers in the description in rising order; `None` for numbers that do not exist.
    pub fn outlines(&self, primitives: &[u32]) -> Vec<Option<Outline>> {
        let mut out = vec![None; primitives.len()];
        for primitive in &self.primitives[..] {
            let Ok(place) = primitives.binary_search(&primitive.id) else { continue };
            let transform = self.transforms.get(primitive.transform as usize).map(|t| t.to_world);
            let untouched = primitive.transform == NO_TRANSFORM;
            let to_world = |p: DVec3| transform.map_or(p, |t| t.transform_point3(p));
            let outline = match &primitive.shape {
                Shape::Sphere(s) if untouched => Outline::Sphere { center: s.center, radius: s.radius },
                Shape::Plane(plane) => {
                    let normal =
                        transform.map_or(plane.normal, |t| t.matrix3.inverse().transpose() * plane.normal);
                    Outline::Plane { point: to_world(plane.point), normal: normal.normalize_or_zero() }
                }
                shape => Outline::Points(shape.hull_points().into_iter().map(to_world).collect()),
            };
            if let Some(slot) = out.get_mut(place) {
                *slot = Some(outline);
            }
        }
        out
    }
}
