//! Settings that the integrators "path" and "direct" have in common.

use super::learn_environment::Sky;
use super::{DirectDesc, LightSampling, PathDesc, SharedPathsMode};
use crate::bsdf::Lobe;

/// More lights are not sampled at a surface.
const MAX_LIGHT_SAMPLES: u32 = 256;

/// Number of bounces after which Russian roulette starts, by default.
const RR_START: u32 = 3;

/// The same under an open sky ([`Sky::Open`], [`Sky::Uniform`]), where few paths are long, so that Russian roulette saves
/// little time. Time × error relative to a start after 3 bounces: 0.85 to 1.02 for five materials under an environment map,
/// 0.97 to 1.22 in four rooms. Without roulette: 0.86 to 1.24 for the materials.
const RR_START_IN_THE_OPEN: u32 = 5;

/// Limits and switches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Settings {
    pub(super) max_depth: u32,
    max_diffuse: u32,
    max_glossy: u32,
    max_transmission: u32,
    pub(super) max_transparent: u32,
    pub(super) rr_start: u32,
    /// Whether `rr_start` is the default.
    starts_by_default: bool,
    pub(super) hide_emitters: bool,
    pub(super) clamp_indirect: Option<f32>,
    pub(super) light_sampling: LightSampling,
    /// Number of lights that are sampled at the first surface of a path that is not specular.
    pub(super) light_samples: u32,
    /// Whether the only light is a uniform environment. Light samples then have cosine-weighted directions, and only
    /// the first surface that is neither specular nor metal has some.
    pub(super) by_cosine: bool,
    /// Whether `max_diffuse` and `max_glossy` limit no path that `max_depth` does not.
    pub(super) counts_only_bounces: bool,
    /// Whether paths may be shared between pixels.
    pub(super) shared_paths: bool,
    /// The "direct" integrator: a path ends after its first non-specular bounce.
    pub(super) direct: bool,
}

/// Bounces of a path so far, in total and by kind of lobe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Bounces {
    pub(super) total: u32,
    diffuse: u32,
    glossy: u32,
    transmission: u32,
}

impl Settings {
    pub(super) fn path(d: &PathDesc) -> Settings {
        Settings {
            max_depth: d.max_depth,
            max_diffuse: d.max_diffuse.unwrap_or(d.max_depth),
            max_glossy: d.max_glossy.unwrap_or(d.max_depth),
            max_transmission: d.max_transmission.unwrap_or(d.max_depth),
            max_transparent: d.max_transparent,
            counts_only_bounces: [d.max_diffuse, d.max_glossy]
                .iter()
                .all(|limit| limit.is_none_or(|limit| limit >= d.max_depth)),
            rr_start: d.rr_start.unwrap_or(RR_START),
            starts_by_default: d.rr_start.is_none(),
            hide_emitters: d.hide_emitters,
            clamp_indirect: (d.clamp_indirect > 0.0).then_some(d.clamp_indirect as f32),
            light_sampling: d.light_sampling,
            light_samples: d.light_samples.unwrap_or(1).clamp(1, MAX_LIGHT_SAMPLES),
            by_cosine: false,
            // Shared paths need the same treatment of all members up to the second vertex: no clamp and no Russian
            // roulette.
            shared_paths: d.shared_paths != SharedPathsMode::Off
                && d.clamp_indirect <= 0.0
                && d.rr_start.is_none_or(|start| start >= 2),
            direct: false,
        }
    }

    pub(super) fn direct(d: &DirectDesc) -> Settings {
        // The surface that is lit is one more bounce.
        let path = PathDesc {
            max_depth: d.max_depth.saturating_add(1),
            max_transparent: d.max_transparent,
            rr_start: Some(u32::MAX),
            shared_paths: SharedPathsMode::Off,
            light_sampling: d.light_sampling,
            light_samples: d.light_samples,
            ..PathDesc::default()
        };
        Settings { direct: true, ..Settings::path(&path) }
    }

    /// The same settings with another number of light samples.
    pub(super) fn with_light_samples(self, light_samples: u32) -> Settings {
        Settings { light_samples, ..self }
    }

    /// The settings for a sky and a number of light samples. Under an open sky Russian roulette starts later.
    pub(super) fn under(self, sky: Sky, light_samples: u32) -> Settings {
        let rr_start = if self.starts_by_default { RR_START_IN_THE_OPEN } else { self.rr_start };
        match sky {
            Sky::Closed => self.with_light_samples(light_samples),
            Sky::Open => Settings { rr_start, ..self }.with_light_samples(light_samples),
            Sky::Uniform => Settings { rr_start, ..self }.under_uniform_sky(light_samples),
        }
    }

    /// The settings for a uniform environment that is the only light. Without light samples, directions that follow the BSDF
    /// find it alone.
    fn under_uniform_sky(self, light_samples: u32) -> Settings {
        match light_samples {
            0 => Settings { light_sampling: LightSampling::Bsdf, ..self },
            _ => Settings { light_samples, by_cosine: true, ..self },
        }
    }

    /// Whether MIS ignores the density of light samples by luminance where a ray leaves the scene.
    #[inline]
    pub(super) fn needs_no_luminance_pdf(&self) -> bool {
        self.by_cosine || self.light_sampling == LightSampling::Bsdf
    }

    /// Counts a bounce; `None` beyond a limit.
    #[inline]
    pub(super) fn count(&self, bounces: &Bounces, lobe: &Lobe) -> Option<Bounces> {
        let mut b = *bounces;
        b.total += 1;
        let (count, limit) = if lobe.is_transmission {
            (&mut b.transmission, self.max_transmission)
        } else if lobe.is_diffuse {
            (&mut b.diffuse, self.max_diffuse)
        } else {
            (&mut b.glossy, self.max_glossy)
        };
        *count += 1;
        (*count <= limit && b.total <= self.max_depth).then_some(b)
    }
}
