//! The rays of a round, and those that wait for theirs.

use super::radiance::{Task, Tree};
use crate::math::Ray;
use crate::scene::RayBatch;

/// A ray on the stack of its sample.
pub(super) struct Waiting {
    pub(super) ray: Ray,
    pub(super) task: Task,
    /// The element below it on the stack, as in `Tree::waiting`.
    pub(super) next: Option<u32>,
}

/// The rays of one round: at most one per sample.
#[derive(Default)]
pub(super) struct RayQueue {
    pub(super) rays: RayBatch,
    pub(super) tasks: Vec<Task>,
}

impl RayQueue {
    pub(super) fn clear(&mut self) {
        self.rays.clear();
        self.tasks.clear();
    }

    #[inline]
    pub(super) fn push(&mut self, ray: &Ray, task: Task) {
        self.rays.push(ray);
        self.tasks.push(task);
    }
}

/// Pops the stack of a sample, if it is not empty, into the next queue.
#[inline]
pub(super) fn resume(tree: &mut Tree, waiting: &mut [Waiting], next: &mut RayQueue) {
    if let Some(i) = tree.waiting {
        let Waiting { ray, task, next: behind } = &waiting[i as usize];
        tree.waiting = *behind;
        next.push(ray, *task);
    }
}
