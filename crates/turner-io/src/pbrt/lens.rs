//! The camera with a lens, `realistic`, and its lens files.

use turner::camera::{LensBrightness, RealisticDesc};
use turner::schema::ErrorCode;

use super::assembly::Assembly;
use super::params::Params;
use super::report::Fault;
use crate::assets::printable;

/// Most bytes of a lens file.
const MAX_LENS: u64 = 1 << 20;

/// Sets the lens of `desc`; `unit` is the world length of one unit of camera space, which pbrt takes for a metre.
pub(super) fn realistic(
    scene: &mut Assembly<'_>,
    params: &Params,
    desc: RealisticDesc,
    unit: f64,
) -> Result<RealisticDesc, Fault> {
    let Some(name) = params.string("lensfile") else {
        let message = "the camera \"realistic\" has no \"lensfile\"";
        return Err(Fault::at(params.place, ErrorCode::MissingKey, message));
    };
    let place = params.place_of("lensfile");
    let (_, bytes) = scene.read(name, MAX_LENS, place)?;
    let elements = elements(&String::from_utf8_lossy(&bytes)).map_err(|(line, problem)| {
        Fault::at(place, ErrorCode::File, format!("{}, line {line}: {problem}", printable(name)))
            .help("a row has four numbers: radius of curvature, thickness, refractive index and diameter")
    })?;
    let has_stop = elements.iter().any(|[radius, ..]| *radius == 0.0);
    let diameter = params.float("aperturediameter").unwrap_or(1.0);
    let (blades, blade_rotation) = match params.string("aperture").unwrap_or("circular") {
        "circular" => (0, 0.0),
        other => {
            let (blades, rotation, as_what) = match other {
                "square" => (4, 45.0, "read as a square whose corners are on the circle"),
                "pentagon" => (5, 0.0, "read as a pentagon whose corners are on the circle"),
                _ => (0, 0.0, "read as a round one"),
            };
            let message = format!("the aperture \"{}\" of the camera: {as_what}", printable(other));
            scene.report.approximated(params.place_of("aperture"), message);
            (blades, rotation)
        }
    };
    Ok(RealisticDesc {
        elements,
        aperture_diameter: (has_stop && diameter > 0.0).then_some(diameter),
        blades,
        blade_rotation,
        focus_distance: Some(params.float("focusdistance").unwrap_or(10.0) * unit),
        film_diagonal: scene.frame.diagonal,
        units_per_metre: unit,
        brightness: LensBrightness::Absolute,
        ..desc
    })
}

/// The rows of a lens file. Lines from # on are comments. The error is a line, counted from 1, and what is wrong there.
fn elements(text: &str) -> Result<Vec<[f64; 4]>, (usize, String)> {
    let mut rows = Vec::new();
    let (mut row, mut count, mut last) = ([0.0; 4], 0, 1);
    for (i, line) in text.lines().enumerate() {
        for word in line.split('#').next().unwrap_or_default().split_whitespace() {
            last = i + 1;
            let Some(number) = word.parse().ok().filter(|v: &f64| v.is_finite()) else {
                return Err((last, format!("\"{}\" is not a number", printable(word))));
            };
            if let Some(to) = row.get_mut(count) {
                *to = number;
            }
            count += 1;
            if count == row.len() {
                rows.push(row);
                count = 0;
            }
        }
    }
    if count != 0 || rows.is_empty() {
        return Err((last, format!("the last row has {count} of four numbers")));
    }
    Ok(rows)
}
