//! Direct light and next directions at eight vertices.

use std::f64::consts::PI;

use turner_bvh::lanes::{Block32, F32x8, F64x8, Mask8, Simd, Vec3x8, Work};

use super::{Lambert, Shading, VertexBlock};
use crate::bsdf::{Lobe, MIN_COSINE, RoughMirrorBlock};
use crate::color::Spectrum;
use crate::math::elementary_x8::sin_cos_turns;
use crate::math::frame_x8::FrameX8;

/// Colours, one register per band.
type Bands<S> = [F32x8<S>; 3];

/// The BSDFs of eight vertices with one non-delta reflection lobe each.
pub(super) trait Kind: Default {
    /// The lobe that is sampled.
    const LOBE: Lobe;

    /// The BRDF of a lane, if it is Lambertian.
    fn lambert(&self, _: usize) -> Option<Spectrum> {
        None
    }

    /// The BRDF and the density of directions above the surface.
    fn eval_pdf<S: Simd>(&self, simd: S, wo: Vec3x8<S>, wi: Vec3x8<S>) -> (Bands<S>, F64x8<S>);

    /// Samples a direction per lane from two random numbers; some may lie below the surface.
    fn sample<S: Simd>(&self, simd: S, wo: Vec3x8<S>, u: [F64x8<S>; 2]) -> Vec3x8<S>;
}

impl Kind for Lambert {
    const LOBE: Lobe = Lobe { is_delta: false, is_transmission: false, is_diffuse: true };

    #[inline]
    fn lambert(&self, lane: usize) -> Option<Spectrum> {
        Some(super::get32(&self.f, lane))
    }

    #[inline(always)]
    fn eval_pdf<S: Simd>(&self, simd: S, _: Vec3x8<S>, wi: Vec3x8<S>) -> (Bands<S>, F64x8<S>) {
        (load(simd, &self.f), wi.z / F64x8::splat(simd, PI))
    }

    #[inline(always)]
    fn sample<S: Simd>(&self, simd: S, _: Vec3x8<S>, [r2, turns]: [F64x8<S>; 2]) -> Vec3x8<S> {
        let (sin, cos) = sin_cos_turns(simd, turns);
        let r = r2.sqrt();
        let height = (F64x8::splat(simd, 1.0) - r2).or_larger(F64x8::splat(simd, 0.0)).sqrt();
        Vec3x8 { x: r * cos, y: r * sin, z: height }
    }
}

impl Kind for RoughMirrorBlock {
    const LOBE: Lobe = Lobe { is_delta: false, is_transmission: false, is_diffuse: false };

    #[inline(always)]
    fn eval_pdf<S: Simd>(&self, simd: S, wo: Vec3x8<S>, wi: Vec3x8<S>) -> (Bands<S>, F64x8<S>) {
        let (f, pdf) = RoughMirrorBlock::eval_pdf(self, simd, wo, wi);
        ([f.x.narrow(), f.y.narrow(), f.z.narrow()], pdf)
    }

    #[inline(always)]
    fn sample<S: Simd>(&self, simd: S, wo: Vec3x8<S>, u: [F64x8<S>; 2]) -> Vec3x8<S> {
        RoughMirrorBlock::sample(self, simd, wo, u)
    }
}

/// Eight surfaces as the rays see them.
struct SurfaceBlock<S: Simd> {
    p: Vec3x8<S>,
    /// Origins of next rays.
    origin: Vec3x8<S>,
    frame: FrameX8<S>,
    /// In the local frame.
    wo: Vec3x8<S>,
    /// Lanes that are not hit at grazing angles.
    front: Mask8<S>,
}

impl<S: Simd> SurfaceBlock<S> {
    #[inline(always)]
    fn new<K>(simd: S, block: &VertexBlock<K>) -> SurfaceBlock<S> {
        let splat = |v: f64| F64x8::splat(simd, v);
        let (p, error, ng) = block.flat_triangles.lanes(simd);
        let direction = Vec3x8::load(simd, &block.direction);
        let outside = direction.dot(ng).lt(splat(0.0));
        let frame = FrameX8::from_z(simd, ng).turned_unless(outside);
        let wo = frame.to_local(-direction);
        // All rays leave on the side of the frame's z axis.
        let side = outside.select(splat(4.0), splat(-4.0));
        SurfaceBlock { p, origin: p + ng * (side * error), frame, wo, front: wo.z.gt(splat(MIN_COSINE)) }
    }

    /// Unshadowed contributions of the sampled lights.
    #[inline(always)]
    fn light<K: Kind>(&self, simd: S, kind: &K, shading: &mut Shading) {
        let splat = |v: f64| F64x8::splat(simd, v);
        let (one, min_cos) = (splat(1.0), splat(MIN_COSINE));
        let to_light = Vec3x8::load(simd, &shading.to_light);
        let distance = to_light.dot(to_light).sqrt();
        let wi = Vec3x8 { x: to_light.x / distance, y: to_light.y / distance, z: to_light.z / distance };
        let local = self.frame.to_local(wi);
        let (f, pdf) = kind.eval_pdf(simd, self.wo, local);
        let light_pdf = F64x8::load(simd, &shading.light_pdf);
        let r = pdf / light_pdf;
        let weight = Mask8::new(simd, shading.weighed).select(one / (one + r * r), one);
        let k = (weight * local.z / light_pdf).narrow();
        let light = mul(mul(mul(load(simd, &shading.beta), f), load(simd, &shading.radiance)), [k, k, k]);
        let resampling_weight = F32x8::load(simd, &shading.resampling_weight);
        let light = mul(light, [resampling_weight, resampling_weight, resampling_weight]);
        let lit =
            (self.front & local.z.gt(min_cos)).and_not(is_black(simd, f)).and_not(is_black(simd, light));
        shading.connects = lit.bits() & shading.lit;
        store(light, &mut shading.light);
        let finite = Mask8::new(simd, shading.finite);
        Vec3x8::select(finite, self.p + to_light - self.origin, wi).store(&mut shading.shadow);
    }
}

/// Computes only the contributions of the sampled lights.
pub(super) struct Light<'a, K> {
    pub(super) block: &'a VertexBlock<K>,
    pub(super) shading: &'a mut Shading,
}

impl<K: Kind> Work for Light<'_, K> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Light { block, shading } = self;
        SurfaceBlock::new(simd, block).light(simd, &block.kind, shading);
    }
}

/// Shades a block with the operations of `PathBatch::scatter` and its callees, for a frame around the geometric normal.
pub(super) struct Shade<'a, K> {
    pub(super) block: &'a VertexBlock<K>,
    pub(super) shading: &'a mut Shading,
}

impl<K: Kind> Work for Shade<'_, K> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Shade { block, shading } = self;
        let splat = |v: f64| F64x8::splat(simd, v);
        let (zero, min_cos) = (splat(0.0), splat(MIN_COSINE));
        let seen = SurfaceBlock::new(simd, block);
        seen.origin.store(&mut shading.origin);
        seen.light(simd, &block.kind, shading);
        let SurfaceBlock { frame, wo, front, .. } = seen;
        let beta = load(simd, &shading.beta);
        let u = [F64x8::load(simd, &shading.u[0]), F64x8::load(simd, &shading.u[1])];
        let local = block.kind.sample(simd, wo, u);
        let (f, pdf) = block.kind.eval_pdf(simd, wo, local);
        let next = frame.to_world(local);
        next.store(&mut shading.next);
        pdf.store(&mut shading.pdf);
        let k = (local.z / pdf).narrow();
        store(mul(mul(beta, f), [k, k, k]), &mut shading.beta_next);
        let valid_pdf = pdf.gt(zero) & pdf.lt(splat(f64::INFINITY));
        shading.follows = (front & local.z.gt(min_cos) & valid_pdf & next.dot(frame.z).gt(zero)).bits();
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, [r, g, b]: &[Block32; 3]) -> Bands<S> {
    [F32x8::load(simd, r), F32x8::load(simd, g), F32x8::load(simd, b)]
}

#[inline(always)]
fn mul<S: Simd>([a, b, c]: Bands<S>, [x, y, z]: Bands<S>) -> Bands<S> {
    [a * x, b * y, c * z]
}

#[inline(always)]
fn is_black<S: Simd>(simd: S, [r, g, b]: Bands<S>) -> Mask8<S> {
    let none = F32x8::splat(simd, 0.0);
    r.eq(none) & g.eq(none) & b.eq(none)
}

#[inline(always)]
fn store<S: Simd>([r, g, b]: Bands<S>, to: &mut [Block32; 3]) {
    r.store(&mut to[0]);
    g.store(&mut to[1]);
    b.store(&mut to[2]);
}
