//! Brute-force intersection of rays with a few spheres: eight rays at a time, sphere after sphere, exact.
//!
//! The arithmetic is that of one ray and one sphere in double precision, operation by operation, so hits are equal to
//! the last bit for every instruction set. Eight rays against one sphere, rather than one ray against eight spheres,
//! keeps all lanes busy for any number of spheres and needs no reduction.

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

/// The nearest hits of a block of rays.
#[derive(Clone, Copy, Debug)]
pub struct NearestBlock {
    /// The ray's t at the hit; its `t_max` if it hits nothing.
    pub t: Block,
    /// Index of the sphere; -1 for none.
    pub sphere: Block,
}

impl Spheres {
    /// Adds a sphere. Its index is the number of spheres before it.
    pub fn push(&mut self, center: [f64; 3], radius: f64) {
        self.spheres.push(Sphere { center, radius2: radius * radius });
    }

    /// Number of spheres.
    pub fn len(&self) -> usize {
        self.spheres.len()
    }

    /// Whether there are no spheres.
    pub fn is_empty(&self) -> bool {
        self.spheres.is_empty()
    }

    /// Memory in bytes.
    pub fn bytes(&self) -> usize {
        self.spheres.len() * size_of::<Sphere>()
    }

    /// The nearest hit of each ray with `t_min <= t <= t_max`; among equally near ones, the sphere with the lowest
    /// index. Replaces the contents of `nearest`.
    pub fn closest(&self, set: InstructionSet, rays: &[RayBlock], nearest: &mut Vec<NearestBlock>) {
        nearest.clear();
        nearest.reserve(rays.len());
        dispatch(set, Closest { spheres: &self.spheres, rays, nearest });
    }

    /// For each block, the set of rays that hit anything with `t_min <= t <= t_max`. Replaces the contents of `hit`.
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
    /// Rays with a direction; excludes empty lanes.
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
    /// With f from the centre to the origin, the discriminant is r² |d|² − |f × d|²: the distance of the line from the
    /// centre, without the cancellation of b² − a c. The roots use the numerically stable quadratic formula (Haines et
    /// al. 2019, "Precision improvements for ray/sphere intersection", Ray Tracing Gems ch. 7).
    #[inline(always)]
    fn hit(&self, sphere: &Sphere, t_max: F64x8<S>) -> Option<(Mask8<S>, F64x8<S>)> {
        let zero = F64x8::splat(self.simd, 0.0);
        let r2 = F64x8::splat(self.simd, sphere.radius2);
        let f = self.origin - Vec3x8::splat(self.simd, sphere.center);
        let d = self.direction;
        let across = f.cross(d);
        let discriminant = self.a * r2 - across.dot(across);
        let hits = discriminant.ge(zero) & self.moving;
        if !hits.any() {
            return None;
        }
        let b = -f.dot(d);
        let c = f.dot(f) - r2;
        let away = b.lt(zero) & c.gt(zero) & self.forward;
        let hits = hits.and_not(away);
        if !hits.any() {
            return None;
        }
        let q = b + discriminant.sqrt().copysign(b);
        let t0 = q.eq(zero).select(zero, c / q);
        let t1 = q / self.a;
        let near = b.gt(zero) & self.contains(t0, t_max);
        let far = b.le(zero) & self.contains(t1, t_max);
        let t = near.select(t0, far.select(t1, t0.or_larger(t1)));
        Some((hits & self.contains(t, t_max), t))
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
                // At exactly `t_max`, only the first hit counts.
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
            // Empty lanes count as hit until the end, so that they do not delay the early exit.
            let idle = t_max.is_nan().bits();
            let mut hit = idle;
            for sphere in self.spheres {
                if let Some((hits, _)) = rays.hit(sphere, t_max) {
                    hit |= hits.bits();
                    if hit == u8::MAX {
                        break;
                    }
                }
            }
            self.hit.push(hit & !idle);
        }
    }
}
