//! Which thing is where.

use super::{DebugView, FirstHit, numbers, shown};
use crate::film::Picture;
use crate::integrator::{Radiance, RayStats};
use crate::schema::params;

params! {
    /// Shows which object, which material and which part of it is seen. EXR files hold, from 0, the number of the object in red (in the order of the
    /// description, instances in order), of the material in green and of the part in blue (a triangle, a side of a box), exact up to
    /// 2^24, with alpha 0 where nothing is hit. PNG gives each object a colour. IDs cannot be averaged: each pixel
    /// has one sample through its centre, whatever `antialias` and `samples` of the film say.
    pub struct IdsDesc as "ids" {
    }
    example r#"[integrator]
type = "ids"
"#
}

impl DebugView for IdsDesc {
    fn word(&self) -> &'static str {
        IdsDesc::DOC.name
    }

    fn shown(&self, picture: &mut Picture) {
        shown::ids(picture);
    }

    fn has_labels(&self) -> bool {
        true
    }

    fn at(&self, hit: &FirstHit<'_>, _: &mut RayStats) -> Radiance {
        let object = hit.scene.primitive_id(&hit.hit);
        let material = hit.surface.material.index();
        numbers([f64::from(object), material as f64, f64::from(hit.hit.shape.part)])
    }
}
