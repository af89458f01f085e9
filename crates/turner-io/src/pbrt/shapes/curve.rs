//! Curves. Those with an area light become triangle meshes, on which lights are sampled; all others are curves.
//!
//! A curve is a chain of Bézier segments of degree 2 or 3; a B-spline is converted span by span. A
//! cross-section is swept along the chain and neighbouring cross-sections are joined by triangles:
//!
//! ```text
//!       side            flat, cylinder: a hexagon around the curve, in the plane of `side` and `up`
//!        ↑  ↗ up        ribbon:         a line across the curve, perpendicular to its normals
//!   ─────●─────→ forward
//! ```
//!
//! The number of steps per segment follows the angle by which its control polygon turns. The frame is carried
//! from step to step: `side` is projected onto the plane perpendicular to `forward`, which avoids twist. pbrt's
//! flat curves always face the ray; a thin tube looks nearly the same. The width is interpolated linearly along
//! the complete curve.

use turner::math::DVec3;
use turner::math::elementary::{acos, sin_cos_turns};
use turner::schema::{ErrorCode, MeshData};
use turner::shape::curves::CurveKind;

use super::super::assembly::Assembly;
use super::super::params::Params;
use super::super::report::Fault;
use super::super::state::State;
use super::fibres::fibre;
use super::light_parts::LightParts;
use super::{Made, orient};
use crate::assets::printable;

/// Angle in degrees by which the direction may turn per step, on average over a segment; fewest and most steps
/// of a segment.
const TURN: f64 = 6.0;
const STEPS: std::ops::RangeInclusive<u32> = 2..=48;
/// Most times that a segment is split into two lights.
const MAX_SPLITS: i32 = 10;
/// Sides of a tube.
const SIDES: u32 = 6;

/// `curve`.
pub(super) fn curve(scene: &mut Assembly<'_>, state: &State, params: &mut Params) -> Result<Made, Fault> {
    let place = params.place;
    let kind = params.string("type").unwrap_or("flat").to_owned();
    let basis = params.string("basis").unwrap_or("bezier").to_owned();
    let degree = params.integer("degree").unwrap_or(3);
    let width = params.float("width").unwrap_or(1.0);
    let widths = [params.float("width0").unwrap_or(width), params.float("width1").unwrap_or(width)];
    // The pieces of an area light; without one it changes nothing.
    let splits = params.integer("splitdepth").unwrap_or(3).clamp(0, MAX_SPLITS);
    let points: Vec<DVec3> =
        params.take_triples("P").into_iter().map(|p| DVec3::from(p.map(f64::from))).collect();
    let normals: Vec<DVec3> =
        params.take_triples("N").into_iter().map(|p| DVec3::from(p.map(f64::from))).collect();
    if !matches!(degree, 2 | 3) {
        let message = format!("degree {degree} of a curve; expected 2 or 3");
        return Err(Fault::at(place, ErrorCode::OutOfRange, message));
    }
    if !matches!(kind.as_str(), "flat" | "cylinder" | "ribbon") {
        return Err(super::super::reader::unknown("type of curve", &kind, &["flat", "cylinder", "ribbon"])
            .or_at(place));
    }
    let d = degree as usize;
    let segments: Vec<Vec<DVec3>> = match basis.as_str() {
        "bezier" if points.len() > d && (points.len() - 1).is_multiple_of(d) => (0..(points.len() - 1) / d)
            .filter_map(|i| points.get(i * d..=i * d + d))
            .map(<[DVec3]>::to_vec)
            .collect(),
        "bspline" if points.len() > d => points.windows(d + 1).map(bezier_of_spline).collect(),
        "bezier" | "bspline" => {
            let message =
                format!("{} control points do not fit a {} curve of degree {degree}", points.len(), basis);
            return Err(Fault::at(place, ErrorCode::Mesh, message));
        }
        other => {
            return Err(
                super::super::reader::unknown("basis of a curve", other, &["bezier", "bspline"]).or_at(place)
            );
        }
    };
    let ribbon = kind == "ribbon" && !normals.is_empty();
    if state.area_light.is_none() {
        let count = 3 * segments.len() as u64 + 1;
        scene.divide(count, place)?;
        let kind = match kind.as_str() {
            "flat" => CurveKind::Flat,
            "ribbon" if ribbon => CurveKind::Ribbon,
            _ => CurveKind::Tube,
        };
        return Ok(Made::Curve(fibre(&segments, widths, ribbon.then_some(&normals[..])), kind));
    }
    let across = if ribbon { 2 } else { SIDES };
    let rows = segments.iter().map(|s| u64::from(steps(s))).sum::<u64>() + 1;
    scene.divide(rows.saturating_mul(u64::from(across)), place)?;
    scene.report.approximated(
        place,
        format!("emissive curves of type \"{}\": rendered as thin swept meshes", printable(&kind)),
    );
    let mut data = sweep(&segments, widths, if ribbon { Some(&normals) } else { None }, across);
    orient(&mut data, state.reverse);
    let per_row = 2 * (if ribbon { 1 } else { SIDES }) as usize;
    let lights = rows_of(&segments).zip(rows_of(&segments).skip(1)).map(|((segment, t), _)| {
        let area = segments
            .get(segment)
            .map_or(1.0, |points| light_area(points, t, 1 << splits, [segment, segments.len()], widths));
        (per_row, area)
    });
    Ok(Made::Mesh(data, LightParts::Runs(lights.collect())))
}

/// Segment and parameter of each row; a segment begins where the last one ends.
fn rows_of(segments: &[Vec<DVec3>]) -> impl Iterator<Item = (usize, f64)> {
    let inner = segments.iter().enumerate().flat_map(|(i, points)| {
        let steps = steps(points);
        (0..steps).map(move |k| (i, f64::from(k) / f64::from(steps)))
    });
    inner.chain([(segments.len().saturating_sub(1), 1.0)])
}

/// The area with which pbrt divides the power of the part of a segment that contains `t`: the length of its control
/// polygon times its mean width. Each segment has `parts` equal parts; `[segment, count]` is its place in the curve.
fn light_area(points: &[DVec3], t: f64, parts: u32, [segment, count]: [usize; 2], widths: [f64; 2]) -> f64 {
    let cubic = match *points {
        [a, b, c] => [a, a.lerp(b, 2.0 / 3.0), c.lerp(b, 2.0 / 3.0), c],
        [a, b, c, d] => [a, b, c, d],
        _ => return 1.0,
    };
    let n = f64::from(parts);
    let part = (t * n).floor().min(n - 1.0);
    let [from, to] = [part / n, (part + 1.0) / n];
    // The blossom of the segment at three parameters.
    let at = |t: [f64; 3]| {
        let [a, b, c, d] = cubic;
        let [e, f, g] = [a.lerp(b, t[0]), b.lerp(c, t[0]), c.lerp(d, t[0])];
        e.lerp(f, t[1]).lerp(f.lerp(g, t[1]), t[2])
    };
    let polygon = [at([from; 3]), at([from, from, to]), at([from, to, to]), at([to; 3])];
    let length: f64 = polygon.windows(2).map(|w| (w[1] - w[0]).length()).sum();
    let middle = (segment as f64 + 0.5 * (from + to)) / count.max(1) as f64;
    length * (widths[0] + (widths[1] - widths[0]) * middle)
}

/// The Bézier points of one span of a uniform B-spline of degree 2 or 3.
fn bezier_of_spline(p: &[DVec3]) -> Vec<DVec3> {
    match *p {
        [a, b, c, d] => {
            vec![(a + 4.0 * b + c) / 6.0, (2.0 * b + c) / 3.0, (b + 2.0 * c) / 3.0, (b + 4.0 * c + d) / 6.0]
        }
        [a, b, c] => vec![(a + b) / 2.0, b, (b + c) / 2.0],
        _ => p.to_vec(),
    }
}

/// Position and direction on a Bézier curve (de Casteljau).
fn at(points: &[DVec3], t: f64) -> (DVec3, DVec3) {
    let mut level = points.to_vec();
    let mut direction = DVec3::ZERO;
    while level.len() > 1 {
        if let [a, b] = level[..] {
            direction = b - a;
        }
        level = level.windows(2).map(|w| w[0].lerp(w[1], t)).collect();
    }
    (level.first().copied().unwrap_or_default(), direction)
}

/// Steps for a segment, by the angle that its control polygon turns.
fn steps(points: &[DVec3]) -> u32 {
    let edges: Vec<DVec3> = points.windows(2).filter_map(|w| (w[1] - w[0]).try_normalize()).collect();
    let turned: f64 = edges.windows(2).map(|e| acos(e[0].dot(e[1]).clamp(-1.0, 1.0)).to_degrees()).sum();
    ((turned / TURN).ceil() as u32).clamp(*STEPS.start(), *STEPS.end())
}

fn sweep(segments: &[Vec<DVec3>], widths: [f64; 2], normals: Option<&[DVec3]>, across: u32) -> MeshData {
    let mut data = MeshData::default();
    let single = |v: DVec3| v.as_vec3().to_array();
    // The frame is carried along with little twist.
    let mut side = DVec3::ZERO;
    let mut forward = DVec3::Z;
    for (segment, t) in rows_of(segments) {
        let Some(points) = segments.get(segment) else { break };
        let (p, d) = at(points, t);
        forward = d.try_normalize().unwrap_or(forward);
        side = (side - forward * side.dot(forward))
            .try_normalize()
            .unwrap_or_else(|| forward.any_orthonormal_vector());
        let v = (segment as f64 + t) / segments.len() as f64;
        let radius = 0.5 * (widths[0] + (widths[1] - widths[0]) * v);
        match normals {
            Some(normals) => {
                let (a, b) = (normals.get(segment), normals.get(segment + 1));
                let normal = match (a, b) {
                    (Some(a), Some(b)) => a.lerp(*b, t),
                    (Some(a), None) => *a,
                    _ => side,
                };
                let out = normal.cross(forward).normalize_or(side);
                for (u, sign) in [(0.0, 1.0), (1.0, -1.0)] {
                    data.positions.push(single(p + out * (sign * radius)));
                    data.normals.push(single(normal.normalize_or(DVec3::Z)));
                    data.uvs.push([u, v as f32]);
                }
            }
            None => {
                let up = forward.cross(side);
                for i in 0..across {
                    let (s, c) = sin_cos_turns(f64::from(i) / f64::from(across));
                    let out = side * c + up * s;
                    data.positions.push(single(p + out * radius));
                    data.normals.push(single(out));
                    data.uvs.push([(f64::from(i) / f64::from(across)) as f32, v as f32]);
                }
            }
        }
    }
    let closed = normals.is_none();
    let sides = if closed { across } else { across - 1 };
    let rows = data.positions.len() as u32 / across;
    for row in 1..rows {
        for i in 0..sides {
            let j = (i + 1) % across;
            let (a, b) = ((row - 1) * across + i, (row - 1) * across + j);
            let (c, d) = (row * across + i, row * across + j);
            data.triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    data
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_follow_the_turning() {
        let straight: Vec<DVec3> = (0..4).map(|i| DVec3::X * f64::from(i)).collect();
        assert_eq!(steps(&straight), 2);
        // Half a turn, along three sides of a square.
        let half = [DVec3::ZERO, DVec3::Y, DVec3::new(1.0, 1.0, 0.0), DVec3::X];
        assert_eq!(steps(&half), 30);
        assert_eq!(steps(&[DVec3::ZERO; 4]), 2);
        // The direction turns little from one step to the next.
        let data = sweep(&[half.to_vec()], [0.01, 0.01], None, SIDES);
        let middle = |row: usize| {
            let ring = &data.positions[row * SIDES as usize..][..SIDES as usize];
            ring.iter().map(|p| DVec3::from(p.map(f64::from))).sum::<DVec3>() / f64::from(SIDES)
        };
        let rows = data.positions.len() / SIDES as usize;
        let edges: Vec<DVec3> = (1..rows).map(|r| (middle(r) - middle(r - 1)).normalize()).collect();
        let sharpest =
            edges.windows(2).map(|e| acos(e[0].dot(e[1]).min(1.0)).to_degrees()).fold(0.0, f64::max);
        assert!(sharpest < 2.0 * TURN, "{sharpest}");
    }
}
