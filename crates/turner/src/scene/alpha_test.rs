//! Alpha test, one-sided surfaces, and several materials per mesh: primitives whose hits may be rejected.
//!
//! A cut-out material has an opacity texture and a cutoff: where opacity < cutoff, the surface is transparent (glTF's
//! `alphaMode = "MASK"`). The decision is made during intersection. A rejected hit is ignored by rays of every type,
//! and the search continues behind it:
//!
//! ```text
//!    ray -----x--------x--------o------>      x: alpha test or facing test fails, hit ignored
//!           leaf     back      leaf           o: hit accepted
//! ```
//!
//! Since camera rays, BSDF-sampled rays and shadow rays all use this test, all light-sampling strategies see the same
//! surface. The test is exact, not stochastic, so it adds no noise. Batches search without the test first and repeat
//! the search with it only for rays whose nearest hit fails: the first hit nearly always passes.

use std::cell::Cell;

use crate::material::{Cutout, Material, MaterialDesc, ShadowKind};
use crate::math::Ray;
use crate::scene::Scene;
use crate::scene::scene::{NO_TRANSFORM, Primitive};
use crate::schema::MaterialId;
use crate::shape::{Shape, ShapeHit, SolidGeometry};
use crate::texture::TexturePoint;

/// No index into the scene's faces.
pub(crate) const NO_FACES: u32 = u32::MAX;

/// Hits of an analytic shape are tried one by one; no shape has more.
const MAX_HITS: u32 = 16;

/// A material with its alpha test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FaceMaterial {
    pub(crate) material: MaterialId,
    cutout: Option<Cutout>,
}

/// The materials of a primitive; triangles select one by index.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Faces {
    materials: Vec<FaceMaterial>,
    /// Whether any of them has an opacity mask.
    masked: bool,
    /// Whether any of them is one-sided.
    one_sided: bool,
}

impl Faces {
    /// `None` if no hit can be rejected and there is one material. `descs` are the scene's materials; the default
    /// material comes after them.
    pub(crate) fn new(
        materials: Vec<MaterialId>,
        descs: &[crate::schema::Named<MaterialDesc>],
        physical: bool,
    ) -> Option<Faces> {
        let cutout = |m: MaterialId| descs.get(m.index()).and_then(|m| m.value.cutout(physical));
        let materials: Vec<FaceMaterial> = materials
            .into_iter()
            .map(|material| FaceMaterial { material, cutout: cutout(material) })
            .collect();
        let masked = materials.iter().any(|m| m.cutout.is_some_and(|c| c.mask.is_some()));
        let one_sided = materials.iter().any(|m| m.cutout.is_some_and(|c| c.one_sided));
        let special = masked || one_sided || materials.len() > 1;
        special.then_some(Faces { materials, masked, one_sided })
    }

    /// Whether hits may be rejected.
    pub(crate) fn need_test(&self) -> bool {
        self.masked || self.one_sided
    }

    /// Whether the only special property is one-sidedness.
    pub(crate) fn are_only_one_sided(&self) -> bool {
        !self.masked && self.one_sided && self.materials.len() == 1
    }

    /// Whether all materials cast an opaque shadow everywhere.
    pub(crate) fn are_opaque(&self, materials: &[Material]) -> bool {
        let opaque = |m: &FaceMaterial| materials[m.material.index()].shadow() == ShadowKind::Opaque;
        !self.masked && !self.one_sided && self.materials.iter().all(opaque)
    }

    fn of(&self, shape: &Shape, hit: &ShapeHit) -> Option<&FaceMaterial> {
        let number = match shape {
            Shape::Mesh(mesh) => mesh.face_material(hit.part),
            Shape::Solid(solid) => solid.material_slot(hit),
            _ => 0,
        };
        self.materials.get(number).or(self.materials.last())
    }
}

impl Scene {
    /// The materials of all faces.
    pub(crate) fn face_materials(&self) -> impl Iterator<Item = MaterialId> + '_ {
        self.faces.iter().flat_map(|f| f.materials.iter().map(|m| m.material))
    }

    /// The material at a hit of a primitive.
    #[inline(always)]
    pub(crate) fn material_of(&self, primitive: &Primitive, hit: &ShapeHit) -> MaterialId {
        if primitive.faces == NO_FACES { primitive.material } else { self.face_material(primitive, hit) }
    }

    fn face_material(&self, primitive: &Primitive, hit: &ShapeHit) -> MaterialId {
        let face = self.faces[primitive.faces as usize].of(&primitive.shape, hit);
        face.map_or(primitive.material, |face| face.material)
    }

    /// Whether a hit is accepted; `ray` is in object space. One-sided surfaces are invisible from their back to rays
    /// of every type, so that all light-sampling strategies agree.
    pub(crate) fn accepts_hit(&self, primitive: &Primitive, ray: &Ray, hit: &ShapeHit) -> bool {
        let face = self.faces[primitive.faces as usize].of(&primitive.shape, hit);
        let Some(cutout) = face.and_then(|face| face.cutout) else { return true };
        let surface = primitive.shape.surface(ray, hit);
        if cutout.one_sided && surface.ng.dot(ray.direction) > 0.0 {
            return false;
        }
        let Some((opacity, cutoff)) = cutout.mask else { return true };
        self.textures.opacity(opacity, &TexturePoint::of_shape(&primitive.shape, hit, &surface)) >= cutoff
    }

    /// `intersect_primitive` for primitives with faces.
    pub(crate) fn intersect_faces(&self, primitive: &Primitive, ray: &Ray) -> Option<ShapeHit> {
        let ray = self.to_object(primitive, ray);
        let faces = &self.faces[primitive.faces as usize];
        if !faces.masked {
            // The first hit is rarely a back face.
            let hit = primitive.shape.intersect(&ray)?;
            if !faces.one_sided || self.accepts_hit(primitive, &ray, &hit) {
                return Some(hit);
            }
        }
        match &primitive.shape {
            Shape::Mesh(mesh) => mesh.intersect_where(&ray, &|hit| self.accepts_hit(primitive, &ray, hit)),
            Shape::Curves(curves) => {
                curves.intersect_where(&ray, &|hit| self.accepts_hit(primitive, &ray, hit))
            }
            shape => each_hit(shape, &ray, |hit| self.accepts_hit(primitive, &ray, hit)),
        }
    }

    /// `primitive_blocks` for primitives with faces.
    pub(crate) fn faces_block(&self, primitive: &Primitive, ray: &Ray, tinted: &Cell<bool>) -> bool {
        let ray = self.to_object(primitive, ray);
        let blocks = |hit: &ShapeHit| {
            self.accepts_hit(primitive, &ray, hit)
                && match self.materials[self.face_material(primitive, hit).index()].shadow() {
                    ShadowKind::Opaque => true,
                    ShadowKind::None => false,
                    ShadowKind::Tinted => {
                        tinted.set(true);
                        false
                    }
                }
        };
        match &primitive.shape {
            Shape::Mesh(mesh) => mesh.occludes_where(&ray, &blocks),
            Shape::Points(points) => points.occludes_where(&ray, &blocks),
            Shape::Curves(curves) => curves.occludes_where(&ray, &blocks),
            shape => each_hit(shape, &ray, blocks).is_some(),
        }
    }

    pub(crate) fn to_object(&self, primitive: &Primitive, ray: &Ray) -> Ray {
        match primitive.transform {
            NO_TRANSFORM => *ray,
            i => self.transforms[i as usize].ray_to_object(ray),
        }
    }
}

/// The nearest hit of a shape that `accept` takes.
fn each_hit(shape: &Shape, ray: &Ray, accept: impl Fn(&ShapeHit) -> bool) -> Option<ShapeHit> {
    let mut ray = *ray;
    for _ in 0..MAX_HITS {
        let hit = shape.intersect(&ray)?;
        if accept(&hit) {
            return Some(hit);
        }
        ray.t_min = hit.t.next_up();
    }
    None
}
