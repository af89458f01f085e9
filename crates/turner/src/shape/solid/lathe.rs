//! Lathes: outlines that are turned about the y axis.
//!
//! A straight line of the outline sweeps a truncated cone, a ring or a cylinder; curves are followed by short lines
//! with smooth shading normals. In the space of the ray, ρ² = r(y)² is quadratic in t for each line.

use super::line::Line;
use super::{PrepareSolid, Solid, SolidGeometry};
use crate::math::{Bounds, DVec2, DVec3, Ray};
use crate::schema::{ErrorCode, SceneError, choice, params};
use crate::shape::{MeshCache, ROUNDING, ShapeHit, SurfacePoint, unit_angle};

choice! {
    /// How the points of a lathe are joined.
    pub enum LatheSpline {
        /// By straight lines.
        Linear = "linear",
        /// By a smooth curve through all points (Catmull–Rom).
        CatmullRom = "catmull-rom",
        /// By cubic Bézier curves: each point of the outline is followed by two control points.
        Bezier = "bezier",
    }
}

params! {
    /// A solid of revolution: an outline that is turned about the y axis, like a vase or a chess piece. Disks close the
    /// ends of an open outline. u runs once around the axis as on a sphere, v along the outline.
    pub struct LatheDesc as "lathe" {
        /// The outline: [[radius, y], …] with radii of 0 or more. If the last point is the first one, the outline is a
        /// ring around the axis.
        points: Vec<DVec2>, required, default [(0.6, 0.0), (0.9, 1.0), (0.5, 1.5)].map(DVec2::from).to_vec();
        /// How the points are joined. Curves are followed by 32 straight lines each, shaded smoothly.
        spline: LatheSpline = LatheSpline::Linear;
    }
    example r#"[[object]]
type = "lathe"
spline = "catmull-rom"
points = [[0, 0], [0.7, 0], [0.3, 0.3], [0.9, 1.2], [0.5, 1.8], [0.6, 2]]
material = { color = "peru" }
"#
}

/// Lines of a curve.
const PIECES: usize = 32;
/// Most lines in all.
const MAX_LINES: usize = 16_384;
/// Lines with common bounds.
const CHUNK: usize = 8;

/// A straight line of the outline, in (radius, y).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    a: DVec2,
    b: DVec2,
    /// Outward unit normals of the curve at both ends; those of the line if it is straight.
    normals: [DVec2; 2],
    /// The outward unit normal of the line.
    n: DVec2,
}

/// A solid of revolution. The part of a hit is the line.
#[derive(Clone, Debug)]
pub struct Lathe {
    pieces: Vec<Piece>,
    /// Bounds of each [`CHUNK`] lines.
    chunks: Vec<Bounds>,
    bounds: Bounds,
    error: f64,
}

impl PrepareSolid for LatheDesc {
    fn prepare_solid(&self, _: &mut MeshCache<'_>) -> Result<Solid, SceneError> {
        let fault = |message: String, help: &str| {
            Err(SceneError::new(ErrorCode::OutOfRange, message).help(help.to_owned()))
        };
        if let Some(bad) = self.points.iter().find(|p| p.x < 0.0) {
            return fault(
                format!("the radius of a lathe must be 0 or more, found {}", bad.x),
                "mirror the outline",
            );
        }
        let per_point = if self.spline == LatheSpline::Linear { 1 } else { PIECES };
        if self.points.len() > MAX_LINES / per_point {
            let message = format!(
                "a lathe has {} points; expected at most {} for this spline",
                self.points.len(),
                MAX_LINES / per_point
            );
            return fault(message, "use fewer points, or a mesh");
        }
        let Some(lines) = self.spline.lines(&self.points) else {
            let message = format!("a lathe has {} points, too few for its spline", self.points.len());
            return fault(
                message,
                "expected at least 2, or 4 for \"bezier\" and three more for each further curve",
            );
        };
        Lathe::new(lines).map(Solid::Lathe)
    }
}

/// A line with the directions of the curve at its ends.
type CurveLine = ([DVec2; 2], Option<[DVec2; 2]>);

impl LatheSpline {
    /// The lines that follow the outline; `None` if there are too few points.
    fn lines(self, points: &[DVec2]) -> Option<Vec<CurveLine>> {
        if points.len() < 2 {
            return None;
        }
        let curves: Vec<[DVec2; 4]> = match self {
            LatheSpline::Linear => {
                return Some(points.windows(2).map(|pair| ([pair[0], pair[1]], None)).collect());
            }
            LatheSpline::CatmullRom => {
                let closed = points.first() == points.last() && points.len() > 3;
                let last = points.len() - 1;
                let of = |i: isize| {
                    let i = if closed { i.rem_euclid(last as isize) } else { i.clamp(0, last as isize) };
                    points[i as usize]
                };
                let curve = |i: usize| {
                    let i = i as isize;
                    let (a, d) = (of(i), of(i + 1));
                    [a, a + (d - of(i - 1)) / 6.0, d - (of(i + 2) - a) / 6.0, d]
                };
                (0..last).map(curve).collect()
            }
            LatheSpline::Bezier => {
                if points.len() % 3 != 1 || points.len() < 4 {
                    return None;
                }
                (0..points.len() - 1)
                    .step_by(3)
                    .map(|i| [points[i], points[i + 1], points[i + 2], points[i + 3]])
                    .collect()
            }
        };
        let mut lines = Vec::with_capacity(curves.len() * PIECES);
        for [a, b, c, d] in curves {
            let at = |s: f64| {
                let r = 1.0 - s;
                let p = r * r * r * a + 3.0 * r * r * s * b + 3.0 * r * s * s * c + s * s * s * d;
                DVec2::new(p.x.max(0.0), p.y)
            };
            let slope = |s: f64| {
                let r = 1.0 - s;
                r * r * (b - a) + 2.0 * r * s * (c - b) + s * s * (d - c)
            };
            for i in 0..PIECES {
                let [s, t] = [i, i + 1].map(|i| i as f64 / PIECES as f64);
                let ends = [if i == 0 { a } else { at(s) }, if i + 1 == PIECES { d } else { at(t) }];
                lines.push((ends, Some([slope(s), slope(t)])));
            }
        }
        Some(lines)
    }
}

impl Lathe {
    fn new(mut lines: Vec<CurveLine>) -> Result<Lathe, SceneError> {
        let (first, last) = (lines[0].0[0], lines[lines.len() - 1].0[1]);
        if first != last {
            // Disks to the axis; the axis itself closes the outline.
            let axis = |p: DVec2| DVec2::new(0.0, p.y);
            lines.insert(0, ([axis(first), first], None));
            lines.push(([last, axis(last)], None));
        }
        lines.retain(|(ends, _)| ends[0] != ends[1]);
        let closing = lines.last().zip(lines.first()).map(|(last, first)| (last.0[1], first.0[0]));
        let cross = |a: DVec2, b: DVec2| a.x * b.y - a.y * b.x;
        let area = lines.iter().map(|(ends, _)| cross(ends[0], ends[1])).sum::<f64>()
            + closing.map_or(0.0, |(from, to)| cross(from, to));
        if area == 0.0 || !area.is_finite() {
            let message = "the outline of a lathe encloses no area";
            return Err(SceneError::new(ErrorCode::OutOfRange, message).help("give radii greater than 0"));
        }
        let outward = |t: DVec2, fallback: DVec2| {
            let n = DVec2::new(t.y, -t.x) * area.signum();
            n.try_normalize().unwrap_or(fallback)
        };
        let pieces: Vec<Piece> = lines
            .iter()
            .map(|(ends, slopes)| {
                let n = outward(ends[1] - ends[0], DVec2::X);
                let normals = slopes.map_or([n; 2], |slopes| slopes.map(|t| outward(t, n)));
                Piece { a: ends[0], b: ends[1], normals, n }
            })
            .collect();
        let bounds_of = |pieces: &[Piece]| {
            let ends = pieces.iter().flat_map(|piece| [piece.a, piece.b]);
            Bounds::of(ends.flat_map(|p| [DVec3::new(-p.x, p.y, -p.x), DVec3::new(p.x, p.y, p.x)]))
        };
        let total = bounds_of(&pieces);
        let error = 2.0 * ROUNDING * total.min.abs().max(total.max.abs()).max_element();
        let grown = |b: Bounds| Bounds::new(b.min - 4.0 * error, b.max + 4.0 * error);
        let chunks = pieces.chunks(CHUNK).map(|chunk| grown(bounds_of(chunk))).collect();
        Ok(Lathe { pieces, chunks, bounds: grown(total), error })
    }

    fn piece(&self, hit: &ShapeHit) -> &Piece {
        &self.pieces[(hit.part as usize).min(self.pieces.len() - 1)]
    }
}

impl Piece {
    /// Calls `visit` with the positions on a line where it crosses the surface of revolution.
    fn crossings(&self, line: &Line, error: f64, mut visit: impl FnMut(f64)) {
        let (o, d) = (line.origin, line.direction);
        let height = self.b.y - self.a.y;
        if height == 0.0 {
            let s = (self.a.y - o.y) / d.y;
            let p = line.at(s);
            let rho = (p.x * p.x + p.z * p.z).sqrt();
            let (low, high) = (self.a.x.min(self.b.x), self.a.x.max(self.b.x));
            if rho >= low - error && rho <= high + error {
                visit(s);
            }
            return;
        }
        let slope = (self.b.x - self.a.x) / height;
        // ρ² = (r + slope · (y − y_a))²
        let (r, dr) = (self.a.x + slope * (o.y - self.a.y), slope * d.y);
        let a = d.x * d.x + d.z * d.z - dr * dr;
        let b = o.x * d.x + o.z * d.z - r * dr;
        // b² − a c by Lagrange's identity, without the cancellation of large equal terms.
        let turn = o.x * d.z - o.z * d.x;
        let (mx, mz) = (r * d.x - dr * o.x, r * d.z - dr * o.z);
        let discriminant = mx * mx + mz * mz - turn * turn;
        let c = o.x * o.x + o.z * o.z - r * r;
        let (low, high) = (self.a.y.min(self.b.y) - error, self.a.y.max(self.b.y) + error);
        let mut check = |s: f64| {
            let y = o.y + s * d.y;
            // The other nappe has a negative radius.
            if y >= low && y <= high && r + s * dr >= -error {
                visit(s);
            }
        };
        if a == 0.0 {
            check(-0.5 * c / b);
        } else if discriminant >= 0.0 {
            let q = -(b + discriminant.sqrt().copysign(b));
            check(if q == 0.0 { 0.0 } else { c / q });
            check(q / a);
        }
    }

    /// The position along the line nearest to a point in (radius, y), 0..1.
    fn parameter(&self, p: DVec2) -> f64 {
        let d = self.b - self.a;
        let x = (p - self.a).dot(d) / d.length_squared();
        if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) }
    }
}

impl SolidGeometry for Lathe {
    fn bounds(&self) -> Option<Bounds> {
        Some(self.bounds)
    }

    fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let line = Line::new(ray, &self.bounds)?;
        let mut best: Option<ShapeHit> = None;
        for (k, chunk) in self.pieces.chunks(CHUNK).enumerate() {
            if self.chunks.len() > 1 && Line::new(ray, &self.chunks[k]).is_none() {
                continue;
            }
            for (i, piece) in chunk.iter().enumerate() {
                piece.crossings(&line, self.error, |s| {
                    let t = line.t(s);
                    if ray.contains(t) && best.is_none_or(|b| t < b.t) {
                        best = Some(ShapeHit { t, part: (CHUNK * k + i) as u32, u: 0.0, v: 0.0 });
                    }
                });
            }
        }
        best
    }

    fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        let piece = self.piece(hit);
        let p = ray.at(hit.t);
        let rho = (p.x * p.x + p.z * p.z).sqrt();
        let out = if rho > 0.0 { DVec2::new(p.x, p.z) / rho } else { DVec2::X };
        let x = piece.parameter(DVec2::new(rho, p.y));
        let q = piece.a + x * (piece.b - piece.a);
        let turned = |n: DVec2| DVec3::new(n.x * out.x, n.y, n.x * out.y);
        let smooth = piece.normals[0] * (1.0 - x) + piece.normals[1] * x;
        let ng = turned(piece.n).normalize();
        let is_straight = piece.normals == [piece.n; 2];
        let ns = turned(smooth).try_normalize().filter(|n| n.dot(ng) > 0.0 && !is_straight).unwrap_or(ng);
        SurfacePoint { p: DVec3::new(q.x * out.x, q.y, q.x * out.y), error: self.error, ng, ns }
    }

    fn uv(&self, hit: &ShapeHit, point: &SurfacePoint) -> DVec2 {
        let p = point.p;
        let x = self.piece(hit).parameter(DVec2::new((p.x * p.x + p.z * p.z).sqrt(), p.y));
        let v = (f64::from(hit.part) + x) / self.pieces.len() as f64;
        DVec2::new(unit_angle(p.x, p.z), v.clamp(0.0, 1.0))
    }

    fn curvature(&self, hit: &ShapeHit) -> f64 {
        let piece = self.piece(hit);
        0.5 * piece.n.x / (0.5 * (piece.a.x + piece.b.x)).max(1e-30)
    }

    fn hull_points(&self) -> Vec<DVec3> {
        let turns =
            (0..24).map(|i| crate::math::elementary::sin_cos(std::f64::consts::TAU * f64::from(i) / 24.0));
        let step = self.pieces.len() / 128 + 1;
        let ends = self.pieces.iter().step_by(step).flat_map(|piece| [piece.a, piece.b]);
        let ring = |p: DVec2| turns.clone().map(move |(s, c)| DVec3::new(p.x * c, p.y, p.x * s));
        ends.flat_map(ring).collect()
    }

    fn memory(&self) -> usize {
        size_of_val(&self.pieces[..]) + size_of_val(&self.chunks[..])
    }
}
