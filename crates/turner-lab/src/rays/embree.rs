//! Embree over a generated scene, under the same conditions as Turner's BVH.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use turner_bvh::Ray;
use turner_bvh::generate::Scene;
use turner_embree as embree;

use super::Rival;
use super::measure::{CHUNK, Query, RaySet, Tracer};
use super::tracer::Hit;

/// Rays in the layout of Embree's packets.
pub(super) type Packets = embree::Packets;

pub(super) fn packets(rays: &[Ray]) -> Packets {
    Packets::new(rays)
}

/// The loaded library.
pub(super) struct Embree(embree::Embree);

/// A device, and the meshes of a scene as Embree reads them.
pub(super) struct EmbreeScene {
    device: embree::Device,
    geometries: Vec<embree::Geometry>,
    instances: Vec<embree::Instance>,
}

/// A built scene.
pub(super) struct Built(Arc<embree::Scene>, Vec<Arc<embree::Scene>>);

impl Embree {
    pub(super) fn load(path: &Path) -> Result<Embree, String> {
        let embree = embree::Embree::load(path).map_err(|e| e.to_string())?;
        embree.device(1).map_err(|e| e.to_string())?;
        Ok(Embree(embree))
    }

    /// The version, for the table head.
    pub(super) fn version(&self) -> String {
        let version = self.0.device(1).map_or(0, |device| device.version());
        format!("{}.{}.{}", version / 10_000, version / 100 % 100, version % 100)
    }

    pub(super) fn scene_for(&self, scene: &Scene, threads: usize) -> Result<EmbreeScene, String> {
        let device = self.0.device(threads).map_err(|e| e.to_string())?;
        let geometries = scene.meshes.iter().map(|mesh| {
            let mesh = embree::Mesh { positions: &mesh.positions, triangles: &mesh.triangles };
            embree::Geometry::new(mesh).map_err(|e| e.to_string())
        });
        let instances =
            scene.instances.iter().map(|i| embree::Instance { mesh: i.mesh, transform: i.transform });
        Ok(EmbreeScene {
            geometries: geometries.collect::<Result<_, _>>()?,
            instances: instances.collect(),
            device,
        })
    }
}

impl EmbreeScene {
    /// Builds all BVHs of the scene.
    pub(super) fn build(&self, rival: Rival) -> Result<Built, String> {
        let (quality, robust) = match rival {
            Rival::Low => (embree::Quality::Low, false),
            Rival::Medium => (embree::Quality::Medium, false),
            Rival::High => (embree::Quality::High, false),
            Rival::Robust => (embree::Quality::Medium, true),
        };
        let options = embree::SceneOptions { quality, robust };
        let part = |geometry| embree::Scene::build(&self.device, geometry, options).map(Arc::new);
        let parts: Vec<_> =
            self.geometries.iter().map(part).collect::<Result<_, _>>().map_err(|e| e.to_string())?;
        if self.instances.is_empty() {
            let only = parts.first().ok_or("a scene without meshes")?;
            return Ok(Built(Arc::clone(only), Vec::new()));
        }
        let top = embree::Scene::instances(&self.device, &parts, &self.instances, options);
        Ok(Built(Arc::new(top.map_err(|e| e.to_string())?), parts))
    }
}

impl Built {
    /// Memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.0.bytes() + self.1.iter().map(|part| part.bytes()).sum::<usize>()
    }
}

fn hit(hit: embree::Hit) -> Hit {
    Hit { t: hit.t, primitive: hit.primitive, instance: hit.instance }
}

impl Tracer for Built {
    fn nearest(&self, query: Query, set: &RaySet, range: Range<usize>, hits: &mut [Hit; CHUNK]) {
        match query {
            Query::One | Query::Batch => {
                for (ray, out) in set.rays[range].iter().zip(hits) {
                    *out = hit(self.0.intersect(ray));
                }
            }
            Query::Coherent => {
                let mut found = [embree::Hit::MISS; CHUNK];
                self.0.intersect_packets(&set.packets, packets_of(&range), &mut found);
                for (out, &found) in hits.iter_mut().zip(&found[..range.len()]) {
                    *out = hit(found);
                }
            }
        }
    }

    fn any(&self, query: Query, set: &RaySet, range: Range<usize>, occluded: &mut [bool; CHUNK]) {
        match query {
            Query::One | Query::Batch => {
                for (ray, out) in set.rays[range].iter().zip(occluded) {
                    *out = self.0.occluded(ray);
                }
            }
            Query::Coherent => self.0.occluded_packets(&set.packets, packets_of(&range), occluded),
        }
    }
}

/// The packets of a range of rays that begins at a chunk.
fn packets_of(range: &Range<usize>) -> Range<usize> {
    range.start / Packets::WIDTH..range.end.div_ceil(Packets::WIDTH)
}
