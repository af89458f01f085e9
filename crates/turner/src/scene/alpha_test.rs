//! Primitives that are not one opaque thing: with cut-outs, or with a material for each part of a mesh.
//!
//! A cut-out is decided while a ray is traced: hits where there is nothing do not count, for any kind of ray, and the
//! search goes on behind them.

use std::cell::Cell;

use crate::material::{Cutout, Material, MaterialDesc, ShadowKind};
use crate::math::Ray;
use crate::scene::Scene;
use crate::scene::scene::{NO_TRANSFORM, Primitive};
use crate::schema::MaterialId;
use crate::shape::{Shape, ShapeHit};
use crate::texture::TexturePoint;

/// In place of an index into the scene's faces.
pub(crate) const NO_FACES: u32 = u32::MAX;

/// The hits of an analytic shape are gone through one by one: none has more.
const MAX_HITS: u32 = 16;

/// A material with the opacity it takes to count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FaceMaterial {
    pub(crate) material: MaterialId,
    cutout: Option<Cutout>,
}

/// The materials of a primitive, by the number that its triangles have.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Faces {
    materials: Vec<FaceMaterial>,
    /// Whether any of them has holes.
    masked: bool,
    /// Whether any of them is seen from one side only.
    one_sided: bool,
}

impl Faces {
    /// `None` if there is nothing special about them. `descs` are the scene's; the default material stands behind them.
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

    /// Whether a hit may be none.
    pub(crate) fn are_checked(&self) -> bool {
        self.masked || self.one_sided
    }

    /// Whether all that is special is that there is no back.
    pub(crate) fn are_only_one_sided(&self) -> bool {
        !self.masked && self.one_sided && self.materials.len() == 1
    }

    /// Whether all of them cast a full shadow everywhere.
    pub(crate) fn are_opaque(&self, materials: &[Material]) -> bool {
        let opaque = |m: &FaceMaterial| materials[m.material.index()].shadow() == ShadowKind::Opaque;
        !self.masked && !self.one_sided && self.materials.iter().all(opaque)
    }

    fn of(&self, shape: &Shape, hit: &ShapeHit) -> Option<&FaceMaterial> {
        let number = match shape {
            Shape::Mesh(mesh) => mesh.face_material(hit.part),
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

    /// Whether there is anything at a hit; `ray` is in the object's space. A surface with one side is not there for rays that meet its
    /// back, of whatever kind: so all ways of finding light agree.
    pub(crate) fn is_there(&self, primitive: &Primitive, ray: &Ray, hit: &ShapeHit) -> bool {
        let face = self.faces[primitive.faces as usize].of(&primitive.shape, hit);
        let Some(cutout) = face.and_then(|face| face.cutout) else { return true };
        let surface = primitive.shape.surface(ray, hit);
        if cutout.one_sided && surface.ng.dot(ray.direction) > 0.0 {
            return false;
        }
        let Some((opacity, cutoff)) = cutout.mask else { return true };
        self.textures.opacity(opacity, &TexturePoint::of_shape(&primitive.shape, hit, &surface)) >= cutoff
    }

    /// What `intersect_primitive` does, for primitives with faces.
    pub(crate) fn intersect_faces(&self, primitive: &Primitive, ray: &Ray) -> Option<ShapeHit> {
        let ray = self.to_object(primitive, ray);
        let faces = &self.faces[primitive.faces as usize];
        if !faces.masked {
            // Backs are rarely the first thing that a ray meets.
            let hit = primitive.shape.intersect(&ray)?;
            if !faces.one_sided || self.is_there(primitive, &ray, &hit) {
                return Some(hit);
            }
        }
        match &primitive.shape {
            Shape::Mesh(mesh) => mesh.intersect_where(&ray, &|hit| self.is_there(primitive, &ray, hit)),
            shape => each_hit(shape, &ray, |hit| self.is_there(primitive, &ray, hit)),
        }
    }

    /// What `primitive_blocks` does, for primitives with faces.
    pub(crate) fn faces_block(&self, primitive: &Primitive, ray: &Ray, tinted: &Cell<bool>) -> bool {
        let ray = self.to_object(primitive, ray);
        let blocks = |hit: &ShapeHit| {
            self.is_there(primitive, &ray, hit)
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
