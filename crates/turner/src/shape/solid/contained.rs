//! Surfaces f(x, y, z) = 0 in a box. With `capped`, the faces of the box close the solid where f is negative there.

use super::SolidGeometry;
use super::line::{Line, face_normal};
use crate::math::{Bounds, DVec2, DVec3, Ray};
use crate::schema::{ErrorCode, SceneError};
use crate::shape::{ROUNDING, ShapeHit, Sphere, SurfacePoint};

/// A function in space; its surface is where it is 0, and its inside where it is negative.
pub(super) trait Field {
    /// The value.
    fn value(&self, p: DVec3) -> f64;

    /// The value and its gradient.
    fn gradient(&self, p: DVec3) -> (f64, DVec3);

    /// Calls `visit` with the positions between `line.enter` and `line.exit` where the sign changes, in order, until it
    /// returns true. Positions before `from` may be left out. What is found must not depend on `from` otherwise.
    fn crossings(&self, line: &Line, from: f64, visit: impl FnMut(f64) -> bool);

    /// Bound on the distance of computed roots from the surface, per unit of the size of the box.
    fn precision(&self) -> f64;

    /// Bytes beyond its own size.
    fn memory(&self) -> usize;

    /// The time of a ray in simple intersection tests.
    fn tests_per_ray(&self) -> f64;
}

/// The box, and whether its faces belong to the solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Container {
    pub(super) bounds: Bounds,
    pub(super) capped: bool,
}

impl Container {
    /// Errors: an empty box.
    pub(super) fn new(min: DVec3, max: DVec3, capped: bool, word: &str) -> Result<Container, SceneError> {
        if min.cmplt(max).all() && min.is_finite() && max.is_finite() {
            return Ok(Container { bounds: Bounds::new(min, max), capped });
        }
        let message =
            format!("each coordinate of `min` of a {word} must be less than that of `max`: {min}, {max}");
        Err(SceneError::new(ErrorCode::OutOfRange, message).help("exchange the two"))
    }

    /// The nearest hit. Parts: 0 is the surface, 1 to 6 are the faces of the box.
    pub(super) fn intersect(&self, field: &impl Field, ray: &Ray) -> Option<ShapeHit> {
        let line = Line::new(ray, &self.bounds)?;
        let hit = |s: f64, part: u32| {
            let t = line.t(s);
            ray.contains(t).then_some(ShapeHit { t, part, u: 0.0, v: 0.0 })
        };
        let face = |end: usize, s: f64| {
            let closed = self.capped && field.value(line.at(s)) < 0.0;
            if closed { hit(s, 1 + line.faces[end]) } else { None }
        };
        if line.t(line.exit) < ray.t_min || line.t(line.enter) > ray.t_max {
            return None;
        }
        if let Some(found) = face(0, line.enter) {
            return Some(found);
        }
        let mut found = None;
        field.crossings(&line, line.before(ray.t_min), |s| {
            found = hit(s, 0);
            line.t(s) >= ray.t_min
        });
        found.or_else(|| face(1, line.exit))
    }

    /// The surface at a hit.
    pub(super) fn surface(&self, field: &impl Field, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        let size = self.bounds.size().max_element();
        let mut p = ray.at(hit.t);
        let far = size + p.abs().max_element();
        if hit.part > 0 {
            let face = hit.part - 1;
            let axis = (face / 2 % 3) as usize;
            p[axis] = if face % 2 == 1 { self.bounds.max[axis] } else { self.bounds.min[axis] };
            let n = face_normal(face);
            return SurfacePoint { p, error: ROUNDING * far, ng: n, ns: n };
        }
        for _ in 0..2 {
            let (value, gradient) = field.gradient(p);
            let step = value * gradient / gradient.length_squared();
            // Newton's steps are small: the point is on the surface but for rounding. NaN is not.
            p -= if step.length() < 1e-6 * size { step } else { DVec3::ZERO };
        }
        let (value, gradient) = field.gradient(p);
        let n = gradient.try_normalize().unwrap_or(-ray.direction.normalize());
        let left = (4.0 * value.abs() / gradient.length()).min(1e-6 * size);
        let left = if left.is_nan() { 1e-6 * size } else { left };
        SurfacePoint { p, error: left + field.precision() * far, ng: n, ns: n }
    }
}

/// A function in its box.
#[derive(Clone, Debug)]
pub struct Contained<F> {
    pub(super) field: F,
    pub(super) container: Container,
}

impl<F: Field> SolidGeometry for Contained<F> {
    fn bounds(&self) -> Option<Bounds> {
        Some(self.container.bounds)
    }

    fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        self.container.intersect(&self.field, ray)
    }

    fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        self.container.surface(&self.field, ray, hit)
    }

    /// Those of a sphere around the centre of the box.
    fn uv(&self, _: &ShapeHit, point: &SurfacePoint) -> DVec2 {
        Sphere::uv((point.p - self.container.bounds.center()).normalize_or(DVec3::Y))
    }

    fn curvature(&self, _: &ShapeHit) -> f64 {
        2.0 / self.container.bounds.size().max_element()
    }

    fn is_closed(&self) -> bool {
        self.container.capped
    }

    fn memory(&self) -> usize {
        self.field.memory()
    }

    fn tests_per_ray(&self) -> f64 {
        self.field.tests_per_ray()
    }
}
