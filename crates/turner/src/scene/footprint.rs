//! Ray footprints: the part of a surface that a ray's cone covers, which sets the filter of texture look-ups.
//!
//! A camera ray stands for a pixel, not a line. It carries a cone: the width of the pixel at the hit, kept in
//! `SurfaceInteraction::seen` with the direction of view. The cone cuts the tangent plane in an ellipse. Its two
//! axes are transformed to object space and to changes of (u, v), over which texture look-ups are filtered.
//!
//! ```text
//!         \   |   /                width: across the cone
//!          \  |  /                 axes[0]: perpendicular to the tilt, as wide as the cone
//!       ----\-|-/---- surface      axes[1]: along the tilt, longer by 1 / cos θ
//!          axes[1]
//! ```
//!
//! A width of 0 means unfiltered look-ups. A direction of 0 means an isotropic footprint, a circle.

use crate::math::DVec3;
use crate::scene::scene::ObjectTransform;
use crate::scene::{Hit, Scene, SurfaceInteraction};
use crate::texture::{Footprint, TexturePoint};

impl Scene {
    /// Position and footprint of texture look-ups on a surface.
    pub fn texture_point(&self, surface: &SurfaceInteraction) -> TexturePoint<'_> {
        let primitive = &self.primitives[surface.hit.primitive as usize];
        let mut at = TexturePoint::of_shape(&primitive.shape, &surface.hit.shape, &surface.object);
        at.to_world = self.transforms.get(primitive.transform as usize).map(|placed| &placed.to_world);
        let (direction, width) = surface.seen;
        if width > 0.0 {
            let direction = DVec3::from(direction.map(f64::from));
            let axes = Footprint::of_cone(direction, surface.ng, f64::from(width));
            let isotropic = direction == DVec3::ZERO;
            at.footprint = Some(Footprint { isotropic, ..self.footprint(surface, axes) });
        }
        at
    }

    /// Approximate curvature: how much the normal rotates per unit of length; above 0 where the surface is convex.
    pub fn curvature(&self, hit: &Hit) -> f64 {
        let primitive = &self.primitives[hit.primitive as usize];
        let own = primitive.shape.curvature(&hit.shape);
        match self.transforms.get(primitive.transform as usize) {
            // `stretch` over √3 is the root mean square of the factors by which lengths grow.
            Some(placed) => own * 3f64.sqrt() / placed.stretch,
            None => own,
        }
    }

    /// Transforms two world-space axes, tangent to the surface, to a texture footprint.
    pub(crate) fn footprint(&self, surface: &SurfaceInteraction, axes: [DVec3; 2]) -> Footprint {
        let primitive = &self.primitives[surface.hit.primitive as usize];
        let p = match self.transforms.get(primitive.transform as usize) {
            None => axes,
            Some(ObjectTransform { motion: Some(motion), .. }) => {
                let inverse = motion.at(f64::from(surface.time)).matrix3.inverse();
                axes.map(|d| inverse * d)
            }
            Some(placed) => axes.map(|d| placed.to_object.matrix3 * d),
        };
        let uv = primitive.shape.uv_change(&surface.hit.shape, &surface.object, p);
        Footprint { p, uv, isotropic: false }
    }
}
