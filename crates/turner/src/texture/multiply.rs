//! The product of two textures.

use super::prepare::{Kind, PrepareContext};
use super::{Mapping, TexturePoint, Textures};
use crate::color::Spectrum;
use crate::schema::{ColorSource, SceneError, params};

params! {
    /// The product of two colours or textures, band by band: for example an image tinted by vertex colours, or a
    /// label under dirt. The opacities are multiplied, too.
    pub struct MultiplyDesc as "multiply" {
        /// The first factor.
        a: ColorSource, required, default ColorSource::Constant(Spectrum::WHITE);
        /// The second factor.
        b: ColorSource, required, default ColorSource::Constant(Spectrum::WHITE);
    }
    example r##"[texture.stained]
type = "multiply"
a = { type = "checkerboard" }
b = { type = "marble" }

[[object]]
type = "sphere"
material = { color = "stained" }
"##
}

/// The product of two textures.
#[derive(Clone, Copy, Debug)]
pub(super) struct Multiply {
    pub(super) a: ColorSource,
    pub(super) b: ColorSource,
}

impl Kind for MultiplyDesc {
    type Prepared = Multiply;
    const MAX_INPUTS: u64 = 2;

    fn sources(&self, visit: &mut dyn FnMut(ColorSource)) {
        visit(self.a);
        visit(self.b);
    }

    fn mapping(&self) -> Mapping {
        Mapping::Solid
    }

    fn prepare(&self, _: &mut PrepareContext<'_>) -> Result<Multiply, SceneError> {
        Ok(Multiply { a: self.a, b: self.b })
    }
}

impl Multiply {
    pub(super) fn eval(&self, textures: &Textures, at: &TexturePoint<'_>) -> Spectrum {
        textures.color(self.a, at) * textures.color(self.b, at)
    }

    /// The smaller spacing of its inputs.
    pub(super) fn spacing(&self, textures: &Textures, at: &TexturePoint<'_>) -> Option<f64> {
        let own = [self.a, self.b].map(|source| textures.spacing(source, at));
        own.into_iter().flatten().reduce(f64::min)
    }

    pub(super) fn memory(&self) -> usize {
        0
    }
}
