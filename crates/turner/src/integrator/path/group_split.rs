//! The light of each light group, told apart.
//!
//! Wherever light is added to a sample, the light or emissive object that it comes from is known: at a hit, at a ray that
//! leaves the scene, at a shadow ray, at a photon. Its group gets the same amount. Light of no group is what remains of
//! the sample, so it is not summed here.

use super::path_batch::Path;
use super::shared_paths::Destination;
use crate::color::Spectrum;
use crate::scene::Scene;
use crate::scene::light_sample::LightSample;

/// No light group.
pub(super) const NO_GROUP: u32 = u32::MAX;

/// The light of each group in each sample of a batch, if it is asked for.
#[derive(Default)]
pub(super) struct GroupSplit {
    /// The number of groups; 0 if they are not asked for.
    groups: usize,
    /// For each sample, the light of each group.
    light: Vec<Spectrum>,
    /// The same for the radiance of shared paths, and for direct light at their second vertices that is told apart.
    donated: Vec<Spectrum>,
    direct: Vec<Spectrum>,
    /// The group of each shadow ray of the round.
    shadow_rays: Vec<u32>,
    /// What one ray that leaves the scene finds, or the photons around one vertex bring: group and radiance.
    found: Vec<(u32, Spectrum)>,
}

impl GroupSplit {
    /// Asks for the groups of a scene in the following batches.
    pub(super) fn turn_on(&mut self, scene: &Scene) {
        self.groups = scene.light_groups.names().len();
    }

    /// The light of the last batch: for each sample one value for each group.
    pub(super) fn light(&self) -> &[Spectrum] {
        &self.light
    }

    /// Begins a batch.
    pub(super) fn begin(&mut self, samples: usize) {
        if self.groups == 0 {
            return;
        }
        for light in [&mut self.light, &mut self.donated, &mut self.direct] {
            light.clear();
            light.resize(samples * self.groups, Spectrum::BLACK);
        }
    }

    /// The group of a sampled light.
    #[inline]
    pub(super) fn of_sample(&self, scene: &Scene, lit: &LightSample) -> u32 {
        if self.groups == 0 {
            return NO_GROUP;
        }
        let groups = &scene.light_groups;
        groups.of_light(lit.light).or_else(|| scene.light_group_of(lit.primitive)).unwrap_or(NO_GROUP)
    }

    /// A path found light of an object.
    #[inline]
    pub(super) fn hit(&mut self, scene: &Scene, sample: u32, path: &Path, primitive: u32, light: Spectrum) {
        if self.groups > 0
            && let Some(group) = scene.light_group_of(primitive)
        {
            self.add(sample, path.destination(), group, light);
        }
    }

    /// Light of a group is part of what one ray, or one vertex, finds.
    #[inline]
    pub(super) fn find(&mut self, group: u32, radiance: Spectrum) {
        if self.groups > 0 && group != NO_GROUP {
            self.found.push((group, radiance));
        }
    }

    /// The same, by the index of the light.
    #[inline]
    pub(super) fn find_light(&mut self, scene: &Scene, light: u32, radiance: Spectrum) {
        if self.groups > 0 {
            self.find(scene.light_groups.of_light(light).unwrap_or(NO_GROUP), radiance);
        }
    }

    /// What was found contributes by this factor; it is forgotten.
    #[inline]
    pub(super) fn add_found(&mut self, sample: u32, path: &Path, factor: Spectrum) {
        while let Some((group, radiance)) = self.found.pop() {
            self.add(sample, path.destination(), group, radiance * factor);
        }
    }

    /// The group of the next shadow ray.
    #[inline]
    pub(super) fn push_shadow_ray(&mut self, group: u32) {
        if self.groups > 0 {
            self.shadow_rays.push(group);
        }
    }

    /// The light of a shadow ray of the round arrives.
    #[inline]
    pub(super) fn arrived(&mut self, ray: usize, sample: u32, to: Destination, light: Spectrum) {
        if let Some(&group) = self.shadow_rays.get(ray)
            && group != NO_GROUP
        {
            self.add(sample, to, group, light);
        }
    }

    /// Ends a round.
    #[inline]
    pub(super) fn end_round(&mut self) {
        self.shadow_rays.clear();
    }

    /// A sample receives a fraction of the radiance of a shared path, or of the direct light at its second vertex.
    #[inline]
    pub(super) fn share(&mut self, from: u32, to: u32, direct: bool, fraction: Spectrum) {
        let (from, to) = (from as usize * self.groups, to as usize * self.groups);
        for group in 0..self.groups {
            let given = if direct { &self.direct } else { &self.donated };
            self.light[to + group] += fraction * given[from + group];
        }
    }

    fn add(&mut self, sample: u32, to: Destination, group: u32, light: Spectrum) {
        let all = match to {
            Destination::Sample => &mut self.light,
            Destination::Donated => &mut self.donated,
            Destination::Direct => &mut self.direct,
        };
        all[sample as usize * self.groups + group as usize] += light;
    }
}
