//! Rays in double precision, in blocks of eight.

use crate::lanes::{Block, LANES};

/// Eight rays: the segments `t_min <= t <= t_max` of the lines `origin + t * direction`.
#[derive(Clone, Copy, Debug)]
pub struct RayBlock {
    /// The points at t = 0, one block per coordinate.
    pub origin: [Block; 3],
    /// The vectors from t = 0 to t = 1.
    pub direction: [Block; 3],
    /// Start of the interval.
    pub t_min: Block,
    /// End of the interval.
    pub t_max: Block,
}

impl RayBlock {
    const NAN: Block = Block([f64::NAN; LANES]);

    /// Rays that hit nothing.
    pub const NOTHING: RayBlock =
        RayBlock { origin: [Self::NAN; 3], direction: [Self::NAN; 3], t_min: Self::NAN, t_max: Self::NAN };

    /// Puts a ray into a lane.
    #[inline]
    pub fn set(&mut self, lane: usize, origin: [f64; 3], direction: [f64; 3], t_min: f64, t_max: f64) {
        for axis in 0..3 {
            self.origin[axis].0[lane] = origin[axis];
            self.direction[axis].0[lane] = direction[axis];
        }
        self.t_min.0[lane] = t_min;
        self.t_max.0[lane] = t_max;
    }
}
