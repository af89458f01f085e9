//! What stands outside a picture.

use super::placement::{floor, fract};
use crate::schema::choice;

choice! {
    /// What stands outside the picture.
    pub enum Wrap {
        /// The picture again.
        Repeat = "repeat",
        /// Its mirror image: no seam, whatever the picture.
        Mirror = "mirror",
        /// Its border, drawn out.
        Clamp = "clamp",
        /// Nothing: black.
        Black = "black",
    }
}

impl Wrap {
    /// A coordinate brought into one picture, 0..=1. Black lies inside already.
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

    /// The texel that a coordinate lies in, of `n`.
    #[inline]
    pub(super) fn nearest(self, v: f64, n: u32) -> u32 {
        ((self.fold(v) * f64::from(n)) as u32).min(n - 1)
    }

    /// The texels whose centres lie before and after a coordinate, and its way from the one to the other.
    #[inline]
    pub(super) fn around(self, v: f64, n: u32) -> (u32, u32, f32) {
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

    /// Whether there is nothing at a coordinate.
    #[inline]
    pub(super) fn is_outside(self, v: f64) -> bool {
        self == Wrap::Black && !(0.0..=1.0).contains(&v)
    }
}
