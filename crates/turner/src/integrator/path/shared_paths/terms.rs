//! The geometry terms between the first vertices of a cluster and a second vertex, eight at a time.

use std::f64::consts::PI;

use turner_bvh::lanes::{Block, F64x8, LANES, Mask8, Simd, Vec3x8, Work};

use super::directional::DirectionalVertex;
use super::{BLOCKS, CLUSTER, Donor, FirstVertex, Reconnection};
use crate::bsdf::{BsdfBlock, MIN_COSINE, OpaqueBlock, OpaqueSeen, TerminatorX8};
use crate::material::bent_normal::bent_normal;
use crate::math::{DVec3, Frame};

/// The first vertices of a cluster as a structure of arrays.
#[derive(Default)]
pub(super) struct FirstVertices {
    p: [[Block; 3]; BLOCKS],
    z: [[Block; 3]; BLOCKS],
    ng: [[Block; 3]; BLOCKS],
    /// Bit masks: which entries are set, and which soften the shadow terminator. Interpolated normals of the latter.
    used: u16,
    soft: u16,
    ns: [[Block; 3]; BLOCKS],
    /// Entries that are opaque bases, those bases, and the directions towards the camera in their frames.
    opaque: u16,
    bases: [OpaqueBlock; BLOCKS],
    x: [[Block; 3]; BLOCKS],
    y: [[Block; 3]; BLOCKS],
    wo: [[Block; 3]; BLOCKS],
    /// What depends on those directions alone, once it is known.
    seen: Option<[[Block; 5]; BLOCKS]>,
}

impl FirstVertices {
    pub(super) fn clear(&mut self) {
        (self.used, self.soft, self.opaque, self.seen) = (0, 0, 0, None);
    }

    pub(super) fn set(
        &mut self,
        member: usize,
        first: &FirstVertex,
        set_base: impl FnOnce(&mut OpaqueBlock, usize),
    ) {
        let (block, lane) = (member / LANES, member % LANES);
        for (to, v) in [(&mut self.p, first.p), (&mut self.z, first.z), (&mut self.ng, first.ng)] {
            for (to, v) in to[block].iter_mut().zip(v.to_array()) {
                to.0[lane] = v;
            }
        }
        self.used |= 1 << member;
        if first.f.is_none() {
            self.opaque |= 1 << member;
            self.seen = None;
            set_base(&mut self.bases[block], lane);
            let frame = Frame::from_z(first.z);
            let wo = frame.to_local(first.wo);
            for (to, v) in [(&mut self.x, frame.x), (&mut self.y, frame.y), (&mut self.wo, wo)] {
                for (to, v) in to[block].iter_mut().zip(v.to_array()) {
                    to.0[lane] = v;
                }
            }
        }
        if let Some(ns) = first.soft {
            self.soft |= 1 << member;
            for (to, v) in self.ns[block].iter_mut().zip(ns.to_array()) {
                to.0[lane] = v;
            }
        }
    }

    /// Computes what depends on the directions towards the camera alone.
    #[inline(always)]
    fn see<S: Simd>(&mut self, simd: S, blocks: usize) {
        let mut all = [[Block::default(); 5]; BLOCKS];
        for (block, to) in all.iter_mut().enumerate().take(blocks) {
            let wo = Vec3x8::load(simd, &self.wo[block]);
            BsdfBlock::towards(&self.bases[block], simd, wo).store(to);
        }
        self.seen = Some(all);
    }

    /// The vertices of a block, and which of them are set.
    #[inline(always)]
    pub(super) fn position<S: Simd>(&self, simd: S, block: usize) -> Vec3x8<S> {
        Vec3x8::load(simd, &self.p[block])
    }

    #[inline(always)]
    pub(super) fn used(&self, block: usize) -> u8 {
        (self.used >> (block * LANES)) as u8
    }
}

/// Computes the terms of donors.
pub(super) struct ReconnectionTerms<'a> {
    pub(super) donors: &'a mut [Donor],
    pub(super) reconnections: &'a [Reconnection],
    pub(super) clusters: &'a mut [FirstVertices],
    pub(super) directional: &'a mut [DirectionalVertex],
    /// SIMD blocks per cluster.
    pub(super) blocks: usize,
}

impl Work for ReconnectionTerms<'_> {
    type Output = ();

    /// Per vertex: G = cos·cos/d², and whether it faces the second vertex.
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let splat = |v: f64| F64x8::splat(simd, v);
        let (zero, least, endless) = (splat(0.0), splat(MIN_COSINE), splat(f64::INFINITY));
        for (donor, to) in self.donors.iter_mut().zip(self.reconnections) {
            let first_vertices = &mut self.clusters[donor.cluster as usize];
            if first_vertices.opaque != 0 && first_vertices.seen.is_none() {
                first_vertices.see(simd, self.blocks);
            }
            let (p, n) = (Vec3x8::splat(simd, to.p.to_array()), Vec3x8::splat(simd, to.ng.to_array()));
            for block in 0..self.blocks.min(BLOCKS) {
                let offset = p - Vec3x8::load(simd, &first_vertices.p[block]);
                let square = offset.dot(offset);
                let length = square.sqrt();
                let wi = Vec3x8 { x: offset.x / length, y: offset.y / length, z: offset.z / length };
                let cos = Vec3x8::load(simd, &first_vertices.z[block]).dot(wi);
                let ng = Vec3x8::load(simd, &first_vertices.ng[block]);
                let cos_geometric = ng.dot(wi);
                let cos_to = -n.dot(wi);
                let density = cos * cos_to / square;
                let faces = cos.gt(least) & cos_geometric.gt(zero) & cos_to.gt(least) & density.lt(endless);
                let opaque = (first_vertices.opaque >> (block * LANES)) as u8;
                let soft = Mask8::new(simd, (first_vertices.soft >> (block * LANES)) as u8);
                let ns = Vec3x8::load(simd, &first_vertices.ns[block]);
                let softening = TerminatorX8::new(simd, ns, ng, soft).softening(simd, wi);
                let lambert = Mask8::new(simd, !opaque);
                (density * lambert.select(softening, splat(1.0))).store(&mut donor.geometry[block]);
                let mut pdf = density / splat(PI);
                if opaque != 0 {
                    let (x, y) = (&first_vertices.x[block], &first_vertices.y[block]);
                    let (x, y) = (Vec3x8::load(simd, x), Vec3x8::load(simd, y));
                    let local = Vec3x8 { x: x.dot(wi), y: y.dot(wi), z: cos };
                    let wo = Vec3x8::load(simd, &first_vertices.wo[block]);
                    let base = &first_vertices.bases[block];
                    let seen = first_vertices.seen.as_ref().map(|seen| OpaqueSeen::load(simd, &seen[block]));
                    let Some(seen) = seen else { continue };
                    let (f, of_base) = BsdfBlock::eval_pdf(base, simd, wo, &seen, local, softening);
                    for (to, f) in donor.f[block].iter_mut().zip(f) {
                        f.store(to);
                    }
                    pdf = Mask8::new(simd, opaque).select(of_base * cos_to / square, pdf);
                }
                pdf.store(&mut donor.pdf[block]);
                let used = (first_vertices.used >> (block * LANES)) as u8;
                donor.faces |= u16::from(faces.bits() & used) << (block * LANES);
            }
            if let Some(second) = self.directional.get_mut(donor.directional as usize) {
                second.evaluate(simd, to.p, first_vertices, self.blocks);
            }
        }
    }
}

impl Donor {
    /// The rare part, one vertex at a time: shading normals that are bent for the viewer. `first` are the points of the
    /// first vertices.
    pub(super) fn finish(&mut self, to: &Reconnection, first: impl Fn(usize) -> Option<DVec3>) {
        let rare = if to.bent.is_some() { self.faces } else { 0 };
        for member in (0..CLUSTER).filter(|m| rare >> m & 1 == 1) {
            let Some(p) = first(member) else { continue };
            let offset = to.p - p;
            let wi = offset / offset.length_squared().sqrt();
            if to.is_bent_differently(wi) {
                self.faces &= !(1 << member);
            }
        }
    }
}

impl Reconnection {
    /// Whether the shading normal would be bent differently for a viewer in direction `-wi`.
    pub(super) fn is_bent_differently(&self, wi: DVec3) -> bool {
        self.bent.is_some_and(|[z, bent]| bent_normal(-wi, z, self.ng) != bent || bent.dot(-wi) <= MIN_COSINE)
    }
}
