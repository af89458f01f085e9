//! Stripes of two colours, with exact filtering.
//!
//! The mean over a footprint is a difference of integrals of the stripe profile, divided by the footprint's width.

use super::placement::{floor, fract, smoothstep};
use super::prepare::{Kind, PrepareContext};
use super::{Axis, Mapping, Placement, TexturePoint, Textures};
use crate::color::Spectrum;
use crate::schema::{ColorSource, Range, SceneError, Transform, params};

params! {
    /// Stripes of two colours along an axis. A pair of stripes is two units of texture coordinates wide: over a shape
    /// with (u, v) in 0..1, density 1 shows one stripe of each colour, as the checkerboard does.
    pub struct StripesDesc as "stripes" {
        /// Colour of the stripe that begins at 0, the centre of the surface.
        even: ColorSource = ColorSource::Constant(Spectrum::WHITE);
        /// Colour of the other stripe.
        odd: ColorSource = ColorSource::Constant(Spectrum::BLACK);
        /// Width of the even stripe as a fraction of a pair.
        width: f64 = 0.5, in Range::UNIT;
        /// Softness of the edges: 0 is sharp, 1 is a wave without flat parts.
        smooth: f64 = 0.0, in Range::UNIT;
        /// The axis along which the colours alternate: "x" is the first texture coordinate (u on a surface), "y" the
        /// second (v); "z" is for `mapping = "solid"`.
        axis: Axis = Axis::X;
        /// Number of stripes per unit of texture coordinates.
        density: f64 = 1.0;
        /// Where the texture coordinates come from.
        mapping: Mapping = Mapping::Uv;
        /// For `mapping = "triplanar"`: sharpness of the transitions between the three projections; higher is sharper.
        blend: f64 = 4.0, in Range::closed(1.0, 64.0);
        /// Translates, rotates or scales the pattern.
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
    type Prepared = Stripes;
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

    fn prepare(&self, _: &mut PrepareContext<'_>) -> Result<Stripes, SceneError> {
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
        let position = 0.5 * self.axis.of(self.placement.coordinates(at));
        let width = 0.5 * self.axis.of(self.placement.extent(at));
        // In narrower intervals the difference of integrals would lose its digits.
        let weight = if width < 1e-6 {
            self.odd_fraction(fract(position))
        } else {
            let change =
                self.odd_integral(position + 0.5 * width) - self.odd_integral(position - 0.5 * width);
            let pairs = (floor(position + 0.5 * width) - floor(position - 0.5 * width)) as f64;
            (change + pairs * (1.0 - self.width)) / width
        };
        textures.mix(self.even, self.odd, weight, at)
    }

    /// The integral of [`Stripes::odd_fraction`] from the start of a pair of stripes to a position in it. The
    /// integrand is R(x − w) + 1 − R(x) − R(x − 1), with R a soft edge around 0 and w the width of the even stripe.
    fn odd_integral(&self, position: f64) -> f64 {
        let x = fract(position);
        let soft = 0.5 * self.smooth * self.width.min(1.0 - self.width);
        let edge = |x: f64| edge_integral(x, soft);
        edge(x - self.width) + x - (edge(x) - edge(0.0)) - edge(x - 1.0)
    }

    /// The weight of the odd colour at a position 0..1 within a pair of stripes.
    fn odd_fraction(&self, position: f64) -> f64 {
        let soft = 0.5 * self.smooth * self.width.min(1.0 - self.width);
        if soft == 0.0 {
            return if position < self.width { 0.0 } else { 1.0 };
        }
        // Distance from the centre of the even stripe, with wrap-around.
        let d = (position - 0.5 * self.width).abs();
        let d = d.min(1.0 - d);
        smoothstep(0.5 * self.width - soft, 0.5 * self.width + soft, d)
    }

    /// See [`Placement::spacing`].
    pub(super) fn spacing(&self, _: &Textures, at: &TexturePoint<'_>) -> Option<f64> {
        self.placement.spacing(at)
    }

    pub(super) fn memory(&self) -> usize {
        0
    }
}

/// The integral from −∞ to `x` of a soft edge that rises from 0 to 1 between −soft and soft.
fn edge_integral(x: f64, soft: f64) -> f64 {
    if x <= -soft {
        0.0
    } else if x >= soft {
        x
    } else {
        let t = (x + soft) / (2.0 * soft);
        2.0 * soft * t * t * t * (1.0 - 0.5 * t)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{at, prepare_texture, text};
    use super::*;
    use crate::schema::value::Data;

    #[test]
    fn stripes_alternate_across_zero() {
        let s = prepare_texture("stripes", &[("density", Data::Integer(3))]);
        for i in -9..9 {
            let expected = if i % 2 == 0 { Spectrum::WHITE } else { Spectrum::BLACK };
            assert_eq!(at(&s, (f64::from(i) + 0.5) / 3.0, 0.7), expected, "stripe {i}");
        }
        let s = prepare_texture("stripes", &[("axis", text("y")), ("width", Data::Number(0.25))]);
        assert_eq!(at(&s, 0.3, 0.0), Spectrum::WHITE);
        assert_eq!(at(&s, 0.3, 0.499), Spectrum::WHITE);
        assert_eq!(at(&s, 0.3, 0.5), Spectrum::BLACK);
        assert_eq!(at(&s, 0.3, -1e-300), Spectrum::WHITE);
    }

    #[test]
    fn all_or_nothing() {
        for (width, expected) in [(0, Spectrum::BLACK), (1, Spectrum::WHITE)] {
            for smooth in [0, 1] {
                let s = prepare_texture(
                    "stripes",
                    &[("width", Data::Integer(width)), ("smooth", Data::Integer(smooth))],
                );
                for i in -20..20 {
                    assert_eq!(at(&s, f64::from(i) * 0.17, 0.0), expected);
                }
            }
        }
    }

    #[test]
    fn soft_edges_are_continuous_and_even_on_average() {
        let s = prepare_texture("stripes", &[("smooth", Data::Number(0.8))]);
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

    #[test]
    fn footprints_see_the_mean_of_the_stripes_they_cover() {
        use crate::math::{DVec2, DVec3};
        use crate::schema::TextureId;
        use crate::texture::{Footprint, TexturePoint};
        // `at` gives (s, t, 0) in space, too.
        for (width, smooth) in [(0.5, 0.0), (0.3, 0.0), (0.3, 0.7), (0.8, 1.0), (0.0, 0.5), (1.0, 0.0)] {
            let keys = [
                ("width", Data::Number(width)),
                ("smooth", Data::Number(smooth)),
                ("mapping", text("solid")),
            ];
            let s = prepare_texture("stripes", &keys);
            for (x, size) in [(0.3, 0.2), (-7.7, 1.3), (2.0, 0.01), (5.1, 17.0), (0.0, 2.0)] {
                let mut point = TexturePoint::new(DVec2::ZERO, DVec3::X * x);
                point.footprint = Some(Footprint {
                    p: [DVec3::X * size, DVec3::Y],
                    uv: [DVec2::ZERO; 2],
                    isotropic: false,
                });
                let found = f64::from(s.eval(TextureId(0), &point).r);
                let counted = (0..20_000)
                    .map(|i| f64::from(at(&s, x + size * ((f64::from(i) + 0.5) / 20_000.0 - 0.5), 0.0).r));
                let expected = counted.sum::<f64>() / 20_000.0;
                assert!(
                    (found - expected).abs() < 1e-3,
                    "{width} {smooth} at {x} over {size}: {found} {expected}"
                );
            }
        }
    }
}
