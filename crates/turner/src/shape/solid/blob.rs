//! Blobs, or metaballs: surfaces where a sum of densities has a threshold (Blinn 1982; densities of Wyvill 1986 in the
//! form of POV-Ray).
//!
//! The density of a component is strength · (1 − r²/R²)² within its radius R, with r the distance to a point or to a
//! segment. Along a ray r² is quadratic, so between the ends of components the sum is a polynomial of degree 4.

use super::line::Line;
use super::roots::{roots_with_signs, value};
use super::{PrepareSolid, Solid, SolidGeometry};
use crate::math::{Bounds, DVec2, DVec3, Ray};
use crate::schema::{ErrorCode, Range, SceneError, params};
use crate::shape::{MeshCache, ShapeHit, Sphere, SurfacePoint};

params! {
    /// A blob (metaballs): soft spheres and capsules that flow into one another. The density of a component falls from
    /// its strength at the centre to 0 at its radius as strength · (1 − distance²/radius²)²; the surface is where the
    /// sum of all densities equals `threshold`. Negative strengths push the surface away. (u, v) are those of a sphere
    /// around the centre of the bounding box.
    pub struct BlobDesc as "blob" {
        /// Spheres: [[x, y, z, radius, strength], …]; [] if there are capsules only.
        spheres: Vec<[f64; 5]>, required, default vec![[-0.6, 0.0, 0.0, 1.1, 1.0], [0.6, 0.0, 0.0, 1.1, 1.0]];
        /// Capsules along a segment: [[x, y, z, to_x, to_y, to_z, radius, strength], …].
        capsules: Vec<[f64; 8]> = Vec::new();
        /// The density at the surface.
        threshold: f64 = 0.5, in Range::POSITIVE;
    }
    example r#"[[object]]
type = "blob"
threshold = 0.6
spheres = [[-0.7, 0, 0, 1.2, 1], [0.7, 0, 0, 1.2, 1], [0, 0.9, 0, 1, 1]]
material = { color = "orchid" }
"#
}

/// Most components: their spans lie on the stack.
const MAX_COMPONENTS: usize = 64;
/// Spans of a component along a line: before, along and behind its segment.
const SPANS: usize = 3;

/// A sphere or capsule.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Component {
    from: DVec3,
    /// Unit direction and length of the segment; 0 for a sphere.
    axis: DVec3,
    length: f64,
    radius: f64,
    strength: f64,
}

/// A part of a line with a polynomial of degree 4.
#[derive(Clone, Copy, Debug, Default)]
struct Span {
    from: f64,
    to: f64,
    coefficients: [f64; 5],
}

/// A blob.
#[derive(Clone, Debug)]
pub struct Blob {
    components: Vec<Component>,
    threshold: f64,
    bounds: Bounds,
}

impl PrepareSolid for BlobDesc {
    fn prepare_solid(&self, _: &mut MeshCache<'_>) -> Result<Solid, SceneError> {
        let mut components = Vec::new();
        for [x, y, z, radius, strength] in &self.spheres {
            let from = DVec3::new(*x, *y, *z);
            components.push(Component {
                from,
                axis: DVec3::ZERO,
                length: 0.0,
                radius: *radius,
                strength: *strength,
            });
        }
        for [x, y, z, to_x, to_y, to_z, radius, strength] in &self.capsules {
            let (from, to) = (DVec3::new(*x, *y, *z), DVec3::new(*to_x, *to_y, *to_z));
            let axis = (to - from).normalize_or_zero();
            let length = if axis == DVec3::ZERO { 0.0 } else { from.distance(to) };
            components.push(Component { from, axis, length, radius: *radius, strength: *strength });
        }
        let count = components.len();
        if count == 0 || count > MAX_COMPONENTS {
            let message = format!("a blob has {count} components; expected 1 to {MAX_COMPONENTS}");
            return Err(SceneError::new(ErrorCode::OutOfRange, message)
                .help("add spheres [x, y, z, radius, strength], or split it into several objects"));
        }
        if let Some(bad) = components.iter().find(|c| !(c.radius > 0.0)) {
            let message = format!("the radius of a component must be greater than 0, found {}", bad.radius);
            return Err(SceneError::new(ErrorCode::OutOfRange, message));
        }
        let attracting = components.iter().filter(|c| c.strength > 0.0);
        let bounds = attracting.fold(Bounds::EMPTY, |all, c| all.union(&c.bounds()));
        Ok(Solid::Blob(Blob { components, threshold: self.threshold, bounds }))
    }
}

impl Component {
    fn bounds(&self) -> Bounds {
        let to = self.from + self.length * self.axis;
        Bounds::new(self.from.min(to) - self.radius, self.from.max(to) + self.radius)
    }

    /// The point of its segment nearest to `p`.
    fn nearest(&self, p: DVec3) -> DVec3 {
        self.from + (p - self.from).dot(self.axis).clamp(0.0, self.length) * self.axis
    }

    /// Calls `add` with the spans of a line in which it has density.
    fn spans(&self, line: &Line, mut add: impl FnMut(Span)) {
        let m = line.origin - self.from;
        let (mz, dz) = (m.dot(self.axis), line.direction.dot(self.axis));
        let end = m - self.length * self.axis;
        let ball = |m: DVec3| [m.length_squared(), 2.0 * m.dot(line.direction), 1.0];
        let (off, along) = (m - mz * self.axis, line.direction - dz * self.axis);
        let tube = [off.length_squared(), 2.0 * off.dot(along), along.length_squared()];
        // Where the line passes the planes through the ends of the segment.
        let infinite = f64::INFINITY;
        let pass = |z: f64| if dz == 0.0 { if mz < z { infinite } else { -infinite } } else { (z - mz) / dz };
        let (a, b) = (pass(0.0), pass(self.length));
        if self.length == 0.0 {
            self.span(ball(m), -infinite, infinite, &mut add);
        } else if dz > 0.0 {
            self.span(ball(m), -infinite, a, &mut add);
            self.span(tube, a, b, &mut add);
            self.span(ball(end), b, infinite, &mut add);
        } else if dz < 0.0 {
            self.span(ball(end), -infinite, b, &mut add);
            self.span(tube, b, a, &mut add);
            self.span(ball(m), a, infinite, &mut add);
        } else if mz < 0.0 {
            self.span(ball(m), -infinite, infinite, &mut add);
        } else {
            let squared = if mz > self.length { ball(end) } else { tube };
            self.span(squared, -infinite, infinite, &mut add);
        }
    }

    /// The span between `from` and `to` where the squared distance c0 + c1 s + c2 s² is below that of the radius.
    fn span(&self, [c0, c1, c2]: [f64; 3], from: f64, to: f64, add: &mut impl FnMut(Span)) {
        let limit = self.radius * self.radius;
        let (mut from, mut to) = (from, to);
        if c2 > 0.0 {
            let discriminant = c1 * c1 - 4.0 * c2 * (c0 - limit);
            if !(discriminant > 0.0) {
                return;
            }
            let root = discriminant.sqrt();
            (from, to) = (from.max((-c1 - root) / (2.0 * c2)), to.min((-c1 + root) / (2.0 * c2)));
        } else if c0 >= limit {
            return;
        }
        if !(from < to) {
            return;
        }
        // strength · (1 − q)² with q = squared distance / R².
        let q = [1.0 - c0 / limit, -c1 / limit, -c2 / limit];
        let s = self.strength;
        let coefficients = [
            s * q[0] * q[0],
            2.0 * s * q[0] * q[1],
            s * (2.0 * q[0] * q[2] + q[1] * q[1]),
            2.0 * s * q[1] * q[2],
            s * q[2] * q[2],
        ];
        add(Span { from, to, coefficients });
    }
}

impl Blob {
    /// Density above the threshold, with its gradient.
    fn at(&self, p: DVec3) -> (f64, DVec3) {
        let (mut density, mut gradient) = (-self.threshold, DVec3::ZERO);
        for c in &self.components {
            let away = p - c.nearest(p);
            let rest = 1.0 - away.length_squared() / (c.radius * c.radius);
            if rest > 0.0 {
                density += c.strength * rest * rest;
                gradient -= 4.0 * c.strength * rest / (c.radius * c.radius) * away;
            }
        }
        (density, gradient)
    }

    /// Calls `visit` with the crossings of a line in order until it returns true. `N` bounds the number of spans.
    fn crossings<const N: usize>(&self, line: &Line, mut visit: impl FnMut(f64) -> bool) {
        let (mut spans, mut count) = ([Span::default(); N], 0);
        for component in &self.components {
            component.spans(line, |span| {
                if let Some(slot) = spans.get_mut(count) {
                    *slot = Span { from: span.from.max(line.enter), to: span.to.min(line.exit), ..span };
                    count += usize::from(slot.from < slot.to);
                }
            });
        }
        let spans = &spans[..count];
        // From one end of a span to the next.
        let (mut at, mut below) = (line.enter, true);
        while at < line.exit {
            let ends = spans.iter().flat_map(|span| [span.from, span.to]);
            let next = ends.filter(|end| *end > at).fold(line.exit, f64::min);
            let mut sum = [-self.threshold, 0.0, 0.0, 0.0, 0.0];
            for span in spans.iter().filter(|span| span.from <= at && span.to >= next) {
                sum.iter_mut().zip(span.coefficients).for_each(|(sum, c)| *sum += c);
            }
            let end = value(&sum, next) < 0.0;
            // Neighbouring pieces agree on the sign between them: `below` is that of the piece before.
            for root in roots_with_signs(&sum, at, next, [below, end]).as_slice() {
                if visit(*root) {
                    return;
                }
            }
            (at, below) = (next, end);
        }
    }
}

impl SolidGeometry for Blob {
    fn bounds(&self) -> Option<Bounds> {
        Some(self.bounds)
    }

    fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let line = Line::new(ray, &self.bounds)?;
        let mut found = None;
        let visit = |s: f64| {
            let t = line.t(s);
            if ray.contains(t) {
                found = Some(ShapeHit { t, part: 0, u: 0.0, v: 0.0 });
            }
            t >= ray.t_min
        };
        if self.components.len() <= 8 {
            self.crossings::<{ 8 * SPANS }>(&line, visit);
        } else {
            self.crossings::<{ MAX_COMPONENTS * SPANS }>(&line, visit);
        }
        found
    }

    fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        let size = self.bounds.size().max_element();
        let mut p = ray.at(hit.t);
        for _ in 0..2 {
            let (value, gradient) = self.at(p);
            let step = value * gradient / gradient.length_squared();
            p -= if step.length() < 1e-3 * size { step } else { DVec3::ZERO };
        }
        let (value, gradient) = self.at(p);
        let steep = gradient.length().max(1e-6 * self.threshold / size);
        let total: f64 = self.components.iter().map(|c| c.strength.abs()).sum();
        let rounding = 1e-13 * (size + p.abs().max_element() + total / steep);
        let n = (-gradient).try_normalize().unwrap_or(-ray.direction.normalize());
        SurfacePoint { p, error: rounding + 4.0 * value.abs() / steep, ng: n, ns: n }
    }

    fn uv(&self, _: &ShapeHit, point: &SurfacePoint) -> DVec2 {
        Sphere::uv((point.p - self.bounds.center()).normalize_or(DVec3::Y))
    }

    fn curvature(&self, _: &ShapeHit) -> f64 {
        2.0 / self.bounds.size().max_element().max(1e-30)
    }

    fn memory(&self) -> usize {
        size_of_val(&self.components[..])
    }
}
