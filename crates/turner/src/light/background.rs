//! The background: what rays see that hit nothing.

use crate::color::Spectrum;
use crate::math::DVec3;
use crate::schema::{MediumId, params};

params! {
    /// The background, seen by rays that hit nothing: one colour, or a vertical gradient from `color` at the horizon
    /// and below to `zenith` straight up.
    pub struct BackgroundDesc as "background" {
        /// The colour of the background.
        color: Spectrum = Spectrum::BLACK;
        /// The colour straight up. Without it the background is one colour.
        zenith: Option<Spectrum> = None;
        /// The up direction of the gradient.
        up: DVec3 = DVec3::Y;
        /// Whether an environment light is shown instead of the colours, if the scene has one.
        environment: bool = true;
        /// Whether the background is transparent in PNG and EXR; pixels that show it in part are transparent in part.
        transparent: bool = false;
        /// The medium that fills the scene and surrounds the camera wherever no other medium is set: endless fog.
        /// Background, environment and sun are neither visible through it nor light it; to keep them, put a box or
        /// sphere of the medium around the scene instead.
        medium: Option<MediumId> = None;
    }
    example r##"[background]
color = "#f0e8d8"
zenith = "steelblue"
"##
}

impl BackgroundDesc {
    /// A copy with `up` of unit length.
    pub fn prepared(&self) -> BackgroundDesc {
        BackgroundDesc { up: self.up.try_normalize().unwrap_or(DVec3::Y), ..self.clone() }
    }

    /// The colour in a unit direction.
    pub fn color(&self, direction: DVec3) -> Spectrum {
        match self.zenith {
            None => self.color,
            Some(zenith) => self.color.lerp(zenith, direction.dot(self.up).clamp(0.0, 1.0) as f32),
        }
    }
}
