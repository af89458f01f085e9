//! Which picture a film is of.

use super::checksum::checksum;
use super::{FilmDesc, PixelRect};

/// What two films must have in common so that their samples belong to one picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Columns and rows of the whole picture.
    pub size: [u32; 2],
    /// The part that is rendered.
    pub region: PixelRect,
    /// The part that is shown.
    pub crop: PixelRect,
    /// Samples each pixel gets in all.
    pub samples: u32,
    /// Seed of the random numbers.
    pub seed: u32,
    /// Hash of the other settings that samples depend on: anti-aliasing, filter, shutter, largest sample, ….
    pub sampling: u64,
    /// Light paths to each sample of all pixels.
    pub light_paths: u64,
    /// Fingerprint of the scene, if the caller gave one.
    pub scene: Option<u64>,
}

impl Identity {
    /// Of a description's film; of no scene, without light paths.
    pub(super) fn new(desc: &FilmDesc, region: PixelRect, crop: PixelRect) -> Identity {
        // All keys, so that a new one is not forgotten.
        let FilmDesc {
            antialias,
            threshold,
            max_subdivisions,
            filter,
            filter_radius,
            texture_filter,
            shutter,
            pixel_sample,
            clamp_sample,
            // In fields of their own.
            width: _,
            height: _,
            crop: _,
            samples: _,
            seed: _,
            // What is made of the samples.
            transfer: _,
            tonemap: _,
            exposure: _,
            auto_exposure: _,
        } = desc;
        let sampling = format!(
            "{antialias:?} {threshold} {max_subdivisions} {filter:?} {filter_radius:?} {texture_filter:?} {shutter:?} \
             {pixel_sample:?} {clamp_sample}"
        );
        Identity {
            size: [desc.width, desc.height],
            region,
            crop,
            samples: desc.samples_per_pixel(),
            seed: desc.seed,
            sampling: checksum(sampling.as_bytes()),
            light_paths: 0,
            scene: None,
        }
    }

    /// The first thing in which two differ, in words; `None` if they are of one picture.
    pub fn difference(&self, other: &Identity) -> Option<String> {
        let words = |what: &str, a: String, b: String| (a != b).then(|| format!("{what}: {a} and {b}"));
        let rect = |r: &PixelRect| format!("{}x{} pixels at ({}, {})", r.width, r.height, r.x, r.y);
        let size = |i: &Identity| format!("{}x{}", i.size[0], i.size[1]);
        let scene = |i: &Identity| i.scene.map_or("none".to_owned(), |s| format!("{s:016x}"));
        words("size", size(self), size(other))
            .or_else(|| words("part that is rendered", rect(&self.region), rect(&other.region)))
            .or_else(|| words("crop", rect(&self.crop), rect(&other.crop)))
            .or_else(|| words("samples per pixel", self.samples.to_string(), other.samples.to_string()))
            .or_else(|| words("seed", self.seed.to_string(), other.seed.to_string()))
            .or_else(|| {
                words("light paths per sample", self.light_paths.to_string(), other.light_paths.to_string())
            })
            .or_else(|| words("scene", scene(self), scene(other)))
            .or_else(|| {
                let differs = self.sampling != other.sampling;
                differs.then(|| "anti-aliasing, filter, shutter or another setting of sampling".to_owned())
            })
    }
}
