//! Participating media.

use std::sync::Arc;

use turner::color::Spectrum;
use turner::math::{DMat3, DVec3};
use turner::medium::{GridBorder, GridMedium, HomogeneousMedium, MediumDesc};
use turner::schema::{GridData, GridFile, MediumId, Named};

use super::assembly::Assembly;
use super::frame::Frame;
use super::params::Params;
use super::report::Fault;
use super::source::Place;
use super::spectra::{Role, color};
use super::state::State;
use crate::assets::printable;
use crate::grid::MAX_GRID;
use crate::vdb;

/// Name, σs and σa per millimetre of pbrt's named media (Jensen et al. 2001; Narasimhan et al. 2006).
const NAMED: &[(&str, [f64; 3], [f64; 3])] = &[
    ("Apple", [2.29, 2.39, 1.97], [0.003, 0.0034, 0.046]),
    ("Chicken1", [0.15, 0.21, 0.38], [0.015, 0.077, 0.19]),
    ("Chicken2", [0.19, 0.25, 0.32], [0.018, 0.088, 0.2]),
    ("Cream", [7.38, 5.47, 3.15], [0.0002, 0.0028, 0.0163]),
    ("Ketchup", [0.18, 0.07, 0.03], [0.061, 0.97, 1.45]),
    ("Marble", [2.19, 2.62, 3.0], [0.0021, 0.0041, 0.0071]),
    ("Potato", [0.68, 0.7, 0.55], [0.0024, 0.009, 0.12]),
    ("Skimmilk", [0.7, 1.22, 1.9], [0.0014, 0.0025, 0.0142]),
    ("Skin1", [0.74, 0.88, 1.01], [0.032, 0.17, 0.48]),
    ("Skin2", [1.09, 1.59, 1.79], [0.013, 0.07, 0.145]),
    ("Spectralon", [11.6, 20.4, 14.9], [0.0, 0.0, 0.0]),
    ("Wholemilk", [2.55, 3.21, 3.77], [0.0011, 0.0024, 0.014]),
];

/// σa and σs of a named medium, per millimetre.
pub(super) fn named(name: &str) -> Option<(Spectrum, Spectrum)> {
    let (_, scattering, absorption) = NAMED.iter().find(|(n, ..)| *n == name)?;
    let band = |v: &[f64; 3]| Spectrum::new(v[0] as f32, v[1] as f32, v[2] as f32);
    Some((band(absorption), band(scattering)))
}

/// Defines a medium.
pub(super) fn define(
    scene: &mut Assembly<'_>,
    state: &State,
    name: String,
    params: Params,
) -> Result<(), Fault> {
    let place = params.place;
    let kind = params.string("type").unwrap_or("homogeneous").to_owned();
    let space = state.color_space;
    let scale = params.float("scale").unwrap_or(1.0).clamp(0.0, 1e15);
    let preset = match params.string("preset") {
        None => None,
        Some(preset) => {
            let found = named(preset);
            if found.is_none() {
                let message = format!("unknown medium preset \"{}\"", printable(preset));
                scene.report.ignored(params.place_of("preset"), message);
            }
            found
        }
    };
    let one = Spectrum::WHITE;
    let (absorption, scattering) = match preset {
        Some(found) => found,
        None => {
            let a = color(scene, space, &params, "sigma_a", Role::Unbounded)?;
            let s = color(scene, space, &params, "sigma_s", Role::Unbounded)?;
            (a.unwrap_or(one), s.unwrap_or(one))
        }
    };
    let emission = color(scene, space, &params, "Le", Role::Light)?.unwrap_or(Spectrum::BLACK);
    let emission = emission * params.float("Lescale").unwrap_or(1.0).clamp(0.0, 1e15) as f32;
    let anisotropy = params.float("g").unwrap_or(0.0).clamp(-0.999, 0.999);
    let size = ["nx", "ny", "nz"].map(|n| params.integer(n).unwrap_or(1).max(0) as u32);
    let density = params.floats("density");
    // pbrt multiplies emission by absorption.
    let emission = emission * absorption;
    let medium = match kind.as_str() {
        "homogeneous" => homogeneous(scale, absorption, scattering, anisotropy, emission),
        "uniformgrid" if !density.is_empty() => {
            let p0 = params.vector("p0").unwrap_or(DVec3::ZERO);
            let p1 = params.vector("p1").unwrap_or(DVec3::ONE);
            let values: Vec<f32> = density.iter().map(|v| v.clamp(0.0, 1e30) as f32).collect();
            match GridData::new(size, values, None) {
                Ok(data) => MediumDesc::Grid(GridMedium {
                    border: GridBorder::Fade,
                    density: scale,
                    absorption: Some(absorption),
                    scattering: Some(scattering),
                    anisotropy,
                    emission,
                    ..placed(scene, state, data, [p0, p1], place)
                }),
                Err(problem) => {
                    scene.report.ignored(place, format!("the medium \"{}\": {problem}", printable(&name)));
                    homogeneous(0.0, absorption, scattering, anisotropy, emission)
                }
            }
        }
        "nanovdb" => match nanovdb(scene, &params)? {
            Some((data, bounds)) => MediumDesc::Grid(GridMedium {
                density: scale,
                absorption: Some(absorption),
                scattering: Some(scattering),
                anisotropy,
                ..placed(scene, state, data, bounds, place)
            }),
            None => homogeneous(0.0, absorption, scattering, anisotropy, Spectrum::BLACK),
        },
        other => {
            params.pass(&[
                "filename",
                "density",
                "temperature",
                "temperaturescale",
                "temperatureoffset",
                "temperaturecutoff",
            ]);
            params.pass(&["wispiness", "frequency", "p0", "p1", "sigma_a_grid", "LeScale", "Lescale"]);
            let message =
                format!("the medium type \"{}\" is not supported: the medium is empty", printable(other));
            scene.report.ignored(place, message);
            homogeneous(0.0, absorption, scattering, anisotropy, Spectrum::BLACK)
        }
    };
    params.pass(&["temperature", "temperaturescale", "temperatureoffset", "temperaturecutoff", "p0", "p1"]);
    params.finish(&format!("the medium \"{}\"", printable(&name)), &mut scene.report);
    scene.medium_list.push(Named { name: Some(name.clone()), span: None, value: medium });
    scene.media.insert(name, MediumId(scene.medium_list.len() as u32 - 1));
    Ok(())
}

/// A grid that fills a box of the medium's space.
fn placed(
    scene: &mut Assembly<'_>,
    state: &State,
    data: GridData,
    [p0, p1]: [DVec3; 2],
    place: Place,
) -> GridMedium {
    let m = state.ctm[0];
    let scales = DMat3::from_diagonal(DVec3::new(m.matrix3.x_axis.x, m.matrix3.y_axis.y, m.matrix3.z_axis.z));
    let (min, max) = (m.transform_point3(p0), m.transform_point3(p1));
    if scales != m.matrix3 || !min.cmplt(max).all() {
        let message = "a medium grid that is rotated or mirrored: aligned with the world axes";
        scene.report.approximated(place, message);
    }
    let file = GridFile { uri: String::new(), data: Arc::new(data) };
    GridMedium { file, min: Some(min.min(max)), max: Some(min.max(max) + 1e-9), ..GridMedium::default() }
}

/// The density of a NanoVDB file and its box; `None` if it cannot be read, which is reported.
fn nanovdb(scene: &mut Assembly<'_>, params: &Params) -> Result<Option<(GridData, [DVec3; 2])>, Fault> {
    let name = params.string("filename").unwrap_or_default().to_owned();
    let grid = params.string("gridname").unwrap_or("density").to_owned();
    let heat = params.string("temperaturename").unwrap_or("temperature").to_owned();
    let glows = params.float("Lescale").unwrap_or(1.0) > 0.0;
    let (_, bytes) = scene.read(&name, MAX_GRID, params.place_of("filename"))?;
    let place = params.place_of("filename");
    let limits = &scene.options.limits;
    limits
        .memory
        .need(2 * bytes.len() as u64, || format!("{}: reading it", printable(&name)))
        .map_err(|e| Fault::from_scene(place, e))?;
    if glows && vdb::has_grid(&bytes, &heat) {
        let message = format!("the grid of temperatures \"{}\": the medium does not glow", printable(&heat));
        scene.report.ignored(place, message);
    }
    match vdb::decode(&bytes, Some(&grid), scene.options.limits.memory.left()) {
        Ok(data) => {
            let bounds = data.bounds().unwrap_or([DVec3::ZERO, DVec3::ONE]);
            Ok(Some((data, bounds)))
        }
        Err(problem) => {
            let message = format!("{}: {}; the medium is empty", printable(&name), printable(&problem));
            scene.report.ignored(place, message);
            Ok(None)
        }
    }
}

fn homogeneous(
    density: f64,
    absorption: Spectrum,
    scattering: Spectrum,
    anisotropy: f64,
    emission: Spectrum,
) -> MediumDesc {
    MediumDesc::Homogeneous(HomogeneousMedium {
        density,
        absorption: Some(absorption),
        scattering: Some(scattering),
        anisotropy,
        emission,
        ..HomogeneousMedium::default()
    })
}

/// Applies white balance and exposure of the film, which may follow the media, to their emission.
pub(super) fn expose(media: &mut [Named<MediumDesc>], frame: &Frame) {
    for medium in media {
        let emission = match &mut medium.value {
            MediumDesc::Homogeneous(m) => &mut m.emission,
            MediumDesc::Grid(m) => &mut m.emission,
            _ => continue,
        };
        *emission = (frame.balanced(*emission) * frame.exposure() as f32).map(|v| v.clamp(0.0, 1e15));
    }
}
