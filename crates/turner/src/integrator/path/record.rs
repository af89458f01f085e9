//! What happened to one sample: every vertex, density and weight of its path.
//!
//! The code that renders writes it down as it goes: a [`PathBatch`](super::path_batch::PathBatch) is generic over a [`Record`], and with
//! [`Off`], which renders pictures, the notes are compiled away.

use crate::bsdf::Lobe;
use crate::color::Spectrum;
use crate::integrator::Radiance;
use crate::math::DVec3;
use crate::sampler::SampleId;
use crate::scene::Caster;
use crate::schema::MaterialId;

/// Takes notes of a path, or none.
pub(super) trait Record {
    /// Writes something down; where nothing is, `f` is not called.
    fn note(&mut self, f: impl FnOnce(&mut PathRecord));

    /// Whether notes are taken: then each ray is shaded by itself.
    const NOTES: bool;
}

/// Nothing is written down.
pub(super) struct Off;

impl Record for Off {
    const NOTES: bool = false;

    #[inline(always)]
    fn note(&mut self, _: impl FnOnce(&mut PathRecord)) {}
}

/// Notes of one path; the wave must hold no other.
impl Record for PathRecord {
    const NOTES: bool = true;

    #[inline(always)]
    fn note(&mut self, f: impl FnOnce(&mut PathRecord)) {
        f(self);
    }
}

/// One sample of a picture by the integrators "path" and "direct". Lengths are in units of the scene, directions are unit vectors in
/// world space, radiance and densities per solid angle (1/sr).
///
/// What each part contributes is what was added to the sample, in this order: [`PathRecord::contributions`] sums to
/// [`PathRecord::radiance`] to the last bit.
#[derive(Clone, Debug)]
pub struct PathRecord {
    /// The pixel, the sample's number and the seed.
    pub id: SampleId,
    /// Where in the picture the sample lies: columns from its left edge, rows from its top one. With filters it may be another pixel.
    pub place: [f64; 2],
    /// Where the camera ray begins.
    pub origin: DVec3,
    /// Its direction.
    pub direction: DVec3,
    /// Its moment: 0 is the begin of motions, 1 their end.
    pub time: f32,
    /// What the path met, in order, also what let it through.
    pub vertices: Vec<VertexRecord>,
    /// What it found where it left the scene.
    pub escape: Option<EscapeRecord>,
    /// Its last way through a medium, if nothing is at the end of it.
    pub way: Option<MediumSegmentRecord>,
    /// What its group shares with it, where pixels use the paths of their neighbours; of other samples `None`.
    pub shared: Option<SharedRecord>,
    /// The vertex from which on the path is lent, as a number in `vertices`.
    pub(super) lent_from: Option<usize>,
    /// Whether the shadow ray that is asked for begins at the second place of a way.
    pub(super) asks_second: bool,
    /// Why it ended.
    pub end: End,
    /// What the sample gives to its pixel.
    pub radiance: Radiance,
}

/// Why a path ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// It left the scene.
    Escaped,
    /// Nothing is scattered in the direction that was sampled, or there was none.
    Absorbed,
    /// A limit on the number of scatterings.
    Depth,
    /// The limit on surfaces that it passes straight.
    Transparency,
    /// Russian roulette.
    Roulette,
    /// The surface shows its colour without light.
    Unlit,
    /// The limit on surfaces of all kinds.
    Vertices,
    /// The camera shows nothing there.
    OutsideField,
}

impl End {
    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            End::Escaped => "escaped",
            End::Absorbed => "absorbed",
            End::Depth => "depth",
            End::Transparency => "transparency",
            End::Roulette => "roulette",
            End::Unlit => "unlit",
            End::Vertices => "vertices",
            End::OutsideField => "left-out",
        }
    }
}

/// What a sample gets of the paths that its group shares.
#[derive(Clone, Debug)]
pub struct SharedRecord {
    /// The vertex from which on the sample's own path is lent, as a number in [`PathRecord::vertices`]: from there on throughputs and contributions are
    /// those of light that leaves this surface, and the sample gets its share of their sum. `None` if the path keeps to itself.
    pub from: Option<usize>,
    /// The paths that bring something to the sample, its own among them, in the order in which they were added.
    pub parts: Vec<DonorRecord>,
}

/// A path that a sample shares.
#[derive(Clone, Copy, Debug)]
pub struct DonorRecord {
    /// Whose path it is.
    pub id: SampleId,
    /// The path's second surface, which the sample's first one sees.
    pub p: DVec3,
    /// Radiance that the path found to leave it.
    pub radiance: Spectrum,
    /// The share of that which the sample gets: BSDF and cosine over the density with which the group finds the place (balance heuristic).
    pub share: Spectrum,
    /// What was added to the sample.
    pub contribution: Spectrum,
}

/// What a surface is to the path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Passage {
    /// It scatters or absorbs it.
    Surface,
    /// By chance it is not there: opacity, or a mix with a hole.
    Hole,
    /// A boundary within a solid that stands above it.
    Hidden,
    /// A thin clear pane that it went straight through.
    Pane,
    /// The boundary of a medium and nothing else.
    Boundary,
    /// No surface: the medium scattered it.
    Medium,
    /// There it comes out of a translucent body in which it was scattered.
    Exit,
}

impl Passage {
    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            Passage::Surface => "surface",
            Passage::Hole => "hole",
            Passage::Hidden => "hidden",
            Passage::Pane => "pane",
            Passage::Boundary => "boundary",
            Passage::Medium => "medium",
            Passage::Exit => "exit",
        }
    }
}

/// A way through a medium.
#[derive(Clone, Debug)]
pub struct MediumSegmentRecord {
    /// The material of the solid that the medium is in; `None` in the open.
    pub solid: Option<MaterialId>,
    /// How long it was.
    pub length: f64,
    /// The factor of the throughput: what the medium left and, where it scattered the path, scattered, over the probability of that.
    pub weight: Spectrum,
    /// Where the path was scattered, the density of the second place there over that of the first; 0 if there is no second place.
    pub beside: f64,
    /// What was added to the sample of the medium's own light.
    pub emission: Option<Spectrum>,
    /// The light sampled at a second place of the way, and how far that is.
    pub second: Option<(f64, LightRecord)>,
}

/// A walk inside a translucent body.
#[derive(Clone, Copy, Debug)]
pub struct RandomWalkRecord {
    /// How many distances were sampled: one more than it was scattered.
    pub steps: u32,
    /// How long it was.
    pub length: f64,
    /// The factor of the throughput: what the medium scattered and left, over the probability of that; 0 in bands that were black before.
    pub weight: Spectrum,
}

/// A surface that the path met, or a place in a medium that scattered it: there normals are 0, `primitive` is `u32::MAX`, and `material` that of
/// the solid that the medium is in, or beyond all materials.
#[derive(Clone, Debug)]
pub struct VertexRecord {
    /// The way to it, if it was through a medium.
    pub way: Option<MediumSegmentRecord>,
    /// Where the ray came from.
    pub origin: DVec3,
    /// Its direction.
    pub direction: DVec3,
    /// How far it came.
    pub t: f64,
    /// The point.
    pub p: DVec3,
    /// Geometric normal, as it points out of the shape.
    pub ng: DVec3,
    /// Shading normal of the shape, on the same side, before normal maps.
    pub ns: DVec3,
    /// The primitive's number in the description, instances in order.
    pub primitive: u32,
    /// Its shape, in a word.
    pub shape: &'static str,
    /// Which part of it: a face of a box, a triangle of a mesh.
    pub part: u32,
    /// The place within the part, as its shape tells it.
    pub uv: [f64; 2],
    /// The material.
    pub material: MaterialId,
    /// The material that a mix chose.
    pub chosen: Option<MaterialId>,
    /// Whether the ray met the outer side.
    pub outside: bool,
    /// Materials of the solids that the ray came through, nested ones in the order it entered them.
    pub inside: Vec<MaterialId>,
    /// The share of light that these left on the way; `None` where they absorb nothing.
    pub transmittance: Option<Spectrum>,
    /// The share of what leaves the surface towards the ray that reaches the pixel.
    pub throughput: Spectrum,
    /// What the surface is to the path.
    pub passage: Passage,
    /// The walk inside a translucent body that led there; origin and direction are those of its last step.
    pub walk: Option<RandomWalkRecord>,
    /// What shone there.
    pub emission: Option<EmissionRecord>,
    /// Index of refraction around the solid, where it has an inside.
    pub ior_around: Option<f64>,
    /// The colour band (0 red, 1 green, 2 blue) that is left of the path, once dispersion has parted them: from here on, or before.
    pub band: Option<u8>,
    /// The throughput with that band alone, where it was chosen here: it stands for the others, too.
    pub dispersed: Option<Spectrum>,
    /// What photons brought.
    pub photons: Option<PhotonsRecord>,
    /// The light that was sampled.
    pub light: Option<LightRecord>,
    /// The direction that was sampled and taken.
    pub scatter: Option<ScatterRecord>,
}

/// Light found by chance.
#[derive(Clone, Copy, Debug)]
pub struct EmissionRecord {
    /// Radiance that the surface emits or shows.
    pub radiance: Spectrum,
    /// Density with which the ray's direction was sampled at the last scattering; `None` where sampling a light could not have found it.
    pub pdf: Option<f64>,
    /// Density with which sampling a light there gives this direction; 0 if it does not.
    pub light_pdf: f64,
    /// The weight of finding it by chance (multiple importance sampling).
    pub weight: f64,
    /// What was added to the sample.
    pub contribution: Spectrum,
}

/// Light of the photons around a vertex.
#[derive(Clone, Copy, Debug)]
pub struct PhotonsRecord {
    /// How far they count.
    pub radius: f64,
    /// How many there were.
    pub count: u32,
    /// Radiance that they bring.
    pub radiance: Spectrum,
    /// What was added to the sample.
    pub contribution: Spectrum,
}

/// A light that was sampled.
#[derive(Clone, Debug)]
pub struct LightRecord {
    /// BsdfFromWo it.
    pub direction: DVec3,
    /// How far it is; infinite where it has no place.
    pub distance: f64,
    /// Density of the direction, the choice of the light included; for a point or a direction the probability of its choice. Times the number of
    /// candidates.
    pub pdf: f64,
    /// How many lights were looked at, of which this was taken: 1 or more.
    pub candidates: u32,
    /// How many times it counts for that: what all of them bring, over what it brings itself.
    pub counts: f32,
    /// Whether rays cannot hit the light by chance.
    pub is_delta: bool,
    /// Its radiance; of a point or a direction, what arrives at a surface that faces it.
    pub radiance: Spectrum,
    /// The BSDF, without the cosine, softened at the terminator.
    pub bsdf: Spectrum,
    /// Density with which the BSDF gives this direction.
    pub bsdf_pdf: f64,
    /// Cosine to the shading normal, not negative.
    pub cosine: f64,
    /// The weight of sampling the light (multiple importance sampling).
    pub weight: f64,
    /// The share of light that solids leave on the way; `None` where they absorb nothing.
    pub transmittance: Option<Spectrum>,
    /// What reaches the pixel if nothing is in the way.
    pub unshadowed: Spectrum,
    /// The share that is not in shadow; `None` where no shadow ray was needed.
    pub visible: Option<Spectrum>,
    /// Where the shadow ray begins, if there was one.
    pub shadow_origin: Option<DVec3>,
    /// What is in its way.
    pub casters: Vec<Caster>,
    /// What was added to the sample.
    pub contribution: Spectrum,
}

/// The way on from a surface.
#[derive(Clone, Copy, Debug)]
pub struct ScatterRecord {
    /// The sampled direction.
    pub direction: DVec3,
    /// What it went through.
    pub lobe: Lobe,
    /// The BSDF, without the cosine; for delta lobes only f·cos / pdf has a meaning.
    pub bsdf: Spectrum,
    /// Density of the direction; for delta lobes the probability of the lobe.
    pub pdf: f64,
    /// Cosine to the shading normal, not negative.
    pub cosine: f64,
    /// Index of refraction on the side it goes to over that on the side it comes from.
    pub eta: f64,
    /// The share that smooth normals over flat triangles leave at the terminator.
    pub terminator: f64,
    /// f·cos·terminator / pdf.
    pub weight: Spectrum,
    /// Russian roulette, where it was played.
    pub roulette: Option<Roulette>,
    /// What the path carries on: throughput before times weight, over the probability to survive.
    pub throughput: Spectrum,
}

/// A chance to end the path; those that go on make up for the others.
#[derive(Clone, Copy, Debug)]
pub struct Roulette {
    /// Probability to go on.
    pub survival: f64,
    /// The random number: the path goes on below `survival`.
    pub number: f64,
}

/// What a path found that left the scene.
#[derive(Clone, Debug)]
pub struct EscapeRecord {
    /// The way out, if it was through a medium.
    pub way: Option<MediumSegmentRecord>,
    /// Where the ray came from.
    pub origin: DVec3,
    /// Its direction.
    pub direction: DVec3,
    /// The share of light that solids left on the way; `None` where they absorb nothing.
    pub transmittance: Option<Spectrum>,
    /// The share of what it found that reaches the pixel.
    pub throughput: Spectrum,
    /// Density with which the ray's direction was sampled; `None` where sampling a light could not have found what is there.
    pub pdf: Option<f64>,
    /// Environments and suns in this direction.
    pub lights: Vec<InfiniteLightRecord>,
    /// The background, where it was seen.
    pub background: Spectrum,
    /// Ambient light.
    pub ambient: Spectrum,
    /// What was added to the sample.
    pub contribution: Spectrum,
}

/// A light around the scene, found by chance.
#[derive(Clone, Copy, Debug)]
pub struct InfiniteLightRecord {
    /// Its radiance in the direction.
    pub radiance: Spectrum,
    /// Density with which sampling a light gives the direction.
    pub light_pdf: f64,
    /// The weight of finding it by chance (multiple importance sampling).
    pub weight: f64,
}

impl PathRecord {
    /// What was added to the sample, in the order in which it was: emission and sampled light of each vertex and of the way to it, and what was found
    /// outside; then what the group's paths brought.
    pub fn contributions(&self) -> impl Iterator<Item = Spectrum> + '_ {
        fn sampled(light: Option<&LightRecord>) -> Option<Spectrum> {
            light.filter(|l| l.visible.is_some()).map(|l| l.contribution)
        }
        // Light that is sampled arrives after all that is found in the same round.
        let shone = |way: &Option<MediumSegmentRecord>| way.as_ref().and_then(|w| w.emission);
        let second = |way: &Option<MediumSegmentRecord>| {
            way.as_ref().and_then(|w| sampled(w.second.as_ref().map(|(_, light)| light)))
        };
        let (own, donated) = match self.shared.as_ref().and_then(|s| s.from) {
            Some(from) => (from, true),
            None => (self.vertices.len(), false),
        };
        let vertices = self.vertices.iter().take(own).flat_map(move |v| {
            let emission = v.emission.map(|e| e.contribution);
            let photons = v.photons.map(|p| p.contribution);
            [shone(&v.way), emission, photons, second(&v.way), sampled(v.light.as_ref())]
                .into_iter()
                .flatten()
        });
        let escape =
            self.escape.iter().filter(move |_| !donated).flat_map(move |e| {
                [shone(&e.way), Some(e.contribution), second(&e.way)].into_iter().flatten()
            });
        let last = [shone(&self.way), second(&self.way)].into_iter().flatten().filter(move |_| !donated);
        let shared = self.shared.iter().flat_map(|s| s.parts.iter().map(|p| p.contribution));
        vertices.chain(escape).chain(last).chain(shared)
    }

    /// Their sum: the colour of [`PathRecord::radiance`], to the last bit.
    pub fn sum(&self) -> Spectrum {
        self.contributions().fold(Spectrum::BLACK, |sum, light| sum + light)
    }
}
