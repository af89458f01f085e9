//! Emission from shapes: points on emissive shapes, sampled by solid angle if the shape is near and by area if it is
//! far.
//!
//! Next-event estimation needs a point q on the emitter and the pdf of the direction to it, per solid angle at the
//! lit point p. Uniform sampling by area has pdf = d² / (area · |cos θ|), which varies strongly over a near emitter
//! and makes noise. Sampling uniformly by solid angle has the constant pdf 1 / Ω:
//!
//! ```text
//!             n  q             area sampling:        pdf(ω) = d² / (A · |cos θ|)
//!    ---------\--*-------      solid-angle sampling: pdf(ω) = 1 / Ω
//!           θ  \/
//!              / d             both integrate to 1 over the directions
//!             /                of the emitter seen from p
//!            p
//! ```
//!
//! Every emitter has `sample` and `pdf`, which agree for every point, so that MIS weights are exact. Methods:
//! rectangles, Ureña et al. 2013; triangles, Arvo 1995; spheres, their cone (Shirley et al. 1996); other shapes by
//! area. [`Curved`] shapes and [`EllipsoidEmitter`] are sampled in object space and their densities transformed.

mod block;
mod disk;
mod placed;
mod rectangle;
mod sphere;
mod triangle;

pub use block::EmitterBlock;
pub use disk::DiskEmitter;
pub use placed::{Curved, CurvedEmitter, EllipsoidEmitter};
pub use rectangle::RectangleEmitter;
pub use sphere::SphereEmitter;
pub use triangle::{TriangleBlock, TriangleEmitter};

use crate::math::DVec3;

/// A point on an emitter, as seen from a lit point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmitterSample {
    /// The point, in world space.
    pub q: DVec3,
    /// The outward normal there, unit.
    pub n: DVec3,
    /// First coordinate on the part: the weight of a triangle's second corner, or the position along a rectangle's
    /// first edge.
    pub u: f64,
    /// Second coordinate on the part.
    pub v: f64,
    /// Probability density per solid angle at the lit point.
    pub pdf: f64,
}

/// Shapes are sampled by solid angle if their squared size is more than this fraction of their squared distance.
/// Farther away the two pdfs hardly differ, and area sampling is cheaper and loses no digits.
const NEAR: f64 = 0.25;

/// Most that a flat shape is sampled by solid angle. From a point on it, rounding decides whether it fills the hemisphere
/// above, which would let it light itself; sampled by area, the cosine to its points is 0.
const MAX_SOLID_ANGLE: f64 = std::f64::consts::TAU - 1e-6;

/// Converts a pdf per area to one per solid angle; `None` for surfaces seen edge-on.
#[inline]
fn per_solid_angle(per_area: f64, p: DVec3, q: DVec3, n: DVec3) -> Option<f64> {
    let d = q - p;
    let d2 = d.length_squared();
    let cosine = d.dot(n).abs() / d2.sqrt();
    let pdf = per_area * d2 / cosine;
    (pdf > 0.0 && pdf < f64::INFINITY).then_some(pdf)
}

#[cfg(test)]
mod placed_tests;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::{OwenSobol, SampleId};

    fn random_pair(i: u32) -> [f64; 2] {
        OwenSobol::new(&SampleId { x: 5, y: 1, index: i, seed: 3 }).two(0)
    }

    /// The mean of 1/pdf is the solid angle; the mean of cosine/pdf over a plane is the form factor times π. Both are
    /// compared with sums over the area, and `pdf` with `sample`.
    pub(super) fn check(
        sample: &dyn Fn(DVec3, [f64; 2]) -> Option<EmitterSample>,
        pdf: &dyn Fn(DVec3, DVec3, DVec3) -> f64,
        points: &[DVec3],
        area_points: &[(DVec3, DVec3, f64)],
        faces_away: bool,
    ) {
        for &p in points {
            let n = 4096;
            let (mut solid, mut cosine_weighted) = (0.0, 0.0);
            for i in 0..n {
                let Some(s) = sample(p, random_pair(i)) else { continue };
                let w = (s.q - p).normalize();
                let again = pdf(p, s.q, s.n);
                assert!((again / s.pdf - 1.0).abs() < 1e-6, "{p}: {} and {again}", s.pdf);
                if faces_away && w.dot(s.n) > 0.0 {
                    continue;
                }
                solid += 1.0 / s.pdf;
                cosine_weighted += w.y.max(0.0) / s.pdf;
            }
            let (solid, cosine_weighted) = (solid / f64::from(n), cosine_weighted / f64::from(n));
            let (mut solid_by_area, mut cosine_weighted_by_area) = (0.0, 0.0);
            for &(q, normal, area) in area_points {
                let d = q - p;
                let cosine = -d.dot(normal) / d.length();
                if faces_away && cosine < 0.0 {
                    continue;
                }
                let part = area * cosine.abs() / d.length_squared();
                solid_by_area += part;
                cosine_weighted_by_area += part * (d.y / d.length()).max(0.0);
            }
            assert!((solid / solid_by_area - 1.0).abs() < 0.01, "{p}: {solid} and {solid_by_area}");
            assert!(
                (cosine_weighted - cosine_weighted_by_area).abs() < 0.01 * (cosine_weighted_by_area + 0.01),
                "{p}: {cosine_weighted} and {cosine_weighted_by_area}"
            );
        }
    }

    pub(super) const POINTS: [DVec3; 6] = [
        DVec3::new(0.3, -1.0, 0.2),
        DVec3::new(0.3, -0.15, 0.2),
        DVec3::new(4.0, -3.0, 1.0),
        DVec3::new(0.0, 5.0, -2.0),
        DVec3::new(-2.0, -0.3, 0.1),
        DVec3::new(30.0, -40.0, 10.0),
    ];

    #[test]
    fn rectangles() {
        let (corner, u, v) = (DVec3::new(-1.0, 0.0, -0.5), DVec3::X * 2.0, DVec3::Z);
        for (u, v) in [(u, v), (v, u), (u, v + 0.4 * u)] {
            let r = RectangleEmitter::new(corner, u, v, 1.0).unwrap();
            let n = 200;
            let grid: Vec<_> = (0..n * n)
                .map(|i| {
                    let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n);
                    let area = u.cross(v).length() / f64::from(n * n);
                    (corner + at(i % n) * u + at(i / n) * v, u.cross(v).normalize(), area)
                })
                .collect();
            check(&|p, u| r.sample(p, u), &|p, q, _| r.pdf(p, q), &POINTS, &grid, false);
            let s = r.sample(POINTS[1], [0.2, 0.7]).unwrap();
            assert!((corner + s.u * u + s.v * v - s.q).length() < 1e-9);
        }
    }

    #[test]
    fn flat_shapes_do_not_light_themselves() {
        let [a, b, c] = [DVec3::new(-1.0, 0.3, -0.5), DVec3::new(1.0, 0.4, -0.2), DVec3::new(0.2, 0.1, 1.0)];
        let up = (c - a).reject_from(b - a);
        let rectangle = RectangleEmitter::new(a, b - a, up, 1.0).unwrap();
        let triangle = TriangleEmitter::new([a, b, c], 1.0).unwrap();
        let mut checked = 0;
        for i in 0..300 {
            let (at, u) = (random_pair(i), random_pair(1000 + i));
            // Points on the shapes, with the rounding of their computation.
            let on_rectangle = a + at[0] * (b - a) + at[1] * up;
            let on_triangle = a + at[0] * (b - a) + at[1] * (1.0 - at[0]) * (c - a);
            for (p, s) in [
                (on_rectangle, rectangle.sample(on_rectangle, u)),
                (on_triangle, triangle.sample(on_triangle, u)),
            ] {
                let Some(s) = s else { continue };
                assert!((s.q - p).normalize().dot(s.n).abs() / s.pdf < 1e-9, "{p}: {s:?}");
                checked += 1;
            }
        }
        assert!(checked > 100, "{checked}");
    }

    #[test]
    fn triangles() {
        let [a, b, c] = [DVec3::new(-1.0, 0.0, -0.5), DVec3::new(1.0, 0.1, 0.0), DVec3::new(0.2, 0.0, 1.0)];
        let t = TriangleEmitter::new([a, b, c], 1.0).unwrap();
        let n = 300;
        let mut grid = Vec::new();
        for i in 0..n {
            for j in 0..n {
                let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n);
                if at(i) + at(j) < 1.0 {
                    let area = (b - a).cross(c - a).length() / f64::from(n * n);
                    grid.push((a + at(i) * (b - a) + at(j) * (c - a), t.normal(), area));
                }
            }
        }
        // Cells on the diagonal count half.
        let total: f64 = grid.iter().map(|g| g.2).sum();
        let exact = 0.5 * (b - a).cross(c - a).length();
        grid.iter_mut().for_each(|g| g.2 *= exact / total);
        check(&|p, u| t.sample(p, u), &|p, q, _| t.pdf(p, q), &POINTS, &grid, false);
        let s = t.sample(POINTS[1], [0.2, 0.7]).unwrap();
        assert!((a + s.u * (b - a) + s.v * (c - a) - s.q).length() < 1e-9 && s.u >= 0.0 && s.u + s.v <= 1.0);
    }

    #[test]
    fn disks_and_rings() {
        for inner in [0.0, 0.5] {
            let d = DiskEmitter::new(DVec3::ZERO, DVec3::X, DVec3::Z * 0.7, inner).unwrap();
            let n = 400;
            let mut grid = Vec::new();
            for i in 0..n * n {
                let at = |i: i32| 2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0;
                let (x, y) = (at(i % n), at(i / n));
                if (inner * inner..1.0).contains(&(x * x + y * y)) {
                    grid.push((DVec3::new(x, 0.0, 0.7 * y), DVec3::Y, 0.7 * 4.0 / f64::from(n * n)));
                }
            }
            check(&|p, u| d.sample(p, u), &|p, q, _| d.pdf(p, q), &POINTS, &grid, false);
        }
    }

    #[test]
    fn spheres() {
        let s = SphereEmitter { center: DVec3::new(0.0, 1.0, 0.0), radius: 1.1 };
        let n = 400;
        let mut grid = Vec::new();
        for i in 0..n {
            for j in 0..n {
                let z = 2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0;
                let (sin, cos) = crate::math::elementary::sin_cos(
                    std::f64::consts::TAU * (f64::from(j) + 0.5) / f64::from(n),
                );
                let r = (1.0 - z * z).sqrt();
                let normal = DVec3::new(r * cos, z, r * sin);
                let area = 4.0 * std::f64::consts::PI * s.radius * s.radius / f64::from(n * n);
                grid.push((s.center + s.radius * normal, normal, area));
            }
        }
        let outside = [POINTS[0], POINTS[2], POINTS[3], POINTS[4], POINTS[5]];
        check(&|p, u| s.sample(p, u), &|p, q, n| s.pdf(p, q, n), &outside, &grid, true);
        // From inside, the complete sphere is visible.
        let inside = [DVec3::new(0.2, 1.3, 0.1)];
        check(&|p, u| s.sample(p, u), &|p, q, n| s.pdf(p, q, n), &inside, &grid, false);
    }

    #[test]
    fn shapes_without_area_are_refused() {
        assert!(RectangleEmitter::new(DVec3::ZERO, DVec3::X, DVec3::X, 1.0).is_none());
        assert!(TriangleEmitter::new([DVec3::ZERO, DVec3::X, 2.0 * DVec3::X], 1.0).is_none());
        assert!(DiskEmitter::new(DVec3::ZERO, DVec3::X, DVec3::ZERO, 0.0).is_none());
    }
}
