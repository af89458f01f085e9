//! Scenes of pbrt-v3 (Pharr, Jakob and Humphreys, "Physically Based Rendering", 3rd edition, 2016; format:
//! pbrt.org/fileformat-v3), whose directives are those of pbrt-v4.
//!
//! A file is one of pbrt-v3 if its film is "image". Its materials have names of their own, in [`materials`]; what differs
//! elsewhere (roughness, defaults, latitude-longitude maps of lights) is beside pbrt-v4's.

mod materials;
#[cfg(test)]
mod tests;

use turner::color::Spectrum;
use turner::schema::MeshData;

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

/// The factor `scale` of a light as a number and a colour; in pbrt-v3 it may be a colour.
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

/// `heightfield`: `nu` by `nv` heights over the unit square.
pub(super) fn height_field(scene: &mut Assembly<'_>, params: &Params) -> Result<MeshData, Fault> {
    let [nu, nv] = ["nu", "nv"].map(|name| params.integer(name).unwrap_or(0).max(0) as usize);
    let heights = params.floats("Pz");
    if nu < 2 || nv < 2 || nu.checked_mul(nv) != Some(heights.len()) {
        let message =
            format!("a heightfield of {nu} x {nv} vertices with {} heights: omitted", heights.len());
        scene.report.ignored(params.place, message);
        return Ok(MeshData::default());
    }
    scene.divide(heights.len() as u64, params.place)?;
    let mut data = MeshData::default();
    for (i, z) in heights.iter().enumerate() {
        let (u, v) = ((i % nu) as f32 / (nu - 1) as f32, (i / nu) as f32 / (nv - 1) as f32);
        data.positions.push([u, v, *z as f32]);
        data.uvs.push([u, v]);
    }
    for y in 0..nv - 1 {
        for x in 0..nu - 1 {
            let at = |x: usize, y: usize| (x + y * nu) as u32;
            let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
            data.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    Ok(data)
}
