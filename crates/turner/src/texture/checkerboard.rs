//! A checkerboard of two colours, with exact filtering.
//!
//! The board is the product of one square wave (±1) per axis. Over a box aligned with the axes, the mean of the
//! product is the product of the means, which is an integral in closed form: exact at any distance. A footprint that
//! is not aligned is divided along its longer axis into up to 32 such boxes.

use super::placement::{floor, fract};
use super::prepare::{Kind, PrepareContext};
use super::{Mapping, Placement, TexturePoint, Textures};
use crate::color::Spectrum;
use crate::math::DVec3;
use crate::schema::{ColorSource, Range, SceneError, Transform, params};

params! {
    /// Squares of two colours (cubes with `mapping = "solid"`), one unit of texture coordinates wide. Over a shape
    /// with (u, v) in 0..1, density 1 shows 2 × 2 squares and density 4 shows 8 × 8.
    pub struct CheckerboardDesc as "checkerboard" {
        /// Colour of the square whose lower left corner is at the origin of the texture coordinates, the centre of
        /// the surface, and of every second square from there.
        even: ColorSource = ColorSource::Constant(Spectrum::WHITE);
        /// Colour of the other squares.
        odd: ColorSource = ColorSource::Constant(Spectrum::BLACK);
        /// Number of squares per unit of texture coordinates.
        density: f64 = 1.0;
        /// Where the texture coordinates come from.
        mapping: Mapping = Mapping::Uv;
        /// For `mapping = "triplanar"`: sharpness of the transitions between the three projections; higher is sharper.
        blend: f64 = 4.0, in Range::closed(1.0, 64.0);
        /// Translates, rotates or scales the pattern.
        transform: Transform = Transform::IDENTITY;
    }
    example r##"[texture.board]
type = "checkerboard"
even = "ivory"
odd = "#305030"
density = 4

[[object]]
type = "plane"
material = { color = "board" }
"##
}

/// A checkerboard.
#[derive(Clone, Debug)]
pub(super) struct Checkerboard {
    even: ColorSource,
    odd: ColorSource,
    placement: Placement,
}

impl Kind for CheckerboardDesc {
    type Prepared = Checkerboard;
    const MAX_INPUTS: u64 = 2;

    fn sources(&self, visit: &mut dyn FnMut(ColorSource)) {
        visit(self.even);
        visit(self.odd);
    }

    fn mapping(&self) -> Mapping {
        self.mapping
    }

    fn triplanar(&self) -> Option<(f64, Transform)> {
        (self.mapping == Mapping::Triplanar).then_some((self.blend, self.transform))
    }

    fn prepare(&self, _: &mut PrepareContext<'_>) -> Result<Checkerboard, SceneError> {
        let placement = Placement::new(self.mapping, self.density, self.transform);
        Ok(Checkerboard { even: self.even, odd: self.odd, placement })
    }
}

impl Checkerboard {
    /// The colour by the parity of the sum of the cell indices; with a footprint, a mix by area.
    pub(super) fn eval(&self, textures: &Textures, at: &TexturePoint<'_>) -> Spectrum {
        let c = self.placement.coordinates(at);
        if let Some(axes) = self.placement.axes(at)
            && axes.iter().any(|d| d.abs().max_element() > 0.0)
        {
            return textures.mix(self.even, self.odd, odd_fraction(c, axes), at);
        }
        let odd = (floor(c.x) + floor(c.y) + floor(c.z)) & 1 == 1;
        textures.color(if odd { self.odd } else { self.even }, at)
    }

    /// See [`Placement::spacing`].
    pub(super) fn spacing(&self, _: &Textures, at: &TexturePoint<'_>) -> Option<f64> {
        self.placement.spacing(at)
    }

    pub(super) fn memory(&self) -> usize {
        0
    }
}

/// The fraction of odd squares in a footprint with these axes around `c`, 0..=1.
fn odd_fraction(c: DVec3, [a, b]: [DVec3; 2]) -> f64 {
    // Most footprints lie within one square.
    let half = 0.5 * (a.abs() + b.abs());
    let (low, high) = (c - half, c + half);
    let cells = |p: DVec3| [floor(p.x), floor(p.y), floor(p.z)];
    if cells(low) == cells(high) {
        let [x, y, z] = cells(c);
        return if (x ^ y ^ z) & 1 == 1 { 1.0 } else { 0.0 };
    }
    let (long, short) = if a.length_squared() >= b.length_squared() { (a, b) } else { (b, a) };
    // The second largest extent of the longer axis: one box is exact where it is 0.
    let reach = long.abs();
    let skew = reach.x.max(reach.y).min(reach.x.min(reach.y).max(reach.z));
    let parts = (3.0 * skew / short.abs().max_element().max(0.125)).ceil().clamp(1.0, 32.0);
    // A box with the same variance as this part of the parallelogram.
    let part = long / parts;
    let size = DVec3::from((short * short + part * part).to_array().map(f64::sqrt));
    let mut sum = 0.0;
    for i in 0..parts as u32 {
        let at = c + long * ((f64::from(i) + 0.5) / parts - 0.5);
        sum += square_wave(at.x, size.x) * square_wave(at.y, size.y) * square_wave(at.z, size.z);
    }
    (0.5 - 0.5 * sum / parts).clamp(0.0, 1.0)
}

/// The mean over an interval around `x` of the square wave that is 1 in 0..1, −1 in 1..2, and so on.
fn square_wave(x: f64, width: f64) -> f64 {
    // In narrower intervals the difference of integrals would lose its digits.
    if width < 1e-6 {
        return if floor(x) & 1 == 0 { 1.0 } else { -1.0 };
    }
    // The integral from 0 is a triangle wave.
    let integral = |x: f64| 1.0 - (2.0 * fract(0.5 * x) - 1.0).abs();
    (integral(x + 0.5 * width) - integral(x - 0.5 * width)) / width
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same, by counting points.
    fn counted(c: DVec3, [a, b]: [DVec3; 2]) -> f64 {
        const N: i32 = 400;
        let mut odd = 0;
        for i in 0..N {
            for j in 0..N {
                let p = c
                    + a * ((f64::from(i) + 0.5) / f64::from(N) - 0.5)
                    + b * ((f64::from(j) + 0.5) / f64::from(N) - 0.5);
                odd += i64::from((floor(p.x) + floor(p.y) + floor(p.z)) & 1 == 1);
            }
        }
        odd as f64 / f64::from(N * N)
    }

    #[test]
    fn boxes_along_the_axes_are_exact() {
        for (c, w, h) in
            [([0.3, 0.7], 0.5, 0.2), ([5.9, -3.1], 0.4, 1.3), ([0.5, 0.5], 3.0, 0.1), ([0.01, 7.0], 2.5, 5.5)]
        {
            let c = DVec3::new(c[0], c[1], 0.0);
            let axes = [DVec3::X * w, DVec3::Y * h];
            let (found, expected) = (odd_fraction(c, axes), counted(c, axes));
            assert!((found - expected).abs() < 5e-3, "{c}: {found} {expected}");
        }
        // The footprint is inside one square; then it is as large as two.
        assert_eq!(odd_fraction(DVec3::new(0.5, 0.5, 0.0), [DVec3::X * 0.5, DVec3::Y * 0.5]), 0.0);
        assert_eq!(odd_fraction(DVec3::new(1.5, 0.5, 0.0), [DVec3::X * 0.5, DVec3::Y * 0.5]), 1.0);
        assert_eq!(odd_fraction(DVec3::new(0.2, 0.9, 0.0), [DVec3::X * 2.0, DVec3::Y * 0.5]), 0.5);
    }

    #[test]
    fn skewed_footprints_are_close() {
        for i in 0..40 {
            let (s, c) = crate::math::elementary::sin_cos(0.3 + f64::from(i) * 0.37);
            let at = DVec3::new(f64::from(i) * 0.19, f64::from(i) * 0.31, 0.0);
            let long = DVec3::new(c, s, 0.0) * (0.2 + 0.05 * f64::from(i));
            let short = DVec3::new(-s, c, 0.0) * 0.2;
            let (found, expected) = (odd_fraction(at, [short, long]), counted(at, [short, long]));
            assert!((found - expected).abs() < 0.09, "{i}: {found} {expected}");
        }
    }

    #[test]
    fn far_away_it_is_grey() {
        for size in [1e3, 1e6, 1e9] {
            let fraction = odd_fraction(DVec3::new(0.3, 0.2, 0.0), [DVec3::X * size, DVec3::Y]);
            assert!((fraction - 0.5).abs() < 2.0 / size, "{size}: {fraction}");
        }
    }
}
