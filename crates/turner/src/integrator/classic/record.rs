//! What happened to one sample: the tree of its rays, with every term of the shading rule.
//!
//! The code that renders writes it down as it goes: a [`TreeBatch`](super::radiance::TreeBatch) is generic over a [`Record`], and with
//! [`Off`], which renders pictures, the notes are compiled away.

use super::notes::Notes;
use crate::color::Spectrum;
use crate::integrator::Radiance;
use crate::math::DVec3;
use crate::sampler::SampleId;
use crate::scene::Caster;
use crate::schema::MaterialId;

/// Takes notes of a tree, or none.
pub(super) trait Record {
    /// Whether anything is written down.
    const NOTES: bool;
    /// Writes something down; where nothing is, `f` is not called.
    fn note(&mut self, f: impl FnOnce(&mut Notes));
}

/// Nothing is written down.
pub(super) struct Off;

impl Record for Off {
    const NOTES: bool = false;
    #[inline(always)]
    fn note(&mut self, _: impl FnOnce(&mut Notes)) {}
}

/// Notes of one sample; the wave must hold no other.
impl Record for Notes {
    const NOTES: bool = true;
    #[inline(always)]
    fn note(&mut self, f: impl FnOnce(&mut Notes)) {
        f(self);
    }
}

/// One sample of a picture by the integrator "classic". Lengths are in units of the scene, directions are unit vectors in world
/// space but for those towards lights, colours are scene values.
///
/// What each part contributes is what was added to the sample, in this order: [`TreeRecord::contributions`] sums to
/// [`TreeRecord::radiance`] to the last bit.
#[derive(Clone, Debug)]
pub struct TreeRecord {
    /// The pixel (of adaptive anti-aliasing: the corner on its finest grid), the sample's number and the seed.
    pub id: SampleId,
    /// Where in the picture the sample lies: columns from its left edge, rows from its top one.
    pub place: [f64; 2],
    /// The rays in the order in which they were traced; the camera's comes first. None where the camera shows nothing.
    pub rays: Vec<RayRecord>,
    /// Rays traced after the first [`MAX_WRITTEN`]: they are part of the sum, but not written down.
    pub unwritten: u64,
    /// Rays that were not traced, for the sample had spawned as many as the integrator allows.
    pub dropped: u64,
    /// What the sample gives to its pixel.
    pub radiance: Radiance,
    /// The sum so far, once there are rays that are not written down.
    pub(super) total: Option<Spectrum>,
}

/// The most rays of a sample that are written down.
pub const MAX_WRITTEN: usize = 1 << 16;

/// Where a ray came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayKind {
    /// The camera.
    Camera,
    /// Mirrored at a surface.
    Reflected,
    /// Refracted into a solid, or out of it.
    Refracted,
}

impl RayKind {
    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            RayKind::Camera => "camera",
            RayKind::Reflected => "reflected",
            RayKind::Refracted => "refracted",
        }
    }
}

/// A ray of the tree; shadow rays stand with the lights they were sent to ([`LightTerm`]).
#[derive(Clone, Debug)]
pub struct RayRecord {
    /// Where it came from.
    pub kind: RayKind,
    /// The ray at whose hit it began; `None` for the camera's.
    pub parent: Option<u32>,
    /// How often light was reflected or refracted between it and the camera.
    pub depth: u32,
    /// Where it begins.
    pub origin: DVec3,
    /// Its direction.
    pub direction: DVec3,
    /// The share of what it finds that reaches the pixel.
    pub weight: f64,
    /// What it found.
    pub end: RayEnd,
}

/// What a ray found.
#[derive(Clone, Debug)]
pub enum RayEnd {
    /// A surface.
    Hit(Box<HitRecord>),
    /// None.
    Miss(MissRecord),
}

/// What a ray brings that met no surface.
#[derive(Clone, Copy, Debug)]
pub struct MissRecord {
    /// What it saw.
    pub seen: Seen,
    /// What was added to the sample.
    pub contribution: Spectrum,
}

/// What is seen where there is no surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// The background or the environment.
    Surroundings,
    /// Directional lights along which it looks.
    Lights,
    /// Ambient light, in place of a ray beyond the limit.
    Ambient,
    /// Nothing: black.
    Nothing,
    /// A background that lets through what is behind the picture.
    Transparent,
}

impl Seen {
    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            Seen::Surroundings => "surroundings",
            Seen::Lights => "lights",
            Seen::Ambient => "ambient",
            Seen::Nothing => "nothing",
            Seen::Transparent => "transparent",
        }
    }
}

/// A surface that a ray met, and how it was shaded: local = ambient + Σ lights, of which the share `k_local` · the ray's weight
/// reaches the pixel.
#[derive(Clone, Debug)]
pub struct HitRecord {
    /// How far the ray came.
    pub t: f64,
    /// The point.
    pub p: DVec3,
    /// Geometric normal, as it points out of the shape.
    pub ng: DVec3,
    /// Shading normal of the shape, on the same side.
    pub ns: DVec3,
    /// The N of the shading rule.
    pub n: DVec3,
    /// The primitive's number in the description, instances in order: [`Scene::object_name`](crate::scene::Scene::object_name).
    pub primitive: u32,
    /// Its shape, in a word.
    pub shape: &'static str,
    /// Which part of it: a face of a box, a triangle of a mesh.
    pub part: u32,
    /// Surface coordinates, as textures see them.
    pub uv: [f64; 2],
    /// The material.
    pub material: MaterialId,
    /// Whether the ray met the outer side: a ray refracted there enters the solid.
    pub entering: bool,
    /// The surface's own colour C.
    pub color: Spectrum,
    /// Shares of ambient light, of light returned diffusely, and strength of the highlight; 0 where a term is switched off.
    pub coefficients: [f64; 3],
    /// Exponent of the highlight.
    pub shininess: f64,
    /// Index of refraction inside over outside.
    pub ior: f64,
    /// ka · Ia · C.
    pub ambient: Spectrum,
    /// Lights, each once or once per point of it that was asked; empty where the local colour has no such term.
    pub lights: Vec<LightTerm>,
    /// Their sum with the ambient term, in this order.
    pub local: Spectrum,
    /// Weights of the local colour, of what is reflected and of what is refracted, as they came out at this angle.
    pub weights: [f64; 3],
    /// Whether no ray can leave: what would be refracted is reflected.
    pub total_internal_reflection: bool,
    /// What was added to the sample because the surface shines, where its material can.
    pub emitted: Option<Spectrum>,
    /// The local colour's part of the sample, where it has a weight.
    pub contribution: Option<Spectrum>,
    /// Rays that were not traced.
    pub cut: Vec<CutRecord>,
}

/// A ray that was not traced.
#[derive(Clone, Copy, Debug)]
pub struct CutRecord {
    /// What it would have been.
    pub kind: RayKind,
    /// Where it would have gone.
    pub direction: DVec3,
    /// The share of what it would have found that would have reached the pixel.
    pub weight: f64,
    /// Why.
    pub reason: CutReason,
    /// What stands for it.
    pub seen: Seen,
    /// What was added to the sample.
    pub contribution: Spectrum,
}

/// Why a ray was not traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CutReason {
    /// As many reflections and refractions as the integrator allows.
    Depth,
    /// As many rays as it allows.
    Count,
}

impl CutReason {
    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            CutReason::Depth => "depth",
            CutReason::Count => "count",
        }
    }
}

/// What a light, or one of its points, adds to the local colour.
#[derive(Clone, Debug)]
pub struct LightTerm {
    /// Its number among the scene's lights: [`Scene::light_sources`](crate::scene::Scene::light_sources).
    pub light: u32,
    /// Which of its points.
    pub sample: u32,
    /// BsdfFromWo the light: its length is the distance of a light that has a place.
    pub to_light: DVec3,
    /// Whether it has one.
    pub finite: bool,
    /// Whether any light comes this way, as far as the light itself is concerned: a spot has a cone.
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
    /// The ray that looked for what is in the way; `None` where none was needed.
    pub shadow: Option<ShadowRecord>,
    /// What was added to the local colour: S · I · (diffuse + highlight).
    pub added: Spectrum,
}

/// A ray from a surface to a light.
#[derive(Clone, Debug)]
pub struct ShadowRecord {
    /// Where it begins.
    pub origin: DVec3,
    /// Its direction; it ends at `t_max`, which is 1 at a light that has a place.
    pub direction: DVec3,
    /// Hits count from here on.
    pub t_min: f64,
    /// And up to here.
    pub t_max: f64,
    /// The share of light that arrives; the integrator's `shadow_factor` comes on top.
    pub through: Spectrum,
    /// What is in the way, in the ray's order; what comes behind the first opaque thing is not listed.
    pub casters: Vec<Caster>,
}

impl TreeRecord {
    /// What the rays that are written down added to the sample, in the order in which they did.
    pub fn contributions(&self) -> impl Iterator<Item = Spectrum> + '_ {
        self.rays.iter().flat_map(RayRecord::contributions)
    }

    /// Their sum, and that of rays which are not written down: the colour of [`TreeRecord::radiance`], to the last bit.
    pub fn sum(&self) -> Spectrum {
        self.total.unwrap_or_else(|| self.contributions().fold(Spectrum::BLACK, |sum, light| sum + light))
    }
}

impl RayRecord {
    /// What this ray itself added to the sample, in order; what those that it spawned brought is theirs.
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
