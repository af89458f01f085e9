//! Light from all around: a picture of the surroundings, infinitely far away.
//!
//! [`map`] says which pixel lies in which direction, [`distribution`] chooses directions by how much light comes
//! from them, [`studio`] is the picture where no file is given.

mod batch;
mod distribution;
mod map;
mod studio;

use std::sync::{Arc, OnceLock};

use crate::color::Spectrum;
use crate::image::Image;
use crate::math::{DVec3, radians};
use crate::schema::error::escape;
use crate::schema::{Asset, ErrorCode, ImageId, Range, SceneError, params};
pub use batch::EnvironmentBatch;
use distribution::Distribution;
use map::EnvironmentMap;

params! {
    /// Light from all around: a picture of the surroundings in equirectangular projection, twice as wide as high, or a built-in photographer's studio.
    /// +y is up; the middle of the picture lies along −z, and it goes on to the right towards +x. The upper edge is the zenith, the lower one the nadir.
    /// EXR and HDR hold light as it is; pictures of 8 and 16 bits are taken for sRGB. Samples below 0 and those that are no finite numbers count as 0; alpha is ignored.
    pub struct EnvironmentDesc as "environment" {
        /// The picture, relative to the scene file; without it a neutral studio: a large soft light from the upper left of the front (+z), a dimmer one at the right,
        /// a strip behind. In it a white floor is about as bright as 0.9.
        file: Option<ImageId> = None;
        /// The light is multiplied by this.
        strength: f64 = 1.0, in Range::NON_NEGATIVE;
        /// Degrees by which the surroundings are turned about +y: what was along −z comes to lie along −x after 90.
        rotation: f64 = 0.0;
        /// The light is multiplied by this colour.
        tint: Spectrum = Spectrum::WHITE, in Range::NON_NEGATIVE;
    }
    example r#"[[light]]
type = "environment"
rotation = 30
strength = 0.8
"#
}

/// A direction chosen for the light that comes from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnvironmentSample {
    /// BsdfFromWo the light, a unit vector.
    pub direction: DVec3,
    /// The light that comes from there.
    pub radiance: Spectrum,
    /// How probable the direction is, per solid angle; greater than 0.
    pub pdf: f64,
}

/// An environment ready to shine. Clones share the picture.
#[derive(Clone, Debug)]
pub struct EnvironmentLight {
    prepared: Arc<Prepared>,
    /// Tint times strength.
    scale: Spectrum,
    /// Sine and cosine of the rotation.
    turn: (f64, f64),
}

#[derive(Debug)]
struct Prepared {
    map: EnvironmentMap,
    distribution: Distribution,
    /// The picture's radiance integrated over all directions, per band.
    total: [f64; 3],
}

impl Prepared {
    fn new(image: Arc<Image>, compensated: bool) -> Result<Prepared, SceneError> {
        let map = EnvironmentMap::new(image);
        let distribution = Distribution::new(&map, compensated)?;
        let total = map.integral();
        Ok(Prepared { map, distribution, total })
    }
}

impl EnvironmentDesc {
    /// The built-in studio.
    pub fn studio() -> EnvironmentDesc {
        EnvironmentDesc { file: None, strength: 1.0, rotation: 0.0, tint: Spectrum::WHITE }
    }

    /// Makes it ready: `images` are the scene's. With `compensated`, directions are chosen for a sampler that combines
    /// them with others by the balance heuristic: see [`EnvironmentLight::sample`].
    pub fn prepare(
        &self,
        images: &[Asset<Image>],
        compensated: bool,
    ) -> Result<EnvironmentLight, SceneError> {
        let prepared = match self.file {
            None => studio(compensated)?,
            Some(id) => {
                let asset = images.get(id.index()).ok_or_else(|| {
                    let message = "an environment refers to a picture that the scene does not have";
                    SceneError::new(ErrorCode::Internal, message)
                })?;
                if !asset.data.is_consistent() {
                    let message = format!("the samples of {} do not fit its size", escape(&asset.uri));
                    return Err(SceneError::new(ErrorCode::Image, message));
                }
                Arc::new(Prepared::new(asset.data.clone(), compensated)?)
            }
        };
        let turn = crate::math::elementary::sin_cos(radians(self.rotation));
        Ok(EnvironmentLight { prepared, scale: self.tint * self.strength as f32, turn })
    }
}

/// The studio is the same for every scene: it is made once for each way of choosing directions.
fn studio(compensated: bool) -> Result<Arc<Prepared>, SceneError> {
    static STUDIOS: [OnceLock<Arc<Prepared>>; 2] = [OnceLock::new(), OnceLock::new()];
    let made = &STUDIOS[usize::from(compensated)];
    if let Some(studio) = made.get() {
        return Ok(studio.clone());
    }
    let studio = Arc::new(Prepared::new(Arc::new(studio::picture()), compensated)?);
    Ok(made.get_or_init(|| studio).clone())
}

impl EnvironmentLight {
    /// Of a consistent picture that a program made, its light multiplied by `scale`, turned by an angle given as sine and cosine.
    pub(super) fn of_picture(
        image: Arc<Image>,
        scale: Spectrum,
        turn: (f64, f64),
        compensated: bool,
    ) -> Result<EnvironmentLight, SceneError> {
        Ok(EnvironmentLight { prepared: Arc::new(Prepared::new(image, compensated)?), scale, turn })
    }

    /// The light that comes from a direction (a vector towards it, of any length but 0): bilinear between the
    /// centres of pixels, never negative, always finite.
    pub fn radiance(&self, direction: DVec3) -> Spectrum {
        self.scaled(self.prepared.map.radiance(self.turned_to_map(direction)))
    }

    /// The same within rounding and the density of [`EnvironmentLight::pdf`], both for little more than half the price of the first.
    #[inline]
    pub fn found(&self, direction: DVec3) -> (Spectrum, f64) {
        let uv = map::coordinates_fast(self.turned_to_map(direction));
        (self.scaled(self.prepared.map.at(uv)), self.prepared.distribution.pdf_at(uv))
    }

    #[inline]
    fn scaled(&self, radiance: Spectrum) -> Spectrum {
        Spectrum::from(
            [(radiance.r, self.scale.r), (radiance.g, self.scale.g), (radiance.b, self.scale.b)]
                .map(|(v, scale)| (v * scale).min(f32::MAX)),
        )
    }

    /// A direction for two uniform numbers in 0..1, the more probable the more light comes from it (by the picture's
    /// luminance; the tint plays no part). `None` if the picture is black.
    ///
    /// Light can come from a direction that is never chosen only if the environment was prepared as `compensated`:
    /// what is dimmer than the mean is then left to the other sampler.
    pub fn sample(&self, u: [f64; 2]) -> Option<EnvironmentSample> {
        let (direction, uv, pdf) = self.prepared.distribution.sample(u)?;
        let radiance = self.scaled(self.prepared.map.at(uv));
        Some(EnvironmentSample { direction: self.turned_to_scene(direction), radiance, pdf })
    }

    /// How probable [`EnvironmentLight::sample`] makes a direction, per solid angle.
    pub fn pdf(&self, direction: DVec3) -> f64 {
        self.prepared.distribution.pdf(self.turned_to_map(direction))
    }

    /// The radiance integrated over all directions. Times π r² it is the power that falls on a sphere of radius r.
    pub fn power(&self) -> Spectrum {
        let [r, g, b] = self.prepared.total;
        let band = |v: f64, scale: f32| (v * f64::from(scale)).min(f64::from(f32::MAX)) as f32;
        Spectrum::new(band(r, self.scale.r), band(g, self.scale.g), band(b, self.scale.b))
    }

    /// Pixels of the picture with a sample that counts as 0 because it is negative or no finite number.
    pub fn invalid_pixels(&self) -> u64 {
        self.prepared.map.invalid_pixels()
    }

    /// Whether no light comes from anywhere.
    pub fn is_black(&self) -> bool {
        self.power().is_black()
    }

    /// Bytes of the picture and of what directions are chosen by.
    pub fn memory(&self) -> usize {
        self.prepared.map.memory() + self.prepared.distribution.memory()
    }

    /// From the scene's directions to the picture's.
    fn turned_to_map(&self, d: DVec3) -> DVec3 {
        let (sin, cos) = self.turn;
        DVec3::new(cos * d.x - sin * d.z, d.y, sin * d.x + cos * d.z)
    }

    /// And back.
    fn turned_to_scene(&self, d: DVec3) -> DVec3 {
        let (sin, cos) = self.turn;
        DVec3::new(cos * d.x + sin * d.z, d.y, cos * d.z - sin * d.x)
    }
}

#[cfg(test)]
mod tests;
