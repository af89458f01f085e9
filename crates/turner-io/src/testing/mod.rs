//! Generated test files: the mesh and the environment map of `scenes/peers/s4.toml`, which other renderers get
//! as well, and one seed file per format.

mod draco_seed;
mod mitsuba_seeds;
mod noisy_sphere;
pub mod seeds;
mod sky;
pub(crate) mod usd_seed;
pub(crate) mod vdb_seed;
mod waves;

pub use noisy_sphere::noisy_sphere_ply;
pub use sky::sky_exr;
