//! Sphere sweeps: tubes of changing radius along a path.
//!
//! Between two neighbouring spheres lies their convex hull: both spheres and the cone that touches them. A ray is
//! inside a convex piece in one interval at most, and inside the sweep where it is inside any piece. The hull of two
//! spheres:
//!
//! ```text
//!        .--.  tangent cone
//!      /      `-._
//!     (    o------o )      axis u from a to b, length l, slope k = (r_b − r_a) / l
//!      \      _.-'         a point with the coordinates (z, ρ) along and off the axis is in
//!        `--'              the cone where ρ <= (r_a + k z) / √(1 − k²) within the tangent circles
//! ```

use super::line::Line;
use super::{PrepareSolid, Solid, SolidGeometry};
use crate::math::{Bounds, DVec2, DVec3, Ray};
use crate::schema::{ErrorCode, SceneError, choice, params};
use crate::shape::{MeshCache, ROUNDING, ShapeHit, Sphere, SurfacePoint};

choice! {
    /// The path of a sphere sweep.
    pub enum SweepPath {
        /// Straight pieces between the spheres.
        Linear = "linear",
        /// A smooth curve through all spheres (Catmull–Rom).
        CatmullRom = "catmull-rom",
        /// A smoother curve near the spheres (uniform cubic B-spline).
        BSpline = "b-spline",
    }
}

params! {
    /// A sphere that moves along a path and changes its radius: a tube with round ends. Where it crosses itself, inner
    /// surfaces are removed. u runs from 0 at the first sphere to 1 at the last one, v is 0.5.
    pub struct SphereSweepDesc as "sphere_sweep" {
        /// Centre and radius of each sphere: [[x, y, z, radius], …], at least two, or four for "b-spline".
        spheres: Vec<[f64; 4]>, required, default vec![[-1.0, 0.0, 0.0, 0.3], [1.0, 0.0, 0.0, 0.5]];
        /// The path between them. Curves are followed in 32 pieces from sphere to sphere.
        path: SweepPath = SweepPath::Linear;
    }
    example r#"[[object]]
type = "sphere_sweep"
path = "catmull-rom"
spheres = [[-2, 0, 0, 0.1], [-1, 1, 0, 0.4], [1, -0.5, 0.5, 0.2], [2, 0.5, 0, 0.3]]
material = { color = "coral" }
"#
}

/// Pieces of a curve between two spheres of the file.
const PIECES: usize = 32;
/// Most pieces in all.
const MAX_PIECES: usize = 16_384;
/// Pieces with common bounds.
const CHUNK: usize = 8;

/// The convex hull of two spheres.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    a: DVec3,
    b: DVec3,
    /// Radii.
    r: [f64; 2],
    /// Unit vector from a to b; 0 if one sphere contains the other.
    axis: DVec3,
    length: f64,
    /// Growth of the radius per unit of length.
    slope: f64,
}

/// A sphere sweep.
#[derive(Clone, Debug)]
pub struct SphereSweep {
    pieces: Vec<Piece>,
    /// Bounds of each [`CHUNK`] pieces.
    chunks: Vec<Bounds>,
    bounds: Bounds,
}

impl PrepareSolid for SphereSweepDesc {
    fn prepare_solid(&self, _: &mut MeshCache<'_>) -> Result<Solid, SceneError> {
        let fault = |message: String, help: &str| {
            Err(SceneError::new(ErrorCode::OutOfRange, message).help(help.to_owned()))
        };
        let least = if self.path == SweepPath::BSpline { 4 } else { 2 };
        if self.spheres.len() < least {
            let message =
                format!("a sphere sweep has {} spheres; expected at least {least}", self.spheres.len());
            return fault(message, "add spheres [x, y, z, radius]");
        }
        if let Some(bad) = self.spheres.iter().find(|s| !(s[3] > 0.0)) {
            return fault(
                format!("the radius of a sphere must be greater than 0, found {}", bad[3]),
                "use a small radius",
            );
        }
        let per_sphere = if self.path == SweepPath::Linear { 1 } else { PIECES };
        if self.spheres.len() > MAX_PIECES / per_sphere {
            let message = format!(
                "a sphere sweep has {} spheres; expected at most {} on this path",
                self.spheres.len(),
                MAX_PIECES / per_sphere
            );
            return fault(message, "split it into several objects");
        }
        let points = self.path.points(&self.spheres);
        let pieces: Vec<Piece> = points.windows(2).map(|pair| Piece::new(pair[0], pair[1])).collect();
        let chunks: Vec<Bounds> = pieces
            .chunks(CHUNK)
            .map(|chunk| chunk.iter().fold(Bounds::EMPTY, |all, piece| all.union(&piece.bounds())))
            .collect();
        let bounds = chunks.iter().fold(Bounds::EMPTY, |all, b| all.union(b));
        Ok(Solid::SphereSweep(SphereSweep { pieces, chunks, bounds }))
    }
}

impl SweepPath {
    /// The spheres of the pieces.
    fn points(self, given: &[[f64; 4]]) -> Vec<[f64; 4]> {
        let of = |i: usize| given[i.min(given.len() - 1)];
        let blend = |from: [[f64; 4]; 4], weights: [f64; 4]| -> [f64; 4] {
            std::array::from_fn(|k| (0..4).map(|i| weights[i] * from[i][k]).sum())
        };
        let mut points = Vec::new();
        let spans = match self {
            SweepPath::Linear => return given.to_vec(),
            SweepPath::CatmullRom => given.len() - 1,
            SweepPath::BSpline => given.len() - 3,
        };
        for (i, j) in (0..spans).flat_map(|i| (0..PIECES).map(move |j| (i, j))).chain([(spans - 1, PIECES)]) {
            let x = j as f64 / PIECES as f64;
            let (x2, x3) = (x * x, x * x * x);
            points.push(match self {
                SweepPath::BSpline => {
                    let rest = 1.0 - x;
                    let weights = [
                        rest * rest * rest / 6.0,
                        (3.0 * x3 - 6.0 * x2 + 4.0) / 6.0,
                        (-3.0 * x3 + 3.0 * x2 + 3.0 * x + 1.0) / 6.0,
                        x3 / 6.0,
                    ];
                    blend([of(i), of(i + 1), of(i + 2), of(i + 3)], weights)
                }
                _ => {
                    let weights = [
                        0.5 * (-x3 + 2.0 * x2 - x),
                        0.5 * (3.0 * x3 - 5.0 * x2 + 2.0),
                        0.5 * (-3.0 * x3 + 4.0 * x2 + x),
                        0.5 * (x3 - x2),
                    ];
                    // A curve may undershoot a small radius.
                    let least = of(i)[3].min(of(i + 1)[3]);
                    let [x, y, z, r] = blend([of(i.saturating_sub(1)), of(i), of(i + 1), of(i + 2)], weights);
                    [x, y, z, r.max(0.5 * least)]
                }
            });
        }
        points
    }
}

impl Piece {
    fn new(from: [f64; 4], to: [f64; 4]) -> Piece {
        let [a, b] = [from, to].map(|s| DVec3::new(s[0], s[1], s[2]));
        let r = [from[3], to[3]];
        let length = a.distance(b);
        let slope = (r[1] - r[0]) / length;
        // One sphere contains the other: there is no cone.
        let axis = if slope.abs() < 1.0 { (b - a) / length } else { DVec3::ZERO };
        Piece { a, b, r, axis, length, slope }
    }

    fn bounds(&self) -> Bounds {
        let ball = |c: DVec3, r: f64| {
            let r = r * (1.0 + 1e-12) + ROUNDING * c.abs().max_element();
            Bounds::new(c - r, c + r)
        };
        ball(self.a, self.r[0]).union(&ball(self.b, self.r[1]))
    }

    /// The interval of distances in which a line is inside.
    fn interval(&self, o: DVec3, d: DVec3) -> Option<(f64, f64)> {
        let ends = [(self.a, self.r[0]), (self.b, self.r[1])];
        let mut found: Option<(f64, f64)> = None;
        let mut add = |from: f64, to: f64| {
            found = Some(found.map_or((from, to), |(a, b)| (a.min(from), b.max(to))));
        };
        for (center, radius) in ends {
            let m = o - center;
            let b = -m.dot(d);
            // The squared distance of the line without cancellation.
            let off = (m + b * d).length_squared();
            let rest = radius * radius - off;
            if rest >= 0.0 {
                add(b - rest.sqrt(), b + rest.sqrt());
            }
        }
        if self.axis != DVec3::ZERO {
            self.cone(o, d).into_iter().for_each(|(from, to)| add(from, to));
        }
        found
    }

    /// The interval in the cone between the tangent circles.
    fn cone(&self, o: DVec3, d: DVec3) -> Option<(f64, f64)> {
        let (k, u) = (self.slope, self.axis);
        let m = o - self.a;
        let (mz, dz) = (m.dot(u), d.dot(u));
        // ρ² (1 − k²) <= (r_a + k z)², with ρ² = |p|² − z².
        let (m_off, d_off) = (m - mz * u, d - dz * u);
        let c = 1.0 - k * k;
        let (r, dr) = (self.r[0] + k * mz, k * dz);
        let qa = c * d_off.length_squared() - dr * dr;
        let qb = c * m_off.dot(d_off) - r * dr;
        let qc = c * m_off.length_squared() - r * r;
        // The tangent circles lie at z = −k r_a and z = l − k r_b.
        let (low, high) = (-k * self.r[0], self.length - k * self.r[1]);
        let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
        if dz != 0.0 {
            let ends = [(low - mz) / dz, (high - mz) / dz];
            (from, to) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        } else if mz < low || mz > high {
            return None;
        }
        if qa.abs() < 1e-14 {
            if qb == 0.0 {
                return (qc <= 0.0 && from < to).then_some((from, to));
            }
            let root = -0.5 * qc / qb;
            (from, to) = if qb > 0.0 { (from, to.min(root)) } else { (from.max(root), to) };
            return (from < to).then_some((from, to));
        }
        let discriminant = qb * qb - qa * qc;
        if discriminant < 0.0 {
            return (qa < 0.0 && from < to).then_some((from, to));
        }
        let q = -(qb + discriminant.sqrt().copysign(qb));
        let (t0, t1) = if q == 0.0 { (0.0, 0.0) } else { (q / qa, qc / q) };
        let (t0, t1) = (t0.min(t1), t0.max(t1));
        if qa > 0.0 {
            (from, to) = (from.max(t0), to.min(t1));
            return (from < to).then_some((from, to));
        }
        // Steeper than the cone: before t0 and after t1. Between the circles only one side has positive radii.
        let radius = |t: f64| r + dr * t;
        let before = (from, to.min(t0));
        let after = (from.max(t1), to);
        [before, after].into_iter().find(|(a, b)| a < b && radius(0.5 * (a + b)) > 0.0)
    }

    /// The nearest point of the surface to `p`, the normal there, and the position along the piece, 0..1.
    fn nearest(&self, p: DVec3) -> (DVec3, DVec3, f64) {
        let m = p - self.a;
        let z = m.dot(self.axis);
        let out = m - z * self.axis;
        let rho = out.length();
        let c = (1.0 - self.slope * self.slope).max(0.0).sqrt();
        // Along the normal of the cone, back to the axis.
        let along = if self.axis == DVec3::ZERO {
            if self.r[1] > self.r[0] { 1.0 } else { 0.0 }
        } else {
            (z + rho * self.slope / c) / self.length
        };
        let x = if along.is_nan() { 0.0 } else { along.clamp(0.0, 1.0) };
        let center = self.a + x * (self.b - self.a);
        let n = (p - center).try_normalize().unwrap_or(DVec3::Y);
        let radius = self.r[0] + x * (self.r[1] - self.r[0]);
        // Within the cone the surface is (r_a + k z) / c from the axis, seen along the normal.
        let p = if x > 0.0 && x < 1.0 {
            let n = (c * out.normalize_or(n) - self.slope * self.axis).normalize();
            return (self.a + x * self.length * self.axis + radius * n, n, x);
        } else {
            center + radius * n
        };
        (p, n, x)
    }
}

impl SphereSweep {
    /// Calls `visit` with the interval of each piece that a line may cross.
    fn intervals(&self, ray: &Ray, line: &Line, mut visit: impl FnMut(usize, f64, f64)) {
        for (k, chunk) in self.pieces.chunks(CHUNK).enumerate() {
            if self.chunks.len() > 1 && Line::new(ray, &self.chunks[k]).is_none() {
                continue;
            }
            for (i, piece) in chunk.iter().enumerate() {
                if let Some((from, to)) = piece.interval(line.origin, line.direction) {
                    visit(CHUNK * k + i, from, to);
                }
            }
        }
    }

    /// The first position from `start` on where the line enters or leaves the sweep, with the piece.
    fn boundary(&self, ray: &Ray, line: &Line, start: f64) -> Option<(f64, usize)> {
        let mut exit: Option<(f64, usize)> = None;
        let mut at = start;
        loop {
            let mut furthest: Option<(f64, usize)> = None;
            let mut entry: Option<(f64, usize)> = None;
            self.intervals(ray, line, |i, from, to| {
                // A piece that begins where another one ends has no gap before it.
                let contains = from < at || (exit.is_some() && from == at);
                if contains && to > at && furthest.is_none_or(|(t, _)| to > t) {
                    furthest = Some((to, i));
                }
                if from >= at && entry.is_none_or(|(t, _)| from < t) {
                    entry = Some((from, i));
                }
            });
            match furthest {
                Some(next) => {
                    exit = Some(next);
                    at = next.0;
                }
                None => return exit.or(entry),
            }
        }
    }
}

impl SolidGeometry for SphereSweep {
    fn bounds(&self) -> Option<Bounds> {
        Some(self.bounds)
    }

    fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        if !(ray.t_min <= ray.t_max) {
            return None;
        }
        let line = Line::new(ray, &self.bounds)?;
        let mut start = line.before(ray.t_min);
        loop {
            let (s, piece) = self.boundary(ray, &line, start)?;
            let t = line.t(s);
            if t > ray.t_max {
                return None;
            }
            if ray.contains(t) {
                return Some(ShapeHit { t, part: piece as u32, u: 0.0, v: 0.0 });
            }
            start = s.next_up();
        }
    }

    fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        let piece = &self.pieces[(hit.part as usize).min(self.pieces.len() - 1)];
        let (p, n, _) = piece.nearest(ray.at(hit.t));
        let size =
            p.abs().max_element() + piece.a.abs().max_element() + piece.r[0].max(piece.r[1]) + piece.length;
        SurfacePoint { p, error: 4.0 * ROUNDING * size, ng: n, ns: n }
    }

    fn uv(&self, hit: &ShapeHit, point: &SurfacePoint) -> DVec2 {
        let piece = &self.pieces[(hit.part as usize).min(self.pieces.len() - 1)];
        let (_, _, x) = piece.nearest(point.p);
        DVec2::new(((f64::from(hit.part) + x) / self.pieces.len() as f64).clamp(0.0, 1.0), 0.5)
    }

    fn curvature(&self, hit: &ShapeHit) -> f64 {
        let piece = &self.pieces[(hit.part as usize).min(self.pieces.len() - 1)];
        1.0 / (piece.r[0] + piece.r[1])
    }

    fn hull_points(&self) -> Vec<DVec3> {
        let n = Sphere { center: DVec3::ZERO, radius: 1.0 };
        let directions = Bounds::new(DVec3::splat(-n.radius), DVec3::splat(n.radius)).corners();
        let around = |c: DVec3, r: f64| directions.map(|d| c + r * d.normalize());
        let step = self.pieces.len() / 256 + 1;
        let ends = self.pieces.iter().rev().take(1).flat_map(|piece| around(piece.b, piece.r[1]));
        let starts = self.pieces.iter().step_by(step).flat_map(|piece| around(piece.a, piece.r[0]));
        starts.chain(ends).collect()
    }

    fn memory(&self) -> usize {
        size_of_val(&self.pieces[..]) + size_of_val(&self.chunks[..])
    }
}
