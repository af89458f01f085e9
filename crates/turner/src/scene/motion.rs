//! Objects that move while the shutter is open: see [`Motion`](crate::animation::motion::Motion).

use crate::math::DVec3;
use crate::scene::{Hit, Scene};

impl Scene {
    /// Where the surface point `p` of a hit at `time` is when the shutter opens and when it closes; `None` if the
    /// object does not move.
    pub(crate) fn ends_of_motion(
        &self,
        hit: &Hit,
        p: DVec3,
        time: f32,
        shutter: [f64; 2],
    ) -> Option<[DVec3; 2]> {
        let primitive = self.primitives.get(hit.primitive as usize)?;
        let motion = self.transforms.get(primitive.transform as usize)?.motion.as_ref()?;
        let own = motion.at(f64::from(time)).inverse().transform_point3(p);
        Some(shutter.map(|time| motion.at(time).transform_point3(own)))
    }
}
