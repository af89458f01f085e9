//! Files of test scenes that are made, not kept: the mesh and the sky of `scenes/peers/s4.toml`, as other renderers were given them.

mod mitsuba_seeds;
mod noisy_sphere;
pub mod seeds;
mod sky;
mod waves;

pub use noisy_sphere::noisy_sphere_ply;
pub use sky::sky_exr;
