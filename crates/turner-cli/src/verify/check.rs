//! A check, its finding, and the context that checks share.

use std::sync::Mutex;

use turner::film::NonFinite;
use turner::integrator::Prepared;
use turner::schema::{ErrorCode, PrepareOptions, SceneError};
use turner::testing::{Comparison, Random, Runs, render_runs};
use turner_bvh::InstructionSet;
use turner_io::assets::{AssetSource, MemoryAssets};
use turner_io::scene::{LoadOptions, load_text};

use crate::instructions::instruction_set;

/// How many samples are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Effort {
    /// That of `turner verify`: half a minute.
    Short,
    /// Several times the samples in the checks that need them.
    Whole,
    /// Sixteen times the samples in every check.
    Long,
}

/// State that the checks share.
pub struct Context {
    /// Seed of all random numbers.
    pub seed: u64,
    /// Number of samples.
    pub effort: Effort,
    /// Threads to render with, 1 or more.
    pub threads: usize,
    /// Non-finite samples in all renders up to now, and the number of samples.
    pub rendered: Mutex<(NonFinite, u64)>,
}

/// The result of a check.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// p-value: the probability of a result at least as extreme if everything is correct. It is compared with the
    /// significance level of the run.
    Chance(f64),
    /// A value and its upper limit.
    Limit(f64, f64),
}

/// The finding of a check.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The result of a check.
    pub verdict: Verdict,
    /// The measured values, in a few words.
    pub found: String,
}

/// The function of a check.
pub type Work = dyn Fn(&Context) -> Result<Finding, SceneError>;

/// A check that can be run.
pub struct Check {
    /// `group/name`.
    pub name: String,
    /// Whether it is a statistical test, which can fail although everything is correct.
    pub by_chance: bool,
    /// Runs it. A check that returns an error fails.
    pub run: Box<Work>,
}

impl Check {
    /// A statistical test.
    pub fn chance(
        name: impl Into<String>,
        run: impl Fn(&Context) -> Result<Finding, SceneError> + 'static,
    ) -> Check {
        Check { name: name.into(), by_chance: true, run: Box::new(run) }
    }

    /// A check of a value against a limit.
    pub fn limit(
        name: impl Into<String>,
        run: impl Fn(&Context) -> Result<Finding, SceneError> + 'static,
    ) -> Check {
        Check { by_chance: false, ..Check::chance(name, run) }
    }
}

impl Finding {
    /// A statistical result with p-value `p`.
    pub fn chance(p: f64, found: impl Into<String>) -> Finding {
        Finding { verdict: Verdict::Chance(p), found: found.into() }
    }

    /// A `value` with the upper limit `limit`.
    pub fn limit(value: f64, limit: f64, found: impl Into<String>) -> Finding {
        Finding { verdict: Verdict::Limit(value, limit), found: found.into() }
    }

    /// The comparison of two pictures. It fails if the standard error, relative to the mean, exceeds `cap`: a result
    /// that noisy proves nothing.
    pub fn comparison(c: &Comparison, cap: f64) -> Finding {
        let mut found = format!("mean ratio {:.5} ± {:.5}", c.ratio, c.ratio_error);
        if c.beyond > 0.0 {
            found += &format!(", {:.2} % of pixels beyond", 100.0 * c.beyond);
        }
        let noisy = c.ratio_error.is_nan() || c.ratio_error > cap * c.ratio.abs().max(1e-30);
        if noisy {
            found += &format!("; too noisy: at most ± {cap}");
        }
        if let Some(w) = c.worst.filter(|w| w.t > 4.0) {
            let (x, y) = (w.pixels.x, w.pixels.y);
            let band = ["red", "green", "blue"].get(w.band).unwrap_or(&"");
            found += &format!(", {band} at ({x}, {y}): {:.5} for {:.5}", w.a.mean, w.b.mean);
        }
        Finding::chance(if noisy { 0.0 } else { c.p_value }, found)
    }
}

impl Context {
    /// A seed for one purpose, from the FNV-1a hash of its name.
    pub fn seed_for(&self, what: &str) -> u64 {
        let hash = what
            .bytes()
            .fold(0xcbf2_9ce4_8422_2325, |h: u64, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3));
        Random::new(self.seed ^ hash).bits()
    }

    /// `n`, or sixteen times as many for a long run.
    pub fn times(&self, n: u32) -> u32 {
        if self.effort == Effort::Long { n.saturating_mul(16) } else { n }
    }

    /// A scene from text without `[film]`.
    pub fn scene(&self, size: [u32; 2], samples: u32, text: &str) -> Result<Prepared, SceneError> {
        self.scene_with(size, samples, text, &MemoryAssets::default())
    }

    /// [`Context::scene`] with the files that the text names.
    pub fn scene_with(
        &self,
        size: [u32; 2],
        samples: u32,
        text: &str,
        assets: &dyn AssetSource,
    ) -> Result<Prepared, SceneError> {
        self.scene_by(instruction_set(), size, samples, text, assets)
    }

    /// [`Context::scene_with`] with a given instruction set.
    pub fn scene_by(
        &self,
        instruction_set: InstructionSet,
        size: [u32; 2],
        samples: u32,
        text: &str,
        assets: &dyn AssetSource,
    ) -> Result<Prepared, SceneError> {
        let text = format!(
            "film.width = {}\nfilm.height = {}\nfilm.antialias = \"monte-carlo\"\nfilm.samples = {}\n{text}",
            size[0],
            size[1],
            samples.max(2)
        );
        let loaded = load_text(text, "verify", assets, &LoadOptions::default()).map_err(|e| e.error)?;
        loaded.desc.prepare(&PrepareOptions { threads: self.threads, instruction_set, ..Default::default() })
    }

    /// Independent renders of a scene. Counts their non-finite samples.
    pub fn runs(&self, prepared: &Prepared, runs: u32, seed: &str) -> Result<Runs, SceneError> {
        let seed = self.seed_for(seed);
        let done = render_runs(prepared, runs, seed, self.threads)?;
        let samples = u64::from(done.width)
            * u64::from(done.height)
            * u64::from(prepared.view.film.samples)
            * u64::from(runs);
        self.count(&done.non_finite, samples);
        Ok(done)
    }

    /// Adds to the counts of samples and of non-finite samples.
    pub fn count(&self, non_finite: &NonFinite, samples: u64) {
        let mut rendered = self.rendered.lock().unwrap_or_else(|e| e.into_inner());
        rendered.0.merge(non_finite);
        rendered.1 += samples;
    }
}

/// An error in the suite itself.
pub fn fault(what: impl std::fmt::Display) -> SceneError {
    SceneError::new(ErrorCode::Internal, format!("{what}"))
}
