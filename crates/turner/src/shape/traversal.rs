//! From double-precision rays to those of the trees.
//!
//! Trees hold boxes in single precision. A [`TraversalFrame`] puts everything a tree holds into the unit sphere,
//! moved and scaled in double precision, and starts each ray beside that sphere, however far its origin is. There
//! the roundings to `f32` are at most 2^-22, and every box is padded by more: whatever a ray meets in double
//! precision it meets in the tree. This holds up to origins some 1e9 times farther away than the scene is large;
//! beyond, positions in double precision are themselves no better than that.

use turner_bvh::Aabb;

use crate::math::{Bounds, DVec3, Ray};

/// Padding of boxes and of ends of rays, in units of the frame's radius: 2^-20, four times the roundings.
const PAD: f64 = 1.0 / (1 << 20) as f64;

/// Where a tree's coordinates lie in the space of its rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraversalFrame {
    center: DVec3,
    /// Units of the tree per unit of space: a power of two, so that scaling is exact.
    scale: f64,
    /// By how much boxes are padded, in units of the tree.
    pad: f64,
}

/// A ray in the units of a tree, and how its parameters correspond.
#[derive(Clone, Copy, Debug)]
pub struct TraversalRay {
    /// What to search the tree with.
    pub ray: turner_bvh::Ray,
    /// Units of the tree per unit of t.
    speed: f64,
    /// Where the tree's ray starts, in its units from t = 0.
    start: f64,
}

impl TraversalRay {
    /// The end of a search that still finds everything up to `t`.
    #[inline]
    pub fn end(&self, t: f64) -> f32 {
        // Within the sphere values are at most 8: their rounding to f32 is a fraction of the padding.
        (t * self.speed - self.start + PAD) as f32
    }
}

impl TraversalFrame {
    /// The frame of a tree that holds everything within `bounds`. No ray is let into an empty or infinite one.
    pub fn new(bounds: &Bounds) -> TraversalFrame {
        if bounds.is_empty() || !bounds.is_finite() {
            // No size: no ray is let in.
            return TraversalFrame { center: DVec3::ZERO, scale: 0.0, pad: PAD };
        }
        let far = bounds.min.abs().max(bounds.max.abs()).max_element();
        // A frame much smaller than its distance from 0 would consist of padding.
        let radius = (0.5 * bounds.size()).length().max(far * 1e-12).clamp(1e-140, 1e140);
        let scale = power_of_two_below(1.0 / radius);
        TraversalFrame { center: bounds.center(), scale, pad: PAD + 4.0 * f64::EPSILON * far * scale }
    }

    /// A box in the units of the tree, padded.
    pub fn aabb(&self, bounds: &Bounds) -> Aabb {
        if bounds.is_empty() {
            return Aabb::EMPTY;
        }
        let min = (bounds.min - self.center) * self.scale - self.pad;
        let max = (bounds.max - self.center) * self.scale + self.pad;
        Aabb::outward(min.to_array(), max.to_array())
    }

    /// A sphere in the units of the tree, not padded.
    pub fn sphere(&self, center: DVec3, radius: f64) -> (DVec3, f64) {
        ((center - self.center) * self.scale, radius * self.scale + self.pad)
    }

    /// The ray to search the tree with; `None` if it passes the tree by, or is no ray at all (NaN, infinite, no
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
        // Everything lies within 1 of the middle, and padded boxes within a little more.
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

/// The largest power of two that is not above a normal number.
fn power_of_two_below(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & 0x7ff0_0000_0000_0000)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::testing::Random;
    use turner_bvh::{Bvh2, Bvh2Options};

    /// Rays aimed at points of small boxes must offer those boxes, wherever the scene lies, however large it is,
    /// and from however far away.
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
                        let mut way = random.direction();
                        if i % 5 == 0 {
                            way = DVec3::AXES[i % 3];
                        }
                        let length = scale * distance;
                        let origin = p - length * way;
                        // Aim from the rounded origin; the length of the direction is arbitrary.
                        let direction = (p - origin) * 3.7;
                        let t = 1.0 / 3.7;
                        let ray = Ray { t_min: 0.0, t_max: t, ..Ray::new(origin, direction) };
                        for ray in [ray, Ray { t_min: t, t_max: f64::INFINITY, ..ray }] {
                            let search = frame.ray(&ray).expect("a ray that meets the scene");
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
    fn rays_beside_or_behind_or_broken_are_turned_away() {
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
