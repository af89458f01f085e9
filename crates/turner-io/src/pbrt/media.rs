//! Participating media.

mod grids;

use turner::color::Spectrum;
use turner::math::DVec3;
use turner::medium::{CloudMedium, GridMedium, HomogeneousMedium, MediumDesc};
use turner::schema::{MediumId, Named};

use super::assembly::Assembly;
use super::frame::Frame;
use super::params::Params;
use super::report::Fault;
use super::spectra::{Role, color};
use super::state::State;
use crate::assets::printable;
use crate::scene_import::{GridBox, named_medium};

/// What all types of media have.
pub(super) struct Common {
    pub(super) scale: f64,
    pub(super) absorption: Spectrum,
    pub(super) scattering: Spectrum,
    pub(super) anisotropy: f64,
    /// Emitted radiance per unit of length.
    pub(super) emission: Spectrum,
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
    let medium = match kind.as_str() {
        "rgbgrid" => grids::colored(scene, state, &params)?,
        _ => {
            let common = common(scene, state, &params)?;
            match kind.as_str() {
                "homogeneous" => Some(homogeneous(&common)),
                "uniformgrid" | "heterogeneous" if params.has("density") => {
                    grids::uniform(scene, state, &params, &common)?
                }
                "nanovdb" => grids::nanovdb(scene, state, &params, &common)?,
                "cloud" => clouds(scene, state, &params, &common)?,
                other => {
                    params.pass(&["filename", "density", "p0", "p1"]);
                    let message = format!("the medium type \"{}\" is not supported", printable(other));
                    scene.report.ignored(place, message);
                    None
                }
            }
        }
    };
    let medium = medium.unwrap_or_else(|| {
        let message = format!("the medium \"{}\" is empty", printable(&name));
        scene.report.ignored(place, message);
        MediumDesc::Homogeneous(HomogeneousMedium { density: 0.0, ..HomogeneousMedium::default() })
    });
    params.pass(&["temperature", "p0", "p1", "Lescale", "LeScale"]);
    params.pass(&["temperaturescale", "temperatureoffset", "temperaturecutoff"]);
    params.finish(&format!("the medium \"{}\"", printable(&name)), &mut scene.report);
    scene.medium_list.push(Named { name: Some(name.clone()), span: None, value: medium });
    scene.media.insert(name, MediumId(scene.medium_list.len() as u32 - 1));
    Ok(())
}

pub(super) fn scale_of(params: &Params) -> f64 {
    params.float("scale").unwrap_or(1.0).clamp(0.0, 1e15)
}

pub(super) fn anisotropy_of(params: &Params) -> f64 {
    params.float("g").unwrap_or(0.0).clamp(-0.999, 0.999)
}

/// The factor of emission, which the files of pbrt's scenes spell in two ways.
fn glow_scale(params: &Params) -> f64 {
    params.float("Lescale").or_else(|| params.float("LeScale")).unwrap_or(1.0).clamp(0.0, 1e15)
}

fn common(scene: &mut Assembly<'_>, state: &State, params: &Params) -> Result<Common, Fault> {
    let space = state.color_space;
    let preset = match params.string("preset") {
        None => None,
        Some(preset) => {
            let found = named_medium(preset);
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
            let a = color(scene, space, params, "sigma_a", Role::Unbounded)?;
            let s = color(scene, space, params, "sigma_s", Role::Unbounded)?;
            let [default_a, default_s] = match scene.frame.is_version3 {
                true => [Spectrum::new(0.0011, 0.0024, 0.014), Spectrum::new(2.55, 3.21, 3.77)],
                false => [one, one],
            };
            (a.unwrap_or(default_a), s.unwrap_or(default_s))
        }
    };
    let emission = color(scene, space, params, "Le", Role::Light)?.unwrap_or(Spectrum::BLACK);
    let emission = emission * glow_scale(params) as f32;
    Ok(Common {
        scale: scale_of(params),
        absorption,
        scattering,
        anisotropy: anisotropy_of(params),
        // pbrt multiplies emission by absorption.
        emission: emission * absorption,
    })
}

/// Clouds of noise.
fn clouds(
    scene: &mut Assembly<'_>,
    state: &State,
    params: &Params,
    common: &Common,
) -> Result<Option<MediumDesc>, Fault> {
    let number = |name, or: f64, most| params.float(name).unwrap_or(or).clamp(0.0, most);
    let cloud = CloudMedium {
        density: number("density", 1.0, 1e30),
        wispiness: number("wispiness", 1.0, 1e6),
        frequency: number("frequency", 5.0, 1e6),
        absorption: Some(common.absorption),
        scattering: Some(common.scattering),
        anisotropy: common.anisotropy,
        ..CloudMedium::default()
    };
    let bounds = grids::box_of(params);
    let placed = GridBox::new(&state.ctm[0], bounds);
    if placed.is_exact && placed.keeps_cells() && bounds == [DVec3::ZERO, DVec3::ONE] {
        let [min, max] = placed.bounds;
        return Ok(Some(MediumDesc::Cloud(CloudMedium { min, max, ..cloud })));
    }
    // Other boxes are parts of the clouds' space, or turned in that of the scene.
    let [from, to] = [bounds[0].min(bounds[1]), bounds[0].max(bounds[1])];
    let data = cloud.grid([from, to], (to - from).max(DVec3::splat(1e-30)));
    let data = data.map_err(|e| Fault::from_scene(params.place, e))?;
    Ok(Some(MediumDesc::Grid(GridMedium {
        absorption: cloud.absorption,
        scattering: cloud.scattering,
        anisotropy: cloud.anisotropy,
        ..grids::placed(scene, state, data, bounds, params.place)?
    })))
}

fn homogeneous(common: &Common) -> MediumDesc {
    MediumDesc::Homogeneous(HomogeneousMedium {
        density: common.scale,
        absorption: Some(common.absorption),
        scattering: Some(common.scattering),
        anisotropy: common.anisotropy,
        emission: common.emission,
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
