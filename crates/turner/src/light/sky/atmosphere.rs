//! The atmosphere of a spherical earth: the amount of each constituent along a ray, and the transmittance.
//!
//! Lengths are in kilometres. Points are given by their height, and directions by the cosine of their angle from the
//! local zenith.

use super::spectrum::{BANDS, Bands, Depths};
use crate::math::elementary::exp;

/// Radius of the earth, and of the top of the atmosphere, km.
pub(super) const GROUND: f64 = 6360.0;
pub(super) const TOP: f64 = 6460.0;

/// Scale heights: the density of air and dust falls by a factor e over these heights, km.
const AIR_HEIGHT: f64 = 8.0;
const DUST_HEIGHT: f64 = 1.2;
/// Ozone is a layer with a triangular profile: its centre, and its half width, km.
const OZONE_CENTER: f64 = 25.0;
const OZONE_HALF_WIDTH: f64 = 15.0;

/// Single-scattering albedo of dust.
const DUST_ALBEDO: f64 = 0.95;

/// Angular radius of the sun, radians.
const SUN_RADIUS: f64 = 0.00465;

/// Amounts of air, dust and ozone as fractions of the vertical column: per kilometre, or summed along a ray.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Amounts {
    pub(super) air: f64,
    pub(super) dust: f64,
    pub(super) ozone: f64,
}

impl Amounts {
    /// Per kilometre at a height.
    pub(super) fn at(height: f64) -> Amounts {
        // Below the ground the same as at the ground.
        let h = height.max(0.0);
        Amounts {
            air: exp(-h / AIR_HEIGHT) / AIR_HEIGHT,
            dust: exp(-h / DUST_HEIGHT) / DUST_HEIGHT,
            ozone: (1.0 - (h - OZONE_CENTER).abs() / OZONE_HALF_WIDTH).max(0.0) / OZONE_HALF_WIDTH,
        }
    }

    /// Adds `times` the other amounts.
    pub(super) fn plus(self, other: Amounts, times: f64) -> Amounts {
        Amounts {
            air: self.air + times * other.air,
            dust: self.dust + times * other.dust,
            ozone: self.ozone + times * other.ozone,
        }
    }

    /// Linear interpolation.
    pub(super) fn lerp(self, other: Amounts, t: f64) -> Amounts {
        Amounts::default().plus(self, 1.0 - t).plus(other, t)
    }
}

/// The composition of the atmosphere.
#[derive(Clone, Copy, Debug)]
pub(super) struct Atmosphere {
    pub(super) depths: Depths,
}

impl Atmosphere {
    /// Transmittance through these amounts.
    pub(super) fn transmittance(&self, amounts: &Amounts) -> Bands {
        let d = &self.depths;
        std::array::from_fn(|i| {
            exp(-(d.air[i] * amounts.air + d.dust[i] * amounts.dust + d.ozone[i] * amounts.ozone))
        })
    }

    /// Scattering coefficients per kilometre of air and of dust.
    pub(super) fn scattering(&self, here: &Amounts) -> (Bands, Bands) {
        (
            std::array::from_fn(|i| self.depths.air[i] * here.air),
            std::array::from_fn(|i| self.depths.dust[i] * here.dust * DUST_ALBEDO),
        )
    }
}

/// The distance from a height along a direction to a sphere of `radius` around the earth's centre: the farther hit if
/// the point is inside.
fn to_sphere(height: f64, cos: f64, radius: f64) -> Option<f64> {
    let r = GROUND + height;
    // (radius − r)(radius + r) avoids the cancellation of the difference of squares.
    let inside = (radius - r) * (radius + r) + r * r * cos * cos;
    (inside >= 0.0).then(|| {
        let root = inside.sqrt();
        if radius > r { root - r * cos } else { -r * cos - root }
    })
}

/// The distance to the ground or to the top of the atmosphere, and whether it is the ground.
pub(super) fn distance_to_boundary(height: f64, cos: f64) -> (f64, bool) {
    match to_sphere(height, cos, GROUND) {
        Some(t) if t > 0.0 && cos < 0.0 => (t, true),
        _ => (to_sphere(height, cos, TOP).unwrap_or(0.0).max(0.0), false),
    }
}

/// The height after a distance `t` along a ray, and the cosine of the ray's angle from the zenith there.
pub(super) fn along(height: f64, cos: f64, t: f64) -> (f64, f64) {
    let r = GROUND + height;
    // r² + 2rt·cos + t² = (r + h')², with h' small compared to r: solved for h' without cancellation.
    let d = t * (2.0 * r * cos + t);
    let new = (r * r + d).max(0.0).sqrt();
    let rise = d / (new + r);
    (height + rise, (r * cos + t) / new)
}

/// The amounts between a point and the top of the atmosphere.
pub(super) fn amounts_above(height: f64, cos: f64) -> Amounts {
    const STEPS: u32 = 64;
    let far = to_sphere(height, cos, TOP).unwrap_or(0.0).max(0.0);
    let mut sum = Amounts::default();
    for i in 0..STEPS {
        // Steps are shorter at the near end, where the air is dense. Below the horizon the densest part is in the
        // centre of the ray; few rays need that.
        let edge = |i: u32| far * (f64::from(i) / f64::from(STEPS)) * (f64::from(i) / f64::from(STEPS));
        let (from, to) = (edge(i), edge(i + 1));
        let (h, _) = along(height, cos, 0.5 * (from + to));
        sum = sum.plus(Amounts::at(h), to - from);
    }
    sum
}

/// Fraction of the sun's disc above the horizon, as seen from a height, for the cosine of its centre's zenith angle.
pub(super) fn visible_sun(height: f64, cos: f64) -> f64 {
    let r = GROUND + height.max(0.0);
    // The horizon dips with height.
    let sin_horizon = GROUND / r;
    let cos_horizon = -(1.0 - sin_horizon * sin_horizon).max(0.0).sqrt();
    // Near the horizon differences of cosines are differences of angles.
    let above = ((cos - cos_horizon) / SUN_RADIUS).clamp(-1.0, 1.0);
    0.5 + above * (0.75 - 0.25 * above * above)
}

/// Amounts between the sun and points of the atmosphere, by height and zenith angle of the sun.
pub(super) struct SunTable {
    /// Zenith angle of the first column, and step between columns, radians.
    first: f64,
    step: f64,
    amounts: Vec<Amounts>,
}

/// Heights are spaced quadratically, so that most lie in the dense air.
const HEIGHTS: usize = 64;
const ANGLES: usize = 64;
/// Along one ray through the atmosphere the local zenith turns by less than this: 10.2 degrees, from the horizon to
/// the top.
const ZENITH_RANGE: f64 = 0.2;

/// The height of a row of `rows`.
pub(super) fn row_height(row: f64, rows: usize) -> f64 {
    let fraction = row / (rows - 1) as f64;
    (TOP - GROUND) * fraction * fraction
}

/// The row of a height.
pub(super) fn height_row(height: f64, rows: usize) -> f64 {
    (height.clamp(0.0, TOP - GROUND) / (TOP - GROUND)).sqrt() * (rows - 1) as f64
}

impl SunTable {
    /// Around `zenith_angle`, the sun's zenith angle at the observer, radians.
    pub(super) fn new(zenith_angle: f64) -> SunTable {
        let first = zenith_angle - ZENITH_RANGE;
        let step = 2.0 * ZENITH_RANGE / (ANGLES - 1) as f64;
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

    /// The amounts between a point and the sun.
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

/// Adds to each wavelength.
pub(super) fn add(sum: &mut Bands, term: impl Fn(usize) -> f64) {
    for (i, v) in sum.iter_mut().enumerate().take(BANDS) {
        *v += term(i);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::elementary::cos;

    #[test]
    fn the_vertical_column_is_one() {
        let up = amounts_above(0.0, 1.0);
        assert!((up.air - 1.0).abs() < 2e-3 && (up.dust - 1.0).abs() < 5e-3, "{up:?}");
        assert!((up.ozone - 1.0).abs() < 5e-3, "{up:?}");
        // The air mass at the horizon for this scale height: √(πR/2H), about 35 (Kasten & Young 1989: 38 for the real
        // atmosphere).
        let low = amounts_above(0.0, 0.0);
        let expected = (std::f64::consts::PI * GROUND / (2.0 * AIR_HEIGHT)).sqrt();
        assert!((low.air / expected - 1.0).abs() < 0.01, "{} {expected}", low.air);
        // Nearly twice the vertical column at 60 degrees from the zenith.
        assert!((amounts_above(0.0, 0.5).air - 1.993).abs() < 0.01);
        assert!(amounts_above(100.0, 0.3).air < 1e-4);
    }

    #[test]
    fn rays_end_at_the_top_or_at_the_ground() {
        assert_eq!(distance_to_boundary(0.0, 1.0), (100.0, false));
        assert_eq!(distance_to_boundary(2.0, -1.0), (2.0, true));
        let (t, ground) = distance_to_boundary(0.0, 0.0);
        assert!((t - (TOP * TOP - GROUND * GROUND).sqrt()).abs() < 1e-9 && !ground);
        let (height, c) = along(0.0, 0.0, t);
        assert!((height - 100.0).abs() < 1e-9 && (c - t / TOP).abs() < 1e-12);
        // Two metres above the ground, 1e-6 radians off: nothing is lost to rounding.
        let (h, _) = along(0.002, 1e-6, 1.0);
        assert!((h - (0.002 + 1e-6 + 0.5 / GROUND)).abs() < 1e-10, "{h}");
    }

    #[test]
    fn the_sun_sets_where_the_horizon_is() {
        assert_eq!((visible_sun(0.0, 1.0), visible_sun(0.0, -0.01), visible_sun(0.0, 0.0)), (1.0, 0.0, 0.5));
        // From 10 km the horizon dips by 3.2 degrees.
        assert!(visible_sun(10.0, -0.05) > 0.99 && visible_sun(10.0, -0.062) < 0.01);
    }

    #[test]
    fn the_table_agrees_with_direct_integration() {
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
