//! Turner's BVH over a generated scene. Only this file calls its build and query functions.

use std::ops::Range;

use turner_bvh::generate::Scene;
use turner_bvh::{BuildOptions, Bvh, Ray, Triangles};
use turner_cli::instructions::instruction_set;

use super::instances::Instances;
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
    /// A miss.
    pub(super) const MISS: Hit = Hit { t: f32::INFINITY, primitive: u32::MAX, instance: u32::MAX };
}

/// Build quality of a BVH.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Quality {
    /// Fastest to build.
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
        BuildOptions { quality, threads, instruction_set: instruction_set(), ..BuildOptions::default() }
    }
}

/// A built scene.
pub(super) enum Turner {
    Mesh(Bvh),
    Instances(Instances),
}

impl Turner {
    /// Builds all BVHs of a scene.
    pub(super) fn build(scene: &Scene, quality: Quality, threads: usize) -> Result<Turner, String> {
        let options = quality.options(threads);
        let mut parts = Vec::new();
        for mesh in &scene.meshes {
            let mesh = Triangles { positions: &mesh.positions, triangles: &mesh.triangles };
            parts.push(Bvh::build(&mesh, &options).map_err(|e| e.to_string())?);
        }
        if scene.instances.is_empty() {
            return parts.into_iter().next().map(Turner::Mesh).ok_or_else(|| "a scene without meshes".into());
        }
        Instances::build(scene, parts, &options).map(Turner::Instances)
    }

    /// Memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Turner::Mesh(mesh) => mesh.stats().bytes,
            Turner::Instances(instances) => instances.bytes(),
        }
    }
}

impl Tracer for Turner {
    fn nearest(&self, query: Query, set: &RaySet, range: Range<usize>, hits: &mut [Hit; CHUNK]) {
        let rays: &[Ray] = &set.rays[range];
        let mesh = match self {
            Turner::Mesh(mesh) => mesh,
            Turner::Instances(instances) => return instances.nearest(query, rays, hits),
        };
        let mut found = [turner_bvh::Hit::MISS; CHUNK];
        match query {
            Query::One => {
                for (ray, out) in rays.iter().zip(&mut found) {
                    *out = mesh.intersect(ray).unwrap_or(turner_bvh::Hit::MISS);
                }
            }
            Query::Batch | Query::Coherent => mesh.intersect_batch(rays, &mut found[..rays.len()]),
        }
        for (out, found) in hits.iter_mut().zip(&found[..rays.len()]) {
            *out = Hit { t: found.t, primitive: found.primitive, instance: u32::MAX };
        }
    }

    fn any(&self, query: Query, set: &RaySet, range: Range<usize>, occluded: &mut [bool; CHUNK]) {
        let rays: &[Ray] = &set.rays[range];
        let mesh = match self {
            Turner::Mesh(mesh) => mesh,
            Turner::Instances(instances) => return instances.any(query, rays, occluded),
        };
        match query {
            Query::One => {
                for (ray, out) in rays.iter().zip(occluded) {
                    *out = mesh.occluded(ray);
                }
            }
            Query::Batch | Query::Coherent => mesh.occluded_batch(rays, &mut occluded[..rays.len()]),
        }
    }
}
