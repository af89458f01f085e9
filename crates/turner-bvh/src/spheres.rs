//! Rays against a few spheres: eight rays at a time, sphere after sphere, exactly.
//!
//! The arithmetic is that of one ray and one sphere, operation by operation in double precision, so the hit found is
//! the same to the last bit whichever instruction set finds it. Eight rays against one sphere rather than one ray
//! against eight spheres: no lane is idle however few spheres there are, and there is nothing to reduce.

use crate::InstructionSet;
use crate::lanes::{Block, F64x8, Mask8, Simd, Vec3x8, Work, dispatch};
use crate::rays::RayBlock;

/// A list of spheres.
#[derive(Clone, Debug, Default)]
pub struct Spheres {
    spheres: Vec<Sphere>,
}

#[derive(Clone, Copy, Debug)]
struct Sphere {
    center: [f64; 3],
    /// Radius squared.
    radius2: f64,
}

/// What a block of rays hits first.
#[derive(Clone, Copy, Debug)]
pub struct NearestBlock {
    /// Where, in the ray's t; its `t_max` where it hits nothing.
    pub t: Block,
    /// The number of the sphere, −1 for none.
    pub sphere: Block,
}

impl Spheres {
    /// Adds a sphere; its number is how many there were.
    pub fn push(&mut self, center: [f64; 3], radius: f64) {
        self.spheres.push(Sphere { center, radius2: radius * radius });
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.spheres.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.spheres.is_empty()
    }

    /// Bytes of memory.
    pub fn bytes(&self) -> usize {
        self.spheres.len() * size_of::<Sphere>()
    }

    /// For each ray the nearest hit with `t_min <= t <= t_max`; among equally near ones that of the sphere with the
    /// lowest number. Replaces what was in `nearest`.
    pub fn closest(&self, set: InstructionSet, rays: &[RayBlock], nearest: &mut Vec<NearestBlock>) {
        nearest.clear();
        nearest.reserve(rays.len());
        dispatch(set, Closest { spheres: &self.spheres, rays, nearest });
    }

    /// For each block the set of rays that hit anything with `t_min <= t <= t_max`. Replaces what was in `hit`.
    pub fn any(&self, set: InstructionSet, rays: &[RayBlock], hit: &mut Vec<u8>) {
        hit.clear();
        hit.reserve(rays.len());
        dispatch(set, Any { spheres: &self.spheres, rays, hit });
    }
}

/// Eight rays in registers, with what does not depend on the sphere.
struct Rays<S: Simd> {
    simd: S,
    origin: Vec3x8<S>,
    direction: Vec3x8<S>,
    /// |direction|².
    a: F64x8<S>,
    t_min: F64x8<S>,
    /// Rays that begin at or after t = 0.
    forward: Mask8<S>,
    /// Rays that have a direction; not the empty lanes.
    moving: Mask8<S>,
}

impl<S: Simd> Rays<S> {
    #[inline(always)]
    fn load(simd: S, block: &RayBlock) -> Rays<S> {
        let direction = Vec3x8::load(simd, &block.direction);
        let a = direction.dot(direction);
        let t_min = F64x8::load(simd, &block.t_min);
        let zero = F64x8::splat(simd, 0.0);
        Rays {
            simd,
            origin: Vec3x8::load(simd, &block.origin),
            direction,
            a,
            t_min,
            forward: t_min.ge(zero),
            moving: a.gt(zero).and_not(F64x8::load(simd, &block.t_max).is_nan()),
        }
    }

    /// Which rays hit the sphere at or before `t_max`, and where.
    ///
    /// The discriminant is r² |d|² − |f × d|² with f from the centre to the origin: the distance of the line from the
    /// centre without the cancellation of b² − a c. The roots are those of the stable form of the quadratic formula
    /// (Haines et al. 2019, "Precision improvements for ray/sphere intersection", Ray Tracing Gems ch. 7).
    #[inline(always)]
    fn hit(&self, sphere: &Sphere, t_max: F64x8<S>) -> Option<(Mask8<S>, F64x8<S>)> {
        let zero = F64x8::splat(self.simd, 0.0);
        let r2 = F64x8::splat(self.simd, sphere.radius2);
        let f = self.origin - Vec3x8::splat(self.simd, sphere.center);
        let d = self.direction;
        let across = f.cross(d);
        let discriminant = self.a * r2 - across.dot(across);
        let met = discriminant.ge(zero) & self.moving;
        if !met.any() {
            return None;
        }
        let b = -f.dot(d);
        let c = f.dot(f) - r2;
        let away = b.lt(zero) & c.gt(zero) & self.forward;
        let met = met.and_not(away);
        if !met.any() {
            return None;
        }
        let q = b + discriminant.sqrt().copysign(b);
        let t0 = q.eq(zero).select(zero, c / q);
        let t1 = q / self.a;
        let near = b.gt(zero) & self.contains(t0, t_max);
        let far = b.le(zero) & self.contains(t1, t_max);
        let t = near.select(t0, far.select(t1, t0.or_larger(t1)));
        Some((met & self.contains(t, t_max), t))
    }

    #[inline(always)]
    fn contains(&self, t: F64x8<S>, t_max: F64x8<S>) -> Mask8<S> {
        t.ge(self.t_min) & t.le(t_max) & t.lt(F64x8::splat(self.simd, f64::INFINITY))
    }
}

struct Closest<'a> {
    spheres: &'a [Sphere],
    rays: &'a [RayBlock],
    nearest: &'a mut Vec<NearestBlock>,
}

impl Work for Closest<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        for block in self.rays {
            let rays = Rays::load(simd, block);
            let mut t_max = F64x8::load(simd, &block.t_max);
            let mut found = Mask8::new(simd, 0);
            let mut nearest = F64x8::splat(simd, -1.0);
            for (i, sphere) in self.spheres.iter().enumerate() {
                let Some((hit, t)) = rays.hit(sphere, t_max) else { continue };
                // At the end of the range a hit counts only if it is the first.
                let nearer = hit.and_not(t.eq(t_max) & found);
                t_max = nearer.select(t, t_max);
                nearest = nearer.select(F64x8::splat(simd, i as f64), nearest);
                found = found | nearer;
            }
            let mut out = NearestBlock { t: Block::default(), sphere: Block::default() };
            t_max.store(&mut out.t);
            nearest.store(&mut out.sphere);
            self.nearest.push(out);
        }
    }
}

struct Any<'a> {
    spheres: &'a [Sphere],
    rays: &'a [RayBlock],
    hit: &'a mut Vec<u8>,
}

impl Work for Any<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        for block in self.rays {
            let rays = Rays::load(simd, block);
            let t_max = F64x8::load(simd, &block.t_max);
            // Lanes without a ray count as hit until the end: nothing is searched for them.
            let idle = t_max.is_nan().bits();
            let mut hit = idle;
            for sphere in self.spheres {
                if let Some((met, _)) = rays.hit(sphere, t_max) {
                    hit |= met.bits();
                    if hit == u8::MAX {
                        break;
                    }
                }
            }
            self.hit.push(hit & !idle);
        }
    }
}
