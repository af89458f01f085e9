//! The sum of all lobes: evaluation, the choice of one lobe to sample, and the density over all lobes. The parent
//! module explains the layers.

use std::f64::consts::PI;

use super::albedo::AlbedoDirection;
use super::coat::Coat;
use super::diffuse::{eon, sample_cosine};
use super::fuzz::Charlie;
use super::terminator::Terminator;
use super::{Bsdf, BsdfSample, Lobe, Rgb, lambert, spectrum};
use crate::color::Spectrum;
use crate::math::{DVec3, Frame, reflect};

/// Directions whose cosine is below this count as below the surface.
pub(crate) const MIN_COSINE: f64 = 1e-7;

// Lobes, in the order of their probabilities.
const FUZZ: usize = 0;
pub(super) const COAT: usize = 1;
pub(super) const INTERFACE: usize = 2;
pub(super) const REFLECT: usize = 3;
pub(super) const TRANSMIT: usize = 4;
/// Straight through a thin wall, or an interface between equal indices.
pub(super) const PASS: usize = 5;
/// Multiple scattering between the facets of the base, reflected and transmitted.
pub(super) const MULTI_REFLECT: usize = 6;
const MULTI_TRANSMIT: usize = 7;
/// Entry into a subsurface medium.
pub(super) const ENTER: usize = 8;
pub(super) const LOBES: usize = 9;

/// The layers over the base along one direction.
#[derive(Clone, Copy)]
pub(super) struct Above {
    pub(super) w: AlbedoDirection,
    /// Cosine to the coat's normal.
    pub(super) coat: f64,
    /// Transmittance of the fuzz, and of fuzz and coat.
    pub(super) fuzz: f64,
    pub(super) through: f64,
    /// Path length through a coat of thickness 1; 0 without a coat.
    pub(super) path_length: f64,
    /// Fraction of light that reaches the diffuse base; 0 without one.
    pub(super) diffuse: f64,
}

/// Probabilities of the lobes.
pub(super) type LobeProbabilities = [f64; LOBES];

/// Nodes and weights of the eight-point Gauss-Legendre rule on 0..=1.
pub(super) const GAUSS: [(f64, f64); 8] = [
    (0.019_855_071_751_231_9, 0.050_614_268_145_188_1),
    (0.101_666_761_293_186_6, 0.111_190_517_226_687_2),
    (0.237_233_795_041_835_5, 0.156_853_322_938_943_6),
    (0.408_282_678_752_175_1, 0.181_341_891_689_181),
    (0.591_717_321_247_825, 0.181_341_891_689_181),
    (0.762_766_204_958_164_5, 0.156_853_322_938_943_6),
    (0.898_333_238_706_813_4, 0.111_190_517_226_687_2),
    (0.980_144_928_248_768_1, 0.050_614_268_145_188_1),
];

impl Bsdf<'_> {
    /// The layers above the base, outside.
    pub(super) fn above(&self, w: AlbedoDirection) -> Above {
        let mu = w.mu;
        let fuzz = self.fuzz.as_ref().map_or(1.0, |f| 1.0 - f.weight * f.charlie.albedo(mu));
        let (through, path_length) = match &self.coat {
            None => (fuzz, 0.0),
            Some(c) => (fuzz * (1.0 - c.weight * c.albedo(mu)), c.path_length(mu)),
        };
        Above { w, coat: mu, fuzz, through, path_length, diffuse: through * self.below(w) }
    }

    /// The layers above the base along `w`. A coat with a normal of its own has its own cosine.
    pub(super) fn above_towards(&self, w: DVec3, inside: bool) -> Above {
        let above = self.above_on(AlbedoDirection::of(w), inside);
        let (Some(n), Some(c), false) = (self.coat_normal, &self.coat, inside || w.z < 0.0) else {
            return above;
        };
        let coat = w.dot(n).clamp(0.0, 1.0);
        let through = above.fuzz * (1.0 - c.weight * c.albedo(coat));
        Above {
            coat,
            through,
            path_length: c.path_length(coat),
            diffuse: through * self.below(above.w),
            ..above
        }
    }

    fn coat_frame(&self) -> Option<Frame> {
        self.coat_normal.map(Frame::from_z)
    }

    /// The coat's BRDF and density. With a separate normal nc, f is multiplied by cos(nc, wi) / cos(n, wi).
    fn coat_reflection(&self, c: &Coat, wo: DVec3, wi: DVec3) -> (f64, f64) {
        let Some(frame) = self.coat_frame() else { return c.reflect(wo, wi) };
        let (o, i) = (frame.to_local(wo), frame.to_local(wi));
        if !(o.z > MIN_COSINE && i.z > MIN_COSINE) {
            return (0.0, 0.0);
        }
        let (f, pdf) = c.reflect(o, i);
        (f * (i.z / wi.z), pdf)
    }

    fn has_diffuse(&self) -> bool {
        let d = &self.diffuse;
        d.reflect != Rgb::ZERO || d.transmit != Rgb::ZERO || d.enter != Rgb::ZERO
    }

    /// Fraction of light under coat and fuzz that reaches the diffuse base.
    #[inline]
    fn below(&self, w: AlbedoDirection) -> f64 {
        match &self.interface {
            _ if !self.has_diffuse() => 0.0,
            None => 1.0,
            Some(i) => i.below(w),
        }
    }

    /// The layers on either side: inside glass there are none.
    pub(super) fn above_on(&self, w: AlbedoDirection, inside: bool) -> Above {
        if inside {
            Above { w, coat: w.mu, fuzz: 1.0, through: 1.0, path_length: 0.0, diffuse: self.below(w) }
        } else {
            self.above(w)
        }
    }

    /// The layers along `wo` and the probabilities of the lobes.
    pub(super) fn prepare_wo(&self, wo: DVec3) -> (Above, LobeProbabilities) {
        if self.lambert {
            let mut p = [0.0; LOBES];
            p[REFLECT] = 1.0;
            let w = AlbedoDirection::all(wo.z);
            return (Above { w, coat: wo.z, fuzz: 1.0, through: 1.0, path_length: 0.0, diffuse: 1.0 }, p);
        }
        if self.exits {
            return self.prepare_exit(wo);
        }
        if self.unlayered.is_some() {
            return (self.prepare_exit(wo).0, [0.0; LOBES]);
        }
        if self.glass_alone {
            let mut p = [0.0; LOBES];
            p[INTERFACE] = if wo.z > MIN_COSINE { 1.0 } else { 0.0 };
            let w = AlbedoDirection::all(wo.z.clamp(0.0, 1.0));
            return (Above { w, coat: w.mu, fuzz: 1.0, through: 1.0, path_length: 0.0, diffuse: 0.0 }, p);
        }
        let above = self.above_towards(DVec3 { z: wo.z.max(0.0), ..wo }, self.inside);
        let p = if wo.z > MIN_COSINE { self.probabilities(above) } else { [0.0; LOBES] };
        (above, p)
    }

    /// T̄, the divisor of T(µo) T(µi), with which the diffuse lobe keeps all light that reaches it.
    pub(super) fn diffuse_normalisation(&self) -> f64 {
        if !self.has_diffuse() {
            return 1.0;
        }
        let plain = self.fuzz.is_none() && (self.coat.is_none() || self.inside);
        let closed_form = match &self.interface {
            None => Some(1.0),
            Some(i) => i.below_average(),
        };
        let average = match closed_form {
            Some(average) if plain => average,
            _ => {
                let sum = GAUSS.iter().map(|(mu, w)| {
                    2.0 * mu * w * self.above_on(AlbedoDirection::all(*mu), self.inside).diffuse
                });
                sum.sum()
            }
        };
        // Rough diffuse reflection is brighter towards some directions: the largest transmittance is safe for all of
        // them.
        let rough = (2.0 * self.diffuse.roughness).min(1.0);
        let largest = if rough > 0.0 {
            self.above_on(AlbedoDirection::all(1.0), self.inside).diffuse.max(average)
        } else {
            average
        };
        (average + (largest - average) * rough).max(1e-6)
    }

    /// Approximate albedo of each lobe for light from one direction.
    pub(super) fn albedos(&self, above: Above) -> [Rgb; LOBES] {
        let mu = above.w.mu;
        let mut out = [Rgb::ZERO; LOBES];
        let mut tint = Rgb::ONE;
        if !self.inside {
            if let Some(f) = &self.fuzz {
                out[FUZZ] = f.color * (f.weight * f.charlie.albedo(mu));
            }
            if let Some(c) = &self.coat {
                out[COAT] = Rgb::splat(above.fuzz * c.weight * c.albedo(above.coat));
                tint = c.tint(2.0 * above.path_length, true);
            }
        }
        let diffuse = above.diffuse;
        out[REFLECT] = self.diffuse.reflect * diffuse * tint;
        out[TRANSMIT] = self.diffuse.transmit * diffuse * tint;
        if let Some(i) = &self.interface {
            let (r, t) = i.split(mu);
            out[INTERFACE] = (r + t) * above.through * tint;
            out[PASS] = i.straight_transmission(mu) * above.through * tint;
            let (reflect, transmit) = i.multi_albedos(above.w);
            out[MULTI_REFLECT] = reflect * above.through * tint;
            out[MULTI_TRANSMIT] = transmit * above.through * tint;
        }
        if self.diffuse.enter != Rgb::ZERO {
            out[ENTER] = self.diffuse.enter * diffuse * tint;
        }
        out
    }

    /// Probabilities of the lobes; all 0 for a black surface.
    fn probabilities(&self, above: Above) -> [f64; LOBES] {
        let mut p = self.albedos(above).map(|a| a.element_sum());
        let sum: f64 = p.iter().sum();
        let scale = if sum > 0.0 { 1.0 / sum } else { 0.0 };
        for p in &mut p {
            *p *= scale;
        }
        p
    }

    /// Factor of specular lobes under the layers: the transmittance along both directions, min(T(µo), T(µi)), and the
    /// coat's colour.
    pub(super) fn layers(&self, o: &Above, i: &Above, reflected: bool) -> Rgb {
        let transmittance = o.through.min(i.through);
        match &self.coat {
            Some(c) if o.path_length + i.path_length > 0.0 => {
                c.tint(o.path_length + i.path_length, reflected) * transmittance
            }
            _ => Rgb::splat(transmittance),
        }
    }

    /// f and pdf, summed over all lobes but delta lobes.
    #[inline]
    pub(super) fn mixture(
        &self,
        wo: DVec3,
        wi: DVec3,
        o: &Above,
        p: &LobeProbabilities,
        terminator: Option<&Terminator>,
    ) -> (Rgb, f64) {
        if !(wo.z > MIN_COSINE && wi.z.abs() > MIN_COSINE) {
            return (Rgb::ZERO, 0.0);
        }
        if self.lambert {
            let above = wi.z > 0.0;
            if !above {
                return (Rgb::ZERO, 0.0);
            }
            let f = self.softened_lambert(wi, terminator).to_array().map(f64::from);
            return (Rgb::from(f), wi.z / PI);
        }
        if let Some(whole) = &self.unlayered {
            return whole.eval(wo, wi);
        }
        if self.exits {
            let (f, pdf) = self.eval_exit(wi);
            return (f * softening(terminator, wi), pdf);
        }
        self.mixture_with(wo, wi, o, p, terminator)
    }

    /// The BRDF of a purely Lambertian surface, in the precision of blocks.
    #[inline]
    fn softened_lambert(&self, wi: DVec3, terminator: Option<&Terminator>) -> Spectrum {
        lambert(self.diffuse.reflect) * softening(terminator, wi) as f32
    }

    fn mixture_with(
        &self,
        wo: DVec3,
        wi: DVec3,
        o: &Above,
        p: &[f64; LOBES],
        terminator: Option<&Terminator>,
    ) -> (Rgb, f64) {
        let transmitted = wi.z < 0.0;
        if transmitted && p[TRANSMIT] + p[MULTI_TRANSMIT] == 0.0 && p[INTERFACE] == 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        if self.glass_alone
            && let Some(interface) = &self.interface
        {
            return if transmitted { interface.transmit(wo, wi) } else { interface.reflect(wo, wi) };
        }
        let mu = wi.z.abs();
        let inside = if transmitted && !self.thin { !self.inside } else { self.inside };
        let i = self.above_towards(wi, inside);
        let layers = self.layers(o, &i, !transmitted || self.thin);
        let (lobe, multi) = if transmitted { (TRANSMIT, MULTI_TRANSMIT) } else { (REFLECT, MULTI_REFLECT) };
        let mut f = Rgb::ZERO;
        let mut pdf = p[lobe] * mu / PI;
        let diffuse = if transmitted { self.diffuse.transmit } else { self.diffuse.reflect };
        if diffuse != Rgb::ZERO {
            let transmittance = o.diffuse * i.diffuse / self.diffuse.normalisation;
            let tinted = match &self.coat {
                Some(c) if o.path_length + i.path_length > 0.0 => {
                    c.tint(o.path_length + i.path_length, true) * transmittance
                }
                _ => Rgb::splat(transmittance),
            };
            f += tinted
                * if transmitted {
                    diffuse / PI
                } else {
                    eon((diffuse / self.diffuse.weight).min(Rgb::ONE), self.diffuse.roughness, wo, wi)
                        * self.diffuse.weight
                }
                * if transmitted { 1.0 } else { softening(terminator, wi) };
        }
        if let Some(interface) = &self.interface {
            let (single, density) =
                if transmitted { interface.transmit(wo, wi) } else { interface.reflect(wo, wi) };
            let multiple = if transmitted {
                interface.multi_transmit(o.w, i.w)
            } else {
                interface.multi_reflect(o.w, i.w)
            };
            f += (single + multiple) * layers;
            pdf += p[INTERFACE] * density;
            if p[multi] > 0.0 {
                pdf += p[multi] * interface.spread().map_or(0.0, |spread| spread.pdf(mu));
            }
        }
        if !transmitted && !self.inside {
            if let Some(c) = &self.coat {
                let (single, density) = self.coat_reflection(c, wo, wi);
                f += Rgb::splat(single * c.weight * o.fuzz.min(i.fuzz));
                pdf += p[COAT] * density;
            }
            if let Some(fuzz) = &self.fuzz {
                f += fuzz.color * (fuzz.weight * fuzz.charlie.eval(wo, wi));
                pdf += p[FUZZ] * Charlie::PDF;
            }
        }
        (f, pdf)
    }

    /// Samples one lobe.
    pub(super) fn sample_mixture(
        &self,
        wo: DVec3,
        u: [f64; 3],
        o: &Above,
        p: &LobeProbabilities,
        terminator: Option<&Terminator>,
    ) -> Option<BsdfSample> {
        if wo.z.is_nan() || wo.z <= MIN_COSINE {
            return None;
        }
        if self.lambert {
            let wi = sample_cosine([u[1], u[2]]);
            let lobe = Lobe { is_delta: false, is_transmission: false, is_diffuse: true };
            let f = self.softened_lambert(wi, terminator);
            return (wi.z > MIN_COSINE).then(|| BsdfSample { wi, f, pdf: wi.z / PI, lobe, eta: 1.0 });
        }
        if let Some(whole) = &self.unlayered {
            return whole.sample(wo, u);
        }
        if self.exits {
            let sample = self.sample_exit([u[1], u[2]])?;
            return Some(BsdfSample { f: sample.f * softening(terminator, sample.wi) as f32, ..sample });
        }
        let (lobe, u0) = choose(p, u[0])?;
        let mut eta = 1.0;
        let wi = match lobe {
            FUZZ => Charlie::sample([u[1], u[2]]),
            REFLECT => sample_cosine([u[1], u[2]]),
            TRANSMIT => {
                let wi = sample_cosine([u[1], u[2]]);
                eta = self.interface.as_ref().map_or(1.0, |i| i.eta);
                DVec3::new(wi.x, wi.y, -wi.z)
            }
            MULTI_REFLECT => self.interface.as_ref()?.spread()?.sample([u[1], u[2]]),
            MULTI_TRANSMIT => {
                let interface = self.interface.as_ref()?;
                let wi = interface.spread()?.sample([u[1], u[2]]);
                eta = interface.eta;
                DVec3::new(wi.x, wi.y, -wi.z)
            }
            COAT => {
                let coat = self.coat.as_ref()?;
                let frame = self.coat_frame();
                let local = frame.map_or(wo, |frame| frame.to_local(wo));
                if coat.smooth {
                    let f = Rgb::splat(coat.fresnel(o.coat) * coat.weight * o.fuzz);
                    let wi = DVec3::new(-local.x, -local.y, local.z);
                    let wi = frame.map_or(wi, |frame| frame.to_world(wi));
                    return if wi.z > 0.0 { delta(wi, f, p[COAT], false, 1.0) } else { None };
                }
                if local.z <= MIN_COSINE {
                    return None;
                }
                let h = coat.facets.sample_visible(local, [u[1], u[2]]);
                let wi = reflect(-local, h);
                match frame {
                    None => wi,
                    Some(frame) if wi.z > 0.0 => frame.to_world(wi),
                    Some(_) => return None,
                }
            }
            // Sampled by BsdfFromWo::enter.
            ENTER => return None,
            PASS => {
                let interface = self.interface.as_ref()?;
                let i = self.above_on(AlbedoDirection::all(wo.z), !self.inside);
                let f = interface.straight_transmission(wo.z) * self.layers(o, &i, false);
                return delta(-wo, f, p[PASS], true, 1.0);
            }
            _ => {
                let interface = self.interface.as_ref()?;
                let choice = interface.sample(wo, [u0, u[1], u[2]])?;
                if choice.transmits {
                    eta = interface.eta;
                }
                if interface.smooth && self.glass_alone {
                    let f = choice.color / (eta * eta);
                    return delta(choice.wi, f, choice.probability, choice.transmits, eta);
                }
                if interface.smooth {
                    let inside = if choice.transmits && !self.thin { !self.inside } else { self.inside };
                    let i = self.above_on(AlbedoDirection::of(choice.wi), inside);
                    let layers = self.layers(o, &i, !choice.transmits || self.thin);
                    let f = choice.color * layers / (eta * eta);
                    return delta(choice.wi, f, p[INTERFACE] * choice.probability, choice.transmits, eta);
                }
                choice.wi
            }
        };
        if wi.z.is_nan() || wi.z.abs() <= MIN_COSINE || (wi.z < 0.0 && matches!(lobe, COAT)) {
            return None;
        }
        let (f, pdf) = self.mixture_with(wo, wi, o, p, terminator);
        let lobe = Lobe {
            is_delta: false,
            is_transmission: wi.z < 0.0,
            is_diffuse: matches!(lobe, FUZZ | REFLECT | TRANSMIT | MULTI_REFLECT | MULTI_TRANSMIT),
        };
        (pdf > 0.0 && pdf.is_finite()).then(|| BsdfSample { wi, f: spectrum(f), pdf, lobe, eta })
    }
}

/// The factor of diffuse reflection at a shadow terminator.
#[inline]
fn softening(terminator: Option<&Terminator>, wi: DVec3) -> f64 {
    terminator.map_or(1.0, |t| t.softening(wi))
}

/// The sample of a delta lobe that carries the fraction `color` of light.
fn delta(wi: DVec3, color: Rgb, pdf: f64, is_transmission: bool, eta: f64) -> Option<BsdfSample> {
    let lobe = Lobe { is_delta: true, is_transmission, is_diffuse: false };
    let f = spectrum(color / wi.z.abs());
    (pdf > 0.0 && wi.z.abs() > MIN_COSINE).then_some(BsdfSample { wi, f, pdf, lobe, eta })
}

/// The lobe that `u` selects, and `u` rescaled to 0..1 within it.
pub(super) fn choose<const N: usize>(p: &[f64; N], u: f64) -> Option<(usize, f64)> {
    let mut below = 0.0;
    let mut last = None;
    for (lobe, p) in p.iter().enumerate() {
        if *p > 0.0 {
            if u < below + p {
                return Some((lobe, ((u - below) / p).clamp(0.0, 1.0 - f64::EPSILON)));
            }
            below += p;
            last = Some(lobe);
        }
    }
    last.map(|lobe| (lobe, 1.0 - f64::EPSILON))
}
