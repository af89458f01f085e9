//! The kinds of rays of a picture.

use turner_bvh::generate::{Scene, rays};

use super::measure::{Contender, Query, RaySet, all_answers};

/// Ambient-occlusion rays reach this part of the scene's extent.
const REACH: f32 = 0.07;

/// What rays are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Kind {
    /// From the camera
    Primary,
    /// From the camera, as coherent packets
    PrimaryCoherent,
    /// From what the camera sees to a point light
    Shadow,
    /// To the light, as coherent packets
    ShadowCoherent,
    /// From what the camera sees into the half-space above
    Diffuse,
    /// As diffuse, but short and any hit will do
    Ambient,
}

impl Kind {
    pub(super) const ALL: [Kind; 6] = [
        Kind::Primary,
        Kind::PrimaryCoherent,
        Kind::Shadow,
        Kind::ShadowCoherent,
        Kind::Diffuse,
        Kind::Ambient,
    ];

    pub(super) fn name(self) -> &'static str {
        match self {
            Kind::Primary => "primary",
            Kind::PrimaryCoherent => "primary-coherent",
            Kind::Shadow => "shadow",
            Kind::ShadowCoherent => "shadow-coherent",
            Kind::Diffuse => "diffuse",
            Kind::Ambient => "ambient",
        }
    }

    /// How the rays are given to a tracer that has the choice.
    pub(super) fn query(self) -> Query {
        match self {
            Kind::PrimaryCoherent | Kind::ShadowCoherent => Query::Coherent,
            Kind::Primary | Kind::Shadow | Kind::Diffuse | Kind::Ambient => Query::Batch,
        }
    }
}

/// All rays of a picture of a scene.
pub(super) struct Picture {
    primary: RaySet,
    shadow: RaySet,
    diffuse: RaySet,
    ambient: RaySet,
}

impl Picture {
    /// What the camera sees is found by `tracer`.
    pub(super) fn new(scene: &Scene, resolution: u32, tracer: Contender<'_>) -> Picture {
        let extent = scene.extent();
        let primary = RaySet::new(rays::primary(&scene.camera, resolution), false);
        let hits = all_answers(&primary, tracer);
        let seen = primary.rays.iter().zip(&hits).filter(|(_, hit)| hit.t.is_finite());
        let points: Vec<rays::Point> = seen
            .filter_map(|(ray, hit)| rays::point(scene, extent, ray, hit.t, hit.instance, hit.primitive))
            .collect();
        Picture {
            primary,
            shadow: RaySet::new(rays::shadow(&points, scene.light), true),
            diffuse: RaySet::new(rays::diffuse(&points), false),
            ambient: RaySet::new(rays::ambient(&points, REACH * extent), true),
        }
    }

    pub(super) fn rays(&self, kind: Kind) -> &RaySet {
        match kind {
            Kind::Primary | Kind::PrimaryCoherent => &self.primary,
            Kind::Shadow | Kind::ShadowCoherent => &self.shadow,
            Kind::Diffuse => &self.diffuse,
            Kind::Ambient => &self.ambient,
        }
    }
}
