//! Which picture a film belongs to.

use super::checksum::checksum;
use super::{ClampSpace, Denoise, FilmDesc, PixelRect};

/// The settings that two films must share so that their samples belong to one picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Columns and rows of the full picture.
    pub size: [u32; 2],
    /// The part that is rendered.
    pub region: PixelRect,
    /// The part that is shown.
    pub crop: PixelRect,
    /// Samples per pixel of the finished picture.
    pub samples: u32,
    /// Seed of the random numbers.
    pub seed: u32,
    /// Hash of the other settings that samples depend on: anti-aliasing, filter, shutter, clamping, ….
    pub sampling: u64,
    /// Whether samples count by weight in several pixels.
    pub weighted: bool,
    /// Whether the film holds what an estimate of its error needs.
    pub estimates_error: bool,
    /// Whether the samples per pixel follow the noise.
    pub adaptive: bool,
    /// Whether the film removes fireflies, for which it keeps the brightest samples of each pixel.
    pub removes_fireflies: bool,
    /// Light paths per sample index of the picture.
    pub light_paths: u64,
    /// Number of neighbouring pixels that share paths; 1 if they do not.
    pub cluster: u32,
    /// Fingerprint of the scene, if the caller set one.
    pub scene: Option<u64>,
}

impl Identity {
    /// The identity for a description, without scene and light paths.
    pub(super) fn new(desc: &FilmDesc, region: PixelRect, crop: PixelRect) -> Identity {
        // All keys are listed, so that a new one is not forgotten.
        let FilmDesc {
            antialias,
            threshold,
            max_subdivisions,
            filter,
            filter_radius,
            reconstruction,
            texture_filter,
            shutter,
            pixel_sample,
            clamp_sample,
            clamp_space,
            // In separate fields.
            width: _,
            height: _,
            crop: _,
            samples: _,
            seed: _,
            adaptive_sampling: _,
            // These do not affect samples.
            transfer: _,
            tonemap: _,
            exposure: _,
            auto_exposure: _,
            denoise: _,
            denoise_aovs: _,
            // In a separate field.
            fireflies: _,
            // A property of the scene.
            motion_blur: _,
            // Compared as channels.
            aovs: _,
        } = desc;
        let mut sampling = format!(
            "{antialias:?} {threshold} {max_subdivisions} {filter:?} {filter_radius:?} {reconstruction:?} \
             {texture_filter:?} {shutter:?} {pixel_sample:?} {clamp_sample}"
        );
        if *clamp_space != ClampSpace::Rgb {
            sampling += &format!(" {clamp_space:?}");
        }
        Identity {
            size: [desc.width, desc.height],
            region,
            crop,
            samples: desc.samples_per_pixel(),
            seed: desc.seed,
            sampling: checksum(sampling.as_bytes()),
            weighted: desc.weights_samples(),
            estimates_error: false,
            adaptive: false,
            removes_fireflies: desc.removes_fireflies(),
            light_paths: 0,
            cluster: 1,
            scene: None,
        }
    }

    /// One more than the largest sample index of the finished picture.
    pub(crate) fn index_end(&self) -> u32 {
        if self.adaptive { self.samples.saturating_mul(super::adaptive::MOST) } else { self.samples }
    }

    /// The first difference in words; `None` if both belong to one picture.
    pub fn difference(&self, other: &Identity) -> Option<String> {
        let words = |what: &str, a: String, b: String| (a != b).then(|| format!("{what}: {a} and {b}"));
        let rect = |r: &PixelRect| format!("{}x{} pixels at ({}, {})", r.width, r.height, r.x, r.y);
        let size = |i: &Identity| format!("{}x{}", i.size[0], i.size[1]);
        let scene = |i: &Identity| i.scene.map_or("none".to_owned(), |s| format!("{s:016x}"));
        words("size", size(self), size(other))
            .or_else(|| words("part that is rendered", rect(&self.region), rect(&other.region)))
            .or_else(|| words("crop", rect(&self.crop), rect(&other.crop)))
            .or_else(|| words("samples per pixel", self.samples.to_string(), other.samples.to_string()))
            .or_else(|| words("weighted samples", self.weighted.to_string(), other.weighted.to_string()))
            .or_else(|| {
                words("error estimate", self.estimates_error.to_string(), other.estimates_error.to_string())
            })
            .or_else(|| words("adaptive sampling", self.adaptive.to_string(), other.adaptive.to_string()))
            .or_else(|| {
                let fireflies =
                    |i: &Identity| if i.removes_fireflies { "removed" } else { "kept" }.to_owned();
                words("fireflies", fireflies(self), fireflies(other))
            })
            .or_else(|| words("seed", self.seed.to_string(), other.seed.to_string()))
            .or_else(|| {
                words("light paths per sample", self.light_paths.to_string(), other.light_paths.to_string())
            })
            .or_else(|| words("pixels that share paths", self.cluster.to_string(), other.cluster.to_string()))
            .or_else(|| words("scene", scene(self), scene(other)))
            .or_else(|| {
                let differs = self.sampling != other.sampling;
                differs.then(|| "anti-aliasing, filter, shutter or another setting of sampling".to_owned())
            })
    }
}

impl FilmDesc {
    /// Whether the samples of two films are the same, so that an integrator's choices for one hold for the other.
    pub(crate) fn has_samples_of(&self, other: &FilmDesc) -> bool {
        let of = |film: &FilmDesc| FilmDesc {
            exposure: 0.0,
            auto_exposure: false,
            denoise: Denoise::Off,
            denoise_aovs: false,
            tonemap: Default::default(),
            crop: None,
            threshold: 0.0,
            aovs: Default::default(),
            fireflies: Default::default(),
            ..film.clone()
        };
        of(self) == of(other)
    }
}
