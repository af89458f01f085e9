//! The BSDFs of eight points at a time: a common interface, and Lambertian reflection.

use std::f64::consts::PI;

use turner_bvh::lanes::{Block32, F32x8, F64x8, Mask8, Simd, Vec3x8};

use super::mixture::MIN_COSINE;
use super::opaque_base::{OpaqueBlock, OpaqueSeen};
use crate::color::Spectrum;
use crate::math::elementary_x8::sin_cos_turns;

/// Colours, one register per band.
pub(crate) type Bands<S> = [F32x8<S>; 3];

/// Eight sampled directions, as [`BsdfSample`](super::BsdfSample).
pub(crate) struct Sampled<S: Simd> {
    /// Local directions that light comes from.
    pub(crate) wi: Vec3x8<S>,
    /// The BRDFs, without the cosine.
    pub(crate) f: Bands<S>,
    /// Densities of `wi` per solid angle; of delta lobes their probabilities.
    pub(crate) pdf: F64x8<S>,
    /// Lanes with a sample, by a delta lobe, by a diffuse lobe.
    pub(crate) valid: Mask8<S>,
    pub(crate) is_delta: Mask8<S>,
    pub(crate) is_diffuse: Mask8<S>,
}

/// The BSDFs of eight points, which only reflect light.
pub(crate) trait BsdfBlock: Default {
    /// What depends on wo alone.
    type Seen<S: Simd>: Copy;

    /// The BRDF of a lane, if it is Lambertian.
    fn lambert(&self, _: usize) -> Option<Spectrum> {
        None
    }

    /// The opaque bases, if these are such.
    fn opaque(&self) -> Option<&OpaqueBlock> {
        None
    }

    /// The BSDFs seen from `wo`.
    fn towards<S: Simd>(&self, simd: S, wo: Vec3x8<S>) -> Self::Seen<S>;

    /// The BRDF and the density of directions above the surface. `softening` is the factor of diffuse reflection at
    /// shadow terminators.
    fn eval_pdf<S: Simd>(
        &self,
        simd: S,
        wo: Vec3x8<S>,
        seen: &Self::Seen<S>,
        wi: Vec3x8<S>,
        softening: F64x8<S>,
    ) -> (Bands<S>, F64x8<S>);

    /// Samples a direction per lane from three random numbers. `softening` is as for `eval_pdf`, by direction.
    fn sample<S: Simd>(
        &self,
        simd: S,
        wo: Vec3x8<S>,
        seen: &Self::Seen<S>,
        u: [F64x8<S>; 3],
        softening: impl Fn(Vec3x8<S>) -> F64x8<S>,
    ) -> Sampled<S>;
}

/// Eight Lambertian BRDFs.
#[derive(Default)]
pub(crate) struct LambertBlock {
    f: [Block32; 3],
}

impl LambertBlock {
    /// Stores a BRDF in a lane.
    #[inline]
    pub(crate) fn set(&mut self, lane: usize, f: Spectrum) {
        for (block, v) in self.f.iter_mut().zip(f.to_array()) {
            block.0[lane] = v;
        }
    }
}

impl BsdfBlock for LambertBlock {
    type Seen<S: Simd> = ();

    #[inline]
    fn lambert(&self, lane: usize) -> Option<Spectrum> {
        let [r, g, b] = &self.f;
        Some(Spectrum::new(r.0[lane], g.0[lane], b.0[lane]))
    }

    #[inline(always)]
    fn towards<S: Simd>(&self, _: S, _: Vec3x8<S>) {}

    #[inline(always)]
    fn eval_pdf<S: Simd>(
        &self,
        simd: S,
        _: Vec3x8<S>,
        (): &(),
        wi: Vec3x8<S>,
        softening: F64x8<S>,
    ) -> (Bands<S>, F64x8<S>) {
        let [r, g, b] = &self.f;
        let softening = softening.narrow();
        let f = [r, g, b].map(|band| F32x8::load(simd, band) * softening);
        (f, wi.z / F64x8::splat(simd, PI))
    }

    #[inline(always)]
    fn sample<S: Simd>(
        &self,
        simd: S,
        wo: Vec3x8<S>,
        (): &(),
        [_, u0, u1]: [F64x8<S>; 3],
        softening: impl Fn(Vec3x8<S>) -> F64x8<S>,
    ) -> Sampled<S> {
        let wi = cosine(simd, [u0, u1]);
        let (f, pdf) = self.eval_pdf(simd, wo, &(), wi, softening(wi));
        let (zero, least) = (F64x8::splat(simd, 0.0), F64x8::splat(simd, MIN_COSINE));
        let valid_pdf = pdf.gt(zero) & pdf.lt(F64x8::splat(simd, f64::INFINITY));
        let valid = wo.z.gt(least) & wi.z.gt(least) & valid_pdf;
        let (all, none) = (Mask8::new(simd, u8::MAX), Mask8::new(simd, 0));
        Sampled { wi, f, pdf, valid, is_delta: none, is_diffuse: all }
    }
}

impl BsdfBlock for OpaqueBlock {
    type Seen<S: Simd> = OpaqueSeen<S>;

    fn opaque(&self) -> Option<&OpaqueBlock> {
        Some(self)
    }

    #[inline(always)]
    fn towards<S: Simd>(&self, simd: S, wo: Vec3x8<S>) -> OpaqueSeen<S> {
        OpaqueBlock::towards(self, simd, wo)
    }

    #[inline(always)]
    fn eval_pdf<S: Simd>(
        &self,
        simd: S,
        wo: Vec3x8<S>,
        seen: &OpaqueSeen<S>,
        wi: Vec3x8<S>,
        softening: F64x8<S>,
    ) -> (Bands<S>, F64x8<S>) {
        let (f, pdf) = OpaqueBlock::eval_pdf(self, simd, wo, seen, wi, softening);
        ([f.x.narrow(), f.y.narrow(), f.z.narrow()], pdf)
    }

    #[inline(always)]
    fn sample<S: Simd>(
        &self,
        simd: S,
        wo: Vec3x8<S>,
        seen: &OpaqueSeen<S>,
        u: [F64x8<S>; 3],
        softening: impl Fn(Vec3x8<S>) -> F64x8<S>,
    ) -> Sampled<S> {
        OpaqueBlock::sample(self, simd, wo, seen, u, softening)
    }
}

/// As [`sample_cosine`](super::sample_cosine).
#[inline(always)]
pub(super) fn cosine<S: Simd>(simd: S, [r2, turns]: [F64x8<S>; 2]) -> Vec3x8<S> {
    let (sin, cos) = sin_cos_turns(simd, turns);
    let r = r2.sqrt();
    let height = (F64x8::splat(simd, 1.0) - r2).or_larger(F64x8::splat(simd, 0.0)).sqrt();
    Vec3x8 { x: r * cos, y: r * sin, z: height }
}
