//! How a texture lies on a surface or in space.

use super::TexturePoint;
use crate::math::{DAffine3, DVec3};
use crate::scene::schema::choice;
use crate::scene::transform::Transform;

choice! {
    /// Which coordinates a texture is looked up at.
    pub enum Mapping {
        /// The surface's (u, v), scaled to (−1..1).
        Uv = "uv",
        /// The position in the space of the object: the pattern goes through the solid.
        Solid = "solid",
    }
}

/// Mapping, density and transform, prepared.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    mapping: Mapping,
    density: f64,
    /// Undoes the texture's own transform; `None` if it has none.
    inverse: Option<DAffine3>,
}

impl Placement {
    /// From the three common keys of every texture.
    pub fn new(mapping: Mapping, density: f64, transform: Transform) -> Placement {
        let inverse = (!transform.is_identity()).then(|| transform.0.inverse());
        Placement { mapping, density, inverse }
    }

    /// Texture coordinates (s, t, r) at a point.
    #[inline]
    pub fn coordinates(&self, at: &TexturePoint) -> DVec3 {
        let c = match self.mapping {
            Mapping::Uv => DVec3::new(2.0 * at.uv.x - 1.0, 2.0 * at.uv.y - 1.0, 0.0),
            Mapping::Solid => at.p,
        };
        let c = match &self.inverse {
            None => c,
            Some(inverse) => inverse.transform_point3(c),
        };
        c * self.density
    }
}
