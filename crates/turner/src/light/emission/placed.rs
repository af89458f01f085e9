//! Emissive curved shapes under any invertible transform.

use super::{EmitterSample, SphereEmitter, per_solid_angle};
use crate::math::{DAffine3, DMat3, DVec3};
use crate::shape::{AreaPoint, Cone, Cylinder, Torus};

/// The transform between object space and world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placement {
    to_world: DAffine3,
    to_object: DAffine3,
    /// Normals transform by the inverse transpose; back by the transpose.
    normal: DMat3,
    /// The scale factor of volumes, |det M|.
    volume: f64,
}

impl Placement {
    /// `None` for a singular transform.
    pub(super) fn new(to_world: DAffine3) -> Option<Placement> {
        let to_object = to_world.inverse();
        let volume = to_world.matrix3.determinant().abs();
        let normal = to_object.matrix3.transpose();
        let valid = to_world.is_finite() && to_object.is_finite() && volume > 0.0 && volume < f64::INFINITY;
        valid.then_some(Placement { to_world, to_object, normal, volume })
    }

    /// The scale factor of areas with the world-space normal `n`: |det M| |M⁻ᵀ n₀|; Mᵀn has the inverse of that
    /// length.
    fn area(&self, n: DVec3) -> f64 {
        self.volume / (self.to_world.matrix3.transpose() * n).length()
    }

    /// The scale factor of areas averaged over all normals: the root of the mean square.
    fn mean_area(&self) -> f64 {
        let m = self.normal;
        let squares = m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared();
        self.volume * (squares / 3.0).sqrt()
    }

    /// The scale factor of solid angles around a point in the unit world-space direction `w`.
    fn solid_angle(&self, w: DVec3) -> f64 {
        let length = (self.to_object.matrix3 * w).length();
        self.volume * length * length * length
    }
}

/// A sphere under a transform, possibly an ellipsoid: the cone of the sphere is sampled uniformly in object space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EllipsoidEmitter {
    sphere: SphereEmitter,
    placement: Placement,
}

impl EllipsoidEmitter {
    /// A sphere in object space and its transform; `None` for a singular transform.
    pub fn new(sphere: SphereEmitter, to_world: DAffine3) -> Option<EllipsoidEmitter> {
        Some(EllipsoidEmitter { sphere, placement: Placement::new(to_world)? })
    }

    /// Another sphere with the same transform.
    pub fn with(&self, sphere: SphereEmitter) -> EllipsoidEmitter {
        EllipsoidEmitter { sphere, ..*self }
    }

    /// The point that `u` chooses, seen from `p`.
    pub fn sample(&self, p: DVec3, u: [f64; 2]) -> Option<EmitterSample> {
        let placement = &self.placement;
        let s = self.sphere.sample(placement.to_object.transform_point3(p), u)?;
        let q = placement.to_world.transform_point3(s.q);
        let n = (placement.normal * s.n).try_normalize()?;
        let w = (q - p).try_normalize()?;
        let pdf = s.pdf / placement.solid_angle(w);
        (pdf > 0.0 && pdf < f64::INFINITY).then_some(EmitterSample { q, n, pdf, ..s })
    }

    /// The pdf of the direction from `p` to the point `q` on it, where the normal is `n`.
    pub fn pdf(&self, p: DVec3, q: DVec3, n: DVec3) -> f64 {
        let placement = &self.placement;
        let back = |v: DVec3| placement.to_object.transform_point3(v);
        let (Some(n), Some(w)) =
            ((placement.to_world.matrix3.transpose() * n).try_normalize(), (q - p).try_normalize())
        else {
            return 0.0;
        };
        let pdf = self.sphere.pdf(back(p), back(q), n) / placement.solid_angle(w);
        if pdf > 0.0 && pdf < f64::INFINITY { pdf } else { 0.0 }
    }

    /// Its approximate area.
    pub fn area(&self) -> f64 {
        self.sphere.area() * self.placement.mean_area()
    }
}

/// A shape sampled uniformly by area in object space.
#[derive(Clone, Copy, Debug)]
pub enum Curved {
    /// Cylinder.
    Cylinder(Cylinder),
    /// Cone.
    Cone(Cone),
    /// Torus.
    Torus(Torus),
}

impl Curved {
    fn area(&self) -> f64 {
        match self {
            Curved::Cylinder(s) => s.area(),
            Curved::Cone(s) => s.area(),
            Curved::Torus(s) => s.area(),
        }
    }

    fn point(&self, u: [f64; 2]) -> AreaPoint {
        match self {
            Curved::Cylinder(s) => s.point_by_area(u),
            Curved::Cone(s) => s.point_by_area(u),
            Curved::Torus(s) => s.point_by_area(u),
        }
    }
}

/// A cylinder, cone or torus, sampled by area in object space.
#[derive(Clone, Copy, Debug)]
pub struct CurvedEmitter {
    shape: Curved,
    placement: Placement,
    /// Pdf per area in object space.
    per_area: f64,
}

impl CurvedEmitter {
    /// A shape in object space and its transform; `None` without area and for a singular transform.
    pub fn new(shape: Curved, to_world: DAffine3) -> Option<CurvedEmitter> {
        let per_area = 1.0 / shape.area();
        let valid = per_area > 0.0 && per_area < f64::INFINITY;
        let placement = Placement::new(to_world)?;
        valid.then_some(CurvedEmitter { shape, placement, per_area })
    }

    /// The point that `u` chooses, seen from `p`, and the part that it is on.
    pub fn sample(&self, p: DVec3, u: [f64; 2]) -> Option<(EmitterSample, u32)> {
        let at = self.shape.point(u);
        let q = self.placement.to_world.transform_point3(at.p);
        let n = (self.placement.normal * at.n).try_normalize()?;
        let pdf = per_solid_angle(self.per_area / self.placement.area(n), p, q, n)?;
        Some((EmitterSample { q, n, u: 0.0, v: 0.0, pdf }, at.part))
    }

    /// The pdf of the direction from `p` to the point `q` on it, where the normal is `n`.
    pub fn pdf(&self, p: DVec3, q: DVec3, n: DVec3) -> f64 {
        per_solid_angle(self.per_area / self.placement.area(n), p, q, n).unwrap_or(0.0)
    }

    /// Its approximate area, from the normals at a few points.
    pub fn area(&self) -> f64 {
        const N: u32 = 12;
        let at = |i: u32| (f64::from(i) + 0.5) / f64::from(N);
        let normals = (0..N * N).map(|i| self.placement.normal * self.shape.point([at(i % N), at(i / N)]).n);
        let sum: f64 = normals.filter_map(|n| n.try_normalize()).map(|n| self.placement.area(n)).sum();
        sum / f64::from(N * N) / self.per_area
    }
}
