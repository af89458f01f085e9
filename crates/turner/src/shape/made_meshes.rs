//! Meshes that are made of descriptions while a scene is prepared, each once.

use std::sync::Arc;

use super::displacement::{Displacement, Refinement};
use super::mesh::MeshDesc;
use super::mesh_cache::MeshCache;
use super::parametric::ParametricDesc;
use super::subdivision::{Subdivision, subdivide};
use super::text::{TextDesc, missing_characters};
use super::triangle_mesh::TriangleMesh;
use crate::image::Image;
use crate::schema::{Asset, MeshData, SceneError};

/// What a mesh is made of.
#[derive(Clone, Debug)]
pub(super) enum Recipe {
    /// A mesh that is subdivided, divided or displaced.
    Refined(Arc<MeshData>, Box<Refined>),
    /// A parametric surface.
    Parametric(ParametricDesc),
    /// A text.
    Text(TextDesc),
}

/// What is done to a mesh.
#[derive(Clone, Debug)]
pub(super) struct Refined {
    subdivision: Option<Box<Subdivision>>,
    edge_length: Option<f64>,
    displacement: Option<(Displacement, Arc<Image>)>,
    smooth: bool,
}

impl Refined {
    fn same(&self, other: &Refined) -> bool {
        let moved = match (&self.displacement, &other.displacement) {
            (Some((a, image)), Some((b, other))) => {
                // The number of the image may change; its data decide.
                Arc::ptr_eq(image, other) && Displacement { image: b.image, ..*a } == *b
            }
            (a, b) => a.is_none() && b.is_none(),
        };
        moved
            && self.subdivision == other.subdivision
            && self.edge_length == other.edge_length
            && self.smooth == other.smooth
    }
}

impl Recipe {
    /// Whether the same mesh would be made.
    fn same(&self, other: &Recipe) -> bool {
        match (self, other) {
            (Recipe::Refined(a, by), Recipe::Refined(b, other)) => Arc::ptr_eq(a, b) && by.same(other),
            (Recipe::Parametric(a), Recipe::Parametric(b)) => a == b,
            (Recipe::Text(a), Recipe::Text(b)) => a == b,
            (Recipe::Refined(..) | Recipe::Parametric(_) | Recipe::Text(_), _) => false,
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

    /// The prepared mesh of an object that subdivides, divides or displaces it.
    ///
    /// Errors: those of [`subdivide`] and [`Refinement::apply`]; a missing image.
    pub(super) fn refined(
        &mut self,
        asset: &Asset<MeshData>,
        desc: &MeshDesc,
    ) -> Result<Arc<TriangleMesh>, SceneError> {
        let image = |by: Displacement| Ok((by, self.image(by.image, "a displaced mesh")?));
        let displacement = desc.displacement.map(image).transpose()?;
        let smooth = desc.smooth.unwrap_or(true);
        let (subdivision, edge_length) = (desc.subdivision.clone(), desc.edge_length);
        let by = Refined { subdivision, edge_length, displacement, smooth };
        self.made(Recipe::Refined(asset.data.clone(), Box::new(by.clone())), |cache| {
            let mut data = asset.data.clone();
            if let Some(subdivision) = &by.subdivision {
                data = Arc::new(cache.subdivided(&data, subdivision)?);
            }
            if by.edge_length.is_some() || by.displacement.is_some() {
                let refinement = Refinement {
                    displacement: by.displacement.as_ref().map(|(by, image)| (*by, &**image)),
                    edge_length: by.edge_length,
                    curved: by.subdivision.is_some(),
                    smooth,
                };
                data = Arc::new(refinement.apply(&data, &cache.options().limits)?);
            }
            Ok(TriangleMesh::without_tree(&data, smooth)?.0)
        })
    }

    fn subdivided(&mut self, data: &MeshData, by: &Subdivision) -> Result<MeshData, SceneError> {
        let subdivided = subdivide(data, by, &self.options().limits)?;
        if subdivided.omitted > 0 {
            let count = subdivided.omitted;
            let faces = if count == 1 { "face" } else { "faces" };
            self.warn(format!(
                "{count} {faces} of a subdivided mesh omitted: they meet themselves, or have a vertex that is not finite"
            ));
        }
        Ok(subdivided.mesh)
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
