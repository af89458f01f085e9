//! Participating media: they absorb, scatter and emit light between surfaces. One file per type; [`MediumDesc`] is the
//! table of their names in a scene.
//!
//! A medium is bound to its boundary by a material (`interior`), by an object (`medium`, whose surface is then an
//! interface without scattering), or to open space (`medium` of `[background]`).
//!
//! Contract of every [`Medium`]:
//!
//! - Rays and lengths are in world space. [`Coefficients`] are per unit of length at density 1, by colour band;
//!   emission is radiance per unit of length. Extinction is absorption plus scattering; the albedo is scattering over
//!   extinction.
//! - Rays have unit directions, so t is a length. A [`RaySegment`] starts at the ray's origin and ends at `end`: a
//!   surface, or infinity.
//! - [`Medium::walk`] samples whether and where the path scatters. `scattered` is `None` if it passes to the end.
//!   `weight` is the factor of the throughput: transmittance, times the scattering coefficient where it scatters, over
//!   the probability density. Its mean over `u` is exact. The phase function is not included.
//! - `pdf` is per unit of length, not per solid angle. It is 0 where unknown (heterogeneous media), and then there is
//!   no MIS over distances.
//! - [`Medium::transmittance`] is exact and within 0..=1 for homogeneous media; for others it is an unbiased estimate.
//! - The phase function ([`PhaseFunction`]) is per steradian and integrates to 1 over the sphere; there is no
//!   cosine. Unlike those of surfaces, its directions are those in which light travels: a cosine of 1 is straight
//!   forward.
//! - Random numbers are passed in: two in `u`, and as many more as a heterogeneous medium needs from a counter-based
//!   [`Stream`], so a path depends on its sample alone.

mod cloud;
mod equiangular;
mod grid;
mod heterogeneous;
mod homogeneous;
mod phase;
mod smoke;
mod subsurface;
mod temperatures;

pub use cloud::CloudMedium;
pub use equiangular::Equiangular;
pub use grid::{GridBorder, GridMedium};
pub use heterogeneous::Heterogeneous;
pub use homogeneous::{Homogeneous, HomogeneousMedium, Place};
pub use phase::PhaseFunction;
pub use smoke::SmokeMedium;
pub use subsurface::scattering_albedo;

use crate::color::Spectrum;
use crate::math::Ray;
use crate::sampler::Stream;
use crate::schema::{ErrorCode, SceneError, family};

family! {
    /// Media: `[medium.NAME]`, or inline as `medium = { … }`. The default `type` is "homogeneous". The integrators
    /// "path" and "direct" render media; other integrators ignore them.
    pub enum MediumDesc as "medium", "media" {
        Homogeneous(HomogeneousMedium),
        Grid(GridMedium),
        Smoke(SmokeMedium),
        Cloud(CloudMedium),
    }
}

/// Coefficients of a medium at density 1, per unit of length and by colour band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients {
    /// Absorption plus scattering.
    pub extinction: [f64; 3],
    /// Scattering.
    pub scattering: [f64; 3],
    /// Emitted radiance.
    pub emission: [f64; 3],
    /// The phase function.
    pub phase: PhaseFunction,
}

impl Coefficients {
    /// From extinction and albedo, or absorption and scattering, times `density`.
    ///
    /// Errors: both at once.
    fn new(
        density: f64,
        [extinction, albedo]: [Option<Spectrum>; 2],
        [absorption, scattering]: [Option<Spectrum>; 2],
        phase: PhaseFunction,
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
            phase,
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

/// The segment of a ray in one medium.
pub struct RaySegment<'a> {
    /// The ray, of unit direction.
    pub ray: &'a Ray,
    /// Distance of the end: a surface, or infinity.
    pub end: f64,
    /// Fraction of each colour band in the path's throughput; their sum is 1.
    pub shares: [f64; 3],
    /// Whether the path may scatter; if not, it passes to the end.
    pub scatters: bool,
}

/// The sampled event along a segment.
#[derive(Clone, Copy, Debug)]
pub struct Walk {
    /// Distance of scattering, if any.
    pub scattered: Option<f64>,
    /// Factor of the throughput, without the phase function.
    pub weight: Spectrum,
    /// Density of that distance per unit of length, where known (homogeneous media); otherwise 0.
    pub pdf: f64,
    /// Emitted radiance, as it arrives at the start of the segment.
    pub emitted: Spectrum,
}

/// A prepared medium.
#[derive(Clone, Debug)]
pub enum Medium {
    /// The same density everywhere.
    Homogeneous(Homogeneous),
    /// Density from a grid.
    Heterogeneous(Heterogeneous),
}

impl MediumDesc {
    /// Prepares the medium.
    pub fn prepare(&self) -> Result<Medium, SceneError> {
        Ok(match self {
            MediumDesc::Homogeneous(m) => Medium::Homogeneous(m.prepare()?),
            MediumDesc::Grid(m) => Medium::Heterogeneous(m.prepare()?),
            MediumDesc::Smoke(m) => Medium::Heterogeneous(m.prepare()?),
            MediumDesc::Cloud(m) => Medium::Heterogeneous(m.prepare()?),
        })
    }
}

impl Medium {
    /// Coefficients at density 1.
    #[inline]
    pub fn coefficients(&self) -> &Coefficients {
        match self {
            Medium::Homogeneous(m) => &m.coefficients,
            Medium::Heterogeneous(m) => &m.coefficients,
        }
    }

    /// Samples scattering along a segment: `u` for the first event and for emission, `more` for all further random numbers.
    #[inline]
    pub fn walk(&self, stretch: &RaySegment<'_>, u: [f64; 3], more: &mut Stream) -> Walk {
        match self {
            Medium::Homogeneous(m) => m.walk(stretch, [u[0], u[1]]),
            Medium::Heterogeneous(m) => m.walk(stretch, u, more),
        }
    }

    /// Transmittance of a ray of unit direction between two distances, exact or an unbiased estimate.
    #[inline]
    pub fn transmittance(&self, ray: &Ray, from: f64, to: f64, more: &mut Stream) -> Spectrum {
        match self {
            Medium::Homogeneous(m) => m.transmittance(to - from),
            Medium::Heterogeneous(m) => m.transmittance(ray, from, to, more),
        }
    }

    /// A medium without effect.
    pub(crate) fn void() -> Medium {
        Medium::Homogeneous(Homogeneous::void())
    }

    /// Whether it has no effect.
    pub fn is_void(&self) -> bool {
        let c = self.coefficients();
        c.extinction == [0.0; 3] && !c.emits()
    }
}
