//! A blend of two textures.

use super::prepare::{Kind, PrepareContext};
use super::{Mapping, TexturePoint, Textures};
use crate::color::Spectrum;
use crate::math::DVec3;
use crate::schema::{ColorSource, ErrorCode, SceneError, params};

params! {
    /// Blends two colours or textures by a third: (1 − amount)·a + amount·b. The opacity is blended in the same way.
    pub struct MixDesc as "mix" {
        /// The colour where `amount` is 0.
        a: ColorSource, required, default ColorSource::Constant(Spectrum::BLACK);
        /// The colour where `amount` is 1.
        b: ColorSource, required, default ColorSource::Constant(Spectrum::WHITE);
        /// The weight of `b`: the mean of the colour's three bands, clamped to 0..1.
        amount: ColorSource = ColorSource::Constant(Spectrum::grey(0.5));
        /// Instead of `amount`: the weight of `b` is |n · d|, with the geometric normal n in world space and this direction
        /// d. `b` then lies on what faces along d or against it.
        direction: Option<DVec3> = None;
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
    /// Of length 1.
    direction: Option<DVec3>,
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
        let unit = |d: DVec3| {
            d.try_normalize().ok_or_else(|| {
                SceneError::new(ErrorCode::OutOfRange, format!("the `direction` of a mix is {d}"))
                    .help("its length must be greater than 0")
            })
        };
        let direction = self.direction.map(unit).transpose()?;
        Ok(Mix { a: self.a, b: self.b, amount: self.amount, direction })
    }
}

impl Mix {
    fn weight(&self, textures: &Textures, at: &TexturePoint<'_>) -> f64 {
        if let Some(direction) = self.direction {
            // Normals are transformed by the inverse transpose.
            let n = at.to_world.map_or(at.n, |m| m.matrix3.inverse().transpose() * at.n);
            let cos = n.dot(direction).abs() / n.length();
            return if cos.is_finite() { cos.min(1.0) } else { 0.0 };
        }
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

    /// The normal in space counts, also of shapes that are stretched.
    #[test]
    fn a_direction_is_an_amount() {
        use crate::math::{DAffine3, DVec2};
        let [a, b] = [Spectrum::BLACK, Spectrum::WHITE].map(ColorSource::Constant);
        let amount = ColorSource::Constant(Spectrum::BLACK);
        let share = |n: DVec3, to_world: Option<&DAffine3>| {
            let mix = Mix { a, b, amount, direction: Some(DVec3::Y) };
            let at = TexturePoint { n, to_world, ..TexturePoint::new(DVec2::ZERO, DVec3::ONE) };
            mix.eval(&Textures::default(), &at).g
        };
        assert_eq!(share(DVec3::NEG_Y, None), 1.0);
        assert_eq!(share(DVec3::X, None), 0.0);
        assert!((share(DVec3::new(0.6, -0.8, 0.0), None) - 0.8).abs() < 1e-6);
        let stretched = DAffine3::from_scale(DVec3::new(2.0, 1.0, 1.0));
        let n = DVec3::new(1.0, 1.0, 0.0).normalize();
        assert!((share(n, Some(&stretched)) - 2.0 / 5f32.sqrt()).abs() < 1e-6);
    }

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
