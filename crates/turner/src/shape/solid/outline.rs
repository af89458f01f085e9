//! Closed outlines in a plane, made of straight lines and cubic Bézier curves; the cross-sections of prisms.

use super::roots::roots_with_signs;
use crate::math::DVec2;
use crate::schema::{ErrorCode, SceneError};

/// Most segments, and most contours: which contours lie in others is found by testing each against all segments.
const MAX_SEGMENTS: usize = 65_536;
const MAX_CONTOURS: usize = 4096;

/// A line or curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Segment {
    /// Coefficients of the position in powers of s, 0..1.
    coefficients: [DVec2; 4],
    /// The end: the start of the next segment, bit by bit.
    end: DVec2,
    min: DVec2,
    max: DVec2,
    /// 1 if the inside is to the left, else −1.
    side: f64,
}

/// Closed outlines. A point is inside if a line from it crosses them an odd number of times.
#[derive(Clone, Debug, Default)]
pub(super) struct Outline {
    segments: Vec<Segment>,
    min: DVec2,
    max: DVec2,
}

fn cross(a: DVec2, b: DVec2) -> f64 {
    a.x * b.y - a.y * b.x
}

impl Segment {
    fn line(from: DVec2, to: DVec2) -> Segment {
        Segment {
            coefficients: [from, to - from, DVec2::ZERO, DVec2::ZERO],
            end: to,
            min: from.min(to),
            max: from.max(to),
            side: 1.0,
        }
    }

    fn curve([a, b, c, d]: [DVec2; 4]) -> Segment {
        Segment {
            coefficients: [a, 3.0 * (b - a), 3.0 * (a - 2.0 * b + c), d - a + 3.0 * (b - c)],
            end: d,
            min: a.min(b).min(c).min(d),
            max: a.max(b).max(c).max(d),
            side: 1.0,
        }
    }

    fn start(&self) -> DVec2 {
        self.coefficients[0]
    }

    /// The point at s.
    pub(super) fn at(&self, s: f64) -> DVec2 {
        let [a, b, c, d] = self.coefficients;
        a + s * (b + s * (c + s * d))
    }

    /// The derivative of the point by s.
    pub(super) fn tangent(&self, s: f64) -> DVec2 {
        let [_, b, c, d] = self.coefficients;
        b + s * (2.0 * c + s * 3.0 * d)
    }

    /// The unit normal that points out of the outline.
    pub(super) fn normal(&self, s: f64) -> DVec2 {
        let mut t = self.tangent(s);
        if t.length_squared() < 1e-24 * (self.max - self.min).length_squared() {
            // At a control point that coincides with an end, the direction is that towards the inside.
            t = self.tangent(s.clamp(1e-4, 1.0 - 1e-4));
        }
        let n = DVec2::new(t.y, -t.x) * self.side;
        n.try_normalize().unwrap_or(DVec2::X)
    }

    /// Whether it is curved.
    fn is_curve(&self) -> bool {
        self.coefficients[2] != DVec2::ZERO || self.coefficients[3] != DVec2::ZERO
    }

    /// Calls `visit` with the s where the line through `o` along `d` crosses it.
    pub(super) fn crossings(&self, o: DVec2, d: DVec2, mut visit: impl FnMut(f64)) {
        // The signed distance of the line from the box: all corners on one side is no crossing.
        let center = 0.5 * (self.min + self.max) - o;
        let reach = 0.5 * (self.max - self.min);
        if cross(d, center).abs() > (d.y.abs() * reach.x + d.x.abs() * reach.y) * (1.0 + 1e-9) + 1e-300 {
            return;
        }
        let ends = [cross(d, self.start() - o), cross(d, self.end - o)];
        let negative = ends.map(|v| v < 0.0);
        if !self.is_curve() {
            if negative[0] != negative[1] {
                visit((ends[0] / (ends[0] - ends[1])).clamp(0.0, 1.0));
            }
            return;
        }
        let [_, b, c, e] = self.coefficients;
        let polynomial = [ends[0], cross(d, b), cross(d, c), cross(d, e)];
        roots_with_signs(&polynomial, 0.0, 1.0, negative).as_slice().iter().for_each(|s| visit(*s));
    }
}

impl Outline {
    /// From closed contours. With `curved`, the points of each contour are those of cubic Bézier curves: a point of the
    /// outline, two control points, a point, …; a contour then has a multiple of three points.
    ///
    /// Errors: a contour of fewer than three points; one that is not made of curves; too many points.
    pub(super) fn new(contours: &[&[DVec2]], curved: bool) -> Result<Outline, SceneError> {
        let mut outline = Outline::default();
        let total: usize = contours.iter().map(|contour| contour.len()).sum();
        if total > MAX_SEGMENTS || contours.len() > MAX_CONTOURS {
            let message = format!(
                "an outline has {} contours with {total} points; expected at most {MAX_CONTOURS} with {MAX_SEGMENTS}",
                contours.len()
            );
            return Err(SceneError::new(ErrorCode::TooLarge, message).help("split it into several objects"));
        }
        let mut starts = Vec::with_capacity(contours.len());
        for contour in contours {
            let mut points = contour.to_vec();
            if points.len() > 1 && points.first() == points.last() {
                points.pop();
            }
            if points.len() < 3 {
                let message = format!("an outline has {} points; expected at least 3", points.len());
                return Err(SceneError::new(ErrorCode::OutOfRange, message).help("add points"));
            }
            if curved && !points.len().is_multiple_of(3) {
                let message = format!("an outline of Bézier curves has {} points", points.len());
                return Err(SceneError::new(ErrorCode::OutOfRange, message)
                    .help("give three for each curve: a point of the outline and two control points"));
            }
            let of = |i: usize| points[i % points.len()];
            let first = outline.segments.len();
            starts.push(first);
            if curved {
                let starts = (0..points.len()).step_by(3);
                let curves = starts.map(|i| Segment::curve([of(i), of(i + 1), of(i + 2), of(i + 3)]));
                outline.segments.extend(curves);
            } else {
                outline.segments.extend((0..points.len()).map(|i| Segment::line(of(i), of(i + 1))));
            }
            // The signed area by Green's theorem, with the control polygon for curves.
            let area: f64 = (0..points.len()).map(|i| cross(of(i), of(i + 1))).sum();
            let side = if area < 0.0 { -1.0 } else { 1.0 };
            outline.segments[first..].iter_mut().for_each(|segment| segment.side = side);
        }
        outline.orient(&starts);
        outline.min = outline.segments.iter().fold(DVec2::INFINITY, |m, s| m.min(s.min));
        outline.max = outline.segments.iter().fold(DVec2::NEG_INFINITY, |m, s| m.max(s.max));
        Ok(outline)
    }

    /// Turns the sides of contours that lie inside an odd number of others: those of holes. `starts` are their first
    /// segments.
    fn orient(&mut self, starts: &[usize]) {
        if starts.len() < 2 {
            return;
        }
        let reach = self.segments.iter().fold(0.0f64, |m, s| m.max((s.max - s.min).max_element()));
        // Just outside of its first segment, a contour alone has nothing.
        let beside = |segment: &Segment| segment.at(0.5) + 1e-7 * reach * segment.normal(0.5);
        let turned: Vec<bool> = starts.iter().map(|i| self.contains(beside(&self.segments[*i]))).collect();
        let ends = starts.iter().skip(1).copied().chain([self.segments.len()]);
        for ((start, end), turned) in starts.iter().zip(ends).zip(turned) {
            let side = if turned { -1.0 } else { 1.0 };
            self.segments[*start..end].iter_mut().for_each(|segment| segment.side *= side);
        }
    }

    /// Its lines and curves.
    pub(super) fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// The corners of its bounding box.
    pub(super) fn bounds(&self) -> [DVec2; 2] {
        [self.min, self.max]
    }

    /// Whether a point is inside.
    pub(super) fn contains(&self, p: DVec2) -> bool {
        let mut inside = false;
        for segment in &self.segments {
            if p.y < segment.min.y || p.y > segment.max.y || p.x > segment.max.x {
                continue;
            }
            segment.crossings(p, DVec2::X, |s| inside ^= segment.at(s).x > p.x);
        }
        inside
    }

    /// Points on it.
    pub(super) fn points(&self) -> impl Iterator<Item = DVec2> {
        self.segments.iter().flat_map(|segment| {
            let steps = if segment.is_curve() { 8 } else { 1 };
            (0..steps).map(move |i| segment.at(f64::from(i) / f64::from(steps)))
        })
    }

    /// The value of s near `s` at which a segment is nearest to `p`, to first order.
    pub(super) fn parameter(&self, segment: usize, s: f64, p: DVec2) -> f64 {
        let Some(segment) = self.segments.get(segment) else { return 0.0 };
        let t = segment.tangent(s);
        let change = (p - segment.at(s)).dot(t) / t.length_squared();
        if change.is_finite() { s + change } else { s }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(half: f64) -> Vec<DVec2> {
        [(-half, -half), (half, -half), (half, half), (-half, half)].map(|(x, y)| DVec2::new(x, y)).to_vec()
    }

    #[test]
    fn holes_and_islands() {
        let (a, b, c) = (square(3.0), square(2.0), square(1.0));
        let outline = Outline::new(&[&a, &b, &c], false).unwrap();
        let at = |x: f64| outline.contains(DVec2::new(x, 0.1));
        assert_eq!([0.0, 1.5, 2.5, 3.5].map(at), [true, false, true, false]);
        // The first segment of each contour is its lower side: normals point out of the solid.
        let normal = |i: usize| outline.segments()[i].normal(0.5).y;
        assert_eq!([0, 4, 8].map(normal), [-1.0, 1.0, -1.0]);
    }

    #[test]
    fn curves_bound_a_disk() {
        // The usual approximation of a circle; its radius is within 0.03 % of 1.
        let k = 0.552_284_749_8;
        let points = [
            (1.0, 0.0),
            (1.0, k),
            (k, 1.0),
            (0.0, 1.0),
            (-k, 1.0),
            (-1.0, k),
            (-1.0, 0.0),
            (-1.0, -k),
            (-k, -1.0),
            (0.0, -1.0),
            (k, -1.0),
            (1.0, -k),
        ]
        .map(|(x, y)| DVec2::new(x, y));
        let outline = Outline::new(&[&points], true).unwrap();
        for i in 0..100 {
            let angle = f64::from(i) * 0.0628;
            let (sin, cos) = crate::math::elementary::sin_cos(angle);
            let d = DVec2::new(cos, sin);
            assert!(outline.contains(0.999 * d) && !outline.contains(1.001 * d), "{angle}");
        }
        let p = outline.segments()[0].at(0.3);
        assert!(outline.segments()[0].normal(0.3).dot(p) > 0.999);
        assert!(
            Outline::new(&[&points[..4]], true).is_err() && Outline::new(&[&points[..2]], false).is_err()
        );
    }
}
