//! Participating media.

use std::sync::Arc;

use turner::color::Spectrum;
use turner::math::{DAffine3, DMat3, DVec3};
use turner::medium::{GridMedium, HomogeneousMedium, MediumDesc};
use turner::schema::{ErrorCode, GridFile, MediumId, Named};

use super::assembly::Assembly;
use super::params::Object;
use super::phase::{self, Phase};
use super::spectra::{Role, color};
use super::volumes::{self, Cells};
use crate::assets::printable;
use crate::scene_import::report::Fault;
use crate::scene_import::{GridBox, ROTATED_GRID, named_medium, unknown};

/// Largest grid file, bytes.
const MAX_GRID: u64 = 2 << 30;

/// The medium of an element; `None` if it is unknown.
pub(super) fn medium(scene: &mut Assembly<'_>, node: usize) -> Result<Option<MediumId>, Fault> {
    let object = Object::new(&scene.document, node)?;
    if let Some(known) = scene.media.get(&object.node) {
        return Ok(*known);
    }
    let made = make(scene, &object)?;
    scene.finish(&object);
    let id = made.map(|value| {
        let name = object.id();
        scene.medium_list.push(Named { name, span: None, value });
        MediumId(scene.medium_list.len() as u32 - 1)
    });
    scene.media.insert(object.node, id);
    Ok(id)
}

fn make(scene: &mut Assembly<'_>, object: &Object) -> Result<Option<MediumDesc>, Fault> {
    object.pass(&[
        "sample_emitters",
        "has_spectral_extinction",
        "majorant_factor",
        "majorant_resolution_factor",
        // Of Mitsuba 0.6: how it integrates.
        "method",
        "step_size",
    ]);
    let scale = object.float("scale")?.unwrap_or(1.0).clamp(0.0, 1e15);
    let phase = phase::of_medium(scene, object)?;
    let named = named(scene, object)?;
    if named.is_some() || object.has("sigma_a") || object.has("sigma_s") {
        let get = |scene: &mut Assembly<'_>, name: &'static str| match object.find(name) {
            Some((node, _)) => color(scene, node, Role::Unbounded),
            None => Ok(Spectrum::BLACK),
        };
        let (absorption, scattering) = match named {
            Some(both) => both,
            None => (get(scene, "sigma_a")?, get(scene, "sigma_s")?),
        };
        let sum = absorption + scattering;
        let part = |s: f32, t: f32| if t > 0.0 { s / t } else { 0.0 };
        let albedo =
            Spectrum::new(part(scattering.r, sum.r), part(scattering.g, sum.g), part(scattering.b, sum.b));
        return Ok(Some(homogeneous(scale, sum, albedo, phase)));
    }
    let albedo = value(scene, object, "albedo", 0.75)?;
    // Heterogeneous media of Mitsuba 0.6 call their extinction "density".
    let name = if object.has("density") { "density" } else { "sigma_t" };
    let sigma_t = value(scene, object, name, 1.0)?;
    if !["homogeneous", "heterogeneous"].contains(&object.kind.as_str()) {
        return Err(unknown("medium", &object.kind, &["homogeneous", "heterogeneous"]).or_at(object.place));
    }
    let (sigma_t, extinction) = match (sigma_t, &albedo) {
        (Volume::Grid(cells), _) => (cells, Spectrum::WHITE),
        // In Mitsuba 3 a heterogeneous medium ends at the box of its volume, even if its values are constant. A number
        // has the unit cube. In Mitsuba 0.6 constant volumes are unbounded.
        (Volume::Constant(c, bounds), _) if object.kind == "heterogeneous" && !scene.document.is_old => {
            (Cells::even(bounds.unwrap_or([DVec3::ZERO, DVec3::ONE])), c)
        }
        (Volume::Constant(c, _), Volume::Grid(cells)) => {
            let message = "a grid of albedos in a constant medium: the medium ends at the box of the grid";
            scene.report.approximated(object.place_of("albedo"), message);
            (Cells::even(cells.bounds), c)
        }
        (Volume::Constant(c, _), Volume::Constant(albedo, _)) => {
            let albedo = albedo.map(|v| v.clamp(0.0, 1.0));
            return Ok(Some(homogeneous(scale, c, albedo, phase)));
        }
    };
    let [min, max] = sigma_t.bounds;
    let (data, albedo) = match albedo {
        Volume::Constant(albedo, _) => (sigma_t.into_grid(), albedo.map(|v| v.clamp(0.0, 1.0))),
        Volume::Grid(albedo) => {
            let memory = &scene.options.limits.memory;
            let (sigma_t, albedo, is_exact) = volumes::on_one_grid(sigma_t, albedo, memory)
                .map_err(|e| Fault::from_scene(object.place_of("albedo"), e))?;
            if !is_exact {
                let message = "a grid of albedos whose cells are not those of sigma_t: resampled";
                scene.report.approximated(object.place_of("albedo"), message);
            }
            (sigma_t.into_grid().and_then(|d| d.with_scattering(albedo.into_albedo())), Spectrum::WHITE)
        }
    };
    let data = data.map_err(|problem| Fault::at(object.place, ErrorCode::Volume, problem))?;
    Ok(Some(MediumDesc::Grid(GridMedium {
        file: GridFile { uri: String::new(), data: Arc::new(data) },
        min: Some(min),
        max: Some(max),
        density: scale,
        extinction: Some(extinction),
        albedo: Some(albedo),
        anisotropy: phase.anisotropy,
        second_anisotropy: phase.second_anisotropy,
        second_weight: phase.second_weight,
        rayleigh: phase.rayleigh,
        ..GridMedium::default()
    })))
}

/// Absorption and scattering coefficients of the named medium that `material` of Mitsuba 0.6 chooses, if no others are
/// given.
fn named(scene: &mut Assembly<'_>, object: &Object) -> Result<Option<(Spectrum, Spectrum)>, Fault> {
    let Some(name) = object.string("material")? else { return Ok(None) };
    if ["sigma_a", "sigma_s", "sigma_t", "albedo"].iter().any(|n| object.has(n)) {
        return Ok(None);
    }
    let found = named_medium(name);
    if found.is_none() {
        let message = format!(
            "unknown medium \"{}\": give it sigma_t and albedo; sigma_t 1 and albedo 0.75 are used",
            printable(name)
        );
        scene.report.ignored(object.place_of("material"), message);
    }
    Ok(found)
}

fn homogeneous(density: f64, extinction: Spectrum, albedo: Spectrum, phase: Phase) -> MediumDesc {
    MediumDesc::Homogeneous(HomogeneousMedium {
        density,
        absorption: Some(extinction * albedo.map(|v| 1.0 - v)),
        scattering: Some(extinction * albedo),
        anisotropy: phase.anisotropy,
        second_anisotropy: phase.second_anisotropy,
        second_weight: phase.second_weight,
        rayleigh: phase.rayleigh,
        ..HomogeneousMedium::default()
    })
}

/// The values of a volume.
enum Volume {
    /// Constant, with the box of the volume if there is one.
    Constant(Spectrum, Option<[DVec3; 2]>),
    Grid(Cells),
}

fn value(scene: &mut Assembly<'_>, object: &Object, name: &'static str, or: f64) -> Result<Volume, Fault> {
    let Some((node, _)) = object.find(name) else {
        return Ok(Volume::Constant(Spectrum::grey(or as f32), None));
    };
    let volume = Object::new(&scene.document, node)?;
    if volume.tag != "volume" {
        return color(scene, volume.node, Role::Unbounded).map(|c| Volume::Constant(c, None));
    }
    let made = match volume.kind.as_str() {
        "constvolume" => {
            let to_world = volume.transform("to_world")?;
            let placed = GridBox::new(&to_world, [DVec3::ZERO, DVec3::ONE]);
            if !placed.is_exact && object.kind == "heterogeneous" {
                scene.report.approximated(volume.place, ROTATED_GRID);
            }
            let bounds = Some(placed.bounds).filter(|[min, max]| min.cmplt(*max).all());
            match volume.find("value") {
                Some((node, _)) => Volume::Constant(color(scene, node, Role::Unbounded)?, bounds),
                None => Volume::Constant(Spectrum::WHITE, bounds),
            }
        }
        "gridvolume" => grid(scene, &volume)?.unwrap_or(Volume::Constant(Spectrum::BLACK, None)),
        other => return Err(unknown("volume", other, &["constvolume", "gridvolume"]).or_at(volume.place)),
    };
    scene.finish(&volume);
    Ok(made)
}

fn grid(scene: &mut Assembly<'_>, object: &Object) -> Result<Option<Volume>, Fault> {
    let to_world = object.transform("to_world")?;
    // In Mitsuba 0.6 a grid fills the box that its file gives.
    let own_box = object.boolean("use_grid_bbox")?.unwrap_or(scene.document.is_old);
    if object.string("filter_type")? == Some("nearest") {
        scene
            .report
            .approximated(object.place, "a grid with nearest-neighbour filtering: interpolated linearly");
    }
    object.pass(&["wrap_mode", "raw", "accel", "filter_type", "data", "grid"]);
    let Some(name) = object.string("filename")?.map(str::to_owned) else {
        scene.report.ignored(object.place, "a gridvolume without filename: the medium is empty");
        return Ok(None);
    };
    let place = object.place_of("filename");
    let (_, bytes) = scene.read(&name, MAX_GRID, place)?;
    let memory = &scene.options.limits.memory;
    // Its values, and those that the grid of the medium keeps besides.
    let what = || format!("{}: reading it", printable(&name));
    memory.need(2 * bytes.len() as u64, what).map_err(|e| Fault::from_scene(place, e))?;
    match Cells::read(&bytes) {
        Ok((cells, channels)) => {
            if channels != 1 && channels != 3 {
                let message = format!("a grid of {channels} channels: their mean is used");
                scene.report.approximated(place, message);
            }
            // Its box as the image of the unit cube: corners in the opposite order mirror the grid.
            let to_world = if own_box {
                let [min, max] = cells.bounds;
                let sides = DMat3::from_diagonal(max - min);
                to_world * DAffine3::from_mat3_translation(sides, min)
            } else {
                to_world
            };
            let placed = GridBox::new(&to_world, [DVec3::ZERO, DVec3::ONE]);
            if !placed.is_exact {
                scene.report.approximated(object.place, ROTATED_GRID);
            }
            if !placed.keeps_cells() {
                let what = || format!("{}: turning it", printable(&name));
                memory.need(cells.bytes(), what).map_err(|e| Fault::from_scene(place, e))?;
            }
            let Some(cells) = cells.placed(&placed) else {
                let message = format!("{}: not enough memory to turn it", printable(&name));
                return Err(Fault::at(place, ErrorCode::TooLarge, message));
            };
            Ok(Some(Volume::Grid(cells)))
        }
        Err(problem) => {
            let message = format!("{}: {problem}; the medium is empty", printable(&name));
            scene.report.ignored(place, message);
            Ok(None)
        }
    }
}
