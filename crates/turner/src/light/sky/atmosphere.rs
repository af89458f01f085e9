//! The air around a spherical earth: how much of each of its parts lies along a ray, and how much light it takes.
//!
//! Lengths are in kilometres. Points are given by their height and directions by the cosine of their angle from the local zenith.

use super::spectrum::{BANDS, Bands, Depths};
use crate::math::elementary::exp;

/// Of the earth, and of the air around it.
pub(super) const GROUND: f64 = 6360.0;
pub(super) const TOP: f64 = 6460.0;

/// Air and dust become thinner by e over these heights.
const AIR_HEIGHT: f64 = 8.0;
const DUST_HEIGHT: f64 = 1.2;
/// Ozone is a layer: densest at this height, none so far above and below.
const OZONE_MIDDLE: f64 = 25.0;
const OZONE_HALF: f64 = 15.0;

/// Of what dust takes from a ray, the part that it scatters.
const DUST_ALBEDO: f64 = 0.95;

/// Half the angle of the sun's disc, radians.
const SUN_RADIUS: f64 = 0.00465;

/// How much air, dust and ozone there is, as shares of the whole column straight up: per kilometre, or along a way.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Amounts {
    pub(super) air: f64,
    pub(super) dust: f64,
    pub(super) ozone: f64,
}

impl Amounts {
    /// Per kilometre at a height.
    pub(super) fn at(height: f64) -> Amounts {
        // Below the ground as at the ground.
        let h = height.max(0.0);
        Amounts {
            air: exp(-h / AIR_HEIGHT) / AIR_HEIGHT,
            dust: exp(-h / DUST_HEIGHT) / DUST_HEIGHT,
            ozone: (1.0 - (h - OZONE_MIDDLE).abs() / OZONE_HALF).max(0.0) / OZONE_HALF,
        }
    }

    /// These and more.
    pub(super) fn plus(self, extra_candidates: Amounts, times: f64) -> Amounts {
        Amounts {
            air: self.air + times * extra_candidates.air,
            dust: self.dust + times * extra_candidates.dust,
            ozone: self.ozone + times * extra_candidates.ozone,
        }
    }

    /// A mixture with others.
    pub(super) fn lerp(self, other: Amounts, t: f64) -> Amounts {
        Amounts::default().plus(self, 1.0 - t).plus(other, t)
    }
}

/// What the air is made of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Atmosphere {
    pub(super) depths: Depths,
}

impl Atmosphere {
    /// The share of light that gets through.
    pub(super) fn transmittance(&self, amounts: &Amounts) -> Bands {
        let d = &self.depths;
        std::array::from_fn(|i| {
            exp(-(d.air[i] * amounts.air + d.dust[i] * amounts.dust + d.ozone[i] * amounts.ozone))
        })
    }

    /// Light scattered per kilometre: by air, and by dust.
    pub(super) fn scattering(&self, here: &Amounts) -> (Bands, Bands) {
        (
            std::array::from_fn(|i| self.depths.air[i] * here.air),
            std::array::from_fn(|i| self.depths.dust[i] * here.dust * DUST_ALBEDO),
        )
    }
}

/// The distance from a height, in a direction, to the sphere of a radius around the earth's middle: the farther meeting for a point inside.
fn to_sphere(height: f64, cos: f64, radius: f64) -> Option<f64> {
    let r = GROUND + height;
    // (radius − r)(radius + r) keeps what the difference of squares loses.
    let inside = (radius - r) * (radius + r) + r * r * cos * cos;
    (inside >= 0.0).then(|| {
        let root = inside.sqrt();
        if radius > r { root - r * cos } else { -r * cos - root }
    })
}

/// The way to the top of the air, or to the ground if it is in the way, which the second number says.
pub(super) fn way(height: f64, cos: f64) -> (f64, bool) {
    match to_sphere(height, cos, GROUND) {
        Some(t) if t > 0.0 && cos < 0.0 => (t, true),
        _ => (to_sphere(height, cos, TOP).unwrap_or(0.0).max(0.0), false),
    }
}

/// The height reached after a way, and the cosine from the zenith that the same direction has there.
pub(super) fn along(height: f64, cos: f64, t: f64) -> (f64, f64) {
    let r = GROUND + height;
    // r² + 2rt·cos + t² = (r + h')², h' small beside r: solved for h' without losing it.
    let d = t * (2.0 * r * cos + t);
    let new = (r * r + d).max(0.0).sqrt();
    let rise = d / (new + r);
    (height + rise, (r * cos + t) / new)
}

/// What lies between a point and the top of the air.
pub(super) fn amounts_above(height: f64, cos: f64) -> Amounts {
    const STEPS: u32 = 64;
    let far = to_sphere(height, cos, TOP).unwrap_or(0.0).max(0.0);
    let mut sum = Amounts::default();
    for i in 0..STEPS {
        // Denser where the air is dense: at the near end; below the horizon in the middle, which few need.
        let edge = |i: u32| far * (f64::from(i) / f64::from(STEPS)) * (f64::from(i) / f64::from(STEPS));
        let (from, to) = (edge(i), edge(i + 1));
        let (h, _) = along(height, cos, 0.5 * (from + to));
        sum = sum.plus(Amounts::at(h), to - from);
    }
    sum
}

/// The share of the sun's disc above the horizon that a point sees, its middle in a direction.
pub(super) fn visible(height: f64, cos: f64) -> f64 {
    let r = GROUND + height.max(0.0);
    // The horizon lies lower the higher one is.
    let sin_horizon = GROUND / r;
    let cos_horizon = -(1.0 - sin_horizon * sin_horizon).max(0.0).sqrt();
    // Near the horizon differences of cosines are those of angles.
    let above = ((cos - cos_horizon) / SUN_RADIUS).clamp(-1.0, 1.0);
    0.5 + above * (0.75 - 0.25 * above * above)
}

/// Sunlight at every height and angle that the sky needs, tabulated.
pub(super) struct SunTable {
    /// Degrees would do; radians from the zenith of the first column, and between columns.
    first: f64,
    step: f64,
    amounts: Vec<Amounts>,
}

/// Heights go with the square, so that the dense air has most of them.
const HEIGHTS: usize = 64;
const ANGLES: usize = 64;
/// Along one ray through the air the zenith turns by less than this: 10.2 degrees, to the top and from the horizon.
const TURN: f64 = 0.2;

/// The height of a row of `rows`.
pub(super) fn row_height(row: f64, rows: usize) -> f64 {
    let share = row / (rows - 1) as f64;
    (TOP - GROUND) * share * share
}

/// The row of a height.
pub(super) fn height_row(height: f64, rows: usize) -> f64 {
    (height.clamp(0.0, TOP - GROUND) / (TOP - GROUND)).sqrt() * (rows - 1) as f64
}

impl SunTable {
    /// Around `zenith_angle`, the sun's angle from the zenith at the observer, radians.
    pub(super) fn new(zenith_angle: f64) -> SunTable {
        let first = zenith_angle - TURN;
        let step = 2.0 * TURN / (ANGLES - 1) as f64;
        let mut amounts = Vec::with_capacity(HEIGHTS * ANGLES);
        for row in 0..HEIGHTS {
            let height = row_height(row as f64, HEIGHTS);
            for column in 0..ANGLES {
                let cos = crate::math::elementary::cos(first + step * column as f64);
                amounts.push(amounts_above(height, cos));
            }
        }
        SunTable { first, step, amounts }
    }

    /// What lies between a point and the sun.
    pub(super) fn amounts(&self, height: f64, zenith_angle: f64) -> Amounts {
        let split = |v: f64, n: usize| {
            let v = v.clamp(0.0, (n - 1) as f64);
            let i = (v as usize).min(n - 2);
            (i, v - i as f64)
        };
        let (row, down) = split(height_row(height, HEIGHTS), HEIGHTS);
        let (column, across) = split((zenith_angle - self.first) / self.step, ANGLES);
        let at = |row: usize| {
            let i = row * ANGLES + column;
            self.amounts[i].lerp(self.amounts[i + 1], across)
        };
        at(row).lerp(at(row + 1), down)
    }
}

/// A sum over bands.
pub(super) fn add(sum: &mut Bands, extra_candidates: impl Fn(usize) -> f64) {
    for (i, v) in sum.iter_mut().enumerate().take(BANDS) {
        *v += extra_candidates(i);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::elementary::cos;

    #[test]
    fn straight_up_there_is_all_of_it_once() {
        let up = amounts_above(0.0, 1.0);
        assert!((up.air - 1.0).abs() < 2e-3 && (up.dust - 1.0).abs() < 5e-3, "{up:?}");
        assert!((up.ozone - 1.0).abs() < 5e-3, "{up:?}");
        // The air mass at the horizon of an air of this height: √(πR/2H), about 35 (Kasten & Young 1989: 38 for the true one).
        let low = amounts_above(0.0, 0.0);
        let expected = (std::f64::consts::PI * GROUND / (2.0 * AIR_HEIGHT)).sqrt();
        assert!((low.air / expected - 1.0).abs() < 0.01, "{} {expected}", low.air);
        // At 60 degrees from the zenith nearly twice as much.
        assert!((amounts_above(0.0, 0.5).air - 1.993).abs() < 0.01);
        assert!(amounts_above(100.0, 0.3).air < 1e-4);
    }

    #[test]
    fn ways_end_at_the_top_or_at_the_ground() {
        assert_eq!(way(0.0, 1.0), (100.0, false));
        assert_eq!(way(2.0, -1.0), (2.0, true));
        let (t, ground) = way(0.0, 0.0);
        assert!((t - (TOP * TOP - GROUND * GROUND).sqrt()).abs() < 1e-9 && !ground);
        let (height, c) = along(0.0, 0.0, t);
        assert!((height - 100.0).abs() < 1e-9 && (c - t / TOP).abs() < 1e-12);
        // Two metres above the ground, 1e-6 radians off: nothing is lost to rounding.
        let (h, _) = along(0.002, 1e-6, 1.0);
        assert!((h - (0.002 + 1e-6 + 0.5 / GROUND)).abs() < 1e-10, "{h}");
    }

    #[test]
    fn the_sun_sets_where_the_horizon_is() {
        assert_eq!((visible(0.0, 1.0), visible(0.0, -0.01), visible(0.0, 0.0)), (1.0, 0.0, 0.5));
        // From 10 km the horizon lies 3.2 degrees lower.
        assert!(visible(10.0, -0.05) > 0.99 && visible(10.0, -0.062) < 0.01);
    }

    #[test]
    fn the_table_is_what_it_was_made_from() {
        for zenith_angle in [0.0, 0.7, 1.4] {
            let table = SunTable::new(zenith_angle);
            for (height, off) in [(0.0, 0.0), (0.3, 0.011), (2.7, -0.1), (31.0, 0.05)] {
                let angle: f64 = zenith_angle + off;
                let (found, exact) = (table.amounts(height, angle), amounts_above(height, cos(angle)));
                assert!((found.air / exact.air - 1.0).abs() < 0.01, "{zenith_angle} {height}");
                assert!(
                    (found.dust - exact.dust).abs() < 0.03 * (0.1 + exact.dust),
                    "{zenith_angle} {height}"
                );
            }
        }
    }
}
