//! Instances: a two-level BVH. The top level holds boxes; rays are transformed into the mesh in each leaf, as in the
//! renderer.

use std::ops::Range;

use turner_bvh::generate::{Instance, Scene};
use turner_bvh::{Aabb, BoxBvh, BuildOptions, Bvh, Ray};

use super::measure::{CHUNK, Query};
use super::tracer::Hit;

/// Boxes are enlarged by this fraction of the scene's extent, which exceeds the rounding error of transformed rays.
const PADDING: f32 = 1e-6;

/// A two-level BVH.
pub(super) struct Instances {
    top: BoxBvh,
    /// In leaf order of the top level.
    placed: Vec<Placed>,
    meshes: Vec<Bvh>,
}

/// An instance.
struct Placed {
    /// World-to-object transform: the rows of a 3x4 matrix.
    inverse: [[f32; 4]; 3],
    mesh: u32,
    /// Index among the scene's instances.
    number: u32,
}

impl Placed {
    fn new(instance: &Instance, number: u32) -> Result<Placed, String> {
        let inverse = inverse(&instance.transform).ok_or("an instance without volume")?;
        Ok(Placed { inverse, mesh: instance.mesh, number })
    }

    /// The ray in object space, up to `t_max`; t is unchanged.
    #[inline(always)]
    fn moved(&self, ray: &Ray, t_max: f32) -> Ray {
        let ([x, y, z], [u, v, w]) = (ray.origin, ray.direction);
        Ray {
            origin: self.inverse.map(|[a, b, c, d]| a * x + b * y + c * z + d),
            direction: self.inverse.map(|[a, b, c, _]| a * u + b * v + c * w),
            t_max,
            ..*ray
        }
    }
}

/// The inverse of an affine transform, if it exists.
fn inverse(rows: &[[f32; 4]; 3]) -> Option<[[f32; 4]; 3]> {
    let [a, b, c] = rows.map(|row| row.map(f64::from));
    let cross = |p: [f64; 4], q: [f64; 4]| {
        [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
    };
    // The columns of the inverse.
    let columns = [cross(b, c), cross(c, a), cross(a, b)];
    let determinant = a[0] * columns[0][0] + a[1] * columns[0][1] + a[2] * columns[0][2];
    let offset = [a[3], b[3], c[3]];
    let inverse = [0, 1, 2].map(|row| {
        let [x, y, z] = columns.map(|column| column[row] / determinant);
        [x, y, z, -(x * offset[0] + y * offset[1] + z * offset[2])].map(|v| v as f32)
    });
    inverse.iter().flatten().all(|v| v.is_finite()).then_some(inverse)
}

impl Instances {
    /// Places meshes whose BVHs are built.
    pub(super) fn build(
        scene: &Scene,
        meshes: Vec<Bvh>,
        options: &BuildOptions<'_>,
    ) -> Result<Instances, String> {
        let of_meshes: Vec<Aabb> = scene.meshes.iter().map(|mesh| mesh.bounds()).collect();
        let pad = PADDING * scene.extent();
        let boxes: Vec<Aabb> = scene
            .instances
            .iter()
            .map(|i| i.bounds(of_meshes[i.mesh as usize]))
            .map(|b| Aabb::new(b.min.map(|x| x - pad), b.max.map(|x| x + pad)))
            .collect();
        let top = BoxBvh::build(&boxes, options).map_err(|e| e.to_string())?;
        let in_order = top.order().iter().map(|&i| Placed::new(&scene.instances[i as usize], i));
        Ok(Instances { placed: in_order.collect::<Result<_, _>>()?, top, meshes })
    }

    /// Memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let meshes: usize = self.meshes.iter().map(|mesh| mesh.stats().bytes).sum();
        self.top.bytes() + size_of_val(&self.placed[..]) + meshes
    }

    /// The nearest hits of at most [`CHUNK`] rays; among equally near ones, the lowest instance.
    pub(super) fn nearest(&self, query: Query, rays: &[Ray], hits: &mut [Hit; CHUNK]) {
        let mut visit = |i: usize, range: Range<u32>, mut t_max: f32| {
            for placed in &self.placed[range.start as usize..range.end as usize] {
                let moved = placed.moved(&rays[i], t_max);
                let Some(found) = self.meshes[placed.mesh as usize].intersect(&moved) else { continue };
                let best = &mut hits[i];
                if found.t < best.t || found.t == best.t && placed.number < best.instance {
                    *best = Hit { t: found.t, primitive: found.primitive, instance: placed.number };
                    t_max = found.t;
                }
            }
            t_max
        };
        match query {
            Query::One => {
                for (i, ray) in rays.iter().enumerate() {
                    self.top.closest(ray, |range, t_max| visit(i, range, t_max));
                }
            }
            Query::Batch | Query::Coherent => self.top.closest_batch(rays, visit),
        }
    }

    /// Whether each of at most [`CHUNK`] rays hits anything.
    pub(super) fn any(&self, query: Query, rays: &[Ray], occluded: &mut [bool; CHUNK]) {
        let visit = |i: usize, range: Range<u32>| {
            let ray = &rays[i];
            // A loop instead of `Iterator::any`, whose closure might not be inlined.
            for placed in &self.placed[range.start as usize..range.end as usize] {
                if self.meshes[placed.mesh as usize].occluded(&placed.moved(ray, ray.t_max)) {
                    return true;
                }
            }
            false
        };
        match query {
            Query::One => {
                for (i, ray) in rays.iter().enumerate() {
                    occluded[i] = self.top.any(ray, |range| visit(i, range));
                }
            }
            Query::Batch | Query::Coherent => {
                self.top.any_batch(rays, &mut occluded[..rays.len()], visit);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use turner_bvh::Triangles;
    use turner_bvh::generate::{SceneKind, rays};

    use super::*;

    #[test]
    fn instances_are_hit_where_their_triangles_are() {
        let scene = SceneKind::Instances1m.generate(60);
        let options = BuildOptions::default();
        // All triangles in world space, in one BVH.
        let placed = 0..scene.instances.len() as u32;
        let count = scene.meshes[0].triangles.len() as u32;
        let corners: Vec<[f32; 3]> = placed
            .flat_map(|i| (0..count).flat_map(move |k| [(i, k)]))
            .flat_map(|(i, k)| scene.triangle(i, k))
            .collect();
        let triangles: Vec<[u32; 3]> =
            (0..corners.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let all = Bvh::build(&Triangles { positions: &corners, triangles: &triangles }, &options).unwrap();
        let mesh = Triangles { positions: &scene.meshes[0].positions, triangles: &scene.meshes[0].triangles };
        let two = Instances::build(&scene, vec![Bvh::build(&mesh, &options).unwrap()], &options).unwrap();
        let mut hit_count = 0;
        for rays in rays::primary(&scene.camera, 48).chunks(CHUNK) {
            for query in [Query::One, Query::Batch] {
                let mut hits = [Hit::MISS; CHUNK];
                let mut any = [false; CHUNK];
                two.nearest(query, rays, &mut hits);
                two.any(query, rays, &mut any);
                for (i, ray) in rays.iter().enumerate() {
                    let expected = all.intersect(ray);
                    let t = expected.map_or(f32::INFINITY, |hit| hit.t);
                    assert!(hits[i].t == t || (hits[i].t - t).abs() < 1e-4, "{ray:?}: {:?} for {t}", hits[i]);
                    assert_eq!(any[i], expected.is_some());
                    if let Some(hit) = expected {
                        assert_eq!(
                            [hits[i].instance, hits[i].primitive],
                            [hit.primitive / count, hit.primitive % count]
                        );
                        hit_count += 1;
                    }
                }
            }
        }
        assert!(hit_count > 500, "{hit_count} hits");
    }
}
