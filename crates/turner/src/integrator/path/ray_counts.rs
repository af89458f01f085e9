//! The number of rays of each sample.

/// The number of rays of each sample of a batch, for the AOV `cost`: the camera ray, the rays that continue its path, its
/// shadow rays, and the rays that join its path to those of other samples.
#[derive(Default)]
pub(super) struct RayCounts {
    on: bool,
    rays: Vec<u32>,
}

impl RayCounts {
    /// Counts the rays of the following batches.
    pub(super) fn turn_on(&mut self, on: bool) {
        self.on |= on;
    }

    /// The counts of the last batch.
    pub(super) fn rays(&self) -> &[u32] {
        &self.rays
    }

    /// Begins a batch.
    pub(super) fn begin(&mut self, samples: usize) {
        if self.on {
            self.rays.clear();
            self.rays.resize(samples, 0);
        }
    }

    /// Counts one ray of a sample.
    #[inline]
    pub(super) fn add(&mut self, sample: u32) {
        self.add_many(sample, 1);
    }

    /// Counts several rays of a sample.
    #[inline]
    pub(super) fn add_many(&mut self, sample: u32, rays: u32) {
        if let Some(count) = self.rays.get_mut(sample as usize) {
            *count = count.saturating_add(rays);
        }
    }

    /// Counts one ray of each of these samples.
    pub(super) fn add_all(&mut self, samples: &[u32]) {
        if self.on {
            samples.iter().for_each(|sample| self.add(*sample));
        }
    }
}
