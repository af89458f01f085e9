//! Lights. Each type has its own file; [`LightDesc`] is the table of their names in a scene.
//! These lights are separate from emissive objects, which are materials; [`emission`] samples the shapes of emissive
//! objects.
//!
//! The contract of every [`Light`]:
//!
//! - Everything is in world space. Directions point from the surface towards the light.
//! - [`Light::illuminate`] takes the lit point and does not test visibility. `to_light` is not normalised. For a
//!   light at a finite distance (`finite`) it reaches to the light, so a shadow ray ends at t = 1; for a directional
//!   or environment light the shadow ray has no end. `intensity` excludes the cosine at the surface. `None` means
//!   that no light arrives: the point is outside a cone, or at the light itself.
//! - `intensity` is colour × intensity × attenuation, in the units of classic ray tracing: a diffuse surface of
//!   colour C that faces the light returns C times it. Physical integrators take it for irradiance, so that a
//!   Lambertian surface returns C/π times it. For this reason samples of an environment are divided by π here.
//! - A light with an extent is sampled `samples()` times, once in each stratum, at a position given by `jitter`; the
//!   caller sums the results. [`Light::illuminate_at`] takes one point that stands for the complete light.
//! - Environments and directional lights with an angle have radiance and a pdf per solid angle (cosine not included),
//!   greater than 0 wherever a sample comes from; `sample` and `pdf` agree. `None` means no sample, never an error.
//! - Delta lights ([`Light::is_delta`]), which rays cannot hit, have no pdf; the probability of choosing the light
//!   stands for it.
//! - [`Light::around`] is the radiance of an infinite light that a ray finds when it leaves the scene in a unit
//!   direction (away from the scene); `None` for every other light.
//! - [`LightBound`] bounds position, emission directions and power. The light tree chooses by it.

mod ambient;
mod area;
mod background;
mod bound;
mod directional;
#[cfg(test)]
mod distant_tests;
pub mod emission;
mod environment;
#[cfg(test)]
mod light_tree_tests;
mod motion;
mod point;
mod profile;
mod sky;
mod slide;
mod spot;
mod tree;

pub use ambient::AmbientDesc;
pub use area::{AreaLight, DiskLightDesc, RectangleLightDesc, SphereLightDesc};
pub use background::BackgroundDesc;
pub use bound::LightBound;
pub use directional::{Directional, DirectionalDesc};
pub use environment::{
    AdaptiveEnvironment, EnvironmentBatch, EnvironmentDesc, EnvironmentLearning, EnvironmentLight,
    EnvironmentSample, MapPoles,
};
pub use point::{Point, PointDesc};
pub use profile::ProfileUnits;
pub use sky::SkyDesc;
pub use slide::SlideUnits;
pub use spot::{Spot, SpotDesc};
pub(crate) use tree::BY_COSINE;
pub(crate) use tree::ChosenLight;
pub use tree::{LightTree, NO_CELL, Receiver};

use crate::color::Spectrum;
use crate::image::Image;
use crate::math::{DVec2, DVec3};
use crate::sampler::stratified;
use crate::schema::value::{Data, Value};
use crate::schema::{
    Asset, ErrorCode, ImageId, ParamType, ReadContext, SceneError, WriteContext, choice, family, wrong_type,
};

family! {
    /// Lights: the `type` of a `[[light]]`. Each has a `color` and an `intensity`; the light that arrives is their
    /// product, reduced by `attenuation`.
    pub enum LightDesc as "light", "lights" {
        Ambient(AmbientDesc),
        Point(PointDesc),
        Directional(DirectionalDesc),
        Spot(SpotDesc),
        Rectangle(RectangleLightDesc),
        Disk(DiskLightDesc),
        Sphere(SphereLightDesc),
        Environment(EnvironmentDesc),
        Sky(SkyDesc),
    }
}

/// Default position of a light added by a program: above a scene at the origin, not inside it.
pub(crate) const DEFAULT_POSITION: DVec3 = DVec3::new(0.0, 5.0, 0.0);

choice! {
    /// How light falls off with distance, by name.
    pub enum AttenuationKind {
        /// No falloff.
        None = "none",
        /// Falls off as 1/d².
        InverseSquare = "inverse-square",
    }
}

/// How light falls off with the distance d: 1 / (c + l·d + q·d²).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attenuation {
    /// The coefficients c, l, q.
    pub coefficients: [f64; 3],
}

impl Attenuation {
    /// No falloff.
    pub const NONE: Attenuation = Attenuation { coefficients: [1.0, 0.0, 0.0] };

    /// The factor at a distance.
    #[inline]
    pub fn factor(&self, distance: f64) -> f64 {
        let [c, l, q] = self.coefficients;
        if l == 0.0 && q == 0.0 {
            return 1.0 / c;
        }
        1.0 / (c + distance * (l + distance * q))
    }
}

impl ParamType for Attenuation {
    fn kind() -> String {
        "\"none\" | \"inverse-square\" | [constant, linear, quadratic]".into()
    }
    fn read(value: &Value, cx: &mut dyn ReadContext) -> Result<Attenuation, SceneError> {
        let coefficients = match &value.data {
            Data::Array(_) => <[f64; 3]>::read(value, cx)?,
            Data::String(_) => match AttenuationKind::read(value, cx)? {
                AttenuationKind::None => [1.0, 0.0, 0.0],
                AttenuationKind::InverseSquare => [0.0, 0.0, 1.0],
            },
            _ => return Err(wrong_type(value, &Self::kind())),
        };
        if coefficients.iter().any(|v| *v < 0.0) || coefficients.iter().all(|v| *v == 0.0) {
            let message = "the coefficients of an attenuation must be 0 or more, and not all 0";
            return Err(SceneError::at(ErrorCode::OutOfRange, value.span, message));
        }
        Ok(Attenuation { coefficients })
    }
    fn show(&self) -> String {
        match self.coefficients {
            [1.0, 0.0, 0.0] => "\"none\"".into(),
            [0.0, 0.0, 1.0] => "\"inverse-square\"".into(),
            c => c.show(),
        }
    }
    fn write(&self, cx: &mut dyn WriteContext) -> Result<Option<Data>, SceneError> {
        match self.coefficients {
            [1.0, 0.0, 0.0] => AttenuationKind::None.write(cx),
            [0.0, 0.0, 1.0] => AttenuationKind::InverseSquare.write(cx),
            coefficients => coefficients.write(cx),
        }
    }
}

/// Light that arrives at a point from one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Illumination {
    /// Towards the light, not normalised: its length is the distance for lights at a finite distance.
    pub to_light: DVec3,
    /// Whether the light is at a finite distance: then only objects nearer than the light cast a shadow.
    pub finite: bool,
    /// Colour times intensity times attenuation.
    pub intensity: Spectrum,
}

/// Directions in which [`Light::illuminate`] samples an environment or the disc of a directional light, or points of a
/// spot light with a radius: enough for
/// soft shadows without much noise.
const ENVIRONMENT_SAMPLES: u32 = 16;

/// Position of direction `i` in the unit square: in its stratum.
fn stratum(i: u32, jitter: DVec2) -> [f64; 2] {
    [(f64::from(i) + jitter.x) / f64::from(ENVIRONMENT_SAMPLES), jitter.y]
}

/// A prepared light.
#[derive(Clone, Debug)]
pub enum Light {
    /// Point.
    Point(point::Point),
    /// Directional.
    Directional(directional::Directional),
    /// Spot.
    Spot(spot::Spot),
    /// Rectangle, disk or sphere.
    Area(area::AreaLight),
    /// Environment or sky.
    Environment(EnvironmentLight),
}

impl LightDesc {
    /// The image that the light is made from.
    pub(crate) fn picture(&self) -> Option<ImageId> {
        match self {
            LightDesc::Environment(l) => l.file,
            LightDesc::Ambient(_)
            | LightDesc::Point(_)
            | LightDesc::Directional(_)
            | LightDesc::Spot(_)
            | LightDesc::Rectangle(_)
            | LightDesc::Disk(_)
            | LightDesc::Sphere(_)
            | LightDesc::Sky(_) => None,
        }
    }

    /// How it falls off with distance; `None` for lights at infinity and ambient light.
    pub(crate) fn attenuation(&self) -> Option<Attenuation> {
        match self {
            LightDesc::Point(l) => Some(l.attenuation),
            LightDesc::Spot(l) => Some(l.attenuation),
            LightDesc::Rectangle(l) => Some(l.attenuation),
            LightDesc::Disk(l) => Some(l.attenuation),
            LightDesc::Sphere(l) => Some(l.attenuation),
            LightDesc::Ambient(_)
            | LightDesc::Directional(_)
            | LightDesc::Environment(_)
            | LightDesc::Sky(_) => None,
        }
    }

    /// Prepares the light and appends it to `lights`. Returns the colour of an ambient light, which is not appended;
    /// black for every other light.
    pub(crate) fn prepare(
        &self,
        setting: &LightSetting<'_>,
        lights: &mut Vec<Light>,
    ) -> Result<Spectrum, SceneError> {
        let light = match self {
            LightDesc::Ambient(l) => return Ok(l.color * l.intensity as f32),
            LightDesc::Point(l) => Light::Point(l.prepare()?),
            LightDesc::Directional(l) => Light::Directional(l.prepare()?),
            LightDesc::Spot(l) => Light::Spot(l.prepare(setting.images)?),
            LightDesc::Rectangle(l) => Light::Area(l.prepare()?),
            LightDesc::Disk(l) => Light::Area(l.prepare()?),
            LightDesc::Sphere(l) => Light::Area(l.prepare()),
            LightDesc::Environment(l) => Light::Environment(l.prepare_again(setting)?),
            LightDesc::Sky(l) => {
                let (around, sun) = l.prepare(setting)?;
                lights.extend(sun.map(Light::Directional));
                Light::Environment(around)
            }
        };
        lights.push(light);
        Ok(Spectrum::BLACK)
    }
}

/// Inputs of the preparation of a light.
#[derive(Clone, Copy)]
pub(crate) struct LightSetting<'a> {
    /// The images of the scene.
    pub(crate) images: &'a [Asset<Image>],
    /// For environments: see [`EnvironmentDesc::prepare`].
    pub(crate) compensated: bool,
    /// Whether the integrator is physical.
    pub(crate) physical: bool,
    /// Number of threads; 0 uses all.
    pub(crate) threads: usize,
    /// The result of the last preparation of this light, before an edit. Images and sampling tables that are still valid
    /// are reused.
    pub(crate) before: &'a [Light],
}

impl<'a> LightSetting<'a> {
    /// The environments in `before`.
    fn environments(&self) -> impl Iterator<Item = &'a EnvironmentLight> {
        self.before.iter().filter_map(|light| match light {
            Light::Environment(light) => Some(light),
            Light::Point(_) | Light::Directional(_) | Light::Spot(_) | Light::Area(_) => None,
        })
    }
}

/// A light of the same intensity everywhere: all that [`Light::illuminate`] needs for a batch of points.
#[derive(Clone, Copy, Debug)]
pub enum Uniform {
    /// A point light.
    Point {
        /// Its position.
        position: DVec3,
        /// Colour times intensity.
        intensity: Spectrum,
    },
    /// A directional light.
    Directional {
        /// Towards the light.
        to_light: DVec3,
        /// Colour times intensity.
        intensity: Spectrum,
    },
}

impl Uniform {
    /// Colour times intensity.
    pub fn intensity(&self) -> Spectrum {
        match self {
            Uniform::Point { intensity, .. } | Uniform::Directional { intensity, .. } => *intensity,
        }
    }
}

impl Light {
    /// This light, if its intensity is the same everywhere.
    pub fn uniform(&self) -> Option<Uniform> {
        match self {
            Light::Point(l) => l.uniform(),
            Light::Directional(l) if !l.is_disc() => {
                let Illumination { to_light, intensity, .. } = l.illuminate();
                Some(Uniform::Directional { to_light, intensity })
            }
            Light::Directional(_) | Light::Spot(_) | Light::Area(_) | Light::Environment(_) => None,
        }
    }

    /// The point of the light that `u` in the unit square chooses; `None` for lights at infinity.
    pub fn point(&self, u: [f64; 2]) -> Option<DVec3> {
        match self {
            Light::Point(l) => Some(l.position()),
            Light::Spot(l) => Some(l.point(u.into())),
            Light::Area(l) => Some(l.point(u.into())),
            Light::Directional(_) | Light::Environment(_) => None,
        }
    }

    /// Whether rays cannot hit it: point, spot and area lights, and directional lights without an angle.
    pub fn is_delta(&self) -> bool {
        match self {
            Light::Point(_) | Light::Spot(_) | Light::Area(_) => true,
            Light::Directional(l) => !l.is_disc(),
            Light::Environment(_) => false,
        }
    }

    /// Whether it is at a finite distance.
    pub fn is_finite(&self) -> bool {
        match self {
            Light::Point(_) | Light::Spot(_) | Light::Area(_) => true,
            Light::Directional(_) | Light::Environment(_) => false,
        }
    }

    /// Its position, if it is a point or spot light.
    pub fn position(&self) -> Option<DVec3> {
        match self {
            Light::Point(l) => Some(l.position()),
            Light::Spot(l) => Some(l.position()),
            Light::Directional(_) | Light::Area(_) | Light::Environment(_) => None,
        }
    }

    /// Radius of the sphere around [`position`](Light::position) that emits; 0 for a point.
    pub fn radius(&self) -> f64 {
        match self {
            Light::Spot(l) => l.radius(),
            Light::Point(_) | Light::Directional(_) | Light::Area(_) | Light::Environment(_) => 0.0,
        }
    }

    /// Number of shadow rays per shading point.
    #[inline]
    pub fn samples(&self) -> u32 {
        match self {
            Light::Area(l) => l.samples,
            Light::Environment(_) => ENVIRONMENT_SAMPLES,
            Light::Directional(l) if l.is_disc() => ENVIRONMENT_SAMPLES,
            Light::Spot(l) if l.radius() > 0.0 => ENVIRONMENT_SAMPLES,
            Light::Point(_) | Light::Directional(_) | Light::Spot(_) => 1,
        }
    }

    /// Pixels of an environment that count as 0 because they are negative or non-finite.
    pub fn invalid_pixels(&self) -> u64 {
        match self {
            Light::Environment(l) => l.invalid_pixels(),
            Light::Point(_) | Light::Directional(_) | Light::Spot(_) | Light::Area(_) => 0,
        }
    }

    /// Radiance of an infinite light from a unit direction; `None` for other lights.
    pub fn around(&self, direction: DVec3) -> Option<Spectrum> {
        match self {
            Light::Environment(l) => Some(l.radiance(direction)),
            Light::Point(_) | Light::Directional(_) | Light::Spot(_) | Light::Area(_) => None,
        }
    }

    /// Whether [`Light::illuminate`] uses its `jitter`.
    #[inline]
    pub fn is_jittered(&self) -> bool {
        match self {
            Light::Environment(_) => true,
            Light::Directional(l) => l.is_disc(),
            Light::Area(l) => l.jitter,
            Light::Spot(l) => l.radius() > 0.0,
            Light::Point(_) => false,
        }
    }

    /// Light that arrives at `p` from sample `i` of `samples()`, positioned in its stratum by `jitter`; `None` if
    /// none arrives.
    #[inline]
    pub fn illuminate(&self, p: DVec3, i: u32, jitter: DVec2) -> Option<Illumination> {
        match self {
            Light::Point(l) => l.illuminate(p),
            Light::Directional(l) => match l.sample(stratum(i, jitter)) {
                Some((to_light, radiance, pdf)) => {
                    let intensity = radiance * (1.0 / (pdf * f64::from(ENVIRONMENT_SAMPLES))) as f32;
                    Some(Illumination { to_light, finite: false, intensity })
                }
                None => Some(l.illuminate()),
            },
            Light::Spot(l) if l.radius() > 0.0 => {
                let mut lit = l.illuminate(p, stratified(i, ENVIRONMENT_SAMPLES, jitter))?;
                lit.intensity *= 1.0 / ENVIRONMENT_SAMPLES as f32;
                Some(lit)
            }
            Light::Spot(l) => l.illuminate(p, DVec2::ZERO),
            Light::Area(l) => l.illuminate(p, i, jitter),
            Light::Environment(l) => {
                let sample = l.sample(stratum(i, jitter))?;
                let share = 1.0 / (std::f64::consts::PI * sample.pdf * f64::from(ENVIRONMENT_SAMPLES));
                let intensity = sample.radiance * share as f32;
                Some(Illumination { to_light: sample.direction, finite: false, intensity })
            }
        }
    }

    /// Light that arrives at `p`. A light with an extent is represented by the one point at `u` in the unit square,
    /// which carries all its power; the mean over the square is the light's effect.
    #[inline]
    pub fn illuminate_at(&self, p: DVec3, u: [f64; 2]) -> Option<Illumination> {
        match self {
            Light::Area(l) => l.illuminate_at(p, u.into()),
            Light::Directional(l) => Some(l.illuminate()),
            Light::Spot(l) => l.illuminate(p, u.into()),
            Light::Point(_) | Light::Environment(_) => self.illuminate(p, 0, DVec2::ZERO),
        }
    }
}
