//! Which vertices are shaded in blocks.

use super::{List, VertexBlocks};
use crate::integrator::path::path_batch::PathBatch;
use crate::integrator::path::record::Record;
use crate::material::{BlockBsdf, Material, OpenPbr};
use crate::math::{DVec3, Ray};
use crate::scene::{Hit, Scene, SurfaceInteraction};

impl<'a, R: Record> PathBatch<'a, R> {
    /// The material at a hit, if the vertex may be shaded in a block.
    #[inline]
    pub(in crate::integrator::path) fn block_material(&self, sample: u32, hit: &Hit) -> Option<&'a OpenPbr> {
        // SIMD shading knows neither media nor photons.
        if R::RECORDS
            || self.lit_points.is_some()
            || self.settings.direct
            || self.scene.volumes.is_some()
            || self.finds_photons(sample)
        {
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

    #[inline]
    fn place<'b>(&self, sample: u32, ray: &'b Ray, hit: &'b Hit, material: &'b OpenPbr) -> Place<'b> {
        let curvature = if self.view.pixel_cone.is_some() { self.scene.curvature(hit) } else { 0.0 };
        Place { sample, ray, hit, material, curvature }
    }

    /// Adds a vertex to a block, if it is on a shape in world space with a constant material.
    #[inline]
    pub(in crate::integrator::path) fn take_plain(
        &mut self,
        number: usize,
        sample: u32,
        ray: &Ray,
        hit: &Hit,
        material: &OpenPbr,
    ) -> bool {
        let Some(bsdf) = material.plain().or_else(|| self.plain_outside(ray, hit, material)) else {
            return false;
        };
        if self.is_scalar(&bsdf) {
            return false;
        }
        // The densities of light paths at smooth normals are those of scalar code.
        let surface = Surface::InWorld { scene: self.scene, flat: self.strategy.is_some() };
        if !self.blocks.take(&bsdf, &self.place(sample, ray, hit, material), &surface) {
            return false;
        }
        self.blocks.in_block[number] = true;
        if self.view.pixel_cone.is_some() {
            let cone = &mut self.paths[sample as usize].cone;
            *cone = cone.advanced(hit.shape.t);
        }
        true
    }

    /// The BSDF of a shape hit on its outer side, where the other side has another one.
    #[inline]
    fn plain_outside<'b>(&self, ray: &Ray, hit: &Hit, material: &'b OpenPbr) -> Option<BlockBsdf<'b>> {
        // Light paths know only BSDFs of both sides.
        let bsdf = material.plain_outside().filter(|_| self.strategy.is_none())?;
        let ng = match self.scene.placed_triangle(hit) {
            Some(triangle) => triangle.normal(),
            None => self.scene.point_in_world(ray, hit)?.ng,
        };
        (ray.direction.dot(ng) < 0.0).then_some(bsdf)
    }

    /// Adds a vertex with its surface interaction to a block; false if its BSDF can only be evaluated by scalar code.
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
        let place = self.place(sample, ray, &surface.hit, material);
        let taken = self.blocks.take(&bsdf, &place, &Surface::Computed(surface, mapped));
        self.blocks.in_block[number] = taken;
        taken
    }
}

/// The path, the ray, the hit and the material of a vertex.
struct Place<'a> {
    sample: u32,
    ray: &'a Ray,
    hit: &'a Hit,
    material: &'a OpenPbr,
    /// Curvature of the surface, for the ray cone after reflection.
    curvature: f64,
}

/// How a surface gets into a block.
enum Surface<'a> {
    /// A shape in world space, if it is one; the block computes triangles. Perhaps only `flat` ones.
    InWorld { scene: &'a Scene, flat: bool },
    /// A surface interaction, and its shading normal after bump and normal map.
    Computed(&'a SurfaceInteraction, DVec3),
}

impl VertexBlocks {
    #[inline]
    fn take(&mut self, bsdf: &BlockBsdf<'_>, place: &Place<'_>, surface: &Surface<'_>) -> bool {
        match bsdf {
            BlockBsdf::Lambert(f) => self.lambert.take(place, surface, |kind, lane| kind.set(lane, *f)),
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
    fn take(&mut self, place: &Place<'_>, surface: &Surface<'_>, set: impl FnOnce(&mut K, usize)) -> bool {
        let (block, lane) = self.free();
        let direction = place.ray.direction;
        match *surface {
            Surface::InWorld { scene, flat } => {
                if !block.surfaces.take(scene, lane, place.hit, place.ray, flat) {
                    return false;
                }
            }
            Surface::Computed(surface, mapped) => block.surfaces.set(lane, surface, mapped, direction),
        }
        block.surfaces.set_softens(lane, place.material.desc.soften_terminator);
        set(&mut block.kind, lane);
        block.samples[lane] = place.sample;
        block.curvature.0[lane] = place.curvature;
        block.from[lane] = place.hit.origin();
        block.sides[lane] = place.material.side();
        self.len += 1;
        true
    }
}
