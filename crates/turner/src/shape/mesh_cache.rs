//! The meshes of a scene, each prepared once.

use std::collections::HashMap;
use std::sync::Arc;

use super::curves::{Curves, CurvesDesc};
use super::height_field::HeightFieldDesc;
use super::made_meshes::CachedMade;
use super::mesh::MeshDesc;
use super::points::{Points, PointsDesc};
use super::triangle_mesh::{SkippedTriangles, TriangleMesh};
use crate::image::Image;
use crate::schema::{Asset, ErrorCode, ImageId, MeshData, MeshId, PrepareOptions, SceneError};

/// Prepared meshes and point clouds, trees included, by the data they were prepared from. The next preparation
/// reuses those whose data are unchanged.
#[derive(Clone, Debug, Default)]
pub struct CachedShapes {
    /// Key: the address of the data (kept alive by the entry), and whether it is smooth.
    meshes: HashMap<(usize, bool), CachedMesh>,
    points: Vec<CachedPoints>,
    curves: Vec<CachedCurves>,
    height_fields: Vec<CachedHeightField>,
    made: Vec<CachedMade>,
}

#[derive(Clone, Debug)]
struct CachedMesh {
    data: Arc<MeshData>,
    mesh: Arc<TriangleMesh>,
    skipped: SkippedTriangles,
}

#[derive(Clone, Debug)]
struct CachedPoints {
    desc: PointsDesc,
    data: Arc<MeshData>,
    points: Arc<Points>,
}

#[derive(Clone, Debug)]
struct CachedCurves {
    desc: CurvesDesc,
    data: Arc<MeshData>,
    curves: Arc<Curves>,
}

#[derive(Clone, Debug)]
struct CachedHeightField {
    desc: HeightFieldDesc,
    image: Arc<Image>,
    mesh: Arc<TriangleMesh>,
}

impl CachedShapes {
    fn height_field(&self, desc: &HeightFieldDesc, image: &Arc<Image>) -> Option<Arc<TriangleMesh>> {
        let same = |k: &&CachedHeightField| {
            // The number of the image may change; its data decide.
            Arc::ptr_eq(&k.image, image) && HeightFieldDesc { file: desc.file, ..k.desc.clone() } == *desc
        };
        self.height_fields.iter().find(same).map(|k| k.mesh.clone())
    }

    fn points(&self, desc: &PointsDesc, data: &Arc<MeshData>) -> Option<Arc<Points>> {
        let same = |k: &&CachedPoints| {
            Arc::ptr_eq(&k.data, data) && k.desc.radius == desc.radius && k.desc.radii == desc.radii
        };
        self.points.iter().find(same).map(|k| k.points.clone())
    }

    fn curves(&self, desc: &CurvesDesc, data: &Arc<MeshData>) -> Option<Arc<Curves>> {
        let same = |k: &&CachedCurves| {
            // The number of the mesh may change; its data decide.
            Arc::ptr_eq(&k.data, data) && CurvesDesc { curves: desc.curves, ..k.desc.clone() } == *desc
        };
        self.curves.iter().find(same).map(|k| k.curves.clone())
    }

    /// How many meshes of `other` are not in this cache.
    pub(crate) fn new_meshes(&self, other: &CachedShapes) -> usize {
        let is_new = |(key, made): &(&(usize, bool), &CachedMesh)| {
            !self.meshes.get(*key).is_some_and(|own| Arc::ptr_eq(&own.data, &made.data))
        };
        other.meshes.iter().filter(is_new).count()
    }
}

/// Bytes per vertex while normals are computed.
const NORMAL_BYTES: u64 = 36;

/// The meshes of a scene: prepared at first use, then shared by all objects with the same mesh and shading.
#[derive(Debug)]
pub struct MeshCache<'a> {
    meshes: &'a [Asset<MeshData>],
    images: &'a [Asset<Image>],
    options: PrepareOptions,
    prepared: HashMap<(MeshId, bool), Arc<TriangleMesh>>,
    /// Shapes of the previous preparation, and all shapes of this one.
    kept: Option<&'a CachedShapes>,
    used: CachedShapes,
    other_warnings: Vec<String>,
    /// Statistics of triangles with a non-finite vertex, of triangles without area, and of meshes without any
    /// usable triangle.
    skipped: [Skipped; 3],
}

/// Skipped triangles: how many, of how many meshes, and the name of the first of these.
#[derive(Debug, Default)]
struct Skipped {
    triangles: usize,
    meshes: usize,
    first: String,
}

impl Skipped {
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

    /// The meshes, as text for a warning.
    fn meshes(&self) -> String {
        match self.meshes {
            1 => self.first.clone(),
            n => format!("{n} meshes, the first of them {}", self.first),
        }
    }
}

impl<'a> MeshCache<'a> {
    /// A cache over the scene's list of meshes, by [`MeshId`].
    pub fn new(meshes: &'a [Asset<MeshData>]) -> MeshCache<'a> {
        MeshCache::with_options(meshes, &PrepareOptions::default())
    }

    /// As [`MeshCache::new`], with options for building trees.
    pub fn with_options(meshes: &'a [Asset<MeshData>], options: &PrepareOptions) -> MeshCache<'a> {
        MeshCache {
            meshes,
            images: &[],
            options: options.clone(),
            prepared: HashMap::new(),
            kept: None,
            used: CachedShapes::default(),
            other_warnings: Vec::new(),
            skipped: Default::default(),
        }
    }

    /// As [`MeshCache::with_options`]; reuses meshes and point clouds of `kept` whose data are the same.
    pub fn with_cached(
        meshes: &'a [Asset<MeshData>],
        options: &PrepareOptions,
        kept: &'a CachedShapes,
    ) -> MeshCache<'a> {
        MeshCache { kept: Some(kept), ..MeshCache::with_options(meshes, options) }
    }

    /// The same cache over the scene's list of images, by [`ImageId`](crate::schema::ImageId), for height fields.
    pub fn with_images(self, images: &'a [Asset<Image>]) -> MeshCache<'a> {
        MeshCache { images, ..self }
    }

    /// All shapes of this preparation, for the next cache.
    pub fn into_cached(self) -> CachedShapes {
        self.used
    }

    /// One warning for each kind of skipped triangles or points.
    pub fn warnings(&self) -> Vec<String> {
        let mut out = self.other_warnings.clone();
        let [infinite, flat, empty] = &self.skipped;
        for (skipped, why) in [(infinite, "with a vertex that is not finite"), (flat, "without area")] {
            let triangles = if skipped.triangles == 1 { "triangle" } else { "triangles" };
            if skipped.meshes > 0 {
                out.push(format!(
                    "{} {triangles} {why} omitted from {}",
                    skipped.triangles,
                    skipped.meshes()
                ));
            }
        }
        if empty.meshes > 0 {
            let verb = if empty.meshes == 1 { "has" } else { "have" };
            let meshes = if empty.meshes == 1 { empty.meshes() } else { empty.meshes() + "," };
            out.push(format!("{meshes} {verb} no triangles to show"));
        }
        out
    }

    /// The meshes prepared so far, and those made of height fields and control cages; each once.
    pub fn prepared(&self) -> impl Iterator<Item = &Arc<TriangleMesh>> {
        let fields = &self.used.height_fields;
        let is_first = |(i, field): &(usize, &CachedHeightField)| {
            !fields[..*i].iter().any(|other| Arc::ptr_eq(&other.mesh, &field.mesh))
        };
        let fields = fields.iter().enumerate().filter(is_first).map(|(_, field)| &field.mesh);
        self.prepared.values().chain(fields).chain(self.used.made.iter().map(CachedMade::mesh))
    }

    /// The prepared curves of an object.
    pub fn curves(&mut self, desc: &CurvesDesc) -> Result<Arc<Curves>, SceneError> {
        let data = self.meshes.get(desc.curves.index()).map(|asset| asset.data.clone());
        let known = data.as_ref().and_then(|data| {
            let kept = self.kept.and_then(|kept| kept.curves(desc, data));
            kept.or_else(|| self.used.curves(desc, data))
        });
        if let Some(curves) = known {
            if let Some(data) = data {
                self.used.curves.push(CachedCurves { desc: desc.clone(), data, curves: curves.clone() });
            }
            return Ok(curves);
        }
        let curves = Arc::new(desc.prepare(self.meshes, &self.options)?);
        if let Some(data) = data {
            self.used.curves.push(CachedCurves { desc: desc.clone(), data, curves: curves.clone() });
        }
        Ok(curves)
    }

    /// The prepared point cloud of an object.
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
        let skipped =
            self.meshes.get(desc.points.index()).map_or(0, |a| a.data.positions.len()) - points.count();
        if skipped > 0 {
            self.other_warnings
                .push(format!("{skipped} points that are not finite, or without a radius, omitted"));
        }
        Ok(points)
    }

    /// The prepared mesh of a height field.
    ///
    /// Errors: a missing image; one that is too large; not enough memory.
    pub fn height_field(&mut self, desc: &HeightFieldDesc) -> Result<Arc<TriangleMesh>, SceneError> {
        let image = self.image(desc.file, "a height field")?;
        let known = self.kept.and_then(|kept| kept.height_field(desc, &image));
        let known = known.or_else(|| self.used.height_field(desc, &image));
        let mesh = match known {
            Some(mesh) => mesh,
            None => {
                let what = || "a height field".to_owned();
                self.options.limits.check_triangles(HeightFieldDesc::triangles(&image), what)?;
                self.options.limits.memory.need(HeightFieldDesc::bytes(&image), what)?;
                let data = Arc::new(desc.mesh(&image)?);
                Arc::new(TriangleMesh::without_tree(&data, desc.smooth)?.0)
            }
        };
        let kept = CachedHeightField { desc: desc.clone(), image, mesh: mesh.clone() };
        self.used.height_fields.push(kept);
        Ok(mesh)
    }

    /// An image of the scene, for `what`.
    ///
    /// Errors: there is none with this number, or it is inconsistent.
    pub(super) fn image(&self, id: ImageId, what: &str) -> Result<Arc<Image>, SceneError> {
        let image = self.images.get(id.index()).map(|asset| asset.data.clone());
        image.filter(|image| image.is_consistent()).ok_or_else(|| {
            let message = format!("{what} names image {}, but the scene has {}", id.0, self.images.len());
            SceneError::new(ErrorCode::Image, message)
        })
    }

    /// Meshes that this preparation made, and those of the previous one.
    pub(super) fn used_made(&self) -> &[CachedMade] {
        &self.used.made
    }

    pub(super) fn kept_made(&self) -> &[CachedMade] {
        self.kept.map_or(&[], |kept| &kept.made)
    }

    pub(super) fn keep_made(&mut self, made: CachedMade) {
        self.used.made.push(made);
    }

    pub(super) fn options(&self) -> &PrepareOptions {
        &self.options
    }

    /// Builds the tree of a mesh that is a part of another shape.
    pub(super) fn build_tree(&self, mesh: &TriangleMesh) -> Result<(), SceneError> {
        mesh.build_tree(&self.options)
    }

    /// Asks for memory before it is allocated.
    pub(super) fn need(&self, bytes: u64, what: impl FnOnce() -> String) -> Result<(), SceneError> {
        self.options.limits.memory.need(bytes, what)
    }

    /// Adds a warning.
    pub(super) fn warn(&mut self, warning: String) {
        self.other_warnings.push(warning);
    }

    /// The prepared mesh of an object.
    pub fn get(&mut self, desc: &MeshDesc) -> Result<Arc<TriangleMesh>, SceneError> {
        let meshes = self.meshes;
        let Some(asset) = meshes.get(desc.mesh.index()) else {
            let message =
                format!("an object names mesh {}, but the scene has {}", desc.mesh.0, self.meshes.len());
            return Err(SceneError::new(ErrorCode::Mesh, message));
        };
        if desc.is_refined() {
            return self.refined(asset, desc);
        }
        let smooth = desc.smooth.unwrap_or(!asset.data.normals.is_empty());
        if let Some(mesh) = self.prepared.get(&(desc.mesh, smooth)) {
            return Ok(Arc::clone(mesh));
        }
        if smooth && asset.data.normals.is_empty() {
            let bytes = (asset.data.positions.len() as u64).saturating_mul(NORMAL_BYTES);
            self.options.limits.memory.need(bytes, || "computing normals".to_owned())?;
        }
        let key = (Arc::as_ptr(&asset.data) as usize, smooth);
        let known = self.kept.and_then(|kept| kept.meshes.get(&key)).cloned();
        let made = match known {
            Some(made) => made,
            None => {
                let (mesh, skipped) = TriangleMesh::without_tree(&asset.data, smooth)?;
                CachedMesh { data: asset.data.clone(), mesh: Arc::new(mesh), skipped }
            }
        };
        let CachedMesh { mesh, skipped, .. } = made.clone();
        self.used.meshes.insert(key, made);
        // Once per mesh, even if it is used both smooth and faceted.
        if !self.prepared.contains_key(&(desc.mesh, !smooth)) {
            let [infinite, flat, empty] = &mut self.skipped;
            for (skipped, count) in [(infinite, skipped.non_finite), (flat, skipped.flat)] {
                if count > 0 {
                    skipped.add(count, &asset.uri);
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
