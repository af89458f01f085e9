//! Scenes of pbrt-v3 (Pharr, Jakob and Humphreys, "Physically Based Rendering", 3rd edition, 2016; format:
//! pbrt.org/fileformat-v3), whose directives are those of pbrt-v4.
//!
//! A file belongs to pbrt-v3 if its film is "image". The materials with other names are in [`materials`]; other differences
//! (roughness, defaults, latitude-longitude maps of lights) are handled where pbrt-v4's features are read.

mod materials;
#[cfg(test)]
mod tests;

use turner::color::Spectrum;

use super::assembly::Assembly;
use super::params::{Params, Type};
use super::report::Fault;
use super::spectra::{Role, color};
use super::state::State;

pub(super) use materials::disney;

/// The materials that only pbrt-v3 has.
pub(super) const MATERIALS: &[&str] = &[
    "matte",
    "plastic",
    "metal",
    "glass",
    "mirror",
    "uber",
    "substrate",
    "translucent",
    "kdsubsurface",
    "disney",
    "fourier",
];

/// The `scale` of a light, as a factor and a colour: in pbrt-v3 it may be a spectrum.
pub(super) fn light_scale(
    scene: &mut Assembly<'_>,
    state: &State,
    params: &Params,
) -> Result<(f64, Spectrum), Fault> {
    if [Type::Rgb, Type::Spectrum, Type::Blackbody].iter().any(|kind| params.is("scale", *kind)) {
        let found = color(scene, state.color_space, params, "scale", Role::Light)?;
        return Ok((1.0, found.unwrap_or(Spectrum::WHITE)));
    }
    Ok((params.float("scale").unwrap_or(1.0), Spectrum::WHITE))
}
