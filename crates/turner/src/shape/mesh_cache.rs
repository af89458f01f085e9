//! The meshes of a scene, each made once.

use std::collections::HashMap;
use std::sync::Arc;

use super::mesh::MeshDesc;
use super::points::{Points, PointsDesc};
use super::triangle_mesh::{SkippedTriangles, TriangleMesh};
use crate::schema::{Asset, ErrorCode, MeshData, MeshId, PrepareOptions, SceneError};

/// Meshes and clouds of points as they were made, by the data that they were made from: what a later preparation need not make again, trees included.
#[derive(Clone, Debug, Default)]
pub struct CachedShapes {
    /// By the address of the data, which is held, and whether they are smooth.
    meshes: HashMap<(usize, bool), CachedMesh>,
    points: Vec<CachedPoints>,
}

#[derive(Clone, Debug)]
struct CachedMesh {
    data: Arc<MeshData>,
    mesh: Arc<TriangleMesh>,
    left_out: SkippedTriangles,
}

#[derive(Clone, Debug)]
struct CachedPoints {
    desc: PointsDesc,
    data: Arc<MeshData>,
    points: Arc<Points>,
}

impl CachedShapes {
    fn points(&self, desc: &PointsDesc, data: &Arc<MeshData>) -> Option<Arc<Points>> {
        let same = |k: &&CachedPoints| {
            Arc::ptr_eq(&k.data, data) && k.desc.radius == desc.radius && k.desc.radii == desc.radii
        };
        self.points.iter().find(same).map(|k| k.points.clone())
    }

    /// How many meshes of `other` are not among these.
    pub(crate) fn new_meshes(&self, other: &CachedShapes) -> usize {
        let is_new = |(key, made): &(&(usize, bool), &CachedMesh)| {
            !self.meshes.get(*key).is_some_and(|own| Arc::ptr_eq(&own.data, &made.data))
        };
        other.meshes.iter().filter(is_new).count()
    }
}

/// Bytes that a vertex takes while its normal is computed.
const NORMAL_MADE: u64 = 36;

/// The meshes of a scene, prepared at first use and then shared by all objects that show them the same way.
#[derive(Debug)]
pub struct MeshCache<'a> {
    meshes: &'a [Asset<MeshData>],
    options: PrepareOptions,
    prepared: HashMap<(MeshId, bool), Arc<TriangleMesh>>,
    /// What was made before, and what of it and anew is used now.
    kept: Option<&'a CachedShapes>,
    used: CachedShapes,
    points_left_out: Vec<String>,
    /// Of triangles with a vertex that is not finite, of those without area, and of meshes without any others.
    left_out: [Without; 3],
}

/// What was left out of meshes: how many triangles, of how many meshes, and the first of these.
#[derive(Debug, Default)]
struct Without {
    triangles: usize,
    meshes: usize,
    first: String,
}

impl Without {
    fn add(&mut self, triangles: usize, name: &str) {
        self.triangles += triangles;
        self.meshes += 1;
        if self.meshes == 1 {
            self.first = match name {
                "" => "a mesh".to_owned(),
                name => format!("the mesh \"{}\"", crate::schema::error::escape(name)),
            };
        }
    }

    /// The meshes, in words.
    fn meshes(&self) -> String {
        match self.meshes {
            1 => self.first.clone(),
            n => format!("{n} meshes, the first of them {}", self.first),
        }
    }
}

impl<'a> MeshCache<'a> {
    /// Over the scene's list, by [`MeshId`].
    pub fn new(meshes: &'a [Asset<MeshData>]) -> MeshCache<'a> {
        MeshCache::with_options(meshes, &PrepareOptions::default())
    }

    /// The same, and how to build trees.
    pub fn with_options(meshes: &'a [Asset<MeshData>], options: &PrepareOptions) -> MeshCache<'a> {
        MeshCache {
            meshes,
            options: options.clone(),
            prepared: HashMap::new(),
            kept: None,
            used: CachedShapes::default(),
            points_left_out: Vec::new(),
            left_out: Default::default(),
        }
    }

    /// The same, where meshes and clouds of points that were made from the same data are taken from `kept`.
    pub fn with_kept(
        meshes: &'a [Asset<MeshData>],
        options: &PrepareOptions,
        kept: &'a CachedShapes,
    ) -> MeshCache<'a> {
        MeshCache { kept: Some(kept), ..MeshCache::with_options(meshes, options) }
    }

    /// All that was asked for, to be given to the next cache.
    pub fn into_kept(self) -> CachedShapes {
        self.used
    }

    /// What was left out of the meshes prepared so far: a sentence for each kind.
    pub fn warnings(&self) -> Vec<String> {
        let mut out = self.points_left_out.clone();
        let [infinite, flat, empty] = &self.left_out;
        for (without, why) in [(infinite, "with a vertex that is not finite"), (flat, "without area")] {
            let triangles = if without.triangles == 1 { "triangle" } else { "triangles" };
            if without.meshes > 0 {
                out.push(format!("{} {triangles} {why} left out of {}", without.triangles, without.meshes()));
            }
        }
        if empty.meshes > 0 {
            let verb = if empty.meshes == 1 { "has" } else { "have" };
            let meshes = if empty.meshes == 1 { empty.meshes() } else { empty.meshes() + "," };
            out.push(format!("{meshes} {verb} no triangles to show"));
        }
        out
    }

    /// The meshes prepared so far.
    pub fn prepared(&self) -> impl Iterator<Item = &Arc<TriangleMesh>> {
        self.prepared.values()
    }

    /// The points an object shows.
    pub fn points(&mut self, desc: &PointsDesc) -> Result<Arc<Points>, SceneError> {
        let data = self.meshes.get(desc.points.index()).map(|asset| asset.data.clone());
        let known = self.kept.and_then(|kept| kept.points(desc, data.as_ref()?));
        let points = match known {
            Some(points) => points,
            None => Arc::new(desc.prepare(self.meshes, &self.options)?),
        };
        if let Some(data) = data {
            self.used.points.push(CachedPoints { desc: desc.clone(), data, points: points.clone() });
        }
        let left_out =
            self.meshes.get(desc.points.index()).map_or(0, |a| a.data.positions.len()) - points.count();
        if left_out > 0 {
            self.points_left_out
                .push(format!("{left_out} points that are not finite, or without a radius, left out"));
        }
        Ok(points)
    }

    /// The mesh an object shows.
    pub fn get(&mut self, desc: &MeshDesc) -> Result<Arc<TriangleMesh>, SceneError> {
        let Some(asset) = self.meshes.get(desc.mesh.index()) else {
            let message =
                format!("an object names mesh {}, but the scene has {}", desc.mesh.0, self.meshes.len());
            return Err(SceneError::new(ErrorCode::Mesh, message));
        };
        let smooth = desc.smooth.unwrap_or(!asset.data.normals.is_empty());
        if let Some(mesh) = self.prepared.get(&(desc.mesh, smooth)) {
            return Ok(Arc::clone(mesh));
        }
        if smooth && asset.data.normals.is_empty() {
            let bytes = (asset.data.positions.len() as u64).saturating_mul(NORMAL_MADE);
            self.options.limits.memory.need(bytes, || "computing normals".to_owned())?;
        }
        let key = (Arc::as_ptr(&asset.data) as usize, smooth);
        let known = self.kept.and_then(|kept| kept.meshes.get(&key)).cloned();
        let made = match known {
            Some(made) => made,
            None => {
                let (mesh, left_out) = TriangleMesh::without_tree(&asset.data, smooth)?;
                CachedMesh { data: asset.data.clone(), mesh: Arc::new(mesh), left_out }
            }
        };
        let CachedMesh { mesh, left_out, .. } = made.clone();
        self.used.meshes.insert(key, made);
        // Once per mesh, not once for each way it is shaded.
        if !self.prepared.contains_key(&(desc.mesh, !smooth)) {
            let [infinite, flat, empty] = &mut self.left_out;
            for (without, count) in [(infinite, left_out.non_finite), (flat, left_out.flat)] {
                if count > 0 {
                    without.add(count, &asset.uri);
                }
            }
            if mesh.triangle_count() == 0 {
                empty.add(0, &asset.uri);
            }
        }
        self.prepared.insert((desc.mesh, smooth), Arc::clone(&mesh));
        Ok(mesh)
    }
}
