//! Marble: veins drawn by a sine that turbulence displaces (after Perlin 1985, "An image synthesizer").
//!
//! φ = π·(veins·d·p + distortion·fbm(p)); a vein stands where sin φ = 0, thin with sharp = 1 and washed out with
//! sharp = 0. It fades in and out along its course, and clouds of a third colour lie in the stone.

use super::placement::smoothstep;
use super::prepare::{Kind, Preparing};
use super::{Fractal, Mapping, Placement, TexturePoint, Textures, Tint};
use crate::color::Spectrum;
use crate::math::DVec3;
use crate::math::elementary::sin;
use crate::scene::schema::{Range, params};
use crate::scene::transform::Transform;
use crate::scene::{ColorSource, SceneError};

params! {
    /// Marble: dark veins through a light, cloudy stone. The veins follow one another across the diagonal of the solid.
    pub struct MarbleDesc as "marble" {
        /// The stone.
        base: Tint = Tint::Display(0xf2efe9);
        /// The clouds in it.
        cloud: Tint = Tint::Display(0xbfc3c6);
        /// The veins.
        vein: Tint = Tint::Display(0x3d4249);
        /// Number of veins per unit of texture coordinates.
        veins: f64 = 1.3, in Range::closed(0.0, 1e6);
        /// How far the veins stray from planes.
        distortion: f64 = 2.2, in Range::closed(0.0, 1000.0);
        /// Thinness of the veins, 0 to 1.
        sharp: f64 = 0.8, in Range::UNIT;
        /// Another number, another stone.
        seed: u32 = 0;
        /// Scales the whole pattern: twice as much, half as large.
        density: f64 = 1.0;
        /// Whether the pattern lies on the surface or goes through the solid.
        mapping: Mapping = Mapping::Solid;
        /// Moves and turns the stone.
        transform: Transform = Transform::IDENTITY;
    }
    example r##"[texture.carrara]
type = "marble"

[[object]]
type = "sphere"
material = { color = "carrara" }
"##
}

/// Marble.
#[derive(Clone, Debug)]
pub(super) struct Marble {
    base: ColorSource,
    cloud: ColorSource,
    vein: ColorSource,
    veins: f64,
    distortion: f64,
    sharp: f64,
    displacement: Fractal,
    clouds: Fractal,
    placement: Placement,
}

/// What the veins follow one another along: (4, 5, −2)/√45.
const ACROSS: DVec3 = DVec3::new(0.596_284_793_999_944, 0.745_355_992_499_93, -0.298_142_396_999_972);

impl Kind for MarbleDesc {
    type Ready = Marble;
    const AT_ONCE: u64 = 3;

    fn sources(&self, visit: &mut dyn FnMut(ColorSource)) {
        self.base.visit(visit);
        self.cloud.visit(visit);
        self.vein.visit(visit);
    }

    fn mapping(&self) -> Mapping {
        self.mapping
    }

    fn prepare(&self, cx: &mut Preparing<'_>) -> Result<Marble, SceneError> {
        let seed = u64::from(self.seed) << 8;
        Ok(Marble {
            base: self.base.resolve(cx.transfer),
            cloud: self.cloud.resolve(cx.transfer),
            vein: self.vein.resolve(cx.transfer),
            veins: self.veins,
            distortion: self.distortion,
            sharp: self.sharp,
            displacement: Fractal::new(seed + 1, 7, 2.05, 0.52),
            clouds: Fractal::new(seed + 2, 5, 2.0, 0.5),
            placement: Placement::new(self.mapping, self.density, self.transform),
        })
    }
}

impl Marble {
    pub(super) fn eval(&self, textures: &Textures, at: &TexturePoint) -> Spectrum {
        let p = self.placement.coordinates(at);
        let shift = self.displacement.fbm(1.1 * p);
        let phase = self.veins * ACROSS.dot(p) + self.distortion * shift;
        let away = sin(std::f64::consts::PI * phase).abs();
        let clouds = self.clouds.fbm(0.9 * p + DVec3::splat(0.6 * shift));
        // A vein is darkest where the clouds are; elsewhere it is a hair or lost.
        let strength = smoothstep(-0.35, 0.3, clouds);
        let width = 1.0 - 0.9 * self.sharp;
        let core = 1.0 - smoothstep(0.0, width * (0.4 + 0.6 * strength), away);
        let halo = (1.0 - away) * (1.0 - away) * 0.45;
        let cloudy = smoothstep(-0.25, 0.55, clouds) + halo;
        let veined = core * (0.15 + 0.75 * strength);
        if veined >= 1.0 {
            return textures.color(self.vein, at);
        }
        let stone = textures.mix(self.base, self.cloud, cloudy, at);
        if veined > 0.0 { stone.lerp(textures.color(self.vein, at), veined as f32) } else { stone }
    }

    pub(super) fn memory(&self) -> usize {
        0
    }
}
