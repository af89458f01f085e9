//! Participating media: what is between surfaces and absorbs, scatters and emits light on its way. One file each;
//! [`MediumDesc`] is the table of their names in a scene.
//!
//! A medium is bound to what encloses it by a material (`interior`), by an object (`medium`, whose surface then is nothing but a boundary), or to
//! all that is in the open (`medium` of `[background]`).
//!
//! The contract, which every [`Medium`] keeps:
//!
//! - Rays and lengths are the world's. [`Coefficients`] are per unit of length at density 1, by colour band; emission is radiance per unit of length. Extinction is absorption
//!   and scattering together, and the albedo is the share of it that is scattered.
//! - Rays have unit directions, so that t is a length. A [`Stretch`] begins at the ray's origin and ends at `end`: a surface, or infinity.
//! - [`Medium::walk`] chooses whether and where the path is scattered. `scattered` is `None` where it passes to the end. `weight` is what the path then carries of what it
//!   carried: transmittance times scattering coefficient (where it was scattered) over the density of what happened, its mean over `u` the true value. The phase function is not in it.
//! - `pdf` is per unit of length, not per solid angle, and 0 where it is not known (a varying density); who needs it for MIS then goes without.
//! - [`Medium::transmittance`] is within 0..=1 for homogeneous media; for others it is an estimate whose mean is the transmittance.
//! - The phase function ([`HenyeyGreenstein`]) is per steradian and integrates to 1 over the sphere: there is no cosine. Its directions are those in which light travels, unlike
//!   those of surfaces: a cosine of 1 goes straight on.
//! - Random numbers are given: two in `u`, as many more as a varying medium needs from a counter-based [`Stream`], so that a path depends on its sample alone.

mod equiangular;
mod grid;
mod heterogeneous;
mod homogeneous;
mod phase;
mod smoke;
mod subsurface;

pub use equiangular::Equiangular;
pub use grid::{GridBorder, GridMedium};
pub use heterogeneous::Heterogeneous;
pub use homogeneous::{Homogeneous, HomogeneousMedium, Place};
pub use phase::HenyeyGreenstein;
pub use smoke::SmokeMedium;
pub use subsurface::scattering_albedo;

use crate::color::Spectrum;
use crate::math::Ray;
use crate::sampler::Stream;
use crate::schema::{ErrorCode, SceneError, family};

family! {
    /// Media: `[medium.NAME]`, or in place as `medium = { … }`. The `type` is "homogeneous" unless given. Integrators that follow light
    /// show them; others do not.
    pub enum MediumDesc as "medium", "media" {
        Homogeneous(HomogeneousMedium),
        Grid(GridMedium),
        Smoke(SmokeMedium),
    }
}

/// What a medium of density 1 does to light, per unit of length and by colour band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients {
    /// Absorbed and scattered together.
    pub extinction: [f64; 3],
    /// Scattered.
    pub scattering: [f64; 3],
    /// Radiance emitted.
    pub emission: [f64; 3],
    /// Where to.
    pub phase: HenyeyGreenstein,
}

impl Coefficients {
    /// From extinction with albedo, or absorption with scattering, times `density`.
    ///
    /// Errors: both at once.
    fn new(
        density: f64,
        [extinction, albedo]: [Option<Spectrum>; 2],
        [absorption, scattering]: [Option<Spectrum>; 2],
        g: f64,
        emission: Spectrum,
    ) -> Result<Coefficients, SceneError> {
        let by_parts = absorption.is_some() || scattering.is_some();
        if by_parts && (extinction.is_some() || albedo.is_some()) {
            let message =
                "a medium has `extinction` and `albedo`, or `absorption` and `scattering`, not both";
            return Err(SceneError::new(ErrorCode::Conflict, message)
                .help("extinction = absorption + scattering, albedo = scattering / extinction"));
        }
        let bands = |c: Spectrum| c.to_array().map(f64::from);
        let (extinction, scattering) = if by_parts {
            let a = bands(absorption.unwrap_or(Spectrum::BLACK));
            let s = bands(scattering.unwrap_or(Spectrum::BLACK));
            ([a[0] + s[0], a[1] + s[1], a[2] + s[2]], s)
        } else {
            let e = bands(extinction.unwrap_or(Spectrum::WHITE));
            let a = bands(albedo.unwrap_or(Spectrum::WHITE));
            (e, [e[0] * a[0], e[1] * a[1], e[2] * a[2]])
        };
        let dense = |v: [f64; 3]| v.map(|v| v * density);
        Ok(Coefficients {
            extinction: dense(extinction),
            scattering: dense(scattering),
            emission: dense(bands(emission)),
            phase: HenyeyGreenstein { g },
        })
    }

    /// Whether it scatters in any band.
    pub fn scatters(&self) -> bool {
        self.scattering != [0.0; 3]
    }

    /// Whether it emits in any band.
    pub fn emits(&self) -> bool {
        self.emission != [0.0; 3]
    }
}

/// The way of a ray through one medium.
pub struct Stretch<'a> {
    /// The ray, of unit direction.
    pub ray: &'a Ray,
    /// Where along it the way ends: at a surface, or nowhere (infinite).
    pub end: f64,
    /// The share of each colour band in what the path carries; their sum is 1.
    pub shares: [f64; 3],
    /// Whether the path may be scattered: if not, it goes on to the end.
    pub scatters: bool,
}

/// What became of a path on its way through a medium.
#[derive(Clone, Copy, Debug)]
pub struct Walk {
    /// Where along the ray it was scattered, if it was.
    pub scattered: Option<f64>,
    /// The factor of what it carries; where it was scattered, without the phase function.
    pub weight: Spectrum,
    /// Density of that place per unit of length, where it is known: in media that are the same everywhere; else 0.
    pub pdf: f64,
    /// Radiance of the medium itself, as it arrives at the begin of the way.
    pub emitted: Spectrum,
}

/// A medium ready to be rendered.
#[derive(Clone, Debug)]
pub enum Medium {
    /// The same everywhere.
    Homogeneous(Homogeneous),
    /// Of varying density.
    Heterogeneous(Heterogeneous),
}

impl MediumDesc {
    /// Makes it ready.
    pub fn prepare(&self) -> Result<Medium, SceneError> {
        Ok(match self {
            MediumDesc::Homogeneous(m) => Medium::Homogeneous(m.prepare()?),
            MediumDesc::Grid(m) => Medium::Heterogeneous(m.prepare()?),
            MediumDesc::Smoke(m) => Medium::Heterogeneous(m.prepare()?),
        })
    }
}

impl Medium {
    /// What it does to light at density 1.
    #[inline]
    pub fn coefficients(&self) -> &Coefficients {
        match self {
            Medium::Homogeneous(m) => &m.coefficients,
            Medium::Heterogeneous(m) => &m.coefficients,
        }
    }

    /// A way through it; `u` chooses band and length, `more` has the numbers beyond.
    #[inline]
    pub fn walk(&self, stretch: &Stretch<'_>, u: [f64; 2], more: &mut Stream) -> Walk {
        match self {
            Medium::Homogeneous(m) => m.walk(stretch, u),
            Medium::Heterogeneous(m) => m.walk(stretch, u, more),
        }
    }

    /// The share of light that is left of a ray of unit direction between two places, or an estimate of it whose mean is that.
    #[inline]
    pub fn transmittance(&self, ray: &Ray, from: f64, to: f64, more: &mut Stream) -> Spectrum {
        match self {
            Medium::Homogeneous(m) => m.transmittance(to - from),
            Medium::Heterogeneous(m) => m.transmittance(ray, from, to, more),
        }
    }

    /// One that does nothing.
    pub(crate) fn void() -> Medium {
        Medium::Homogeneous(Homogeneous::void())
    }

    /// Whether nothing is there.
    pub fn is_void(&self) -> bool {
        let c = self.coefficients();
        c.extinction == [0.0; 3] && !c.emits()
    }
}
