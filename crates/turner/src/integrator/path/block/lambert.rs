//! Lambert's reflection, eight vertices at a time: direct light and the way on.

use std::f64::consts::PI;

use turner_bvh::lanes::{Block32, F32x8, F64x8, Mask8, Simd, Vec3x8, Work};

use super::{Shading, VertexBlock};
use crate::bsdf::MIN_COSINE;
use crate::math::elementary_x8::sin_cos_turns;
use crate::math::frame_x8::FrameX8;

/// Shades a block. Each line is one of [`Wave::scatter`](crate::integrator::path) and what that calls, for a frame around the geometric normal.
pub(super) struct Shade<'a> {
    pub(super) block: &'a VertexBlock,
    pub(super) room: &'a mut Shading,
}

/// Colours, band by band.
type Bands<S> = [F32x8<S>; 3];

#[inline(always)]
fn load<S: Simd>(simd: S, [r, g, b]: &[Block32; 3]) -> Bands<S> {
    [F32x8::load(simd, r), F32x8::load(simd, g), F32x8::load(simd, b)]
}

#[inline(always)]
fn times<S: Simd>([a, b, c]: Bands<S>, [x, y, z]: Bands<S>) -> Bands<S> {
    [a * x, b * y, c * z]
}

#[inline(always)]
fn store<S: Simd>([r, g, b]: Bands<S>, to: &mut [Block32; 3]) {
    r.store(&mut to[0]);
    g.store(&mut to[1]);
    b.store(&mut to[2]);
}

impl Work for Shade<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Shade { block, room } = self;
        let splat = |v: f64| F64x8::splat(simd, v);
        let (zero, one, least) = (splat(0.0), splat(1.0), splat(MIN_COSINE));
        let (p, error, ng) = block.facets.lanes(simd);
        let direction = Vec3x8::load(simd, &block.direction);
        let outside = direction.dot(ng).lt(zero);
        let frame = FrameX8::from_z(simd, ng).turned_unless(outside);
        let seen = (-direction).dot(frame.z).gt(least);
        // All rays leave on the side of the frame's z.
        let side = outside.select(splat(4.0), splat(-4.0));
        let origin = p + ng * (side * error);
        origin.store(&mut room.origin);
        let reaches = times(load(simd, &room.beta), load(simd, &block.f));

        let to_light = Vec3x8::load(simd, &room.to_light);
        let distance = to_light.dot(to_light).sqrt();
        let wi = Vec3x8 { x: to_light.x / distance, y: to_light.y / distance, z: to_light.z / distance };
        let cosine = wi.dot(frame.z);
        let light_pdf = F64x8::load(simd, &room.light_pdf);
        let r = cosine / splat(PI) / light_pdf;
        let weight = Mask8::new(simd, room.weighed).select(one / (one + r * r), one);
        let k = (weight * cosine / light_pdf).narrow();
        let [r, g, b] = times(times(reaches, load(simd, &room.radiance)), [k, k, k]);
        let none = F32x8::splat(simd, 0.0);
        let dark = r.eq(none) & g.eq(none) & b.eq(none);
        room.connects = (seen & cosine.gt(least)).and_not(dark).bits() & room.lit;
        store([r, g, b], &mut room.light);
        let finite = Mask8::new(simd, room.finite);
        Vec3x8::select(finite, p + to_light - origin, wi).store(&mut room.shadow);

        let r2 = F64x8::load(simd, &room.u[0]);
        let (sin, cos) = sin_cos_turns(simd, F64x8::load(simd, &room.u[1]));
        let r = r2.sqrt();
        let height = (one - r2).or_larger(zero).sqrt();
        let next = frame.to_world(Vec3x8 { x: r * cos, y: r * sin, z: height });
        next.store(&mut room.next);
        let pdf = height / splat(PI);
        pdf.store(&mut room.pdf);
        let k = (height / pdf).narrow();
        store(times(reaches, [k, k, k]), &mut room.beta_next);
        room.follows = (seen & height.gt(least) & next.dot(frame.z).gt(zero)).bits();
    }
}
