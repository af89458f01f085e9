//! The aperture of a lens: a circle, or a regular polygon formed by blades.

use std::f64::consts::TAU;

use crate::math::elementary::{angle, sin_cos_turns};
use crate::math::{DVec2, radians};
use crate::sampler::concentric_disk;
use crate::schema::{ErrorCode, SceneError};

/// An aperture of radius 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Aperture {
    Circle,
    /// A regular polygon.
    Polygon {
        /// Number of edges, one per blade.
        edges: f64,
        /// Direction of the first corner, in turns counter-clockwise from the right.
        first: f64,
    },
}

impl Aperture {
    /// From a number of blades, 0 for a circle. The first corner is at the top, rotated counter-clockwise by
    /// `rotation` degrees.
    pub(super) fn new(blades: u32, rotation: f64) -> Result<Aperture, SceneError> {
        match blades {
            0 => Ok(Aperture::Circle),
            1 | 2 => {
                let message = format!("a lens has 0 blades (a round aperture) or at least 3, not {blades}");
                Err(SceneError::new(ErrorCode::OutOfRange, message))
            }
            _ => {
                // Full turns change nothing; the remainder is a moderate number.
                let first = (0.25 + radians(rotation % 360.0) / TAU).rem_euclid(1.0);
                Ok(Aperture::Polygon { edges: f64::from(blades), first })
            }
        }
    }

    /// Maps the unit square to the aperture, preserving area.
    #[inline]
    pub(super) fn point(&self, u: DVec2) -> DVec2 {
        let &Aperture::Polygon { edges, first } = self else { return concentric_disk(u) };
        // Choose the triangle between the centre and one edge, then a point in it: its width grows with the distance.
        let edge = (u.x * edges).floor().min(edges - 1.0);
        let along = (u.x * edges - edge).clamp(0.0, 1.0);
        let corner = |i: f64| {
            let (s, c) = sin_cos_turns(first + i / edges);
            DVec2::new(c, s)
        };
        u.y.max(0.0).sqrt() * corner(edge).lerp(corner(edge + 1.0), along)
    }
}

impl Aperture {
    /// Whether a point of the circle of radius 1 is open.
    #[inline]
    pub(super) fn contains(&self, p: DVec2) -> bool {
        let &Aperture::Polygon { edges, first } = self else { return true };
        // From the middle of the nearest edge, in turns.
        let place = (angle(p.y, p.x) / TAU - first) * edges;
        let (_, cos) = sin_cos_turns((place - place.floor() - 0.5) / edges);
        let (_, inner) = sin_cos_turns(0.5 / edges);
        p.length() * cos <= inner
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::elementary::{cos, sin};

    fn points(aperture: &Aperture) -> impl Iterator<Item = DVec2> + '_ {
        let n = 300;
        let at = move |i: u32| (f64::from(i) + 0.5) / f64::from(n);
        (0..n * n).map(move |i| aperture.point(DVec2::new(at(i % n), at(i / n))))
    }

    #[test]
    fn areas_are_kept() {
        for blades in [3, 4, 5, 6, 9, 64] {
            for rotation in [0.0, 17.0, -1e6] {
                let aperture = Aperture::new(blades, rotation).unwrap();
                let n = f64::from(blades);
                // The distance of an edge from the centre, and the polygon's area.
                let inner = cos(std::f64::consts::PI / n);
                let area = 0.5 * n * sin(TAU / n);
                let (mut count, mut near, mut moment) = (0.0, 0.0, 0.0);
                let mut sum = DVec2::ZERO;
                for p in points(&aperture) {
                    assert!(p.length() <= 1.0 + 1e-12);
                    count += 1.0;
                    near += f64::from(u8::from(p.length() < 0.7 * inner));
                    moment += p.length_squared();
                    sum += p;
                }
                let disk = std::f64::consts::PI * 0.49 * inner * inner;
                assert!((near / count - disk / area).abs() < 4e-3, "{blades}: {}", near / count);
                // The polar moment of area over the area: (1 + 2 cos²(π/n)) / 6.
                let expected = (1.0 + 2.0 * inner * inner) / 6.0;
                assert!((moment / count - expected).abs() < 1e-4, "{blades}: {}", moment / count);
                assert!((sum / count).length() < 1e-4, "{blades}: {}", sum / count);
            }
        }
    }

    #[test]
    fn blades_stand_where_they_should() {
        let square = Aperture::new(4, 0.0).unwrap();
        // The first corner is at the top, the next to the left.
        assert!((square.point(DVec2::new(0.0, 1.0)) - DVec2::Y).length() < 1e-12);
        assert!((square.point(DVec2::new(0.25, 1.0)) - DVec2::NEG_X).length() < 1e-12);
        let turned = Aperture::new(4, 45.0).unwrap();
        for p in points(&turned) {
            assert!(p.abs().max_element() <= 0.5f64.sqrt() + 1e-12, "{p}");
        }
        // A polygon of many blades approaches a circle.
        let many: f64 =
            points(&Aperture::new(512, 0.0).unwrap()).map(|p| p.length_squared()).sum::<f64>() / 90_000.0;
        assert!((many - 0.5).abs() < 1e-4, "{many}");
        assert_eq!(Aperture::new(0, 30.0).unwrap(), Aperture::Circle);
        assert!(Aperture::new(1, 0.0).is_err() && Aperture::new(2, 0.0).is_err());
    }
}
