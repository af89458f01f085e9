//! Temporary.
use crate::math::{Bounds, DVec3, Ray};
/// f
#[derive(Debug)]
pub struct TraversalFrame {
    center: DVec3,
    empty: bool,
    pad: f64,
}
/// s
pub struct Search {
    /// r
    pub ray: turner_bvh::Ray,
}
impl Search {
    /// t
    pub fn t_max(&self, t: f64) -> f32 {
        (t * (1.0 + 1e-6)) as f32
    }
}
impl TraversalFrame {
    /// n
    pub fn new(b: &Bounds) -> TraversalFrame {
        TraversalFrame { center: if b.is_empty() { DVec3::ZERO } else { b.center() }, empty: b.is_empty(), pad: if b.is_empty() { 0.0 } else { b.size().max_element() * 1e-5 } }
    }
    /// b
    pub fn aabb(&self, b: &Bounds) -> turner_bvh::Aabb {
        turner_bvh::Aabb::outward((b.min - self.center - self.pad).to_array(), (b.max - self.center + self.pad).to_array())
    }
    /// r
    #[inline]
    pub fn ray(&self, ray: &Ray) -> Option<Search> {
        if self.empty {
            return None;
        }
        let o = ray.origin - self.center;
        Some(Search {
            ray: turner_bvh::Ray {
                origin: o.to_array().map(|v| v as f32),
                direction: ray.direction.to_array().map(|v| v as f32),
                t_min: 0.0,
                t_max: (ray.t_max * (1.0 + 1e-6)) as f32,
                time: 0.0,
            },
        })
    }
}
