//! Turner's tree over a generated scene. This file alone knows by which calls it is built and asked.

use std::ops::Range;

use turner_bvh::generate::{Mesh, Scene};
use turner_bvh::{Aabb, Bvh2, Bvh2Options, Bvh4, Ray};

use super::measure::{CHUNK, Query, RaySet, Tracer};

/// The nearest hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Hit {
    /// Infinite on a miss.
    pub(super) t: f32,
    /// `u32::MAX` on a miss.
    pub(super) primitive: u32,
    /// `u32::MAX` in a scene without instances.
    pub(super) instance: u32,
}

impl Hit {
    const MISS: Hit = Hit { t: f32::INFINITY, primitive: u32::MAX, instance: u32::MAX };
}

/// How well a tree is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Quality {
    /// Soonest ready.
    Fast,
    /// For most scenes.
    Balanced,
    /// Fastest to trace.
    High,
}

impl Quality {
    pub(super) fn name(self) -> &'static str {
        match self {
            Quality::Fast => "fast",
            Quality::Balanced => "balanced",
            Quality::High => "high",
        }
    }

    fn options(self, threads: usize) -> Bvh2Options {
        let bins = match self {
            Quality::Fast => 8,
            Quality::Balanced => 16,
            Quality::High => 32,
        };
        Bvh2Options { threads, bins, ..Bvh2Options::default() }
    }
}

/// A built scene.
pub(super) struct Turner {
    parts: Vec<Part>,
    top: Option<Top>,
}

/// The tree of a mesh: triangles in the order of its leaves, as a vertex and two edges.
struct Part {
    tree: Bvh4,
    triangles: Vec<[[f32; 3]; 3]>,
}

/// The tree of instances, and the way from the world to each.
struct Top {
    tree: Bvh4,
    inverses: Vec<(u32, [[f32; 4]; 3])>,
}

impl Turner {
    /// Builds all trees of a scene.
    pub(super) fn build(scene: &Scene, quality: Quality, threads: usize) -> Result<Turner, String> {
        let options = quality.options(threads);
        let parts: Vec<Part> =
            scene.meshes.iter().map(|mesh| Part::build(mesh, &options)).collect::<Result<_, _>>()?;
        let top = match scene.instances.as_slice() {
            [] => None,
            instances => {
                let own: Vec<Aabb> = scene.meshes.iter().map(Mesh::bounds).collect();
                let boxes: Vec<Aabb> = instances.iter().map(|i| i.bounds(own[i.mesh as usize])).collect();
                let tree = tree(&boxes, &options)?;
                let inverses = tree.order().iter().map(|&i| {
                    let instance = &instances[i as usize];
                    (instance.mesh, inverse(&instance.transform))
                });
                Some(Top { inverses: inverses.collect(), tree })
            }
        };
        Ok(Turner { parts, top })
    }

    /// Bytes of memory.
    pub(super) fn bytes(&self) -> usize {
        let part = |p: &Part| p.tree.bytes() + size_of_val(p.triangles.as_slice());
        let top = self.top.as_ref().map_or(0, |t| t.tree.bytes() + size_of_val(t.inverses.as_slice()));
        self.parts.iter().map(part).sum::<usize>() + top
    }

    #[inline]
    fn intersect(&self, ray: &Ray) -> Hit {
        let mut hit = Hit { t: ray.t_max, ..Hit::MISS };
        match &self.top {
            None => self.parts[0].nearest(ray, &mut hit, u32::MAX),
            Some(top) => {
                top.tree.closest(ray, |positions, t_max| {
                    hit.t = t_max;
                    for position in positions {
                        let (part, inverse) = &top.inverses[position as usize];
                        let inner = into(inverse, ray, hit.t);
                        self.parts[*part as usize].nearest(
                            &inner,
                            &mut hit,
                            top.tree.order()[position as usize],
                        );
                    }
                    hit.t
                });
            }
        }
        if hit.primitive == u32::MAX { Hit::MISS } else { hit }
    }

    #[inline]
    fn occluded(&self, ray: &Ray) -> bool {
        match &self.top {
            None => self.parts[0].any(ray),
            Some(top) => top.tree.any(ray, |mut positions| {
                positions.any(|position| {
                    let (part, inverse) = &top.inverses[position as usize];
                    self.parts[*part as usize].any(&into(inverse, ray, ray.t_max))
                })
            }),
        }
    }
}

impl Part {
    fn build(mesh: &Mesh, options: &Bvh2Options) -> Result<Part, String> {
        let corners = |i: usize| mesh.triangle(i);
        let boxes: Vec<Aabb> =
            (0..mesh.triangles.len()).map(|i| corners(i).into_iter().fold(Aabb::EMPTY, Aabb::grow)).collect();
        let tree = tree(&boxes, options)?;
        let triangles = tree.order().iter().map(|&i| {
            let [a, b, c] = corners(i as usize);
            [a, sub(b, a), sub(c, a)]
        });
        Ok(Part { triangles: triangles.collect(), tree })
    }

    #[inline]
    fn nearest(&self, ray: &Ray, hit: &mut Hit, instance: u32) {
        self.tree.closest(ray, |positions, mut t_max| {
            for position in positions {
                if let Some(t) = meet(ray, &self.triangles[position as usize], t_max) {
                    t_max = t;
                    *hit = Hit { t, primitive: self.tree.order()[position as usize], instance };
                }
            }
            t_max
        });
    }

    #[inline]
    fn any(&self, ray: &Ray) -> bool {
        self.tree.any(ray, |mut positions| {
            positions.any(|i| meet(ray, &self.triangles[i as usize], ray.t_max).is_some())
        })
    }
}

fn tree(boxes: &[Aabb], options: &Bvh2Options) -> Result<Bvh4, String> {
    Bvh2::build(boxes, options).map(|tree| Bvh4::collapse(&tree)).map_err(|e| e.to_string())
}

/// Where a ray meets a triangle, by Möller and Trumbore's method.
#[inline]
fn meet(ray: &Ray, &[a, e, f]: &[[f32; 3]; 3], t_max: f32) -> Option<f32> {
    let p = cross(ray.direction, f);
    let determinant = dot(e, p);
    let inverse = 1.0 / determinant;
    let s = sub(ray.origin, a);
    let u = dot(s, p) * inverse;
    let q = cross(s, e);
    let v = dot(ray.direction, q) * inverse;
    let t = dot(f, q) * inverse;
    // False for NaN, as it is for triangles seen edge on.
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= ray.t_min && t <= t_max).then_some(t)
}

/// The ray as seen by an instance: `t` stays what it is.
#[inline]
fn into(matrix: &[[f32; 4]; 3], ray: &Ray, t_max: f32) -> Ray {
    let linear = |row: &[f32; 4], v: [f32; 3]| row[0] * v[0] + row[1] * v[1] + row[2] * v[2];
    Ray {
        origin: std::array::from_fn(|i| linear(&matrix[i], ray.origin) + matrix[i][3]),
        direction: std::array::from_fn(|i| linear(&matrix[i], ray.direction)),
        t_max,
        ..*ray
    }
}

fn inverse(m: &[[f32; 4]; 3]) -> [[f32; 4]; 3] {
    let column = |j: usize| [m[0][j], m[1][j], m[2][j]];
    let (x, y, z, w) = (column(0), column(1), column(2), column(3));
    let scale = 1.0 / dot(x, cross(y, z));
    [cross(y, z), cross(z, x), cross(x, y)].map(|row| {
        let row = row.map(|a| a * scale);
        [row[0], row[1], row[2], -dot(row, w)]
    })
}

fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

impl Tracer for Turner {
    fn nearest(&self, query: Query, set: &RaySet, range: Range<usize>, hits: &mut [Hit; CHUNK]) {
        let rays = &set.rays[range];
        match query {
            Query::One | Query::Batch | Query::Coherent => {
                for (ray, hit) in rays.iter().zip(hits) {
                    *hit = self.intersect(ray);
                }
            }
        }
    }

    fn any(&self, query: Query, set: &RaySet, range: Range<usize>, occluded: &mut [bool; CHUNK]) {
        let rays = &set.rays[range];
        match query {
            Query::One | Query::Batch | Query::Coherent => {
                for (ray, occluded) in rays.iter().zip(occluded) {
                    *occluded = self.occluded(ray);
                }
            }
        }
    }
}
