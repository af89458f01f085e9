//! Shared paths: neighbouring pixels reuse one another's paths (Bekaert, Sbert and Halton 2002, "Accelerating path
//! tracing by re-using paths").
//!
//! ```text
//!  camera rays:  |       |       |
//!               x_1     x_2     x_3        first vertices of a cluster of pixels, diffuse
//!                 .      |      .
//!                   .    |    .            |  BSDF-sampled ray of donor path 2
//!                     .  |  .              .  shadow rays (reconnections)
//!                        y                 second vertex of donor path 2, diffuse; L(y): radiance that leaves it
//! ```
//!
//! L(y) is the expensive part of path 2. If y reflects diffusely, L(y) is the same in all directions, so each pixel of
//! the cluster whose first vertex sees y can use it. From each donor pixel i receives
//!
//! ```text
//!  f_i · G(x_i, y) · L(y) / sum over k of p_k(y)       G = cos_i cos_y / d²,   p_k(y) = cos_k cos_y / (π d²)
//! ```
//!
//! where f is the BRDF and k runs over all first vertices that see y, any of which could have sampled it. This is the
//! balance heuristic (Veach and Guibas 1995) with one sample of each density, so the mean is that of separate paths. At
//! best the noise of indirect light falls to that of sixteen times as many paths; the cost is up to fifteen shadow rays
//! per path. The noise of neighbouring pixels is correlated.
//!
//! A cluster consists of one sample, with the same index, of each of sixteen pixels in a cell of 8 x 8 pixels. Cells
//! are counted from the corner of the image, so a sample depends on its own ID and those of its neighbours, never on
//! tiles, crops or threads.

mod probe;
mod terms;

use terms::{FirstVertices, ReconnectionTerms};
use turner_bvh::lanes::{Block, LANES, dispatch};

use super::path_batch::PathBatch;
use super::record::Record;
use crate::bsdf::MIN_COSINE;
use crate::color::Spectrum;
use crate::film::Antialias;
use crate::integrator::{Radiance, RayStats};
use crate::material::vertex::Vertex;
use crate::material::{AlphaMode, OpenPbr};
use crate::math::{DVec3, Ray};
use crate::sampler::SampleId;
use crate::scene::{RayBatch, RayOrigin, Scene, SpectrumBlock};
use crate::view::View;

pub(super) use probe::decide;

/// Maximum number of samples that share paths: a cluster.
const CLUSTER: usize = 16;
/// Edge of the cells that hold clusters, in pixels.
pub(crate) const CELL: u32 = 8;
/// `t_max` of the shadow rays that join two vertices. They end short of the second one, so that single precision does
/// not report its surface as an occluder.
const SHADOW_END: f64 = 1.0 - 1.0 / 1024.0;
/// No sample.
const NONE: u32 = u32::MAX;

/// The cluster that a pixel belongs to, as an index within its cell. Clusters change every sixteen sample indices, so
/// that noise does not look like blocks; the first arrangement interleaves pixels. They stay the same for sixteen
/// indices, because sixteen consecutive samples are well distributed over each pixel: clusters that change with every
/// index have 12 % more noise in a Cornell box.
fn cluster_in_cell(id: &SampleId) -> u32 {
    let (x, y) = (id.x % CELL, id.y % CELL);
    match id.index / 16 % 4 {
        0 => 2 * (y % 2) + x % 2,
        1 => 2 * (y / 4) + x / 4,
        2 => y / 2,
        _ => x / 2,
    }
}

/// The samples of a sample's cluster, including itself, row by row.
pub(crate) fn cluster(view: &View, id: SampleId) -> impl Iterator<Item = SampleId> {
    let (left, top) = (id.x - id.x % CELL, id.y - id.y % CELL);
    let (right, bottom) = ((left + CELL).min(view.film.width), (top + CELL).min(view.film.height));
    (top..bottom)
        .flat_map(move |y| (left..right).map(move |x| SampleId { x, y, ..id }))
        .filter(move |other| cluster_in_cell(other) == cluster_in_cell(&id))
}

/// A first vertex with a Lambertian BSDF. Normals are on the side of the ray.
pub(super) struct FirstVertex {
    pub(super) p: DVec3,
    /// Origin of rays that leave it.
    pub(super) origin: DVec3,
    pub(super) from: RayOrigin,
    /// The shading normal, and the interpolated normal of the shape before normal maps.
    pub(super) z: DVec3,
    pub(super) ns: DVec3,
    pub(super) ng: DVec3,
    /// The BRDF.
    pub(super) f: Spectrum,
}

/// A second vertex with a Lambertian BSDF. Normals are on the side of the ray.
pub(super) struct Reconnection {
    pub(super) p: DVec3,
    /// End point of the shadow rays to it.
    pub(super) target: DVec3,
    pub(super) ng: DVec3,
    /// The shading normal before and after it is bent towards the viewer; `None` where it is the geometric normal.
    pub(super) bent: Option<[DVec3; 2]>,
}

impl FirstVertex {
    /// Whether BSDF sampling at this vertex can find `to`.
    fn can_sample(&self, to: &Reconnection) -> bool {
        let offset = to.p - self.p;
        let square = offset.length_squared();
        let wi = offset / square.sqrt();
        let (cos, cos_geometric, cos_to) = (self.z.dot(wi), self.ng.dot(wi), -to.ng.dot(wi));
        cos > MIN_COSINE
            && cos_geometric > 0.0
            && cos_to > MIN_COSINE
            && cos * cos_to / square < f64::INFINITY
            && !to.is_bent_differently(wi)
    }
}

/// A path that is shared.
struct Donor {
    sample: u32,
    cluster: u32,
    /// Bit masks over the cluster: which first vertices face the second vertex, and which see it unoccluded.
    faces: u16,
    visible: u16,
    /// For each first vertex of the cluster: the density with which it samples the second vertex, p_k, and the factor
    /// G; both per area.
    pdf: [Block; CLUSTER / LANES],
    geometry: [Block; CLUSTER / LANES],
}

/// The clusters of a path batch.
#[derive(Default)]
pub(super) struct SharedPaths {
    on: bool,
    /// The samples of each cluster, in the order of its pixels, and the cluster of each sample.
    clusters: Vec<[u32; CLUSTER]>,
    cluster_of: Vec<u32>,
    /// Index of each sample in its cluster.
    member_of: Vec<u8>,
    /// The first vertices, by cluster and by sample.
    by_cluster: Vec<FirstVertices>,
    first_vertices: Vec<Option<FirstVertex>>,
    donors: Vec<Donor>,
    reconnections: Vec<Reconnection>,
    /// Radiance that leaves the second vertex of each donor path.
    pub(super) donated: Vec<Radiance>,
    /// For each donor, the weight of that radiance in each sample of its cluster.
    weights: Vec<[Spectrum; CLUSTER]>,
    /// The second vertices of donor paths.
    points: Vec<DVec3>,
    rays: RayBatch,
    reconnections_of_rays: Vec<(u32, u8)>,
    through: Vec<SpectrumBlock>,
    /// Used while clusters are formed: the index of each cluster by its position, and the number of its samples.
    table: Vec<u32>,
    counts: Vec<u8>,
}

impl SharedPaths {
    pub(super) fn new(on: bool) -> SharedPaths {
        SharedPaths { on, ..SharedPaths::default() }
    }

    /// Whether paths are shared.
    #[inline]
    pub(super) fn is_on(&self) -> bool {
        self.on
    }

    /// Whether paths of a scene can be shared. Light paths exclude it too; the caller checks that.
    pub(super) fn is_possible(scene: &Scene, view: &View) -> bool {
        scene.volumes.is_none() && !scene.moves && view.film.antialias != Antialias::Adaptive
    }

    /// Forms the clusters of the samples.
    fn begin(&mut self, ids: &[SampleId]) {
        let cells = |edge: fn(&SampleId) -> u32| {
            let edges = ids.iter().map(edge);
            (edges.clone().min().unwrap_or(0) / CELL, edges.max().unwrap_or(0) / CELL)
        };
        let ((left, right), (top, _)) = (cells(|id| id.x), cells(|id| id.y));
        let across = right - left + 1;
        self.clusters.clear();
        self.cluster_of.clear();
        self.member_of.clear();
        self.table.clear();
        self.counts.clear();
        for (i, id) in ids.iter().enumerate() {
            let place =
                (((id.y / CELL - top) * across + id.x / CELL - left) * 4 + cluster_in_cell(id)) as usize;
            if self.table.len() <= place {
                self.table.resize(place + 1, NONE);
            }
            if self.table[place] == NONE {
                self.table[place] = self.clusters.len() as u32;
                self.clusters.push([NONE; CLUSTER]);
                self.counts.push(0);
            }
            let cluster = self.table[place];
            let (members, count) = (&mut self.clusters[cluster as usize], &mut self.counts[cluster as usize]);
            self.member_of.push(*count);
            if let Some(member) = members.get_mut(usize::from(*count)) {
                *member = i as u32;
                *count += 1;
            }
            self.cluster_of.push(cluster);
        }
        self.by_cluster.resize_with(self.clusters.len(), FirstVertices::default);
        self.by_cluster.iter_mut().for_each(FirstVertices::clear);
        self.first_vertices.clear();
        self.first_vertices.resize_with(ids.len(), || None);
        self.donated.clear();
        self.donated.resize(ids.len(), Radiance { color: Spectrum::BLACK, alpha: 1.0 });
        self.weights.resize(ids.len(), [Spectrum::BLACK; CLUSTER]);
        self.points.resize(ids.len(), DVec3::ZERO);
        self.donors.clear();
        self.reconnections.clear();
    }

    fn first(&self, sample: u32) -> Option<&FirstVertex> {
        self.first_vertices.get(sample as usize)?.as_ref()
    }
}

impl<R: Record> PathBatch<'_, R> {
    pub(super) fn begin_shared_paths(&mut self, ids: &[SampleId]) {
        if self.shared_paths.on {
            self.shared_paths.begin(ids);
        }
    }

    /// Whether a path is at its first vertex and may share its path.
    #[inline]
    pub(super) fn may_be_first(&self, sample: u32) -> bool {
        let path = &self.paths[sample as usize];
        self.shared_paths.on && path.vertex == 1 && path.media.is_empty()
    }

    /// Whether a path is at its second vertex and may become a donor.
    #[inline]
    pub(super) fn may_donate(&self, sample: u32) -> bool {
        let path = &self.paths[sample as usize];
        self.shared_paths.on
            && path.vertex == 2
            && path.bounces.total == 1
            && self.shared_paths.first(sample).is_some()
    }

    /// Stores a first or second vertex with a Lambertian BSDF.
    pub(super) fn note_shared_vertex(&mut self, sample: u32, v: &Vertex<'_>, material: &OpenPbr) {
        let (first, second) = (self.may_be_first(sample), self.may_donate(sample));
        if !first && !second {
            return;
        }
        let Some(f) = v.bsdf.as_lambert() else { return };
        let side = if v.wo.dot(v.surface.ng) >= 0.0 { 1.0 } else { -1.0 };
        let (ng, origin) = (side * v.surface.ng, v.surface.leave(v.wo));
        if first {
            let (p, from, ns) = (v.surface.p, v.surface.hit.origin(), side * v.surface.ns);
            self.set_first(sample, FirstVertex { p, origin, from, z: v.frame.z, ns, ng, f });
        } else if material.desc.alpha_mode != AlphaMode::Blend && !material.is_emissive() {
            let unbent = || side * material.frame(self.scene, v.surface).z;
            let bent = (v.frame.z != ng).then(|| [unbent(), v.frame.z]);
            self.donate(sample, Reconnection { p: v.surface.p, target: origin, ng, bent });
        }
    }

    /// Stores the first vertex of a sample.
    #[inline]
    pub(super) fn set_first(&mut self, sample: u32, first: FirstVertex) {
        let shared_paths = &mut self.shared_paths;
        let member = usize::from(shared_paths.member_of[sample as usize]);
        if member < CLUSTER {
            shared_paths.by_cluster[shared_paths.cluster_of[sample as usize] as usize].set(member, &first);
            shared_paths.first_vertices[sample as usize] = Some(first);
        }
    }

    /// Makes a path a donor from its second vertex on, if BSDF sampling at its first vertex can find the second one.
    pub(super) fn donate(&mut self, sample: u32, second: Reconnection) {
        let path = &mut self.paths[sample as usize];
        let importance = path.beta.max_component();
        let can_sample = self.shared_paths.first(sample).is_some_and(|first| first.can_sample(&second));
        if !(can_sample && importance > 0.0 && importance < f32::INFINITY) {
            return;
        }
        path.beta = Spectrum::WHITE;
        path.importance *= importance;
        path.donates = true;
        self.record.note(|r| r.donated_from = r.vertices.len().checked_sub(1));
        self.shared_paths.points[sample as usize] = second.p;
        let cluster = self.shared_paths.cluster_of[sample as usize];
        let visible = 1 << self.shared_paths.member_of[sample as usize];
        let none = [Block([0.0; LANES]); CLUSTER / LANES];
        self.shared_paths.donors.push(Donor {
            sample,
            cluster,
            faces: 0,
            visible,
            pdf: none,
            geometry: none,
        });
        self.shared_paths.reconnections.push(second);
    }

    /// Traces the reconnections to the second vertices of this round, and computes their weights.
    pub(super) fn trace_reconnections(&mut self, stats: &mut RayStats) {
        let shared_paths = &mut self.shared_paths;
        if shared_paths.donors.is_empty() {
            return;
        }
        shared_paths.rays.clear();
        shared_paths.reconnections_of_rays.clear();
        dispatch(
            self.scene.instruction_set,
            ReconnectionTerms {
                donors: &mut shared_paths.donors,
                reconnections: &shared_paths.reconnections,
                clusters: &shared_paths.by_cluster,
            },
        );
        for (number, (donor, second)) in
            shared_paths.donors.iter_mut().zip(&shared_paths.reconnections).enumerate()
        {
            let members = &shared_paths.clusters[donor.cluster as usize];
            let first = |m: usize| shared_paths.first_vertices.get(members[m] as usize)?.as_ref();
            let cluster = &shared_paths.by_cluster[donor.cluster as usize];
            donor.finish(cluster, second, |m| first(m).map(|first| (first.p, first.ns, first.ng)));
            for member in (0..CLUSTER).filter(|m| (donor.faces & !donor.visible) >> m & 1 == 1) {
                let Some(first) = first(member) else { continue };
                let ray = Ray { t_max: SHADOW_END, ..Ray::new(first.origin, second.target - first.origin) };
                shared_paths.rays.push_leaving(&ray, first.from);
                shared_paths.reconnections_of_rays.push((number as u32, member as u8));
                self.counts.add(donor.sample);
            }
        }
        stats.shadow += shared_paths.reconnections_of_rays.len() as u64;
        self.scene.transmittance_batch(&mut shared_paths.rays, &mut shared_paths.through);
        for (i, &(donor, member)) in shared_paths.reconnections_of_rays.iter().enumerate() {
            if shared_paths.through[i / LANES].get(i % LANES) == Spectrum::WHITE {
                shared_paths.donors[donor as usize].visible |= 1 << member;
            }
        }
        for donor in &shared_paths.donors {
            let reaches = |member: usize| donor.visible >> member & 1 == 1;
            let of = |blocks: &[Block], member: usize| blocks[member / LANES].0[member % LANES];
            let sum: f64 = (0..CLUSTER).filter(|m| reaches(*m)).map(|m| of(&donor.pdf, m)).sum();
            let members = &shared_paths.clusters[donor.cluster as usize];
            let weights = &mut shared_paths.weights[donor.sample as usize];
            for (member, &other) in members.iter().enumerate() {
                let first = shared_paths.first_vertices.get(other as usize).and_then(Option::as_ref);
                weights[member] = match first.filter(|_| reaches(member)) {
                    Some(first) => first.f * (of(&donor.geometry, member) / sum) as f32,
                    None => Spectrum::BLACK,
                };
            }
        }
        shared_paths.donors.clear();
        shared_paths.reconnections.clear();
    }

    /// What the sample at this index of the batch receives: for each donor its index, its second vertex, the weight,
    /// and the radiance that leaves that vertex.
    pub(super) fn received_by(
        &self,
        place: usize,
    ) -> impl Iterator<Item = (usize, DVec3, Spectrum, Spectrum)> {
        let PathBatch { shared_paths, paths, .. } = self;
        let members = &shared_paths.clusters[shared_paths.cluster_of[place] as usize];
        let lane = members.iter().position(|&m| m as usize == place);
        members.iter().map(|&m| m as usize).filter(|&m| paths.get(m).is_some_and(|p| p.donates)).filter_map(
            move |from| {
                let geometry = shared_paths.weights[from][lane?];
                (!geometry.is_black()).then_some((
                    from,
                    shared_paths.points[from],
                    geometry,
                    shared_paths.donated[from].color,
                ))
            },
        )
    }

    /// Adds the radiance of all donors to the samples of their clusters.
    pub(super) fn distribute_shared(&mut self, out: &mut [Radiance]) {
        let PathBatch { shared_paths, paths, groups, .. } = self;
        if !shared_paths.on {
            return;
        }
        for members in &shared_paths.clusters {
            for &from in members.iter().filter(|&&m| m != NONE && paths[m as usize].donates) {
                let (donated, weights) =
                    (shared_paths.donated[from as usize].color, &shared_paths.weights[from as usize]);
                for (&to, geometry) in members.iter().zip(weights) {
                    if !geometry.is_black() {
                        out[to as usize].color += *geometry * donated;
                        groups.share(from, to, *geometry);
                    }
                }
            }
        }
    }
}
