//! The record of one sample: every vertex, density and weight of its path.
//!
//! The rendering code itself writes the record: a [`PathBatch`](super::path_batch::PathBatch) is generic over a
//! [`Record`]. With [`Off`], which renders images, recording compiles to nothing, so there is no second tracer to keep
//! in step.

use crate::bsdf::Lobe;
use crate::color::Spectrum;
use crate::integrator::Radiance;
use crate::math::DVec3;
use crate::sampler::SampleId;
use crate::scene::Caster;
use crate::schema::MaterialId;

/// Records a path, or nothing.
pub(super) trait Record {
    /// Passes the record to `f`; with [`Off`], `f` is not called.
    fn note(&mut self, f: impl FnOnce(&mut PathRecord));

    /// Whether a record is kept. If so, vertices are shaded one by one.
    const RECORDS: bool;
}

/// Records nothing.
pub(super) struct Off;

impl Record for Off {
    const RECORDS: bool = false;

    #[inline(always)]
    fn note(&mut self, _: impl FnOnce(&mut PathRecord)) {}
}

/// Records one path; the batch must hold no other.
impl Record for PathRecord {
    const RECORDS: bool = true;

    #[inline(always)]
    fn note(&mut self, f: impl FnOnce(&mut PathRecord)) {
        f(self);
    }
}

/// One sample of an image by the integrators "path" and "direct". Lengths are in scene units, directions are unit
/// vectors in world space, radiance and densities are per solid angle (1/sr).
///
/// Contributions are what was added to the sample, in this order: [`PathRecord::contributions`] sums to
/// [`PathRecord::radiance`] to the last bit.
#[derive(Clone, Debug)]
pub struct PathRecord {
    /// The pixel, the sample index and the seed.
    pub id: SampleId,
    /// Position of the sample in the image, in pixels: x from the left edge, y from the top edge. With a pixel filter
    /// it may lie in another pixel.
    pub place: [f64; 2],
    /// Origin of the camera ray.
    pub origin: DVec3,
    /// Direction of the camera ray.
    pub direction: DVec3,
    /// Time of the ray: 0 is the start of motions, 1 their end.
    pub time: f32,
    /// The vertices in order, including those that let the path pass.
    pub vertices: Vec<VertexRecord>,
    /// What the ray found that left the scene, if one did.
    pub escape: Option<EscapeRecord>,
    /// The last segment through a medium, if there is no vertex at its end.
    pub way: Option<MediumSegmentRecord>,
    /// What the samples of its cluster share with it, where paths are shared; `None` for other samples.
    pub shared: Option<SharedRecord>,
    /// Indices in `vertices`: light is shared from the first vertex on, up to the second, which is not included.
    pub(super) donated_from: Option<usize>,
    pub(super) donated_until: Option<usize>,
    /// Whether the next shadow ray starts at the equiangular point of a segment.
    pub(super) next_is_equiangular: bool,
    /// Why the path ended.
    pub end: End,
    /// The result of the sample.
    pub radiance: Radiance,
}

/// Why a path ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// It left the scene.
    Escaped,
    /// No direction was sampled, or the BSDF is black in it.
    Absorbed,
    /// A limit on the number of bounces.
    Depth,
    /// The limit on surfaces that a path passes straight through.
    Transparency,
    /// Russian roulette.
    Roulette,
    /// The surface is unlit: it shows its base colour.
    Unlit,
    /// The limit on vertices of all kinds.
    Vertices,
    /// The camera has no ray there.
    OutsideField,
}

impl End {
    /// The reason as one word.
    pub fn word(self) -> &'static str {
        match self {
            End::Escaped => "escaped",
            End::Absorbed => "absorbed",
            End::Depth => "depth",
            End::Transparency => "transparency",
            End::Roulette => "roulette",
            End::Unlit => "unlit",
            End::Vertices => "vertices",
            End::OutsideField => "outside-field",
        }
    }
}

/// What a sample receives from the paths of its cluster.
#[derive(Clone, Debug)]
pub struct SharedRecord {
    /// Index in [`PathRecord::vertices`] from which on the sample's own path is shared. From there on throughputs and
    /// contributions are those of radiance that leaves this vertex, and the sample receives its weight times their sum.
    /// `None` if the path is not shared.
    pub from: Option<usize>,
    /// Index of the first vertex after it whose light is the sample's own again: a delta lobe leads there, which is no
    /// other pixel's.
    pub until: Option<usize>,
    /// The donor paths that contribute to the sample, its own among them, in the order in which they were added.
    pub parts: Vec<DonorRecord>,
}

/// A path that is shared with a sample.
#[derive(Clone, Copy, Debug)]
pub struct DonorRecord {
    /// The sample that traced the path.
    pub id: SampleId,
    /// The path's second vertex, which is visible from the sample's first one.
    pub p: DVec3,
    /// Which part of the light at the second vertex this is.
    pub part: DonorPart,
    /// That light, as the path estimates it.
    pub radiance: Spectrum,
    /// Its weight in the sample: BSDF times cosine over the summed density with which the cluster finds the point
    /// (balance heuristic), times the BSDF of the second vertex unless that is part of the radiance.
    pub share: Spectrum,
    /// What was added to the sample.
    pub contribution: Spectrum,
}

/// A part of the light at the second vertex of a donor path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DonorPart {
    /// The radiance that leaves it, if its BSDF is Lambertian.
    Radiance,
    /// Direct light that arrives there, weighted for MIS, before the BSDF.
    Direct,
    /// Light that arrives there from the next vertex, before the BSDF.
    Next,
}

impl DonorPart {
    /// The part as one word.
    pub fn word(self) -> &'static str {
        match self {
            DonorPart::Radiance => "radiance",
            DonorPart::Direct => "direct",
            DonorPart::Next => "next",
        }
    }
}

/// What a vertex is to the path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Passage {
    /// A surface that scatters or absorbs it.
    Surface,
    /// A surface that lets it pass: stochastic opacity, a hole in a mix, or an emitter hidden from the camera.
    Hole,
    /// A boundary inside a solid of higher priority (nested dielectrics).
    Hidden,
    /// A thin clear pane that it passes straight through.
    Pane,
    /// An interface: the boundary of a medium and nothing else.
    Interface,
    /// No surface: a scattering event in a medium.
    Medium,
    /// The point where it leaves a translucent body after a random walk.
    Exit,
}

impl Passage {
    /// The passage as one word.
    pub fn word(self) -> &'static str {
        match self {
            Passage::Surface => "surface",
            Passage::Hole => "hole",
            Passage::Hidden => "hidden",
            Passage::Pane => "pane",
            Passage::Interface => "interface",
            Passage::Medium => "medium",
            Passage::Exit => "exit",
        }
    }
}

/// A segment through a medium.
#[derive(Clone, Debug)]
pub struct MediumSegmentRecord {
    /// Material of the solid that holds the medium; `None` for the medium of the scene.
    pub solid: Option<MaterialId>,
    /// Its length.
    pub length: f64,
    /// Factor of the throughput: transmittance, and the scattering coefficient where it scattered, over the
    /// probability.
    pub weight: Spectrum,
    /// Where the path scattered: density of the equiangular point over that of distance sampling; 0 if there is no
    /// equiangular point.
    pub beside: f64,
    /// The medium's own emission, as added to the sample.
    pub emission: Option<Spectrum>,
    /// The light sampled at the equiangular point, and the distance of that point.
    pub second: Option<(f64, LightRecord)>,
}

/// A random walk in a translucent body.
#[derive(Clone, Copy, Debug)]
pub struct RandomWalkRecord {
    /// Number of sampled distances: one more than scattering events.
    pub steps: u32,
    /// Its length.
    pub length: f64,
    /// Factor of the throughput: scattering and transmittance over the probability; 0 in bands that were black before.
    pub weight: Spectrum,
}

/// A surface that the path hit, or a scattering event in a medium. In a medium normals are 0, `primitive` is
/// `u32::MAX`, and `material` is that of the solid that holds the medium, or `u32::MAX`.
#[derive(Clone, Debug)]
pub struct VertexRecord {
    /// The segment to the vertex, if it went through a medium.
    pub way: Option<MediumSegmentRecord>,
    /// Origin of the ray.
    pub origin: DVec3,
    /// Direction of the ray.
    pub direction: DVec3,
    /// Distance along the ray.
    pub t: f64,
    /// The point.
    pub p: DVec3,
    /// Geometric normal, pointing out of the shape.
    pub ng: DVec3,
    /// Shading normal of the shape, on the same side, before normal maps.
    pub ns: DVec3,
    /// Index of the primitive in the description, instances in order.
    pub primitive: u32,
    /// Its shape, as one word.
    pub shape: &'static str,
    /// Part of the shape: a face of a box, a triangle of a mesh.
    pub part: u32,
    /// Surface parameters within the part, as the shape defines them.
    pub uv: [f64; 2],
    /// The material.
    pub material: MaterialId,
    /// The material that a mix chose.
    pub chosen: Option<MaterialId>,
    /// Whether the ray hit the front side.
    pub outside: bool,
    /// Materials of the solids that the ray travelled in, nested ones in the order of entry.
    pub inside: Vec<MaterialId>,
    /// Transmittance of these solids along the ray; `None` where they absorb nothing.
    pub transmittance: Option<Spectrum>,
    /// Throughput: the fraction of radiance leaving the vertex towards the ray that reaches the pixel.
    pub throughput: Spectrum,
    /// What the vertex is to the path.
    pub passage: Passage,
    /// The random walk in a translucent body that led here; origin and direction are those of its last step.
    pub walk: Option<RandomWalkRecord>,
    /// Emission found at the vertex.
    pub emission: Option<EmissionRecord>,
    /// Index of refraction outside the solid, for solids.
    pub ior_around: Option<f64>,
    /// The colour band (0 red, 1 green, 2 blue) that is left after dispersion, chosen here or before.
    pub band: Option<u8>,
    /// The throughput in that band, where it was chosen here; it is weighted up for the bands dropped.
    pub dispersed: Option<Spectrum>,
    /// The contribution of photons.
    pub photons: Option<PhotonsRecord>,
    /// The lights sampled at the vertex: one, or several at the first surface that is not specular.
    pub lights: Vec<LightRecord>,
    /// The direction sampled at the vertex and taken.
    pub scatter: Option<ScatterRecord>,
}

/// Emission found by a BSDF-sampled ray.
#[derive(Clone, Copy, Debug)]
pub struct EmissionRecord {
    /// Radiance that the surface emits or shows.
    pub radiance: Spectrum,
    /// Density of the ray's direction at the last scattering event; `None` where light sampling could not have found
    /// it.
    pub pdf: Option<f64>,
    /// Density of this direction by light sampling; 0 if it cannot be sampled.
    pub light_pdf: f64,
    /// MIS weight of finding it by a BSDF-sampled ray.
    pub weight: f64,
    /// What was added to the sample.
    pub contribution: Spectrum,
}

/// Radiance estimated from the photons around a vertex.
#[derive(Clone, Copy, Debug)]
pub struct PhotonsRecord {
    /// Radius of the density estimate.
    pub radius: f64,
    /// Number of photons within it.
    pub count: u32,
    /// The radiance.
    pub radiance: Spectrum,
    /// What was added to the sample.
    pub contribution: Spectrum,
}

/// A sampled light (next-event estimation).
#[derive(Clone, Debug)]
pub struct LightRecord {
    /// Direction to the light.
    pub direction: DVec3,
    /// Distance to it; infinite for infinite lights.
    pub distance: f64,
    /// Density of the direction, including the choice of the light; for a delta light the probability of its choice.
    /// Times the number of candidates.
    pub pdf: f64,
    /// Number of light candidates of which this one was chosen: 1 or more.
    pub candidates: u32,
    /// Resampling weight: the contribution of all candidates over that of this one.
    pub counts: f32,
    /// Whether it is a delta light, which no ray can hit.
    pub is_delta: bool,
    /// Its radiance; for a delta light, the irradiance at a surface that faces it.
    pub radiance: Spectrum,
    /// The BSDF, without the cosine, softened at the shadow terminator.
    pub bsdf: Spectrum,
    /// Density of this direction by BSDF sampling.
    pub bsdf_pdf: f64,
    /// Absolute cosine to the shading normal.
    pub cosine: f64,
    /// MIS weight of sampling the light.
    pub weight: f64,
    /// Transmittance of solids along the shadow ray; `None` where they absorb nothing.
    pub transmittance: Option<Spectrum>,
    /// Contribution if unoccluded.
    pub unshadowed: Spectrum,
    /// Fraction that arrives; `None` where no shadow ray was needed.
    pub visible: Option<Spectrum>,
    /// Origin of the shadow ray, if there was one.
    pub shadow_origin: Option<DVec3>,
    /// What occludes it.
    pub casters: Vec<Caster>,
    /// What was added to the sample.
    pub contribution: Spectrum,
}

/// The next direction of a path.
#[derive(Clone, Copy, Debug)]
pub struct ScatterRecord {
    /// The sampled direction.
    pub direction: DVec3,
    /// The lobe it was sampled from.
    pub lobe: Lobe,
    /// The BSDF, without the cosine; for delta lobes only f·cos / pdf has a meaning.
    pub bsdf: Spectrum,
    /// Density of the direction; for delta lobes the probability of the lobe.
    pub pdf: f64,
    /// Absolute cosine to the shading normal.
    pub cosine: f64,
    /// Relative index of refraction: that of the side it goes to over that of the side it comes from.
    pub eta: f64,
    /// Factor of diffuse reflection, which `bsdf` contains: the softened shadow terminator of smooth meshes.
    pub terminator: f64,
    /// f·cos / pdf.
    pub weight: Spectrum,
    /// Russian roulette, where it was played.
    pub roulette: Option<Roulette>,
    /// New throughput: the throughput before times `weight`, over the survival probability.
    pub throughput: Spectrum,
}

/// Russian roulette; surviving paths are weighted up.
#[derive(Clone, Copy, Debug)]
pub struct Roulette {
    /// Survival probability.
    pub survival: f64,
    /// The random number: the path survives below `survival`.
    pub number: f64,
}

/// What a ray found that left the scene.
#[derive(Clone, Debug)]
pub struct EscapeRecord {
    /// The last segment, if it went through a medium.
    pub way: Option<MediumSegmentRecord>,
    /// Origin of the ray.
    pub origin: DVec3,
    /// Direction of the ray.
    pub direction: DVec3,
    /// Transmittance of solids along the ray; `None` where they absorb nothing.
    pub transmittance: Option<Spectrum>,
    /// Throughput: the fraction of what it found that reaches the pixel.
    pub throughput: Spectrum,
    /// Density of the ray's direction; `None` where light sampling could not have found what it hits.
    pub pdf: Option<f64>,
    /// Infinite lights in this direction: environment maps and suns.
    pub lights: Vec<InfiniteLightRecord>,
    /// The background, where it was visible.
    pub background: Spectrum,
    /// Ambient light.
    pub ambient: Spectrum,
    /// What was added to the sample.
    pub contribution: Spectrum,
}

/// An infinite light found by a ray that left the scene.
#[derive(Clone, Copy, Debug)]
pub struct InfiniteLightRecord {
    /// Its radiance in the direction.
    pub radiance: Spectrum,
    /// Density of the direction by light sampling.
    pub light_pdf: f64,
    /// MIS weight of finding it by a BSDF-sampled ray.
    pub weight: f64,
}

impl PathRecord {
    /// What was added to the sample, in order: emission and sampled light of each vertex and of the segment to it, then
    /// of the ray that left the scene, then the paths shared by the cluster.
    pub fn contributions(&self) -> impl Iterator<Item = Spectrum> + '_ {
        fn sampled(light: Option<&LightRecord>) -> Option<Spectrum> {
            light.filter(|l| l.visible.is_some()).map(|l| l.contribution)
        }
        // Sampled light is added after everything else of its round.
        let emitted = |way: &Option<MediumSegmentRecord>| way.as_ref().and_then(|w| w.emission);
        let second = |way: &Option<MediumSegmentRecord>| {
            way.as_ref().and_then(|w| sampled(w.second.as_ref().map(|(_, light)| light)))
        };
        // The vertices from..until are shared.
        let end = self.vertices.len();
        let shared = self.shared.as_ref().and_then(|s| Some((s.from?, s.until.unwrap_or(usize::MAX))));
        let (from, until) = shared.unwrap_or((end, end));
        let donated = until > end;
        // The exit of a random walk belongs to the round of its entry.
        let mut next = 0;
        let vertices = self.vertices.chunk_by(|_, next| next.walk.is_some()).flat_map(move |round| {
            let first = next;
            next += round.len();
            let is_own = move |i: &usize| !(from..until).contains(&(first + i));
            let own = move || round.iter().enumerate().filter(move |(i, _)| is_own(i)).map(|(_, v)| v);
            let found = own().flat_map(move |v| {
                let emission = v.emission.map(|e| e.contribution);
                [emitted(&v.way), emission, v.photons.map(|p| p.contribution)].into_iter().flatten()
            });
            let lit = own().flat_map(move |v| {
                let lights = v.lights.iter().map(|light| sampled(Some(light)));
                std::iter::once(second(&v.way)).chain(lights).flatten()
            });
            found.chain(lit)
        });
        let escape =
            self.escape.iter().filter(move |_| !donated).flat_map(move |e| {
                [emitted(&e.way), Some(e.contribution), second(&e.way)].into_iter().flatten()
            });
        let last = [emitted(&self.way), second(&self.way)].into_iter().flatten().filter(move |_| !donated);
        let shared = self.shared.iter().flat_map(|s| s.parts.iter().map(|p| p.contribution));
        vertices.chain(escape).chain(last).chain(shared)
    }

    /// Their sum: the colour of [`PathRecord::radiance`], to the last bit.
    pub fn sum(&self) -> Spectrum {
        self.contributions().fold(Spectrum::BLACK, |sum, light| sum + light)
    }
}
