//! The steps of a preparation: progress and cancellation.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::integrator::Integrator;

/// Options of an update.
#[derive(Clone, Copy, Default)]
pub struct UpdateOptions<'a> {
    /// Replaces the description's integrator.
    pub integrator: Option<&'a dyn Integrator>,
    /// Set to true, it cancels the update between steps or BVHs of meshes. Results so far stay cached.
    pub cancel: Option<&'a AtomicBool>,
    /// Called at the beginning of each step.
    pub progress: Option<&'a dyn Fn(PrepareStep)>,
}

impl UpdateOptions<'_> {
    pub(super) fn is_cancelled(&self) -> bool {
        self.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed))
    }

    pub(super) fn begin(&self, step: PrepareStep) {
        if let Some(progress) = self.progress {
            progress(step);
        }
    }

    /// Begins a step. Returns whether the update is cancelled.
    pub(super) fn step(&self, step: PrepareStep) -> bool {
        self.begin(step);
        self.is_cancelled()
    }
}

/// The steps of a preparation, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PrepareStep {
    /// Textures and their mipmaps, materials, media.
    Surfaces,
    /// Lights and the sampling tables of environments.
    Lights,
    /// Objects placed in the world.
    Objects,
    /// BVHs of meshes and over objects.
    Trees,
    /// The light tree.
    LightTree,
    /// Camera, film and integrator.
    View,
}
