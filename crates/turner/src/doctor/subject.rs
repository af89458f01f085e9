//! The scene under examination.

use std::ops::Deref;
use std::sync::Arc;

use crate::film::FilmDesc;
use crate::integrator::{IntegratorDesc, Prepared};
use crate::scene::Scene;

/// A prepared scene with the settings of its integrator. Both can be changed without affecting the original.
#[derive(Clone)]
pub(super) struct Subject {
    /// The scene, view and integrator.
    pub(super) prepared: Prepared,
    /// The settings of the integrator.
    pub(super) integrator: IntegratorDesc,
}

impl Subject {
    pub(super) fn film(&self) -> &FilmDesc {
        &self.prepared.view.film
    }

    pub(super) fn film_mut(&mut self) -> &mut FilmDesc {
        &mut self.prepared.view.film
    }

    /// The scene, mutable; it is copied first if it is shared.
    pub(super) fn scene_mut(&mut self) -> &mut Scene {
        Arc::make_mut(&mut self.prepared.scene)
    }

    /// Changes the integrator settings. Light paths and shared paths are switched off, so that camera paths are
    /// independent of each other.
    pub(super) fn set_integrator(&mut self, mut integrator: IntegratorDesc) {
        use crate::integrator::{Caustics, SharedPathsMode};
        if let IntegratorDesc::Path(path) = &mut integrator {
            (path.shared_paths, path.caustics) = (SharedPathsMode::Off, Caustics::Off);
        }
        if let Ok(prepared) = self.prepared.with_integrator(integrator.integrator()) {
            (self.prepared, self.integrator) = (prepared, integrator);
        }
    }
}

impl Deref for Subject {
    type Target = Scene;

    fn deref(&self) -> &Scene {
        &self.prepared.scene
    }
}
