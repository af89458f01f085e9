//! Classic recursive ray tracing: the five documents' programs as one, with named settings.
//!
//! Whitted 1980, "An improved illumination model for shaded display"; docs/reference/classic.md says which settings make
//! which document.

mod notes;
mod points;
mod prepared;
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
    /// What a ray beyond the depth limit returns.
    pub enum AtDepth {
        /// The background's colour.
        Background = "background",
        /// Black.
        Black = "black",
        /// The ambient light.
        Ambient = "ambient",
        /// There is no such ray: at the limit a surface shows its local colour alone, with weight 1.
        Local = "local",
    }
}

choice! {
    /// What a ray that hits nothing returns.
    pub enum Miss {
        /// The background's colour.
        Background = "background",
        /// Black.
        Black = "black",
    }
}

choice! {
    /// The weight of the local colour of materials that do not say it (`k_local`).
    pub enum Combine {
        /// What reflection and refraction leave of 1.
        Blend = "blend",
        /// 1: the coefficients simply add.
        Add = "add",
    }
}

choice! {
    /// The colour of highlights.
    pub enum Highlight {
        /// The light's.
        Light = "light",
        /// The light's times the material's.
        Material = "material",
    }
}

choice! {
    /// Which way the normal of the shading rule points.
    pub enum Facing {
        /// BsdfFromWo the viewer, so that surfaces are lit from the side they are seen from.
        Viewer = "viewer",
        /// Out of the shape, as document 004 has it: seen from inside, a surface is lit by what is outside.
        Outward = "outward",
    }
}

params! {
    /// Classic recursive ray tracing (Whitted 1980): local colour by ambient, diffuse and highlight terms with shadow rays, mirror reflection, refraction.
    pub struct ClassicDesc as "classic" {
        /// How many times a ray may be reflected or refracted.
        max_depth: u32 = 5, in Range::closed(0.0, 100000.0);
        /// What a ray beyond that returns.
        at_depth: AtDepth = AtDepth::Background;
        /// What a ray that hits nothing returns.
        miss: Miss = Miss::Background;
        /// The weight of the local colour of materials without `k_local`.
        combine: Combine = Combine::Blend;
        /// The colour of highlights.
        highlight: Highlight = Highlight::Light;
        /// Which way the normal points in N·L and R·V.
        facing: Facing = Facing::Viewer;
        /// Whether a ray that misses and looks along a directional light sees the light's colour.
        light_seen: bool = false;
        /// Share of a light that reaches points in shadow: the paper's factor.
        shadow_factor: f64 = 0.0, in Range::UNIT;
        /// Rays that leave a surface count hits from this t on, as the documents measure it: in units of the camera's vector from eye to screen for reflected and refracted rays, of the vector to the light (as given, for a directional light) for shadow rays. 0 instead moves the start off the surface by the precision of the hit.
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
        /// Rays one camera sample may spawn at most; what goes beyond is dropped and counted.
        max_rays: u32 = 16384, in Range::closed(1.0, 4294967295.0);
    }
    example r#"[integrator]
type = "classic"
max_depth = 3
at_depth = "local"
shadows = true
"#
}
