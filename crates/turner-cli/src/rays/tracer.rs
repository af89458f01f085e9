//! Turner's tree over a generated scene. This file alone knows by which calls it is built and asked.

use std::ops::Range;
use std::sync::Arc;

use turner_bvh::generate::Scene;
use turner_bvh::{BuildOptions, Bvh, Group, GroupParts, Instance, Object, Ray, Triangles};

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

    fn options(self, threads: usize) -> BuildOptions<'static> {
        let quality = match self {
            Quality::Fast => turner_bvh::Quality::Fast,
            Quality::Balanced => turner_bvh::Quality::Balanced,
            Quality::High => turner_bvh::Quality::High,
        };
        BuildOptions { quality, threads, ..BuildOptions::default() }
    }
}

/// A built scene.
pub(super) enum Turner {
    Mesh(Arc<Bvh>),
    Group(Box<Group>),
}

impl Turner {
    /// Builds all trees of a scene.
    pub(super) fn build(scene: &Scene, quality: Quality, threads: usize) -> Result<Turner, String> {
        let options = quality.options(threads);
        let mut parts = Vec::new();
        for mesh in &scene.meshes {
            let mesh = Triangles { positions: &mesh.positions, triangles: &mesh.triangles };
            parts.push(Arc::new(Bvh::build(&mesh, &options).map_err(|e| e.to_string())?));
        }
        if scene.instances.is_empty() {
            return parts.into_iter().next().map(Turner::Mesh).ok_or_else(|| "a scene without meshes".into());
        }
        let instances: Vec<Instance> =
            scene.instances.iter().map(|i| Instance { object: i.mesh, transform: i.transform }).collect();
        let objects = parts.into_iter().map(Object::Mesh).collect();
        let parts = GroupParts { instances: &instances, ..GroupParts::default() };
        Group::build(objects, &parts, &options)
            .map(|group| Turner::Group(Box::new(group)))
            .map_err(|e| e.to_string())
    }

    /// Bytes of memory.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Turner::Mesh(mesh) => mesh.stats().bytes,
            Turner::Group(group) => {
                let objects = group.objects().iter().map(|object| match object {
                    Object::Mesh(mesh) => mesh.stats().bytes,
                    Object::Moving(mesh) => mesh.stats().bytes,
                    Object::Group(group) => group.stats().bytes,
                });
                group.stats().bytes + objects.sum::<usize>()
            }
        }
    }
}

/// A hit in the words of the table.
fn hit(hit: turner_bvh::Hit) -> Hit {
    Hit { t: hit.t, primitive: hit.primitive, instance: hit.instance }
}

/// How each of the two kinds of trees is asked.
macro_rules! ask {
    ($tree:expr, $query:expr, $rays:expr, $out:expr, $one:ident, $batch:ident, $coherent:ident, $each:expr) => {
        match $query {
            Query::One => {
                for (ray, out) in $rays.iter().zip($out) {
                    *out = $each($tree.$one(ray));
                }
            }
            Query::Batch => $tree.$batch($rays, &mut $out[..$rays.len()]),
            Query::Coherent => $tree.$coherent($rays, &mut $out[..$rays.len()]),
        }
    };
}

impl Tracer for Turner {
    fn nearest(&self, query: Query, set: &RaySet, range: Range<usize>, hits: &mut [Hit; CHUNK]) {
        let rays: &[Ray] = &set.rays[range];
        let mut found = [turner_bvh::Hit::MISS; CHUNK];
        let found = &mut found[..];
        let one = |hit: Option<turner_bvh::Hit>| hit.unwrap_or(turner_bvh::Hit::MISS);
        // The last name but one is that for rays that run together; groups have no packets.
        match self {
            Turner::Mesh(m) => {
                ask!(m, query, rays, &mut *found, intersect, intersect_batch, intersect_coherent, one)
            }
            Turner::Group(g) => {
                ask!(g, query, rays, &mut *found, intersect, intersect_batch, intersect_batch, one)
            }
        }
        for (out, &found) in hits.iter_mut().zip(&found[..rays.len()]) {
            *out = hit(found);
        }
    }

    fn any(&self, query: Query, set: &RaySet, range: Range<usize>, occluded: &mut [bool; CHUNK]) {
        let rays: &[Ray] = &set.rays[range];
        let out = &mut occluded[..];
        let one = |hit: bool| hit;
        match self {
            Turner::Mesh(m) => {
                ask!(m, query, rays, &mut *out, occluded, occluded_batch, occluded_coherent, one)
            }
            Turner::Group(g) => {
                ask!(g, query, rays, &mut *out, occluded, occluded_batch, occluded_batch, one)
            }
        }
    }
}
