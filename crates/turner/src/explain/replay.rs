//! Traces a sample once more with the code that renders, and records it.

use super::names::Names;
use crate::color::Spectrum;
use crate::description::SceneDesc;
use crate::integrator::{IntegratorDesc, Prepared, classic, path};
use crate::math::DVec3;
use crate::render::SampleRecord;
use crate::schema::{MaterialId, SceneError};
use crate::view::camera_ray;

/// What the integrator did for one sample.
#[derive(Clone, Debug)]
pub enum Replay {
    /// The ray tree of "classic".
    Tree(Box<classic::TreeRecord>),
    /// The path of "path" or "direct".
    Path(Box<path::PathRecord>),
    /// The first hit, for all other integrators.
    FirstHit(Box<FirstHit>),
}

/// The camera ray and what it hits.
#[derive(Clone, Copy, Debug)]
pub struct FirstHit {
    /// Origin and direction; `None` outside the image of the camera.
    pub camera: Option<(DVec3, DVec3)>,
    /// The hit.
    pub hit: Option<FirstSurface>,
    /// What the integrator shows.
    pub shown: Spectrum,
}

/// The surface at the first hit.
#[derive(Clone, Copy, Debug)]
pub struct FirstSurface {
    /// Distance along the ray.
    pub t: f64,
    /// The point.
    pub position: DVec3,
    /// Geometric normal.
    pub geometric_normal: DVec3,
    /// Shading normal.
    pub shading_normal: DVec3,
    /// Texture coordinates.
    pub uv: [f64; 2],
    /// The ID of the primitive.
    pub primitive: u32,
    /// Its shape as a word.
    pub shape: &'static str,
    /// Its material.
    pub material: MaterialId,
}

impl Replay {
    /// Traces a sample again. Errors: those of the integrator's replay.
    pub fn new(prepared: &Prepared, desc: &SceneDesc, sample: &SampleRecord) -> Result<Replay, SceneError> {
        let (id, place) = (sample.id, sample.place);
        Ok(match &desc.integrator {
            IntegratorDesc::Classic(_) => Replay::Tree(Box::new(classic::replay_at(prepared, id, place)?)),
            IntegratorDesc::Path(_) | IntegratorDesc::Direct(_) => {
                Replay::Path(Box::new(path::replay_at(prepared, id, place)?))
            }
            IntegratorDesc::Normals(_)
            | IntegratorDesc::Depth(_)
            | IntegratorDesc::Position(_)
            | IntegratorDesc::Uv(_)
            | IntegratorDesc::Albedo(_)
            | IntegratorDesc::Ids(_)
            | IntegratorDesc::Wireframe(_)
            | IntegratorDesc::AmbientOcclusion(_)
            | IntegratorDesc::Cost(_)
            | IntegratorDesc::Bounces(_) => Replay::FirstHit(Box::new(FirstHit::new(prepared, sample))),
        })
    }

    /// The sum of all contributions, in the order in which they were added.
    pub fn sum(&self) -> Spectrum {
        match self {
            Replay::Tree(tree) => tree.sum(),
            Replay::Path(path) => path.sum(),
            Replay::FirstHit(first) => first.shown,
        }
    }

    /// Adds the rays to a tree.
    pub(super) fn grow(&self, out: &mut super::SampleTree, names: &Names<'_>) {
        match self {
            Replay::Tree(tree) => super::classic::grow(out, names, tree),
            Replay::Path(path) => super::path::grow(out, names, path),
            Replay::FirstHit(first) => super::first_hit::grow(out, names, first),
        }
    }
}

impl FirstHit {
    fn new(prepared: &Prepared, sample: &SampleRecord) -> FirstHit {
        let (scene, shown) = (&prepared.scene, sample.radiance.color);
        let Some(ray) = camera_ray(&prepared.view, sample.id, sample.place) else {
            return FirstHit { camera: None, hit: None, shown };
        };
        let hit = scene.intersect_from_camera(&ray).map(|hit| {
            let surface = scene.surface(&ray, &hit);
            FirstSurface {
                t: hit.shape.t,
                position: surface.p,
                geometric_normal: surface.ng,
                shading_normal: surface.ns,
                uv: scene.texture_point(&surface).uv.into(),
                primitive: scene.primitive_id(&hit),
                shape: scene.shape_word(&hit),
                material: surface.material,
            }
        });
        FirstHit { camera: Some((ray.origin, ray.direction)), hit, shown }
    }
}
