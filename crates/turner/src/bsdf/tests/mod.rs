//! Truth of the BSDFs: statistics against densities, energy, reciprocity, hostile numbers.

mod coat_normal;
mod energy;
mod materials;
mod robustness;
mod statistics;
mod symmetry;
