//! Shared paths: neighbouring pixels reuse one another's paths (Bekaert, Sbert and Halton 2002, "Accelerating path
//! tracing by re-using paths").
//!
//! ```text
//!  camera rays:  |       |       |
//!               x_1     x_2     x_3        first vertices of a cluster of pixels
//!                 .      |      .
//!                   .    |    .            |  BSDF-sampled ray of donor path 2
//!                     .  |  .              .  shadow rays (reconnections)
//!                        y                 second vertex of donor path 2; L(y): radiance that leaves it
//! ```
//!
//! L(y) is the expensive part of path 2. If y reflects diffusely, L(y) is the same in all directions, so each pixel of
//! the cluster whose first vertex sees y can use it. From each donor pixel i receives
//!
//! ```text
//!  f_i · G(x_i, y) · L(y) / sum over k of p_k(y)       G = cos_i cos_y / d²
//! ```
//!
//! where f is the BRDF, p_k(y) is the density per area with which BSDF sampling at x_k finds y, and k runs over all first
//! vertices that see y, any of which could have sampled it. This is the
//! balance heuristic (Veach and Guibas 1995) with one sample of each density, so the mean is that of separate paths. At
//! best the noise of indirect light falls to that of sixteen times as many paths; the cost is up to fifteen shadow rays
//! per path. The noise of neighbouring pixels is correlated.
//!
//! Where y is not Lambertian, its BSDF belongs to the weights, and more densities are summed: see [`directional`].
//!
//! A cluster consists of one sample, with the same index, of each of sixteen pixels in a cell of 8 x 8 pixels, or of
//! eight or four where fewer shadow rays pay better. Cells are counted from the corner of the image, so a sample depends
//! on its own ID and those of its neighbours, never on tiles, crops or threads.

mod directional;
mod probe;
mod reconnections;
mod terms;
mod vertices;

use directional::DirectionalVertex;
use terms::FirstVertices;
use turner_bvh::lanes::{Block, Block32, LANES};

use super::path_batch::PathBatch;
use super::record::{DonorPart, Record};
use crate::bsdf::OpaqueBlock;
use crate::color::Spectrum;
use crate::film::Antialias;
use crate::integrator::Radiance;
use crate::math::DVec3;
use crate::sampler::SampleId;
use crate::scene::{RayBatch, Scene, SpectrumBlock};
use crate::view::View;

pub(super) use directional::{SecondLight, SecondNext};
pub(super) use probe::{Sharing, decide};
pub(super) use vertices::{FirstVertex, Reconnection};

/// Maximum number of samples that share paths: a cluster.
const CLUSTER: usize = 16;
/// SIMD blocks per cluster.
const BLOCKS: usize = CLUSTER / LANES;
/// Minimum width α of rough mirrors that share paths.
pub(super) const WIDE: f64 = 0.1;
/// Edge of the cells that hold clusters, in pixels.
pub(crate) const CELL: u32 = 8;
/// `t_max` of the shadow rays that join two vertices. They end short of the second one, so that single precision does
/// not report its surface as an occluder.
const SHADOW_END: f64 = 1.0 - 1.0 / 1024.0;
/// No sample.
const NONE: u32 = u32::MAX;

/// The cluster of `size` pixels that a pixel belongs to, as an index within its cell. Clusters change every sixteen sample
/// indices, so that noise does not look like blocks; the first arrangement interleaves pixels. They stay the same for
/// sixteen indices, because sixteen consecutive samples are well distributed over each pixel: clusters that change with
/// every index have 12 % more noise in a Cornell box.
fn cluster_in_cell(id: &SampleId, size: u32) -> u32 {
    let (x, y) = (id.x % CELL, id.y % CELL);
    let interleaved = 2 * (y % 2) + x % 2;
    match (id.index / 16 % 4, size) {
        (0, 16..) => interleaved,
        (0, 8..) => 4 * (x / 4) + interleaved,
        (0, _) => 8 * (y / 4) + 4 * (x / 4) + interleaved,
        (1, 16..) => 2 * (y / 4) + x / 4,
        (1, 8..) => 2 * (y / 2) + x / 4,
        (1, _) => 4 * (y / 2) + x / 2,
        (2, 16..) => y / 2,
        (2, 8..) => y,
        (2, _) => 2 * y + x / 4,
        (_, 16..) => x / 2,
        (_, 8..) => x,
        (..) => 2 * x + y / 4,
    }
}

/// The samples that share paths with a sample in a cluster of `size` pixels, and itself, row by row.
pub(crate) fn cluster(view: &View, id: SampleId, size: u32) -> impl Iterator<Item = SampleId> {
    let (left, top) = (id.x - id.x % CELL, id.y - id.y % CELL);
    let (right, bottom) = ((left + CELL).min(view.film.width), (top + CELL).min(view.film.height));
    (top..bottom)
        .flat_map(move |y| (left..right).map(move |x| SampleId { x, y, ..id }))
        .filter(move |other| cluster_in_cell(other, size) == cluster_in_cell(&id, size))
}

/// Where light goes that a path finds.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Destination {
    /// To its own sample.
    Sample,
    /// To the samples of its cluster, by the weights of the path.
    Donated,
    /// The same by the weights of direct light.
    Direct,
}

/// A path that is shared.
struct Donor {
    sample: u32,
    cluster: u32,
    /// Bit masks over the cluster: which first vertices face the second vertex, and which see it unoccluded.
    faces: u16,
    visible: u16,
    /// For each first vertex of the cluster: the density with which it samples the second vertex, p_k, and the factor
    /// G; both per area. BRDFs, where they are not Lambertian.
    pdf: [Block; BLOCKS],
    geometry: [Block; BLOCKS],
    f: [[Block32; 3]; BLOCKS],
    /// Index of the second vertex among those whose BSDF depends on the direction.
    directional: u32,
}

/// The clusters of a path batch.
#[derive(Default)]
pub(super) struct SharedPaths {
    /// Number of pixels that share paths; 1 if they do not.
    size: u32,
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
    /// Whether a sample gives light to others, and whether its second vertex is directional.
    gives: Vec<bool>,
    is_directional: Vec<bool>,
    /// For directional second vertices, the mean densities of the cluster for the light and the next direction; those of
    /// another batch, if they are given.
    densities: Vec<[f64; 2]>,
    given_densities: Option<[f64; 2]>,
    /// The second vertices of the round whose BSDF is not Lambertian; only the first `len` are in use.
    directional: Vec<DirectionalVertex>,
    base_scratch: OpaqueBlock,
    len: usize,
    /// For each sample the number of its vertex in that list, in the round of the vertex.
    directional_of: Vec<u32>,
    /// Direct light of such vertices, without their BSDF, and its weights in the samples of the cluster.
    pub(super) direct: Vec<Spectrum>,
    direct_weights: Vec<[Spectrum; CLUSTER]>,
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
    pub(super) fn new(size: u32) -> SharedPaths {
        SharedPaths { size, ..SharedPaths::default() }
    }

    /// Whether paths are shared.
    #[inline]
    pub(super) fn is_on(&self) -> bool {
        self.size > 1
    }

    /// SIMD blocks per cluster.
    fn blocks(&self) -> usize {
        (self.size as usize).div_ceil(LANES).min(BLOCKS)
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
        let in_cell = CELL * CELL / self.size;
        self.clusters.clear();
        self.cluster_of.clear();
        self.member_of.clear();
        self.table.clear();
        self.counts.clear();
        for (i, id) in ids.iter().enumerate() {
            let place = (((id.y / CELL - top) * across + id.x / CELL - left) * in_cell
                + cluster_in_cell(id, self.size)) as usize;
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
        self.gives.clear();
        self.gives.resize(ids.len(), false);
        self.is_directional.clear();
        self.is_directional.resize(ids.len(), false);
        self.densities.clear();
        self.densities.resize(ids.len(), [0.0; 2]);
        self.direct.clear();
        self.direct.resize(ids.len(), Spectrum::BLACK);
        self.directional_of.clear();
        self.directional_of.resize(ids.len(), NONE);
        self.direct_weights.resize(ids.len(), [Spectrum::BLACK; CLUSTER]);
        self.len = 0;
        self.points.resize(ids.len(), DVec3::ZERO);
        self.donors.clear();
        self.reconnections.clear();
    }

    /// The parts of the light that a donor gives, with their weights in the samples of its cluster.
    fn parts(&self, from: usize) -> impl Iterator<Item = (DonorPart, &[Spectrum; CLUSTER], Spectrum)> {
        let is_directional = self.is_directional[from];
        let next = if is_directional { DonorPart::Next } else { DonorPart::Radiance };
        let direct =
            is_directional.then(|| (DonorPart::Direct, &self.direct_weights[from], self.direct[from]));
        direct.into_iter().chain([(next, &self.weights[from], self.donated[from].color)])
    }

    /// Mean densities of the cluster for the light and the next direction sampled at a directional second vertex.
    pub(super) fn densities(&self, sample: usize) -> [f64; 2] {
        self.densities.get(sample).copied().unwrap_or_default()
    }

    /// Takes these densities for the only path of the batch, instead of its own.
    pub(super) fn take_densities(&mut self, densities: [f64; 2]) {
        self.given_densities = Some(densities);
    }

    fn first(&self, sample: u32) -> Option<&FirstVertex> {
        self.first_vertices.get(sample as usize)?.as_ref()
    }
}

impl<R: Record> PathBatch<'_, R> {
    pub(super) fn begin_shared_paths(&mut self, ids: &[SampleId]) {
        if self.shared_paths.is_on() {
            self.shared_paths.begin(ids);
        }
    }
}
