//! Second vertices whose BSDF is not Lambertian: each first vertex of the cluster sees another radiance.
//!
//! ```text
//!  x_1    x_2    x_3         A donor path samples a light and its next direction at y. Pixel i receives
//!    \     |     /
//!     \    |    /   light      f_i G_i / sum_k p_k(y)  ·  f_y(x_i, light) · cos · Le / p(light)
//!      \   |   /   *
//!       \  |  /  /             f_i G_i / sum_k p_k(y)  ·  f_y(x_i, next) · cos · L(next) / p(next)
//!          y -------> next
//!                             p(next) = sum_k p_k(y) p_y(next | x_k) / sum_k p_k(y)
//! ```
//!
//! Any first vertex that sees y could have sampled both y and the next direction, so the balance heuristic takes the
//! mean of the densities at y, weighted by p_k(y). MIS between light and BSDF sampling uses the same mean. A delta lobe
//! reflects each first vertex in another direction, so its light is not shared.

use turner_bvh::lanes::{Block, Block32, F64x8, LANES, Mask8, Simd, Vec3x8};

use super::terms::FirstVertices;
use super::{BLOCKS, SharedPaths};
use crate::bsdf::{BsdfBlock, MIN_COSINE, OpaqueBlock};
use crate::color::Spectrum;
use crate::integrator::path::path_batch::Path;
use crate::math::{DVec3, Frame};

/// A second vertex that is an opaque base.
pub(in crate::integrator::path) struct DirectionalVertex {
    base: OpaqueBlock,
    frame: Frame,
    /// The sampled light and the next direction.
    pub(super) light: Option<SecondLight>,
    pub(super) next: Option<SecondNext>,
    /// The BSDF in those directions.
    pub(super) towards_light: Towards,
    pub(super) towards_next: Towards,
    /// Throughput and importance of the path before it became a donor; see `take_back`.
    pub(super) beta: Spectrum,
    pub(super) importance: f32,
}

/// For each first vertex, the BRDF and the density of one direction.
#[derive(Clone, Default)]
pub(super) struct Towards {
    pub(super) f: [[Block32; 3]; BLOCKS],
    pub(super) pdf: [Block; BLOCKS],
}

/// The light that is sampled at a second vertex.
pub(in crate::integrator::path) struct SecondLight {
    pub(in crate::integrator::path) wi: DVec3,
    pub(in crate::integrator::path) radiance: Spectrum,
    /// Cosine over the density.
    pub(in crate::integrator::path) k: f64,
    /// Factor of diffuse reflection at the shadow terminator.
    pub(in crate::integrator::path) softening: f64,
    pub(in crate::integrator::path) pdf: f64,
    /// Whether rays can hit the light, too (MIS).
    pub(in crate::integrator::path) weighed: bool,
    /// Index of the shadow ray.
    pub(in crate::integrator::path) ray: usize,
}

/// The next direction at a second vertex.
pub(in crate::integrator::path) struct SecondNext {
    pub(in crate::integrator::path) wi: DVec3,
    /// Cosine.
    pub(in crate::integrator::path) k: f64,
    /// Factor of diffuse reflection at the shadow terminator.
    pub(in crate::integrator::path) softening: f64,
    /// Probability of surviving Russian roulette.
    pub(in crate::integrator::path) survival: f32,
}

/// The colour of a member of the cluster.
#[inline]
pub(super) fn color_at(f: &[[Block32; 3]; BLOCKS], member: usize) -> Spectrum {
    let [r, g, b] = &f[member / LANES];
    let lane = member % LANES;
    Spectrum::new(r.0[lane], g.0[lane], b.0[lane])
}

impl SharedPaths {
    /// Adds a vertex whose base is in this lane of the block; returns its number.
    pub(in crate::integrator::path) fn add_directional(
        &mut self,
        frame: Frame,
        path: &Path,
        (block, lane): (&OpaqueBlock, usize),
    ) -> u32 {
        if self.len == self.directional.len() {
            self.directional.push(DirectionalVertex {
                base: OpaqueBlock::default(),
                frame: Frame::from_z(DVec3::Z),
                light: None,
                next: None,
                towards_light: Towards::default(),
                towards_next: Towards::default(),
                beta: Spectrum::BLACK,
                importance: 1.0,
            });
        }
        let added = &mut self.directional[self.len];
        added.base.set_all(block, lane);
        (added.frame, added.light, added.next) = (frame, None, None);
        (added.beta, added.importance) = (path.beta, path.importance);
        self.len += 1;
        self.len as u32 - 1
    }

    /// The second vertex that a path is at, if its BSDF is not Lambertian.
    #[inline]
    pub(in crate::integrator::path) fn directional_at(
        &mut self,
        sample: u32,
    ) -> Option<&mut DirectionalVertex> {
        let number = *self.directional_of.get(sample as usize)?;
        self.directional.get_mut(number as usize)
    }
}

impl DirectionalVertex {
    /// The path continues by a delta lobe, so from here on it contributes to its own pixel only.
    pub(in crate::integrator::path) fn take_back(&mut self, path: &mut Path) {
        (path.beta, path.importance, path.donates) = (self.beta, self.importance, false);
    }

    /// Stores the sampled light.
    pub(in crate::integrator::path) fn set_light(&mut self, light: SecondLight) {
        self.light = Some(light);
    }

    /// Stores the next direction.
    pub(in crate::integrator::path) fn set_next(&mut self, next: SecondNext) {
        self.next = Some(next);
    }

    /// The BSDF towards a member of the cluster in both directions; black where there is none.
    #[inline]
    pub(super) fn in_both(&self, member: usize) -> [Spectrum; 2] {
        let of = |is: bool, to: &Towards| if is { color_at(&to.f, member) } else { Spectrum::BLACK };
        [of(self.light.is_some(), &self.towards_light), of(self.next.is_some(), &self.towards_next)]
    }

    /// Evaluates the BSDF for the first vertices of a cluster.
    #[inline(always)]
    pub(super) fn evaluate<S: Simd>(
        &mut self,
        simd: S,
        p: DVec3,
        first_vertices: &FirstVertices,
        blocks: usize,
    ) {
        let splat = |v: DVec3| Vec3x8::splat(simd, v.to_array());
        let (x, y, z) = (splat(self.frame.x), splat(self.frame.y), splat(self.frame.z));
        let least = F64x8::splat(simd, MIN_COSINE);
        for block in 0..blocks.min(BLOCKS) {
            let offset = first_vertices.position(simd, block) - splat(p);
            let length = offset.dot(offset).sqrt();
            let wo = Vec3x8 { x: offset.x / length, y: offset.y / length, z: offset.z / length };
            let wo = Vec3x8 { x: x.dot(wo), y: y.dot(wo), z: z.dot(wo) };
            let above = wo.z.gt(least) & Mask8::new(simd, first_vertices.used(block));
            let seen = BsdfBlock::towards(&self.base, simd, wo);
            let directions = [
                (self.light.as_ref().map(|light| (light.wi, light.softening)), &mut self.towards_light),
                (self.next.as_ref().map(|next| (next.wi, next.softening)), &mut self.towards_next),
            ];
            for (wi, to) in directions {
                let Some((wi, softening)) = wi else { continue };
                let softening = F64x8::splat(simd, softening);
                let (f, pdf) = BsdfBlock::eval_pdf(&self.base, simd, wo, &seen, splat(wi), softening);
                let none = turner_bvh::lanes::F32x8::splat(simd, 0.0);
                for (to, f) in to.f[block].iter_mut().zip(f) {
                    above.select32(f, none).store(to);
                }
                above.select(pdf, F64x8::splat(simd, 0.0)).store(&mut to.pdf[block]);
            }
        }
    }
}
