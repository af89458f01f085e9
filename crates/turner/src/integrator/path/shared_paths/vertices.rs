//! The vertices that shared paths join: the first ones of a cluster, and the second ones of donor paths.

use turner_bvh::lanes::{Block, Block32, LANES};

use super::{BLOCKS, CLUSTER, Donor, NONE, WIDE};
use crate::bsdf::{Bsdf, MIN_COSINE, OpaqueBlock};
use crate::color::Spectrum;
use crate::integrator::path::path_batch::{Path, PathBatch};
use crate::integrator::path::record::Record;
use crate::integrator::path::settings::Bounces;
use crate::material::vertex::Vertex;
use crate::material::{AlphaMode, OpenPbr};
use crate::math::DVec3;
use crate::scene::RayOrigin;

/// A first vertex. Normals are on the side of the ray.
pub(in crate::integrator::path) struct FirstVertex {
    pub(in crate::integrator::path) p: DVec3,
    /// Origin of rays that leave it.
    pub(in crate::integrator::path) origin: DVec3,
    pub(in crate::integrator::path) from: RayOrigin,
    /// The shading normal.
    pub(in crate::integrator::path) z: DVec3,
    /// The interpolated normal of a smooth mesh before normal maps, where the shadow terminator is softened.
    pub(in crate::integrator::path) soft: Option<DVec3>,
    pub(in crate::integrator::path) ng: DVec3,
    /// The BRDF, if it is Lambertian.
    pub(in crate::integrator::path) f: Option<Spectrum>,
    /// Towards the camera.
    pub(in crate::integrator::path) wo: DVec3,
    /// Throughput, bounces and number of vertices of the path up to here.
    pub(in crate::integrator::path) beta: Spectrum,
    pub(in crate::integrator::path) bounces: Bounces,
    pub(in crate::integrator::path) number: u32,
}

/// A second vertex. Normals are on the side of the ray.
pub(in crate::integrator::path) struct Reconnection {
    pub(in crate::integrator::path) p: DVec3,
    /// End point of the shadow rays to it.
    pub(in crate::integrator::path) target: DVec3,
    pub(in crate::integrator::path) ng: DVec3,
    /// The shading normal before and after it is bent towards the viewer; `None` where it is the geometric normal.
    pub(in crate::integrator::path) bent: Option<[DVec3; 2]>,
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

impl<R: Record> PathBatch<'_, R> {
    /// Whether a path is at its first vertex that is not a mirror or clear glass, and may share its path.
    #[inline]
    pub(in crate::integrator::path) fn may_be_first(&self, sample: u32) -> bool {
        let path = &self.paths[sample as usize];
        // Russian roulette on the way to the second vertex would be part of the densities. A first vertex stays one if its
        // path continues by a delta lobe: it receives the light of its neighbours all the same. After dispersion a path
        // carries one colour band, which other pixels do not share.
        self.shared_paths.is_on()
            && self.shared_paths.first(sample).is_none()
            && !path.any_nonspecular
            && path.bounces.total + 1 < self.settings.rr_start
            && path.band.is_none()
            && path.media.is_empty()
    }

    /// Whether the `number`th vertex of a path is its second one, where it may become a donor.
    #[inline]
    pub(in crate::integrator::path) fn is_second(&self, sample: u32, number: u32) -> bool {
        let path = &self.paths[sample as usize];
        let follows =
            |first: &FirstVertex| number == first.number + 1 && path.bounces.total == first.bounces.total + 1;
        self.shared_paths.is_on()
            && !path.specular_bounce
            && self.shared_paths.first(sample).is_some_and(follows)
    }

    /// Stores a first or second vertex, if its BSDF is Lambertian or an opaque base.
    pub(in crate::integrator::path) fn note_shared_vertex(
        &mut self,
        sample: u32,
        v: &Vertex<'_>,
        material: &OpenPbr,
    ) {
        let second = self.is_second(sample, self.paths[sample as usize].vertex);
        let first = self.may_be_first(sample);
        if !first && !second {
            return;
        }
        let f = v.bsdf.as_lambert();
        let base = v.bsdf.at_any_wo().and_then(Bsdf::as_opaque_base);
        let base = base.filter(|base| self.settings.counts_only_bounces && base.is_wide(WIDE));
        if f.is_none() && base.is_none() {
            return;
        }
        let side = if v.wo.dot(v.surface.ng) >= 0.0 { 1.0 } else { -1.0 };
        let (ng, origin) = (side * v.surface.ng, v.surface.leave(v.wo));
        if first {
            let (p, from) = (v.surface.p, v.surface.hit.origin());
            let softens = material.desc.soften_terminator && v.surface.ns != v.surface.ng;
            let soft = softens.then(|| side * v.surface.ns);
            let (z, wo) = (v.frame.z, v.wo);
            let Path { beta, bounces, vertex: number, .. } = self.paths[sample as usize];
            let first = FirstVertex { p, origin, from, z, soft, ng, f, wo, beta, bounces, number };
            self.set_first(sample, first, |bases, lane| {
                if let Some(base) = &base {
                    bases.set(lane, base);
                }
            });
        } else if material.desc.alpha_mode != AlphaMode::Blend && !material.is_emissive() {
            let unbent = || side * material.frame(self.scene, v.surface).z;
            let bent = (v.frame.z != ng).then(|| [unbent(), v.frame.z]);
            let number = match base.filter(|_| f.is_none()) {
                Some(base) => {
                    let mut block = std::mem::take(&mut self.shared_paths.base_scratch);
                    block.set(0, &base);
                    let path = &self.paths[sample as usize];
                    let number = self.shared_paths.add_directional(v.frame, path, (&block, 0));
                    self.shared_paths.base_scratch = block;
                    number
                }
                None => NONE,
            };
            self.donate(sample, Reconnection { p: v.surface.p, target: origin, ng, bent }, number);
        }
    }

    /// Stores the first vertex of a sample; `set_base` stores its BSDF if it is not Lambertian.
    #[inline]
    pub(in crate::integrator::path) fn set_first(
        &mut self,
        sample: u32,
        first: FirstVertex,
        set_base: impl FnOnce(&mut OpaqueBlock, usize),
    ) {
        let shared_paths = &mut self.shared_paths;
        let member = usize::from(shared_paths.member_of[sample as usize]);
        if member < CLUSTER {
            let cluster = &mut shared_paths.by_cluster[shared_paths.cluster_of[sample as usize] as usize];
            cluster.set(member, &first, set_base);
            shared_paths.first_vertices[sample as usize] = Some(first);
        }
    }

    /// Makes a path a donor from its second vertex on, if BSDF sampling at its first vertex can find the second one.
    /// `directional` is the number of that vertex if it is not Lambertian.
    pub(in crate::integrator::path) fn donate(
        &mut self,
        sample: u32,
        second: Reconnection,
        directional: u32,
    ) -> bool {
        let path = &mut self.paths[sample as usize];
        let importance = path.beta.max_component();
        let can_sample = self.shared_paths.first(sample).is_some_and(|first| first.can_sample(&second));
        if !(can_sample && importance > 0.0 && importance < f32::INFINITY) {
            return false;
        }
        path.beta = Spectrum::WHITE;
        path.importance *= importance;
        path.donates = true;
        self.record.note(|r| r.donated_from = r.vertices.len().checked_sub(1));
        self.shared_paths.points[sample as usize] = second.p;
        self.shared_paths.gives[sample as usize] = true;
        let cluster = self.shared_paths.cluster_of[sample as usize];
        let visible = 1 << self.shared_paths.member_of[sample as usize];
        let none = [Block([0.0; LANES]); BLOCKS];
        self.shared_paths.donors.push(Donor {
            sample,
            cluster,
            faces: 0,
            visible,
            pdf: none,
            geometry: none,
            f: [[Block32([0.0; LANES]); 3]; BLOCKS],
            directional,
        });
        self.shared_paths.reconnections.push(second);
        if directional != NONE {
            self.shared_paths.directional_of[sample as usize] = directional;
            self.shared_paths.is_directional[sample as usize] = true;
        }
        true
    }
}
