//! Tools that check whether a render is correct, for authors of BSDFs, lights, samplers and integrators in this
//! crate or another one. `turner-lab verify` runs them at length.
//!
//! Each statistical check returns a p-value: the probability of a result at least as bad if everything is
//! correct. Of many checks each is compared with [`sidak_level`], so that all of them together raise a false
//! alarm as rarely as a single one.
//!
//! | to check | by |
//! |---|---|
//! | a sampler of directions or points against its pdf | [`chi_square_of_directions`], [`chi_square_on_square`] |
//! | a BSDF's samples and pdf | [`samples_follow_density`], [`samples_agree_with_eval`] |
//! | a BSDF's energy and reciprocity | [`albedo`], [`reciprocity_error`] |
//! | two methods that should render the same picture | [`render_runs`] of each, then [`compare`] |
//! | a picture against another renderer's, or a formula | [`render_runs`], then [`compare`] with a [`Reference`] |
//! | the error of a picture | [`relative_mse`] |
//!
//! A check of a new BSDF in a few lines; it needs an implementation of [`Scattering`]:
//!
//! ```
//! use turner::{bsdf::Bsdf, color::Spectrum, testing::*};
//! let (bsdf, wo) = (Bsdf::lambert(Spectrum::grey(0.5)), direction(0.4, 1.0));
//! assert!(samples_follow_density(&bsdf, wo, 1, &ChiSquareOptions::default()).p_value > 0.01);
//! assert!(samples_agree_with_eval(&bsdf, wo, 500).is_ok() && reciprocity_error(&bsdf, None, 500) < 1e-5);
//! assert!((albedo(&bsdf, wo, 10_000)[0] - 0.5).abs() < 1e-3);
//! ```

mod chi_square;
mod compare;
mod materials;
mod moments;
mod random;
mod runs;
mod scattering;
#[cfg(test)]
pub(crate) mod scenes;
mod tails;

pub use crate::compare::relative_mse;
pub use chi_square::{ChiSquare, ChiSquareOptions, chi_square_of_directions, chi_square_on_square};
pub use compare::{CompareOptions, Comparison, Worst, compare};
pub use materials::materials;
pub use moments::{Moments, difference};
pub use random::{Random, direction, spread};
pub use runs::{Estimate, Reference, Runs, render_runs};
pub use scattering::{
    Scattering, albedo, reciprocity_error, samples_agree_with_eval, samples_follow_density,
};
pub use tails::{
    beta_share, binomial_tail, chi_square_tail, gamma_tail, ln_gamma, normal_tails, sidak_level, smallest_of,
    student_tails,
};
