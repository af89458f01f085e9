//! One BSDF of all lobes: their sum, a sample of one of them, and the density over all.

use std::f64::consts::PI;

use super::albedo::AlbedoDirection;
use super::coat::Coat;
use super::diffuse::{eon, sample_cosine};
use super::fuzz::Charlie;
use super::{Bsdf, BsdfSample, Lobe, Rgb, spectrum};
use crate::math::{DVec3, Frame, reflect};

/// Directions closer to the surface than this cosine count as below it.
pub(crate) const MIN_COSINE: f64 = 1e-7;

// Lobes, in the order of their probabilities.
const FUZZ: usize = 0;
pub(super) const COAT: usize = 1;
pub(super) const INTERFACE: usize = 2;
pub(super) const REFLECT: usize = 3;
const TRANSMIT: usize = 4;
/// Straight through a thin wall, or a boundary between equal indices.
pub(super) const PASS: usize = 5;
/// What scatters several times between the facets of the base, reflected and transmitted.
const AGAIN: usize = 6;
const ACROSS: usize = 7;
/// Into a translucent body.
pub(super) const ENTER: usize = 8;
pub(super) const LOBES: usize = 9;

/// What lies over the base on the way to or from a direction.
#[derive(Clone, Copy)]
pub(super) struct Above {
    pub(super) w: AlbedoDirection,
    /// The cosine to the coat's normal.
    pub(super) coat: f64,
    /// Shares that pass the fuzz, and the fuzz and the coat.
    pub(super) fuzz: f64,
    pub(super) through: f64,
    /// Way through the coat; 0 where there is none.
    pub(super) way: f64,
    /// Share that reaches the diffuse body; 0 where there is no body.
    pub(super) body: f64,
}

/// Probabilities of the lobes.
pub(super) type Shares = [f64; LOBES];

/// Nodes and weights of Gauss and Legendre's rule with eight points on 0..=1.
const GAUSS: [(f64, f64); 8] = [
    (0.019_855_071_751_231_9, 0.050_614_268_145_188_1),
    (0.101_666_761_293_186_6, 0.111_190_517_226_687_2),
    (0.237_233_795_041_835_5, 0.156_853_322_938_943_6),
    (0.408_282_678_752_175_1, 0.181_341_891_689_181),
    (0.591_717_321_247_825, 0.181_341_891_689_181),
    (0.762_766_204_958_164_5, 0.156_853_322_938_943_6),
    (0.898_333_238_706_813_4, 0.111_190_517_226_687_2),
    (0.980_144_928_248_768_1, 0.050_614_268_145_188_1),
];

impl Bsdf {
    /// What lies above the base outside.
    pub(super) fn above(&self, w: AlbedoDirection) -> Above {
        let mu = w.mu;
        let fuzz = self.fuzz.as_ref().map_or(1.0, |f| 1.0 - f.weight * f.charlie.albedo(mu));
        let (through, way) = match &self.coat {
            None => (fuzz, 0.0),
            Some(c) => (fuzz * (1.0 - c.weight * c.albedo(mu)), c.way(mu)),
        };
        Above { w, coat: mu, fuzz, through, way, body: through * self.below(w) }
    }

    /// What lies above the base on the way to or from a direction, on a side; a coat with a normal of its own is met at its own angle.
    pub(super) fn above_towards(&self, w: DVec3, inside: bool) -> Above {
        let above = self.above_on(AlbedoDirection::of(w), inside);
        let (Some(n), Some(c), false) = (self.coat_normal, &self.coat, inside || w.z < 0.0) else {
            return above;
        };
        let coat = w.dot(n).clamp(0.0, 1.0);
        let through = above.fuzz * (1.0 - c.weight * c.albedo(coat));
        Above { coat, through, way: c.way(coat), body: through * self.below(above.w), ..above }
    }

    fn coat_frame(&self) -> Option<Frame> {
        self.coat_normal.map(Frame::from_z)
    }

    /// A coat's reflection with its density: the BRDF times the cosine to the coat's own normal over that to the surface's.
    fn coat_reflection(&self, c: &Coat, wo: DVec3, wi: DVec3) -> (f64, f64) {
        let Some(frame) = self.coat_frame() else { return c.reflect(wo, wi) };
        let (o, i) = (frame.to_local(wo), frame.to_local(wi));
        if !(o.z > MIN_COSINE && i.z > MIN_COSINE) {
            return (0.0, 0.0);
        }
        let (f, pdf) = c.reflect(o, i);
        (f * (i.z / wi.z), pdf)
    }

    fn has_body(&self) -> bool {
        let d = &self.diffuse;
        d.reflect != Rgb::ZERO || d.transmit != Rgb::ZERO || d.enter != Rgb::ZERO
    }

    /// Share of light under the layers that reaches the diffuse body.
    #[inline]
    fn below(&self, w: AlbedoDirection) -> f64 {
        match &self.interface {
            _ if !self.has_body() => 0.0,
            None => 1.0,
            Some(i) => i.below(w),
        }
    }

    /// The same on either side: inside glass there are no layers.
    pub(super) fn above_on(&self, w: AlbedoDirection, inside: bool) -> Above {
        if inside {
            Above { w, coat: w.mu, fuzz: 1.0, through: 1.0, way: 0.0, body: self.below(w) }
        } else {
            self.above(w)
        }
    }

    /// What lies above on the way to `wo`, and the probabilities of the lobes.
    pub(super) fn seen(&self, wo: DVec3) -> (Above, Shares) {
        if self.lambert {
            let mut p = [0.0; LOBES];
            p[REFLECT] = 1.0;
            let w = AlbedoDirection::all(wo.z);
            return (Above { w, coat: wo.z, fuzz: 1.0, through: 1.0, way: 0.0, body: 1.0 }, p);
        }
        if self.leaves {
            return self.seen_from_inside(wo);
        }
        let above = self.above_towards(DVec3 { z: wo.z.max(0.0), ..wo }, self.inside);
        let p = if wo.z > MIN_COSINE { self.probabilities(above) } else { [0.0; LOBES] };
        (above, p)
    }

    /// The divisor of the product of two such shares, with which a body keeps all that reaches it.
    pub(super) fn diffuse_normalisation(&self) -> f64 {
        if !self.has_body() {
            return 1.0;
        }
        let plain = self.fuzz.is_none() && (self.coat.is_none() || self.inside);
        let closed = match &self.interface {
            None => Some(1.0),
            Some(i) => i.below_average(),
        };
        let average = match closed {
            Some(average) if plain => average,
            _ => {
                let sum = GAUSS
                    .iter()
                    .map(|(mu, w)| 2.0 * mu * w * self.above_on(AlbedoDirection::all(*mu), self.inside).body);
                sum.sum()
            }
        };
        // A rough body is brighter towards some directions: the largest transmittance is safe for all of them.
        let rough = (2.0 * self.diffuse.roughness).min(1.0);
        let most = if rough > 0.0 {
            self.above_on(AlbedoDirection::all(1.0), self.inside).body.max(average)
        } else {
            average
        };
        (average + (most - average) * rough).max(1e-6)
    }

    /// Albedo of each lobe for light from a direction, about.
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
                tint = c.tint(2.0 * above.way, true);
            }
        }
        let body = above.body;
        out[REFLECT] = self.diffuse.reflect * body * tint;
        out[TRANSMIT] = self.diffuse.transmit * body * tint;
        if let Some(i) = &self.interface {
            let (r, t) = i.split(mu);
            out[INTERFACE] = (r + t) * above.through * tint;
            out[PASS] = i.passing(mu) * above.through * tint;
            let (again, across) = i.lost_albedos(above.w);
            out[AGAIN] = again * above.through * tint;
            out[ACROSS] = across * above.through * tint;
        }
        if self.diffuse.enter != Rgb::ZERO {
            out[ENTER] = self.diffuse.enter * body * tint;
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

    /// Factor of specular lobes under the layers: what passes them on both ways.
    pub(super) fn layers(&self, o: &Above, i: &Above, reflected: bool) -> Rgb {
        let share = o.through.min(i.through);
        match &self.coat {
            Some(c) if o.way + i.way > 0.0 => c.tint(o.way + i.way, reflected) * share,
            _ => Rgb::splat(share),
        }
    }

    /// f and pdf of all lobes but delta lobes.
    #[inline]
    pub(super) fn mixture(&self, wo: DVec3, wi: DVec3, o: &Above, p: &Shares) -> (Rgb, f64) {
        if !(wo.z > MIN_COSINE && wi.z.abs() > MIN_COSINE) {
            return (Rgb::ZERO, 0.0);
        }
        if self.lambert {
            let above = wi.z > 0.0;
            return if above { (self.diffuse.reflect / PI, wi.z / PI) } else { (Rgb::ZERO, 0.0) };
        }
        if self.leaves {
            return self.what_leaves(wi);
        }
        self.mixture_with(wo, wi, o, p)
    }

    fn mixture_with(&self, wo: DVec3, wi: DVec3, o: &Above, p: &[f64; LOBES]) -> (Rgb, f64) {
        let transmitted = wi.z < 0.0;
        if transmitted && p[TRANSMIT] + p[ACROSS] == 0.0 && p[INTERFACE] == 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        let mu = wi.z.abs();
        let inside = if transmitted && !self.thin { !self.inside } else { self.inside };
        let i = self.above_towards(wi, inside);
        let layers = self.layers(o, &i, !transmitted || self.thin);
        let (lobe, again) = if transmitted { (TRANSMIT, ACROSS) } else { (REFLECT, AGAIN) };
        let mut f = Rgb::ZERO;
        let mut pdf = p[lobe] * mu / PI;
        let body = if transmitted { self.diffuse.transmit } else { self.diffuse.reflect };
        if body != Rgb::ZERO {
            let share = o.body * i.body / self.diffuse.through;
            let share = match &self.coat {
                Some(c) if o.way + i.way > 0.0 => c.tint(o.way + i.way, true) * share,
                _ => Rgb::splat(share),
            };
            f += share
                * if transmitted {
                    body / PI
                } else {
                    eon((body / self.diffuse.share).min(Rgb::ONE), self.diffuse.roughness, wo, wi)
                        * self.diffuse.share
                };
        }
        if let Some(interface) = &self.interface {
            let (single, density) =
                if transmitted { interface.transmit(wo, wi) } else { interface.reflect(wo, wi) };
            let lost = if transmitted {
                interface.lost_and_transmitted(o.w, i.w)
            } else {
                interface.lost_and_reflected(o.w, i.w)
            };
            f += (single + lost) * layers;
            pdf += p[INTERFACE] * density;
            if p[again] > 0.0 {
                pdf += p[again] * interface.spread().map_or(0.0, |spread| spread.pdf(mu));
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

    /// A sample of one lobe.
    pub(super) fn sample_mixture(&self, wo: DVec3, u: [f64; 3], o: &Above, p: &Shares) -> Option<BsdfSample> {
        if wo.z.is_nan() || wo.z <= MIN_COSINE {
            return None;
        }
        if self.lambert {
            let wi = sample_cosine([u[1], u[2]]);
            let lobe = Lobe { is_delta: false, is_transmission: false, is_diffuse: true };
            let f = spectrum(self.diffuse.reflect / PI);
            return (wi.z > MIN_COSINE).then(|| BsdfSample { wi, f, pdf: wi.z / PI, lobe, eta: 1.0 });
        }
        if self.leaves {
            return self.sample_leaving([u[1], u[2]]);
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
            AGAIN => self.interface.as_ref()?.spread()?.sample([u[1], u[2]]),
            ACROSS => {
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
                let h = coat.ggx.sample_visible(local, [u[1], u[2]]);
                let wi = reflect(-local, h);
                match frame {
                    None => wi,
                    Some(frame) if wi.z > 0.0 => frame.to_world(wi),
                    Some(_) => return None,
                }
            }
            // See BsdfFromWo::enter.
            ENTER => return None,
            PASS => {
                let interface = self.interface.as_ref()?;
                let i = self.above_on(AlbedoDirection::all(wo.z), !self.inside);
                let f = interface.passing(wo.z) * self.layers(o, &i, false);
                return delta(-wo, f, p[PASS], true, 1.0);
            }
            _ => {
                let interface = self.interface.as_ref()?;
                let choice = interface.sample(wo, [u0, u[1], u[2]])?;
                if choice.transmits {
                    eta = interface.eta;
                }
                if interface.smooth {
                    let inside = if choice.transmits && !self.thin { !self.inside } else { self.inside };
                    let i = self.above_on(AlbedoDirection::of(choice.wi), inside);
                    let layers = self.layers(o, &i, !choice.transmits || self.thin);
                    let f = choice.color * layers / (eta * eta);
                    return delta(choice.wi, f, p[INTERFACE] * choice.share, choice.transmits, eta);
                }
                choice.wi
            }
        };
        if wi.z.is_nan() || wi.z.abs() <= MIN_COSINE || (wi.z < 0.0 && matches!(lobe, COAT)) {
            return None;
        }
        let (f, pdf) = self.mixture_with(wo, wi, o, p);
        let lobe = Lobe {
            is_delta: false,
            is_transmission: wi.z < 0.0,
            is_diffuse: matches!(lobe, FUZZ | REFLECT | TRANSMIT | AGAIN | ACROSS),
        };
        (pdf > 0.0 && pdf.is_finite()).then(|| BsdfSample { wi, f: spectrum(f), pdf, lobe, eta })
    }
}

/// The sample of a delta lobe that carries the share `color` of light.
fn delta(wi: DVec3, color: Rgb, pdf: f64, is_transmission: bool, eta: f64) -> Option<BsdfSample> {
    let lobe = Lobe { is_delta: true, is_transmission, is_diffuse: false };
    let f = spectrum(color / wi.z.abs());
    (pdf > 0.0 && wi.z.abs() > MIN_COSINE).then_some(BsdfSample { wi, f, pdf, lobe, eta })
}

/// The lobe that `u` falls on, and where in it, within 0..1.
pub(super) fn choose(p: &[f64; LOBES], u: f64) -> Option<(usize, f64)> {
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
