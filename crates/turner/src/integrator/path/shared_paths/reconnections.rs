//! Reconnections: which first vertices see the second vertices of the round, the weights that follow, and the light that
//! the samples receive in the end.

use turner_bvh::lanes::{Block, LANES, dispatch};

use super::directional::color_at;
use super::terms::ReconnectionTerms;
use super::vertices::FirstVertex;
use super::{BLOCKS, NONE, SHADOW_END};
use crate::color::Spectrum;
use crate::integrator::path::path_batch::PathBatch;
use crate::integrator::path::record::{DonorPart, Record};
use crate::integrator::{Radiance, RayStats};
use crate::math::{DVec3, Ray};

impl<R: Record> PathBatch<'_, R> {
    /// Traces the reconnections to the second vertices of this round, and computes their weights.
    pub(in crate::integrator::path) fn trace_reconnections(&mut self, stats: &mut RayStats) {
        let shared_paths = &mut self.shared_paths;
        if shared_paths.donors.is_empty() {
            return;
        }
        let blocks = shared_paths.blocks();
        let size = shared_paths.size as usize;
        shared_paths.rays.clear();
        shared_paths.reconnections_of_rays.clear();
        dispatch(
            self.scene.instruction_set,
            ReconnectionTerms {
                donors: &mut shared_paths.donors,
                reconnections: &shared_paths.reconnections,
                clusters: &mut shared_paths.by_cluster,
                directional: &mut shared_paths.directional,
                blocks,
            },
        );
        for (number, (donor, second)) in
            shared_paths.donors.iter_mut().zip(&shared_paths.reconnections).enumerate()
        {
            let members = &shared_paths.clusters[donor.cluster as usize];
            let first = |m: usize| shared_paths.first_vertices.get(members[m] as usize)?.as_ref();
            donor.finish(second, |m| first(m).map(|first| first.p));
            let kind = |first: &FirstVertex| (first.bounces, first.number);
            let own = shared_paths.first_vertices[donor.sample as usize].as_ref().map(kind);
            for member in (0..size).filter(|m| (donor.faces & !donor.visible) >> m & 1 == 1) {
                // Limits on bounces must end the paths of all members alike, and all first vertices must be known.
                let Some(first) = first(member).filter(|first| Some(kind(first)) == own) else { continue };
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
            let of = |blocks: &[Block; BLOCKS], member: usize| blocks[member / LANES].0[member % LANES];
            let sum: f64 = (0..size).filter(|m| reaches(*m)).map(|m| of(&donor.pdf, m)).sum();
            let members = &shared_paths.clusters[donor.cluster as usize];
            let weights = &mut shared_paths.weights[donor.sample as usize];
            for (member, &other) in members.iter().enumerate() {
                let first = shared_paths.first_vertices.get(other as usize).and_then(Option::as_ref);
                weights[member] = match first.filter(|_| reaches(member)) {
                    Some(first) => {
                        let f = first.f.unwrap_or_else(|| color_at(&donor.f, member));
                        first.beta * f * (of(&donor.geometry, member) / sum) as f32
                    }
                    None => Spectrum::BLACK,
                };
            }
            if let Some(v) = shared_paths.directional.get(donor.directional as usize) {
                let mean = |pdf: &[Block; BLOCKS]| {
                    let terms = (0..size).filter(|m| reaches(*m)).map(|m| of(&donor.pdf, m) * of(pdf, m));
                    terms.sum::<f64>() / sum
                };
                let direct_weights = &mut shared_paths.direct_weights[donor.sample as usize];
                *direct_weights = *weights;
                for (member, (direct, rest)) in direct_weights.iter_mut().zip(weights).enumerate() {
                    let [light, next] = v.in_both(member);
                    (*direct, *rest) = (*direct * light, *rest * next);
                }
                let own = [mean(&v.towards_light.pdf), mean(&v.towards_next.pdf)];
                let densities = shared_paths.given_densities.unwrap_or(own);
                shared_paths.densities[donor.sample as usize] = densities;
                if let Some(light) = &v.light {
                    let ratio = if light.weighed { densities[0] / light.pdf } else { 0.0 };
                    let weight = 1.0 / (1.0 + ratio * ratio);
                    let arrives = light.radiance * (weight * light.k) as f32;
                    self.shadows.light[light.ray].1 = arrives;
                    self.record.note(|r| r.donates_direct(weight, densities[0], arrives));
                }
                if let Some(next) = &v.next {
                    let path = &mut self.paths[donor.sample as usize];
                    let own = path.beta.max_component();
                    let weight = Spectrum::grey((next.k / densities[1]) as f32);
                    path.beta = weight * (1.0 / next.survival);
                    path.pdf = densities[1];
                    // Russian roulette continues as if nothing were shared.
                    path.importance *= own / path.beta.max_component();
                    self.record.note(|r| r.donates_next(weight, densities[1], path.beta));
                }
            }
        }
        shared_paths.donors.clear();
        shared_paths.reconnections.clear();
        shared_paths.len = 0;
    }

    /// Ends a round: light that arrives later is not direct light of second vertices.
    pub(in crate::integrator::path) fn end_round_of_shared_paths(&mut self, samples: &[u32]) {
        if self.shared_paths.is_on() {
            for &sample in samples {
                self.shared_paths.directional_of[sample as usize] = NONE;
            }
        }
    }

    /// What a sample receives from the donors of its cluster. `place` is its index in the batch. Each item has the index of
    /// the donor, its second vertex, the part of its light, the weight of that part, and the light.
    pub(in crate::integrator::path) fn received_by(
        &self,
        place: usize,
    ) -> impl Iterator<Item = (usize, DVec3, DonorPart, Spectrum, Spectrum)> {
        let shared_paths = &self.shared_paths;
        let members = &shared_paths.clusters[shared_paths.cluster_of[place] as usize];
        let lane = members.iter().position(|&m| m as usize == place);
        let donors =
            members.iter().map(|&m| m as usize).filter(|&m| shared_paths.gives.get(m) == Some(&true));
        donors.flat_map(move |from| shared_paths.parts(from).map(move |part| (from, part))).filter_map(
            move |(from, (part, weights, light))| {
                let weight = weights[lane?];
                let gives = !weight.is_black() && (part != DonorPart::Direct || !light.is_black());
                gives.then_some((from, shared_paths.points[from], part, weight, light))
            },
        )
    }

    /// Adds the radiance of all donors to the samples of their clusters.
    pub(in crate::integrator::path) fn distribute_shared(&mut self, out: &mut [Radiance]) {
        let PathBatch { shared_paths, groups, .. } = self;
        if !shared_paths.is_on() {
            return;
        }
        for members in &shared_paths.clusters {
            for &from in members.iter().filter(|&&m| m != NONE && shared_paths.gives[m as usize]) {
                for (part, weights, light) in shared_paths.parts(from as usize) {
                    if part == DonorPart::Direct && light.is_black() {
                        continue;
                    }
                    for (&to, weight) in members.iter().zip(weights).filter(|(_, weight)| !weight.is_black())
                    {
                        out[to as usize].color += *weight * light;
                        groups.share(from, to, part == DonorPart::Direct, *weight);
                    }
                }
            }
        }
    }
}
