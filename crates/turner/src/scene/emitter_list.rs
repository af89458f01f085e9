//! Access to single emitters, to find out what each contributes, and where (`turner doctor`).

use crate::math::{Bounds, DVec3, Ray};
use crate::scene::alpha_test::NO_FACES;
use crate::scene::emitters::{Emitter, NONE};
use crate::scene::light_sample::LightSample;
use crate::scene::{Hit, Scene};
use crate::schema::MaterialId;
use crate::shape::Shape;

/// One emitter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ListedEmitter {
    /// A light, by its index in the prepared scene.
    Light(u32),
    /// A shape with an emissive material.
    Shape {
        /// The primitive's ID ([`Scene::primitive_id`]).
        primitive: u32,
        /// The emitter's index; a box has one for each of its six sides.
        emitter: u32,
    },
}

impl Scene {
    /// All emitters that can be sampled: lights, and with physical integrators emissive shapes. Shapes that are
    /// unbounded, move or have no area are found by BSDF sampling only, and are not listed.
    pub fn emitter_list(&self) -> Vec<ListedEmitter> {
        let lights = (0..self.lights.len() as u32).map(ListedEmitter::Light);
        let shapes = (0..).zip(self.emitters.all()).filter_map(|(emitter, e)| match e {
            Emitter::Light(_) => None,
            Emitter::Shape(shape) => {
                let primitive = self.primitives.get(shape.primitive() as usize)?.id;
                Some(ListedEmitter::Shape { primitive, emitter })
            }
        });
        lights.chain(shapes).collect()
    }

    /// Light of one emitter at `p`, from the point that `u` chooses: two numbers for the point and one for the part
    /// of the shape. The pdf is that of the point alone.
    pub fn sample_emitter(&self, emitter: ListedEmitter, p: DVec3, u: [f64; 3]) -> Option<LightSample> {
        match emitter {
            ListedEmitter::Light(i) => self.sample_light(i, p, 0.0, [u[0], u[1]]),
            ListedEmitter::Shape { emitter, .. } => match self.emitters.all().get(emitter as usize)? {
                Emitter::Shape(shape) => {
                    // With a light tree, parts are chosen by the tree.
                    let part = if shape.has_parts() && self.emitters.tree_bytes() > 0 {
                        let place = (u[2] * f64::from(shape.parts())) as u32;
                        shape.part_at(place.min(shape.parts().saturating_sub(1)))
                    } else {
                        NONE
                    };
                    shape.sample(self, p, u, part)
                }
                Emitter::Light(_) => None,
            },
        }
    }

    /// World-space bounds of an emissive shape or a light; `None` for lights at infinity.
    pub fn emitter_bounds(&self, emitter: ListedEmitter) -> Option<Bounds> {
        match emitter {
            ListedEmitter::Light(i) => {
                let light = self.lights.get(i as usize)?;
                if !light.is_finite() {
                    return None;
                }
                if let Some(position) = light.position() {
                    let reach = DVec3::splat(light.radius());
                    return Some(Bounds::new(position - reach, position + reach));
                }
                // For area lights, the bounds of points as seen from near the scene.
                let p = self.stats.bounds.map_or(DVec3::ZERO, |b| b.center());
                let places = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [0.5, 0.5]];
                let near = |d: DVec3, u| light.illuminate_at(p + d, u).map(|l| p + d + l.to_light);
                let offsets = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
                let size = self.stats.bounds.map_or(1.0, |b| b.size().length());
                let points = offsets.iter().flat_map(|d| places.map(|u| near(*d * size, u)));
                let bounds = Bounds::of(points.flatten());
                (!bounds.is_empty()).then_some(bounds)
            }
            ListedEmitter::Shape { primitive, .. } => self.primitive_bounds(primitive),
        }
    }

    /// World-space bounds of a primitive, by its ID; `None` for planes and unknown IDs.
    pub fn primitive_bounds(&self, primitive: u32) -> Option<Bounds> {
        let found = self.primitives.iter().find(|p| p.id == primitive)?;
        let bounds = found.shape.bounds()?;
        Some(match self.transforms.get(found.transform as usize) {
            Some(t) => bounds.transformed(&t.to_world),
            None => bounds,
        })
    }

    /// The shape of a primitive in a word, by its ID.
    pub fn primitive_shape(&self, primitive: u32) -> &'static str {
        self.primitives.iter().find(|p| p.id == primitive).map_or("object", |p| p.shape.word())
    }

    /// The ID and world-space bounds of each primitive except planes.
    pub fn all_bounds(&self) -> impl Iterator<Item = (u32, Bounds)> + '_ {
        self.primitives.iter().filter_map(|p| {
            let bounds = p.shape.bounds()?;
            let placed = self.transforms.get(p.transform as usize);
            Some((p.id, placed.map_or(bounds, |t| bounds.transformed(&t.to_world))))
        })
    }

    /// The ID and material of each primitive; for meshes with several materials, the default one.
    pub fn primitive_materials(&self) -> impl Iterator<Item = (u32, MaterialId)> + '_ {
        self.primitives.iter().map(|p| (p.id, p.material))
    }

    /// Primitives with a one-sided material whose back a ray crosses before its end. Skips large meshes (over 4096
    /// triangles), and one-sided primitives beyond the first 1024.
    pub fn backs_on(&self, ray: &Ray) -> Vec<(u32, &'static str)> {
        const MOST_PRIMITIVES: usize = 1024;
        const MOST_TRIANGLES: u32 = 4096;
        let mut out = Vec::new();
        let special = self.primitives.iter().filter(|p| p.faces != NO_FACES).take(MOST_PRIMITIVES);
        for p in special {
            if !self.faces.get(p.faces as usize).is_some_and(|f| f.are_only_one_sided()) {
                continue;
            }
            let own = self.to_object(p, ray);
            let back_hit = match &p.shape {
                Shape::Mesh(mesh) => {
                    let count = mesh.data().triangles.len() as u32;
                    count <= MOST_TRIANGLES
                        && (0..count).any(|i| mesh.triangle_corners(i).is_some_and(|c| is_back(c, &own)))
                }
                shape => shape
                    .intersect(&own)
                    .is_some_and(|hit| shape.surface(&own, &hit).ng.dot(own.direction) > 0.0),
            };
            if back_hit {
                out.push((p.id, p.shape.word()));
            }
        }
        out
    }

    /// The t at which a ray continues behind a hit.
    pub fn behind(&self, ray: &Ray, hit: &Hit) -> f64 {
        self.beyond(ray, hit, &self.surface(ray, hit))
    }
}

/// Whether a ray hits the back of a triangle, by Cramer's rule.
fn is_back([a, b, c]: [DVec3; 3], ray: &Ray) -> bool {
    let (u, v, from) = (b - a, c - a, ray.origin - a);
    let n = u.cross(v);
    let determinant = n.dot(ray.direction);
    if determinant <= 0.0 {
        return false;
    }
    let w = from.cross(ray.direction);
    let (s, t) = (-v.dot(w) / determinant, u.dot(w) / determinant);
    let distance = -from.dot(n) / determinant;
    s >= 0.0 && t >= 0.0 && s + t <= 1.0 && ray.contains(distance)
}
