//! Where a ray met a surface: what all materials, textures and integrators are given.
//!
//! Positions and directions are in world space, in scene units; normals are unit and point out of the shape; `object` is the same surface in the space of the
//! object, for textures.

use crate::math::DVec3;
use crate::schema::MaterialId;
use crate::shape::{ShapeHit, SurfacePoint};

/// The nearest hit of a ray: all that traversal carries.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Where on the shape.
    pub shape: ShapeHit,
    /// Index of the primitive.
    pub(crate) primitive: u32,
}

/// The surface at a hit, in world space; made once, for the nearest hit.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceInteraction {
    /// The point.
    pub p: DVec3,
    /// Bound on its distance from the true surface.
    pub error: f64,
    /// Geometric normal, unit, as it points out of the shape.
    pub ng: DVec3,
    /// Shading normal, unit, on the same side.
    pub ns: DVec3,
    /// The material.
    pub material: MaterialId,
    /// The surface in the object's space, for textures.
    pub(crate) object: SurfacePoint,
    pub(crate) hit: Hit,
    /// The moment, as in the ray.
    pub(crate) time: f32,
    /// The ray's unit direction and the width of its cone here, for textures; a width of 0 stands for the point alone.
    pub(crate) seen: ([f32; 3], f32),
}

impl SurfaceInteraction {
    /// The shading normal in the object's space.
    pub(crate) fn object_normal(&self) -> DVec3 {
        self.object.ns
    }

    /// The moment, as in the ray that met it.
    pub fn time(&self) -> f32 {
        self.time
    }

    /// The point moved off the surface by more than its error, to the side `direction` leads to: a ray from there
    /// does not hit the surface it leaves (Wächter & Binder 2019 discuss the alternatives).
    #[inline]
    pub fn leave(&self, direction: DVec3) -> DVec3 {
        let side = if direction.dot(self.ng) >= 0.0 { 4.0 } else { -4.0 };
        self.p + self.ng * (side * self.error)
    }
}

/// Of a surface that is looked at in a point alone.
pub(crate) const NOT_SEEN: ([f32; 3], f32) = ([0.0; 3], 0.0);

impl SurfaceInteraction {
    /// The same surface with another shading normal.
    pub(crate) fn with_normal(&self, ns: DVec3) -> SurfaceInteraction {
        SurfaceInteraction { ns, ..*self }
    }

    /// Says what the ray's cone covers of the surface: `direction` of the ray, unit, and the cone's diameter here.
    #[inline]
    pub fn see(&mut self, direction: DVec3, width: f32) {
        self.seen = (direction.to_array().map(|v| v as f32), width);
    }

    /// The same surface looked at in a point alone.
    pub(crate) fn sharp(&self) -> SurfaceInteraction {
        SurfaceInteraction { seen: NOT_SEEN, ..*self }
    }
}
