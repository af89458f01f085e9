//! From f64 rays to the f32 rays of BVHs over boxes.
//!
//! BVHs hold boxes in f32, while scenes may be as small as 1e-6 or as far away as 1e7 units. A
//! [`TraversalFrame`] translates and scales everything a tree holds, in f64, into the unit sphere, and starts
//! each ray next to that sphere, however distant its origin is:
//!
//! ```text
//!    world (f64)                               frame (f32)
//!                                                ,-----,
//!    origin o---------------->[scene]     o---->(  r=1  )---->
//!                                         start  `-----´
//! ```
//!
//! In the frame, rounding to f32 is at most 2^-22, and every box is padded by more (2^-20). Hence a ray that
//! hits an object in f64 also hits its box in the tree: a box test may report too many candidates, never too
//! few. The shape then computes the hit in f64. This holds for origins up to about 1e9 times farther away than
//! the size of the scene; beyond that, f64 positions are themselves no more precise.

use turner_bvh::Aabb;

use crate::math::{Bounds, DVec3, Ray};

/// Padding of boxes and of ray ends, in units of the frame's radius: 2^-20, four times the rounding error.
const PAD: f64 = 1.0 / (1 << 20) as f64;

/// The affine map from the space of rays to the coordinates of a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraversalFrame {
    center: DVec3,
    /// Tree units per unit of space: a power of two, so that scaling is exact.
    scale: f64,
    /// Padding of boxes, in tree units.
    pad: f64,
}

/// A ray in tree units, and how its parameter corresponds to that of the original ray.
#[derive(Clone, Copy, Debug)]
pub struct TraversalRay {
    /// The ray to search the tree with.
    pub ray: turner_bvh::Ray,
    /// Tree units per unit of t.
    speed: f64,
    /// Start of the tree's ray, in tree units from t = 0.
    start: f64,
}

impl TraversalRay {
    /// The `t_max` of a search that still finds everything up to `t`.
    #[inline]
    pub fn end(&self, t: f64) -> f32 {
        // Values within reach are at most 8: their rounding to f32 is a fraction of the padding.
        (t * self.speed - self.start + PAD) as f32
    }
}

impl TraversalFrame {
    /// The frame of a tree whose contents are within `bounds`. If the bounds are empty or infinite, all rays miss.
    pub fn new(bounds: &Bounds) -> TraversalFrame {
        if bounds.is_empty() || !bounds.is_finite() {
            // Scale 0: every ray misses.
            return TraversalFrame { center: DVec3::ZERO, scale: 0.0, pad: PAD };
        }
        let far = bounds.min.abs().max(bounds.max.abs()).max_element();
        // If the frame were much smaller than its distance from 0, padding would fill it.
        let radius = (0.5 * bounds.size()).length().max(far * 1e-12).clamp(1e-140, 1e140);
        let scale = power_of_two_below(1.0 / radius);
        TraversalFrame { center: bounds.center(), scale, pad: PAD + 4.0 * f64::EPSILON * far * scale }
    }

    /// A box in tree units, padded.
    pub fn aabb(&self, bounds: &Bounds) -> Aabb {
        if bounds.is_empty() {
            return Aabb::EMPTY;
        }
        let min = (bounds.min - self.center) * self.scale - self.pad;
        let max = (bounds.max - self.center) * self.scale + self.pad;
        Aabb::outward(min.to_array(), max.to_array())
    }

    /// A box in tree units as one in space, with its padding.
    pub(crate) fn bounds_of(&self, b: &Aabb) -> Bounds {
        let of = |v: [f32; 3]| DVec3::from_array(v.map(f64::from)) / self.scale + self.center;
        Bounds::new(of(b.min), of(b.max))
    }

    /// A sphere in tree units, padded.
    pub fn sphere(&self, center: DVec3, radius: f64) -> (DVec3, f64) {
        ((center - self.center) * self.scale, radius * self.scale + self.pad)
    }

    /// The ray to search the tree with; `None` if it misses the frame or is invalid (NaN, infinite, zero
    /// direction).
    #[inline]
    pub fn ray(&self, ray: &Ray) -> Option<TraversalRay> {
        let o = (ray.origin - self.center) * self.scale;
        let d = ray.direction * self.scale;
        let speed = d.length();
        let inv = 1.0 / speed;
        if !(inv > 0.0 && inv < f64::INFINITY) {
            return None;
        }
        let d = d * inv;
        let nearest = -o.dot(d);
        // The contents lie within 1 of the centre, and padded boxes slightly farther out.
        let reach = 1.0 + 2.0 * self.pad;
        let start = (nearest - 2.0 * reach).max(ray.t_min * speed - PAD);
        if !((o + nearest * d).length_squared() <= reach * reach && start <= nearest + 2.0 * reach) {
            return None;
        }
        let p = o + start * d;
        let ray = turner_bvh::Ray {
            origin: p.as_vec3().to_array(),
            direction: d.as_vec3().to_array(),
            t_min: 0.0,
            t_max: (ray.t_max * speed - start + PAD) as f32,
        };
        Some(TraversalRay { ray, speed, start })
    }
}

/// The largest power of two that is not above `x`, a normal number.
fn power_of_two_below(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & 0x7ff0_0000_0000_0000)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::testing::Random;
    use turner_bvh::{Bvh2, Bvh2Options};

    /// Rays aimed at points of small boxes must find those boxes, for any position and size of the scene, and
    /// from any distance.
    #[test]
    fn no_box_is_lost_by_rounding() {
        let mut random = Random::new(1);
        for scale in [1e-6, 1e-3, 1.0, 1e3, 1e6] {
            for offset in [0.0, 1.0, 1e6] {
                for distance in [0.5, 10.0, 1e7] {
                    let middle = DVec3::new(offset, -0.7 * offset, 0.3 * offset);
                    let points: Vec<DVec3> = (0..200).map(|_| middle + scale * random.in_cube()).collect();
                    let frame = TraversalFrame::new(&Bounds::of(points.iter().copied()));
                    let boxes: Vec<Aabb> = points.iter().map(|&p| frame.aabb(&Bounds::new(p, p))).collect();
                    assert!(boxes.iter().all(|b| b.is_valid()));
                    let tree =
                        Bvh2::build(&boxes, &Bvh2Options { threads: 1, ..Default::default() }).unwrap();
                    for (i, &p) in points.iter().enumerate() {
                        let mut axis = random.direction();
                        if i % 5 == 0 {
                            axis = DVec3::AXES[i % 3];
                        }
                        let length = scale * distance;
                        let origin = p - length * axis;
                        // Aim from the rounded origin; the length of the direction is arbitrary.
                        let direction = (p - origin) * 3.7;
                        let t = 1.0 / 3.7;
                        let ray = Ray { t_min: 0.0, t_max: t, ..Ray::new(origin, direction) };
                        for ray in [ray, Ray { t_min: t, t_max: f64::INFINITY, ..ray }] {
                            let search = frame.ray(&ray).expect("the ray hits the scene");
                            assert!(search.end(t) <= 8.0);
                            let mut offered = false;
                            tree.closest(&search.ray, |range, t_max| {
                                let order = &tree.order()[range.start as usize..range.end as usize];
                                offered |= order.contains(&(i as u32));
                                t_max.min(search.end(t))
                            });
                            assert!(
                                offered,
                                "scale {scale}, offset {offset}, distance {distance}, point {i}"
                            );
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn rays_that_miss_or_are_invalid_are_rejected() {
        let frame = TraversalFrame::new(&Bounds::new(DVec3::NEG_ONE, DVec3::ONE));
        let ray = |o: [f64; 3], d: [f64; 3]| frame.ray(&Ray::new(o.into(), d.into())).is_some();
        assert!(ray([0.0, 0.0, 1e7], [0.0, 0.0, -1e-3]));
        assert!(!ray([0.0, 0.0, 1e7], [0.0, 0.0, 1.0]));
        assert!(!ray([0.0, 5.0, 1e7], [0.0, 0.0, -1.0]));
        assert!(!ray([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]));
        assert!(!ray([f64::NAN, 0.0, 0.0], [0.0, 0.0, 1.0]));
        assert!(!ray([0.0, 0.0, 0.0], [0.0, f64::INFINITY, 1.0]));
        assert!(!ray([0.0, 0.0, f64::INFINITY], [0.0, 1.0, 1.0]));
        assert!(TraversalFrame::new(&Bounds::EMPTY).ray(&Ray::new(DVec3::ONE, DVec3::ONE)).is_none());
    }
}
