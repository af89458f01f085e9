//! Lights. One file each; [`LightDesc`] is the table of their names in a scene.
//!
//! The contract, which every [`Light`] keeps (objects that shine are materials; `light::emission` samples their shapes):
//!
//! - All is in world space. Directions point from the surface towards the light.
//! - [`Light::illuminate`] is given the point that is lit and asks no visibility. `to_light` is not normalised: for a light with a place (`finite`) it reaches as far as the light,
//!   so that a shadow ray ends at t = 1; for a direction or an environment nothing ends it. The cosine at the surface is not in `intensity`. `None` is no light from there:
//!   outside a cone, or at the light itself.
//! - `intensity` is colour times intensity times attenuation. It has the units of the classic documents: a diffuse surface of colour C that faces the light returns C times it.
//!   Integrators that follow light take it for irradiance, so that a Lambertian surface returns C/π times it. An environment's samples are therefore divided by π here.
//! - A light with an extent is asked `samples()` times, one point in each stratum, placed by `jitter`; the caller takes the mean. [`Light::illuminate_at`] is one point that stands for all.
//! - Environments and discs in the sky have radiance and a density: pdf per solid angle, the cosine not in it, greater than 0 wherever a sample comes from; `sample` and `pdf` agree.
//!   `None` is no sample, never an error.
//! - Lights that rays cannot hit ([`Light::is_delta`]) have no density; what stands for it is the probability of their choice.
//! - [`Light::around`] is the radiance that a ray finds that leaves the scene in a direction (unit, away from the scene's middle); `None` for lights that are not infinite.
//! - [`LightBound`] says where a light stands, where it shines and how strongly: the light tree chooses by it.

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
mod point;
mod profile;
mod sky;
mod spot;
mod tree;

pub use ambient::AmbientDesc;
pub use area::{AreaLight, DiskLightDesc, RectangleLightDesc, SphereLightDesc};
pub use background::BackgroundDesc;
pub use bound::LightBound;
pub use directional::{Directional, DirectionalDesc};
pub use environment::{EnvironmentBatch, EnvironmentDesc, EnvironmentLight, EnvironmentSample};
pub use point::{Point, PointDesc};
pub use profile::ProfileUnits;
pub use sky::SkyDesc;
pub use spot::{Spot, SpotDesc};
pub(crate) use tree::WIDTH as TREE_WIDTH;
pub use tree::{LightTree, Receiver};

use crate::color::Spectrum;
use crate::image::Image;
use crate::math::{DVec2, DVec3};
use crate::schema::value::{Data, Value};
use crate::schema::{
    Asset, ErrorCode, ImageId, ParamType, ReadContext, SceneError, WriteContext, choice, family, wrong_type,
};

family! {
    /// Lights: the `type` of a `[[light]]`. Each has a `color` and an `intensity`; what arrives is their product, weakened by `attenuation`.
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

/// Where a program's lamp begins: above a scene at the origin, and not in it.
pub(crate) const LAMP: DVec3 = DVec3::new(0.0, 5.0, 0.0);

choice! {
    /// How light weakens with distance, by name.
    pub enum AttenuationKind {
        /// Not at all.
        None = "none",
        /// By 1/d².
        InverseSquare = "inverse-square",
    }
}

/// How light weakens with the distance d: 1 / (c + l·d + q·d²).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attenuation {
    /// The coefficients c, l, q.
    pub coefficients: [f64; 3],
}

impl Attenuation {
    /// The same at every distance.
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
    /// BsdfFromWo the light, not normalised: its length is the distance for lights that have a place.
    pub to_light: DVec3,
    /// Whether the light has a place: then only what is nearer than it casts a shadow.
    pub finite: bool,
    /// Colour times intensity times attenuation.
    pub intensity: Spectrum,
}

/// Directions in which [`Light::illuminate`] asks an environment or a disc in the sky: enough for soft shadows without much noise.
const ENVIRONMENT_SAMPLES: u32 = 16;

/// Place in the unit square of one of these directions, in its stratum.
fn stratum(i: u32, jitter: DVec2) -> [f64; 2] {
    [(f64::from(i) + jitter.x) / f64::from(ENVIRONMENT_SAMPLES), jitter.y]
}

/// A light ready to shine.
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
    /// All around.
    Environment(EnvironmentLight),
}

impl LightDesc {
    /// The picture that it is made from.
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

    /// How it weakens with distance; `None` for lights that have no place.
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

    /// Makes it ready and adds what it is made of to `lights`; gives the colour of an ambient light, which has no place. `images` are the
    /// scene's; `compensated` is for environments ([`EnvironmentDesc::prepare`]), `physical` whether the integrator is.
    pub fn prepare(
        &self,
        images: &[Asset<Image>],
        compensated: bool,
        physical: bool,
        lights: &mut Vec<Light>,
    ) -> Result<Spectrum, SceneError> {
        let light = match self {
            LightDesc::Ambient(l) => return Ok(l.color * l.intensity as f32),
            LightDesc::Point(l) => Light::Point(l.prepare()?),
            LightDesc::Directional(l) => Light::Directional(l.prepare()?),
            LightDesc::Spot(l) => Light::Spot(l.prepare()?),
            LightDesc::Rectangle(l) => Light::Area(l.prepare()?),
            LightDesc::Disk(l) => Light::Area(l.prepare()?),
            LightDesc::Sphere(l) => Light::Area(l.prepare()),
            LightDesc::Environment(l) => Light::Environment(l.prepare(images, compensated)?),
            LightDesc::Sky(l) => {
                let (around, sun) = l.prepare(compensated, physical)?;
                lights.extend(sun.map(Light::Directional));
                Light::Environment(around)
            }
        };
        lights.push(light);
        Ok(Spectrum::BLACK)
    }
}

/// A light of the same intensity everywhere: what [`Light::illuminate`] needs to be done for many points at once.
#[derive(Clone, Copy, Debug)]
pub enum Uniform {
    /// From a point.
    Point {
        /// Where it is.
        position: DVec3,
        /// Colour times intensity.
        intensity: Spectrum,
    },
    /// From one direction.
    Directional {
        /// BsdfFromWo the light.
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

    /// Of a light that is made of points, which rays cannot hit: the one that `u` in the unit square chooses.
    pub fn point(&self, u: [f64; 2]) -> Option<DVec3> {
        match self {
            Light::Point(l) => Some(l.position()),
            Light::Spot(l) => Some(l.position()),
            Light::Area(l) => Some(l.point(u.into())),
            Light::Directional(_) | Light::Environment(_) => None,
        }
    }

    /// Whether rays cannot hit it: a point, a direction, or made of points.
    pub fn is_delta(&self) -> bool {
        match self {
            Light::Point(_) | Light::Spot(_) | Light::Area(_) => true,
            Light::Directional(l) => !l.is_disc(),
            Light::Environment(_) => false,
        }
    }

    /// Whether it has a place.
    pub fn is_finite(&self) -> bool {
        match self {
            Light::Point(_) | Light::Spot(_) | Light::Area(_) => true,
            Light::Directional(_) | Light::Environment(_) => false,
        }
    }

    /// Where it is, if it is a point.
    pub fn position(&self) -> Option<DVec3> {
        match self {
            Light::Point(l) => Some(l.position()),
            Light::Spot(l) => Some(l.position()),
            Light::Directional(_) | Light::Area(_) | Light::Environment(_) => None,
        }
    }

    /// How many points of the light are asked for visibility.
    #[inline]
    pub fn samples(&self) -> u32 {
        match self {
            Light::Area(l) => l.samples,
            Light::Environment(_) => ENVIRONMENT_SAMPLES,
            Light::Directional(l) if l.is_disc() => ENVIRONMENT_SAMPLES,
            Light::Point(_) | Light::Directional(_) | Light::Spot(_) => 1,
        }
    }

    /// Pixels of an environment that count as 0 because they are negative or no finite numbers.
    pub fn invalid_pixels(&self) -> u64 {
        match self {
            Light::Environment(l) => l.invalid_pixels(),
            Light::Point(_) | Light::Directional(_) | Light::Spot(_) | Light::Area(_) => 0,
        }
    }

    /// The light of the surroundings that comes from a direction; `None` for other lights.
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
            Light::Point(_) | Light::Spot(_) => false,
        }
    }

    /// Light that arrives at `p` from the light's sample `i` of `samples()`, placed in its stratum by `jitter`; `None` if
    /// none does.
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
            Light::Spot(l) => l.illuminate(p),
            Light::Area(l) => l.illuminate(p, i, jitter),
            Light::Environment(l) => {
                let sample = l.sample(stratum(i, jitter))?;
                let share = 1.0 / (std::f64::consts::PI * sample.pdf * f64::from(ENVIRONMENT_SAMPLES));
                let intensity = sample.radiance * share as f32;
                Some(Illumination { to_light: sample.direction, finite: false, intensity })
            }
        }
    }

    /// Light that arrives at `p`; from lights with an extent, all that one of its points would send if it stood for the whole.
    /// That point is at `u` in the unit square; its mean over the square is the light's effect.
    #[inline]
    pub fn illuminate_at(&self, p: DVec3, u: [f64; 2]) -> Option<Illumination> {
        match self {
            Light::Area(l) => l.illuminate_at(p, u.into()),
            Light::Directional(l) => Some(l.illuminate()),
            Light::Point(_) | Light::Spot(_) | Light::Environment(_) => self.illuminate(p, 0, DVec2::ZERO),
        }
    }
}
