//! What a ray sees that hits nothing.

use crate::color::Spectrum;
use crate::math::DVec3;
use crate::schema::{MediumId, params};

params! {
    /// What a ray sees that hits nothing: one colour, or a vertical gradient from `color` at the horizon and
    /// below to `zenith` straight up.
    pub struct BackgroundDesc as "background" {
        /// The colour of the background.
        color: Spectrum = Spectrum::BLACK;
        /// The colour straight up; without it the background is the same everywhere.
        zenith: Option<Spectrum> = None;
        /// Up, for the gradient.
        up: DVec3 = DVec3::Y;
        /// Whether an environment light is seen instead of the colours, where there is one.
        environment: bool = true;
        /// Whether pixels (parts of pixels) that show the background are transparent in PNG and EXR.
        transparent: bool = false;
        /// The medium that all the scene is in where nothing else is said, as far as the camera sees: fog without end. What is around the scene
        /// (background, environment, sun) is not seen through it and does not light it; for that, put a box or sphere of it around the scene.
        medium: Option<MediumId> = None;
    }
    example r##"[background]
color = "#f0e8d8"
zenith = "steelblue"
"##
}

impl BackgroundDesc {
    /// With `up` of unit length.
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
