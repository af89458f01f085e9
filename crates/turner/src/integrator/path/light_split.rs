//! Emission, direct and indirect light of each sample, told apart.
//!
//! In each round of a batch, what a sample gains depends on how often its path has been scattered before:
//!
//! | bounces before | found by the ray itself | light sampled at the vertex |
//! |---|---|---|
//! | 0 | emission | direct |
//! | 1 | direct | indirect |
//! | more | indirect | indirect |
//!
//! So the parts are differences of the radiance before and after the steps of a round. Light of photons and of shared
//! paths is indirect.

use super::path_batch::Path;
use crate::color::Spectrum;
use crate::integrator::{LightParts, Radiance};

/// The parts of the light of a batch, if they are asked for.
#[derive(Default)]
pub(super) struct LightSplit {
    on: bool,
    /// Whether any path of this round has been scattered less than twice.
    active: bool,
    /// For each sample: its bounces before this round.
    bounces: Vec<u32>,
    /// For each sample: its radiance before the step.
    before: Vec<Spectrum>,
    /// For each sample: the light of photons in this step.
    photons: Vec<Spectrum>,
    parts: Vec<LightParts>,
}

impl LightSplit {
    /// Asks for the parts of the following batches.
    pub(super) fn turn_on(&mut self) {
        self.on = true;
    }

    /// The parts of the last batch.
    pub(super) fn parts(&self) -> &[LightParts] {
        &self.parts
    }

    /// Begins a batch.
    pub(super) fn begin(&mut self, count: usize) {
        if !self.on {
            return;
        }
        self.bounces.resize(count, 0);
        self.before.resize(count, Spectrum::BLACK);
        self.photons.resize(count, Spectrum::BLACK);
        self.parts.clear();
        self.parts.resize(count, LightParts::default());
    }

    /// Begins a round of these samples.
    pub(super) fn begin_round(&mut self, samples: &[u32], paths: &[Path], out: &[Radiance]) {
        self.active = false;
        if !self.on {
            return;
        }
        for &sample in samples {
            let i = sample as usize;
            self.bounces[i] = paths[i].bounces.total;
            self.before[i] = out[i].color;
            self.photons[i] = Spectrum::BLACK;
            self.active |= self.bounces[i] < 2;
        }
    }

    /// Photons have added light to a sample.
    pub(super) fn gathered(&mut self, sample: u32, added: Spectrum) {
        // The guides of the denoiser ask for it after more bounces, too.
        if self.on {
            self.photons[sample as usize] += added;
        }
    }

    /// The light of photons that a sample has gained in this step.
    pub(super) fn photons(&self, sample: u32) -> Spectrum {
        self.photons.get(sample as usize).copied().unwrap_or_default()
    }

    /// The vertices of a round are shaded; the light that they sample is not yet added.
    pub(super) fn shaded(&mut self, samples: &[u32], out: &[Radiance]) {
        if !self.active {
            return;
        }
        for &sample in samples {
            let i = sample as usize;
            let gained = out[i].color - self.before[i] - self.photons[i];
            match self.bounces[i] {
                0 => self.parts[i].emission += gained,
                1 => self.parts[i].direct += gained,
                _ => {}
            }
            self.before[i] = out[i].color;
        }
    }

    /// The light that the vertices of a round sample is added.
    pub(super) fn lit(&mut self, samples: &[u32], out: &[Radiance]) {
        if !self.active {
            return;
        }
        for &sample in samples {
            let i = sample as usize;
            if self.bounces[i] == 0 {
                self.parts[i].direct += out[i].color - self.before[i];
            }
        }
    }
}
