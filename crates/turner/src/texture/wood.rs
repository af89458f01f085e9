//! Wood: annual rings around a trunk, and fibres along it.
//!
//! In coordinates whose z axis is the trunk's axis, the ring number at radius ρ = √(x² + y²) is rings·(ρ +
//! distortion·fbm), plus a slow noise of itself, because years differ. Within a ring the colour darkens from the
//! light, wide early wood to the dark, thin late wood, and falls back within a few hundredths of the ring. Fibres are
//! noise stretched about twenty-fold along the trunk.

use super::placement::{floor, smoothstep};
use super::prepare::{Kind, PrepareContext};
use super::{Fractal, Mapping, Perlin, Placement, TexturePoint, Textures, Tint};
use crate::color::Spectrum;
use crate::math::{DVec3, Frame};
use crate::schema::{ColorSource, ErrorCode, Range, SceneError, Transform, params};

params! {
    /// Wood: annual rings around a trunk through the solid. By default the pith (the centre of the trunk) passes
    /// behind and to the left of the shape, so that rings, arches and grain are visible; `pith = [0, 0, 0]` centres
    /// it.
    pub struct WoodDesc as "wood" {
        /// Colour of the early wood, which grows in spring.
        light: Tint = Tint::Display(0xd9a066);
        /// Colour of the late wood, which grows in summer, and of the fibres.
        dark: Tint = Tint::Display(0x7a4420);
        /// Number of rings per unit of texture coordinates.
        rings: f64 = 12.0, in Range::closed(0.0, 1e6);
        /// How far the rings deviate from circles: 0 is exact circles.
        distortion: f64 = 0.25, in Range::closed(0.0, 1000.0);
        /// Strength of the fibres; 0 is none.
        grain: f64 = 0.5, in Range::UNIT;
        /// A point on the pith, the centre line of the trunk.
        pith: DVec3 = DVec3::new(-0.45, 0.0, -0.6);
        /// Direction of the trunk, of any length.
        axis: DVec3 = DVec3::new(0.15, 1.0, -0.25);
        /// Seed: another value gives another tree.
        seed: u32 = 0;
        /// Scales the pattern: with density 2 it is half as large.
        density: f64 = 1.0;
        /// Where the texture coordinates come from.
        mapping: Mapping = Mapping::Solid;
        /// For `mapping = "triplanar"`: sharpness of the transitions between the three projections; higher is sharper.
        blend: f64 = 4.0, in Range::closed(1.0, 64.0);
        /// Translates, rotates or scales the trunk.
        transform: Transform = Transform::IDENTITY;
    }
    example r##"[texture.oak]
type = "wood"

[[object]]
type = "sphere"
material = { color = "oak" }
"##
}

/// Wood.
#[derive(Clone, Debug)]
pub(super) struct Wood {
    light: ColorSource,
    dark: ColorSource,
    rings: f64,
    distortion: f64,
    grain: f64,
    pith: DVec3,
    trunk: Frame,
    bend: Fractal,
    years: Perlin,
    fibres: Fractal,
    placement: Placement,
}

impl Kind for WoodDesc {
    type Prepared = Wood;
    const MAX_INPUTS: u64 = 2;

    fn sources(&self, visit: &mut dyn FnMut(ColorSource)) {
        self.light.visit(visit);
        self.dark.visit(visit);
    }

    fn mapping(&self) -> Mapping {
        self.mapping
    }

    fn triplanar(&self) -> Option<(f64, Transform)> {
        (self.mapping == Mapping::Triplanar).then_some((self.blend, self.transform))
    }

    fn prepare(&self, cx: &mut PrepareContext<'_>) -> Result<Wood, SceneError> {
        let axis = self
            .axis
            .try_normalize()
            .ok_or_else(|| SceneError::new(ErrorCode::OutOfRange, "the `axis` of wood must not be zero"))?;
        let seed = u64::from(self.seed) << 8;
        Ok(Wood {
            light: self.light.resolve(cx.transfer),
            dark: self.dark.resolve(cx.transfer),
            rings: self.rings,
            distortion: self.distortion,
            grain: self.grain,
            pith: self.pith,
            trunk: Frame::from_z(axis),
            bend: Fractal::new(seed + 1, 3, 2.1, 0.4),
            years: Perlin::new(seed + 2),
            fibres: Fractal::new(seed + 3, 2, 2.3, 0.6),
            placement: Placement::new(self.mapping, self.density, self.transform),
        })
    }
}

/// The mean weight of late wood over a year: a rise from 0.15 to 0.92 and a fall from 0.94 to 1, each with half of
/// its length, and the plateau in between.
const MEAN_LATE: f64 = 0.5 * 0.77 + 0.02 + 0.5 * 0.06;

impl Wood {
    pub(super) fn eval(&self, textures: &Textures, at: &TexturePoint<'_>) -> Spectrum {
        let width = self.placement.width(at);
        let q = self.trunk.to_local(self.placement.coordinates(at) - self.pith);
        let radius = (q.x * q.x + q.y * q.y).sqrt();
        let bend = self.bend.fbm(DVec3::new(0.9 * q.x, 0.9 * q.y, 0.35 * q.z), 0.9 * width);
        let ring = self.rings * (radius + self.distortion * bend);
        let ring = ring + 0.8 * self.years.at(DVec3::new(0.35 * ring, 0.5, 0.5));
        let year = floor(ring) as f64;
        let season = ring - year;
        let late = smoothstep(0.15, 0.92, season) * (1.0 - smoothstep(0.94, 1.0, season));
        // A footprint of one ring or more: the mean of a year.
        let rings = self.rings * (1.0 + self.distortion) * width;
        let lost = if rings > 0.0 { smoothstep(0.3, 1.2, rings) } else { 0.0 };
        let late = late + lost * (MEAN_LATE - late);
        let strength = 0.62 + 0.5 * (1.0 - lost) * self.years.at(DVec3::new(0.5, 0.37 * year, 7.5));
        let fibre = self.fibres.fbm(DVec3::new(56.0 * q.x, 56.0 * q.y, 2.4 * q.z), 56.0 * width);
        let dark = 0.08 + strength * late + self.grain * (0.55 * fibre + 0.25 * fibre.abs());
        textures.mix(self.light, self.dark, dark, at)
    }

    /// See [`Placement::spacing`].
    pub(super) fn spacing(&self, _: &Textures, at: &TexturePoint<'_>) -> Option<f64> {
        self.placement.spacing(at)
    }

    pub(super) fn memory(&self) -> usize {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{at, list, prepare_texture, read};
    use super::*;
    use crate::color::Transfer;
    use crate::schema::value::Data;

    #[test]
    fn without_noise_rings_are_round_about_the_axis() {
        let keys = [
            ("distortion", Data::Integer(0)),
            ("grain", Data::Integer(0)),
            ("pith", list(&[0.0, 0.0, 0.0])),
            ("axis", list(&[0.0, 0.0, 5.0])),
        ];
        let wood = prepare_texture("wood", &keys);
        for i in 0..50 {
            let r = f64::from(i) / 40.0;
            let a = at(&wood, r, 0.0);
            assert!((a - at(&wood, 0.0, -r)).map(f32::abs).max_component() < 1e-6);
            assert!((a - at(&wood, 0.6 * r, 0.8 * r)).map(f32::abs).max_component() < 1e-3);
        }
    }

    #[test]
    fn a_trunk_needs_a_direction() {
        let scene = read("wood", &[("axis", list(&[0.0, 0.0, 0.0]))]).unwrap();
        let error = Textures::prepare(&scene.textures, &[], Transfer::None, false).unwrap_err();
        assert_eq!(error.code, ErrorCode::OutOfRange);
        assert!(error.span.is_some());
    }
}
