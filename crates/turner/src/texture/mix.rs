//! A blend of two textures.

use super::prepare::{Kind, PrepareContext};
use super::{Mapping, TexturePoint, Textures};
use crate::color::Spectrum;
use crate::schema::{ColorSource, SceneError, params};

params! {
    /// Blends two colours or textures by a third: (1 − amount)·a + amount·b. The opacity is blended in the same way.
    pub struct MixDesc as "mix" {
        /// The colour where `amount` is 0.
        a: ColorSource, required, default ColorSource::Constant(Spectrum::BLACK);
        /// The colour where `amount` is 1.
        b: ColorSource, required, default ColorSource::Constant(Spectrum::WHITE);
        /// The weight of `b`: the mean of the colour's three bands, clamped to 0..1.
        amount: ColorSource = ColorSource::Constant(Spectrum::grey(0.5));
    }
    example r##"[texture.worn]
type = "mix"
a = "firebrick"
b = { type = "checkerboard", density = 4 }
amount = { type = "noise" }

[[object]]
type = "sphere"
material = { color = "worn" }
"##
}

/// A blend of two textures.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mix {
    a: ColorSource,
    b: ColorSource,
    amount: ColorSource,
}

impl Kind for MixDesc {
    type Prepared = Mix;
    const MAX_INPUTS: u64 = 3;

    fn sources(&self, visit: &mut dyn FnMut(ColorSource)) {
        visit(self.a);
        visit(self.b);
        visit(self.amount);
    }

    fn mapping(&self) -> Mapping {
        Mapping::Solid
    }

    fn prepare(&self, _: &mut PrepareContext<'_>) -> Result<Mix, SceneError> {
        Ok(Mix { a: self.a, b: self.b, amount: self.amount })
    }
}

impl Mix {
    fn weight(&self, textures: &Textures, at: &TexturePoint<'_>) -> f64 {
        let c = textures.color(self.amount, at);
        f64::from((c.r + c.g + c.b) / 3.0).clamp(0.0, 1.0)
    }

    pub(super) fn eval(&self, textures: &Textures, at: &TexturePoint<'_>) -> Spectrum {
        textures.mix(self.a, self.b, self.weight(textures, at), at)
    }

    pub(super) fn opacity(&self, textures: &Textures, at: &TexturePoint<'_>) -> f32 {
        let t = self.weight(textures, at) as f32;
        let [a, b] = [self.a, self.b].map(|source| textures.opacity(source, at));
        a + (b - a) * t
    }

    /// The smallest spacing of its inputs.
    pub(super) fn spacing(&self, textures: &Textures, at: &TexturePoint<'_>) -> Option<f64> {
        let own = [self.a, self.b, self.amount].map(|source| textures.spacing(source, at));
        own.into_iter().flatten().reduce(f64::min)
    }

    pub(super) fn memory(&self) -> usize {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{at, prepare_texture, text};
    use super::*;
    use crate::schema::value::Data;

    #[test]
    fn the_amount_is_the_share_of_the_second() {
        for (amount, red) in [(0.0, 1.0), (0.25, 0.75), (1.0, 0.0), (7.0, 0.0)] {
            let mix = prepare_texture(
                "mix",
                &[("a", text("red")), ("b", text("blue")), ("amount", Data::Number(amount))],
            );
            assert_eq!(at(&mix, 0.1, 0.2), Spectrum::new(red, 0.0, 1.0 - red), "{amount}");
        }
    }
}
