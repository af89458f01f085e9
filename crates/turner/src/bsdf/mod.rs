//! Scattering at a point of a surface: how much light from one direction leaves in another, and directions to continue a path.
//!
//! The contract, which every lobe keeps:
//!
//! - Directions are unit vectors in the local frame, whose +z is the shading normal on wo's side, and point away from the surface: `wo` to where
//!   light goes, `wi` to where it comes from.
//! - `f` is without the cosine. A pdf is per solid angle. A path's weight is f·|wi.z| / pdf.
//! - [`sample`](Bsdf::sample) takes three numbers in 0..1. Its `f` and `pdf` are those of all lobes together, as [`eval_pdf`](Bsdf::eval_pdf) gives them. `None`
//!   is no sample: the light that remains is absorbed, and the path ends.
//! - Delta lobes return 0 from [`eval`](Bsdf::eval) and [`pdf`](Bsdf::pdf). What `sample` says of them has a meaning as the quotient alone.
//! - Radiance is transported: what crosses into a medium of `eta` times the index is divided by eta² (Walter et al. 2007), so f(wo, wi) = f(wi, wo) on one side
//!   and f(wo, wi) · eta² = f(wi, wo) seen from the other.
//! - Where `wo` is not above the surface everything is 0 and there is no sample.
//!
//! A [`Bsdf`] is layered after OpenPBR 1.1: fuzz over a coat over a base that mixes metal, glass and a diffuse body under a
//! dielectric boundary. Layers are combined by their albedos, symmetrically, so that all stays reciprocal and no energy appears:
//!
//! - A diffuse lobe under layers of transmittance T(µ) is scaled by T(µo) T(µi) / T̄ (Kelemen and Szirmay-Kalos 2001), which leaves
//!   exactly T(µo) of it; rough diffuse lobes, which are not flat, by a little less.
//! - Specular lobes under coat and fuzz are scaled by the smaller of T(µo) and T(µi), which loses a little at grazing angles.
//! - Colours of metal, coat and fuzz absorb; the dielectric's `specular_color` takes from the body what its strongest band does.

mod albedo;
mod coat;
mod diffuse;
mod film;
mod fresnel;
mod fuzz;
mod interface;
mod microfacet;
mod mixture;
mod pane;
mod point;
mod rough_mirror;
mod subsurface;

pub(crate) use diffuse::sample_cosine;
pub(crate) use mixture::MIN_COSINE;
pub use point::PrincipledPoint;
pub use rough_mirror::{RoughMirror, RoughMirrorBlock};
pub use subsurface::Entry;

use albedo::AlbedoDirection;
use coat::Coat;
use fuzz::Charlie;
use interface::Interface;

use crate::color::Spectrum;
use crate::math::DVec3;
use crate::math::elementary::sin_cos;

/// A colour in f64.
type Rgb = DVec3;

/// What a sample went through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lobe {
    /// A single direction: a mirror, or smooth glass.
    pub is_delta: bool,
    /// To the other side of the surface.
    pub is_transmission: bool,
    /// Diffuse, or fuzz: the path forgets where it came from.
    pub is_diffuse: bool,
}

/// A sampled direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// Where light comes from.
    pub wi: DVec3,
    /// The BSDF, without the cosine: f·|wi.z| / pdf is the weight of the path. For delta lobes only that quotient has a meaning.
    pub f: Spectrum,
    /// Density of `wi` per solid angle over all lobes; for delta lobes the probability of the lobe. Greater than 0.
    pub pdf: f64,
    /// What it went through.
    pub lobe: Lobe,
    /// Index of refraction on wi's side over that on wo's; 1 unless transmitted through a boundary that bends light.
    pub eta: f64,
}

/// The scattering of light at a point.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf {
    /// Cosine and sine of the angle from x to the direction of anisotropy.
    rotation: Option<(f64, f64)>,
    /// Whether wo is inside glass.
    inside: bool,
    thin: bool,
    fuzz: Option<Fuzz>,
    coat: Option<Coat>,
    /// The coat's own normal, turned as directions are, where it has one.
    coat_normal: Option<DVec3>,
    interface: Option<Interface>,
    diffuse: Diffuse,
    /// Lambert's reflection and nothing else.
    lambert: bool,
    /// What leaves the inside of a translucent body: see [`Bsdf::leaving`].
    leaves: bool,
}

#[derive(Clone, Copy, Debug)]
struct Fuzz {
    /// Share covered.
    weight: f64,
    color: Rgb,
    charlie: Charlie,
}

/// The body under all boundaries.
#[derive(Clone, Copy, Debug)]
struct Diffuse {
    /// Albedos, shares included.
    reflect: Rgb,
    transmit: Rgb,
    /// What comes back of light that enters and walks about inside.
    enter: Rgb,
    /// Share of the surface that it may enter.
    enter_share: f64,
    /// Share of the surface, for the BRDF of a rough body, whose albedo is `reflect` / `share`.
    share: f64,
    roughness: f64,
    /// What the layers above let through: of light from all around, and what the products of transmittances are divided by.
    through: f64,
}

impl Bsdf {
    /// Of a physical material at a point.
    pub fn new(p: &PrincipledPoint) -> Bsdf {
        let interface = Interface::new(p, Coat::alpha(p));
        let share = (1.0 - unit(p.base_metalness)) * (1.0 - unit(p.transmission_weight));
        let (base, translucent) = (color(p.base_color) * unit(p.base_weight), color(p.subsurface_color));
        let subsurface = unit(p.subsurface_weight);
        let (reflect, transmit, enter) = if p.thin_walled {
            (base * (1.0 - subsurface), translucent * subsurface, Rgb::ZERO)
        } else if p.subsurface_walk && p.entering {
            (base * (1.0 - subsurface), Rgb::ZERO, translucent * subsurface)
        } else {
            (base.lerp(translucent, subsurface), Rgb::ZERO, Rgb::ZERO)
        };
        let glass = (1.0 - unit(p.base_metalness)) * unit(p.transmission_weight);
        let albedo = base * unit(p.base_metalness) + (reflect + transmit + enter) * share + Rgb::splat(glass);
        let roughness = share + (1.0 - share) * unit(p.specular_roughness);
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
                reflect: reflect * share,
                transmit: transmit * share,
                enter: enter * share,
                enter_share: if enter == Rgb::ZERO { 0.0 } else { subsurface * share },
                share,
                roughness: unit(p.base_diffuse_roughness),
                through: 1.0,
            },
            lambert: false,
            leaves: false,
        };
        bsdf.diffuse.through = bsdf.diffuse_normalisation();
        bsdf.lambert = bsdf.is_lambert();
        bsdf
    }

    /// Lambert's diffuse reflection of an albedo within 0..=1.
    pub fn lambert(albedo: Spectrum) -> Bsdf {
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
                enter_share: 0.0,
                share: 1.0,
                roughness: 0.0,
                through: 1.0,
            },
            lambert: false,
            leaves: false,
        };
        bsdf.lambert = bsdf.is_lambert();
        bsdf
    }

    /// The same with a normal of the coat's own, a unit vector above the surface. The coat's light counts by the cosine to that normal, so that it
    /// keeps its energy; it is not reciprocal then.
    pub fn with_coat_normal(mut self, n: DVec3) -> Bsdf {
        let n = self.turned(n);
        if self.coat.is_some() && n.z > 0.0 && n.z < 1.0 - 1e-12 {
            self.coat_normal = Some(n);
        }
        self
    }

    /// What Lambert's reflection and nothing else returns of light from any direction above the surface; `None` for all other BSDFs.
    pub fn as_lambert(&self) -> Option<Spectrum> {
        self.lambert.then(|| spectrum(self.diffuse.reflect / std::f64::consts::PI))
    }

    /// The rough mirror that this is, if it is nothing else.
    pub fn as_rough_mirror(&self) -> Option<RoughMirror> {
        let bare = self.fuzz.is_none()
            && self.coat.is_none()
            && self.rotation.is_none()
            && self.diffuse.reflect == Rgb::ZERO
            && self.diffuse.transmit == Rgb::ZERO
            && self.diffuse.enter == Rgb::ZERO
            && !self.inside;
        let interface = self.interface.as_ref().filter(|_| bare)?;
        let color = interface.rough_mirror()?;
        // As all lobes share one's probability, to the last bit.
        let sum = color.element_sum();
        let share = sum * (1.0 / sum);
        let black = spectrum(color).is_black() || sum <= f64::MIN_POSITIVE;
        (!black && share > 0.0).then_some(RoughMirror { ggx: interface.ggx, color, share })
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

    /// The BSDF without the cosine, for light from `wi` that leaves towards `wo`.
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> Spectrum {
        self.eval_pdf(wo, wi).0
    }

    /// Density with which [`sample`](Bsdf::sample) finds `wi`, per solid angle.
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.eval_pdf(wo, wi).1
    }

    /// Both at once, for little more than the price of one.
    pub fn eval_pdf(&self, wo: DVec3, wi: DVec3) -> (Spectrum, f64) {
        self.towards(wo).eval_pdf(wi)
    }

    /// A direction that light comes from; each number of `u` is within 0..1. `None` where there is nothing to follow: the path ends.
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        self.towards(wo).sample(u)
    }

    /// The scattering of light that leaves towards `wo`: for several questions about it.
    pub fn towards(&self, wo: DVec3) -> BsdfFromWo<'_> {
        let wo = self.turned(wo);
        let (above, p) = self.seen(wo);
        BsdfFromWo { bsdf: self, wo, above, p }
    }

    /// Whether any lobe is not a delta lobe: whether lights can be connected to.
    pub fn has_smooth(&self) -> bool {
        self.fuzz.is_some()
            || self.coat.as_ref().is_some_and(|c| !c.smooth)
            || self.interface.as_ref().is_some_and(|i| !i.smooth)
            || self.diffuse.reflect != Rgb::ZERO
            || self.diffuse.transmit != Rgb::ZERO
    }

    /// How widely it scatters light on average: 0 is a mirror or clear glass, 1 is diffuse.
    pub fn roughness_hint(&self) -> f64 {
        let rough = |smooth: bool, alpha: f64| if smooth { 0.0 } else { alpha.sqrt() };
        // All lobes that are not named are diffuse, or nearly.
        let mut roughness = [1.0; mixture::LOBES];
        roughness[mixture::COAT] = self.coat.as_ref().map_or(0.0, |c| rough(c.smooth, c.ggx.ax));
        roughness[mixture::INTERFACE] =
            self.interface.as_ref().map_or(0.0, |i| rough(i.smooth, (i.ggx.ax * i.ggx.ay).sqrt()));
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

    /// About the share of light from head-on that is reflected or transmitted, in each band within 0..=1.
    pub fn albedo_hint(&self) -> Spectrum {
        let sum: Rgb = self.albedos(self.above(AlbedoDirection::all(1.0))).into_iter().sum();
        spectrum(sum.clamp(Rgb::ZERO, Rgb::ONE))
    }

    fn turned(&self, w: DVec3) -> DVec3 {
        match self.rotation {
            None => w,
            Some((cos, sin)) => DVec3::new(cos * w.x + sin * w.y, cos * w.y - sin * w.x, w.z),
        }
    }

    fn turned_back(&self, w: DVec3) -> DVec3 {
        match self.rotation {
            None => w,
            Some((cos, sin)) => DVec3::new(cos * w.x - sin * w.y, cos * w.y + sin * w.x, w.z),
        }
    }
}

/// A BSDF with what depends on the direction alone that light leaves in: shares of the lobes.
#[derive(Clone, Copy)]
pub struct BsdfFromWo<'a> {
    bsdf: &'a Bsdf,
    /// Turned to the direction of anisotropy.
    wo: DVec3,
    above: mixture::Above,
    p: mixture::Shares,
}

impl BsdfFromWo<'_> {
    /// As [`Bsdf::as_lambert`].
    #[inline]
    pub fn as_lambert(&self) -> Option<Spectrum> {
        self.bsdf.as_lambert()
    }

    /// As [`Bsdf::eval_pdf`].
    #[inline]
    pub fn eval_pdf(&self, wi: DVec3) -> (Spectrum, f64) {
        let (f, pdf) = self.bsdf.mixture(self.wo, self.bsdf.turned(wi), &self.above, &self.p);
        (spectrum(f), pdf)
    }

    /// The share of light from behind that comes straight through a thin smooth wall: what the mean over samples that go straight on is.
    pub fn straight(&self) -> Spectrum {
        self.bsdf.straight(self.wo)
    }

    /// As [`Bsdf::has_smooth`].
    pub fn has_smooth(&self) -> bool {
        self.bsdf.has_smooth()
    }

    /// As [`Bsdf::sample`].
    #[inline]
    pub fn sample(&self, u: [f64; 3]) -> Option<BsdfSample> {
        let mut sample = self.bsdf.sample_mixture(self.wo, u, &self.above, &self.p)?;
        sample.wi = self.bsdf.turned_back(sample.wi);
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

/// Into 0..=1; 0 for NaN.
fn unit(v: f64) -> f64 {
    if v > 0.0 { v.min(1.0) } else { 0.0 }
}

fn color(c: Spectrum) -> Rgb {
    Rgb::new(unit(f64::from(c.r)), unit(f64::from(c.g)), unit(f64::from(c.b)))
}

fn spectrum(c: Rgb) -> Spectrum {
    Spectrum::new(c.x as f32, c.y as f32, c.z as f32)
}

#[cfg(test)]
mod tests;
