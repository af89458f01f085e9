//! Hits during shading, in blocks of eight.

use turner_bvh::lanes::{Block, Block32, F64x8, Mask8, Simd, Vec3x8, Work};

use super::Facing;
use crate::math::DVec3;
use crate::scene::SpectrumBlock;
use crate::shape::ROUNDING;

/// Eight hits. Lanes without a hit hold stale values; their results are never used.
#[derive(Clone, Copy, Default)]
pub(super) struct PointBlock {
    /// Unit direction of the ray.
    pub(super) d: [Block; 3],
    /// Origin and length of the ray.
    pub(super) origin: [Block; 3],
    pub(super) t: Block,
    /// Lanes that hit a sphere whose surface is still to be computed, and the sphere.
    pub(super) on_sphere: u8,
    pub(super) center: [Block; 3],
    pub(super) radius: Block,
    /// The surface: point, error bound, and the normals that point out of the shape.
    pub(super) p: [Block; 3],
    pub(super) error: Block,
    pub(super) ng: [Block; 3],
    pub(super) ns: [Block; 3],
    /// Lanes whose ray enters the shape.
    pub(super) entering: u8,
    /// The normal N of the shading model.
    pub(super) lit: [Block; 3],
    /// The surface colour, which is also that of material-coloured highlights.
    pub(super) color: SpectrumBlock,
    /// Coefficients of the material; `kd` and `ks` are 0 where the term is switched off.
    pub(super) ka: Block32,
    pub(super) kd: Block,
    pub(super) ks: Block,
    /// Integer exponents are stored as the bits of integers, and `exponent_bits` is the bitwise OR of all of
    /// them. Lanes with other exponents are marked in `real_exponent`.
    pub(super) exponent: Block,
    pub(super) exponent_bits: u32,
    pub(super) real_exponent: u8,
    /// The cosine below which the highlight is 0.
    pub(super) dark: Block,
    /// Lanes with a highlight term, and lanes that need lights.
    pub(super) glossy: u8,
    pub(super) shaded: u8,
    /// The local colour: the sum of ambient term and lights.
    pub(super) local: SpectrumBlock,
    /// The weight of the local colour in the pixel.
    pub(super) weight: Block,
    /// Lanes with a reflected ray.
    pub(super) mirrors: u8,
}

/// Stores a vector in a lane.
#[inline]
pub(super) fn set(block: &mut [Block; 3], lane: usize, v: DVec3) {
    block[0].0[lane] = v.x;
    block[1].0[lane] = v.y;
    block[2].0[lane] = v.z;
}

/// The vector in a lane.
#[inline]
pub(super) fn get(block: &[Block; 3], lane: usize) -> DVec3 {
    DVec3::new(block[0].0[lane], block[1].0[lane], block[2].0[lane])
}

impl PointBlock {
    /// Resets the lane masks for new hits.
    pub(super) fn clear(&mut self) {
        (self.on_sphere, self.real_exponent, self.glossy, self.shaded, self.mirrors) = (0, 0, 0, 0, 0);
        self.exponent_bits = 0;
    }

    /// The normal of a lane, flipped towards the viewer.
    #[inline]
    pub(super) fn facing(&self, normal: &[Block; 3], lane: usize) -> DVec3 {
        let n = get(normal, lane);
        if self.entering >> lane & 1 == 1 { n } else { -n }
    }

    /// The point of a lane, moved off the surface to the side of `direction`, as
    /// [`leave`](crate::scene::SurfaceInteraction::leave) does.
    pub(super) fn leave(&self, lane: usize, direction: DVec3) -> DVec3 {
        let ng = get(&self.ng, lane);
        let side = if direction.dot(ng) >= 0.0 { 4.0 } else { -4.0 };
        get(&self.p, lane) + ng * (side * self.error.0[lane])
    }

    #[inline(always)]
    pub(super) fn leave_wide<S: Simd>(&self, simd: S, direction: Vec3x8<S>) -> Vec3x8<S> {
        let ng = Vec3x8::load(simd, &self.ng);
        let out = direction.dot(ng).ge(F64x8::splat(simd, 0.0));
        let side = out.select(F64x8::splat(simd, 4.0), F64x8::splat(simd, -4.0));
        Vec3x8::load(simd, &self.p) + ng * (side * F64x8::load(simd, &self.error))
    }
}

/// Computes the surfaces of spheres and the facing normals.
pub(super) struct Surfaces<'a> {
    pub(super) points: &'a mut [PointBlock],
    pub(super) facing: Facing,
}

impl Work for Surfaces<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let zero = F64x8::splat(simd, 0.0);
        for b in self.points {
            let d = Vec3x8::load(simd, &b.d);
            if b.on_sphere != 0 {
                let t = F64x8::load(simd, &b.t);
                let center = Vec3x8::load(simd, &b.center);
                let at = Vec3x8::load(simd, &b.origin) + d * t - center;
                let n = at * (F64x8::splat(simd, 1.0) / at.dot(at).sqrt());
                let p = center + n * F64x8::load(simd, &b.radius);
                // As in `Sphere::surface`.
                let reach = center.x.abs().or_larger(center.y.abs().or_larger(center.z.abs()));
                let error = (F64x8::load(simd, &b.radius) + reach) * F64x8::splat(simd, ROUNDING);
                let floor = F64x8::splat(simd, 1e-15) * t;
                let sphere = Mask8::new(simd, b.on_sphere);
                sphere.select(error.or_larger(floor), F64x8::load(simd, &b.error)).store(&mut b.error);
                for (to, v) in [(&mut b.p, p), (&mut b.ng, n), (&mut b.ns, n)] {
                    Vec3x8::select(sphere, v, Vec3x8::load(simd, to)).store(to);
                }
            }
            let entering = d.dot(Vec3x8::load(simd, &b.ng)).le(zero);
            b.entering = entering.bits();
            let ns = Vec3x8::load(simd, &b.ns);
            match self.facing {
                Facing::Viewer => Vec3x8::select(entering, ns, -ns),
                Facing::Outward => ns,
            }
            .store(&mut b.lit);
        }
    }
}

/// A separate random dimension for each shaded point, light and shadow ray of a sample.
pub(super) fn jitter_dimension(shaded: u64, light: usize, i: u32) -> u64 {
    16 + ((shaded << 40) ^ ((light as u64) << 20) ^ u64::from(i))
}
