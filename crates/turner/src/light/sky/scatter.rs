//! Light that the air scatters: once, by the phase functions of molecules and dust; more often, as if alike in all directions
//! (Hillaire 2020, "A scalable and production ready sky and atmosphere rendering technique", section 5.5).

use std::f64::consts::{PI, TAU};

use super::atmosphere::{
    Amounts, Atmosphere, GROUND, SunTable, add, along, height_row, row_height, visible, way,
};
use super::spectrum::{BANDS, Bands};
use crate::math::elementary::{acos, cos, sin_cos};

/// Steps along a ray of the picture, and along those that gather light for further scattering.
const STEPS: u32 = 40;
const FEW_STEPS: u32 = 16;

/// The table of light scattered more than once: heights, and angles of the sun.
const HEIGHTS: usize = 12;
const ANGLES: usize = 7;
const TURN: f64 = 0.2;

/// The asymmetry of dust: how much of its light goes on forwards.
const DUST_FORWARD: f64 = 0.76;

/// Air with the sun in it; radiances are shares of what the sun brings, per steradian.
pub(super) struct Sky {
    atmosphere: Atmosphere,
    sun: SunTable,
    /// Angle of the sun from the zenith at the observer.
    zenith_angle: f64,
    /// Radiance that arrives from all sides by more than one scattering, by height and sun.
    multiple: Vec<Bands>,
}

impl Sky {
    /// With the sun at an angle from the zenith, and a ground that returns the share `albedo`.
    pub(super) fn new(atmosphere: Atmosphere, zenith_angle: f64, albedo: f64) -> Sky {
        let sun = SunTable::new(zenith_angle);
        let mut sky = Sky { atmosphere, sun, zenith_angle, multiple: Vec::new() };
        let mut multiple = Vec::with_capacity(HEIGHTS * ANGLES);
        for row in 0..HEIGHTS {
            let height = row_height(row as f64, HEIGHTS);
            for column in 0..ANGLES {
                let angle = zenith_angle - TURN + 2.0 * TURN * column as f64 / (ANGLES - 1) as f64;
                multiple.push(sky.gathered(height, angle, albedo));
            }
        }
        sky.multiple = multiple;
        sky
    }

    /// The share of the sun's light that arrives at a point where the sun stands at an angle from the zenith.
    pub(super) fn sunlight(&self, height: f64, zenith_angle: f64) -> Bands {
        let seen = visible(height, cos(zenith_angle));
        if seen == 0.0 {
            return [0.0; BANDS];
        }
        self.atmosphere.transmittance(&self.sun.amounts(height, zenith_angle)).map(|t| t * seen)
    }

    /// Radiance from a direction at the angle of cosine `cos_view` from the zenith, turned by the cosine `cos_turn` from the sun
    /// around it.
    pub(super) fn radiance(&self, height: f64, cos_view: f64, cos_turn: f64) -> Bands {
        let (sin_sun, cos_sun) = sin_cos(self.zenith_angle);
        let sin_view = (1.0 - cos_view * cos_view).max(0.0).sqrt();
        let cos_between = cos_view * cos_sun + sin_view * sin_sun * cos_turn;
        let (air_phase, dust_phase) = (rayleigh(cos_between), cornette_shanks(cos_between));
        let mut light = [0.0; BANDS];
        march(
            self.zenith_angle,
            height,
            cos_view,
            cos_between,
            STEPS,
            |amounts, here, height, angle, length| {
                let through = self.atmosphere.transmittance(amounts);
                let (air, dust) = self.atmosphere.scattering(here);
                let sun = self.sunlight(height, angle);
                let around = self.multiple(height, angle);
                add(&mut light, |i| {
                    let once = sun[i] * (air[i] * air_phase + dust[i] * dust_phase);
                    through[i] * length * (once + around[i] * (air[i] + dust[i]))
                });
            },
        );
        light
    }

    /// Radiance that arrives at a point from all sides by two scatterings or more, the ground's included: that of two, and the
    /// geometric series of those that follow.
    fn gathered(&self, height: f64, zenith_angle: f64, albedo: f64) -> Bands {
        const RINGS: u32 = 8;
        const AROUND: u32 = 8;
        let (sin_sun, cos_sun) = sin_cos(zenith_angle);
        let (mut second, mut again) = ([0.0; BANDS], [0.0; BANDS]);
        let share = 1.0 / f64::from(RINGS * AROUND);
        for ring in 0..RINGS {
            let cos_view = 1.0 - 2.0 * (f64::from(ring) + 0.5) / f64::from(RINGS);
            let sin_view = (1.0 - cos_view * cos_view).sqrt();
            for turn in 0..AROUND {
                let cos_turn = cos(TAU * (f64::from(turn) + 0.5) / f64::from(AROUND));
                let cos_between = cos_view * cos_sun + sin_view * sin_sun * cos_turn;
                let (end, ground) = march(
                    zenith_angle,
                    height,
                    cos_view,
                    cos_between,
                    FEW_STEPS,
                    |amounts, here, height, angle, length| {
                        let through = self.atmosphere.transmittance(amounts);
                        let (air, dust) = self.atmosphere.scattering(here);
                        let sun = self.sunlight(height, angle);
                        let scattered = |i: usize| share * through[i] * length * (air[i] + dust[i]);
                        add(&mut second, |i| scattered(i) * sun[i] / (4.0 * PI));
                        add(&mut again, scattered);
                    },
                );
                if let Some(angle) = ground {
                    let through = self.atmosphere.transmittance(&end);
                    let (sun, facing) = (self.sunlight(0.0, angle), cos(angle).max(0.0));
                    add(&mut second, |i| share * through[i] * albedo / PI * sun[i] * facing);
                }
            }
        }
        std::array::from_fn(|i| second[i] / (1.0 - again[i].min(0.99)))
    }

    /// From the table of [`Sky::gathered`].
    fn multiple(&self, height: f64, zenith_angle: f64) -> Bands {
        let split = |v: f64, n: usize| {
            let v = v.clamp(0.0, (n - 1) as f64);
            let i = (v as usize).min(n - 2);
            (i, v - i as f64)
        };
        let (row, down) = split(height_row(height, HEIGHTS), HEIGHTS);
        let column = (zenith_angle - self.zenith_angle + TURN) / (2.0 * TURN) * (ANGLES - 1) as f64;
        let (column, across) = split(column, ANGLES);
        let i = row * ANGLES + column;
        let corners = [i, i + 1, i + ANGLES, i + ANGLES + 1].map(|i| &self.multiple[i]);
        let weights =
            [(1.0 - down) * (1.0 - across), (1.0 - down) * across, down * (1.0 - across), down * across];
        std::array::from_fn(|band| corners.iter().zip(weights).map(|(c, w)| c[band] * w).sum())
    }
}

/// Walks along a ray to the ground or out of the air, the sun at an angle from the zenith where it begins. Each step is told what lies
/// before its middle, what is there per kilometre, its height, the sun's angle from the zenith there, and its length in kilometres.
/// Returns what lies along the whole ray, and, if it ends at the ground, the sun's angle there.
fn march(
    zenith_angle: f64,
    height: f64,
    cos_view: f64,
    cos_between: f64,
    steps: u32,
    mut step: impl FnMut(&Amounts, &Amounts, f64, f64, f64),
) -> (Amounts, Option<f64>) {
    let (far, ground) = way(height, cos_view);
    let cos_sun = cos(zenith_angle);
    // The sun's direction dotted with the local zenith.
    let sun_at = |t: f64, h: f64| acos(((GROUND + height) * cos_sun + t * cos_between) / (GROUND + h));
    let mut before = Amounts::default();
    for i in 0..steps {
        let edge = |i: u32| {
            let share = f64::from(i) / f64::from(steps);
            far * share * share
        };
        let (from, to) = (edge(i), edge(i + 1));
        let middle = 0.5 * (from + to);
        let (h, _) = along(height, cos_view, middle);
        let here = Amounts::at(h);
        step(&before.plus(here, 0.5 * (to - from)), &here, h, sun_at(middle, h), to - from);
        before = before.plus(here, to - from);
    }
    (before, ground.then(|| sun_at(far, 0.0)))
}

/// Molecules scatter forwards and backwards alike; its mean over the sphere is 1/4π.
fn rayleigh(cos: f64) -> f64 {
    3.0 / (16.0 * PI) * (1.0 + cos * cos)
}

/// Dust (Cornette & Shanks 1992, "Physically reasonable analytic expression for the single-scattering phase function").
fn cornette_shanks(cos: f64) -> f64 {
    const G: f64 = DUST_FORWARD;
    let d = 1.0 + G * G - 2.0 * G * cos;
    3.0 / (8.0 * PI) * (1.0 - G * G) * (1.0 + cos * cos) / ((2.0 + G * G) * d * d.sqrt())
}
