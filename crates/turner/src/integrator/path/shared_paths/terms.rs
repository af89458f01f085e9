//! The geometry terms between the first vertices of a cluster and a second vertex, eight at a time.

use std::f64::consts::PI;

use turner_bvh::lanes::{Block, F64x8, LANES, Simd, Vec3x8, Work};

use super::{Donor, FirstVertex, GROUP, Reconnection};
use crate::bsdf::MIN_COSINE;
use crate::material::bent_normal::bent_normal;
use crate::material::vertex::softened;
use crate::math::DVec3;

/// SIMD blocks per cluster.
const BLOCKS: usize = GROUP / LANES;

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
    pub(super) groups: &'a [FirstVertices],
}

impl Work for ReconnectionTerms<'_> {
    type Output = ();

    /// Per vertex: G = cos·cos/d², and whether it faces the second vertex.
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let splat = |v: f64| F64x8::splat(simd, v);
        let (zero, least, endless) = (splat(0.0), splat(MIN_COSINE), splat(f64::INFINITY));
        for (donor, to) in self.donors.iter_mut().zip(self.reconnections) {
            let firsts = &self.groups[donor.group as usize];
            let (p, n) = (Vec3x8::splat(simd, to.p.to_array()), Vec3x8::splat(simd, to.ng.to_array()));
            for block in 0..BLOCKS {
                let way = p - Vec3x8::load(simd, &firsts.p[block]);
                let square = way.dot(way);
                let length = square.sqrt();
                let wi = Vec3x8 { x: way.x / length, y: way.y / length, z: way.z / length };
                let cos = Vec3x8::load(simd, &firsts.z[block]).dot(wi);
                let leaves = Vec3x8::load(simd, &firsts.ng[block]).dot(wi);
                let arrives = -n.dot(wi);
                let density = cos * arrives / square;
                let sees = cos.gt(least) & leaves.gt(zero) & arrives.gt(least) & density.lt(endless);
                density.store(&mut donor.pdf[block]);
                let used = (firsts.used >> (block * LANES)) as u8;
                donor.sees |= u16::from(sees.bits() & used) << (block * LANES);
            }
        }
    }
}

impl Donor {
    /// The rare parts, one vertex at a time: shading normals that are bent for the viewer, and softened terminators.
    /// Densities get their factor 1/π.
    pub(super) fn finish(
        &mut self,
        group: &FirstVertices,
        to: &Reconnection,
        first: impl Fn(usize) -> Option<(DVec3, DVec3, DVec3)>,
    ) {
        for (pdf, share) in self.pdf.iter_mut().zip(&mut self.share) {
            *share = *pdf;
            for v in &mut pdf.0 {
                *v /= PI;
            }
        }
        let doubtful = if to.bent.is_some() { self.sees } else { self.sees & group.soft };
        for member in (0..GROUP).filter(|m| doubtful >> m & 1 == 1) {
            let Some((p, ns, ng)) = first(member) else { continue };
            let way = to.p - p;
            let wi = way / way.length_squared().sqrt();
            if to.is_bent_otherwise(wi) {
                self.sees &= !(1 << member);
            }
            self.share[member / LANES].0[member % LANES] *= softened(ns, ng, wi);
        }
    }
}

impl Reconnection {
    /// Whether the shading normal would be bent differently for a viewer in direction `-wi`.
    pub(super) fn is_bent_otherwise(&self, wi: DVec3) -> bool {
        self.bent.is_some_and(|[z, bent]| bent_normal(-wi, z, self.ng) != bent || bent.dot(-wi) <= MIN_COSINE)
    }
}
