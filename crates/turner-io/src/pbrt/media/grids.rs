//! Media on grids.

use std::sync::Arc;

use turner::color::Spectrum;
use turner::math::DVec3;
use turner::medium::{GridBorder, GridMedium, MediumDesc};
use turner::schema::{ErrorCode, GridData, GridFile, GridScattering};

use super::{Common, anisotropy_of, glow_scale, scale_of};
use crate::assets::printable;
use crate::grid::MAX_GRID;
use crate::pbrt::assembly::Assembly;
use crate::pbrt::params::Params;
use crate::pbrt::report::Fault;
use crate::pbrt::source::Place;
use crate::pbrt::state::State;
use crate::scene_import::{GridBox, ROTATED_GRID};
use crate::vdb;

/// Largest coefficient.
const MOST: f64 = 1e30;

/// A grid of densities; `None` if it is damaged, which is reported.
pub(super) fn uniform(
    scene: &mut Assembly<'_>,
    state: &State,
    params: &Params,
    common: &Common,
) -> Result<Option<MediumDesc>, Fault> {
    let values: Vec<f32> = params.floats("density").iter().map(|v| v.clamp(0.0, MOST) as f32).collect();
    let data = checked(scene, params, GridData::new(size_of_grid(params), values, None));
    let Some(data) = data else { return Ok(None) };
    let medium = GridMedium {
        border: GridBorder::Fade,
        density: common.scale,
        absorption: Some(common.absorption),
        scattering: Some(common.scattering),
        anisotropy: common.anisotropy,
        emission: common.emission,
        ..placed(scene, state, data, box_of(params), params.place)?
    };
    let hot: Vec<f32> = params.floats("temperature").iter().map(|v| v.clamp(0.0, MOST) as f32).collect();
    if hot.is_empty() {
        return Ok(Some(MediumDesc::Grid(medium)));
    }
    let hot = checked(scene, params, GridData::new(size_of_grid(params), hot, None));
    Ok(Some(MediumDesc::Grid(match hot {
        Some(hot) => glowing(scene, state, params, common, medium, (hot, box_of(params)))?,
        None => medium,
    })))
}

/// A grid of colours; `None` if it is damaged, which is reported.
pub(super) fn colored(
    scene: &mut Assembly<'_>,
    state: &State,
    params: &Params,
) -> Result<Option<MediumDesc>, Fault> {
    let (absorption, scattering) = (colors(state, params, "sigma_a"), colors(state, params, "sigma_s"));
    let light = match params.float("Lescale").unwrap_or(1.0) {
        scale if scale > 0.0 => colors(state, params, "Le"),
        _ => Vec::new(),
    };
    params.pass(&["Le"]);
    let count = absorption.len().max(scattering.len());
    for (name, list) in [("sigma_a", &absorption), ("sigma_s", &scattering), ("Le", &light)] {
        if !list.is_empty() && list.len() != count {
            let message = format!("{} colours of \"{name}\" for {count} cells", list.len());
            scene.report.ignored(params.place_of(name), message);
            return Ok(None);
        }
    }
    if absorption.is_empty() && !light.is_empty() {
        scene.report.ignored(params.place_of("Le"), "a grid that glows without \"sigma_a\"");
        return Ok(None);
    }
    // One that is not given is 1 everywhere.
    let filled = |c: Vec<[f32; 3]>| if c.is_empty() { vec![[1.0; 3]; count] } else { c };
    let (absorption, scattering) = (filled(absorption), filled(scattering));
    let sum = |(a, s): (&[f32; 3], &[f32; 3])| [a[0] + s[0], a[1] + s[1], a[2] + s[2]];
    let extinction: Vec<[f32; 3]> = absorption.iter().zip(&scattering).map(sum).collect();
    let glow: Vec<[f32; 3]> =
        absorption.iter().zip(&light).map(|(a, l)| [a[0] * l[0], a[1] * l[1], a[2] * l[2]]).collect();
    let (emission, color) = emission(&extinction, &glow);
    if let Some(emission) = &emission {
        let is_one_color = |(i, g): (usize, &[f32; 3])| {
            let density = extinction.get(i).copied().map_or(0.0, |e| e[0].max(e[1]).max(e[2]));
            let e = emission.get(i).copied().unwrap_or_default() * density;
            let shown = color.to_array().map(|c| c * e);
            g.iter().zip(shown).all(|(a, b)| (a - b).abs() <= 1e-3 * (a + b))
        };
        if !glow.iter().enumerate().all(is_one_color) {
            let message = "the light of a grid has several colours: their mean colour";
            scene.report.approximated(params.place_of("Le"), message);
        }
    }
    let data = GridData::of_extinction(size_of_grid(params), extinction, emission)
        .and_then(|data| data.with_scattering(GridScattering::Coefficient(scattering)));
    let Some(data) = checked(scene, params, data) else { return Ok(None) };
    let scale = params.float("Lescale").unwrap_or(1.0).clamp(0.0, 1e15) as f32;
    Ok(Some(MediumDesc::Grid(GridMedium {
        border: GridBorder::Fade,
        density: scale_of(params),
        anisotropy: anisotropy_of(params),
        emission: (color * scale).map(|v| v.clamp(0.0, 1e15)),
        ..placed(scene, state, data, box_of(params), params.place)?
    })))
}

/// The colours of cells.
fn colors(state: &State, params: &Params, name: &'static str) -> Vec<[f32; 3]> {
    let rgb = |c: &[f64; 3]| {
        let color = if name == "Le" {
            state.color_space.light_to_rec709(*c)
        } else {
            state.color_space.to_rec709(*c)
        };
        color.map(|v| v.clamp(0.0, MOST / 2.0) as f32)
    };
    params.rgbs(name).as_chunks::<3>().0.iter().map(rgb).collect()
}

/// Factors of the emission at the density of each cell, and its colour: that of all cells together.
fn emission(extinction: &[[f32; 3]], glow: &[[f32; 3]]) -> (Option<Vec<f32>>, Spectrum) {
    let total = glow.iter().fold([0.0f64; 3], |t, g| [0, 1, 2].map(|i| t[i] + f64::from(g[i])));
    let most = total.iter().fold(0.0f64, |m, v| m.max(*v));
    if most <= 0.0 {
        return (None, Spectrum::BLACK);
    }
    let color = Spectrum::from(total.map(|v| (v / most) as f32));
    let factor = |(e, g): (&[f32; 3], &[f32; 3])| {
        let density = e[0].max(e[1]).max(e[2]);
        if density <= 0.0 {
            return 0.0;
        }
        (Spectrum::from(*g).luminance() / (color.luminance() * density)).clamp(0.0, MOST as f32)
    };
    (Some(extinction.iter().zip(glow).map(factor).collect()), color)
}

/// The grid; `None` if it is damaged, which is reported.
fn checked(scene: &mut Assembly<'_>, params: &Params, data: Result<GridData, String>) -> Option<GridData> {
    data.map_err(|problem| scene.report.ignored(params.place, problem)).ok()
}

fn size_of_grid(params: &Params) -> [u32; 3] {
    ["nx", "ny", "nz"].map(|n| params.integer(n).unwrap_or(1).max(0) as u32)
}

pub(super) fn box_of(params: &Params) -> [DVec3; 2] {
    [params.vector("p0").unwrap_or(DVec3::ZERO), params.vector("p1").unwrap_or(DVec3::ONE)]
}

/// A grid that fills a box of the medium's space.
pub(super) fn placed(
    scene: &mut Assembly<'_>,
    state: &State,
    data: GridData,
    [a, b]: [DVec3; 2],
    place: Place,
) -> Result<GridMedium, Fault> {
    // In pbrt the first cell lies at the smallest coordinates, whatever the order of the corners is.
    let placed = GridBox::new(&state.ctm[0], [a.min(b), a.max(b)]);
    if !placed.keeps_cells() {
        let memory = &scene.options.limits.memory;
        let need = memory.need(data.memory() as u64, || "turning a medium grid".to_owned());
        need.map_err(|e| Fault::from_scene(place, e))?;
    }
    let Some(data) = placed.grid(data) else {
        return Err(Fault::at(place, ErrorCode::TooLarge, "not enough memory to turn a medium grid"));
    };
    if !placed.is_exact {
        scene.report.approximated(place, ROTATED_GRID);
    }
    let [min, max] = placed.bounds;
    let file = GridFile { uri: String::new(), data: Arc::new(data) };
    Ok(GridMedium { file, min: Some(min), max: Some(max + 1e-9), ..GridMedium::default() })
}

/// A medium that glows by a grid of temperatures in a box of the medium's space.
fn glowing(
    scene: &mut Assembly<'_>,
    state: &State,
    params: &Params,
    common: &Common,
    medium: GridMedium,
    (hot, bounds): (GridData, [DVec3; 2]),
) -> Result<GridMedium, Fault> {
    let own = hot.bounds().unwrap_or(bounds);
    let placed = placed(scene, state, hot, own, params.place)?;
    // Both say where they are in the scene.
    let in_scene = |medium: &GridMedium| {
        let bounds = medium.bounds();
        let data = GridData::clone(&medium.file.data).with_bounds(bounds);
        let data = data.map_err(|problem| Fault::at(params.place, ErrorCode::Transform, problem))?;
        Ok::<_, Fault>(GridFile { uri: String::new(), data: Arc::new(data) })
    };
    let scale = params.float("temperaturescale").unwrap_or(1.0);
    let offset = params.float("temperatureoffset").or_else(|| params.float("temperaturecutoff"));
    Ok(GridMedium {
        file: in_scene(&medium)?,
        temperature: Some(in_scene(&placed)?),
        temperature_scale: scale.clamp(0.0, 1e9),
        temperature_offset: offset.unwrap_or(0.0).clamp(-1e9, 1e9),
        // pbrt multiplies emission by absorption.
        emission: common.absorption * glow_scale(params) as f32,
        ..medium
    })
}

/// A NanoVDB file; `None` if it has no name or is damaged, which is reported.
pub(super) fn nanovdb(
    scene: &mut Assembly<'_>,
    state: &State,
    params: &Params,
    common: &Common,
) -> Result<Option<MediumDesc>, Fault> {
    let Some(name) = params.string("filename").map(str::to_owned) else {
        scene.report.ignored(params.place, "a nanovdb medium without a filename");
        return Ok(None);
    };
    let grid = params.string("gridname").unwrap_or("density").to_owned();
    let heat = params.string("temperaturename").unwrap_or("temperature").to_owned();
    let (_, bytes) = scene.read(&name, MAX_GRID, params.place_of("filename"))?;
    let place = params.place_of("filename");
    let limits = &scene.options.limits;
    limits
        .memory
        .need(2 * bytes.len() as u64, || format!("{}: reading it", printable(&name)))
        .map_err(|e| Fault::from_scene(place, e))?;
    let densities = |data: GridData| match data.has_distances() {
        true => {
            Err(format!("the grid \"{grid}\" is a level set, distances to a surface: expected densities"))
        }
        false => Ok(data),
    };
    match vdb::decode(&bytes, Some(&grid), scene.options.limits.memory.left()).and_then(densities) {
        Ok(data) => {
            let bounds = data.bounds().unwrap_or([DVec3::ZERO, DVec3::ONE]);
            let medium = GridMedium {
                density: common.scale,
                absorption: Some(common.absorption),
                scattering: Some(common.scattering),
                anisotropy: common.anisotropy,
                ..placed(scene, state, data, bounds, params.place)?
            };
            let hot = if glow_scale(params) > 0.0 && vdb::has_grid(&bytes, &heat) {
                let read = vdb::decode(&bytes, Some(&heat), scene.options.limits.memory.left());
                read.and_then(densities).map_err(|problem| {
                    let message =
                        format!("{}: {}: the medium does not glow", printable(&name), printable(&problem));
                    scene.report.ignored(place, message);
                })
            } else {
                Err(())
            };
            Ok(Some(MediumDesc::Grid(match hot {
                Ok(hot) => glowing(scene, state, params, common, medium, (hot, bounds))?,
                Err(()) => medium,
            })))
        }
        Err(problem) => {
            let message = format!("{}: {}", printable(&name), printable(&problem));
            scene.report.ignored(place, message);
            Ok(None)
        }
    }
}
