//! Direct light and next directions at eight vertices.

use turner_bvh::lanes::{Block32, F32x8, F64x8, Mask8, Simd, Vec3x8, Work};

use super::{Shading, VertexBlock};
use crate::bsdf::{Bands, BsdfBlock, MIN_COSINE, Sampled, TerminatorX8};
use crate::scene::SurfaceX8;

/// Eight vertices as the rays see them.
struct Seen<S: Simd, K: BsdfBlock> {
    surface: SurfaceX8<S>,
    /// Towards the rays' origins, in the local frames.
    wo: Vec3x8<S>,
    bsdf: K::Seen<S>,
    terminator: TerminatorX8<S>,
    /// Lanes that are not hit at grazing angles.
    front: Mask8<S>,
}

impl<S: Simd, K: BsdfBlock> Seen<S, K> {
    #[inline(always)]
    fn new(simd: S, block: &VertexBlock<K>) -> Seen<S, K> {
        let surface = block.surfaces.lanes(simd);
        let wo = surface.frame.to_local(surface.wo);
        let bsdf = block.kind.towards(simd, wo);
        let front = wo.z.gt(F64x8::splat(simd, MIN_COSINE));
        Seen { surface, wo, bsdf, terminator: surface.terminator(simd), front }
    }

    /// Unshadowed contributions of the sampled lights.
    #[inline(always)]
    fn light(&self, simd: S, kind: &K, shading: &mut Shading) {
        let splat = |v: f64| F64x8::splat(simd, v);
        let (one, min_cos) = (splat(1.0), splat(MIN_COSINE));
        let to_light = Vec3x8::load(simd, &shading.to_light);
        let distance = to_light.dot(to_light).sqrt();
        let wi = Vec3x8 { x: to_light.x / distance, y: to_light.y / distance, z: to_light.z / distance };
        let local = self.surface.frame.to_local(wi);
        let softening = self.terminator.softening(simd, local);
        if shading.second != 0 {
            local.store(&mut shading.local[0]);
            softening.store(&mut shading.softening[0]);
        }
        let (f, pdf) = kind.eval_pdf(simd, self.wo, &self.bsdf, local, softening);
        let light_pdf = F64x8::load(simd, &shading.light_pdf);
        let r = pdf / light_pdf;
        let weight = Mask8::new(simd, shading.weighed).select(one / (one + r * r), one);
        let k = (weight * local.z / light_pdf).narrow();
        let light = mul(mul(mul(load(simd, &shading.beta), f), load(simd, &shading.radiance)), [k, k, k]);
        let resampling_weight = F32x8::load(simd, &shading.resampling_weight);
        let light = mul(light, [resampling_weight, resampling_weight, resampling_weight]);
        let reflects = self.surface.reflects(simd, wi, self.front & local.z.gt(min_cos));
        let lit = reflects.and_not(is_black(simd, f)).and_not(is_black(simd, light));
        shading.connects = lit.bits() & shading.lit;
        store(light, &mut shading.light);
        let finite = Mask8::new(simd, shading.finite);
        let origin = self.surface.leave(simd, wi);
        origin.store(&mut shading.shadow_origin);
        Vec3x8::select(finite, self.surface.p + to_light - origin, wi).store(&mut shading.shadow);
    }
}

/// Computes only the contributions of the sampled lights.
pub(super) struct Light<'a, K> {
    pub(super) block: &'a VertexBlock<K>,
    pub(super) shading: &'a mut Shading,
}

impl<K: BsdfBlock> Work for Light<'_, K> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Light { block, shading } = self;
        Seen::new(simd, block).light(simd, &block.kind, shading);
    }
}

/// Shades a block with the operations of `PathBatch::scatter` and its callees.
pub(super) struct Shade<'a, K> {
    pub(super) block: &'a VertexBlock<K>,
    pub(super) shading: &'a mut Shading,
}

impl<K: BsdfBlock> Work for Shade<'_, K> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Shade { block, shading } = self;
        let seen = Seen::new(simd, block);
        if shading.lit == 0 {
            shading.connects = 0;
        } else {
            seen.light(simd, &block.kind, shading);
        }
        let Seen { surface, wo, bsdf, terminator, front } = seen;
        let [u0, u1, u2] = &shading.u;
        let u = [F64x8::load(simd, u0), F64x8::load(simd, u1), F64x8::load(simd, u2)];
        let Sampled { wi: local, f, pdf, valid, is_delta, is_diffuse } =
            block.kind.sample(simd, wo, &bsdf, u, |wi| terminator.softening(simd, wi));
        let next = surface.frame.to_world(local);
        surface.leave(simd, next).store(&mut shading.origin);
        next.store(&mut shading.next);
        pdf.store(&mut shading.pdf);
        let k = (local.z / pdf).narrow();
        store(mul(mul(load(simd, &shading.beta), f), [k, k, k]), &mut shading.beta_next);
        if shading.second != 0 {
            local.store(&mut shading.local[1]);
            terminator.softening(simd, local).store(&mut shading.softening[1]);
            store(f, &mut shading.f_next);
            k.store(&mut shading.k_next);
        }
        shading.delta = is_delta.bits();
        shading.diffuse = is_diffuse.bits();
        let above = front & valid & local.z.gt(F64x8::splat(simd, 0.0));
        shading.follows = surface.reflects(simd, next, above).bits();
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
