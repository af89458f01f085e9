//! The surface interaction: where a ray hit a surface, as materials, textures and integrators need it.
//!
//! Positions and directions are in world space, in scene units. Normals are unit vectors that point out of the
//! shape. `object` is the same surface in object space, for textures.
//!
//! ```text
//!    wo   ng   ns
//!      \   |   /       wo: towards the viewer, the reverse of the ray's direction
//!       \  |  /        ng: geometric normal, ns: shading normal
//!        \ | /         p:  the point, within `error` of the true surface
//! ---------p---------
//! ```

use crate::math::DVec3;
use crate::schema::MaterialId;
use crate::shape::{ShapeHit, SurfacePoint};

/// The nearest hit of a ray: the result of traversal.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// The hit on the shape.
    pub shape: ShapeHit,
    /// Index of the primitive.
    pub(crate) primitive: u32,
}

/// The surface at a hit, in world space; computed once, for the nearest hit.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceInteraction {
    /// The point.
    pub p: DVec3,
    /// Bound on the distance of `p` from the true surface.
    pub error: f64,
    /// Geometric normal, unit, out of the shape.
    pub ng: DVec3,
    /// Shading normal, unit, on the same side.
    pub ns: DVec3,
    /// The material.
    pub material: MaterialId,
    /// The surface in object space, for textures.
    pub(crate) object: SurfacePoint,
    pub(crate) hit: Hit,
    /// Time of the ray.
    pub(crate) time: f32,
    /// The ray's unit direction and the diameter of its cone here, for texture filtering; a diameter of 0 means
    /// unfiltered.
    pub(crate) seen: ([f32; 3], f32),
}

impl SurfaceInteraction {
    /// The shading normal in object space.
    pub(crate) fn object_normal(&self) -> DVec3 {
        self.object.ns
    }

    /// Time of the ray that hit the surface.
    pub fn time(&self) -> f32 {
        self.time
    }

    /// The point moved off the surface by more than its error, to the side of `direction`, so that a ray from
    /// there does not hit the same surface again (Wächter & Binder 2019 discuss the alternatives).
    #[inline]
    pub fn leave(&self, direction: DVec3) -> DVec3 {
        let side = if direction.dot(self.ng) >= 0.0 { 4.0 } else { -4.0 };
        self.p + self.ng * (side * self.error)
    }
}

/// The footprint of unfiltered lookups.
pub(crate) const NOT_SEEN: ([f32; 3], f32) = ([0.0; 3], 0.0);

impl SurfaceInteraction {
    /// The same surface with another shading normal.
    pub(crate) fn with_normal(&self, ns: DVec3) -> SurfaceInteraction {
        SurfaceInteraction { ns, ..*self }
    }

    /// Sets the footprint: the ray's unit direction, and the diameter of its cone here.
    #[inline]
    pub fn see(&mut self, direction: DVec3, width: f32) {
        self.seen = (direction.to_array().map(|v| v as f32), width);
    }

    /// The same surface without a footprint, for unfiltered lookups.
    pub(crate) fn sharp(&self) -> SurfaceInteraction {
        SurfaceInteraction { seen: NOT_SEEN, ..*self }
    }
}
