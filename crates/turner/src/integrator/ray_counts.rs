//! The number of rays and of bounces of each sample.

/// The number of rays of each sample of a batch, for the AOV `cost`: the camera ray, the rays that continue its path, its
/// shadow rays, and the rays that join its path to those of other samples. And the number of bounces of its path.
#[derive(Default)]
pub(super) struct RayCounts {
    counts_rays: bool,
    counts_bounces: bool,
    rays: Vec<u32>,
    bounces: Vec<u32>,
}

impl RayCounts {
    /// Counts rays, bounces or both of the following batches.
    pub(super) fn turn_on(&mut self, rays: bool, bounces: bool) {
        self.counts_rays |= rays;
        self.counts_bounces |= bounces;
    }

    /// The numbers of rays of the last batch.
    pub(super) fn rays(&self) -> &[u32] {
        &self.rays
    }

    /// The numbers of bounces of the last batch.
    pub(super) fn bounces(&self) -> &[u32] {
        &self.bounces
    }

    /// Begins a batch.
    pub(super) fn begin(&mut self, samples: usize) {
        for (list, _) in [(&mut self.rays, self.counts_rays), (&mut self.bounces, self.counts_bounces)]
            .into_iter()
            .filter(|(_, on)| *on)
        {
            list.clear();
            list.resize(samples, 0);
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

    /// Counts one ray of each of these samples, whose paths are continued by it. `bounces` is the number of bounces of a
    /// sample's path.
    pub(super) fn begin_round(&mut self, samples: &[u32], bounces: impl Fn(usize) -> u32) {
        if self.counts_rays {
            samples.iter().for_each(|sample| self.add(*sample));
        }
        if self.counts_bounces {
            for &sample in samples {
                let i = sample as usize;
                self.bounces[i] = bounces(i);
            }
        }
    }
}
