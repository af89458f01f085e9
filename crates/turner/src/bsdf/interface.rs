//! The specular interface of the base: reflection of metal, plastic and glass and refraction of glass, with one
//! distribution of microfacets (`facets`).
//!
//! ```text
//!             n
//!      wo     |   h   wi             reflection:  h = (wo + wi) / |wo + wi|,  wi = 2 (wo·h) h − wo
//!         \   |  /  /
//!   n1     \  | / /                  refraction:  h ∝ wo + η wi,  η = n2 / n1   (Snell)
//!   --------\-|//-------------
//!   n2        |\                     Fresnel: the facet reflects F(wo·h) and transmits 1 − F
//!             | \  wi
//! ```
//!
//! Single scattering (Walter et al. 2007): f = F D G2 / (4 cos θo cos θi) for reflection, eq. 21 for refraction. Facets
//! are sampled among those visible from wo; then the Fresnel term chooses reflection or refraction. Light that hits a
//! second facet is missing, and rough surfaces darken. A diffuse lobe returns it (Kulla and Conty 2017, "Revisiting
//! physically based shading at Imageworks"): with E the albedo of single scattering and L = 1 − E, f = k L(wo) L(wi), k
//! such that a white surface loses nothing. Glass divides it between its two sides with L of the near side for wo and
//! of wi's side for wi, which keeps it reciprocal.

use super::albedo::{self, AlbedoCurve, AlbedoDirection, Reflected};
use super::facets::{FacetKind, Facets, widths};
use super::film::{Film, Tint};
use super::fresnel::{self, Metal};
use super::specular::Specular;
use super::spread::Spread;
use super::{PrincipledPoint, Rgb, color, unit};
use crate::math::{DVec3, reflect};
use std::f64::consts::PI;

/// Lobes narrower than this α are delta lobes.
const MIN_ALPHA: f64 = 1e-4;
/// Relative indices closer to 1 than this do not refract.
const MIN_CONTRAST: f64 = 1e-3;

/// The interface, seen from one side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interface {
    pub(super) facets: Facets,
    /// Delta lobes: no microfacets.
    pub(super) smooth: bool,
    /// Fractions of metal, glass and opaque dielectric.
    pub(super) metal: f64,
    pub(super) glass: f64,
    pub(super) opaque: f64,
    pub(super) metal_fresnel: Metal,
    /// Colour of dielectric reflection.
    pub(super) specular: Specular,
    /// Colour of light that glass transmits.
    pub(super) through: Rgb,
    /// Index on the far side over that on wo's side, for refraction; 1 for thin walls.
    pub(super) eta: f64,
    /// Whether glass transmits light straight, whatever the roughness.
    pub(super) straight: bool,
    thin: bool,
    inside: bool,
    /// Relative indices (inside over outside) of the reflectance of glass and of the opaque dielectric; infinite for a
    /// perfect mirror.
    glass_index: f64,
    pub(super) opaque_index: f64,
    /// What a thin film adds to the reflectance of a dielectric and of metal.
    pub(super) film: Option<(Tint, Tint)>,
    /// Directional albedo of the opaque dielectric, if rough.
    pub(super) rough: Option<Reflected>,
    /// What single scattering at the opaque dielectric loses; `None` if it is returned.
    pub(super) lost: Option<AlbedoCurve>,
    pub(super) compensation: Option<Compensation>,
}

/// Energy that single scattering loses, and the lobes that return it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Compensation {
    pub(super) mirror: AlbedoCurve,
    near: AlbedoCurve,
    far: AlbedoCurve,
    /// Cosine-weighted means of the three, in this order. Computed once: they cost more than all the rest.
    pub(super) averages: [f64; 3],
    /// Factors of the products of losses.
    pub(super) metal: Rgb,
    reflect: Rgb,
    transmit: Rgb,
    pub(super) spread: Spread,
}

/// The product of two losses. Interpolated losses may be slightly negative.
fn loss_product(a: &AlbedoCurve, w_a: AlbedoDirection, b: &AlbedoCurve, w_b: AlbedoDirection) -> f64 {
    a.at(w_a).max(0.0) * b.at(w_b).max(0.0)
}

impl Interface {
    /// `None` if nothing is reflected or transmitted specularly. `coat_alpha` is the α of the coat.
    pub(super) fn new(p: &PrincipledPoint, coat_alpha: f64) -> Option<Interface> {
        let metal = unit(p.base_metalness);
        let transmission = (1.0 - metal) * unit(p.transmission_weight);
        let opaque = (1.0 - metal) * (1.0 - unit(p.transmission_weight));
        let thin = p.thin_walled;
        let inside = !p.entering && !thin && transmission > 0.0;
        let exterior = if p.exterior_ior > 0.0 && p.exterior_ior.is_finite() { p.exterior_ior } else { 1.0 };
        let ior = if p.specular_ior >= 0.0 { p.specular_ior.min(1e6) } else { 1.0 };
        // glTF's weight is a factor of the reflectance, OpenPBR's of F₀.
        let weight = if p.gltf_specular { 1.0 } else { p.specular_weight };
        let weight = if weight >= 0.0 { weight } else { 0.0 };
        let index = ior / exterior;
        let (specular, curve) = Specular::new(p, index);
        let refracts = !thin && index > 0.0 && (index - 1.0).abs() >= MIN_CONTRAST;
        let refracting = if refracts { index } else { 1.0 };
        let weighted = |index: f64| match index {
            0.0 if weight > 0.0 => f64::INFINITY,
            0.0 => 1.0,
            _ => fresnel::scaled_index(index, weight),
        };
        let glass_index = weighted(curve);
        // Under a coat the dielectric borders on the coat. A base index below the coat's would reflect totally there,
        // which the coat's own interface undoes, so the ratio is inverted. `specular_weight` applies to the result
        // (OpenPBR). In glTF the coat does not change the base.
        let mut opaque_index = curve;
        let coat = unit(p.coat_weight);
        if coat > 0.0 && p.coat_ior > 0.0 && !p.gltf_specular {
            opaque_index += (index / p.coat_ior - index) * coat;
        }
        if opaque_index > 0.0 && opaque_index < 1.0 {
            opaque_index = 1.0 / opaque_index;
        }
        let opaque_index = weighted(opaque_index);
        let film_weight = unit(p.thin_film_weight);
        let has_film = film_weight > 0.0 && p.thin_film_thickness > 0.0 && p.thin_film_ior > 0.0;
        let reflects =
            metal > 0.0 || has_film || (opaque > 0.0 && opaque_index != 1.0 && specular.reflects());
        if !reflects && transmission == 0.0 {
            return None;
        }
        let (ax, ay) = widths(p, coat, coat_alpha);
        let smooth = ax.max(ay) < MIN_ALPHA;
        let kind = FacetKind { distribution: p.specular_distribution, masking: p.specular_masking };
        let facets = Facets { ax: ax.max(MIN_ALPHA), ay: ay.max(MIN_ALPHA), kind };
        let base = color(p.base_color) * unit(p.base_weight);
        let edge = if p.gltf_specular { Rgb::ONE } else { specular.tint };
        let metal_fresnel = match p.metal_index {
            Some(index) => Metal::of_index(index, edge, weight.min(1.0)),
            None => Metal::new(base, edge, weight.min(1.0)),
        };
        let film = has_film.then(|| {
            let thickness = p.thin_film_thickness.min(1e3) * 1e-6;
            let film = Film { ior: p.thin_film_ior.clamp(1.0, 10.0), thickness };
            film.tints(glass_index, &metal_fresnel, film_weight)
        });
        let through = if p.transmission_depth > 0.0 { Rgb::ONE } else { color(p.transmission_color) };
        let through = through * color(p.transmission_tint);
        let mut interface = Interface {
            facets,
            smooth,
            metal,
            glass: transmission,
            opaque,
            metal_fresnel,
            specular,
            through,
            eta: if inside { 1.0 / refracting } else { refracting },
            straight: !refracts && !thin,
            thin,
            inside,
            glass_index,
            opaque_index,
            film,
            rough: None,
            lost: None,
            compensation: None,
        };
        if !smooth {
            if opaque > 0.0 {
                interface.rough = Some(Reflected::new(&facets, opaque_index));
                if !p.specular_multiple_scattering && opaque_index.is_finite() {
                    interface.lost = Some(albedo::dielectric_loss(opaque_index, &facets));
                }
            }
            interface.compensation = p.specular_multiple_scattering.then(|| interface.compensate()).flatten();
        }
        Some(interface)
    }

    fn compensate(&self) -> Option<Compensation> {
        let glass = if self.straight { 0.0 } else { self.glass };
        if self.metal + glass == 0.0 {
            return None;
        }
        let mirror = albedo::mirror_loss(&self.facets);
        let mirror_average = if self.metal > 0.0 || self.thin { mirror.average().max(1e-9) } else { 1.0 };
        let f = self.metal_fresnel.average();
        let average_albedo = 1.0 - mirror_average;
        let metal =
            f * f * average_albedo / (Rgb::ONE - f * mirror_average) * (self.metal / (PI * mirror_average));
        let (mut near, mut far, mut averages) = (mirror, mirror, [mirror_average; 3]);
        let (mut reflect, mut transmit) = (Rgb::ZERO, Rgb::ZERO);
        if glass > 0.0 && self.thin {
            let (r, t) = self.glass_split(0.7);
            let scale = glass / (PI * mirror_average);
            (reflect, transmit) = (r * scale, t * scale);
        } else if glass > 0.0 {
            near = albedo::dielectric_loss(self.eta, &self.facets);
            far = albedo::dielectric_loss(1.0 / self.eta, &self.facets);
            averages = [mirror_average, near.average(), far.average()];
            // The tables are for glass whose reflectance follows from its index; with another specular weight, nothing
            // is returned.
            let above_one = |index: f64| index.max(1.0 / index);
            let same = (above_one(self.glass_index) / above_one(self.eta) - 1.0).abs() < 1e-3;
            if same && self.specular.is_plain() {
                let scale = glass / (PI * (averages[2] * self.eta * self.eta + averages[1]).max(1e-9));
                let tint = if self.inside { Rgb::ONE } else { self.specular.tint };
                (reflect, transmit) = (tint * scale, self.through * scale);
            }
        }
        let spread =
            Spread::new((0.5 * (self.facets.ax * self.facets.ax + self.facets.ay * self.facets.ay)).sqrt());
        Some(Compensation { mirror, near, far, averages, metal, reflect, transmit, spread })
    }

    /// The BRDF of multiple scattering between facets.
    pub(super) fn multi_reflect(&self, o: AlbedoDirection, i: AlbedoDirection) -> Rgb {
        let Some(c) = &self.compensation else { return Rgb::ZERO };
        let mut f = Rgb::ZERO;
        if self.metal > 0.0 {
            f += c.metal * loss_product(&c.mirror, o, &c.mirror, i);
        }
        if self.glass > 0.0 {
            f += c.reflect * loss_product(&c.near, o, &c.near, i);
        }
        f
    }

    /// The BTDF of multiple scattering between facets.
    pub(super) fn multi_transmit(&self, o: AlbedoDirection, i: AlbedoDirection) -> Rgb {
        match &self.compensation {
            Some(c) if self.glass > 0.0 => c.transmit * loss_product(&c.near, o, &c.far, i),
            _ => Rgb::ZERO,
        }
    }

    /// Albedos of the two multiple-scattering lobes for light from `w`: reflected, transmitted.
    pub(super) fn multi_albedos(&self, w: AlbedoDirection) -> (Rgb, Rgb) {
        let Some(c) = &self.compensation else { return (Rgb::ZERO, Rgb::ZERO) };
        let [mirror_average, near_average, far_average] = c.averages;
        let (mut reflected, mut transmitted) = (Rgb::ZERO, Rgb::ZERO);
        if self.metal > 0.0 {
            reflected += c.metal * (c.mirror.at(w).max(0.0) * mirror_average * PI);
        }
        if self.glass > 0.0 {
            let near = c.near.at(w).max(0.0) * PI;
            reflected += c.reflect * (near * near_average);
            transmitted = c.transmit * (near * far_average * self.eta * self.eta);
        }
        (reflected, transmitted)
    }

    /// Their sampling density.
    pub(super) fn spread(&self) -> Option<&Spread> {
        self.compensation.as_ref().map(|c| &c.spread)
    }

    /// Reflectance of the opaque dielectric at a cosine.
    fn opaque_fresnel(&self, mu: f64) -> Rgb {
        self.with_film(mu, self.opaque_index)
    }

    /// Whether reflection and refraction of glass are all there is, without multiple scattering between facets.
    pub(super) fn is_one_lobe(&self) -> bool {
        let others = [self.metal, self.opaque];
        others == [0.0; 2] && self.glass > 0.0 && !self.straight && self.compensation.is_none()
    }

    fn with_film(&self, mu: f64, index: f64) -> Rgb {
        if index == f64::INFINITY {
            return Rgb::ONE; // a film adds nothing to a perfect mirror
        }
        let plain = Rgb::splat(fresnel::dielectric(mu, index));
        match &self.film {
            None => plain,
            Some((tint, _)) => (plain + tint.at(mu)).clamp(Rgb::ZERO, Rgb::ONE),
        }
    }

    fn metal_fresnel(&self, mu: f64) -> Rgb {
        let plain = self.metal_fresnel.at(mu);
        match &self.film {
            None => plain,
            Some((_, tint)) => (plain + tint.at(mu) * self.metal_fresnel.weight).clamp(Rgb::ZERO, Rgb::ONE),
        }
    }

    /// Reflected and transmitted fraction of glass at a facet with cosine `mu`. Fresnel always uses the cosine outside,
    /// so that both directions agree even where `specular_weight` changes the reflectance but not the refraction.
    fn glass_split(&self, mu: f64) -> (Rgb, Rgb) {
        let eta = if self.straight || self.thin { 1.0 } else { self.eta };
        let Some(far) = fresnel::refracted_cosine(mu, eta) else { return (Rgb::ONE, Rgb::ZERO) };
        let r = self.with_film(if self.inside { far } else { mu }, self.glass_index);
        let (outside, kept) = self.specular.of_glass(r);
        if self.thin {
            // The series of interreflections between the two sides of the wall.
            let (r, t, c) = (kept, Rgb::ONE - kept, self.through);
            let series = (Rgb::ONE - r * r * c * c).max(Rgb::splat(1e-9));
            let back = t * t * r * c * c / series;
            let reflected = match self.specular.is_plain() {
                true => self.specular.tint * (r + back),
                false => outside + back,
            };
            return (reflected, t * t * c / series);
        }
        (if self.inside { kept } else { outside }, (Rgb::ONE - kept) * self.through)
    }

    /// Reflected and transmitted fraction at a facet, without light that passes straight.
    pub(super) fn split(&self, mu: f64) -> (Rgb, Rgb) {
        let (mut r, mut t) = (Rgb::ZERO, Rgb::ZERO);
        if self.metal > 0.0 {
            r += self.metal_fresnel(mu) * self.metal;
        }
        if self.opaque > 0.0 {
            r += self.specular.at(self.opaque_fresnel(mu)) * self.opaque;
        }
        if self.glass > 0.0 {
            let (glass_r, glass_t) = self.glass_split(mu);
            r += glass_r * self.glass;
            if !self.straight {
                t += glass_t * self.glass;
            }
        }
        (r, t)
    }

    /// Fraction that passes straight through glass of equal indices.
    pub(super) fn straight_transmission(&self, mu: f64) -> Rgb {
        if self.straight && self.glass > 0.0 { self.glass_split(mu).1 * self.glass } else { Rgb::ZERO }
    }

    /// Fraction of light from `w` that the opaque dielectric transmits to the diffuse base; the same for all bands.
    pub(super) fn below(&self, w: AlbedoDirection) -> f64 {
        let boundary = match &self.rough {
            Some(rough) => rough.at(w),
            None => fresnel::dielectric(w.mu, self.opaque_index),
        };
        let mut reflected = Rgb::splat(boundary);
        if let Some((tint, _)) = &self.film {
            reflected += self.average_over_facets(w.mu, tint);
        }
        let lost = self.lost.map_or(0.0, |loss| loss.at(w).max(0.0));
        let reflected =
            self.specular.most(reflected, || 1.0 - self.mirror_loss().map_or(0.0, |loss| loss.at(w)));
        (1.0 - reflected - lost).max(0.0)
    }

    /// The loss of single scattering if all light is reflected; `None` if smooth.
    pub(super) fn mirror_loss(&self) -> Option<AlbedoCurve> {
        (!self.smooth).then(|| albedo::mirror_loss(&self.facets))
    }

    /// What a film adds to the reflectance of a rough surface: the mean over visible facets.
    fn average_over_facets(&self, mu: f64, tint: &Tint) -> Rgb {
        if self.smooth {
            return tint.at(mu);
        }
        let wo = DVec3::new((1.0 - mu * mu).max(0.0).sqrt(), 0.0, mu.max(1e-6));
        let g1 = self.facets.g1(wo);
        let mut sum = Rgb::ZERO;
        for i in 0..4 {
            for j in 0..4 {
                let u = [(f64::from(i) + 0.5) / 4.0, (f64::from(j) + 0.5) / 4.0];
                let h = self.facets.sample_visible(wo, u);
                let wi = reflect(-wo, h);
                if wi.z > 0.0 {
                    sum += tint.at(wo.dot(h)) * (self.facets.g2(wo, wi) / g1);
                }
            }
        }
        sum / 16.0
    }

    /// Cosine-weighted mean of [`Interface::below`]; `None` if it has no closed form.
    pub(super) fn below_average(&self) -> Option<f64> {
        if self.film.is_some() {
            return None;
        }
        let boundary = match &self.rough {
            Some(rough) => rough.average(),
            None => fresnel::dielectric_average(self.opaque_index),
        };
        let white = || 1.0 - self.mirror_loss().map_or(0.0, |loss| loss.average());
        let lost = self.lost.map_or(0.0, |loss| loss.average());
        Some((1.0 - self.specular.most(Rgb::splat(boundary), white) - lost).max(0.0))
    }

    /// BRDF of single scattering and its density; (0, 0) for delta lobes.
    pub(super) fn reflect(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
        if self.smooth {
            return (Rgb::ZERO, 0.0);
        }
        let h = (wo + wi).normalize();
        let mu = wo.dot(h);
        let d = self.facets.d(h);
        if d == 0.0 {
            return (Rgb::ZERO, 0.0); // far from a narrow lobe of Beckmann's distribution
        }
        let (r, t) = self.split(mu);
        let (lo, li) = (self.facets.lambda(wo), self.facets.lambda(wi));
        let f = r * (d / (self.facets.masking(lo, li) * 4.0 * wo.z * wi.z));
        (f, d / ((1.0 + lo) * 4.0 * wo.z) * reflection_probability(r, t))
    }

    /// BTDF of single scattering and its density.
    pub(super) fn transmit(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
        if self.smooth || self.straight || self.glass == 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        if self.thin {
            let wi = DVec3::new(wi.x, wi.y, -wi.z);
            let h = (wo + wi).normalize();
            let (r, t) = self.split(wo.dot(h));
            let d = self.facets.d(h);
            let (lo, li) = (self.facets.lambda(wo), self.facets.lambda(wi));
            let f = t * (d / (self.facets.masking(lo, li) * 4.0 * wo.z * wi.z));
            return (f, d / ((1.0 + lo) * 4.0 * wo.z) * (1.0 - reflection_probability(r, t)));
        }
        let h = wo + wi * self.eta;
        let length = h.length();
        if length.is_nan() || length <= 1e-12 {
            return (Rgb::ZERO, 0.0);
        }
        let h = h * (1.0 / length).copysign(h.z);
        let (o, i) = (wo.dot(h), wi.dot(h));
        let d = self.facets.d(h);
        if o <= 0.0 || i >= 0.0 || d == 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        let (r, t) = self.split(o);
        let root = o + self.eta * i;
        let (go, gi) = (self.facets.g1(wo), self.facets.g1(wi));
        // Walter et al. 2007, equations 21 and 17, for radiance: no factor η².
        let common = d * o * -i * go / (root * root * wo.z);
        let f = t * (common * gi / -wi.z);
        (f, common * self.eta * self.eta * (1.0 - reflection_probability(r, t)))
    }

    /// Samples a visible facet; `u[0]` chooses reflection or transmission. The facet of a smooth interface is the
    /// surface itself.
    pub(super) fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<Choice> {
        let h = if self.smooth { DVec3::Z } else { self.facets.sample_visible(wo, [u[1], u[2]]) };
        let mu = wo.dot(h);
        let (r, t) = self.split(mu.clamp(0.0, 1.0));
        let probability = reflection_probability(r, t);
        if u[0] < probability {
            let wi = reflect(-wo, h);
            return (wi.z > 0.0).then_some(Choice { wi, transmits: false, color: r, probability });
        }
        let wi = if self.thin {
            let wi = reflect(-wo, h);
            DVec3::new(wi.x, wi.y, -wi.z)
        } else {
            crate::math::refract(-wo, h, 1.0 / self.eta)?.normalize()
        };
        (wi.z < 0.0).then_some(Choice { wi, transmits: true, color: t, probability: 1.0 - probability })
    }
}

/// The result of [`Interface::sample`].
pub(super) struct Choice {
    pub(super) wi: DVec3,
    pub(super) transmits: bool,
    /// Fraction of light that the facet sends there, and the probability of the choice.
    pub(super) color: Rgb,
    pub(super) probability: f64,
}

/// Probability of sampling the reflection at a facet.
fn reflection_probability(r: Rgb, t: Rgb) -> f64 {
    let (r, t) = (r.element_sum(), t.element_sum());
    // Subnormal sums have no reliable quotient.
    if r + t > f64::MIN_POSITIVE { (r / (r + t)).clamp(0.0, 1.0) } else { 1.0 }
}
