//! Sun and sky: the light of a clear day, computed from the composition of the atmosphere.
//!
//! The model is a spherical atmosphere of air molecules (Rayleigh scattering), aerosol ("dust") and ozone (absorption
//! only). For each direction of an environment map of the upper hemisphere, single scattering is integrated along the
//! view ray:
//!
//! ```text
//!   L(view) = ∫ T(0..t) · [ T(t..sun) · (σ_air · p_air + σ_dust · p_dust) + (σ_air + σ_dust) · L_ms ] dt
//!
//!   top of the atmosphere _____________________
//!                             /      / sun
//!              view ray      /      /         T: transmittance, σ: scattering coefficient,
//!                     ___---x------           p: phase function, x: scattering point
//!             ___--- t
//!        o---___________________ ground
//! ```
//!
//! L_ms is the light scattered two times or more. It comes from the geometric series of Hillaire 2020, "A scalable
//! and production ready sky and atmosphere rendering technique" (section 5.5). Light is computed at sixteen
//! wavelengths and then converted to linear sRGB. Unlike fits to measured skies (Preetham 1999, Hošek & Wilkie 2012),
//! the model covers every elevation of the sun, down to twilight, and every composition. It costs a moment when the
//! scene is prepared and nothing afterwards.
//!
//! The result is an ordinary environment light, and the sun is a directional light with an extent. [`spectrum`] has
//! the wavelengths, [`atmosphere`] the densities along a ray, [`scatter`] the integration.

mod atmosphere;
mod scatter;
mod spectrum;

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use atmosphere::Atmosphere;
use scatter::Sky;
use spectrum::{Colors, Depths};

use super::LightSetting;
use super::directional::{Directional, DirectionalDesc};
use super::environment::{EnvironmentLight, tilt};
use crate::color::Spectrum;
use crate::image::{Image, Pixels};
use crate::math::elementary::{asin, atan2, cos, sin_cos};
use crate::math::{DVec3, radians};
use crate::schema::{ErrorCode, Range, SceneError, params};

params! {
    /// Daylight of a clear sky, computed from air, dust and ozone, and the sun. +y is up, −z is north, +x is east.
    /// The sky is an environment light; below the horizon it shows ground lit by sun and sky, unless `ground` is
    /// false. The sun is a directional light with an extent, visible to physical integrators. Exposure 0 suits noon:
    /// one unit of light is a quarter of the sunlight above the atmosphere, about 33,000 lux.
    pub struct SkyDesc as "sky" {
        /// Elevation of the sun above the horizon, in degrees. A few degrees below 0 there is twilight.
        elevation: f64 = 35.0, in Range::closed(-90.0, 90.0);
        /// Azimuth of the sun, in degrees from north (−z) towards east (+x).
        azimuth: f64 = 225.0;
        /// The direction towards the sun, of any length; replaces `elevation` and `azimuth`.
        direction: Option<DVec3> = None;
        /// The direction towards the zenith, of any length. Another one than +y turns sky, ground and the other directions
        /// the shortest way.
        up: DVec3 = DVec3::Y;
        /// Amount of air: 1 is that at sea level, 0.5 that of high mountains.
        air: f64 = 1.0, in Range::closed(0.0, 10.0);
        /// Amount of dust and haze: 1 is a clear day in the country, 5 a hazy one.
        dust: f64 = 1.0, in Range::closed(0.0, 100.0);
        /// Amount of ozone: 1 is 300 Dobson units. Ozone keeps twilight blue.
        ozone: f64 = 1.0, in Range::closed(0.0, 10.0);
        /// Fraction of light that the ground reflects; bright ground makes a brighter sky.
        ground_albedo: Spectrum = Spectrum::grey(0.3), in Range::UNIT;
        /// Whether the ground is seen below the horizon. Otherwise it is black there, for scenes with a floor of their own.
        ground: bool = true;
        /// Whether the sun is included; otherwise the sky alone emits light.
        sun: bool = true;
        /// Angular diameter of the sun, in degrees; at 0 it has no extent.
        sun_angle: f64 = 0.53, in Range::closed(0.0, 90.0);
        /// Multiplies the sun's light, not the sky's.
        sun_strength: Spectrum = Spectrum::WHITE, in Range::NON_NEGATIVE;
        /// Multiplies the light of the sky and of the ground, not the sun's; at 0 the sun is alone.
        sky_strength: Spectrum = Spectrum::WHITE, in Range::NON_NEGATIVE;
        /// Multiplies the light of sun and sky.
        strength: f64 = 1.0, in Range::NON_NEGATIVE;
    }
    example r#"[[light]]
type = "sky"
elevation = 12
azimuth = 240
"#
}

/// Size of the environment map.
const WIDTH: u32 = 512;
const HEIGHT: u32 = WIDTH / 2;

/// Azimuths for which each row is computed, from the sun's to the opposite one.
const AZIMUTHS: usize = 65;

impl SkyDesc {
    /// Rotates sun and sky about +y by degrees, in the sense of an environment's `rotation`: 90 moves what was in the
    /// north (−z) to the west.
    pub fn turn(&mut self, degrees: f64) {
        let (sin, cos) = sin_cos(radians(degrees));
        let turned = |d: DVec3| DVec3::new(cos * d.x + sin * d.z, d.y, cos * d.z - sin * d.x);
        match tilt(self.up) {
            None => self.azimuth -= degrees,
            // The sun turns with the zenith.
            Some(tilt) if self.direction.is_none() => {
                self.direction = Some(tilt * towards(radians(self.elevation), radians(self.azimuth)));
            }
            Some(_) => {}
        }
        self.direction = self.direction.map(turned);
        self.up = turned(self.up);
    }

    /// Elevation of the sun and azimuth from north towards east, radians, where the zenith is +y.
    fn sun_angles(&self) -> Result<(f64, f64), SceneError> {
        let Some(direction) = self.direction else {
            return Ok((radians(self.elevation), radians(self.azimuth)));
        };
        let d = direction.try_normalize().ok_or_else(|| {
            SceneError::new(ErrorCode::OutOfRange, "the `direction` of the sun must not be zero")
        })?;
        let d = tilt(self.up).map_or(d, |tilt| tilt.transpose() * d);
        let azimuth = if d.x == 0.0 && d.z == 0.0 { 0.0 } else { atan2(d.x, -d.z) };
        Ok((asin(d.y), azimuth))
    }

    /// Prepares the sky and, if it has one, the sun. For integrators that are not physical, the sun's irradiance is
    /// divided by π, as samples of environments are.
    pub(super) fn prepare(
        &self,
        setting: &LightSetting<'_>,
    ) -> Result<(EnvironmentLight, Option<Directional>), SceneError> {
        let (elevation, azimuth) = self.sun_angles()?;
        // The image has the sun in the north.
        let rotation = sin_cos(-azimuth);
        let scale = self.sky_strength * self.strength as f32;
        let compensated = setting.compensated;
        let key = DayKey {
            elevation,
            air: self.air,
            dust: self.dust,
            ozone: self.ozone,
            ground_albedo: self.ground_albedo,
            ground: self.ground,
        };
        let same = |light: &&EnvironmentLight| {
            light.is_compensated() == compensated && light.day().is_some_and(|day| day.key == key)
        };
        let environment = match setting.environments().find(same) {
            Some(light) => light.with(scale, rotation, self.up),
            None => {
                let (day, image) = key.compute(setting.threads);
                EnvironmentLight::of_day(day, Arc::new(image), scale, rotation, self.up, compensated)?
            }
        };
        let sunlight = environment.day().map_or(Spectrum::BLACK, |day| day.sunlight);
        let factor = if setting.physical { 1.0 } else { 1.0 / PI };
        let light = sunlight * self.sun_strength * (self.strength * factor) as f32;
        if !self.sun || light.is_black() {
            return Ok((environment, None));
        }
        let upright = towards(elevation, azimuth);
        let sun = DirectionalDesc {
            from: Some(tilt(self.up).map_or(upright, |tilt| tilt * upright)),
            color: light,
            angle: self.sun_angle,
            seen_angle: 0.5 * self.sun_angle,
            ..DirectionalDesc::default()
        };
        Ok((environment, Some(sun.prepare()?)))
    }
}

/// The direction of an elevation and an azimuth from north (−z) towards east (+x), where the zenith is +y.
fn towards(elevation: f64, azimuth: f64) -> DVec3 {
    let ((sin_e, cos_e), (sin_a, cos_a)) = (sin_cos(elevation), sin_cos(azimuth));
    DVec3::new(sin_a * cos_e, sin_e, -cos_a * cos_e)
}

/// The parameters that the image of a sky depends on.
#[derive(Clone, Debug, PartialEq)]
struct DayKey {
    /// Elevation of the sun, radians.
    elevation: f64,
    air: f64,
    dust: f64,
    ozone: f64,
    ground_albedo: Spectrum,
    ground: bool,
}

/// The parameters of a computed sky, and its sunlight.
#[derive(Clone, Debug)]
pub(super) struct Day {
    key: DayKey,
    /// Irradiance of the sun on a surface that faces it.
    sunlight: Spectrum,
}

impl DayKey {
    /// Computes the sunlight and the environment map, in which the sun is in the north. `threads` of 0 uses all.
    fn compute(self, threads: usize) -> (Day, Image) {
        let colors = Colors::new();
        let atmosphere = Atmosphere { depths: Depths::new(self.air, self.dust, self.ozone) };
        let zenith_angle = 0.5 * PI - self.elevation;
        let sky = Sky::new(atmosphere, zenith_angle, f64::from(self.ground_albedo.luminance()));
        let sunlight = colors.color(&sky.sunlight(0.0, zenith_angle));
        let facing = cos(zenith_angle).max(0.0) as f32;
        let ground = if self.ground { self.ground_albedo } else { Spectrum::BLACK };
        let image = environment_map(&sky, &colors, ground, sunlight * facing, threads);
        (Day { key: self, sunlight }, image)
    }
}

/// The environment map, with the sun in the north; `sun` is the sun's irradiance on level ground.
fn environment_map(sky: &Sky, colors: &Colors, albedo: Spectrum, sun: Spectrum, threads: usize) -> Image {
    let mut samples = Vec::with_capacity((WIDTH * HEIGHT * 3) as usize);
    let mut irradiance = sun;
    for (y, row) in (0..).zip(rows_above_horizon(sky, colors, threads)) {
        let edge = |y: u32| cos(PI * f64::from(y) / f64::from(HEIGHT));
        let solid_angle = TAU / f64::from(WIDTH) * (edge(y) - edge(y + 1));
        let mut sum = Spectrum::BLACK;
        for x in 0..WIDTH {
            // Azimuth from the sun, in steps of `row`.
            let step = ((f64::from(x) + 0.5) / f64::from(WIDTH) - 0.5).abs() * 2.0 * (AZIMUTHS - 1) as f64;
            let i = (step as usize).min(AZIMUTHS - 2);
            let color = row[i].lerp(row[i + 1], (step - i as f64) as f32);
            samples.extend(color.to_array());
            sum += color;
        }
        irradiance += sum * (solid_angle * cos_of_row(y)) as f32;
    }
    let ground = irradiance * albedo * (1.0 / PI) as f32;
    for _ in 0..WIDTH * HEIGHT / 2 {
        samples.extend(ground.to_array());
    }
    Image { width: WIDTH, height: HEIGHT, channels: 3, pixels: Pixels::F32(samples) }
}

/// Cosine of the angle from the zenith in the middle of a row.
fn cos_of_row(y: u32) -> f64 {
    cos(PI * (f64::from(y) + 0.5) / f64::from(HEIGHT))
}

/// The colours of each row above the horizon, at [`AZIMUTHS`].
fn rows_above_horizon(sky: &Sky, colors: &Colors, threads: usize) -> Vec<[Spectrum; AZIMUTHS]> {
    let cos_azimuths: [f64; AZIMUTHS] = std::array::from_fn(|i| cos(PI * i as f64 / (AZIMUTHS - 1) as f64));
    let mut rows = vec![[Spectrum::BLACK; AZIMUTHS]; HEIGHT as usize / 2];
    let threads = match threads {
        0 => turner_host::thread::available(),
        n => n,
    };
    let fill = |first: usize, rows: &mut [[Spectrum; AZIMUTHS]]| {
        for (y, row) in (first as u32..).zip(rows) {
            *row = sky.radiances(0.0, cos_of_row(y), &cos_azimuths).map(|light| colors.color(&light));
        }
    };
    let part = rows.len().div_ceil(threads);
    let mut parts = rows.chunks_mut(part).enumerate().map(|(i, rows)| (i * part, rows));
    let own = parts.next();
    turner_host::thread::scope(|scope| {
        parts.for_each(|(first, rows)| {
            scope.spawn(move || fill(first, rows));
        });
        own.into_iter().for_each(|(first, rows)| fill(first, rows));
    });
    rows
}

#[cfg(test)]
mod tests;
