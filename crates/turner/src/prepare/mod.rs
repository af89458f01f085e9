//! From a description to a scene that can be rendered. A [`Preparer`] also handles edits: it caches its results
//! and prepares again only what an edit changes.
//!
//! ```text
//! SceneDesc ─┬─ textures ── mipmaps, by image ──────────────────┐
//!            ├─ materials, media ───────────────────────────────┤
//!            ├─ shapes ──── meshes and their BVHs, by mesh      ├─ Scene ─┐
//!            │    └─ placed ── objects in the world             │         │
//!            │         └─ geometry ── BVHs over objects ────────┤         ├─ Prepared
//!            ├─ lights ──── sampling tables, by environment ────┘         │
//!            ├─ camera, film ── View ─────────────────────────────────────┤
//!            └─ integrator ───────────────────────────────────────────────┘
//! ```
//!
//! Each step compares its inputs with those of the last description. If they are equal, the result is shared. So
//! the result has the same bytes as a fresh preparation after any edits.

mod count;
mod default_studio;
mod flatten;
#[cfg(test)]
mod gathered_tests;
mod geometry;
mod lights;
mod metering;
mod picture_needs;
mod placed;
mod preparer;
mod shapes;
mod steps;
#[cfg(test)]
mod studio_tests;
mod surfaces;
#[cfg(test)]
mod tests;

pub use preparer::{Preparer, Rebuilt, Update};
pub use steps::{PrepareStep, UpdateOptions};

use crate::description::SceneDesc;
use crate::film::{Antialias, Film, TextureFilter};
use crate::integrator::{Capabilities, Integrator, Prepared};
use crate::schema::{ErrorCode, PrepareOptions, SceneError, Warning, WarningKind};

impl SceneDesc {
    /// Validates the scene and builds everything that rendering needs. To prepare a scene again after edits, keep
    /// a [`Preparer`].
    ///
    /// Errors: invalid references, values out of range, not enough memory.
    pub fn prepare(&self, options: &PrepareOptions) -> Result<Prepared, SceneError> {
        self.prepare_with(self.integrator.integrator(), options)
    }

    /// The same with another integrator than the description's.
    pub fn prepare_with(
        &self,
        integrator: &dyn Integrator,
        options: &PrepareOptions,
    ) -> Result<Prepared, SceneError> {
        let prepared = self.prepare_unchosen(integrator, options)?;
        prepared.choose(options.threads);
        Ok(prepared)
    }

    /// The same without the choices of the integrator, which its first pass makes while other threads trace a preview:
    /// [`Prepared::choose`].
    pub fn prepare_unchosen(
        &self,
        integrator: &dyn Integrator,
        options: &PrepareOptions,
    ) -> Result<Prepared, SceneError> {
        let wanted = UpdateOptions { integrator: Some(integrator), ..UpdateOptions::default() };
        let update = Preparer::once(options.clone()).update_with(self, &wanted)?;
        let stopped = || SceneError::new(ErrorCode::Internal, "a preparation stopped without a cancel");
        update.map(|Update { prepared, .. }| prepared).ok_or_else(stopped)
    }

    /// Validates the film and returns its warnings.
    fn check_film(&self) -> Result<Vec<Warning>, SceneError> {
        Film::check(&self.film)?;
        let [open, close] = self.film.shutter;
        if open > close {
            let message = format!("the shutter closes at {close}, before it opens at {open}");
            return Err(SceneError::new(ErrorCode::Conflict, message).help("write shutter = [OPEN, CLOSE]"));
        }
        let message = "`filter` and `filter_radius` are ignored: they need `antialias = \"monte-carlo\"`";
        let ignored = self.film.ignores_filter().then(|| Warning::new(WarningKind::Ignored, message));
        let film = &self.film;
        let is_random = film.antialias == Antialias::MonteCarlo && film.samples > 1;
        let message = "`adaptive_sampling` is ignored: it needs `antialias = \"monte-carlo\"`, several samples per pixel and a filter within the pixel (`filter = \"box\"`)";
        let even = (film.adaptive_sampling && (!is_random || film.weights_samples()))
            .then(|| Warning::new(WarningKind::Ignored, message));
        Ok(ignored.into_iter().chain(even).collect())
    }

    /// Whether texture lookups are filtered over the footprint.
    fn filters_textures(&self, capabilities: Capabilities) -> bool {
        let wanted = match self.film.texture_filter {
            TextureFilter::Auto => capabilities.physical,
            TextureFilter::On => true,
            TextureFilter::Off => false,
        };
        wanted && !self.textures.is_empty()
    }
}
