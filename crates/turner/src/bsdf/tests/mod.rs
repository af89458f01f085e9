//! Truth of the BSDFs: statistics against densities, energy, reciprocity, hostile numbers.

mod energy;
mod materials;
mod robustness;
mod statistics;
mod symmetry;
