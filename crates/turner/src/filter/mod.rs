//! Pixel filters (reconstruction filters): the weights of samples around the centre of a pixel.
//!
//! A filter is the product of a function f along x and along y; f is even, non-negative, and 0 beyond a radius r. A
//! pixel is the mean of the image weighted by f. There are two ways to estimate it
//! ([`Reconstruction`](crate::film::Reconstruction)):
//!
//! ```text
//! weighted      samples lie evenly in their pixels;     pixel = Σ f(xᵢ)·vᵢ / Σ f(xᵢ) over all samples within r
//! importance    samples lie around their pixel, with    pixel = mean of its own samples
//!               density f
//! ```
//!
//! Weighted samples count in several pixels, so a pixel has more of them and less noise. Filter importance sampling
//! (Ernst, Stamminger and Greiner 2006, "Filter importance sampling") keeps pixels independent.
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
    /// The weights of samples around a pixel's centre.
    pub enum FilterKind {
        /// Constant over the pixel's square.
        Box = "box",
        /// Falls linearly from the centre: soft.
        Tent = "tent",
        /// A Gaussian, truncated at three standard deviations: smooth, without ringing or jagged edges.
        Gaussian = "gaussian",
        /// A narrower bell that ends smoothly: sharp.
        BlackmanHarris = "blackman-harris",
    }
}

impl FilterKind {
    /// The default radius, in pixels.
    pub fn default_radius(self) -> f64 {
        match self {
            FilterKind::Box => 0.5,
            FilterKind::Tent => 1.0,
            FilterKind::Gaussian | FilterKind::BlackmanHarris => 1.5,
        }
    }

    /// f at a distance of `x` radii (0..=1) from the centre, not normalized.
    fn profile(self, x: f64) -> f64 {
        match self {
            FilterKind::Box => 1.0,
            FilterKind::Tent => 1.0 - x,
            FilterKind::Gaussian => exp(-4.5 * x * x) - exp(-4.5),
            FilterKind::BlackmanHarris => {
                let c = |n: f64| cos(n * PI * x);
                // Rounding may give a negative value at the end.
                (0.35875 + 0.48829 * c(1.0) + 0.14128 * c(2.0) + 0.01168 * c(3.0)).max(0.0)
            }
        }
    }
}

/// A prepared filter that distributes samples.
#[derive(Clone, Debug)]
pub struct Filter {
    radius: f64,
    shape: Shape,
    /// [`Filter::half`] at 0.
    peak: f64,
}

#[derive(Clone, Debug)]
enum Shape {
    /// The pixel's square: positions are the random numbers themselves.
    Pixel,
    Box,
    Tent,
    Table(Box<Table>),
}

impl Filter {
    /// A filter with a radius in pixels, or its default radius.
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
        let filter = Filter { radius, shape, peak: 1.0 };
        Filter { peak: filter.half(0.0), ..filter }
    }

    /// The position in the pixel for two random numbers in 0..1, distributed with the filter's density. (0, 0) is the
    /// pixel's upper left corner, (1, 1) the lower right one; wide filters extend beyond. The mapping is monotone, so
    /// well-distributed points stay well distributed.
    #[inline]
    pub fn place(&self, u: DVec2) -> DVec2 {
        let along = |u: f64| match &self.shape {
            Shape::Pixel | Shape::Box => 2.0 * u - 1.0,
            Shape::Tent => invert_even(u, |v| 1.0 - (1.0 - v).max(0.0).sqrt()),
            Shape::Table(table) => invert_even(u, |v| table.invert(v)),
        };
        match self.shape {
            Shape::Pixel => u,
            _ => DVec2::splat(0.5) + self.radius * DVec2::new(along(u.x), along(u.y)),
        }
    }
}

impl Filter {
    /// Radius around the pixel's centre, in pixels.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The density of [`Filter::place`] per pixel area, at offset `d` from the pixel's centre.
    pub fn density(&self, d: DVec2) -> f64 {
        let along = |d: f64| 0.5 * self.half(d) / self.radius;
        along(d.x) * along(d.y)
    }

    /// The filter along one axis at offset `d` from the pixel's centre, relative to the centre: 1 at `d` = 0.
    #[inline]
    pub fn weight(&self, d: f64) -> f64 {
        self.half(d) / self.peak
    }

    /// The fraction of the filter of pixel `at` along one axis that lies within 0..`size`.
    pub(crate) fn fraction_inside(&self, at: u32, size: u32) -> f64 {
        let center = f64::from(at) + 0.5;
        1.0 - self.beyond(center) - self.beyond(f64::from(size) - center)
    }

    /// The fraction of the filter along one axis at offsets of more than `d` >= 0.
    fn beyond(&self, d: f64) -> f64 {
        let x = (d / self.radius).min(1.0);
        0.5 * match &self.shape {
            Shape::Pixel | Shape::Box => 1.0 - x,
            Shape::Tent => (1.0 - x) * (1.0 - x),
            Shape::Table(table) => 1.0 - table.sum(x),
        }
    }

    /// The density along one axis at offset `d`, as a function of the distance in radii, whose integral is 1.
    #[inline]
    fn half(&self, d: f64) -> f64 {
        let x = d.abs() / self.radius;
        // The pixel's square includes its left and upper edges only.
        if x > 1.0 || d == self.radius {
            return 0.0;
        }
        match &self.shape {
            Shape::Pixel | Shape::Box => 1.0,
            Shape::Tent => 2.0 * (1.0 - x),
            Shape::Table(table) => table.density(x),
        }
    }
}

/// Inverts the distribution function of an even density, given the inverse `half` for one half.
#[inline]
fn invert_even(u: f64, half: impl Fn(f64) -> f64) -> f64 {
    if u < 0.5 { -half(1.0 - 2.0 * u) } else { half(2.0 * u - 1.0) }
}

#[cfg(test)]
mod tests;
