//! Integration of scattered light: single scattering with the phase functions of molecules and dust, multiple
//! scattering as if isotropic (Hillaire 2020, "A scalable and production ready sky and atmosphere rendering
//! technique", section 5.5).
//!
//! Let L₂ be the mean radiance, over all directions, that arrives at a point after one scattering or one reflection by
//! the ground; the point itself scatters it a second time. Let f be the mean radiance that arrives if every point
//! scatters a uniform unit radiance. Each further order is f times the last, so all orders together are
//!
//! ```text
//!   L_ms = L₂ (1 + f + f² + ...) = L₂ / (1 − f)
//! ```

use std::f64::consts::{PI, TAU};

use super::atmosphere::{
    Amounts, Atmosphere, GROUND, SunTable, add, along, distance_to_boundary, height_row, row_height,
    visible_sun,
};
use super::spectrum::{BANDS, Bands};
use crate::math::elementary::{acos, cos, sin_cos};

/// Steps along a ray of the image, and along the rays of the multiple-scattering table.
const STEPS: u32 = 40;
const FEW_STEPS: u32 = 16;

/// Size of the multiple-scattering table: heights, and zenith angles of the sun.
const HEIGHTS: usize = 12;
const ANGLES: usize = 7;
const ZENITH_RANGE: f64 = 0.2;

/// Asymmetry g of the dust's phase function.
const DUST_ASYMMETRY: f64 = 0.76;

/// The atmosphere with a sun. Radiances are fractions of the sun's irradiance above the atmosphere, per steradian.
pub(super) struct Sky {
    atmosphere: Atmosphere,
    sun: SunTable,
    /// Zenith angle of the sun at the observer, radians.
    zenith_angle: f64,
    /// L_ms by height and zenith angle of the sun.
    multiple: Vec<Bands>,
}

impl Sky {
    /// With the sun at a zenith angle in radians, and a ground of this albedo.
    pub(super) fn new(atmosphere: Atmosphere, zenith_angle: f64, albedo: f64) -> Sky {
        let sun = SunTable::new(zenith_angle);
        let mut sky = Sky { atmosphere, sun, zenith_angle, multiple: Vec::new() };
        let mut multiple = Vec::with_capacity(HEIGHTS * ANGLES);
        for row in 0..HEIGHTS {
            let height = row_height(row as f64, HEIGHTS);
            for column in 0..ANGLES {
                let angle =
                    zenith_angle - ZENITH_RANGE + 2.0 * ZENITH_RANGE * column as f64 / (ANGLES - 1) as f64;
                multiple.push(sky.multiple_scattering(height, angle, albedo));
            }
        }
        sky.multiple = multiple;
        sky
    }

    /// The fraction of sunlight that arrives at a point where the sun has this zenith angle.
    pub(super) fn sunlight(&self, height: f64, zenith_angle: f64) -> Bands {
        let visible = visible_sun(height, cos(zenith_angle));
        if visible == 0.0 {
            return [0.0; BANDS];
        }
        self.atmosphere.transmittance(&self.sun.amounts(height, zenith_angle)).map(|t| t * visible)
    }

    /// Radiances from directions of one zenith angle, whose cosine is `cos_view`; `cos_turns` are the cosines of their
    /// azimuths from the sun.
    pub(super) fn radiances<const N: usize>(
        &self,
        height: f64,
        cos_view: f64,
        cos_turns: &[f64; N],
    ) -> [Bands; N] {
        let (sin_sun, cos_sun) = sin_cos(self.zenith_angle);
        let sin_view = (1.0 - cos_view * cos_view).max(0.0).sqrt();
        let between = cos_turns.map(|turn| cos_view * cos_sun + sin_view * sin_sun * turn);
        let phases = between.map(|cos| (rayleigh(cos), cornette_shanks(cos)));
        let mut lights = [[0.0; BANDS]; N];
        march(height, cos_view, STEPS, |step| {
            let through = self.atmosphere.transmittance(&step.amounts);
            let (air, dust) = self.atmosphere.scattering(&step.here);
            for ((light, cos_between), (air_phase, dust_phase)) in lights.iter_mut().zip(between).zip(phases)
            {
                let angle = angle_of_sun(cos_sun, cos_between, height, step.distance, step.height);
                let sun = self.sunlight(step.height, angle);
                let multiple = self.multiple(step.height, angle);
                add(light, |i| {
                    let once = sun[i] * (air[i] * air_phase + dust[i] * dust_phase);
                    through[i] * step.length * (once + multiple[i] * (air[i] + dust[i]))
                });
            }
        });
        lights
    }

    /// L_ms at a point, ground included: L₂ / (1 − f).
    fn multiple_scattering(&self, height: f64, zenith_angle: f64, albedo: f64) -> Bands {
        const RINGS: u32 = 8;
        const AZIMUTHS: u32 = 8;
        let (sin_sun, cos_sun) = sin_cos(zenith_angle);
        let (mut second, mut again) = ([0.0; BANDS], [0.0; BANDS]);
        let fraction = 1.0 / f64::from(RINGS * AZIMUTHS);
        for ring in 0..RINGS {
            let cos_view = 1.0 - 2.0 * (f64::from(ring) + 0.5) / f64::from(RINGS);
            let sin_view = (1.0 - cos_view * cos_view).sqrt();
            for azimuth in 0..AZIMUTHS {
                let cos_turn = cos(TAU * (f64::from(azimuth) + 0.5) / f64::from(AZIMUTHS));
                let cos_between = cos_view * cos_sun + sin_view * sin_sun * cos_turn;
                let angle = |distance: f64, at: f64| angle_of_sun(cos_sun, cos_between, height, distance, at);
                let (end, ground) = march(height, cos_view, FEW_STEPS, |step| {
                    let through = self.atmosphere.transmittance(&step.amounts);
                    let (air, dust) = self.atmosphere.scattering(&step.here);
                    let sun = self.sunlight(step.height, angle(step.distance, step.height));
                    let scattered = |i: usize| fraction * through[i] * step.length * (air[i] + dust[i]);
                    add(&mut second, |i| scattered(i) * sun[i] / (4.0 * PI));
                    add(&mut again, scattered);
                });
                if let Some(distance) = ground {
                    let angle = angle(distance, 0.0);
                    let through = self.atmosphere.transmittance(&end);
                    let (sun, facing) = (self.sunlight(0.0, angle), cos(angle).max(0.0));
                    add(&mut second, |i| fraction * through[i] * albedo / PI * sun[i] * facing);
                }
            }
        }
        std::array::from_fn(|i| second[i] / (1.0 - again[i].min(0.99)))
    }

    /// Interpolates the table of [`Sky::multiple_scattering`].
    fn multiple(&self, height: f64, zenith_angle: f64) -> Bands {
        let split = |v: f64, n: usize| {
            let v = v.clamp(0.0, (n - 1) as f64);
            let i = (v as usize).min(n - 2);
            (i, v - i as f64)
        };
        let (row, down) = split(height_row(height, HEIGHTS), HEIGHTS);
        let column =
            (zenith_angle - self.zenith_angle + ZENITH_RANGE) / (2.0 * ZENITH_RANGE) * (ANGLES - 1) as f64;
        let (column, across) = split(column, ANGLES);
        let i = row * ANGLES + column;
        let corners = [i, i + 1, i + ANGLES, i + ANGLES + 1].map(|i| &self.multiple[i]);
        let weights =
            [(1.0 - down) * (1.0 - across), (1.0 - down) * across, down * (1.0 - across), down * across];
        std::array::from_fn(|band| corners.iter().zip(weights).map(|(c, w)| c[band] * w).sum())
    }
}

/// The zenith angle of the sun at a point of a ray, in radians. The ray begins at `height`, where the cosine of the sun's
/// zenith angle is `cos_sun`; `cos_between` is the cosine of the angle between the ray and the sun. The point is at
/// `distance` along the ray, at the height `at`. Lengths in km.
fn angle_of_sun(cos_sun: f64, cos_between: f64, height: f64, distance: f64, at: f64) -> f64 {
    acos(((GROUND + height) * cos_sun + distance * cos_between) / (GROUND + at))
}

/// A step along a ray.
struct March {
    /// Amounts from the origin to the centre of the step.
    amounts: Amounts,
    /// Amounts per kilometre at its centre.
    here: Amounts,
    /// Height of its centre, km.
    height: f64,
    /// Distance of its centre from the origin, km.
    distance: f64,
    /// Its length, km.
    length: f64,
}

/// Marches along a ray to the ground or out of the atmosphere. Returns the amounts along the complete ray and, if it
/// ends at the ground, the distance.
fn march(height: f64, cos_view: f64, steps: u32, mut step: impl FnMut(&March)) -> (Amounts, Option<f64>) {
    let (far, ground) = distance_to_boundary(height, cos_view);
    let mut before = Amounts::default();
    for i in 0..steps {
        let edge = |i: u32| {
            let fraction = f64::from(i) / f64::from(steps);
            far * fraction * fraction
        };
        let (from, to) = (edge(i), edge(i + 1));
        let center = 0.5 * (from + to);
        let (h, _) = along(height, cos_view, center);
        let here = Amounts::at(h);
        step(&March {
            amounts: before.plus(here, 0.5 * (to - from)),
            here,
            height: h,
            distance: center,
            length: to - from,
        });
        before = before.plus(here, to - from);
    }
    (before, ground.then_some(far))
}

/// Rayleigh phase function: as much forwards as backwards; its mean over the sphere is 1/4π.
fn rayleigh(cos: f64) -> f64 {
    3.0 / (16.0 * PI) * (1.0 + cos * cos)
}

/// Phase function of dust (Cornette & Shanks 1992, "Physically reasonable analytic expression for the
/// single-scattering phase function").
fn cornette_shanks(cos: f64) -> f64 {
    const G: f64 = DUST_ASYMMETRY;
    let d = 1.0 + G * G - 2.0 * G * cos;
    3.0 / (8.0 * PI) * (1.0 - G * G) * (1.0 + cos * cos) / ((2.0 + G * G) * d * d.sqrt())
}
