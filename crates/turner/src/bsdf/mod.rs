//! BSDFs: the scattering of light at a surface point, and the sampling of directions to continue a path.
//!
//! Contract of every lobe:
//!
//! - Directions are unit vectors in the local frame, whose +z is the shading normal on wo's side. They point away from
//!   the surface: `wo` is the direction in which light leaves, `wi` the direction from which it arrives.
//! - `f` is without the cosine. A pdf is per solid angle. The path weight is f·|wi.z| / pdf.
//! - [`sample`](Bsdf::sample) takes three random numbers in 0..1. Its `f` and `pdf` are sums over all lobes, equal to
//!   [`eval_pdf`](Bsdf::eval_pdf). `None` means no sample: the remaining light is absorbed and the path ends.
//! - Delta lobes return 0 from [`eval`](Bsdf::eval) and [`pdf`](Bsdf::pdf). Of their samples only the quotient f / pdf
//!   has a meaning.
//! - Radiance is transported, so transmission is divided by eta², where eta is the index of refraction on wi's side
//!   over that on wo's (Veach 1997, chapter 5). Hence f(wo, wi) = f(wi, wo) on one side, and f(wo, wi) · eta² = f(wi,
//!   wo) across the surface.
//! - Where `wo` is not above the surface, f and pdf are 0 and there is no sample.
//!
//! A [`Bsdf`] is layered after OpenPBR 1.1:
//!
//! ```text
//!    wo    n = +z   wi
//!      \     |     /         fuzz       Charlie sheen
//!   ~~~~\~~~~|~~~~/~~~~~~~
//!        \   |   /           coat       smooth or GGX dielectric, absorbs, own normal
//!   ------\--|--/---------   film       changes the Fresnel term of the interface
//!          \ | /             interface  facets: metal | glass | opaque dielectric
//!   ========\|/===========
//!            *               diffuse    EON reflection, transmission (thin walls), subsurface entry
//! ```
//!
//! The layers together have no closed form. Instead each lobe is attenuated by the transmittance of the layers above
//! it, T(µ) = 1 − directional albedo (module `albedo`). The factors are symmetric, so the sum is reciprocal, and it
//! creates no energy:
//!
//! - Diffuse lobes: T(µo) T(µi) / T̄, T̄ the cosine-weighted mean (Kelemen and Szirmay-Kalos 2001). A Lambertian lobe
//!   keeps exactly T(µo); rough diffuse lobes keep a little less.
//! - Specular lobes under coat and fuzz: min(T(µo), T(µi)), which loses a little at grazing angles.
//! - The colours of metal, coat and fuzz absorb. Under a dielectric with a `specular_color`, all bands of the diffuse
//!   lobe are attenuated by the reflection of the strongest band.
//!
//! Hair ([`Bsdf::hair`]), Disney's principled BSDF ([`Bsdf::disney`]) and measured BRDFs ([`Bsdf::measured`]) have none of
//! these layers: modules `hair`, `disney` and `measured`.
//!
//! Sampling chooses one lobe in proportion to its approximate albedo seen from wo, then a direction: cosine-weighted
//! (diffuse), visible normals (coat, interface), uniform (fuzz), near grazing (multiple scattering between facets).
//! Dividing by the pdf of all lobes is one-sample MIS with the balance heuristic (Veach 1997, §9.2.4).

mod albedo;
mod beckmann;
mod beckmann_x8;
mod block;
mod coat;
mod diffuse;
mod disney;
mod facets;
mod facets_x8;
mod film;
mod fresnel;
mod fresnel_x8;
mod fuzz;
mod hair;
mod interface;
mod measured;
mod microfacet;
mod mixture;
mod opaque_base;
mod pane;
mod parts;
mod point;
mod specular;
mod spread;
mod subsurface;
mod terminator;
mod unlayered;

pub(crate) use block::{Bands, BsdfBlock, LambertBlock, Sampled};
pub(crate) use diffuse::sample_cosine;
pub use disney::DisneyPoint;
pub use facets::{FacetDistribution, FacetMasking};
pub use fresnel::MetalIndex;
pub use fresnel::conductor;
pub use hair::{HairPoint, color_of_sigma_a, sigma_a_of_color, sigma_a_of_melanin};
pub use measured::Measured;
pub(crate) use mixture::MIN_COSINE;
pub(crate) use opaque_base::{OpaqueBase, OpaqueBlock, OpaqueSeen};
pub(crate) use parts::MOST_DELTAS;
pub use point::PrincipledPoint;
pub use subsurface::Entry;
pub(crate) use terminator::{Terminator, TerminatorX8};

use albedo::AlbedoDirection;
use coat::Coat;
use fuzz::Charlie;
use interface::Interface;
use unlayered::Unlayered;

use crate::color::Spectrum;
use crate::math::DVec3;
use crate::math::elementary::sin_cos;

/// Linear RGB in f64.
pub(crate) type Rgb = DVec3;

/// The kind of lobe that a sample belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lobe {
    /// A delta lobe: a perfect mirror or smooth glass.
    pub is_delta: bool,
    /// The sample is on the other side of the surface.
    pub is_transmission: bool,
    /// Diffuse, fuzz or multiple scattering between facets.
    pub is_diffuse: bool,
}

/// A sampled direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// Direction that light comes from, local.
    pub wi: DVec3,
    /// The BSDF without the cosine: f·|wi.z| / pdf is the path weight. For delta lobes only that quotient has a
    /// meaning.
    pub f: Spectrum,
    /// Density of `wi` per solid angle over all lobes; for delta lobes the probability of the lobe. Greater than 0.
    pub pdf: f64,
    /// The lobe.
    pub lobe: Lobe,
    /// Index of refraction on wi's side over that on wo's; 1 unless the sample is refracted.
    pub eta: f64,
}

/// The BSDF at a surface point. `'m` is the life of the material, whose tables it may refer to.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf<'m> {
    /// Cosine and sine of the angle from x to the direction of anisotropy.
    rotation: Option<(f64, f64)>,
    /// Whether wo is inside glass.
    inside: bool,
    thin: bool,
    fuzz: Option<Fuzz>,
    coat: Option<Coat>,
    /// The coat's own normal in the anisotropy frame, if any.
    coat_normal: Option<DVec3>,
    interface: Option<Interface>,
    diffuse: Diffuse,
    /// Lambertian reflection only.
    lambert: bool,
    /// Glass of single scattering, and nothing else: the interface is the only lobe.
    glass_alone: bool,
    /// Light that leaves the interior after a subsurface random walk: see [`Bsdf::leaving`].
    exits: bool,
    /// Another model, instead of all layers.
    unlayered: Option<Unlayered<'m>>,
}

#[derive(Clone, Copy, Debug)]
struct Fuzz {
    /// Fraction of the surface covered.
    weight: f64,
    color: Rgb,
    charlie: Charlie,
}

/// The diffuse base under all layers.
#[derive(Clone, Copy, Debug)]
struct Diffuse {
    /// Albedos, weights included.
    reflect: Rgb,
    transmit: Rgb,
    /// Albedo of the light that enters and is scattered inside (subsurface).
    enter: Rgb,
    /// Fraction of the surface where light may enter.
    enter_weight: f64,
    /// Fraction of the surface that is diffuse. The rough BRDF has the albedo `reflect` / `weight`.
    weight: f64,
    roughness: f64,
    /// T̄, the mean transmittance of the layers above: the divisor of T(µo) T(µi).
    normalisation: f64,
}

impl Bsdf<'static> {
    /// The BSDF of an OpenPBR material at a point.
    pub fn new(p: &PrincipledPoint) -> Bsdf<'static> {
        let interface = Interface::new(p, Coat::alpha(p));
        let diffuse_weight = (1.0 - unit(p.base_metalness)) * (1.0 - unit(p.transmission_weight));
        let (base, translucent) = (base_albedo(p.base_color, p.base_weight), color(p.subsurface_color));
        let subsurface = unit(p.subsurface_weight);
        let (reflect, transmit, enter) = if p.thin_walled {
            let (reflect, transmit) = thin_albedos(p, subsurface);
            (reflect, transmit, Rgb::ZERO)
        } else if p.subsurface_walk && p.entering {
            (base * (1.0 - subsurface), Rgb::ZERO, translucent * subsurface)
        } else {
            (base.lerp(translucent, subsurface), Rgb::ZERO, Rgb::ZERO)
        };
        let glass = (1.0 - unit(p.base_metalness)) * unit(p.transmission_weight);
        let albedo =
            base * unit(p.base_metalness) + (reflect + transmit + enter) * diffuse_weight + Rgb::splat(glass);
        let roughness = diffuse_weight + (1.0 - diffuse_weight) * unit(p.specular_roughness);
        let fuzz_weight = unit(p.fuzz_weight);
        let mut bsdf = Bsdf {
            rotation: rotation(p),
            inside: !p.entering && !p.thin_walled && glass > 0.0,
            thin: p.thin_walled,
            fuzz: (fuzz_weight > 0.0).then(|| Fuzz {
                weight: fuzz_weight,
                color: color(p.fuzz_color),
                charlie: Charlie::new(unit(p.fuzz_roughness)),
            }),
            coat: Coat::new(p, albedo.clamp(Rgb::ZERO, Rgb::ONE), roughness),
            coat_normal: None,
            interface,
            diffuse: Diffuse {
                reflect: reflect * diffuse_weight,
                transmit: transmit * diffuse_weight,
                enter: enter * diffuse_weight,
                enter_weight: if enter == Rgb::ZERO { 0.0 } else { subsurface * diffuse_weight },
                weight: diffuse_weight,
                roughness: unit(p.base_diffuse_roughness),
                normalisation: 1.0,
            },
            lambert: false,
            glass_alone: false,
            exits: false,
            unlayered: None,
        };
        bsdf.diffuse.normalisation = bsdf.diffuse_normalisation();
        bsdf.lambert = bsdf.is_lambert();
        bsdf.glass_alone = bsdf.is_glass_alone();
        bsdf
    }

    /// Lambertian reflection of an albedo within 0..=1.
    pub fn lambert(albedo: Spectrum) -> Bsdf<'static> {
        let mut bsdf = Bsdf {
            rotation: None,
            inside: false,
            thin: false,
            fuzz: None,
            coat: None,
            coat_normal: None,
            interface: None,
            diffuse: Diffuse {
                reflect: color(albedo),
                transmit: Rgb::ZERO,
                enter: Rgb::ZERO,
                enter_weight: 0.0,
                weight: 1.0,
                roughness: 0.0,
                normalisation: 1.0,
            },
            lambert: false,
            glass_alone: false,
            exits: false,
            unlayered: None,
        };
        bsdf.lambert = bsdf.is_lambert();
        bsdf
    }
}

impl<'m> Bsdf<'m> {
    /// An opaque dielectric base, which has a diffuse lobe, with another albedo of that lobe; `None` if it has none then.
    pub(crate) fn with_base_albedo(&self, albedo: Rgb) -> Option<Bsdf<'m>> {
        let diffuse = Diffuse { reflect: albedo, ..self.diffuse };
        (albedo != Rgb::ZERO && self.diffuse.reflect != Rgb::ZERO).then_some(Bsdf { diffuse, ..*self })
    }

    /// The BSDF with a separate coat normal `n`, a unit vector above the surface. The coat's lobe uses the cosine to
    /// that normal, which preserves its energy but makes it non-reciprocal.
    pub fn with_coat_normal(mut self, n: DVec3) -> Bsdf<'m> {
        let n = self.in_aniso_frame(n);
        if self.coat.is_some() && n.z > 0.0 && n.z < 1.0 - 1e-12 {
            self.coat_normal = Some(n);
        }
        self
    }

    /// The constant BRDF of a purely Lambertian surface; `None` for all other BSDFs.
    pub fn as_lambert(&self) -> Option<Spectrum> {
        self.lambert.then(|| lambert(self.diffuse.reflect))
    }

    fn is_lambert(&self) -> bool {
        self.fuzz.is_none()
            && self.coat.is_none()
            && self.interface.is_none()
            && self.diffuse.transmit == Rgb::ZERO
            && self.diffuse.enter == Rgb::ZERO
            && self.diffuse.reflect != Rgb::ZERO
            && self.diffuse.roughness < diffuse::MIN_ROUGHNESS
    }

    fn is_glass_alone(&self) -> bool {
        let is_bare = self.fuzz.is_none() && self.coat.is_none() && self.diffuse.weight == 0.0;
        is_bare && self.interface.as_ref().is_some_and(Interface::is_one_lobe)
    }

    /// The BSDF without the cosine, for light from `wi` that leaves towards `wo`.
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> Spectrum {
        self.eval_pdf(wo, wi).0
    }

    /// Density with which [`sample`](Bsdf::sample) finds `wi`, per solid angle.
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.eval_pdf(wo, wi).1
    }

    /// [`eval`](Bsdf::eval) and [`pdf`](Bsdf::pdf) together, for little more than the cost of one.
    pub fn eval_pdf(&self, wo: DVec3, wi: DVec3) -> (Spectrum, f64) {
        self.towards(wo).eval_pdf(wi)
    }

    /// Samples a direction that light comes from. `u`, each in 0..1: `u[0]` chooses the lobe, `u[1]` and `u[2]` the
    /// direction. `None` if nothing is scattered: the path ends.
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        self.towards(wo).sample(u)
    }

    /// The BSDF seen from a fixed `wo`, for several evaluations and samples.
    pub fn towards(&self, wo: DVec3) -> BsdfFromWo<'_> {
        let wo = self.in_aniso_frame(wo);
        let (above, p) = self.prepare_wo(wo);
        BsdfFromWo { bsdf: self, wo, above, p, terminator: None }
    }

    /// Whether any lobe is not a delta lobe, so that lights can be sampled.
    pub fn has_smooth(&self) -> bool {
        self.unlayered.is_some()
            || self.fuzz.is_some()
            || self.coat.as_ref().is_some_and(|c| !c.smooth)
            || self.interface.as_ref().is_some_and(|i| !i.smooth)
            || self.diffuse.reflect != Rgb::ZERO
            || self.diffuse.transmit != Rgb::ZERO
    }

    /// Mean roughness, weighted by albedo: 0 is a mirror or clear glass, 1 is diffuse.
    pub fn roughness_hint(&self) -> f64 {
        if let Some(whole) = &self.unlayered {
            return whole.roughness();
        }
        let rough = |smooth: bool, alpha: f64| if smooth { 0.0 } else { alpha.sqrt() };
        // All other lobes are diffuse, or nearly.
        let mut roughness = [1.0; mixture::LOBES];
        roughness[mixture::COAT] = self.coat.as_ref().map_or(0.0, |c| rough(c.smooth, c.facets.ax));
        roughness[mixture::INTERFACE] =
            self.interface.as_ref().map_or(0.0, |i| rough(i.smooth, (i.facets.ax * i.facets.ay).sqrt()));
        roughness[mixture::PASS] = 0.0;
        let (mut sum, mut weights) = (0.0, 0.0);
        for (albedo, roughness) in
            self.albedos(self.above(AlbedoDirection::all(1.0))).into_iter().zip(roughness)
        {
            sum += albedo.element_sum() * roughness;
            weights += albedo.element_sum();
        }
        if weights > 0.0 { sum / weights } else { 1.0 }
    }

    /// Approximate fraction of light at normal incidence that is reflected or transmitted, each band within 0..=1.
    pub fn albedo_hint(&self) -> Spectrum {
        if let Some(whole) = &self.unlayered {
            return spectrum(whole.albedo().clamp(Rgb::ZERO, Rgb::ONE));
        }
        let sum: Rgb = self.albedos(self.above(AlbedoDirection::all(1.0))).into_iter().sum();
        spectrum(sum.clamp(Rgb::ZERO, Rgb::ONE))
    }

    fn in_aniso_frame(&self, w: DVec3) -> DVec3 {
        match self.rotation {
            None => w,
            Some((cos, sin)) => DVec3::new(cos * w.x + sin * w.y, cos * w.y - sin * w.x, w.z),
        }
    }

    fn out_of_aniso_frame(&self, w: DVec3) -> DVec3 {
        match self.rotation {
            None => w,
            Some((cos, sin)) => DVec3::new(cos * w.x - sin * w.y, cos * w.y + sin * w.x, w.z),
        }
    }
}

/// The BSDF seen from a fixed wo. The transmittance of the layers and the lobe probabilities are computed once.
#[derive(Clone, Copy)]
pub struct BsdfFromWo<'a> {
    bsdf: &'a Bsdf<'a>,
    /// In the anisotropy frame.
    wo: DVec3,
    above: mixture::Above,
    p: mixture::LobeProbabilities,
    /// Where diffuse reflection is softened; in the anisotropy frame.
    terminator: Option<Terminator>,
}

impl<'a> BsdfFromWo<'a> {
    /// The BSDF whose diffuse reflection is softened at the shadow terminator of a smooth mesh.
    pub(crate) fn softened(self, terminator: Terminator) -> BsdfFromWo<'a> {
        let terminator = terminator.turned(|n| self.bsdf.in_aniso_frame(n));
        BsdfFromWo { terminator: Some(terminator), ..self }
    }

    /// The BSDF for any direction on the same side; `None` if its coat has a normal of its own, which depends on wo, or if
    /// it is a hair, whose offset depends on wo.
    pub(crate) fn at_any_wo(&self) -> Option<&'a Bsdf<'a>> {
        let is_for_any = self.bsdf.unlayered.as_ref().is_none_or(Unlayered::is_for_any_wo);
        (self.bsdf.coat_normal.is_none() && is_for_any).then_some(self.bsdf)
    }
}

impl BsdfFromWo<'_> {
    /// See [`Bsdf::as_lambert`].
    #[inline]
    pub fn as_lambert(&self) -> Option<Spectrum> {
        self.bsdf.as_lambert()
    }

    /// See [`Bsdf::eval_pdf`].
    #[inline]
    pub fn eval_pdf(&self, wi: DVec3) -> (Spectrum, f64) {
        let wi = self.bsdf.in_aniso_frame(wi);
        let (f, pdf) = self.bsdf.mixture(self.wo, wi, &self.above, &self.p, self.terminator.as_ref());
        (spectrum(f), pdf)
    }

    /// The factor of diffuse reflection for light from `wi`, which [`eval_pdf`](BsdfFromWo::eval_pdf) contains.
    #[inline]
    pub(crate) fn softening(&self, wi: DVec3) -> f64 {
        self.terminator.as_ref().map_or(1.0, |t| t.softening(self.bsdf.in_aniso_frame(wi)))
    }

    /// Fraction of light from behind that passes straight through a thin smooth wall: the mean weight of the samples
    /// that pass straight.
    pub fn straight(&self) -> Spectrum {
        self.bsdf.straight(self.wo)
    }

    /// See [`Bsdf::has_smooth`].
    pub fn has_smooth(&self) -> bool {
        self.bsdf.has_smooth()
    }

    /// See [`Bsdf::sample`].
    #[inline]
    pub fn sample(&self, u: [f64; 3]) -> Option<BsdfSample> {
        let mut sample =
            self.bsdf.sample_mixture(self.wo, u, &self.above, &self.p, self.terminator.as_ref())?;
        sample.wi = self.bsdf.out_of_aniso_frame(sample.wi);
        Some(sample)
    }
}

fn rotation(p: &PrincipledPoint) -> Option<(f64, f64)> {
    let round = match p.alpha {
        Some((x, y)) => x == y,
        None => unit(p.specular_roughness_anisotropy) == 0.0,
    };
    let angle = p.anisotropy_rotation;
    (!round && angle != 0.0 && angle.is_finite()).then(|| {
        let (sin, cos) = sin_cos(angle);
        (cos, sin)
    })
}

/// What a thin wall reflects and transmits diffusely, of which the fraction `subsurface` transmits. Each colour may exceed
/// 1 where its fraction makes up for it; together they do not.
fn thin_albedos(p: &PrincipledPoint, subsurface: f64) -> (Rgb, Rgb) {
    let of = |c: Spectrum, weight: f64| {
        let band = |v: f32| if v > 0.0 { (f64::from(v) * weight).min(1.0) } else { 0.0 };
        Rgb::new(band(c.r), band(c.g), band(c.b))
    };
    let reflect = of(p.base_color, unit(p.base_weight) * (1.0 - subsurface));
    let transmit = of(p.subsurface_color, subsurface);
    let scale = (reflect + transmit).max(Rgb::ONE).recip();
    (reflect * scale, transmit * scale)
}

/// Clamps to 0..=1; 0 for NaN.
fn unit(v: f64) -> f64 {
    if v > 0.0 { v.min(1.0) } else { 0.0 }
}

/// The Lambertian BRDF of an albedo.
pub(crate) fn lambert(albedo: Rgb) -> Spectrum {
    spectrum(albedo / std::f64::consts::PI)
}

/// The albedo of an opaque diffuse base without subsurface scattering.
pub(crate) fn base_albedo(base_color: Spectrum, base_weight: f64) -> Rgb {
    color(base_color) * unit(base_weight)
}

fn color(c: Spectrum) -> Rgb {
    Rgb::new(unit(f64::from(c.r)), unit(f64::from(c.g)), unit(f64::from(c.b)))
}

fn spectrum(c: Rgb) -> Spectrum {
    Spectrum::new(c.x as f32, c.y as f32, c.z as f32)
}

#[cfg(test)]
mod tests;
