//! IES floodlights: converts photometry of types A and B to type C about the direction in which the floodlight is
//! aimed.
//!
//! Types A and B both give a horizontal and a vertical angle in degrees from the aim. Type A rotates about the
//! vertical axis first, type B about the horizontal axis first (IES LM-75):
//!
//! | type | direction for horizontal angle H and vertical angle V, in the frame aim, right, up |
//! |---|---|
//! | A | cos V · (cos H · aim + sin H · right) + sin V · up |
//! | B | cos H · (cos V · aim + sin V · up) + sin H · right |
//!
//! In type C the aim has the vertical angle 0; right has the horizontal angle 0 and up 90.

use std::f64::consts::PI;

use turner::math::elementary::{atan2, sin_cos};
use turner::math::radians;
use turner::schema::LightProfile;

/// Most vertical or horizontal angles of the resulting profile.
const MAX_STEPS: usize = 720;

/// The photometry type of a floodlight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Floodlight {
    A,
    B,
}

/// Measured intensities in candela: one row of vertical angles for each horizontal angle. Angles are in degrees and
/// increase within −90..=90. A range that starts at 0 is symmetric.
pub(crate) struct Measured {
    pub(crate) horizontal: Vec<f64>,
    pub(crate) vertical: Vec<f64>,
    pub(crate) candela: Vec<Vec<f32>>,
}

impl Floodlight {
    /// The angles H and V, in degrees, of a direction given in the frame aim, right, up.
    fn angles(self, [aim, right, up]: [f64; 3]) -> (f64, f64) {
        let over = |a: f64, b: f64| (a * a + b * b).sqrt();
        let (h, v) = match self {
            Floodlight::A => (atan2(right, aim), atan2(up, over(aim, right))),
            Floodlight::B => (atan2(right, over(aim, up)), atan2(up, aim)),
        };
        (h.to_degrees(), v.to_degrees())
    }

    /// Resamples to a profile of type C with about the angular resolution of the measurement.
    pub(crate) fn profile(self, measured: &Measured) -> Result<LightProfile, &'static str> {
        for angles in [&measured.horizontal, &measured.vertical] {
            let ends = angles.first().zip(angles.last());
            if !ends.is_some_and(|(a, b)| *a >= -90.0 && *b <= 90.0)
                || !angles.windows(2).all(|w| w[0] < w[1])
            {
                return Err("angles of types A and B must increase within -90 to 90");
            }
        }
        let span = |angles: &[f64]| angles.last().unwrap_or(&0.0) - angles.first().unwrap_or(&0.0);
        let step = |angles: &[f64]| span(angles) / angles.len().max(2) as f64;
        let finest = step(&measured.horizontal).min(step(&measured.vertical)).clamp(0.25, 2.0);
        let rows = ((180.0 / finest) as usize).clamp(90, MAX_STEPS);
        let columns = ((360.0 / finest) as usize).clamp(180, MAX_STEPS);
        let vertical: Vec<f64> = (0..=rows).map(|i| 180.0 * i as f64 / rows as f64).collect();
        let horizontal: Vec<f64> = (0..=columns).map(|i| 360.0 * i as f64 / columns as f64).collect();
        let mut candela = Vec::with_capacity((rows + 1) * (columns + 1));
        for around in &horizontal {
            let (up, right) = sin_cos(radians(*around));
            for from_aim in &vertical {
                let (s, c) = sin_cos(PI * from_aim / 180.0);
                let (h, v) = self.angles([c, s * right, s * up]);
                candela.push(measured.at(h, v));
            }
        }
        LightProfile::new(vertical, horizontal, candela)
    }
}

impl Measured {
    /// Interpolates bilinearly between measured angles; 0 beyond them.
    fn at(&self, h: f64, v: f64) -> f32 {
        let folded = |angles: &[f64], x: f64| if angles.first() == Some(&0.0) { x.abs() } else { x };
        let Some((column, across)) = between(&self.horizontal, folded(&self.horizontal, h)) else {
            return 0.0;
        };
        let Some((row, along)) = between(&self.vertical, folded(&self.vertical, v)) else { return 0.0 };
        let get = |column: usize, row: usize| {
            let plane = self.candela.get(column.min(self.candela.len() - 1));
            plane.and_then(|p| p.get(row.min(p.len().max(1) - 1))).copied().unwrap_or(0.0)
        };
        let near = get(column, row) + (get(column, row + 1) - get(column, row)) * along;
        let far = get(column + 1, row) + (get(column + 1, row + 1) - get(column + 1, row)) * along;
        near + (far - near) * across
    }
}

/// The index of the last angle not above x, and the interpolation weight of the next.
fn between(angles: &[f64], x: f64) -> Option<(usize, f32)> {
    const ROUNDING: f64 = 1e-9;
    let (first, last) = (*angles.first()?, *angles.last()?);
    // A single angle: the intensity does not depend on it.
    if angles.len() == 1 {
        return Some((0, 0.0));
    }
    if !(first - ROUNDING..=last + ROUNDING).contains(&x) {
        return None;
    }
    let next = angles.partition_point(|a| *a <= x).clamp(1, angles.len() - 1);
    let (a, b) = (angles.get(next - 1)?, angles.get(next)?);
    Some((next - 1, ((x - a) / (b - a)).clamp(0.0, 1.0) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Intensities that grow linearly with the horizontal or the vertical angle.
    fn grows(sideways: bool) -> Measured {
        let angles: Vec<f64> = (-18..=18).map(|i| 5.0 * f64::from(i)).collect();
        let plane = |h: f64| angles.iter().map(|v| (100.0 + if sideways { h } else { *v }) as f32).collect();
        Measured {
            candela: angles.iter().map(|h| plane(*h)).collect(),
            horizontal: angles.clone(),
            vertical: angles.clone(),
        }
    }

    #[test]
    fn angles_are_turned_as_the_type_says() {
        for (kind, sideways, along_right, along_up) in [
            (Floodlight::A, true, 130.0, 100.0),
            (Floodlight::A, false, 100.0, 130.0),
            (Floodlight::B, true, 130.0, 100.0),
            (Floodlight::B, false, 100.0, 130.0),
        ] {
            let profile = kind.profile(&grows(sideways)).unwrap();
            assert!((profile.candela(0.0, 0.0) - 100.0).abs() < 0.1, "the aim");
            assert!((profile.candela(30.0, 0.0) - along_right).abs() < 0.2, "{kind:?}: to the right");
            assert!((profile.candela(30.0, 90.0) - along_up).abs() < 0.2, "{kind:?}: upwards");
            assert_eq!(profile.candela(120.0, 0.0), 0.0, "behind it is dark");
        }
        // Off both axes the types differ: A measures the horizontal angle in the horizontal plane, B from
        // that of the aim and up.
        let at = |kind: Floodlight| kind.profile(&grows(true)).unwrap().candela(60.0, 45.0);
        let (s, c) = sin_cos(radians(60.0));
        let side = s * 0.5_f64.sqrt();
        let a = atan2(side, c).to_degrees();
        let b = atan2(side, (c * c + side * side).sqrt()).to_degrees();
        assert!((f64::from(at(Floodlight::A)) - 100.0 - a).abs() < 0.3);
        assert!((f64::from(at(Floodlight::B)) - 100.0 - b).abs() < 0.3);
    }

    #[test]
    fn angles_from_0_on_are_the_same_on_the_other_side() {
        let half = Measured {
            horizontal: vec![0.0, 45.0, 90.0],
            vertical: vec![-90.0, 0.0, 90.0],
            candela: vec![vec![0.0, 4.0, 0.0], vec![0.0, 2.0, 0.0], vec![0.0; 3]],
        };
        let profile = Floodlight::B.profile(&half).unwrap();
        assert!(
            (profile.candela(45.0, 0.0) - 2.0).abs() < 0.05
                && (profile.candela(45.0, 180.0) - 2.0).abs() < 0.05
        );
        let wrong = Measured { horizontal: vec![0.0, 120.0], ..half };
        assert!(Floodlight::A.profile(&wrong).is_err());
    }
}
