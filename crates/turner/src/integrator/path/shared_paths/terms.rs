//! The geometry terms between the first vertices of a cluster and a second vertex, eight at a time.

use std::f64::consts::PI;

use turner_bvh::lanes::{Block, F64x8, LANES, Simd, Vec3x8, Work};

use super::{CLUSTER, Donor, FirstVertex, Reconnection};
use crate::bsdf::MIN_COSINE;
use crate::material::bent_normal::bent_normal;
use crate::material::vertex::softened;
use crate::math::DVec3;

/// SIMD blocks per cluster.
const BLOCKS: usize = CLUSTER / LANES;

/// The first vertices of a cluster as a structure of arrays.
#[derive(Default)]
pub(super) struct FirstVertices {
    p: [[Block; 3]; BLOCKS],
    z: [[Block; 3]; BLOCKS],
    ng: [[Block; 3]; BLOCKS],
    /// Bit masks: which entries are set, and which soften the shadow terminator.
    used: u16,
    soft: u16,
}

impl FirstVertices {
    pub(super) fn clear(&mut self) {
        (self.used, self.soft) = (0, 0);
    }

    pub(super) fn set(&mut self, member: usize, first: &FirstVertex) {
        let (block, lane) = (member / LANES, member % LANES);
        for (to, v) in [(&mut self.p, first.p), (&mut self.z, first.z), (&mut self.ng, first.ng)] {
            for (to, v) in to[block].iter_mut().zip(v.to_array()) {
                to.0[lane] = v;
            }
        }
        self.used |= 1 << member;
        if first.ns != first.ng {
            self.soft |= 1 << member;
        }
    }
}

/// Computes the terms of donors.
pub(super) struct ReconnectionTerms<'a> {
    pub(super) donors: &'a mut [Donor],
    pub(super) reconnections: &'a [Reconnection],
    pub(super) clusters: &'a [FirstVertices],
}

impl Work for ReconnectionTerms<'_> {
    type Output = ();

    /// Per vertex: G = cos·cos/d², and whether it faces the second vertex.
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let splat = |v: f64| F64x8::splat(simd, v);
        let (zero, least, endless) = (splat(0.0), splat(MIN_COSINE), splat(f64::INFINITY));
        for (donor, to) in self.donors.iter_mut().zip(self.reconnections) {
            let first_vertices = &self.clusters[donor.cluster as usize];
            let (p, n) = (Vec3x8::splat(simd, to.p.to_array()), Vec3x8::splat(simd, to.ng.to_array()));
            for block in 0..BLOCKS {
                let offset = p - Vec3x8::load(simd, &first_vertices.p[block]);
                let square = offset.dot(offset);
                let length = square.sqrt();
                let wi = Vec3x8 { x: offset.x / length, y: offset.y / length, z: offset.z / length };
                let cos = Vec3x8::load(simd, &first_vertices.z[block]).dot(wi);
                let cos_geometric = Vec3x8::load(simd, &first_vertices.ng[block]).dot(wi);
                let cos_to = -n.dot(wi);
                let density = cos * cos_to / square;
                let faces = cos.gt(least) & cos_geometric.gt(zero) & cos_to.gt(least) & density.lt(endless);
                density.store(&mut donor.pdf[block]);
                let used = (first_vertices.used >> (block * LANES)) as u8;
                donor.faces |= u16::from(faces.bits() & used) << (block * LANES);
            }
        }
    }
}

impl Donor {
    /// The rare parts, one vertex at a time: shading normals that are bent for the viewer, and softened terminators.
    /// Densities get their factor 1/π.
    pub(super) fn finish(
        &mut self,
        cluster: &FirstVertices,
        to: &Reconnection,
        first: impl Fn(usize) -> Option<(DVec3, DVec3, DVec3)>,
    ) {
        for (pdf, geometry) in self.pdf.iter_mut().zip(&mut self.geometry) {
            *geometry = *pdf;
            for v in &mut pdf.0 {
                *v /= PI;
            }
        }
        let rare = if to.bent.is_some() { self.faces } else { self.faces & cluster.soft };
        for member in (0..CLUSTER).filter(|m| rare >> m & 1 == 1) {
            let Some((p, ns, ng)) = first(member) else { continue };
            let offset = to.p - p;
            let wi = offset / offset.length_squared().sqrt();
            if to.is_bent_differently(wi) {
                self.faces &= !(1 << member);
            }
            self.geometry[member / LANES].0[member % LANES] *= softened(ns, ng, wi);
        }
    }
}

impl Reconnection {
    /// Whether the shading normal would be bent differently for a viewer in direction `-wi`.
    pub(super) fn is_bent_differently(&self, wi: DVec3) -> bool {
        self.bent.is_some_and(|[z, bent]| bent_normal(-wi, z, self.ng) != bent || bent.dot(-wi) <= MIN_COSINE)
    }
}
