//! IDs of object, material and part.

use super::{DebugView, FirstHit, display, values};
use crate::film::Picture;
use crate::integrator::{Radiance, RayStats};
use crate::schema::params;

params! {
    /// Shows the object, the material and the part at the first hit. EXR files hold zero-based IDs: the object in
    /// red (in the order of the description, instances in order), the material in green and the part in blue (a
    /// triangle, a side of a box). They are exact up to 2^24; alpha is 0 where nothing is hit. PNG files show one
    /// colour per object. IDs cannot be averaged: each pixel has one sample through its centre, and `antialias` and
    /// `samples` of the film are ignored.
    pub struct IdsDesc as "ids" {
    }
    example r#"[integrator]
type = "ids"
"#
}

impl DebugView for IdsDesc {
    fn type_name(&self) -> &'static str {
        IdsDesc::DOC.name
    }

    fn set_display(&self, picture: &mut Picture) {
        display::ids(picture);
    }

    fn has_labels(&self) -> bool {
        true
    }

    fn at_hit(&self, hit: &FirstHit<'_>, _: &mut RayStats) -> Radiance {
        let object = hit.scene.primitive_id(&hit.hit);
        let material = hit.surface.material.index();
        values([f64::from(object), material as f64, f64::from(hit.hit.shape.part)])
    }
}
