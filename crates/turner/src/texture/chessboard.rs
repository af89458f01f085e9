//! Squares of two colours.

use super::placement::floor;
use super::prepare::{Kind, Preparing};
use super::{Mapping, Placement, TexturePoint, Textures};
use crate::color::Spectrum;
use crate::scene::schema::params;
use crate::scene::transform::Transform;
use crate::scene::{ColorSource, SceneError};

params! {
    /// Squares (cubes with `mapping = "solid"`) of two colours, one unit of texture coordinates wide: with density 1 four
    /// squares cover a shape, with density 4 sixteen by four.
    pub struct ChessboardDesc as "chessboard" {
        /// Colour of the squares that touch the corner (0, 0) from above right.
        even: ColorSource = ColorSource::Constant(Spectrum::WHITE);
        /// Colour of the others.
        odd: ColorSource = ColorSource::Constant(Spectrum::BLACK);
        /// Number of squares per unit of texture coordinates.
        density: f64 = 1.0;
        /// Whether the pattern lies on the surface or goes through the solid.
        mapping: Mapping = Mapping::Uv;
        /// Moves the pattern.
        transform: Transform = Transform::IDENTITY;
    }
    example r##"[texture.board]
type = "chessboard"
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
pub(super) struct Chessboard {
    even: ColorSource,
    odd: ColorSource,
    placement: Placement,
}

impl Kind for ChessboardDesc {
    type Ready = Chessboard;
    const AT_ONCE: u64 = 1;

    fn sources(&self, visit: &mut dyn FnMut(ColorSource)) {
        visit(self.even);
        visit(self.odd);
    }

    fn mapping(&self) -> Mapping {
        self.mapping
    }

    fn prepare(&self, _: &mut Preparing<'_>) -> Result<Chessboard, SceneError> {
        let placement = Placement::new(self.mapping, self.density, self.transform);
        Ok(Chessboard { even: self.even, odd: self.odd, placement })
    }
}

impl Chessboard {
    /// Parity of the three cell numbers.
    pub(super) fn eval(&self, textures: &Textures, at: &TexturePoint<'_>) -> Spectrum {
        let c = self.placement.coordinates(at);
        let odd = (floor(c.x) + floor(c.y) + floor(c.z)) & 1 == 1;
        textures.color(if odd { self.odd } else { self.even }, at)
    }

    pub(super) fn memory(&self) -> usize {
        0
    }
}
