//! Truth of the BSDFs: statistics against densities, energy, reciprocity.

mod energy;
mod materials;
