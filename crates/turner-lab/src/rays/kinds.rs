//! The kinds of rays in a rendering.

use turner_bvh::generate::{Scene, rays};

use super::measure::{Contender, Query, RaySet, all_answers};

/// Ambient-occlusion rays reach this fraction of the scene's extent.
const REACH: f32 = 0.07;

/// The purpose of rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Kind {
    /// Camera rays
    Primary,
    /// Camera rays, as coherent packets
    PrimaryCoherent,
    /// Shadow rays from visible points to a point light
    Shadow,
    /// Shadow rays, as coherent packets
    ShadowCoherent,
    /// Cosine-distributed rays from visible points
    Diffuse,
    /// Like diffuse, but short, and any hit counts
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

    /// How the rays are passed to a tracer that supports several ways.
    pub(super) fn query(self) -> Query {
        match self {
            Kind::PrimaryCoherent | Kind::ShadowCoherent => Query::Coherent,
            Kind::Primary | Kind::Shadow | Kind::Diffuse | Kind::Ambient => Query::Batch,
        }
    }
}

/// All rays of a rendering of a scene.
pub(super) struct Picture {
    primary: RaySet,
    shadow: RaySet,
    diffuse: RaySet,
    ambient: RaySet,
}

impl Picture {
    /// `tracer` finds the visible points.
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
