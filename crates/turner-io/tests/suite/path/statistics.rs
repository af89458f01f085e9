//! Means of pictures and how sure they are.

use turner::schema::PrepareOptions;
use turner::testing::{CompareOptions, Estimate, Reference, Runs, compare, render_runs};

use crate::classic::common::describe;

/// Independent renders of one scene.
#[derive(Clone, Debug)]
pub(crate) struct Mean(Runs);

/// Runs of a scene of which all pixels look at the same thing.
const RUNS: u32 = 8;

/// Of a scene without film; 6 × 6 pixels.
pub(crate) fn mean(samples: u32, text: &str) -> Mean {
    mean_of(6, samples, text)
}

pub(crate) fn mean_of(size: u32, samples: u32, text: &str) -> Mean {
    let film = format!(
        "film.width = {size}\nfilm.height = {size}\nfilm.antialias = \"monte-carlo\"\nfilm.samples = {samples}\n"
    );
    let scene = describe(&(film + text)).prepare(&PrepareOptions::default()).unwrap();
    let runs = render_runs(&scene, RUNS, 7, 2).unwrap();
    assert_eq!(runs.non_finite.count, 0);
    Mean(runs)
}

/// How probable chance must be to count as chance: of some hundred comparisons, one in a thousand runs fails with other seeds.
const LEVEL: f64 = 1e-5;

impl Mean {
    /// In the three bands.
    pub(crate) fn value(&self) -> [f64; 3] {
        [0, 1, 2].map(|band| self.0.mean(band).mean)
    }

    /// Standard errors of the bands.
    pub(crate) fn error(&self) -> [f64; 3] {
        [0, 1, 2].map(|band| self.0.mean(band).error())
    }

    /// The colour everywhere, with a standard error of no more than `cap` times its value: a noisy test cannot pass.
    #[track_caller]
    pub(crate) fn is(&self, expected: [f64; 3], cap: f64) {
        let (width, height) = self.0.size();
        self.matches(&Reference::constant(width, height, expected), cap);
    }

    #[track_caller]
    pub(crate) fn is_grey(&self, expected: f64, cap: f64) {
        self.is([expected; 3], cap);
    }

    /// Two estimates of one picture.
    #[track_caller]
    pub(crate) fn agrees(&self, other: &Mean, cap: f64) {
        self.matches(&other.0, cap);
    }

    #[track_caller]
    fn matches(&self, other: &dyn Estimate, cap: f64) {
        // Sums of colours are of single precision.
        let options = CompareOptions { tolerance: 4e-6, absolute: 1e-9, ..CompareOptions::default() };
        let found = compare(&self.0, other, &options);
        assert!(found.ratio_error <= cap + 1e-6, "too noisy: {found:?}");
        assert!(found.p_value > LEVEL, "{found:?}");
    }
}
