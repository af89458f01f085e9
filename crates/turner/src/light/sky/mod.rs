//! Sun and sky: the light of a clear day, computed from what the air is made of.
//!
//! Sunlight enters a spherical atmosphere of air, dust and ozone. What is scattered once is integrated along each direction of a
//! picture of the upper hemisphere; what is scattered more often is added by the geometric series of Hillaire 2020. That holds for any height of
//! the sun, down to twilight, and for any mixture of the air, which fits to measured skies (Preetham 1999, Hošek & Wilkie 2012) do
//! not; it takes a moment while the scene is prepared, and no time after. The picture is an environment like any other; the sun is a
//! directional light with an extent.
//!
//! [`spectrum`] has the wavelengths, [`atmosphere`] what lies along a ray, [`scatter`] the light.

mod atmosphere;
mod scatter;
mod spectrum;

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use atmosphere::Atmosphere;
use scatter::Sky;
use spectrum::{Colors, Depths};

use super::directional::{Directional, DirectionalDesc};
use super::environment::EnvironmentLight;
use crate::color::Spectrum;
use crate::image::{Image, Pixels};
use crate::math::elementary::{asin, atan2, cos, sin_cos};
use crate::math::{DVec3, radians};
use crate::schema::{ErrorCode, Range, SceneError, params};

params! {
    /// The light of a clear day: a sky computed from air, dust and ozone, and the sun in it, which rises and sets as it does on earth. +y is up, −z is north, +x is east.
    /// The sky is an environment; below the horizon it shows a ground in the same light. The sun is a directional light with an extent, which physical integrators
    /// show. Exposure 0 suits noon: a unit of light is a quarter of the sun's above the air, 33,000 lux.
    pub struct SkyDesc as "sky" {
        /// Angle of the sun above the horizon, degrees; some degrees below it there is twilight.
        elevation: f64 = 35.0, in Range::closed(-90.0, 90.0);
        /// Where the sun stands: degrees from north (−z) over east (+x).
        azimuth: f64 = 225.0;
        /// The direction towards the sun, of any length, instead of `elevation` and `azimuth`.
        direction: Option<DVec3> = None;
        /// How much air there is: 1 is that of the earth at sea level, 0.5 that of high mountains.
        air: f64 = 1.0, in Range::closed(0.0, 10.0);
        /// How much dust and haze: 1 is a clear day in the country, 5 a hazy one.
        dust: f64 = 1.0, in Range::closed(0.0, 100.0);
        /// How much ozone: 1 is 300 Dobson units. It keeps twilight blue.
        ozone: f64 = 1.0, in Range::closed(0.0, 10.0);
        /// The part of light that the ground returns: the sky above bright ground is brighter.
        ground_albedo: Spectrum = Spectrum::grey(0.3), in Range::UNIT;
        /// Whether the sun shines, or its sky alone.
        sun: bool = true;
        /// Angle from one side of the sun to the other, degrees; 0 is a sun without extent.
        sun_angle: f64 = 0.53, in Range::closed(0.0, 90.0);
        /// The sun's light is multiplied by this, not the sky's.
        sun_strength: f64 = 1.0, in Range::NON_NEGATIVE;
        /// All light is multiplied by this.
        strength: f64 = 1.0, in Range::NON_NEGATIVE;
    }
    example r#"[[light]]
type = "sky"
elevation = 12
azimuth = 240
"#
}

/// Columns and rows of the picture.
const WIDTH: u32 = 512;
const HEIGHT: u32 = WIDTH / 2;

/// Directions around the zenith for which light is computed, from the sun's to the opposite one.
const TURNS: usize = 65;

impl SkyDesc {
    /// Turns sun and sky about +y by degrees, as an environment is: what was in the north (−z) comes to be in the west after 90.
    pub fn turn(&mut self, degrees: f64) {
        self.azimuth -= degrees;
        let (sin, cos) = sin_cos(radians(degrees));
        self.direction =
            self.direction.map(|d| DVec3::new(cos * d.x + sin * d.z, d.y, cos * d.z - sin * d.x));
    }

    /// Angles of the sun: above the horizon and from north over east, radians.
    fn sun_place(&self) -> Result<(f64, f64), SceneError> {
        let Some(direction) = self.direction else {
            return Ok((radians(self.elevation), radians(self.azimuth)));
        };
        let d = direction.try_normalize().ok_or_else(|| {
            SceneError::new(ErrorCode::OutOfRange, "the `direction` of the sun must not be zero")
        })?;
        let azimuth = if d.x == 0.0 && d.z == 0.0 { 0.0 } else { atan2(d.x, -d.z) };
        Ok((asin(d.y), azimuth))
    }

    /// The sky, and the sun if it shines. `compensated` is for environments; integrators that are not physical
    /// take 1/π of the sun's light, as they do of environments.
    pub(super) fn prepare(
        &self,
        compensated: bool,
        physical: bool,
    ) -> Result<(EnvironmentLight, Option<Directional>), SceneError> {
        let (elevation, azimuth) = self.sun_place()?;
        let colors = Colors::new();
        let atmosphere = Atmosphere { depths: Depths::new(self.air, self.dust, self.ozone) };
        let zenith_angle = 0.5 * PI - elevation;
        let sky = Sky::new(atmosphere, zenith_angle, f64::from(self.ground_albedo.luminance()));
        let sunlight = colors.color(&sky.sunlight(0.0, zenith_angle));
        let facing = cos(zenith_angle).max(0.0) as f32;
        let picture = picture(&sky, &colors, self.ground_albedo, sunlight * facing);
        // The picture has the sun in the north.
        let turn = sin_cos(-azimuth);
        let scale = Spectrum::WHITE * self.strength as f32;
        let around = EnvironmentLight::of_picture(Arc::new(picture), scale, turn, compensated)?;
        let share = if physical { 1.0 } else { 1.0 / PI };
        let light = sunlight * (self.strength * self.sun_strength * share) as f32;
        if !self.sun || light.is_black() {
            return Ok((around, None));
        }
        let ((sin_e, cos_e), (sin_a, cos_a)) = (sin_cos(elevation), sin_cos(azimuth));
        let sun = DirectionalDesc {
            from: Some(DVec3::new(sin_a * cos_e, sin_e, -cos_a * cos_e)),
            color: light,
            angle: self.sun_angle,
            seen_angle: 0.5 * self.sun_angle,
            ..DirectionalDesc::default()
        };
        Ok((around, Some(sun.prepare()?)))
    }
}

/// The environment's picture, with the sun in the north; `sun` is what it brings to level ground.
fn picture(sky: &Sky, colors: &Colors, albedo: Spectrum, sun: Spectrum) -> Image {
    let mut samples = Vec::with_capacity((WIDTH * HEIGHT * 3) as usize);
    let mut irradiance = sun;
    let turns: Vec<f64> = (0..TURNS).map(|i| cos(PI * i as f64 / (TURNS - 1) as f64)).collect();
    for y in 0..HEIGHT / 2 {
        let edge = |y: u32| cos(PI * f64::from(y) / f64::from(HEIGHT));
        let cos_view = cos(PI * (f64::from(y) + 0.5) / f64::from(HEIGHT));
        let solid_angle = TAU / f64::from(WIDTH) * (edge(y) - edge(y + 1));
        let row: Vec<Spectrum> =
            turns.iter().map(|turn| colors.color(&sky.radiance(0.0, cos_view, *turn))).collect();
        let mut sum = Spectrum::BLACK;
        for x in 0..WIDTH {
            // From the sun's direction, in steps of the row.
            let turn = ((f64::from(x) + 0.5) / f64::from(WIDTH) - 0.5).abs() * 2.0 * (TURNS - 1) as f64;
            let i = (turn as usize).min(TURNS - 2);
            let color = row[i].lerp(row[i + 1], (turn - i as f64) as f32);
            samples.extend(color.to_array());
            sum += color;
        }
        irradiance += sum * (solid_angle * cos_view) as f32;
    }
    let ground = irradiance * albedo * (1.0 / PI) as f32;
    for _ in 0..WIDTH * HEIGHT / 2 {
        samples.extend(ground.to_array());
    }
    Image { width: WIDTH, height: HEIGHT, channels: 3, pixels: Pixels::F32(samples) }
}

#[cfg(test)]
mod tests;
