//! Correctness of the BSDFs: samples against densities, energy, reciprocity, extreme parameters.

mod coat_normal;
mod disney;
mod energy;
mod hair;
mod lobes;
mod measured;
mod robustness;
mod statistics;
mod symmetry;
