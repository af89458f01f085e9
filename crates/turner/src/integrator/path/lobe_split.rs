//! The light of each sample by the lobe of the first surface that scatters it, told apart.
//!
//! Let the first surface on the way of a path scatter light by the BSDF f = f_d + f_s: diffuse reflection, and all other
//! reflection. Of the light that arrives from one direction there, the layer "diffuse" gets the fraction f_d / f, band by band,
//! and "specular" the rest; all light that crosses the surface belongs to "transmission". The fraction is known twice: in the
//! direction of the light that is sampled, and in the direction in which the path continues. All light that the path finds
//! later comes from the latter direction.
//!
//! Like [`LightSplit`](super::light_split), this measures how the radiance changes in the steps of a round. Light of photons at
//! the first surface and of shared paths is what remains: it is indirect and reflected diffusely.

use super::path_batch::Path;
use super::shared_paths::Destination;
use crate::color::Spectrum;
use crate::integrator::{LobeParts, Radiance};
use crate::material::vertex::Vertex;
use crate::math::DVec3;

/// How the first surface scatters light from one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Share {
    /// By reflection, of which this fraction is diffuse.
    Reflected(Spectrum),
    /// By transmission.
    Transmitted,
    /// By a medium.
    Volume,
}

impl Share {
    /// All of it by diffuse reflection, or none of it.
    pub(super) fn lobe(is_diffuse: bool) -> Share {
        Share::Reflected(if is_diffuse { Spectrum::WHITE } else { Spectrum::BLACK })
    }

    /// That of a direction in the frame of a vertex, on its own side (`crosses` is false) or on the other.
    pub(super) fn of_vertex(v: &Vertex<'_>, wi: DVec3, crosses: bool) -> Share {
        if crosses { Share::Transmitted } else { Share::Reflected(v.bsdf.diffuse_fraction(wi)) }
    }
}

/// The parts by lobes of the light of a batch, if they are asked for.
#[derive(Default)]
pub(super) struct LobeSplit {
    on: bool,
    /// For each sample: its bounces before this round.
    bounces: Vec<u32>,
    /// For each sample: its radiance before the step.
    before: Vec<Spectrum>,
    /// For each sample: the share of the light from the direction in which its path leaves its first surface.
    continues: Vec<Share>,
    /// The share of each shadow ray of the round.
    shadow_rays: Vec<Share>,
    parts: Vec<LobeParts>,
}

impl LobeSplit {
    /// Whether the parts are asked for.
    #[inline]
    pub(super) fn is_on(&self) -> bool {
        self.on
    }

    /// Asks for the parts of the following batches.
    pub(super) fn turn_on(&mut self) {
        self.on = true;
    }

    /// The parts of the last batch.
    pub(super) fn parts(&self) -> &[LobeParts] {
        &self.parts
    }

    /// Whether the path of a sample is at its first surface, which then has to say how it scatters light.
    #[inline]
    fn is_first(&self, sample: u32) -> bool {
        self.on && self.bounces[sample as usize] == 0
    }

    /// The next shadow ray of a sample; `share` is asked for at its first surface.
    #[inline]
    pub(super) fn push_shadow_ray(&mut self, sample: u32, share: impl FnOnce() -> Share) {
        if self.on {
            let known = self.continues[sample as usize];
            self.shadow_rays.push(if self.is_first(sample) { share() } else { known });
        }
    }

    /// A path leaves a vertex; `share` is asked for at its first surface.
    #[inline]
    pub(super) fn leaves(&mut self, sample: u32, share: impl FnOnce() -> Share) {
        if self.is_first(sample) {
            self.continues[sample as usize] = share();
        }
    }

    /// Begins a batch.
    pub(super) fn begin(&mut self, count: usize) {
        if !self.on {
            return;
        }
        self.bounces.resize(count, 0);
        self.before.resize(count, Spectrum::BLACK);
        self.continues.clear();
        self.continues.resize(count, Share::lobe(true));
        self.shadow_rays.clear();
        self.parts.clear();
        self.parts.resize(count, LobeParts::default());
    }

    /// Begins a round of these samples.
    pub(super) fn begin_round(&mut self, samples: &[u32], paths: &[Path], out: &[Radiance]) {
        if !self.on {
            return;
        }
        for &sample in samples {
            let i = sample as usize;
            self.bounces[i] = paths[i].bounces.total;
            self.before[i] = out[i].color;
        }
    }

    /// Photons have added light to a sample.
    pub(super) fn gathered(&mut self, sample: u32, added: Spectrum) {
        if !self.on {
            return;
        }
        let i = sample as usize;
        self.before[i] += added;
        if self.bounces[i] > 0 {
            self.add(i, self.continues[i], added, false);
        }
    }

    /// The vertices of a round are shaded; the light of shadow rays is not yet added.
    pub(super) fn shaded(&mut self, samples: &[u32], out: &[Radiance]) {
        if !self.on {
            return;
        }
        for &sample in samples {
            let i = sample as usize;
            let gained = out[i].color - self.before[i];
            // Without a bounce it is emission.
            if self.bounces[i] > 0 {
                self.add(i, self.continues[i], gained, self.bounces[i] == 1);
            }
        }
    }

    /// The light of a shadow ray of the round arrives.
    #[inline]
    pub(super) fn arrived(&mut self, ray: usize, sample: u32, to: Destination, light: Spectrum) {
        if let Some(&share) = self.shadow_rays.get(ray)
            && to == Destination::Sample
        {
            self.add(sample as usize, share, light, self.bounces[sample as usize] == 0);
        }
    }

    /// Ends a round.
    #[inline]
    pub(super) fn end_round(&mut self) {
        self.shadow_rays.clear();
    }

    fn add(&mut self, sample: usize, share: Share, light: Spectrum, is_direct: bool) {
        let parts = &mut self.parts[sample];
        match share {
            Share::Transmitted => parts.transmission += light,
            Share::Volume => parts.volume += light,
            Share::Reflected(diffuse) => {
                let of_diffuse = light * diffuse;
                if is_direct {
                    parts.direct_diffuse += of_diffuse;
                    parts.direct_specular += light - of_diffuse;
                } else {
                    // What is diffuse remains.
                    parts.indirect_specular += light - of_diffuse;
                }
            }
        }
    }
}
