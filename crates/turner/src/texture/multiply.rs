//! Two textures multiplied.

use super::prepare::{Kind, Preparing};
use super::{Mapping, TexturePoint, Textures};
use crate::color::Spectrum;
use crate::schema::{ColorSource, SceneError, params};

params! {
    /// Two colours or textures multiplied, band by band: a picture tinted by vertex colours, a label under dirt. The opacity of the product
    /// is the product of theirs.
    pub struct MultiplyDesc as "multiply" {
        /// One.
        a: ColorSource, required, default ColorSource::Constant(Spectrum::WHITE);
        /// The other.
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

/// Two textures multiplied.
#[derive(Clone, Copy, Debug)]
pub(super) struct Product {
    pub(super) a: ColorSource,
    pub(super) b: ColorSource,
}

impl Kind for MultiplyDesc {
    type Ready = Product;
    const AT_ONCE: u64 = 2;

    fn sources(&self, visit: &mut dyn FnMut(ColorSource)) {
        visit(self.a);
        visit(self.b);
    }

    fn mapping(&self) -> Mapping {
        Mapping::Solid
    }

    fn prepare(&self, _: &mut Preparing<'_>) -> Result<Product, SceneError> {
        Ok(Product { a: self.a, b: self.b })
    }
}

impl Product {
    pub(super) fn eval(&self, textures: &Textures, at: &TexturePoint<'_>) -> Spectrum {
        textures.color(self.a, at) * textures.color(self.b, at)
    }

    /// The shorter of theirs.
    pub(super) fn spacing(&self, textures: &Textures, at: &TexturePoint<'_>) -> Option<f64> {
        let own = [self.a, self.b].map(|source| textures.spacing(source, at));
        own.into_iter().flatten().reduce(f64::min)
    }

    pub(super) fn memory(&self) -> usize {
        0
    }
}
