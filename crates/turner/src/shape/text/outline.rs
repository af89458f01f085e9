//! Outlines of characters as short straight edges that know the direction of the curve they approximate.

use crate::math::DVec2;
use crate::math::elementary::acos;
use crate::schema::{Contour, OutlinePiece};

/// An edge of an outline, em.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Edge {
    pub(super) from: DVec2,
    pub(super) to: DVec2,
    /// Unit directions of the outline at both ends.
    pub(super) directions: [DVec2; 2],
}

/// Most edges of one curve.
const MOST: f64 = 256.0;
/// Largest turn within an edge, radians: 15°.
const MOST_TURN: f64 = std::f64::consts::PI / 12.0;

/// Adds the edges of a contour, moved by `shift`. No point of a curve is farther than `tolerance` from its edge.
pub(super) fn flatten(contour: &Contour, shift: DVec2, tolerance: f64, edges: &mut Vec<Edge>) {
    let mut at = contour.start;
    for piece in contour.pieces.iter().chain(&[OutlinePiece::Line(contour.start)]) {
        match *piece {
            OutlinePiece::Line(to) => {
                curve([at, at.lerp(to, 1.0 / 3.0), at.lerp(to, 2.0 / 3.0), to], 1.0, shift, edges)
            }
            OutlinePiece::Quadratic(c, to) => {
                let cubic = [at, at.lerp(c, 2.0 / 3.0), to.lerp(c, 2.0 / 3.0), to];
                curve(cubic, pieces(&cubic, tolerance), shift, edges);
            }
            OutlinePiece::Cubic(c, d, to) => {
                let cubic = [at, c, d, to];
                curve(cubic, pieces(&cubic, tolerance), shift, edges);
            }
        }
        at = piece.end();
    }
}

/// The number of edges of equal parameter range: the distance of a curve from its chord is at most an eighth of the
/// largest second derivative.
fn pieces([a, b, c, d]: &[DVec2; 4], tolerance: f64) -> f64 {
    let second = 6.0 * (a - 2.0 * b + c).length().max((b - 2.0 * c + d).length());
    let legs = [b - a, c - b, d - c].map(DVec2::normalize_or_zero);
    let turn: f64 = legs.windows(2).map(|l| acos(l[0].dot(l[1]).clamp(-1.0, 1.0))).sum();
    let count = (second / (8.0 * tolerance)).sqrt().max(turn / MOST_TURN).ceil();
    if count.is_finite() { count.clamp(1.0, MOST) } else { MOST }
}

/// Adds the edges of a cubic Bézier curve.
fn curve([a, b, c, d]: [DVec2; 4], count: f64, shift: DVec2, edges: &mut Vec<Edge>) {
    let point = |t: f64| {
        let s = 1.0 - t;
        s * s * s * a + 3.0 * s * s * t * b + 3.0 * s * t * t * c + t * t * t * d
    };
    let slope = |t: f64| {
        let s = 1.0 - t;
        3.0 * (s * s * (b - a) + 2.0 * s * t * (c - b) + t * t * (d - c))
    };
    let (mut from, mut t) = (a, 0.0);
    for i in 1..=count as u32 {
        let end = f64::from(i) / count;
        let to = if end < 1.0 { point(end) } else { d };
        if let Some(chord) = (to - from).try_normalize() {
            // Where control points coincide the slope is 0, and the chord is as good.
            let along = |t: f64| slope(t).try_normalize().filter(|d| d.dot(chord) > 0.5).unwrap_or(chord);
            edges.push(Edge { from: from + shift, to: to + shift, directions: [along(t), along(end)] });
        }
        (from, t) = (to, end);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A circle of four cubic curves, within 3e-4 of the radius.
    pub(crate) fn circle(radius: f64) -> Contour {
        let k = 0.5522847498 * radius;
        let at = |x, y| DVec2::new(x, y);
        let r = radius;
        let pieces = vec![
            OutlinePiece::Cubic(at(r, k), at(k, r), at(0.0, r)),
            OutlinePiece::Cubic(at(-k, r), at(-r, k), at(-r, 0.0)),
            OutlinePiece::Cubic(at(-r, -k), at(-k, -r), at(0.0, -r)),
            OutlinePiece::Cubic(at(k, -r), at(r, -k), at(r, 0.0)),
        ];
        Contour { start: at(r, 0.0), pieces }
    }

    #[test]
    fn edges_are_within_the_tolerance_and_know_the_direction() {
        for tolerance in [1e-2, 1e-3, 1e-4] {
            let mut edges = Vec::new();
            flatten(&circle(0.5), DVec2::ONE, tolerance, &mut edges);
            for e in &edges {
                let middle = (0.5 * (e.from + e.to) - DVec2::ONE).length();
                assert!((middle - 0.5).abs() < tolerance + 2e-4, "{middle}");
                for (p, d) in [e.from, e.to].iter().zip(e.directions) {
                    assert!(((p - DVec2::ONE).perp().normalize() - d).length() < 2e-3, "{p} {d}");
                }
            }
            assert!(edges.windows(2).all(|w| w[0].to == w[1].from));
            assert_eq!(edges[0].from, edges[edges.len() - 1].to);
        }
    }

    #[test]
    fn points_that_coincide_have_no_length() {
        let p = DVec2::new(0.5, 0.0);
        let still = Contour { start: p, pieces: vec![OutlinePiece::Line(p), OutlinePiece::Cubic(p, p, p)] };
        let mut edges = Vec::new();
        flatten(&still, DVec2::ZERO, 1e-3, &mut edges);
        // What rounding leaves is far below the grid that outlines are filled on.
        assert!(edges.iter().all(|e| e.from.distance(e.to) < 1e-15), "{edges:?}");
    }
}
