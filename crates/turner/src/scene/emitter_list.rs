//! What shines in a scene, one thing after the other: to find out what each brings where.

use crate::math::{Bounds, DVec3, Ray};
use crate::scene::alpha_test::NO_FACES;
use crate::scene::emitters::{Emitter, LightSample, NONE};
use crate::scene::{Hit, Scene};
use crate::schema::MaterialId;
use crate::shape::Shape;

/// One thing that shines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ListedEmitter {
    /// A light, by its number among the prepared scene's.
    Light(u32),
    /// A shape with an emissive material, by its number in the description ([`Scene::primitive_id`]), and its emitter's number.
    Shape {
        /// The primitive's number in the description.
        primitive: u32,
        /// The emitter's number: the faces of a box are six.
        emitter: u32,
    },
}

impl Scene {
    /// All that can be asked for light: lights, and with integrators that follow light the shapes that shine. What has no end, moves or
    /// has no area is only found by chance, and is not among them.
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

    /// Light of one of them at `p`, from the place on it that `u` chooses: two numbers for the place and one for its part. The density is that
    /// of the place alone.
    pub fn sample_emitter(&self, one: ListedEmitter, p: DVec3, u: [f64; 3]) -> Option<LightSample> {
        match one {
            ListedEmitter::Light(i) => self.lights.get(i as usize)?.sample(p, [u[0], u[1]], i),
            ListedEmitter::Shape { emitter, .. } => match self.emitters.all().get(emitter as usize)? {
                Emitter::Shape(shape) => {
                    // In a tree of lights parts are chosen there.
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

    /// The bounds of a shape that shines, in the world; of a light without extent the point itself. `None` for what is infinitely far away.
    pub fn emitter_bounds(&self, one: ListedEmitter) -> Option<Bounds> {
        match one {
            ListedEmitter::Light(i) => {
                let light = self.lights.get(i as usize)?;
                if !light.is_finite() {
                    return None;
                }
                if let Some(position) = light.position() {
                    return Some(Bounds::new(position, position));
                }
                // Of lights made of points, where these are as seen from somewhere near.
                let p = self.stats.bounds.map_or(DVec3::ZERO, |b| b.center());
                let places = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [0.5, 0.5]];
                let near = |d: DVec3, u| light.illuminate_at(p + d, u).map(|l| p + d + l.to_light);
                let around = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
                let size = self.stats.bounds.map_or(1.0, |b| b.size().length());
                let points = around.iter().flat_map(|d| places.map(|u| near(*d * size, u)));
                let bounds = Bounds::of(points.flatten());
                (!bounds.is_empty()).then_some(bounds)
            }
            ListedEmitter::Shape { primitive, .. } => self.primitive_bounds(primitive),
        }
    }

    /// The bounds of a primitive in the world, by its number in the description; `None` for planes and numbers that do not exist.
    pub fn primitive_bounds(&self, primitive: u32) -> Option<Bounds> {
        let found = self.primitives.iter().find(|p| p.id == primitive)?;
        let bounds = found.shape.bounds()?;
        Some(match self.transforms.get(found.transform as usize) {
            Some(t) => bounds.transformed(&t.to_world),
            None => bounds,
        })
    }

    /// The shape of a primitive in a word, by its number in the description.
    pub fn primitive_shape(&self, primitive: u32) -> &'static str {
        self.primitives.iter().find(|p| p.id == primitive).map_or("object", |p| p.shape.word())
    }

    /// For each primitive its number in the description and its bounds in the world; planes are left out.
    pub fn all_bounds(&self) -> impl Iterator<Item = (u32, Bounds)> + '_ {
        self.primitives.iter().filter_map(|p| {
            let bounds = p.shape.bounds()?;
            let placed = self.transforms.get(p.transform as usize);
            Some((p.id, placed.map_or(bounds, |t| bounds.transformed(&t.to_world))))
        })
    }

    /// For each primitive its number in the description and its material; of meshes with several, that of the rest.
    pub fn primitive_materials(&self) -> impl Iterator<Item = (u32, MaterialId)> + '_ {
        self.primitives.iter().map(|p| (p.id, p.material))
    }

    /// Primitives of one-sided materials whose back a ray passes up to its end. Large meshes (over 4096 triangles) and scenes of very many
    /// one-sided primitives are left out.
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
            let met = match &p.shape {
                Shape::Mesh(mesh) => {
                    let count = mesh.data().triangles.len() as u32;
                    count <= MOST_TRIANGLES
                        && (0..count).any(|i| mesh.triangle_corners(i).is_some_and(|c| is_back(c, &own)))
                }
                shape => shape
                    .intersect(&own)
                    .is_some_and(|hit| shape.surface(&own, &hit).ng.dot(own.direction) > 0.0),
            };
            if met {
                out.push((p.id, p.shape.word()));
            }
        }
        out
    }

    /// Where a ray goes on behind a hit, as its smallest `t`.
    pub fn behind(&self, ray: &Ray, hit: &Hit) -> f64 {
        self.beyond(ray, hit, &self.surface(ray, hit))
    }
}

/// Whether a ray meets the back of a triangle, by Cramer's rule.
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
