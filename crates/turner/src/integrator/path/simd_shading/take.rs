//! Which vertices are shaded in blocks.

use super::{LANES, List, VertexBlocks};
use crate::integrator::footprint;
use crate::integrator::path::path_batch::PathBatch;
use crate::integrator::path::record::Record;
use crate::material::{BlockBsdf, Material, OpenPbr};
use crate::math::Ray;
use crate::scene::{Hit, Scene, SurfaceInteraction};

impl<'a, R: Record> PathBatch<'a, R> {
    /// The material at a hit, if the vertex may be shaded in a block.
    #[inline]
    pub(in crate::integrator::path) fn block_material(&self, sample: u32, hit: &Hit) -> Option<&'a OpenPbr> {
        // SIMD shading knows neither media nor photons.
        if R::RECORDS || self.settings.direct || self.scene.volumes.is_some() || self.finds_photons(sample) {
            return None;
        }
        let Material::OpenPbr(material) = self.scene.material_at(hit) else { return None };
        // With light paths, caustic targets need MIS weights that only scalar code computes.
        if !material.is_opaque_base || self.strategy.is_some() && material.casts_caustics {
            return None;
        }
        let path = &self.paths[sample as usize];
        let is_catcher = path.from_camera && self.scene.is_shadow_catcher(hit);
        (path.media.is_empty() && !is_catcher).then_some(material)
    }

    /// Whether the light of this BSDF is told apart only by scalar code, or its light paths are.
    fn is_scalar(&self, bsdf: &BlockBsdf<'_>) -> bool {
        matches!(bsdf, BlockBsdf::Opaque(_)) && (self.strategy.is_some() || self.lobes.is_on())
    }

    /// Adds a vertex to a block, if it is on a flat triangle with a constant material.
    #[inline]
    pub(in crate::integrator::path) fn take_flat(
        &mut self,
        number: usize,
        sample: u32,
        ray: &Ray,
        hit: &Hit,
        material: &OpenPbr,
    ) -> bool {
        let Some(bsdf) = material.plain().filter(|bsdf| !self.is_scalar(bsdf)) else { return false };
        if !self.blocks.take(&bsdf, &Place { sample, hit, material }, Flat { scene: self.scene, ray }) {
            return false;
        }
        self.blocks.in_block[number] = true;
        if self.view.pixel_cone.is_some() {
            let cone = &mut self.paths[sample as usize].cone;
            *cone = cone.advanced(hit.shape.t);
        }
        true
    }

    /// Adds a vertex whose surface is computed to a block, unless its BSDF is none of those in blocks.
    pub(in crate::integrator::path) fn take_surface(
        &mut self,
        number: usize,
        sample: u32,
        ray: &Ray,
        surface: &SurfaceInteraction,
        material: &OpenPbr,
    ) -> bool {
        if self.strategy.is_some() {
            return false;
        }
        let outside = ray.direction.dot(surface.ng) < 0.0;
        let mut made = None;
        let bsdf = material.block_bsdf(self.scene, surface, outside, &mut made);
        let Some(bsdf) = bsdf.filter(|bsdf| !self.is_scalar(bsdf)) else { return false };
        let has_maps = material.desc.bump().is_some() || material.desc.normal_map.is_some();
        let mapped = if has_maps { material.frame(self.scene, surface).z } else { surface.ns };
        let curvature = match self.view.pixel_cone {
            Some(_) => footprint::curvature(self.scene, surface, -ray.direction),
            None => 0.0,
        };
        let place = Place { sample, hit: &surface.hit, material };
        let taken = self.blocks.take(&bsdf, &place, Computed { surface, ray, mapped, curvature });
        self.blocks.in_block[number] = taken;
        taken
    }
}

/// What a block knows of a vertex beside its surface and BSDF.
struct Place<'a> {
    sample: u32,
    hit: &'a Hit,
    material: &'a OpenPbr,
}

/// How a surface gets into a block.
trait Store {
    /// Stores it in a lane; returns whether that is possible.
    fn store<K>(&self, block: &mut super::VertexBlock<K>, lane: usize, hit: &Hit) -> bool;
}

/// A flat triangle, which the block computes.
struct Flat<'a> {
    scene: &'a Scene,
    ray: &'a Ray,
}

impl Store for Flat<'_> {
    #[inline]
    fn store<K>(&self, block: &mut super::VertexBlock<K>, lane: usize, hit: &Hit) -> bool {
        block.curvature.0[lane] = 0.0;
        block.surfaces.take(self.scene, lane, hit, self.ray.direction)
    }
}

struct Computed<'a> {
    surface: &'a SurfaceInteraction,
    ray: &'a Ray,
    mapped: crate::math::DVec3,
    curvature: f64,
}

impl Store for Computed<'_> {
    #[inline]
    fn store<K>(&self, block: &mut super::VertexBlock<K>, lane: usize, _: &Hit) -> bool {
        block.curvature.0[lane] = self.curvature;
        block.surfaces.set(lane, self.surface, self.mapped, self.ray.direction);
        true
    }
}

impl VertexBlocks {
    #[inline]
    fn take(&mut self, bsdf: &BlockBsdf<'_>, place: &Place<'_>, surface: impl Store) -> bool {
        match bsdf {
            BlockBsdf::Lambert(f) => {
                self.lambert.take(place, surface, |kind, lane| super::set32(&mut kind.f, lane, *f))
            }
            BlockBsdf::Opaque(base) if base.is_metal() => {
                self.metals.take(place, surface, |kind, lane| kind.set(lane, base))
            }
            BlockBsdf::Opaque(base) => {
                self.dielectrics.take(place, surface, |kind, lane| kind.set(lane, base))
            }
        }
    }
}

impl<K: Default> List<K> {
    #[inline]
    fn take(&mut self, place: &Place<'_>, surface: impl Store, set: impl FnOnce(&mut K, usize)) -> bool {
        let (block, lane) = self.free();
        debug_assert!(lane < LANES);
        if !surface.store(block, lane, place.hit) {
            return false;
        }
        set(&mut block.kind, lane);
        block.samples[lane] = place.sample;
        block.from[lane] = place.hit.origin();
        block.sides[lane] = place.material.side();
        self.len += 1;
        true
    }
}
