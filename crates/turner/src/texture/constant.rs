//! One colour.

use super::prepare::{Kind, Preparing};
use super::{Mapping, TexturePoint, Textures};
use crate::color::Spectrum;
use crate::schema::{ColorSource, SceneError, params};

params! {
    /// The same colour everywhere: gives a colour a name.
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

/// One colour.
#[derive(Clone, Copy, Debug)]
pub(super) struct Constant(Spectrum);

impl Kind for ConstantDesc {
    type Ready = Constant;
    const AT_ONCE: u64 = 0;

    fn sources(&self, _: &mut dyn FnMut(ColorSource)) {}

    fn mapping(&self) -> Mapping {
        Mapping::Solid
    }

    fn prepare(&self, _: &mut Preparing<'_>) -> Result<Constant, SceneError> {
        Ok(Constant(self.color))
    }
}

impl Constant {
    pub(super) fn eval(&self, _: &Textures, _: &TexturePoint<'_>) -> Spectrum {
        self.0
    }

    /// It has no measure of its own.
    pub(super) fn spacing(&self, _: &Textures, _: &TexturePoint<'_>) -> Option<f64> {
        None
    }

    pub(super) fn memory(&self) -> usize {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{at, ready, text};
    use super::*;

    #[test]
    fn it_is_the_same_everywhere() {
        let red = ready("constant", &[("color", text("red"))]);
        assert_eq!(at(&red, 0.1, -7.0), Spectrum::new(1.0, 0.0, 0.0));
    }
}
