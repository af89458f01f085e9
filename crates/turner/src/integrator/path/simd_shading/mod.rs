//! SIMD shading: the commonest vertices, eight at a time. These are surfaces whose BSDF is Lambertian or an opaque base:
//! metal, or diffuse reflection under a dielectric interface (see [`BlockBsdf`]).
//!
//! ```text
//!  hits:   L  g  L  D  M  g  L ...          L: Lambertian;  D, M: opaque base without and with metal;  g: anything else
//!          |  |  |  |  |
//!  blocks: [L L L L L L L L] [D D . . . . . .] [M . . . . . . .]     one lane per vertex
//!  rest:   g g                                                       scalar code, `shade`
//! ```
//!
//! A vertex is sorted into a block at its hit. Triangles of constant materials need no
//! [`SurfaceInteraction`](crate::scene::SurfaceInteraction): their surfaces are computed in the block. The lanes perform
//! the operations of [`PathBatch::shade`] in the same order and precision, so each vertex has the same bits as in scalar
//! code, on every instruction set and in any batch. All other vertices, and all vertices of recorded paths, are shaded by
//! scalar code.

mod follow;
mod shade;
mod take;

use turner_bvh::lanes::{Block, Block32, LANES, Simd, Work, dispatch};

use super::LightSampling;
use super::light_resampling::{CANDIDATES, Facing, NONE, resample, resamples};
use super::path_batch::{Path, PathBatch};
use super::record::Record;
use super::shade::MAX_VERTICES;
use super::shared_paths::{FirstVertex, Reconnection, WIDE};
use crate::bsdf::{BsdfBlock, LambertBlock, OpaqueBlock};
use crate::color::Spectrum;
use crate::integrator::RayStats;
use crate::light::Receiver;
use crate::material::Gloss;
use crate::math::block::{bits, set_vector};
use crate::scene::light_sample::LightSample;
use crate::scene::{LightBatch, RayOrigin, SurfaceBlock};

/// The vertices of one round; memory is reused.
#[derive(Default)]
pub(super) struct VertexBlocks {
    lambert: List<LambertBlock>,
    dielectrics: List<OpaqueBlock>,
    metals: List<OpaqueBlock>,
    /// Which hits are in blocks.
    in_block: Vec<bool>,
    shading: Shading,
}

/// The vertices of one BSDF.
#[derive(Default)]
struct List<K> {
    blocks: Vec<VertexBlock<K>>,
    /// Number of vertices; only the last block may have free lanes.
    len: usize,
}

impl VertexBlocks {
    /// Removes all vertices; `hits` is the number of hits of the round.
    pub(super) fn clear(&mut self, hits: usize) {
        self.lambert.len = 0;
        self.dielectrics.len = 0;
        self.metals.len = 0;
        self.in_block.clear();
        self.in_block.resize(hits, false);
    }

    /// Whether the hit with this index is in a block.
    #[inline]
    pub(super) fn contains(&self, hit: usize) -> bool {
        self.in_block[hit]
    }
}

impl<K: Default> List<K> {
    /// The next free lane, and its block.
    #[inline]
    fn free(&mut self) -> (&mut VertexBlock<K>, usize) {
        let (index, lane) = (self.len / LANES, self.len % LANES);
        if index == self.blocks.len() {
            self.blocks.push(VertexBlock::default());
        }
        (&mut self.blocks[index], lane)
    }

    /// The blocks in use, with the number of vertices in each.
    fn used(&mut self) -> impl Iterator<Item = (&mut VertexBlock<K>, usize)> {
        let len = self.len;
        let blocks = self.blocks.iter_mut().take(len.div_ceil(LANES)).enumerate();
        blocks.map(move |(i, block)| (block, LANES.min(len - i * LANES)))
    }
}

/// Eight vertices.
#[derive(Default)]
struct VertexBlock<K> {
    surfaces: SurfaceBlock,
    kind: K,
    samples: [u32; LANES],
    from: [RayOrigin; LANES],
    /// Glossiness of their materials, for light sampling.
    sides: [Option<Gloss>; LANES],
    /// Curvatures of the surfaces, positive where convex, for the ray cones after reflection.
    curvature: Block,
    /// Receivers for light sampling; also the receivers of emitters that their next rays hit.
    receivers: [Option<Receiver>; LANES],
    /// Index of each request for light.
    lights: [u32; LANES],
}

/// Inputs and outputs of shading a block.
#[derive(Default)]
struct Shading {
    /// Throughputs.
    beta: [Block32; 3],
    /// Three random numbers each for the next direction, as for `Bsdf::sample`.
    u: [Block; 3],
    /// Bit mask of lanes with a sampled light, and those lights.
    lit: u8,
    to_light: [Block; 3],
    radiance: [Block32; 3],
    light_pdf: Block,
    /// What shadow rays to those lights end before.
    targets: [RayOrigin; LANES],
    /// The light groups of those lights, if they are told apart.
    groups: [u32; LANES],
    /// Resampling weights.
    resampling_weight: Block32,
    /// Bit masks: lights at a finite distance, and lights that BSDF-sampled rays can hit too (MIS).
    finite: u8,
    weighed: u8,
    /// Bit mask of lanes with a shadow ray, those rays, and their contributions.
    connects: u8,
    shadow_origin: [Block; 3],
    shadow: [Block; 3],
    light: [Block32; 3],
    /// Bit masks: lanes with a next ray, by a delta lobe, by a diffuse lobe. Those rays.
    follows: u8,
    delta: u8,
    diffuse: u8,
    origin: [Block; 3],
    next: [Block; 3],
    pdf: Block,
    beta_next: [Block32; 3],
    /// Bit mask of second vertices of shared paths. For these: the local directions to the sampled lights and of the next
    /// rays, the factors of diffuse reflection at the shadow terminators in both, and BRDF and cosine over density in the
    /// latter.
    second: u8,
    local: [[Block; 3]; 2],
    softening: [Block; 2],
    f_next: [Block32; 3],
    k_next: Block32,
}

impl<R: Record> PathBatch<'_, R> {
    /// Computes the surfaces of the blocks and requests light samples for them.
    pub(super) fn request_lights_in_blocks(&mut self, lights: &mut LightBatch) {
        let mut vertices = std::mem::take(&mut self.blocks);
        self.request_lights(&mut vertices.lambert, lights);
        self.request_lights(&mut vertices.dielectrics, lights);
        self.request_lights(&mut vertices.metals, lights);
        self.blocks = vertices;
    }

    fn request_lights<K: Default>(&self, vertices: &mut List<K>, lights: &mut LightBatch) {
        if vertices.len == 0 {
            return;
        }
        dispatch(self.scene.instruction_set, Surfaces(vertices));
        let asks = self.settings.light_sampling != LightSampling::Bsdf && !self.guides.are_alone();
        for (block, len) in vertices.used() {
            let adaptive = self.adaptive.filter(|_| !self.settings.by_cosine);
            let cells = adaptive.map(|adaptive| adaptive.cells_of_block(block.surfaces.stored_points()));
            for lane in 0..len {
                let surfaces = &block.surfaces;
                let (p, ng, ns) =
                    (surfaces.point(lane), surfaces.normal(lane), surfaces.shading_normal(lane));
                let sample = block.samples[lane];
                let path = &self.paths[sample as usize];
                let (gloss, direction) = (block.sides[lane], surfaces.direction(lane));
                let receiver = self.scene.receiver_of(gloss, p, ng, ns, direction);
                let receiver = cells.map_or(receiver, |cells| receiver.in_cell(cells[lane]));
                let facing = Facing { gloss, ng, ns, direction };
                let receiver = self.of_vertex(sample, path.vertex + 1, receiver, facing);
                let receiver = receiver.with_candidates(self.extra_light_samples(path, &receiver));
                block.receivers[lane] = Some(receiver);
                block.lights[lane] = NONE;
                if asks && !self.is_spent(path) {
                    block.lights[lane] = self.request_light(path, receiver, lights);
                }
            }
        }
    }

    /// Shades all blocks.
    pub(super) fn shade_blocks(&mut self, lights: &LightBatch, stats: &mut RayStats) {
        let mut vertices = std::mem::take(&mut self.blocks);
        let VertexBlocks { lambert, dielectrics, metals, shading, .. } = &mut vertices;
        self.shade_list(lambert, shading, lights, stats);
        self.shade_list(dielectrics, shading, lights, stats);
        self.shade_list(metals, shading, lights, stats);
        self.blocks = vertices;
    }

    fn shade_list<K: BsdfBlock>(
        &mut self,
        vertices: &mut List<K>,
        shading: &mut Shading,
        lights: &LightBatch,
        stats: &mut RayStats,
    ) {
        for (block, len) in vertices.used() {
            let (mut lanes, mut resampled, mut several) = (0, 0, 0);
            (shading.lit, shading.second) = (0, 0);
            shading.resampling_weight = Block32([1.0; LANES]);
            for lane in 0..len {
                let path = &mut self.paths[block.samples[lane] as usize];
                path.vertex += 1;
                let path = &self.paths[block.samples[lane] as usize];
                if path.vertex > MAX_VERTICES || self.is_spent(path) {
                    continue;
                }
                lanes |= 1 << lane;
                if self.shared_paths.is_on() {
                    let is_second = self.note_shared_vertex_in_block(block, lane);
                    shading.second |= u8::from(is_second) << lane;
                }
                let path = &self.paths[block.samples[lane] as usize];
                set32(&mut shading.beta, lane, path.beta);
                let [u0, u1, u2, _] = path.numbers.second();
                for (block, u) in shading.u.iter_mut().zip([u2, u0, u1]) {
                    block.0[lane] = u;
                }
                match lights.get(block.lights[lane] as usize) {
                    [] => {}
                    _ if block.receivers[lane].as_ref().is_some_and(resamples) => resampled |= 1 << lane,
                    [first, others @ ..] => {
                        self.set_light(shading, lane, first.as_ref());
                        several |= u8::from(!others.is_empty()) << lane;
                    }
                }
            }
            if lanes == 0 {
                continue;
            }
            if resampled != 0 {
                self.choose_lights(block, shading, lights, resampled);
            }
            dispatch(self.scene.instruction_set, shade::Shade { block, shading });
            for lane in bits(shading.connects & lanes) {
                self.connect_lane(block, shading, lane);
            }
            self.connect_to_others(block, shading, lights, several);
            for lane in bits(shading.follows & lanes) {
                self.follow_lane(block, shading, lane, stats);
            }
        }
    }

    /// As `note_shared_vertex`, for the vertex in a lane. Returns whether it is the second vertex of a shared path and its BSDF
    /// is not Lambertian.
    fn note_shared_vertex_in_block<K: BsdfBlock>(&mut self, block: &VertexBlock<K>, lane: usize) -> bool {
        let sample = block.samples[lane];
        let second = self.is_second(sample, self.paths[sample as usize].vertex);
        let first = self.may_be_first(sample);
        if !first && !second {
            return false;
        }
        let f = block.kind.lambert(lane);
        let bases = block
            .kind
            .opaque()
            .filter(|bases| self.settings.counts_only_bounces && bases.is_wide(lane, WIDE));
        if f.is_none() && bases.is_none() {
            return false;
        }
        let surfaces = &block.surfaces;
        let (p, ng) = (surfaces.point(lane), surfaces.normal(lane));
        let side = if surfaces.direction(lane).dot(ng) <= 0.0 { 1.0 } else { -1.0 };
        let (origin, ng) = (surfaces.leave(lane, side), side * ng);
        let z = surfaces.frame_normal(lane);
        if first {
            let soft = surfaces.soft_normal(lane).map(|ns| side * ns);
            let Path { beta, bounces, vertex: number, .. } = self.paths[sample as usize];
            let (from, wo) = (block.from[lane], -surfaces.direction(lane));
            let first = FirstVertex { p, origin, from, z, soft, ng, f, wo, beta, bounces, number };
            self.set_first(sample, first, |to, place| {
                if let Some(bases) = bases {
                    to.copy_lane(place, bases, lane);
                }
            });
            return false;
        }
        let bent = (z != ng).then(|| [side * surfaces.mapped_normal(lane), z]);
        let number = bases.map(|bases| {
            let path = &self.paths[sample as usize];
            self.shared_paths.add_directional(surfaces.frame(lane), path, (bases, lane))
        });
        let second = Reconnection { p, target: origin, ng, bent };
        self.donate(sample, second, number.unwrap_or(NONE)) && number.is_some()
    }

    /// Queues shadow rays to the second and further light samples of lanes.
    fn connect_to_others<K: BsdfBlock>(
        &mut self,
        block: &VertexBlock<K>,
        shading: &mut Shading,
        lights: &LightBatch,
        lanes: u8,
    ) {
        for number in 1..self.settings.light_samples as usize {
            shading.lit = 0;
            for lane in bits(lanes) {
                let light = lights.get(block.lights[lane] as usize).get(number);
                self.set_light(shading, lane, light.and_then(Option::as_ref));
            }
            if shading.lit == 0 {
                continue;
            }
            dispatch(self.scene.instruction_set, shade::Light { block, shading });
            for lane in bits(shading.connects) {
                self.connect_lane(block, shading, lane);
            }
        }
    }

    /// Chooses one of several light candidates for lanes, as `choose_light` does.
    fn choose_lights<K: BsdfBlock>(
        &self,
        block: &VertexBlock<K>,
        shading: &mut Shading,
        lights: &LightBatch,
        lanes: u8,
    ) {
        let candidate = |lane: usize, number: usize| {
            lights.get(block.lights[lane] as usize).get(number).and_then(Option::as_ref)
        };
        let mut contributions = [[0.0; LANES]; CANDIDATES];
        for (number, contributions) in contributions.iter_mut().enumerate() {
            for lane in bits(lanes) {
                self.set_light(shading, lane, candidate(lane, number));
            }
            dispatch(self.scene.instruction_set, shade::Light { block, shading });
            for lane in bits(lanes & shading.connects) {
                contributions[lane] = get32(&shading.light, lane).luminance();
            }
        }
        for lane in bits(lanes) {
            let [u, ..] = self.paths[block.samples[lane] as usize].numbers.first();
            match resample(&contributions.map(|b| b[lane]), u) {
                Some((chosen, resampling_weight)) => {
                    self.set_light(shading, lane, candidate(lane, chosen));
                    shading.resampling_weight.0[lane] = resampling_weight;
                }
                None => shading.lit &= !(1 << lane),
            }
        }
    }

    #[inline]
    fn set_light(&self, shading: &mut Shading, lane: usize, lit: Option<&LightSample>) {
        let bit = 1 << lane;
        let Some(lit) = lit else {
            shading.lit &= !bit;
            return;
        };
        shading.lit |= bit;
        let weighed = !lit.is_delta && self.settings.light_sampling == LightSampling::Both;
        shading.weighed = shading.weighed & !bit | u8::from(weighed) << lane;
        shading.finite = shading.finite & !bit | u8::from(lit.finite) << lane;
        set_vector(&mut shading.to_light, lane, lit.to_light);
        set32(&mut shading.radiance, lane, lit.radiance);
        shading.light_pdf.0[lane] = lit.pdf;
        shading.targets[lane] = lit.target();
        shading.groups[lane] = self.groups.of_sample(self.scene, lit);
    }
}

struct Surfaces<'a, K>(&'a mut List<K>);

impl<K> Work for Surfaces<'_, K> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let used = self.0.len.div_ceil(LANES);
        for block in &mut self.0.blocks[..used] {
            block.surfaces.compute(simd);
        }
    }
}

#[inline]
fn set32(to: &mut [Block32; 3], lane: usize, c: Spectrum) {
    (to[0].0[lane], to[1].0[lane], to[2].0[lane]) = (c.r, c.g, c.b);
}

#[inline]
fn get32([r, g, b]: &[Block32; 3], lane: usize) -> Spectrum {
    Spectrum::new(r.0[lane], g.0[lane], b.0[lane])
}
