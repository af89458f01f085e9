//! Participating media, and the grids of their densities (.vol files).

use std::sync::Arc;

use turner::color::Spectrum;
use turner::math::{DAffine3, DVec3};
use turner::medium::{GridMedium, HomogeneousMedium, MediumDesc};
use turner::schema::{ErrorCode, GridData, GridFile, MediumId, Named};

use super::assembly::Assembly;
use super::params::Object;
use super::spectra::{Role, color};
use crate::assets::printable;
use crate::scene_import::report::Fault;
use crate::scene_import::unknown;

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
    ]);
    let scale = object.float("scale")?.unwrap_or(1.0).clamp(0.0, 1e15);
    let anisotropy = match object.object("phase")? {
        None => 0.0,
        Some(phase) => {
            let g = match phase.kind.as_str() {
                "hg" => phase.float("g")?.unwrap_or(0.8),
                "isotropic" => 0.0,
                other if ["rayleigh", "blendphase", "sggx", "tabphase"].contains(&other) => {
                    phase.pass_all();
                    let message = format!("{}: rendered as isotropic", phase.title());
                    scene.report.approximated(phase.place, message);
                    0.0
                }
                other => {
                    let all = ["hg", "isotropic", "rayleigh", "blendphase", "sggx", "tabphase"];
                    return Err(unknown("phase", other, &all).or_at(phase.place));
                }
            };
            scene.finish(&phase);
            g.clamp(-0.999, 0.999)
        }
    };
    if object.has("sigma_a") || object.has("sigma_s") {
        let get = |scene: &mut Assembly<'_>, name: &'static str| match object.find(name) {
            Some((node, _)) => color(scene, node, Role::Unbounded),
            None => Ok(Spectrum::BLACK),
        };
        let (absorption, scattering) = (get(scene, "sigma_a")?, get(scene, "sigma_s")?);
        let sum = absorption + scattering;
        let part = |s: f32, t: f32| if t > 0.0 { s / t } else { 0.0 };
        let albedo =
            Spectrum::new(part(scattering.r, sum.r), part(scattering.g, sum.g), part(scattering.b, sum.b));
        return Ok(Some(homogeneous(scale, sum, albedo, anisotropy)));
    }
    let albedo = value(scene, object, "albedo", 0.75)?;
    let sigma_t = value(scene, object, "sigma_t", 1.0)?;
    let albedo = match albedo {
        Volume::Constant(c, _) => c.map(|v| v.clamp(0.0, 1.0)),
        Volume::Grid(..) => {
            let message = "a grid of albedos: 0.75 replaces it";
            scene.report.approximated(object.place_of("albedo"), message);
            Spectrum::grey(0.75)
        }
    };
    match (object.kind.as_str(), sigma_t) {
        // A heterogeneous medium ends at the box of its volume, even if its values are constant.
        ("heterogeneous", Volume::Constant(sigma_t, Some([min, max]))) => {
            let data = GridData::new([2; 3], vec![1.0; 8], None)
                .map_err(|problem| Fault::at(object.place, ErrorCode::Internal, problem))?;
            Ok(Some(gridded(data, [min, max], (scale, sigma_t), albedo, anisotropy)))
        }
        ("homogeneous" | "heterogeneous", Volume::Constant(sigma_t, _)) => {
            Ok(Some(homogeneous(scale, sigma_t, albedo, anisotropy)))
        }
        ("homogeneous" | "heterogeneous", Volume::Grid(data, min, max)) => {
            Ok(Some(gridded(data, [min, max], (scale, Spectrum::WHITE), albedo, anisotropy)))
        }
        (other, _) => Err(unknown("medium", other, &["homogeneous", "heterogeneous"]).or_at(object.place)),
    }
}

fn homogeneous(density: f64, extinction: Spectrum, albedo: Spectrum, anisotropy: f64) -> MediumDesc {
    MediumDesc::Homogeneous(HomogeneousMedium {
        density,
        absorption: Some(extinction * albedo.map(|v| 1.0 - v)),
        scattering: Some(extinction * albedo),
        anisotropy,
        ..HomogeneousMedium::default()
    })
}

fn gridded(
    data: GridData,
    [min, max]: [DVec3; 2],
    (density, extinction): (f64, Spectrum),
    albedo: Spectrum,
    anisotropy: f64,
) -> MediumDesc {
    let file = GridFile { uri: String::new(), data: Arc::new(data) };
    MediumDesc::Grid(GridMedium {
        file,
        min: Some(min),
        max: Some(max),
        density,
        extinction: Some(extinction),
        albedo: Some(albedo),
        anisotropy,
        ..GridMedium::default()
    })
}

/// The values of a volume.
enum Volume {
    /// Constant, with the box of the volume if there is one.
    Constant(Spectrum, Option<[DVec3; 2]>),
    Grid(GridData, DVec3, DVec3),
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
            let (a, b) = (to_world.transform_point3(DVec3::ZERO), to_world.transform_point3(DVec3::ONE));
            let bounds = Some([a.min(b), a.max(b)]).filter(|[min, max]| min.cmplt(*max).all());
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
    let own_box = object.boolean("use_grid_bbox")?.unwrap_or(false);
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
    match decode(&bytes) {
        Ok((data, bounds, channels)) => {
            if channels > 1 {
                let message = format!("a grid of {channels} channels: their mean is used");
                scene.report.approximated(place, message);
            }
            let local = if own_box { bounds } else { [DVec3::ZERO, DVec3::ONE] };
            let (min, max) = (to_world.transform_point3(local[0]), to_world.transform_point3(local[1]));
            let straight = DAffine3::from_scale(to_world.transform_vector3(DVec3::ONE)).matrix3;
            if (straight - to_world.matrix3).to_cols_array().iter().any(|v| v.abs() > 1e-6)
                || !min.cmplt(max).all()
            {
                let message = "a medium grid that is rotated or mirrored: aligned with the world axes";
                scene.report.approximated(object.place, message);
            }
            Ok(Some(Volume::Grid(data, min.min(max), max.max(min) + 1e-9)))
        }
        Err(problem) => {
            let message = format!("{}: {problem}; the medium is empty", printable(&name));
            scene.report.ignored(place, message);
            Ok(None)
        }
    }
}

/// Decodes a .vol file: "VOL", version 3, type 1 (f32), sizes along x, y, z, channels, the bounding box, then
/// the values, x fastest. Returns the mean of the channels, the box and the number of channels.
fn decode(bytes: &[u8]) -> Result<(GridData, [DVec3; 2], usize), String> {
    let cut = || "the file is truncated".to_owned();
    if !bytes.starts_with(b"VOL\x03") {
        return Err("is not a volume file of version 3".into());
    }
    let word = |i: usize| -> Option<[u8; 4]> { bytes.get(4 * i..4 * i + 4)?.try_into().ok() };
    let integer = |i: usize| word(i).map(i32::from_le_bytes).ok_or_else(cut);
    if integer(1)? != 1 {
        return Err("its values are not 32-bit floats".into());
    }
    let mut size = [0u32; 3];
    for (i, s) in size.iter_mut().enumerate() {
        *s = u32::try_from(integer(2 + i)?).map_err(|_| "a size is negative".to_owned())?;
    }
    let channels = usize::try_from(integer(5)?).ok().filter(|c| (1..=16).contains(c));
    let channels = channels.ok_or_else(|| "expected 1 to 16 channels".to_owned())?;
    let float = |i: usize| word(i).map(|b| f64::from(f32::from_le_bytes(b))).ok_or_else(cut);
    let corner = |i: usize| Ok::<_, String>(DVec3::new(float(i)?, float(i + 1)?, float(i + 2)?));
    let bounds = [corner(6)?, corner(9)?];
    let count = size.iter().try_fold(channels, |n, s| n.checked_mul(*s as usize));
    let data = bytes.get(48..).unwrap_or_default();
    if count.and_then(|n| n.checked_mul(4)).is_none_or(|n| n > data.len()) {
        let [x, y, z] = size;
        return Err(format!("{x} × {y} × {z} cells of {channels} channels are more than the file holds"));
    }
    let (values, _) = data.as_chunks::<4>();
    let count = count.unwrap_or_default();
    let value = |b: &[u8; 4]| {
        let v = f32::from_le_bytes(*b);
        if v.is_finite() { v.clamp(0.0, 1e30) } else { 0.0 }
    };
    let cells = values.get(..count).unwrap_or_default().chunks_exact(channels);
    let density = cells.map(|cell| cell.iter().map(|b| value(b) / channels as f32).sum()).collect();
    GridData::new(size, density, None).map(|data| (data, bounds, channels))
}
