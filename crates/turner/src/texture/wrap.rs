//! Wrap modes: what continues outside an image.

use super::placement::{floor, fract};
use crate::schema::choice;

choice! {
    /// How a texture continues outside its image.
    pub enum Wrap {
        /// The image repeats.
        Repeat = "repeat",
        /// The image is mirrored at its borders: no seams.
        Mirror = "mirror",
        /// The border is extended.
        Clamp = "clamp",
        /// Black.
        Black = "black",
    }
}

impl Wrap {
    /// Maps a coordinate into the image, 0..=1. With `Black` it must be inside already.
    #[inline]
    fn fold(self, v: f64) -> f64 {
        match self {
            Wrap::Repeat => fract(v),
            Wrap::Mirror => {
                let v = 2.0 * fract(0.5 * v);
                if v > 1.0 { 2.0 - v } else { v }
            }
            Wrap::Clamp | Wrap::Black => v.clamp(0.0, 1.0),
        }
    }

    /// The texel, of `n`, that contains a coordinate.
    #[inline]
    pub(super) fn nearest(self, v: f64, n: u32) -> u32 {
        ((self.fold(v) * f64::from(n)) as u32).min(n - 1)
    }

    /// The texels with the nearest centres before and after a coordinate, and the interpolation weight of the second.
    #[inline]
    pub(crate) fn neighbours(self, v: f64, n: u32) -> (u32, u32, f32) {
        let x = self.fold(v) * f64::from(n) - 0.5;
        let first = floor(x);
        let weight = (x - first as f64) as f32;
        let texel = |i: i64| {
            if i < 0 {
                if self == Wrap::Repeat { n - 1 } else { 0 }
            } else if i >= i64::from(n) {
                if self == Wrap::Repeat { 0 } else { n - 1 }
            } else {
                i as u32
            }
        };
        (texel(first), texel(first + 1), weight)
    }

    /// Whether the image is black at a coordinate outside.
    #[inline]
    pub(super) fn is_outside(self, v: f64) -> bool {
        self == Wrap::Black && !(0.0..=1.0).contains(&v)
    }
}
