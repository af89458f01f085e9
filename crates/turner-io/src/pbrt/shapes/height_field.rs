//! Height fields of pbrt-v3.

use turner::schema::MeshData;

use super::super::assembly::Assembly;
use super::super::params::Params;
use super::super::report::Fault;
use super::super::state::State;
use super::light_parts::LightParts;
use super::{Made, orient};

/// `heightfield`: `nu` by `nv` heights over the unit square.
pub(super) fn surface(scene: &mut Assembly<'_>, state: &State, params: &Params) -> Result<Made, Fault> {
    let [nu, nv] = ["nu", "nv"].map(|name| params.integer(name).unwrap_or(0).max(0) as usize);
    let heights = params.floats("Pz");
    if nu < 2 || nv < 2 || nu.checked_mul(nv) != Some(heights.len()) {
        let message =
            format!("a heightfield of {nu} x {nv} vertices with {} heights: omitted", heights.len());
        scene.report.ignored(params.place, message);
        return Ok(Made::Nothing);
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
    orient(&mut data, state.reverse);
    Ok(Made::Mesh(data, LightParts::Triangles))
}
