//! A constant colour.

use super::prepare::{Kind, PrepareContext};
use super::{Mapping, TexturePoint, Textures};
use crate::color::Spectrum;
use crate::schema::{ColorSource, SceneError, params};

params! {
    /// The same colour everywhere. Use it to give a colour a name.
    pub struct ConstantDesc as "constant" {
        /// The colour.
        color: Spectrum = Spectrum::WHITE;
    }
    example r##"[texture.brick]
type = "constant"
color = "firebrick"

[[object]]
type = "sphere"
material = { color = "brick" }
"##
}

/// A constant colour.
#[derive(Clone, Copy, Debug)]
pub(super) struct Constant(Spectrum);

impl Kind for ConstantDesc {
    type Prepared = Constant;
    const MAX_INPUTS: u64 = 0;

    fn sources(&self, _: &mut dyn FnMut(ColorSource)) {}

    fn mapping(&self) -> Mapping {
        Mapping::Solid
    }

    fn prepare(&self, _: &mut PrepareContext<'_>) -> Result<Constant, SceneError> {
        Ok(Constant(self.color))
    }
}

impl Constant {
    pub(super) fn eval(&self, _: &Textures, _: &TexturePoint<'_>) -> Spectrum {
        self.0
    }

    /// It has no scale.
    pub(super) fn spacing(&self, _: &Textures, _: &TexturePoint<'_>) -> Option<f64> {
        None
    }

    pub(super) fn memory(&self) -> usize {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{at, prepare_texture, text};
    use super::*;

    #[test]
    fn it_is_the_same_everywhere() {
        let red = prepare_texture("constant", &[("color", text("red"))]);
        assert_eq!(at(&red, 0.1, -7.0), Spectrum::new(1.0, 0.0, 0.0));
    }
}
