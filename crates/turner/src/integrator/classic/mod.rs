//! Classic recursive ray tracing: one integrator for the programs of five documents, with a setting for each
//! difference.
//!
//! Whitted 1980, "An Improved Illumination Model for Shaded Display". docs/reference/classic.md lists the
//! settings that reproduce each document.

mod gather;
mod notes;
mod points;
mod prepared;
mod queue;
mod radiance;
mod record;
mod replay;
mod shade;
mod spawn;
#[cfg(test)]
mod tests;

pub use record::{
    CutReason, CutRecord, HitRecord, LightTerm, MAX_WRITTEN, MissRecord, RayEnd, RayKind, RayRecord, Seen,
    ShadowRecord, TreeRecord,
};
pub use replay::{replay, replay_at};

use crate::schema::{Range, choice, params};

choice! {
    /// The value of a ray beyond the depth limit.
    pub enum AtDepth {
        /// The background colour.
        Background = "background",
        /// Black.
        Black = "black",
        /// The ambient light.
        Ambient = "ambient",
        /// No such ray is traced: at the limit a surface shows only its local colour, with weight 1.
        Local = "local",
    }
}

choice! {
    /// The value of a ray that hits nothing.
    pub enum Miss {
        /// The background colour.
        Background = "background",
        /// Black.
        Black = "black",
    }
}

choice! {
    /// The weight of the local colour of materials without `k_local`.
    pub enum Combine {
        /// 1 minus the weights of reflection and refraction.
        Blend = "blend",
        /// 1: all terms are simply added.
        Add = "add",
    }
}

choice! {
    /// The colour of highlights.
    pub enum Highlight {
        /// The colour of the light.
        Light = "light",
        /// The colour of the light times that of the material.
        Material = "material",
    }
}

choice! {
    /// The direction of the normal in the shading model.
    pub enum Facing {
        /// Towards the viewer: surfaces are lit from the visible side.
        Viewer = "viewer",
        /// Out of the shape, as in document 004: a surface seen from inside is lit by the lights outside.
        Outward = "outward",
    }
}

params! {
    /// Classic recursive ray tracing (Whitted 1980): local colour from ambient, diffuse and highlight terms with
    /// shadow rays, plus mirror reflection and refraction.
    pub struct ClassicDesc as "classic" {
        /// The maximum number of reflections and refractions along a ray path.
        max_depth: u32 = 5, in Range::closed(0.0, 100000.0);
        /// The value of a ray beyond `max_depth`.
        at_depth: AtDepth = AtDepth::Background;
        /// The value of a ray that hits nothing.
        miss: Miss = Miss::Background;
        /// The weight of the local colour of materials without `k_local`.
        combine: Combine = Combine::Blend;
        /// The colour of highlights.
        highlight: Highlight = Highlight::Light;
        /// The direction of the normal N in N·L and R·V.
        facing: Facing = Facing::Viewer;
        /// Whether a ray that hits nothing and points towards a directional light returns the colour of that
        /// light.
        light_seen: bool = false;
        /// Fraction of a light that reaches points in shadow: the shadow factor of document 002.
        shadow_factor: f64 = 0.0, in Range::UNIT;
        /// Secondary rays ignore hits with t below this value. As in the documents, t counts in lengths of the
        /// ray's direction vector: for reflected and refracted rays the camera's vector from the viewpoint to the
        /// screen, for shadow rays the vector to the light (for a directional light, its vector as given). With
        /// 0, the ray origin is moved off the surface by the numerical error of the hit instead.
        epsilon: f64 = 0.0, in Range::NON_NEGATIVE;
        /// Whether the ambient term counts.
        ambient: bool = true;
        /// Whether the diffuse term counts.
        diffuse: bool = true;
        /// Whether highlights count.
        highlights: bool = true;
        /// Whether objects cast shadows.
        shadows: bool = true;
        /// Whether surfaces reflect.
        reflection: bool = true;
        /// Whether surfaces refract.
        refraction: bool = true;
        /// The maximum number of reflected and refracted rays per camera sample. Further rays are dropped and
        /// counted.
        max_rays: u32 = 16384, in Range::closed(1.0, 4294967295.0);
    }
    example r#"[integrator]
type = "classic"
max_depth = 3
at_depth = "local"
shadows = true
"#
}
