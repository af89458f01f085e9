//! The hits of camera rays.

use crate::scene::Hit;

/// What the camera rays of a batch hit, so that AOVs need not trace them again.
#[derive(Default)]
pub(in crate::integrator) struct FirstHits {
    on: bool,
    /// Whether the next hits are those of camera rays.
    is_next: bool,
    hits: Vec<Option<Hit>>,
}

impl FirstHits {
    /// Keeps the hits of the following batches.
    pub(in crate::integrator) fn turn_on(&mut self, on: bool) {
        self.on |= on;
    }

    /// Begins a batch.
    pub(in crate::integrator) fn begin(&mut self) {
        self.is_next = self.on;
    }

    /// Keeps hits, if they are the first ones of a batch: one for each sample.
    #[inline]
    pub(in crate::integrator) fn found(&mut self, hits: &[Option<Hit>]) {
        if std::mem::take(&mut self.is_next) {
            self.hits.clear();
            self.hits.extend_from_slice(hits);
        }
    }

    /// The hits of the last batch, before media and opacity; empty if they were not kept.
    pub(in crate::integrator) fn hits(&self) -> &[Option<Hit>] {
        &self.hits
    }
}
