//! Meshes that are made of descriptions while a scene is prepared, each once.

use std::sync::Arc;

use super::mesh::MeshDesc;
use super::mesh_cache::MeshCache;
use super::parametric::ParametricDesc;
use super::subdivision::{Subdivision, subdivide};
use super::text::{TextDesc, missing_characters};
use super::triangle_mesh::TriangleMesh;
use crate::schema::{Asset, MeshData, SceneError};

/// What a mesh is made of.
#[derive(Clone, Debug)]
pub(super) enum Recipe {
    /// A subdivided mesh, and whether it is smooth.
    Subdivided(Arc<MeshData>, Box<Subdivision>, bool),
    /// A parametric surface.
    Parametric(ParametricDesc),
    /// A text.
    Text(TextDesc),
}

impl Recipe {
    /// Whether the same mesh would be made.
    fn same(&self, other: &Recipe) -> bool {
        match (self, other) {
            (Recipe::Subdivided(a, by, smooth), Recipe::Subdivided(b, other_by, other_smooth)) => {
                Arc::ptr_eq(a, b) && by == other_by && smooth == other_smooth
            }
            (Recipe::Parametric(a), Recipe::Parametric(b)) => a == b,
            (Recipe::Text(a), Recipe::Text(b)) => a == b,
            (Recipe::Subdivided(..) | Recipe::Parametric(_) | Recipe::Text(_), _) => false,
        }
    }
}

/// A mesh with its recipe.
#[derive(Clone, Debug)]
pub(super) struct CachedMade {
    recipe: Recipe,
    mesh: Arc<TriangleMesh>,
}

impl CachedMade {
    pub(super) fn mesh(&self) -> &Arc<TriangleMesh> {
        &self.mesh
    }
}

impl MeshCache<'_> {
    /// The mesh of a recipe: a known one, or what `make` makes.
    fn made(
        &mut self,
        recipe: Recipe,
        make: impl FnOnce(&mut Self) -> Result<TriangleMesh, SceneError>,
    ) -> Result<Arc<TriangleMesh>, SceneError> {
        let find = |list: &[CachedMade]| list.iter().find(|k| k.recipe.same(&recipe)).cloned();
        if let Some(made) = find(self.used_made()) {
            return Ok(made.mesh);
        }
        let made = match find(self.kept_made()) {
            Some(made) => made,
            None => {
                let mesh = Arc::new(make(self)?);
                CachedMade { recipe, mesh }
            }
        };
        let mesh = made.mesh.clone();
        self.keep_made(made);
        Ok(mesh)
    }

    /// The prepared mesh of an object that subdivides it.
    ///
    /// Errors: those of [`subdivide`].
    pub(super) fn subdivided(
        &mut self,
        asset: &Asset<MeshData>,
        desc: &MeshDesc,
        by: &Subdivision,
    ) -> Result<Arc<TriangleMesh>, SceneError> {
        let smooth = desc.smooth.unwrap_or(true);
        let recipe = Recipe::Subdivided(asset.data.clone(), Box::new(by.clone()), smooth);
        self.made(recipe, |cache| {
            let subdivided = subdivide(&asset.data, by, &cache.options().limits)?;
            if subdivided.omitted > 0 {
                let count = subdivided.omitted;
                let faces = if count == 1 { "face" } else { "faces" };
                cache.warn(format!(
                    "{count} {faces} of a subdivided mesh omitted: they meet themselves, or have a vertex that is not finite"
                ));
            }
            Ok(TriangleMesh::without_tree(&Arc::new(subdivided.mesh), smooth)?.0)
        })
    }

    /// The prepared mesh of a parametric surface.
    ///
    /// Errors: those of the expressions; more triangles than the limits allow.
    pub(super) fn parametric(&mut self, desc: &ParametricDesc) -> Result<Arc<TriangleMesh>, SceneError> {
        self.made(Recipe::Parametric(desc.clone()), |cache| {
            let (data, reached) = desc.mesh(&cache.options().limits)?;
            if !reached {
                cache.warn(
                    "a parametric surface has more than `tolerance` of error at its largest number of triangles".to_owned(),
                );
            }
            Ok(TriangleMesh::without_tree(&Arc::new(data), desc.smooth)?.0)
        })
    }

    /// The prepared mesh of a text.
    ///
    /// Errors: those of the font; more triangles than the limits allow.
    pub(super) fn text(&mut self, desc: &TextDesc) -> Result<Arc<TriangleMesh>, SceneError> {
        self.made(Recipe::Text(desc.clone()), |cache| {
            let set = desc.mesh(&cache.options().limits)?;
            if !set.missing.is_empty() {
                cache.warn(missing_characters(&set.missing));
            }
            if set.mesh.triangles.is_empty() {
                cache.warn("a text has no outlines to show".to_owned());
            }
            Ok(TriangleMesh::without_tree(&Arc::new(set.mesh), true)?.0)
        })
    }
}
