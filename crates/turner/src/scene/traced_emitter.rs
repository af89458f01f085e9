//! Emissive solids: directions are sampled uniformly in the cone of the bounding sphere, and a ray finds the point.
//!
//! ```text
//!             .--.
//!   p ──────(─→██ )     pdf = 1 / solid angle of the cone; directions that miss the solid contribute nothing
//!             `--'
//! ```
//!
//! Each direction has one visible point, so the pdf of a hit of a BSDF-sampled ray is that of its direction.

use std::f64::consts::{PI, TAU};

use crate::light::emission::EmitterSample;
use crate::math::elementary::sin_cos_turns;
use crate::math::{Bounds, DAffine3, DMat3, DVec3, Frame, Ray};
use crate::sampler::uniform_sphere;
use crate::schema::MaterialId;
use crate::shape::{Solid, SolidGeometry};

/// A solid with its transform and bounding sphere.
#[derive(Clone, Debug)]
pub(crate) struct TracedEmitter {
    to_object: DAffine3,
    /// For normals.
    to_world: DMat3,
    /// The bounding sphere in world space.
    center: DVec3,
    radius: f64,
    /// The least distance of a sampled point: nearer ones are the lit surface itself.
    least: f64,
}

/// The mean over the parts of a solid that may have materials of their own; `of` is given `None` for that of the object.
pub(crate) fn mean_of_parts(solid: &Solid, of: impl Fn(Option<MaterialId>) -> f64) -> f64 {
    match solid.materials() {
        [] => of(None),
        parts => parts.iter().map(|own| of(*own)).sum::<f64>() / parts.len() as f64,
    }
}

impl TracedEmitter {
    /// `None` for degenerate bounds.
    pub(crate) fn new(bounds: &Bounds, to_world: &DAffine3) -> Option<TracedEmitter> {
        let corners = bounds.corners().map(|p| to_world.transform_point3(p));
        let center = corners.iter().sum::<DVec3>() / 8.0;
        let radius = corners.iter().map(|p| p.distance(center)).fold(0.0, f64::max) * (1.0 + 1e-9);
        let to_object = to_world.inverse();
        let valid = radius > 0.0 && radius.is_finite() && to_object.is_finite();
        valid.then(|| TracedEmitter {
            to_object,
            to_world: to_object.matrix3.transpose(),
            center,
            radius,
            least: 1e-9 * (radius + center.abs().max_element()),
        })
    }

    /// 1 − cos of half the angle of the cone from `p`; `None` inside the bounding sphere.
    fn cap(&self, p: DVec3) -> Option<f64> {
        let sin2 = self.radius * self.radius / p.distance_squared(self.center);
        (sin2 < 1.0 - 1e-9).then(|| sin2 / (1.0 + (1.0 - sin2).sqrt()))
    }

    /// The point that `u` chooses, with its part; `None` where the direction misses the solid.
    pub(crate) fn sample(&self, solid: &Solid, p: DVec3, u: [f64; 2]) -> Option<(EmitterSample, u32)> {
        let (direction, pdf) = match self.cap(p) {
            Some(cap) => {
                let x = u[0] * cap;
                let (cos, sin) = (1.0 - x, (x * (2.0 - x)).sqrt());
                let (s, c) = sin_cos_turns(u[1]);
                let local = DVec3::new(sin * c, sin * s, cos);
                let axis = (self.center - p).try_normalize()?;
                (Frame::from_z(axis).to_world(local), 1.0 / (TAU * cap))
            }
            None => (uniform_sphere(u.into()), 1.0 / (4.0 * PI)),
        };
        let ray = Ray { t_min: self.least, ..Ray::new(p, direction) }.transformed(&self.to_object);
        let hit = solid.intersect(&ray)?;
        let surface = solid.surface(&ray, &hit);
        let n = (self.to_world * surface.ng).try_normalize()?;
        Some((EmitterSample { q: p + hit.t * direction, n, u: hit.u, v: hit.v, pdf }, hit.part))
    }

    /// The pdf of a direction from `p` that hits the solid.
    pub(crate) fn pdf(&self, p: DVec3) -> f64 {
        match self.cap(p) {
            Some(cap) => 1.0 / (TAU * cap),
            None => 1.0 / (4.0 * PI),
        }
    }

    /// An estimate of the area: that of the bounding sphere.
    pub(crate) fn area(&self) -> f64 {
        4.0 * PI * self.radius * self.radius
    }
}
