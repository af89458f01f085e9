//! More samples per pixel for a film that exists.

use super::band::Band;
use super::error::ErrorSample;
use super::tile_pixels::error_of_one;
use super::{Film, Fixed96, SampleSet};
use crate::color::Spectrum;
use crate::schema::{ErrorCode, SceneError};

impl Film {
    /// Raises the samples per pixel of the finished picture; the samples that the film holds stay. The caller
    /// knows that they are those of the picture with more samples: see [`Renderer::extend`](crate::Renderer::extend).
    ///
    /// Errors, which leave the film unchanged: fewer samples than now, or too many light paths
    /// ([`ErrorCode::Conflict`]); not enough memory ([`ErrorCode::TooLarge`]).
    pub fn extend(&mut self, samples: u32) -> Result<(), SceneError> {
        let own = self.identity.samples;
        if samples < own {
            let message =
                format!("the film has {own} samples per pixel; expected at least as many, found {samples}");
            return Err(SceneError::new(ErrorCode::Conflict, message));
        }
        if self.identity.light_paths.checked_mul(u64::from(samples)).is_none() {
            let message = format!("{samples} samples per pixel have too many light paths");
            return Err(SceneError::new(ErrorCode::Conflict, message));
        }
        let kept_samples = Film::keeps_samples(&self.identity, self.channels());
        let mut identity = self.identity.clone();
        identity.samples = samples;
        if kept_samples && !Film::keeps_samples(&identity, self.channels()) {
            // A film of one sample per pixel stores samples; one of several stores sums.
            let bytes = Film::pixel_bytes(&identity, self.channels());
            if Vec::<u8>::new().try_reserve_exact(self.region.area() as usize * bytes).is_err() {
                let (width, height) = (self.region.width, self.region.height);
                let message = format!("not enough memory for a film of {width}x{height}");
                return Err(SceneError::new(ErrorCode::TooLarge, message));
            }
            for band in &mut self.bands {
                band.sums_mut();
            }
            self.bytes_per_pixel = bytes;
        }
        self.identity = identity;
        Ok(())
    }

    /// Adds the sums of an error estimate to a film that holds at most sample 0 of each pixel.
    ///
    /// Errors: a film of weighted samples, whose pixels consist of several ([`ErrorCode::Conflict`]); not enough memory
    /// ([`ErrorCode::TooLarge`]).
    pub fn begin_error_estimate(&mut self) -> Result<(), SceneError> {
        if self.identity.estimates_error {
            return Ok(());
        }
        let single = |held: &SampleSet| held.is_empty() || held.len() == 1 && held.first_missing() == 1;
        if self.identity.weighted || !self.bands.iter().flat_map(Band::sets).all(single) {
            let message = "the film has no sums for an estimate of its error, which more samples need";
            return Err(SceneError::new(ErrorCode::Conflict, message)
                .help("render again with this number of samples"));
        }
        let mut out = self.clone();
        out.estimate_error()?;
        for (own, old) in out.bands.iter_mut().zip(&self.bands) {
            own.held.clone_from(&old.held);
            own.labels.clone_from(&old.labels);
            own.brightest.clone_from(&old.brightest);
            own.non_finite = old.non_finite;
            let has_sums = matches!(old.pixels(), super::band::Pixels::Sums(_));
            let pixels = own.sums_mut();
            for (i, words) in pixels.iter_mut().enumerate() {
                *words = old.sum(i).to_words();
            }
            for i in 0..pixels.len() {
                let (kept, sums) = own.extra_mut(i).split_at_mut(self.channels().len());
                kept.copy_from_slice(old.extra(i));
                let value = if has_sums { old.sum(i).mean() } else { old.single(i) };
                let Some([r, g, b, _]) = value.filter(|v| v.iter().all(|v| v.is_finite())) else { continue };
                let error = error_of_one(&ErrorSample::new(Spectrum::new(r, g, b), 0));
                for (words, sum) in sums.iter_mut().zip(error) {
                    *words = Fixed96::from_i128(sum).to_words();
                }
            }
        }
        out.splats.clone_from(&self.splats);
        out.identity.light_paths = self.identity.light_paths;
        out.identity.cluster = self.identity.cluster;
        out.count_non_finite();
        *self = out;
        Ok(())
    }
}
