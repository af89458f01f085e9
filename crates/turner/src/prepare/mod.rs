//! From a description to what can be rendered, and from an edited description again: a [`Preparer`] keeps what it made and makes anew only what an edit
//! changes.
//!
//! ```text
//! SceneDesc ─┬─ textures ── pyramids, by picture ───────────────┐
//!            ├─ materials, media ───────────────────────────────┤
//!            ├─ shapes ──── meshes and their trees, by mesh     ├─ Scene ─┐
//!            │    └─ placed ── objects in the world             │         │
//!            │         └─ geometry ── trees over objects ───────┤         ├─ Prepared
//!            ├─ lights ──── tables of environments, by picture ─┘         │
//!            ├─ camera, film ── View ─────────────────────────────────────┤
//!            └─ integrator ───────────────────────────────────────────────┘
//! ```
//!
//! Each step is compared with the step of the last description by what goes into it, and is shared if nothing did. So the result has the bytes of a fresh
//! preparation, whatever the edits were.

mod count;
mod default_studio;
mod flatten;
#[cfg(test)]
mod gathered_tests;
mod geometry;
mod lights;
mod picture_needs;
mod placed;
mod preparer;
mod shapes;
mod surfaces;
#[cfg(test)]
mod tests;

pub use preparer::{PrepareStep, Preparer, Remade, Update, UpdateOptions};

use crate::description::SceneDesc;
use crate::film::{Film, TextureFilter};
use crate::integrator::{Capabilities, Integrator, Prepared};
use crate::schema::{ErrorCode, PrepareOptions, SceneError, Warning, WarningKind};

impl SceneDesc {
    /// Checks what only the whole scene shows and builds what rendering needs. To prepare a scene again after edits, keep a [`Preparer`].
    ///
    /// Errors: references to nothing, numbers beyond what can be traced, memory that there is not.
    pub fn prepare(&self, options: &PrepareOptions) -> Result<Prepared, SceneError> {
        self.prepare_with(self.integrator.integrator(), options)
    }

    /// The same for an integrator that takes the place of the description's.
    pub fn prepare_with(
        &self,
        integrator: &dyn Integrator,
        options: &PrepareOptions,
    ) -> Result<Prepared, SceneError> {
        let wanted = UpdateOptions { integrator: Some(integrator), ..UpdateOptions::default() };
        let update = Preparer::once(options.clone()).update_with(self, &wanted)?;
        let Some(Update { prepared, .. }) = update else {
            return Err(SceneError::new(ErrorCode::Internal, "a preparation ended that nobody cancelled"));
        };
        prepared.choose();
        Ok(prepared)
    }

    /// Checks the film; gives what there is to say about it.
    fn check_film(&self) -> Result<Vec<Warning>, SceneError> {
        Film::check(&self.film)?;
        let [open, close] = self.film.shutter;
        if open > close {
            let message = format!("the shutter closes at {close}, before it opens at {open}");
            return Err(SceneError::new(ErrorCode::Conflict, message).help("write shutter = [OPEN, CLOSE]"));
        }
        let message = "`filter` and `filter_radius` are ignored: they need `antialias = \"monte-carlo\"`";
        let ignored = self.film.ignores_filter().then(|| Warning::new(WarningKind::Ignored, message));
        Ok(ignored.into_iter().collect())
    }

    /// Whether textures are averaged over what a ray stands for.
    fn filters_textures(&self, capabilities: Capabilities) -> bool {
        let wanted = match self.film.texture_filter {
            TextureFilter::Auto => capabilities.physical,
            TextureFilter::On => true,
            TextureFilter::Off => false,
        };
        wanted && !self.textures.is_empty()
    }
}
