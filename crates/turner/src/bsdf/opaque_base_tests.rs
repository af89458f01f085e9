use turner_bvh::InstructionSet;
use turner_bvh::lanes::{Block32, LANES, Work, dispatch};

use super::*;
use crate::bsdf::{
    Bsdf, FacetDistribution, FacetMasking, MetalIndex, PrincipledPoint, Terminator, TerminatorX8,
};
use crate::color::Spectrum;
use crate::math::DVec3;
use crate::math::block::vector;
use crate::testing::Random;

/// The lanes with softened terminators.
const SOFT: u8 = 0b0110_1101;

struct All<'a> {
    block: &'a OpaqueBlock,
    wo: &'a [Block; 3],
    u: &'a [Block; 3],
    /// Geometric normals; the shading normals are +z.
    ng: &'a [Block; 3],
    /// wi, f, pdf; lanes with a sample, by delta lobes, by diffuse lobes.
    out: &'a mut Out,
}

#[derive(Default)]
struct Out {
    wi: [Block; 3],
    f: [Block32; 3],
    pdf: Block,
    masks: [u8; 3],
    evaluated: ([Block; 3], Block),
}

impl Work for All<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let wo = Vec3x8::load(simd, self.wo);
        let [a, b, c] = self.u;
        let u = [F64x8::load(simd, a), F64x8::load(simd, b), F64x8::load(simd, c)];
        let seen = self.block.towards(simd, wo);
        let up = Vec3x8::splat(simd, [0.0, 0.0, 1.0]);
        let terminator = TerminatorX8::new(simd, up, Vec3x8::load(simd, self.ng), Mask8::new(simd, SOFT));
        let s = self.block.sample(simd, wo, &seen, u, |wi| terminator.softening(simd, wi));
        s.wi.store(&mut self.out.wi);
        for (band, to) in s.f.into_iter().zip(&mut self.out.f) {
            band.store(to);
        }
        s.pdf.store(&mut self.out.pdf);
        self.out.masks = [s.valid.bits(), s.is_delta.bits(), s.is_diffuse.bits()];
        let softening = terminator.softening(simd, s.wi);
        let (f, pdf) = self.block.eval_pdf(simd, wo, &seen, s.wi, softening);
        f.store(&mut self.out.evaluated.0);
        pdf.store(&mut self.out.evaluated.1);
    }
}

/// Bases of all kinds: metal and not, smooth and rough, tinted, of any index, some of them mixed.
fn point(random: &mut Random) -> PrincipledPoint {
    let [kind, r, g, b] = random.units::<4>();
    let [tint_r, tint_g, tint_b, roughness] = random.units::<4>();
    let [ior, weight, share, side] = random.units::<4>();
    let color = |r: f64, g: f64, b: f64| Spectrum::new(r as f32, g as f32, b as f32);
    let plain = tint_b < 0.7 && g < 0.5;
    PrincipledPoint {
        base_color: color(r, g, b),
        base_weight: if kind < 0.1 { 0.0 } else { 1.0 },
        metal_index: ((10.0 * kind).fract() < 0.4)
            .then(|| MetalIndex::new(color(3.0 * r, g, 2.0 * b), color(g, 8.0 * b, r))),
        base_metalness: if kind < 0.5 { 0.0 } else { (2.0 * share).min(1.0) },
        specular_color: match tint_r {
            r if r < 0.5 => Spectrum::WHITE,
            r if r < 0.7 => color(r, 30.0 * tint_g, tint_b),
            r => color(r, tint_g, tint_b),
        },
        gltf_specular: tint_b < 0.4,
        // Tables of other facets than the usual ones take long.
        specular_roughness: match roughness {
            r if r < 0.2 => 0.0,
            r if plain => r,
            r => (4.0 * r).ceil() / 4.0,
        },
        specular_ior: if ior < 0.1 {
            0.0
        } else if plain {
            1.0 + ior
        } else {
            1.0 + (3.0 * ior).ceil() / 3.0
        },
        specular_weight: if weight < 0.5 { 1.0 } else { 3.0 * weight - 1.5 },
        specular_multiple_scattering: tint_g < 0.6,
        specular_distribution: if tint_b < 0.7 {
            FacetDistribution::Ggx
        } else {
            FacetDistribution::Beckmann
        },
        specular_masking: if g < 0.5 { FacetMasking::Correlated } else { FacetMasking::Separable },
        entering: side < 0.7,
        ..PrincipledPoint::default()
    }
}

#[test]
fn eight_lanes_equal_scalar() {
    let mut random = Random::new(4);
    let (mut seen, mut deltas, mut again) = (0, 0, 0);
    // One block, so that lanes are used again for other bases.
    let mut block = OpaqueBlock::default();
    for round in 0..1500 {
        let bsdfs: [Bsdf<'_>; LANES] = std::array::from_fn(|_| {
            loop {
                let mut point = point(&mut random);
                if round % 3 == 0 {
                    point.base_metalness = f64::from(u8::from(round % 2 == 0));
                }
                let bsdf = Bsdf::new(&point);
                if bsdf.as_opaque_base().is_some() {
                    return bsdf;
                }
            }
        });
        let (mut wo, mut u, mut ng) = ([Block::default(); 3], [Block::default(); 3], [Block::default(); 3]);
        for (lane, bsdf) in bsdfs.iter().enumerate() {
            block.set(lane, &bsdf.as_opaque_base().unwrap());
            let [x, y, z, _] = random.units::<4>();
            set_vector(&mut wo, lane, DVec3::new(2.0 * x - 1.0, 2.0 * y - 1.0, z * z + 1e-6).normalize());
            [u[0].0[lane], u[1].0[lane], u[2].0[lane], _] = random.units::<4>();
            set_vector(&mut ng, lane, (DVec3::Z + random.direction() * 0.9).normalize());
        }
        for instructions in InstructionSet::available() {
            let mut out = Out::default();
            dispatch(instructions, All { block: &block, wo: &wo, u: &u, ng: &ng, out: &mut out });
            for (lane, bsdf) in bsdfs.iter().enumerate() {
                let is = |i: usize| out.masks[i] >> lane & 1 == 1;
                let wi = vector(&out.wi, lane);
                let mut scalar = bsdf.towards(vector(&wo, lane));
                if SOFT >> lane & 1 == 1 {
                    scalar = scalar.softened(Terminator::new(DVec3::Z, vector(&ng, lane)));
                }
                let sample = scalar.sample([u[0].0[lane], u[1].0[lane], u[2].0[lane]]);
                assert_eq!(sample.is_some(), is(0), "{bsdf:?}");
                if wi.z > MIN_COSINE {
                    let f = crate::bsdf::spectrum(vector(&out.evaluated.0, lane));
                    let wide = (f, out.evaluated.1.0[lane]);
                    assert_eq!(scalar.eval_pdf(wi), wide, "{bsdf:?}");
                }
                let Some(s) = sample else { continue };
                let [r, g, b] = &out.f;
                let f = Spectrum::new(r.0[lane], g.0[lane], b.0[lane]);
                assert_eq!((s.wi, s.f, s.pdf), (wi, f, out.pdf.0[lane]), "{bsdf:?}");
                assert_eq!((s.lobe.is_delta, s.lobe.is_diffuse), (is(1), is(2)), "{bsdf:?}");
                seen += 1;
                deltas += usize::from(is(1));
                again += usize::from(is(2) && bsdf.interface.as_ref().is_some_and(|i| i.metal == 1.0));
            }
        }
    }
    assert!(seen > 20_000 && deltas > 1000 && again > 100, "{seen}, {deltas}, {again}");
}

#[test]
fn layered_and_other_bsdfs_are_none() {
    let base = PrincipledPoint::default();
    let is_base = |p: PrincipledPoint| Bsdf::new(&p).as_opaque_base().is_some();
    assert!(is_base(base) && is_base(PrincipledPoint { base_metalness: 1.0, ..base }));
    // As scenes of Mitsuba and pbrt have them.
    let single = PrincipledPoint { specular_multiple_scattering: false, ..base };
    let separable = PrincipledPoint { specular_masking: FacetMasking::Separable, ..single };
    assert!(is_base(single) && is_base(separable));
    assert!(is_base(PrincipledPoint { specular_distribution: FacetDistribution::Beckmann, ..separable }));
    let others = [
        PrincipledPoint { coat_weight: 0.5, ..base },
        PrincipledPoint { fuzz_weight: 0.5, ..base },
        PrincipledPoint { transmission_weight: 0.5, ..base },
        PrincipledPoint { thin_film_weight: 0.5, ..base },
        PrincipledPoint { base_diffuse_roughness: 0.5, ..base },
        PrincipledPoint { specular_roughness_anisotropy: 0.5, ..base },
        PrincipledPoint { thin_walled: true, subsurface_weight: 0.5, ..base },
        PrincipledPoint { subsurface_walk: true, subsurface_weight: 0.5, ..base },
        PrincipledPoint { specular_weight: 0.0, ..base },
    ];
    for other in others {
        assert!(!is_base(other), "{other:?}");
    }
}
