//! Stripes of two colours.

use super::placement::{fract, smoothstep};
use super::prepare::{Kind, Preparing};
use super::{Axis, Mapping, Placement, TexturePoint, Textures};
use crate::color::Spectrum;
use crate::scene::schema::{Range, params};
use crate::scene::transform::Transform;
use crate::scene::{ColorSource, SceneError};

params! {
    /// Stripes of two colours, which follow one another along an axis. A pair of them takes two units of texture coordinates: with
    /// density 1 one stripe of each colour covers a shape, as on the chessboard.
    pub struct StripesDesc as "stripes" {
        /// Colour of the stripe that begins at 0.
        even: ColorSource = ColorSource::Constant(Spectrum::WHITE);
        /// Colour of the other.
        odd: ColorSource = ColorSource::Constant(Spectrum::BLACK);
        /// The share of the even colour.
        width: f64 = 0.5, in Range::UNIT;
        /// Softness of the edges: 0 for sharp ones, 1 for waves without any flat part.
        smooth: f64 = 0.0, in Range::UNIT;
        /// The axis that the stripes follow one another along: "x" is s on a surface, "y" is t; "z" is for `mapping = "solid"`.
        axis: Axis = Axis::X;
        /// Number of stripes per unit of texture coordinates.
        density: f64 = 1.0;
        /// Whether the pattern lies on the surface or goes through the solid.
        mapping: Mapping = Mapping::Uv;
        /// Moves and turns the pattern.
        transform: Transform = Transform::IDENTITY;
    }
    example r##"[texture.awning]
type = "stripes"
even = "ivory"
odd = "seagreen"
density = 8

[[object]]
type = "sphere"
material = { color = "awning" }
"##
}

/// Stripes of two colours.
#[derive(Clone, Debug)]
pub(super) struct Stripes {
    even: ColorSource,
    odd: ColorSource,
    width: f64,
    smooth: f64,
    axis: Axis,
    placement: Placement,
}

impl Kind for StripesDesc {
    type Ready = Stripes;
    const AT_ONCE: u64 = 2;

    fn sources(&self, visit: &mut dyn FnMut(ColorSource)) {
        visit(self.even);
        visit(self.odd);
    }

    fn mapping(&self) -> Mapping {
        self.mapping
    }

    fn prepare(&self, _: &mut Preparing<'_>) -> Result<Stripes, SceneError> {
        Ok(Stripes {
            even: self.even,
            odd: self.odd,
            width: self.width,
            smooth: self.smooth,
            axis: self.axis,
            placement: Placement::new(self.mapping, self.density, self.transform),
        })
    }
}

impl Stripes {
    pub(super) fn eval(&self, textures: &Textures, at: &TexturePoint<'_>) -> Spectrum {
        let place = fract(0.5 * self.axis.of(self.placement.coordinates(at)));
        textures.mix(self.even, self.odd, self.odd_share(place), at)
    }

    /// The share of the odd colour at a place in 0..1 within a pair of stripes.
    fn odd_share(&self, place: f64) -> f64 {
        let soft = 0.5 * self.smooth * self.width.min(1.0 - self.width);
        if soft == 0.0 {
            return if place < self.width { 0.0 } else { 1.0 };
        }
        // Distance from the middle of the even stripe, around the pair.
        let d = (place - 0.5 * self.width).abs();
        let d = d.min(1.0 - d);
        smoothstep(0.5 * self.width - soft, 0.5 * self.width + soft, d)
    }

    pub(super) fn memory(&self) -> usize {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{at, ready, text};
    use super::*;
    use crate::scene::value::Data;

    #[test]
    fn stripes_alternate_across_zero() {
        let s = ready("stripes", &[("density", Data::Integer(3))]);
        for i in -9..9 {
            let expected = if i % 2 == 0 { Spectrum::WHITE } else { Spectrum::BLACK };
            assert_eq!(at(&s, (f64::from(i) + 0.5) / 3.0, 0.7), expected, "stripe {i}");
        }
        let s = ready("stripes", &[("axis", text("y")), ("width", Data::Number(0.25))]);
        assert_eq!(at(&s, 0.3, 0.0), Spectrum::WHITE);
        assert_eq!(at(&s, 0.3, 0.499), Spectrum::WHITE);
        assert_eq!(at(&s, 0.3, 0.5), Spectrum::BLACK);
        assert_eq!(at(&s, 0.3, -1e-300), Spectrum::WHITE);
    }

    #[test]
    fn all_or_nothing() {
        for (width, expected) in [(0, Spectrum::BLACK), (1, Spectrum::WHITE)] {
            for smooth in [0, 1] {
                let s =
                    ready("stripes", &[("width", Data::Integer(width)), ("smooth", Data::Integer(smooth))]);
                for i in -20..20 {
                    assert_eq!(at(&s, f64::from(i) * 0.17, 0.0), expected);
                }
            }
        }
    }

    #[test]
    fn soft_edges_are_continuous_and_even_on_average() {
        let s = ready("stripes", &[("smooth", Data::Number(0.8))]);
        let (mut sum, mut last) = (0.0, at(&s, -3.0, 0.0).r);
        for i in 1..=8000 {
            let v = at(&s, -3.0 + f64::from(i) / 2000.0, 0.0).r;
            assert!((v - last).abs() < 2e-3);
            (sum, last) = (sum + f64::from(v), v);
        }
        assert!((sum / 8000.0 - 0.5).abs() < 1e-4);
        assert_eq!(at(&s, 0.5, 0.0), Spectrum::WHITE);
        assert_eq!(at(&s, 0.0, 0.0), Spectrum::grey(0.5));
    }
}
