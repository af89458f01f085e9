//! Reconstruction filters: how much what lies around the middle of a pixel counts for it.
//!
//! Filters are products of one function f along x and along y, even and never negative, 0 beyond a radius r. A pixel is the mean of
//! the picture weighted by f. Here the samples themselves are spread by f and all weigh the same (Ernst, Stamminger & Greiner 2006,
//! "Filter importance sampling"): a sample belongs to one pixel alone, and tiles, passes and machines need not exchange any.
//!
//! | filter | f(x) for abs(x) < r | default r |
//! |---|---|---|
//! | box | 1 | 0.5 |
//! | tent | 1 − abs(x)/r | 1 |
//! | gaussian | exp(−x²/2σ²) − exp(−r²/2σ²) with σ = r/3 | 1.5 |
//! | blackman-harris | 0.35875 + 0.48829 cos(πx/r) + 0.14128 cos(2πx/r) + 0.01168 cos(3πx/r) (Harris 1978) | 1.5 |

mod table;

use std::f64::consts::PI;

use table::Table;

use crate::choice::choice;
use crate::math::DVec2;
use crate::math::elementary::{cos, exp};

choice! {
    /// How the light around a pixel's middle is weighted.
    pub enum FilterKind {
        /// All of the pixel's square alike, and nothing beyond.
        Box = "box",
        /// The less the farther from the middle, in a straight line: soft.
        Tent = "tent",
        /// A bell, cut off at three standard deviations: smooth, without ringing or jagged edges.
        Gaussian = "gaussian",
        /// A narrower bell that ends smoothly: sharp.
        BlackmanHarris = "blackman-harris",
    }
}

impl FilterKind {
    /// The radius in pixels where none is given.
    pub fn default_radius(self) -> f64 {
        match self {
            FilterKind::Box => 0.5,
            FilterKind::Tent => 1.0,
            FilterKind::Gaussian | FilterKind::BlackmanHarris => 1.5,
        }
    }

    /// f at `x` of 0..=1 radii from the middle, not normalised.
    fn profile(self, x: f64) -> f64 {
        match self {
            FilterKind::Box => 1.0,
            FilterKind::Tent => 1.0 - x,
            FilterKind::Gaussian => exp(-4.5 * x * x) - exp(-4.5),
            FilterKind::BlackmanHarris => {
                let c = |n: f64| cos(n * PI * x);
                // Rounding leaves less than nothing at the very end.
                (0.35875 + 0.48829 * c(1.0) + 0.14128 * c(2.0) + 0.01168 * c(3.0)).max(0.0)
            }
        }
    }
}

/// A filter ready to place samples.
#[derive(Clone, Debug)]
pub struct Filter {
    radius: f64,
    shape: Shape,
}

#[derive(Clone, Debug)]
enum Shape {
    /// The pixel itself: numbers are places.
    Pixel,
    Box,
    Tent,
    Table(Box<Table>),
}

impl Filter {
    /// A filter of a radius in pixels; of its own without one.
    pub fn new(kind: FilterKind, radius: Option<f64>) -> Filter {
        let radius = radius.unwrap_or(kind.default_radius());
        let shape = match kind {
            FilterKind::Box if radius == 0.5 => Shape::Pixel,
            FilterKind::Box => Shape::Box,
            FilterKind::Tent => Shape::Tent,
            FilterKind::Gaussian | FilterKind::BlackmanHarris => {
                Shape::Table(Box::new(Table::new(|x| kind.profile(x))))
            }
        };
        Filter { radius, shape }
    }

    /// The place in the pixel for two uniform numbers in 0..1, spread by the filter's own density: (0, 0) is the pixel's upper left corner,
    /// (1, 1) the lower right one; wide filters reach beyond. Larger numbers give larger places, so that points that are spread well stay so.
    #[inline]
    pub fn place(&self, u: DVec2) -> DVec2 {
        let along = |u: f64| match &self.shape {
            Shape::Pixel | Shape::Box => 2.0 * u - 1.0,
            Shape::Tent => both_sides(u, |v| 1.0 - (1.0 - v).max(0.0).sqrt()),
            Shape::Table(table) => both_sides(u, |v| table.invert(v)),
        };
        match self.shape {
            Shape::Pixel => u,
            _ => DVec2::splat(0.5) + self.radius * DVec2::new(along(u.x), along(u.y)),
        }
    }
}

impl Filter {
    /// How far from a pixel's middle it reaches, in pixels.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The density of [`Filter::place`], per pixel area, `d` from the pixel's middle.
    pub fn density(&self, d: DVec2) -> f64 {
        let along = |d: f64| {
            let x = d.abs() / self.radius;
            // A pixel has its left and upper edge.
            if x > 1.0 || d == self.radius {
                return 0.0;
            }
            let half = match &self.shape {
                Shape::Pixel | Shape::Box => 1.0,
                Shape::Tent => 2.0 * (1.0 - x),
                Shape::Table(table) => table.density(x),
            };
            0.5 * half / self.radius
        };
        along(d.x) * along(d.y)
    }
}

/// The inverse of an even density's distribution function by that of one half, `half`.
#[inline]
fn both_sides(u: f64, half: impl Fn(f64) -> f64) -> f64 {
    if u < 0.5 { -half(1.0 - 2.0 * u) } else { half(2.0 * u - 1.0) }
}

#[cfg(test)]
mod tests;
