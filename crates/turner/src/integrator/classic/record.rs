//! The record of one sample: its ray tree, with every term of the shading model.
//!
//! The rendering code itself fills it: a [`TreeBatch`](super::radiance::TreeBatch) is generic over a [`Record`].
//! With [`Off`], as used for rendering, the compiler removes all recording.

use super::notes::Notes;
use crate::color::Spectrum;
use crate::integrator::Radiance;
use crate::math::DVec3;
use crate::sampler::SampleId;
use crate::scene::Caster;
use crate::schema::MaterialId;

/// A recorder of a ray tree, or none.
pub(super) trait Record {
    /// Whether anything is recorded.
    const NOTES: bool;
    /// Records something. Without a recorder, `f` is not called.
    fn note(&mut self, f: impl FnOnce(&mut Notes));
}

/// Records nothing.
pub(super) struct Off;

impl Record for Off {
    const NOTES: bool = false;
    #[inline(always)]
    fn note(&mut self, _: impl FnOnce(&mut Notes)) {}
}

/// Records one sample; the batch must hold no other.
impl Record for Notes {
    const NOTES: bool = true;
    #[inline(always)]
    fn note(&mut self, f: impl FnOnce(&mut Notes)) {
        f(self);
    }
}

/// One sample of the integrator "classic". Lengths are in scene units. Directions are unit vectors in world
/// space, except those to lights. Colours are linear scene values.
///
/// Contributions are the values added to the sample, in this order: [`TreeRecord::contributions`] sums to
/// [`TreeRecord::radiance`] bit for bit.
#[derive(Clone, Debug)]
pub struct TreeRecord {
    /// The pixel (with adaptive anti-aliasing, the corner on the finest grid), the sample index and the seed.
    pub id: SampleId,
    /// The position of the sample in the picture, in pixels from its top left corner: (column, row).
    pub place: [f64; 2],
    /// The rays in the order in which they were traced, the camera ray first. Empty where the camera has no ray.
    pub rays: Vec<RayRecord>,
    /// Number of rays traced after the first [`MAX_WRITTEN`]. They are part of the sum but not recorded.
    pub unwritten: u64,
    /// Number of rays that were not traced because of the integrator's `max_rays`.
    pub dropped: u64,
    /// The radiance of the sample.
    pub radiance: Radiance,
    /// The sum so far, once there are rays that are not recorded.
    pub(super) total: Option<Spectrum>,
}

/// The maximum number of recorded rays of a sample.
pub const MAX_WRITTEN: usize = 1 << 16;

/// The origin of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayKind {
    /// From the camera.
    Camera,
    /// Reflected at a surface.
    Reflected,
    /// Refracted into a solid, or out of it.
    Refracted,
}

impl RayKind {
    /// The kind as a word.
    pub fn word(self) -> &'static str {
        match self {
            RayKind::Camera => "camera",
            RayKind::Reflected => "reflected",
            RayKind::Refracted => "refracted",
        }
    }
}

/// A ray of the tree. Shadow rays are part of the light terms ([`LightTerm`]).
#[derive(Clone, Debug)]
pub struct RayRecord {
    /// What kind of ray it is.
    pub kind: RayKind,
    /// The index of the ray at whose hit it was spawned; `None` for the camera ray.
    pub parent: Option<u32>,
    /// The number of reflections and refractions between it and the camera.
    pub depth: u32,
    /// The origin.
    pub origin: DVec3,
    /// The direction.
    pub direction: DVec3,
    /// Its weight in the pixel.
    pub weight: f64,
    /// What it hit.
    pub end: RayEnd,
}

/// What a ray hit.
#[derive(Clone, Debug)]
pub enum RayEnd {
    /// A surface.
    Hit(Box<HitRecord>),
    /// Nothing.
    Miss(MissRecord),
}

/// A ray that hit nothing.
#[derive(Clone, Copy, Debug)]
pub struct MissRecord {
    /// What it returned.
    pub seen: Seen,
    /// The value added to the sample.
    pub contribution: Spectrum,
}

/// What a ray returned that hit no surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// The background or the environment.
    Background,
    /// Directional lights in the direction of the ray.
    Lights,
    /// The ambient light, for a ray beyond the depth limit.
    Ambient,
    /// Nothing: black.
    Nothing,
    /// A transparent background.
    Transparent,
}

impl Seen {
    /// The value as a word.
    pub fn word(self) -> &'static str {
        match self {
            Seen::Background => "background",
            Seen::Lights => "lights",
            Seen::Ambient => "ambient",
            Seen::Nothing => "nothing",
            Seen::Transparent => "transparent",
        }
    }
}

/// A hit and its shading: local = ambient + Σ lights. The local colour counts with `k_local` times the weight of
/// the ray.
#[derive(Clone, Debug)]
pub struct HitRecord {
    /// Distance along the ray.
    pub t: f64,
    /// The point.
    pub p: DVec3,
    /// Geometric normal, out of the shape.
    pub ng: DVec3,
    /// Shading normal of the shape, on the same side.
    pub ns: DVec3,
    /// The normal N of the shading model.
    pub n: DVec3,
    /// Index of the primitive in the description, instances in order:
    /// [`Scene::object_name`](crate::scene::Scene::object_name).
    pub primitive: u32,
    /// The name of its shape type.
    pub shape: &'static str,
    /// Index of the part: a face of a box, a triangle of a mesh.
    pub part: u32,
    /// Texture coordinates.
    pub uv: [f64; 2],
    /// The material.
    pub material: MaterialId,
    /// Whether the ray hit the outer side: a ray refracted there enters the solid.
    pub entering: bool,
    /// The surface colour C.
    pub color: Spectrum,
    /// ka, kd and ks; 0 where a term is switched off.
    pub coefficients: [f64; 3],
    /// Exponent of the highlight.
    pub shininess: f64,
    /// Relative index of refraction, inside over outside.
    pub ior: f64,
    /// ka · Ia · C.
    pub ambient: Spectrum,
    /// The light terms, one per light or per sample of an area light; empty where the surface has neither a
    /// diffuse nor a highlight term.
    pub lights: Vec<LightTerm>,
    /// The sum of the ambient term and the light terms, in this order.
    pub local: Spectrum,
    /// Weights of local colour, reflection and refraction at this angle of incidence.
    pub weights: [f64; 3],
    /// Whether there is total internal reflection: the refracted fraction is reflected.
    pub total_internal_reflection: bool,
    /// The emission added to the sample, where the material can emit.
    pub emitted: Option<Spectrum>,
    /// The contribution of the local colour, where its weight is above 0.
    pub contribution: Option<Spectrum>,
    /// Rays that were not traced.
    pub cut: Vec<CutRecord>,
}

/// A ray that was not traced.
#[derive(Clone, Copy, Debug)]
pub struct CutRecord {
    /// What kind of ray it would have been.
    pub kind: RayKind,
    /// Its direction.
    pub direction: DVec3,
    /// The weight it would have had in the pixel.
    pub weight: f64,
    /// Why it was not traced.
    pub reason: CutReason,
    /// What replaced it.
    pub seen: Seen,
    /// The value added to the sample.
    pub contribution: Spectrum,
}

/// Why a ray was not traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CutReason {
    /// The limit of depth.
    Depth,
    /// The limit of rays per sample.
    Count,
}

impl CutReason {
    /// The reason as a word.
    pub fn word(self) -> &'static str {
        match self {
            CutReason::Depth => "depth",
            CutReason::Count => "count",
        }
    }
}

/// The term of one light, or of one sample of an area light.
#[derive(Clone, Debug)]
pub struct LightTerm {
    /// Index among the scene's lights: [`Scene::light_sources`](crate::scene::Scene::light_sources).
    pub light: u32,
    /// Index of the sample of an area light.
    pub sample: u32,
    /// Towards the light; for a light with a position, its length is the distance.
    pub to_light: DVec3,
    /// Whether the light has a position.
    pub finite: bool,
    /// Whether the light illuminates this point at all, without regard to shadows: a spot has a cone.
    pub reaches: bool,
    /// I: colour times intensity times attenuation.
    pub intensity: Spectrum,
    /// N·L.
    pub n_dot_l: f64,
    /// R·V; 0 where there is no highlight.
    pub r_dot_v: f64,
    /// kd · C · max(0, N·L).
    pub diffuse: Spectrum,
    /// ks · H · max(0, R·V)^shininess.
    pub highlight: Spectrum,
    /// The shadow ray; `None` where none was needed.
    pub shadow: Option<ShadowRecord>,
    /// The value added to the local colour: S · I · (diffuse + highlight).
    pub added: Spectrum,
}

/// A shadow ray.
#[derive(Clone, Debug)]
pub struct ShadowRecord {
    /// The origin.
    pub origin: DVec3,
    /// The direction. The ray ends at `t_max`, which is 1 at a light with a position.
    pub direction: DVec3,
    /// Hits count from this t.
    pub t_min: f64,
    /// Hits count up to this t.
    pub t_max: f64,
    /// The transmittance, before the integrator's `shadow_factor` is applied.
    pub through: Spectrum,
    /// The objects along the ray, in order, up to the first opaque one.
    pub casters: Vec<Caster>,
}

impl TreeRecord {
    /// The contributions of the recorded rays, in the order in which they were added to the sample.
    pub fn contributions(&self) -> impl Iterator<Item = Spectrum> + '_ {
        self.rays.iter().flat_map(RayRecord::contributions)
    }

    /// The sum of all contributions, those of unrecorded rays included: the colour of [`TreeRecord::radiance`],
    /// bit for bit.
    pub fn sum(&self) -> Spectrum {
        self.total.unwrap_or_else(|| self.contributions().fold(Spectrum::BLACK, |sum, light| sum + light))
    }
}

impl RayRecord {
    /// The contributions of this ray in order, without those of the rays that it spawned.
    pub fn contributions(&self) -> impl Iterator<Item = Spectrum> + '_ {
        let (hit, miss) = match &self.end {
            RayEnd::Hit(hit) => (Some(hit), None),
            RayEnd::Miss(miss) => (None, Some(miss.contribution)),
        };
        let of_hit = hit.into_iter().flat_map(|h| {
            let cut = h.cut.iter().map(|c| c.contribution);
            h.emitted.into_iter().chain(h.contribution).chain(cut)
        });
        miss.into_iter().chain(of_hit)
    }
}
