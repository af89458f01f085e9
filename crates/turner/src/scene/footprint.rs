//! What a ray's cone covers of a surface: where textures are looked up, and over how much.

use crate::math::DVec3;
use crate::scene::scene::ObjectTransform;
use crate::scene::{Scene, SurfaceInteraction};
use crate::texture::{Footprint, TexturePoint};

impl Scene {
    /// Where textures are looked up on a surface, and over what footprint.
    pub fn texture_point(&self, surface: &SurfaceInteraction) -> TexturePoint<'_> {
        let primitive = &self.primitives[surface.hit.primitive as usize];
        let mut at = TexturePoint::of_shape(&primitive.shape, &surface.hit.shape, &surface.object);
        at.to_world = self.transforms.get(primitive.transform as usize).map(|placed| &placed.to_world);
        let (direction, width) = surface.seen;
        if width > 0.0 {
            let direction = DVec3::from(direction.map(f64::from));
            let axes = Footprint::of_cone(direction, surface.ng, f64::from(width));
            at.footprint = Some(self.footprint(surface, axes));
        }
        at
    }

    /// How much the surface's normal turns per unit of length, about; above 0 where it bulges outwards.
    pub fn curvature(&self, surface: &SurfaceInteraction) -> f64 {
        let primitive = &self.primitives[surface.hit.primitive as usize];
        let own = primitive.shape.curvature(&surface.hit.shape);
        match self.transforms.get(primitive.transform as usize) {
            // The root of the mean square of the factors that lengths grow by.
            Some(placed) => own * 3f64.sqrt() / placed.stretch,
            None => own,
        }
    }

    /// Two axes in the world, tangent to the surface, as a footprint of textures.
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
        Footprint { p, uv: primitive.shape.uv_change(&surface.hit.shape, &surface.object, p) }
    }
}
