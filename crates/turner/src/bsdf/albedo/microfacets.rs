//! Albedo of single scattering by rough facets: the mean of F·G2/G1 over the facets visible from wo (see the VNDF in
//! `microfacet`), by quasi-Monte Carlo with a Fibonacci lattice.

use turner_bvh::InstructionSet;
use turner_bvh::lanes::{Block, F64x8, LANES, Mask8, Simd, Vec3x8, Work, dispatch};

use crate::bsdf::facets::{FacetDistribution, FacetKind, Facets};
use crate::bsdf::facets_x8::FacetBlock;
use crate::bsdf::fresnel;
use crate::bsdf::fresnel_x8::dielectric;
use crate::math::DVec3;
use crate::math::elementary::{ln, sin_cos_turns};
use crate::math::elementary_x8::clamp;

/// The interface at the facets.
#[derive(Clone, Copy, Debug)]
pub(super) enum Boundary {
    /// Reflects all light.
    Mirror,
    /// Index behind over index in front.
    Dielectric(f64),
}

/// Points of a Fibonacci lattice in the unit square, eight at a time: the first coordinate, cosine and sine of the
/// second one times 2π, and the weight, 0 in unused lanes.
pub(super) struct Lattice {
    points: Vec<[Block; 4]>,
    /// The same for other kinds of facets than [`FacetKind::PLAIN`]: both coordinates, the slopes of a facet of Beckmann's
    /// distribution with α = 1, and 1 in lanes that are used.
    others: Vec<[Block; 5]>,
    /// The best set of the machine: the sums are the same with any.
    set: InstructionSet,
}

impl Lattice {
    /// `n` and `before` are consecutive Fibonacci numbers.
    pub(super) fn new(n: u32, before: u32) -> Lattice {
        let count = f64::from(n);
        let mut blocks = vec![[Block::default(); 4]; (n as usize).div_ceil(LANES)];
        let mut others = vec![[Block::default(); 5]; blocks.len()];
        for i in 0..n {
            let turns = (u64::from(i) * u64::from(before) % u64::from(n)) as f64;
            let (sin, cos) = sin_cos_turns((turns + 0.5) / count);
            let u = [(f64::from(i) + 0.5) / count, (turns + 0.5) / count];
            let slope = (-ln(1.0 - u[0])).sqrt();
            let other = [u[0], u[1], slope * cos, slope * sin, 1.0];
            for (block, v) in others[i as usize / LANES].iter_mut().zip(other) {
                block.0[i as usize % LANES] = v;
            }
            let point = [(f64::from(i) + 0.5) / count, cos, sin, 1.0 / count];
            for (block, v) in blocks[i as usize / LANES].iter_mut().zip(point) {
                block.0[i as usize % LANES] = v;
            }
        }
        Lattice { points: blocks, others, set: InstructionSet::best() }
    }

    /// Fractions of light from `wo` (wo.z > 0) that one scattering reflects and transmits.
    pub(super) fn albedos(&self, facets: &Facets, wo: DVec3, boundary: Boundary) -> (f64, f64) {
        if facets.kind != FacetKind::PLAIN {
            return match facets.ax == facets.ay {
                true => dispatch(self.set, OtherScattering { lattice: self, facets, wo, boundary }),
                false => self.albedos_of_any(*facets, wo, boundary),
            };
        }
        dispatch(self.set, SingleScattering { lattice: self, facets, wo, boundary })
    }

    /// The same for all kinds of facets. Beckmann's are sampled among all normals and weighted by how much of them is
    /// visible, which is faster than among the visible ones.
    fn albedos_of_any(&self, facets: Facets, wo: DVec3, boundary: Boundary) -> (f64, f64) {
        let lo = facets.lambda(wo);
        let (mut reflected, mut transmitted, mut visible) = (0.0, 0.0, 0.0);
        let lanes = self.others.iter().flat_map(|block| (0..LANES).map(|lane| block.map(|v| v.0[lane])));
        for [u, v, x, y, _] in lanes.filter(|[.., used]| *used > 0.0) {
            let (h, weight) = match facets.kind.distribution {
                FacetDistribution::Ggx => (facets.sample_visible(wo, [u, v]), 1.0),
                FacetDistribution::Beckmann => {
                    let h = DVec3::new(facets.ax * x, facets.ay * y, 1.0);
                    (h.normalize(), wo.dot(h).max(0.0))
                }
            };
            if weight <= 0.0 {
                continue;
            }
            visible += weight;
            let mu = wo.dot(h).clamp(0.0, 1.0);
            let mut f = 1.0;
            if let Boundary::Dielectric(eta) = boundary
                && let Some(t) = fresnel::refracted_cosine(mu, eta)
            {
                f = fresnel::dielectric(mu, eta);
                let wi = h * (mu / eta - t) - wo * (1.0 / eta);
                if wi.z < 0.0 {
                    transmitted += (1.0 - f) * facets.g1(wi) * weight;
                }
            }
            let wi = h * (2.0 * mu) - wo;
            if wi.z > 0.0 {
                reflected += f * (1.0 + lo) / facets.masking(lo, facets.lambda(wi)) * weight;
            }
        }
        if visible > 0.0 { (reflected / visible, transmitted / visible) } else { (0.0, 0.0) }
    }
}

/// As [`Lattice::albedos_of_any`], for isotropic facets.
struct OtherScattering<'a> {
    lattice: &'a Lattice,
    facets: &'a Facets,
    wo: DVec3,
    boundary: Boundary,
}

impl Work for OtherScattering<'_> {
    type Output = (f64, f64);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> (f64, f64) {
        let splat = |v: f64| F64x8::splat(simd, v);
        let (zero, one, two) = (splat(0.0), splat(1.0), splat(2.0));
        let mut facets = FacetBlock::default();
        (0..LANES).for_each(|lane| facets.set(lane, self.facets));
        let beckmann = self.facets.kind.distribution == FacetDistribution::Beckmann;
        let (a, all) = (splat(self.facets.ax), Mask8::new(simd, u8::MAX));
        let (wo, lo) = (Vec3x8::splat(simd, self.wo.to_array()), splat(self.facets.lambda(self.wo)));
        let (mut reflected, mut transmitted, mut visible) = (zero, zero, zero);
        for point in &self.lattice.others {
            let [u, v, x, y, used] = point.each_ref().map(|block| F64x8::load(simd, block));
            let (h, weight) = if beckmann {
                let h = Vec3x8 { x: a * x, y: a * y, z: one };
                (h * (one / h.dot(h).sqrt()), wo.dot(h).or_larger(zero) * used)
            } else {
                (facets.sample_visible(simd, all, wo, [u, v]), used)
            };
            let seen = weight.gt(zero);
            visible = visible + weight;
            let mu = clamp(wo.dot(h), zero, one);
            let mut f = one;
            if let Boundary::Dielectric(eta) = self.boundary {
                let eta = splat(eta);
                f = dielectric(simd, mu, eta);
                let sin2 = (one - mu * mu).or_larger(zero) / (eta * eta);
                let t = (one - sin2).or_larger(zero).sqrt();
                let wi = h * (mu / eta - t) - wo * (one / eta);
                let through = seen & sin2.lt(one) & wi.z.lt(zero);
                let part = (one - f) / (one + facets.lambda(simd, wi)) * weight;
                transmitted = transmitted + through.select(part, zero);
            }
            let wi = h * (two * mu) - wo;
            let part = f * (one + lo) / facets.masking(simd, lo, facets.lambda(simd, wi)) * weight;
            reflected = reflected + (seen & wi.z.gt(zero)).select(part, zero);
        }
        let sum = |v: F64x8<S>| -> f64 {
            let mut block = Block::default();
            v.store(&mut block);
            block.0.iter().sum()
        };
        let visible = sum(visible);
        if visible > 0.0 { (sum(reflected) / visible, sum(transmitted) / visible) } else { (0.0, 0.0) }
    }
}

struct SingleScattering<'a> {
    lattice: &'a Lattice,
    facets: &'a Facets,
    wo: DVec3,
    boundary: Boundary,
}

impl Work for SingleScattering<'_> {
    type Output = (f64, f64);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> (f64, f64) {
        let splat = |v: f64| F64x8::splat(simd, v);
        let (zero, one, two) = (splat(0.0), splat(1.0), splat(2.0));
        let (ax, ay) = (splat(self.facets.ax), splat(self.facets.ay));
        let wo = Vec3x8::splat(simd, self.wo.to_array());
        let s = DVec3::new(self.facets.ax * self.wo.x, self.facets.ay * self.wo.y, self.wo.z).normalize();
        let stretched = Vec3x8::splat(simd, s.to_array());
        let eta = match self.boundary {
            Boundary::Mirror => None,
            Boundary::Dielectric(eta) => Some(splat(eta)),
        };
        let lo = splat(self.facets.lambda(self.wo));
        // cos θ √(1 + α² tan² θ), from which Λ is computed.
        let root = |w: Vec3x8<S>| {
            let (x, y) = (ax * w.x, ay * w.y);
            (w.z * w.z + x * x + y * y).sqrt()
        };
        let (mut reflected, mut transmitted) = (zero, zero);
        for [u, cos, sin, weight] in &self.lattice.points {
            let load = |block: &Block| F64x8::load(simd, block);
            let weight = load(weight);
            let z = (one - load(u)) * (one + stretched.z) - stretched.z;
            let r = (one - z * z).or_larger(zero).sqrt();
            let cap = Vec3x8 { x: r * load(cos), y: r * load(sin), z } + stretched;
            let h = Vec3x8 { x: ax * cap.x, y: ay * cap.y, z: cap.z.or_larger(splat(1e-300)) };
            let h = h * (one / h.dot(h).sqrt());
            let mu = wo.dot(h).or_larger(zero);
            let mu = mu.gt(one).select(one, mu);
            let mut f = one;
            if let Some(eta) = eta {
                let t2 = one - (one - mu * mu) / (eta * eta);
                let t = t2.or_larger(zero).sqrt();
                let (a, b) = (mu - eta * t, mu + eta * t);
                let (c, d) = (eta * mu - t, eta * mu + t);
                let (ad, cb, bd) = (a * d, c * b, b * d);
                let total = t2.le(splat(1e-14));
                f = total.select(one, (ad * ad + cb * cb) / (two * bd * bd));
                let wi = h * (mu / eta - t) - wo * (one / eta);
                let contribution = (one - f) * (-wi.z * two) / (root(wi) - wi.z);
                let through = wi.z.lt(splat(-1e-300));
                transmitted = transmitted + through.select(total.select(zero, contribution), zero) * weight;
            }
            let wi = h * (two * mu) - wo;
            let contribution = f * (one + lo) * two * wi.z / ((one + two * lo) * wi.z + root(wi));
            reflected = reflected + wi.z.gt(splat(1e-300)).select(contribution, zero) * weight;
        }
        let sum = |v: F64x8<S>| {
            let mut block = Block::default();
            v.store(&mut block);
            block.0.iter().sum()
        };
        (sum(reflected), sum(transmitted))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::facets::FacetMasking;

    #[test]
    fn lanes_and_scalar_code_agree() {
        let lattice = Lattice::new(2584, 1597);
        let mut kinds = Vec::new();
        for distribution in [FacetDistribution::Ggx, FacetDistribution::Beckmann] {
            for masking in [FacetMasking::Correlated, FacetMasking::Separable] {
                kinds.push(FacetKind { distribution, masking });
            }
        }
        for kind in kinds {
            for alpha in [1e-3, 0.1, 0.5, 1.0] {
                for z in [0.001, 0.02, 0.5, 1.0] {
                    let facets = Facets { ax: alpha, ay: alpha, kind };
                    let wo = DVec3::new((1.0f64 - z * z).sqrt(), 0.0, z);
                    for boundary in [Boundary::Mirror, Boundary::Dielectric(1.5), Boundary::Dielectric(0.6)] {
                        let scalar = lattice.albedos_of_any(facets, wo, boundary);
                        for set in InstructionSet::available() {
                            let work = OtherScattering { lattice: &lattice, facets: &facets, wo, boundary };
                            let lanes = dispatch(set, work);
                            let off = (lanes.0 - scalar.0).abs().max((lanes.1 - scalar.1).abs());
                            assert!(off < 1e-11, "{kind:?} {alpha} {z} {boundary:?}: {lanes:?} {scalar:?}");
                        }
                    }
                }
            }
        }
    }
}
