//! Rough mirrors, eight at a time: GGX microfacets whose reflectance does not depend on the angle, without any other
//! lobe.
//!
//! The results equal those of the scalar [`Bsdf`](super::Bsdf) to the last bit.

use std::f64::consts::PI;

use turner_bvh::lanes::{Block, F64x8, Mask8, Simd, Vec3x8};

use super::Rgb;
use super::microfacet::Ggx;
use crate::math::elementary_x8::sin_cos_turns;

/// A BSDF that is only a rough mirror.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughMirror {
    pub(super) ggx: Ggx,
    pub(super) color: Rgb,
    /// Probability of its lobe, 1 up to rounding.
    pub(super) probability: f64,
}

/// Eight rough mirrors, one per lane.
#[derive(Clone, Debug, Default)]
pub struct RoughMirrorBlock {
    alpha: [Block; 2],
    color: [Block; 3],
    probability: Block,
}

impl RoughMirrorBlock {
    /// Stores a mirror in a lane.
    #[inline]
    pub fn set(&mut self, lane: usize, m: &RoughMirror) {
        (self.alpha[0].0[lane], self.alpha[1].0[lane]) = (m.ggx.ax, m.ggx.ay);
        for (block, v) in self.color.iter_mut().zip(m.color.to_array()) {
            block.0[lane] = v;
        }
        self.probability.0[lane] = m.probability;
    }

    #[inline(always)]
    fn alpha<S: Simd>(&self, simd: S) -> [F64x8<S>; 2] {
        [F64x8::load(simd, &self.alpha[0]), F64x8::load(simd, &self.alpha[1])]
    }

    /// BRDF and density of `wi`; both directions above the surface.
    #[inline(always)]
    pub fn eval_pdf<S: Simd>(&self, simd: S, wo: Vec3x8<S>, wi: Vec3x8<S>) -> (Vec3x8<S>, F64x8<S>) {
        let [ax, ay] = self.alpha(simd);
        let splat = |v: f64| F64x8::splat(simd, v);
        let (one, four) = (splat(1.0), splat(4.0));
        let h = wo + wi;
        let h = h * (one / h.dot(h).sqrt());
        let (x, y) = (h.x / ax, h.y / ay);
        let s = x * x + y * y + h.z * h.z;
        let d = one / (splat(PI) * ax * ay * s * s);
        let (lo, li) = (lambda(simd, ax, ay, wo), lambda(simd, ax, ay, wi));
        let f = Vec3x8::load(simd, &self.color) * (d / ((one + lo + li) * four * wo.z * wi.z));
        let density = d / ((one + lo) * four * wo.z);
        (f, F64x8::load(simd, &self.probability) * density)
    }

    /// Samples a facet visible from `wo` and returns the reflected direction.
    #[inline(always)]
    pub fn sample<S: Simd>(&self, simd: S, wo: Vec3x8<S>, u: [F64x8<S>; 2]) -> Vec3x8<S> {
        let [ax, ay] = self.alpha(simd);
        let splat = |v: f64| F64x8::splat(simd, v);
        let (zero, one, two) = (splat(0.0), splat(1.0), splat(2.0));
        let stretched = Vec3x8 { x: ax * wo.x, y: ay * wo.y, z: wo.z };
        let stretched = stretched * (one / stretched.dot(stretched).sqrt());
        let z = (one - u[0]) * (one + stretched.z) - stretched.z;
        let r = (one - z * z).or_larger(zero).sqrt();
        let (sin, cos) = sin_cos_turns(simd, u[1]);
        let cap = Vec3x8 { x: r * cos, y: r * sin, z } + stretched;
        let h = Vec3x8 { x: ax * cap.x, y: ay * cap.y, z: cap.z.or_larger(zero) };
        let length = h.dot(h).sqrt();
        let non_zero: Mask8<S> = length.gt(zero);
        let up = Vec3x8::splat(simd, [0.0, 0.0, 1.0]);
        let h = Vec3x8::select(non_zero, Vec3x8 { x: h.x / length, y: h.y / length, z: h.z / length }, up);
        let d = -wo;
        d - h * (two * d.dot(h))
    }
}

/// See [`Ggx::lambda`].
#[inline(always)]
fn lambda<S: Simd>(simd: S, ax: F64x8<S>, ay: F64x8<S>, w: Vec3x8<S>) -> F64x8<S> {
    let (x, y) = (ax * w.x, ay * w.y);
    let t2 = (x * x + y * y) / (w.z * w.z);
    let one = F64x8::splat(simd, 1.0);
    F64x8::splat(simd, 0.5) * ((one + t2).sqrt() - one)
}

#[cfg(test)]
mod tests {
    use turner_bvh::InstructionSet;
    use turner_bvh::lanes::{LANES, Work, dispatch};

    use super::*;
    use crate::bsdf::{Bsdf, PrincipledPoint};
    use crate::color::Spectrum;
    use crate::math::DVec3;
    use crate::testing::Random;

    struct All<'a> {
        mirrors: &'a RoughMirrorBlock,
        wo: &'a [Block; 3],
        u: &'a [Block; 2],
        /// wi, f, pdf.
        out: &'a mut ([Block; 3], [Block; 3], Block),
    }

    impl Work for All<'_> {
        type Output = ();
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) {
            let wo = Vec3x8::load(simd, self.wo);
            let u = [F64x8::load(simd, &self.u[0]), F64x8::load(simd, &self.u[1])];
            let wi = self.mirrors.sample(simd, wo, u);
            let (f, pdf) = self.mirrors.eval_pdf(simd, wo, wi);
            wi.store(&mut self.out.0);
            f.store(&mut self.out.1);
            pdf.store(&mut self.out.2);
        }
    }

    #[test]
    fn eight_lanes_equal_scalar() {
        let mut random = Random::new(4);
        let mut seen = 0;
        for _ in 0..500 {
            let bsdfs: [Bsdf; LANES] = std::array::from_fn(|_| {
                let [a, b, c, r] = random.units::<4>();
                Bsdf::new(&PrincipledPoint {
                    base_weight: 0.0,
                    specular_ior: 0.0,
                    specular_color: Spectrum::new(a as f32, b as f32, c as f32),
                    specular_roughness: 0.05 + 0.95 * r,
                    ..PrincipledPoint::default()
                })
            });
            let (mut mirrors, mut wo, mut u) =
                (RoughMirrorBlock::default(), [Block::default(); 3], [Block::default(); 2]);
            for (lane, bsdf) in bsdfs.iter().enumerate() {
                mirrors.set(lane, &bsdf.as_rough_mirror().unwrap());
                let [x, y, z, _] = random.units::<4>();
                let w = DVec3::new(2.0 * x - 1.0, 2.0 * y - 1.0, z * z + 1e-6).normalize();
                for (block, v) in wo.iter_mut().zip(w.to_array()) {
                    block.0[lane] = v;
                }
                [u[0].0[lane], u[1].0[lane]] = random.units::<2>();
            }
            for set in InstructionSet::available() {
                let mut out = ([Block::default(); 3], [Block::default(); 3], Block::default());
                dispatch(set, All { mirrors: &mirrors, wo: &wo, u: &u, out: &mut out });
                for (lane, bsdf) in bsdfs.iter().enumerate() {
                    let vector = |v: &[Block; 3]| DVec3::new(v[0].0[lane], v[1].0[lane], v[2].0[lane]);
                    let (wi, f, pdf) = (vector(&out.0), vector(&out.1), out.2.0[lane]);
                    let chosen = [0.5, u[0].0[lane], u[1].0[lane]];
                    let Some(s) = bsdf.sample(vector(&wo), chosen) else {
                        assert!(wi.z <= 1e-7);
                        continue;
                    };
                    let f = Spectrum::new(f.x as f32, f.y as f32, f.z as f32);
                    assert_eq!((s.wi, s.f, s.pdf), (wi, f, pdf));
                    assert_eq!(bsdf.eval_pdf(vector(&wo), wi), (f, pdf));
                    seen += 1;
                }
            }
        }
        assert!(seen > 3000, "{seen}");
    }

    #[test]
    fn others_are_none() {
        let mirror = PrincipledPoint {
            base_weight: 0.0,
            specular_ior: 0.0,
            specular_roughness: 0.3,
            ..PrincipledPoint::default()
        };
        assert!(Bsdf::new(&mirror).as_rough_mirror().is_some());
        let others = [
            PrincipledPoint { specular_roughness: 0.0, ..mirror },
            PrincipledPoint { specular_ior: 1.5, ..mirror },
            PrincipledPoint { coat_weight: 0.5, ..mirror },
            PrincipledPoint { fuzz_weight: 0.5, ..mirror },
            PrincipledPoint { transmission_weight: 0.5, ..mirror },
            PrincipledPoint { base_metalness: 0.5, ..mirror },
            PrincipledPoint { specular_color: Spectrum::BLACK, ..mirror },
        ];
        for other in &others {
            assert!(Bsdf::new(other).as_rough_mirror().is_none(), "{other:?}");
        }
    }
}
