//! Prepared shapes: each mesh once, for all its instances.

use std::sync::Arc;

use crate::description::{ObjectContent, ObjectDesc, SceneDesc};
use crate::schema::{PrepareOptions, SceneError, Warning, WarningKind};
use crate::shape::{CachedShapes, MeshCache, Shape, TriangleMesh};

/// The shapes of all objects and groups, each prepared once.
pub(crate) struct PreparedShapes {
    /// For the scene's objects and for those of each group, by index; `None` for instances and hidden objects.
    pub(crate) objects: Vec<Option<Shape>>,
    pub(crate) groups: Vec<Vec<Option<Shape>>>,
    pub(crate) meshes: Vec<Arc<TriangleMesh>>,
    /// What was omitted from meshes.
    pub(crate) warnings: Vec<Warning>,
}

impl PreparedShapes {
    /// Prepares all shapes of a scene. Meshes and point clouds with the same data are taken from `kept`, which
    /// then holds those of this scene.
    ///
    /// Errors: inconsistent meshes, not enough memory.
    pub(super) fn new(
        desc: &SceneDesc,
        options: &PrepareOptions,
        kept: &mut CachedShapes,
    ) -> Result<PreparedShapes, SceneError> {
        let mut cache = MeshCache::with_cached(&desc.meshes, options, kept).with_images(&desc.images);
        let mut prepare = |objects: &[ObjectDesc]| -> Result<Vec<Option<Shape>>, SceneError> {
            objects
                .iter()
                .map(|o| match &o.content {
                    _ if o.hidden => Ok(None),
                    ObjectContent::Shape(s) => s.prepare(&mut cache).map(Some).map_err(|e| e.or_at(o.span)),
                    ObjectContent::Instance(_) => Ok(None),
                })
                .collect()
        };
        let objects = prepare(&desc.objects)?;
        let groups = desc.groups.iter().map(|g| prepare(&g.value.objects)).collect::<Result<_, _>>()?;
        let doubt = |m: &String| Warning::new(WarningKind::Doubtful, m.as_str());
        let warnings = cache.warnings().iter().map(doubt).collect();
        let meshes = cache.prepared().cloned().collect();
        *kept = cache.into_cached();
        Ok(PreparedShapes { objects, groups, meshes, warnings })
    }
}
