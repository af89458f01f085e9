//! The opaque base of OpenPBR, eight at a time: metal, or diffuse reflection under a dielectric interface, without coat,
//! fuzz, film, transmission or subsurface scattering, isotropic.
//!
//! ```text
//!    wo    n    wi       interface        facets: metal's and dielectric Fresnel, one lobe, or a delta lobe
//!      \   |   /         multiple         what single scattering loses between the facets of metal
//!   ====\==|==/======    diffuse          Lambertian, times what the interface transmits along wo and wi
//! ```
//!
//! These are most surfaces of most scenes. The results equal those of the scalar [`Bsdf`] to the last bit.

use std::f64::consts::PI;

use turner_bvh::lanes::{Block, F64x8, LANES, Mask8, Simd, Vec3x8};

use super::albedo::AlbedoCurveBlock;
use super::block::{Sampled, cosine};
use super::facets_x8::FacetBlock;
use super::fresnel::Metal;
use super::fresnel_x8::{conductors, dielectric};
use super::interface::Interface;
use super::mixture::MIN_COSINE;
use super::spread::Spread;
use super::{Bsdf, Rgb, diffuse};
use crate::math::block::{bits, set_bit, set_vector};
use crate::math::elementary_x8::{clamp, is_finite};

impl Bsdf<'_> {
    /// The base, if the BSDF has no other layer.
    pub(crate) fn as_opaque_base(&self) -> Option<OpaqueBase<'_>> {
        let d = &self.diffuse;
        let alone = self.fuzz.is_none()
            && self.coat.is_none()
            && self.rotation.is_none()
            && !self.inside
            && !self.thin
            && !self.exits
            && d.transmit == Rgb::ZERO
            && d.enter == Rgb::ZERO
            && d.roughness < diffuse::MIN_ROUGHNESS;
        let interface = self.interface.as_ref().filter(|_| alone)?;
        let isotropic = interface.facets.ax == interface.facets.ay
            && interface.rough.as_ref().is_none_or(|r| r.curve.is_isotropic())
            && interface.compensation.as_ref().is_none_or(|c| c.mirror.is_isotropic());
        (isotropic && interface.glass == 0.0 && interface.film.is_none()).then_some(OpaqueBase {
            bsdf: self,
            interface,
            reflect: d.reflect,
        })
    }
}

/// A BSDF that is only an opaque base.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OpaqueBase<'a> {
    bsdf: &'a Bsdf<'a>,
    interface: &'a Interface,
    /// Albedo of the diffuse lobe.
    reflect: Rgb,
}

impl OpaqueBase<'_> {
    /// Whether another base has the same parameters.
    pub(crate) fn is_same(&self, other: &OpaqueBase<'_>) -> bool {
        let (a, b) = (self.interface, other.interface);
        let metal = |m: &Metal| (m.f0, m.dip, m.weight, m.index);
        (a.facets, a.smooth, a.metal, a.opaque, a.specular, a.opaque_index)
            == (b.facets, b.smooth, b.metal, b.opaque, b.specular, b.opaque_index)
            && metal(&a.metal_fresnel) == metal(&b.metal_fresnel)
            && (a.rough.is_some(), a.lost.is_some()) == (b.rough.is_some(), b.lost.is_some())
            && a.compensation.is_some() == b.compensation.is_some()
            && self.reflect == other.reflect
            && self.bsdf.diffuse.normalisation == other.bsdf.diffuse.normalisation
    }

    /// The same base with another diffuse albedo, which is not black.
    pub(crate) fn with_albedo(self, reflect: Rgb) -> Self {
        OpaqueBase { reflect, ..self }
    }

    /// Whether it reflects diffusely, or by a lobe that is at least this wide (α).
    pub(crate) fn is_wide(&self, alpha: f64) -> bool {
        self.reflect != Rgb::ZERO || !self.interface.smooth && self.interface.facets.ax >= alpha
    }

    /// Whether it is metal at least in part; [`OpaqueBlock`]s of one kind are faster than mixed ones.
    pub(crate) fn is_metal(&self) -> bool {
        self.interface.metal > 0.0
    }
}

/// Eight opaque bases.
#[derive(Clone, Debug, Default)]
pub(crate) struct OpaqueBlock {
    facets: FacetBlock,
    /// Masks: delta lobes; any metal; metal by its index; multiple scattering; any diffuse reflection; albedos from a table; reflectances
    /// that are more than tinted; light that the interface of the dielectric loses.
    smooth: u8,
    metals: u8,
    indexed: u8,
    multiple: u8,
    diffuse: u8,
    rough: u8,
    lifted: u8,
    loses: u8,
    metal: Block,
    metal_weight: Block,
    /// F₀ and dip of metal, or η and k.
    f0: [Block; 3],
    dip: [Block; 3],
    /// The colour of metal by its index.
    metal_color: [Block; 3],
    opaque: Block,
    tint: [Block; 3],
    lift: [Block; 3],
    index: Block,
    boundary: AlbedoCurveBlock,
    lost: AlbedoCurveBlock,
    /// The albedo of the diffuse lobe, its BRDF where nothing covers it, and the mean transmittance above it.
    reflect: [Block; 3],
    lambert: [Block; 3],
    normalisation: Block,
    mirror: AlbedoCurveBlock,
    mirror_average: Block,
    multi: [Block; 3],
    spread_k: Block,
    spread_log: Block,
}

/// The parts of opaque bases that depend on wo alone.
#[derive(Clone, Copy)]
pub(crate) struct OpaqueSeen<S: Simd> {
    /// Transmittance of the interface, and the loss between its facets.
    below: F64x8<S>,
    loss: F64x8<S>,
    /// Probabilities of the lobes: interface, diffuse, multiple scattering.
    p: [F64x8<S>; 3],
}

impl<S: Simd> OpaqueSeen<S> {
    #[inline(always)]
    pub(crate) fn load(simd: S, [below, loss, a, b, c]: &[Block; 5]) -> OpaqueSeen<S> {
        let load = |block: &Block| F64x8::load(simd, block);
        OpaqueSeen { below: load(below), loss: load(loss), p: [load(a), load(b), load(c)] }
    }

    #[inline(always)]
    pub(crate) fn store(self, [below, loss, a, b, c]: &mut [Block; 5]) {
        self.below.store(below);
        self.loss.store(loss);
        self.p[0].store(a);
        self.p[1].store(b);
        self.p[2].store(c);
    }
}

impl OpaqueBlock {
    /// Stores a base in a lane.
    pub(crate) fn set(&mut self, lane: usize, base: &OpaqueBase<'_>) {
        let (i, d) = (base.interface, &base.bsdf.diffuse);
        let has_diffuse = base.reflect != Rgb::ZERO;
        self.facets.set(lane, &i.facets);
        set_bit(&mut self.smooth, lane, i.smooth);
        set_bit(&mut self.metals, lane, i.metal > 0.0);
        set_bit(&mut self.diffuse, lane, has_diffuse);
        self.metal.0[lane] = i.metal;
        if i.metal > 0.0 {
            self.metal_weight.0[lane] = i.metal_fresnel.weight;
            let metal = &i.metal_fresnel;
            let (f0, dip) = metal.index.map_or((metal.f0, metal.dip), |(index, _)| (index.eta, index.k));
            set_vector(&mut self.f0, lane, f0);
            set_vector(&mut self.dip, lane, dip);
            set_vector(&mut self.metal_color, lane, metal.index.map_or(Rgb::ONE, |(_, color)| color));
        }
        set_bit(&mut self.indexed, lane, i.metal > 0.0 && i.metal_fresnel.index.is_some());
        self.opaque.0[lane] = i.opaque;
        set_vector(&mut self.tint, lane, i.specular.tint);
        set_vector(&mut self.lift, lane, i.specular.lift);
        set_bit(&mut self.lifted, lane, i.specular.is_lifted());
        if let Some(loss) = i.mirror_loss().filter(|_| i.specular.is_lifted()) {
            self.mirror.set(lane, &loss);
        }
        self.index.0[lane] = i.opaque_index;
        let rough = i.rough.as_ref().filter(|_| has_diffuse);
        set_bit(&mut self.rough, lane, rough.is_some());
        if let Some(rough) = rough {
            self.boundary.set(lane, &rough.curve);
        }
        let lost = i.lost.as_ref().filter(|_| has_diffuse);
        set_bit(&mut self.loses, lane, lost.is_some());
        if let Some(lost) = lost {
            self.lost.set(lane, lost);
        }
        set_vector(&mut self.reflect, lane, base.reflect);
        let lambert =
            if has_diffuse { (base.reflect / d.weight).min(Rgb::ONE) / PI * d.weight } else { Rgb::ZERO };
        set_vector(&mut self.lambert, lane, lambert);
        self.normalisation.0[lane] = d.normalisation;
        let multiple = i.compensation.as_ref().filter(|_| i.metal > 0.0);
        set_bit(&mut self.multiple, lane, multiple.is_some());
        if let Some(c) = multiple {
            self.mirror.set(lane, &c.mirror);
            self.mirror_average.0[lane] = c.averages[0];
            set_vector(&mut self.multi, lane, c.metal);
            (self.spread_k.0[lane], self.spread_log.0[lane]) = (c.spread.k, c.spread.log);
        }
    }

    /// Copies a lane of another block.
    pub(crate) fn copy_lane(&mut self, to: usize, other: &OpaqueBlock, from: usize) {
        let copy = |a: &mut Block, b: &Block| a.0[to] = b.0[from];
        let copy_bit = |a: &mut u8, b: u8| set_bit(a, to, b >> from & 1 == 1);
        self.combine(other, copy, copy_bit);
        self.boundary.copy_lane(to, &other.boundary, from);
        self.lost.copy_lane(to, &other.lost, from);
        self.mirror.copy_lane(to, &other.mirror, from);
    }

    /// Sets all lanes to a lane of another block.
    pub(crate) fn set_all(&mut self, other: &OpaqueBlock, from: usize) {
        let spread = |a: &mut Block, b: &Block| a.0 = [b.0[from]; LANES];
        let spread_bit = |a: &mut u8, b: u8| *a = if b >> from & 1 == 1 { u8::MAX } else { 0 };
        self.combine(other, spread, spread_bit);
        self.boundary.set_all(&other.boundary, from);
        self.lost.set_all(&other.lost, from);
        self.mirror.set_all(&other.mirror, from);
    }

    /// Applies functions to all numbers and masks except those of the curves.
    #[inline]
    fn combine(
        &mut self,
        other: &OpaqueBlock,
        number: impl Fn(&mut Block, &Block),
        mask: impl Fn(&mut u8, u8),
    ) {
        mask(&mut self.smooth, other.smooth);
        mask(&mut self.metals, other.metals);
        mask(&mut self.indexed, other.indexed);
        mask(&mut self.multiple, other.multiple);
        mask(&mut self.diffuse, other.diffuse);
        mask(&mut self.rough, other.rough);
        mask(&mut self.lifted, other.lifted);
        mask(&mut self.loses, other.loses);
        let vectors = [
            (&mut self.f0, &other.f0),
            (&mut self.dip, &other.dip),
            (&mut self.metal_color, &other.metal_color),
            (&mut self.tint, &other.tint),
            (&mut self.lift, &other.lift),
            (&mut self.reflect, &other.reflect),
            (&mut self.lambert, &other.lambert),
            (&mut self.multi, &other.multi),
        ];
        for (a, b) in vectors.into_iter().flat_map(|(a, b)| a.iter_mut().zip(b)) {
            number(a, b);
        }
        self.facets.combine(&other.facets, &number, mask);
        number(&mut self.metal, &other.metal);
        number(&mut self.metal_weight, &other.metal_weight);
        number(&mut self.opaque, &other.opaque);
        number(&mut self.index, &other.index);
        number(&mut self.normalisation, &other.normalisation);
        number(&mut self.mirror_average, &other.mirror_average);
        number(&mut self.spread_k, &other.spread_k);
        number(&mut self.spread_log, &other.spread_log);
    }

    /// Whether a lane reflects diffusely, or by a lobe that is at least this wide (α).
    pub(crate) fn is_wide(&self, lane: usize, alpha: f64) -> bool {
        let is = |mask: u8| mask >> lane & 1 == 1;
        is(self.diffuse) || !is(self.smooth) && self.facets.alpha(lane) >= alpha
    }

    /// What depends on wo alone; see `Bsdf::prepare_wo`.
    #[inline(always)]
    pub(crate) fn towards<S: Simd>(&self, simd: S, wo: Vec3x8<S>) -> OpaqueSeen<S> {
        let splat = |v: f64| F64x8::splat(simd, v);
        let (zero, one) = (splat(0.0), splat(1.0));
        let mu = smaller(wo.z.or_larger(zero), one);
        let (below, loss) = (self.below(simd, mu), self.loss(simd, mu));
        let interface = sum(self.reflectance(simd, mu));
        let diffuse = sum(Vec3x8::load(simd, &self.reflect) * below);
        let mut multiple = zero;
        if self.multiple != 0 {
            let scale = loss * F64x8::load(simd, &self.mirror_average) * splat(PI);
            let all = sum(Vec3x8::load(simd, &self.multi) * scale);
            multiple = Mask8::new(simd, self.multiple).select(all, zero);
        }
        let total = interface + diffuse + multiple;
        let positive = total.gt(zero) & wo.z.gt(splat(MIN_COSINE));
        let scale = positive.select(one / total, zero);
        OpaqueSeen { below, loss, p: [interface * scale, diffuse * scale, multiple * scale] }
    }

    /// Fraction of light that reaches the diffuse base; 0 without one. See `Interface::below`.
    #[inline(always)]
    fn below<S: Simd>(&self, simd: S, mu: F64x8<S>) -> F64x8<S> {
        let splat = |v: f64| F64x8::splat(simd, v);
        let (zero, one) = (splat(0.0), splat(1.0));
        if self.diffuse == 0 {
            return zero;
        }
        let index = F64x8::load(simd, &self.index);
        let mirror = index.eq(splat(f64::INFINITY));
        let boundary = if self.rough == 0 {
            dielectric(simd, mu, index)
        } else {
            let rough = Mask8::new(simd, self.rough);
            let alpha = self.boundary.alpha(simd);
            let smoothed = (mu * mu + (one - mu * mu) * splat(0.5) * alpha * alpha).sqrt();
            let smooth = dielectric(simd, rough.select(smoothed, mu), index);
            let curve = self.boundary.at(simd, mu);
            let tabulated = clamp(mirror.select(one - curve, smooth + curve), zero, one);
            rough.select(tabulated, smooth)
        };
        let mut reflected = Vec3x8::load(simd, &self.tint) * boundary;
        if self.lifted != 0 {
            let some = Mask8::new(simd, self.lifted & !self.smooth);
            let loss = some.select(self.mirror.at(simd, mu), zero);
            reflected = reflected + Vec3x8::load(simd, &self.lift) * (one - loss);
        }
        let most = larger(larger(reflected.x, reflected.y), reflected.z);
        let mut below = one - clamp(most, zero, one);
        if self.loses != 0 {
            let lost = self.lost.at(simd, mu).or_larger(zero);
            below = (below - Mask8::new(simd, self.loses).select(lost, zero)).or_larger(zero);
        }
        Mask8::new(simd, self.diffuse).select(below, zero)
    }

    /// Loss of single scattering between the facets of metal, at least 0.
    #[inline(always)]
    fn loss<S: Simd>(&self, simd: S, mu: F64x8<S>) -> F64x8<S> {
        let zero = F64x8::splat(simd, 0.0);
        if self.multiple == 0 { zero } else { self.mirror.at(simd, mu).or_larger(zero) }
    }

    /// Reflectance of facets at a cosine; see `Interface::split`.
    #[inline(always)]
    fn reflectance<S: Simd>(&self, simd: S, mu: F64x8<S>) -> Vec3x8<S> {
        let splat = |v: f64| F64x8::splat(simd, v);
        let (zero, one) = (splat(0.0), splat(1.0));
        let index = F64x8::load(simd, &self.index);
        let tint = Vec3x8::load(simd, &self.tint);
        let mut opaque = tint * dielectric(simd, mu, index);
        if self.lifted != 0 {
            let f = opaque + Vec3x8::load(simd, &self.lift);
            opaque = Vec3x8 { x: clamp(f.x, zero, one), y: clamp(f.y, zero, one), z: clamp(f.z, zero, one) };
        }
        let opaque = opaque * F64x8::load(simd, &self.opaque);
        if self.metals == 0 {
            return opaque;
        }
        let c = clamp(one - mu, zero, one);
        let c5 = c * c * c * c * c;
        let (f0, dip) = (Vec3x8::load(simd, &self.f0), Vec3x8::load(simd, &self.dip));
        let f = f0 + (Vec3x8 { x: one, y: one, z: one } - f0) * c5 - dip * (clamp(mu, zero, one) * c5 * c);
        let f = Vec3x8 { x: clamp(f.x, zero, one), y: clamp(f.y, zero, one), z: clamp(f.z, zero, one) };
        let f = if self.indexed == 0 { f } else { self.conductor(simd, mu, f) };
        let metal = f * F64x8::load(simd, &self.metal_weight) * F64x8::load(simd, &self.metal);
        Vec3x8::select(Mask8::new(simd, self.metals), metal + opaque, opaque)
    }

    /// `tinted`, and the reflectance of metal by its index where it has one; see [`Metal`].
    #[inline(always)]
    fn conductor<S: Simd>(&self, simd: S, mu: F64x8<S>, tinted: Vec3x8<S>) -> Vec3x8<S> {
        let (eta, k) = (Vec3x8::load(simd, &self.f0), Vec3x8::load(simd, &self.dip));
        let exact = conductors(simd, mu, [eta, k], Vec3x8::load(simd, &self.metal_color));
        Vec3x8::select(Mask8::new(simd, self.indexed), exact, tinted)
    }

    /// BRDF and density of `wi` above the surface; see `Bsdf::mixture`. `softening` is the factor of diffuse reflection.
    #[inline(always)]
    pub(crate) fn eval_pdf<S: Simd>(
        &self,
        simd: S,
        wo: Vec3x8<S>,
        seen: &OpaqueSeen<S>,
        wi: Vec3x8<S>,
        softening: F64x8<S>,
    ) -> (Vec3x8<S>, F64x8<S>) {
        let splat = |v: f64| F64x8::splat(simd, v);
        let (zero, one, four, pi) = (splat(0.0), splat(1.0), splat(4.0), splat(PI));
        let [interface, diffuse, multiple] = seen.p;
        let mu = wi.z.abs();
        let capped = smaller(mu, one);
        let mut pdf = diffuse * mu / pi;
        let mut f = Vec3x8 { x: zero, y: zero, z: zero };
        if self.diffuse != 0 {
            let through = seen.below * self.below(simd, capped) / F64x8::load(simd, &self.normalisation);
            let lit = Mask8::new(simd, self.diffuse).select(through, zero);
            f = Vec3x8::load(simd, &self.lambert) * lit * softening;
        }
        let none = zero;
        let mut single = Vec3x8 { x: none, y: none, z: none };
        if self.smooth != u8::MAX {
            let rough = Mask8::new(simd, !self.smooth);
            let h = wo + wi;
            let h = h * (one / h.dot(h).sqrt());
            let reflectance = self.reflectance(simd, wo.dot(h));
            let d = self.facets.d(simd, h);
            let (lo, li) = (self.facets.lambda(simd, wo), self.facets.lambda(simd, wi));
            let all = reflectance * (d / (self.facets.masking(simd, lo, li) * four * wo.z * wi.z));
            let density = d / ((one + lo) * four * wo.z);
            single = Vec3x8::select(rough, all, single);
            pdf = rough.select(pdf + interface * density, pdf);
        }
        if self.multiple != 0 {
            let some = Mask8::new(simd, self.multiple);
            let again = Vec3x8::load(simd, &self.multi) * (seen.loss * self.loss(simd, capped));
            single = Vec3x8::select(some, single + again, single);
            let (k, log) = (F64x8::load(simd, &self.spread_k), F64x8::load(simd, &self.spread_log));
            let density = mu / (pi * (mu * mu + k) * log);
            pdf = (some & multiple.gt(zero)).select(pdf + multiple * density, pdf);
        }
        (f + single, pdf)
    }

    /// Samples one lobe; see `Bsdf::sample_mixture`. `u` as for [`Bsdf::sample`].
    #[inline(always)]
    pub(crate) fn sample<S: Simd>(
        &self,
        simd: S,
        wo: Vec3x8<S>,
        seen: &OpaqueSeen<S>,
        u: [F64x8<S>; 3],
        softening: impl Fn(Vec3x8<S>) -> F64x8<S>,
    ) -> Sampled<S> {
        let splat = |v: f64| F64x8::splat(simd, v);
        let (zero, one, least) = (splat(0.0), splat(1.0), splat(MIN_COSINE));
        let [interface, diffuse, multiple] = seen.p;
        // As `choose`: the first lobe at which the cumulative probability exceeds u.
        let (first, second, third) = (interface.gt(zero), diffuse.gt(zero), multiple.gt(zero));
        let takes_first = first & (u[0].lt(interface) | Mask8::new(simd, !(second | third).bits()));
        let below = interface + diffuse;
        let takes_second = second.and_not(takes_first) & (u[0].lt(below) | Mask8::new(simd, !third.bits()));
        let takes_third = third.and_not(takes_first | takes_second);

        let wi_diffuse = cosine(simd, [u[1], u[2]]);
        let mut wi = wi_diffuse;
        let smooth = Mask8::new(simd, self.smooth);
        if takes_first.any() {
            let facet = self.facets.sample_visible(simd, takes_first.and_not(smooth), wo, [u[1], u[2]]);
            let d = -wo;
            let mirrored = d - facet * (splat(2.0) * d.dot(facet));
            let through = Vec3x8 { x: -wo.x, y: -wo.y, z: wo.z };
            wi = Vec3x8::select(takes_first, Vec3x8::select(smooth, through, mirrored), wi);
        }
        if takes_third.any() {
            wi = Vec3x8::select(takes_third, self.spread(simd, takes_third.bits(), [u[1], u[2]]), wi);
        }
        let is_delta = takes_first & smooth;
        let (f, pdf) = self.eval_pdf(simd, wo, seen, wi, softening(wi));
        // The delta lobe: color / |wi.z|, with the probability of its lobe.
        let color = self.reflectance(simd, smaller(wo.z, one));
        let mirror = Vec3x8 { x: color.x / wi.z, y: color.y / wi.z, z: color.z / wi.z };
        let f = Vec3x8::select(is_delta, mirror, f);
        let pdf = is_delta.select(interface, pdf);
        let valid = (takes_first | takes_second | takes_third)
            & wi.z.gt(least)
            & wo.z.gt(least)
            & pdf.gt(zero)
            & (is_finite(simd, pdf) | is_delta);
        let f = [f.x.narrow(), f.y.narrow(), f.z.narrow()];
        Sampled { wi, f, pdf, valid, is_delta, is_diffuse: takes_second | takes_third }
    }

    /// Directions of multiple scattering in some lanes; see [`Spread::sample`]. Rare, and its exponential is scalar.
    #[inline(always)]
    fn spread<S: Simd>(&self, simd: S, lanes: u8, u: [F64x8<S>; 2]) -> Vec3x8<S> {
        let (mut us, mut to) = ([Block::default(); 2], [Block::default(); 3]);
        u[0].store(&mut us[0]);
        u[1].store(&mut us[1]);
        for lane in bits(lanes) {
            let spread = Spread { k: self.spread_k.0[lane], log: self.spread_log.0[lane] };
            set_vector(&mut to, lane, spread.sample([us[0].0[lane], us[1].0[lane]]));
        }
        Vec3x8::load(simd, &to)
    }
}

#[inline(always)]
fn smaller<S: Simd>(a: F64x8<S>, b: F64x8<S>) -> F64x8<S> {
    b.lt(a).select(b, a)
}

#[inline(always)]
fn larger<S: Simd>(a: F64x8<S>, b: F64x8<S>) -> F64x8<S> {
    b.gt(a).select(b, a)
}

#[inline(always)]
fn sum<S: Simd>(v: Vec3x8<S>) -> F64x8<S> {
    v.x + v.y + v.z
}

#[cfg(test)]
#[path = "opaque_base_tests.rs"]
mod tests;
