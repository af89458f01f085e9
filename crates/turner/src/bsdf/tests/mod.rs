//! Truth of the BSDFs: statistics against densities, energy, reciprocity, hostile numbers.

mod coat_normal;
mod energy;
mod lobes;
mod robustness;
mod statistics;
mod symmetry;
