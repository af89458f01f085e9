//! Squares of two colours.
//!
//! Over a footprint the board is the product of three square waves, ±1, whose mean over a box along the axes is the product of their means:
//! exact, at any distance. A footprint that lies askew is divided along its longer axis into up to 32 such boxes.

use super::placement::{floor, fract};
use super::prepare::{Kind, Preparing};
use super::{Mapping, Placement, TexturePoint, Textures};
use crate::color::Spectrum;
use crate::math::DVec3;
use crate::schema::{ColorSource, Range, SceneError, Transform, params};

params! {
    /// Squares (cubes with `mapping = "solid"`) of two colours, one unit of texture coordinates wide: with density 1 four
    /// squares cover a shape, with density 4 sixteen by four.
    pub struct CheckerboardDesc as "checkerboard" {
        /// Colour of the squares that touch the corner (0, 0) from above right.
        even: ColorSource = ColorSource::Constant(Spectrum::WHITE);
        /// Colour of the others.
        odd: ColorSource = ColorSource::Constant(Spectrum::BLACK);
        /// Number of squares per unit of texture coordinates.
        density: f64 = 1.0;
        /// How the pattern lies on the surface or goes through the solid.
        mapping: Mapping = Mapping::Uv;
        /// For `mapping = "triplanar"`: how sharply one direction follows another where the surface turns.
        blend: f64 = 4.0, in Range::closed(1.0, 64.0);
        /// Moves the pattern.
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

/// Squares of two colours.
#[derive(Clone, Debug)]
pub(super) struct Checkerboard {
    even: ColorSource,
    odd: ColorSource,
    placement: Placement,
}

impl Kind for CheckerboardDesc {
    type Ready = Checkerboard;
    const AT_ONCE: u64 = 2;

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

    fn prepare(&self, _: &mut Preparing<'_>) -> Result<Checkerboard, SceneError> {
        let placement = Placement::new(self.mapping, self.density, self.transform);
        Ok(Checkerboard { even: self.even, odd: self.odd, placement })
    }
}

impl Checkerboard {
    /// Parity of the three cell numbers; over a footprint, the shares of the two.
    pub(super) fn eval(&self, textures: &Textures, at: &TexturePoint<'_>) -> Spectrum {
        let c = self.placement.coordinates(at);
        if let Some(axes) = self.placement.axes(at)
            && axes.iter().any(|d| d.abs().max_element() > 0.0)
        {
            return textures.mix(self.even, self.odd, odd_share(c, axes), at);
        }
        let odd = (floor(c.x) + floor(c.y) + floor(c.z)) & 1 == 1;
        textures.color(if odd { self.odd } else { self.even }, at)
    }

    /// A step on the surface over which it changes little, as [`Placement::spacing`].
    pub(super) fn spacing(&self, _: &Textures, at: &TexturePoint<'_>) -> Option<f64> {
        self.placement.spacing(at)
    }

    pub(super) fn memory(&self) -> usize {
        0
    }
}

/// The share of odd squares in a footprint around `c` with these axes, 0..=1.
fn odd_share(c: DVec3, [a, b]: [DVec3; 2]) -> f64 {
    let (long, short) = if a.length_squared() >= b.length_squared() { (a, b) } else { (b, a) };
    // How far it lies askew: the second of its extents. One box is exact where that is 0.
    let reach = long.abs();
    let askew = reach.x.max(reach.y).min(reach.x.min(reach.y).max(reach.z));
    let parts = (3.0 * askew / short.abs().max_element().max(0.125)).ceil().clamp(1.0, 32.0);
    // A box of the same spread as the part of the parallelogram.
    let part = long / parts;
    let size = DVec3::from((short * short + part * part).to_array().map(f64::sqrt));
    let mut sum = 0.0;
    for i in 0..parts as u32 {
        let at = c + long * ((f64::from(i) + 0.5) / parts - 0.5);
        sum += batch(at.x, size.x) * batch(at.y, size.y) * batch(at.z, size.z);
    }
    (0.5 - 0.5 * sum / parts).clamp(0.0, 1.0)
}

/// The mean over an interval around `x` of the wave that is 1 in 0..1 and −1 in 1..2, and so on.
fn batch(x: f64, width: f64) -> f64 {
    // Narrower ones lose their digits in the difference.
    if width < 1e-6 {
        return if floor(x) & 1 == 0 { 1.0 } else { -1.0 };
    }
    // Its integral from 0: up and down again.
    let integral = |x: f64| 1.0 - (2.0 * fract(0.5 * x) - 1.0).abs();
    (integral(x + 0.5 * width) - integral(x - 0.5 * width)) / width
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same by counting points.
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
            let (found, expected) = (odd_share(c, axes), counted(c, axes));
            assert!((found - expected).abs() < 5e-3, "{c}: {found} {expected}");
        }
        // One square, wholly inside; and one as large as two.
        assert_eq!(odd_share(DVec3::new(0.5, 0.5, 0.0), [DVec3::X * 0.5, DVec3::Y * 0.5]), 0.0);
        assert_eq!(odd_share(DVec3::new(1.5, 0.5, 0.0), [DVec3::X * 0.5, DVec3::Y * 0.5]), 1.0);
        assert_eq!(odd_share(DVec3::new(0.2, 0.9, 0.0), [DVec3::X * 2.0, DVec3::Y * 0.5]), 0.5);
    }

    #[test]
    fn footprints_askew_are_near_enough() {
        for i in 0..40 {
            let (s, c) = crate::math::elementary::sin_cos(0.3 + f64::from(i) * 0.37);
            let at = DVec3::new(f64::from(i) * 0.19, f64::from(i) * 0.31, 0.0);
            let long = DVec3::new(c, s, 0.0) * (0.2 + 0.05 * f64::from(i));
            let short = DVec3::new(-s, c, 0.0) * 0.2;
            let (found, expected) = (odd_share(at, [short, long]), counted(at, [short, long]));
            assert!((found - expected).abs() < 0.09, "{i}: {found} {expected}");
        }
    }

    #[test]
    fn far_away_it_is_grey() {
        for size in [1e3, 1e6, 1e9] {
            let share = odd_share(DVec3::new(0.3, 0.2, 0.0), [DVec3::X * size, DVec3::Y]);
            assert!((share - 0.5).abs() < 2.0 / size, "{size}: {share}");
        }
    }
}
