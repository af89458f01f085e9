//! Environment light: light from an image of the environment (environment map), infinitely far away.
//!
//! [`map`] relates directions and pixels, [`distribution`] samples directions in proportion to their luminance, and
//! [`studio`] is the built-in image used when no file is given.

mod adaptive;
mod batch;
mod cells;
mod distribution;
mod map;
mod studio;
mod tiles;

use std::f64::consts::PI;
use std::sync::{Arc, OnceLock};

use crate::bsdf::sample_cosine;
use crate::color::Spectrum;
use crate::image::Image;
use crate::light::LightSetting;
use crate::light::sky::Day;
use crate::math::elementary::atan2;
use crate::math::{DMat3, DVec3, Frame, radians};
use crate::schema::error::escape;
use crate::schema::{Asset, ErrorCode, ImageId, Range, SceneError, choice, params};
pub use adaptive::{AdaptiveEnvironment, EnvironmentLearning};
pub use batch::EnvironmentBatch;
use distribution::Distribution;
use map::EnvironmentMap;

choice! {
    /// Where the first and the last row of pixels of an environment map lie.
    pub enum MapPoles {
        /// The outer edges of the rows are at the poles, as in most programs.
        Edges = "edges",
        /// The centres of their pixels are at the poles, as in Mitsuba.
        Centers = "centers",
    }
}

params! {
    /// Light from an environment map in equirectangular (latitude-longitude) projection, twice as wide as high, or
    /// from a built-in photographer's studio. +y is up. The centre of the image lies along −z, and +x lies to its
    /// right. The upper edge is the zenith, the lower edge the nadir. EXR and HDR files hold linear radiance; images
    /// of 8 and 16 bits are read as sRGB. Negative and non-finite samples count as 0; alpha is ignored.
    pub struct EnvironmentDesc as "environment" {
        /// The image, as a path relative to the scene file. Without it a neutral studio is used: a white sweep
        /// under a dark ceiling, a large soft light at the upper left of the front (+z), a dim one on the right, and a
        /// third high behind. In the studio a white floor has a brightness of about 0.9.
        file: Option<ImageId> = None;
        /// Multiplies the light.
        strength: f64 = 1.0, in Range::NON_NEGATIVE;
        /// Rotation about +y, degrees: 90 moves what was along −z to −x.
        rotation: f64 = 0.0;
        /// Where the zenith of the image is: after the rotation, the shortest turn takes +y there.
        up: DVec3 = DVec3::Y;
        /// Where the first and the last row of pixels lie.
        poles: MapPoles = MapPoles::Edges;
        /// Multiplies the light, per channel.
        tint: Spectrum = Spectrum::WHITE, in Range::NON_NEGATIVE;
    }
    example r#"[[light]]
type = "environment"
rotation = 30
strength = 0.8
"#
}

/// A sampled direction of an environment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnvironmentSample {
    /// Towards the light, a unit vector.
    pub direction: DVec3,
    /// The radiance from there.
    pub radiance: Spectrum,
    /// Probability density per solid angle; greater than 0.
    pub pdf: f64,
}

/// A prepared environment. Clones share the image.
#[derive(Clone, Debug)]
pub struct EnvironmentLight {
    prepared: Arc<Prepared>,
    /// Tint times strength.
    scale: Spectrum,
    /// Sine and cosine of the rotation.
    rotation: (f64, f64),
    /// The turn after it, from +y to the zenith, if any.
    tilt: Option<DMat3>,
}

#[derive(Debug)]
struct Prepared {
    map: EnvironmentMap,
    distribution: Distribution,
    /// The image's radiance integrated over all directions, per channel.
    total: [f64; 3],
    /// Whether directions are sampled with MIS compensation.
    compensated: bool,
    /// The sun and atmosphere that the image was computed from, if it is a sky.
    day: Option<Day>,
}

impl Prepared {
    fn new(image: Arc<Image>, poles: MapPoles, compensated: bool) -> Result<Prepared, SceneError> {
        let map = EnvironmentMap::new(image, poles);
        let distribution = Distribution::new(&map, compensated)?;
        let total = map.integral();
        Ok(Prepared { map, distribution, total, compensated, day: None })
    }
}

impl EnvironmentDesc {
    /// The built-in studio.
    pub fn studio() -> EnvironmentDesc {
        EnvironmentDesc::default()
    }

    /// The environment with the rotation and zenith of a rotation matrix, which may have a scale; `None` if the matrix is
    /// none.
    pub fn turned_by(self, m: DMat3) -> Option<EnvironmentDesc> {
        let scale = m.y_axis.length();
        let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis / scale);
        let is_rotation = (x.cross(y) - z).length() < 1e-6 && (y.cross(z) - x).length() < 1e-6;
        if !(is_rotation && scale > 0.0 && scale.is_finite()) {
            return None;
        }
        // Rounding must not tilt it.
        let up = if (y - DVec3::Y).length() < 1e-9 { DVec3::Y } else { y };
        let about = tilt(up).map_or(z, |tilt| tilt.transpose() * z);
        let rotation = atan2(about.x, about.z).to_degrees();
        Some(EnvironmentDesc { rotation, up, ..self })
    }

    /// Prepares the light; `images` are the scene's. With `compensated`, directions are sampled for use with another
    /// sampling strategy and the balance heuristic: see [`EnvironmentLight::sample`].
    pub fn prepare(
        &self,
        images: &[Asset<Image>],
        compensated: bool,
    ) -> Result<EnvironmentLight, SceneError> {
        self.prepare_again(&LightSetting { images, compensated, physical: true, threads: 0, before: &[] })
    }

    /// As [`EnvironmentDesc::prepare`]. Reuses the sampling tables of `setting.before` if its image is the same.
    pub(super) fn prepare_again(&self, setting: &LightSetting<'_>) -> Result<EnvironmentLight, SceneError> {
        let LightSetting { images, compensated, .. } = *setting;
        let prepared = match self.file {
            None => studio(compensated)?,
            Some(id) => {
                let asset = images.get(id.index()).ok_or_else(|| {
                    let message = "an environment light refers to an image that the scene does not have";
                    SceneError::new(ErrorCode::Internal, message)
                })?;
                if !asset.data.is_consistent() {
                    let message = format!("the samples of {} do not fit its size", escape(&asset.uri));
                    return Err(SceneError::new(ErrorCode::Image, message));
                }
                let mut before = setting.environments().map(|light| &light.prepared);
                let kept = before
                    .find(|old| old.compensated == compensated && old.map.is_of(&asset.data, self.poles))
                    .cloned();
                match kept {
                    Some(kept) => kept,
                    None => Arc::new(Prepared::new(asset.data.clone(), self.poles, compensated)?),
                }
            }
        };
        let rotation = crate::math::elementary::sin_cos(radians(self.rotation));
        let scale = self.tint * self.strength as f32;
        Ok(EnvironmentLight { prepared, scale, rotation, tilt: tilt(self.up) })
    }
}

/// The studio is the same for every scene: it is prepared once for each sampling distribution.
fn studio(compensated: bool) -> Result<Arc<Prepared>, SceneError> {
    static STUDIOS: [OnceLock<Arc<Prepared>>; 2] = [OnceLock::new(), OnceLock::new()];
    let made = &STUDIOS[usize::from(compensated)];
    if let Some(studio) = made.get() {
        return Ok(studio.clone());
    }
    let studio = Arc::new(Prepared::new(Arc::new(studio::image()), MapPoles::Edges, compensated)?);
    Ok(made.get_or_init(|| studio).clone())
}

impl EnvironmentLight {
    /// An environment from a consistent generated image, multiplied by `scale` and rotated by an angle given as sine
    /// and cosine.
    #[cfg(test)]
    pub(super) fn from_image(
        image: Arc<Image>,
        scale: Spectrum,
        rotation: (f64, f64),
        compensated: bool,
    ) -> Result<EnvironmentLight, SceneError> {
        let prepared = Arc::new(Prepared::new(image, MapPoles::Edges, compensated)?);
        Ok(EnvironmentLight { prepared, scale, rotation, tilt: None })
    }

    /// A sky from its computed image, multiplied by `scale`, rotated by an angle given as sine and cosine, and turned so that
    /// its zenith is `up`.
    pub(super) fn of_day(
        day: Day,
        image: Arc<Image>,
        scale: Spectrum,
        rotation: (f64, f64),
        up: DVec3,
        compensated: bool,
    ) -> Result<EnvironmentLight, SceneError> {
        let prepared = Prepared { day: Some(day), ..Prepared::new(image, MapPoles::Edges, compensated)? };
        Ok(EnvironmentLight { prepared: Arc::new(prepared), scale, rotation, tilt: tilt(up) })
    }

    /// Whether both have the same prepared image.
    #[cfg(test)]
    pub(super) fn shares_image(&self, other: &EnvironmentLight) -> bool {
        Arc::ptr_eq(&self.prepared, &other.prepared)
    }

    /// The sun and atmosphere of a sky.
    pub(super) fn day(&self) -> Option<&Day> {
        self.prepared.day.as_ref()
    }

    /// Whether directions are sampled with MIS compensation.
    pub(super) fn is_compensated(&self) -> bool {
        self.prepared.compensated
    }

    /// The same environment with another scale, rotation and zenith.
    pub(super) fn with(&self, scale: Spectrum, rotation: (f64, f64), up: DVec3) -> EnvironmentLight {
        EnvironmentLight { prepared: self.prepared.clone(), scale, rotation, tilt: tilt(up) }
    }

    /// The radiance, if it is the same in all directions.
    #[inline]
    pub(crate) fn uniform(&self) -> Option<Spectrum> {
        self.prepared.map.uniform().map(|radiance| self.scaled(radiance))
    }

    /// A sample with a cosine-weighted direction about a unit normal.
    pub(crate) fn sample_by_cosine(&self, n: DVec3, u: [f64; 2]) -> Option<EnvironmentSample> {
        let local = sample_cosine(u);
        let direction = Frame::from_z(n).to_world(local);
        let radiance = self.uniform().unwrap_or_else(|| self.found(direction).0);
        let pdf = local.z / PI;
        (pdf > 0.0).then_some(EnvironmentSample { direction, radiance, pdf })
    }

    /// Radiance from a direction (a vector towards the light, of any non-zero length): bilinear between pixel
    /// centres, never negative, always finite.
    pub fn radiance(&self, direction: DVec3) -> Spectrum {
        self.scaled(self.prepared.map.radiance(self.to_image(direction)))
    }

    /// The same radiance within rounding, and the pdf of [`EnvironmentLight::pdf`], at little more than half the cost
    /// of [`EnvironmentLight::radiance`] alone.
    #[inline]
    pub fn found(&self, direction: DVec3) -> (Spectrum, f64) {
        let uv = map::coordinates_fast(self.to_image(direction));
        (self.scaled(self.prepared.map.at(uv)), self.prepared.distribution.pdf_at(uv))
    }

    #[inline]
    fn scaled(&self, radiance: Spectrum) -> Spectrum {
        Spectrum::from(
            [(radiance.r, self.scale.r), (radiance.g, self.scale.g), (radiance.b, self.scale.b)]
                .map(|(v, scale)| (v * scale).min(f32::MAX)),
        )
    }

    /// Samples a direction from two uniform numbers in 0..1, with a density proportional to the image's luminance
    /// (the tint does not count). `None` if the image is black.
    ///
    /// A direction that emits light has a pdf of 0 only if the environment was prepared as `compensated`: directions
    /// dimmer than the mean are then left to the other strategy.
    pub fn sample(&self, u: [f64; 2]) -> Option<EnvironmentSample> {
        let (direction, uv, pdf) = self.prepared.distribution.sample(u)?;
        let radiance = self.scaled(self.prepared.map.at(uv));
        Some(EnvironmentSample { direction: self.to_world(direction), radiance, pdf })
    }

    /// The pdf of [`EnvironmentLight::sample`] for a direction, per solid angle.
    pub fn pdf(&self, direction: DVec3) -> f64 {
        self.prepared.distribution.pdf(self.to_image(direction))
    }

    /// The same environment after a further rotation about +y, in degrees.
    pub(crate) fn turned(&self, degrees: f64) -> EnvironmentLight {
        let (s, c) = crate::math::elementary::sin_cos(radians(degrees));
        let (sin, cos) = self.rotation;
        EnvironmentLight { rotation: (sin * c + cos * s, cos * c - sin * s), ..self.clone() }
    }

    /// How bright unshadowed white surfaces with these unit normals are: the luminance of their irradiance over π, to
    /// within a few percent.
    pub(crate) fn brightness(&self, normals: &[DVec3]) -> Vec<f64> {
        const COLUMNS: u32 = 128;
        const ROWS: u32 = 64;
        let map = &self.prepared.map;
        let (width, height) = map.size();
        let mut blocks = vec![0.0; (COLUMNS * ROWS) as usize];
        let block_of = |i: u32, n: u32, of: u32| (u64::from(i) * u64::from(n) / u64::from(of)) as u32;
        for (y, solid_angle) in (0..height).zip(map::solid_angles(width, height)) {
            let row = block_of(y, ROWS, height) * COLUMNS;
            for x in 0..width {
                let radiance = self.scaled(map.pixel(x, y)).luminance();
                blocks[(row + block_of(x, COLUMNS, width)) as usize] += f64::from(radiance) * solid_angle;
            }
        }
        let mut sums = vec![0.0; normals.len()];
        for (i, light) in (0..).zip(blocks).filter(|(_, light)| *light > 0.0) {
            let (row, column) = (f64::from(i / COLUMNS) + 0.5, f64::from(i % COLUMNS) + 0.5);
            let (sin, cos) = crate::math::elementary::sin_cos(std::f64::consts::PI * row / f64::from(ROWS));
            let direction = self.to_world(map::direction_at(column / f64::from(COLUMNS), sin, cos));
            for (sum, normal) in sums.iter_mut().zip(normals) {
                *sum += light * direction.dot(*normal).max(0.0) * std::f64::consts::FRAC_1_PI;
            }
        }
        sums
    }

    /// The radiance integrated over all directions. Times π r² it is the power that falls on a sphere of radius r.
    pub fn power(&self) -> Spectrum {
        let [r, g, b] = self.prepared.total;
        let band = |v: f64, scale: f32| (v * f64::from(scale)).min(f64::from(f32::MAX)) as f32;
        Spectrum::new(band(r, self.scale.r), band(g, self.scale.g), band(b, self.scale.b))
    }

    /// Pixels of the image that count as 0 because a sample is negative or non-finite.
    pub fn invalid_pixels(&self) -> u64 {
        self.prepared.map.invalid_pixels()
    }

    /// Whether it emits no light.
    pub fn is_black(&self) -> bool {
        self.power().is_black()
    }

    /// Memory of the image and the sampling tables, in bytes.
    pub fn memory(&self) -> usize {
        self.prepared.map.memory() + self.prepared.distribution.memory()
    }

    /// Rotates a direction from world space to the image.
    fn to_image(&self, d: DVec3) -> DVec3 {
        let (sin, cos) = self.rotation;
        let d = self.upright(d);
        DVec3::new(cos * d.x - sin * d.z, d.y, sin * d.x + cos * d.z)
    }

    /// Rotates a direction from the image to world space.
    fn to_world(&self, d: DVec3) -> DVec3 {
        let (sin, cos) = self.rotation;
        self.tilted(DVec3::new(cos * d.x + sin * d.z, d.y, cos * d.z - sin * d.x))
    }

    /// A direction in world space, turned so that the zenith is +y.
    #[inline]
    fn upright(&self, d: DVec3) -> DVec3 {
        self.tilt.map_or(d, |m| DVec3::new(m.x_axis.dot(d), m.y_axis.dot(d), m.z_axis.dot(d)))
    }

    /// The reverse of [`EnvironmentLight::upright`].
    #[inline]
    fn tilted(&self, d: DVec3) -> DVec3 {
        self.tilt.map_or(d, |m| m * d)
    }
}

/// The shortest turn from +y to the zenith; `None` if there is none.
pub(super) fn tilt(up: DVec3) -> Option<DMat3> {
    let up = up.try_normalize().filter(|up| *up != DVec3::Y)?;
    if up.y < -1.0 + 1e-12 {
        return Some(DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0)));
    }
    // Rodrigues' formula for the axis y × up.
    let (x, z, k) = (up.x, up.z, 1.0 / (1.0 + up.y));
    let of_x = DVec3::new(1.0 - k * x * x, -x, -k * x * z);
    Some(DMat3::from_cols(of_x, up, DVec3::new(-k * x * z, -z, 1.0 - k * z * z)))
}

#[cfg(test)]
mod adaptive_tests;
#[cfg(test)]
mod tests;
