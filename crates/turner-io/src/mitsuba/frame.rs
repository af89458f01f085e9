//! Sensor, film, sampler, filter and integrator.

use turner::camera::{
    CameraDesc, Handedness, MAX_SHIFT, OrthographicDesc, PinholeDesc, ThinLensDesc, Viewport,
};
use turner::description::SceneDesc;
use turner::film::Antialias;
use turner::filter::FilterKind;
use turner::integrator::{DepthDesc, DepthMeasure, IntegratorDesc, PathDesc};
use turner::math::elementary::{atan2, tan};
use turner::math::{DAffine3, DVec2, DVec3, radians};
use turner::schema::{ErrorCode, MediumId, Named};

use super::assembly::Assembly;
use super::media;
use super::params::Object;
use crate::assets::printable;
use crate::scene_import::report::{Fault, Report};
use crate::scene_import::{is_sound, unknown};

/// Most columns or rows.
const MAX_SIDE: i64 = 65536;
/// Stands for unlimited depth.
const NO_LIMIT: u32 = 1000;

/// Camera, film and integrator of the file, with Mitsuba's defaults.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    camera: Option<CameraDesc>,
    size: [u32; 2],
    crop: Option<[u32; 4]>,
    samples: u32,
    filter: (FilterKind, f64),
    integrator: IntegratorDesc,
    /// In stops.
    exposure: f64,
    /// The medium around the camera.
    pub(super) medium: Option<MediumId>,
}

impl Default for Frame {
    fn default() -> Frame {
        Frame {
            camera: None,
            size: [768, 576],
            crop: None,
            samples: 4,
            filter: (FilterKind::Gaussian, 1.5),
            integrator: paths(NO_LIMIT),
            exposure: 0.0,
            medium: None,
        }
    }
}

/// A path tracer of this depth.
fn paths(max_depth: u32) -> IntegratorDesc {
    IntegratorDesc::Path(PathDesc { max_depth, ..PathDesc::default() })
}

/// Sets the integrator. If integrators are nested, the inner one counts.
pub(super) fn integrator(scene: &mut Assembly<'_>, object: &Object) -> Result<(), Fault> {
    let inner = object.objects(&["integrator"])?;
    if let Some(inner) = inner.first() {
        let inner = Object::new(&scene.document, *inner)?;
        if inner.objects(&["integrator"])?.is_empty() {
            let message = format!("{} around {}: the inner one is used", object.title(), inner.title());
            scene.report.ignored(object.place, message);
            object.pass_all();
            return integrator(scene, &inner);
        }
    }
    let depth = object.integer("max_depth")?.unwrap_or(-1);
    object.pass(&[
        "samples_per_pass",
        "timeout",
        "block_size",
        "shading_samples",
        "emitter_samples",
        "bsdf_samples",
        "aovs",
    ]);
    // Mitsuba counts the camera ray.
    let mut max_depth = u32::try_from(depth).map_or(NO_LIMIT, |d| d.clamp(1, 100_001) - 1);
    match object.kind.as_str() {
        "path" | "volpath" | "volpathmis" | "prb" | "prbvolpath" | "prb_basic" | "prb_projective" => {}
        "direct" | "direct_projective" | "emission" => max_depth = u32::from(object.kind != "emission"),
        "volpath_simple" | "bdpt" => object.pass_all(),
        "ptracer" | "particle" | "photonmapper" | "ppm" | "sppm" | "mlt" | "pssmlt" | "erpt" | "vpl" => {
            let message = format!("{}: \"path\" replaces it", object.title());
            scene.report.approximated(object.place, message);
            object.pass_all();
        }
        "depth" => {
            object.pass_all();
            scene.frame.integrator = IntegratorDesc::Depth(DepthDesc { measure: DepthMeasure::Distance });
            return Ok(());
        }
        "aov" | "moment" | "stokes" | "adaptive" | "irrcache" => {
            let message = format!("{}: \"path\" replaces it", object.title());
            scene.report.ignored(object.place, message);
            object.pass_all();
        }
        other => {
            let known = "unknown integrator, \"path\" replaces it";
            scene.report.ignored(object.place, format!("\"{}\": {known}", printable(other)));
            object.pass_all();
        }
    }
    let hide_emitters = object.boolean("hide_emitters")?.unwrap_or(false);
    if object.boolean("strict_normals")?.unwrap_or(false) {
        object.pass(&["strict_normals"]);
    }
    let rr_start = object.integer("rr_depth")?.and_then(|d| u32::try_from(d).ok());
    scene.frame.integrator =
        IntegratorDesc::Path(PathDesc { max_depth, hide_emitters, rr_start, ..PathDesc::default() });
    scene.finish(object);
    Ok(())
}

/// The sensors of Mitsuba.
const SENSORS: &[&str] =
    &["perspective", "thinlens", "orthographic", "radiancemeter", "irradiancemeter", "distant", "batch"];

/// Sets the camera: that of the first sensor.
pub(super) fn sensor(scene: &mut Assembly<'_>, object: &Object) -> Result<(), Fault> {
    if scene.frame.camera.is_some() {
        scene.report.ignored(object.place, "another sensor: the first one is used");
        return Ok(());
    }
    if let Some(film) = object.object("film")? {
        self::film(scene, &film)?;
    }
    if let Some(sampler) = object.object("sampler")? {
        self::sampler(scene, &sampler)?;
    }
    let medium = object.objects(&["medium"])?;
    if let Some(medium) = medium.first() {
        scene.frame.medium = media::medium(scene, *medium)?;
    }
    let to_world = object.transform("to_world")?;
    object.pass(&["shutter_open", "shutter_close", "srf"]);
    let (near, far) = clip(object)?;
    let camera = match object.kind.as_str() {
        "perspective" | "thinlens" => {
            let pose = pose(scene, object, to_world)?;
            let viewport = Viewport::Height(height(scene, object)?);
            let shift = principal_point(scene, object)?;
            let Pose { position, look_at, up, handedness, .. } = pose;
            let radius = object.float("aperture_radius")?.unwrap_or(0.0);
            let focus = object.float("focus_distance")?.unwrap_or(0.0);
            let (fov, viewport, distance) = (None, Some(viewport), Some(1.0));
            if object.kind == "thinlens" && radius > 0.0 && focus > 0.0 {
                CameraDesc::ThinLens(ThinLensDesc {
                    position,
                    look_at,
                    up,
                    handedness,
                    fov,
                    viewport,
                    distance,
                    shift,
                    lens_radius: radius,
                    focus_distance: Some(focus),
                    near,
                    far,
                    ..ThinLensDesc::default()
                })
            } else {
                CameraDesc::Pinhole(PinholeDesc {
                    position,
                    look_at,
                    up,
                    handedness,
                    fov,
                    viewport,
                    distance,
                    shift,
                    near,
                    far,
                    motion: None,
                })
            }
        }
        "orthographic" => {
            // The image is 2 wide in camera space.
            let scale = to_world.matrix3.x_axis.length();
            let pose = pose(scene, object, to_world)?;
            let Pose { position, look_at, up, handedness, aspect } = pose;
            let viewport = Viewport::Height(2.0 * scale / aspect);
            CameraDesc::Orthographic(OrthographicDesc {
                position,
                look_at,
                up,
                handedness,
                viewport,
                near,
                far,
                motion: None,
            })
        }
        "radiancemeter" | "irradiancemeter" | "distant" | "batch" => {
            object.pass_all();
            let message = format!("{} is not supported: the default camera replaces it", object.title());
            scene.report.ignored(object.place, message);
            return Ok(());
        }
        other => {
            return Err(unknown("sensor", other, SENSORS).or_at(object.place));
        }
    };
    object.pass(&[
        "focus_distance",
        "aperture_radius",
        "near_clip",
        "far_clip",
        "fov",
        "fov_axis",
        "focal_length",
    ]);
    scene.finish(object);
    scene.frame.camera = Some(camera);
    Ok(())
}

/// The shift of the screen for an offset of the principal point, whose y points down.
fn principal_point(scene: &mut Assembly<'_>, object: &Object) -> Result<DVec2, Fault> {
    let [x, y] = ["principal_point_offset_x", "principal_point_offset_y"].map(|n| object.float(n));
    let shift = DVec2::new(x?.unwrap_or(0.0), -y?.unwrap_or(0.0));
    if shift.abs().max_element() > MAX_SHIFT {
        scene.report.ignored(object.place, "a principal point far off the film: it is centred");
        return Ok(DVec2::ZERO);
    }
    Ok(shift)
}

/// The distances along the viewing direction between which a sensor sees surfaces.
///
/// Errors: the far one is not beyond the near one, as in Mitsuba.
fn clip(object: &Object) -> Result<(f64, Option<f64>), Fault> {
    let near = object.float("near_clip")?.unwrap_or(0.01).max(0.0);
    let far = object.float("far_clip")?.unwrap_or(1e4);
    if far <= near {
        let message = format!("`far_clip`, {far}, is not beyond `near_clip`, {near}");
        return Err(Fault::at(object.place_of("far_clip"), ErrorCode::OutOfRange, message));
    }
    Ok((near, Some(far)))
}

/// Position and orientation of a camera: it looks along its +z, +y is up, +x to the left.
struct Pose {
    position: DVec3,
    look_at: DVec3,
    up: DVec3,
    handedness: Handedness,
    /// Width over height of the image.
    aspect: f64,
}

fn pose(scene: &mut Assembly<'_>, object: &Object, to_world: DAffine3) -> Result<Pose, Fault> {
    if !is_sound(&to_world) {
        let message = "the camera's transform is not invertible";
        return Err(Fault::at(object.place, ErrorCode::Transform, message));
    }
    let m = to_world.matrix3;
    let [left, up, forward] = [m.x_axis, m.y_axis, m.z_axis];
    let unit = forward.length();
    let askew =
        [left.dot(up), up.dot(forward), forward.dot(left)].iter().any(|d| d.abs() > 1e-3 * unit * unit);
    if askew {
        scene.report.approximated(
            object.place,
            "the camera's transform has shear: the camera uses its position and directions only",
        );
    }
    let handedness = if m.determinant() > 0.0 { Handedness::Right } else { Handedness::Left };
    let position = to_world.translation;
    // Far enough that rounding does not change the direction.
    let look_at = position + forward / unit * (1.0 + position.abs().max_element());
    let [w, h] = scene.frame.size.map(f64::from);
    Ok(Pose { position, look_at, up, handedness, aspect: w / h })
}

/// Height of the screen at distance 1.
fn height(scene: &mut Assembly<'_>, object: &Object) -> Result<f64, Fault> {
    let [w, h] = scene.frame.size.map(f64::from);
    screen_height(scene, object, w / h)
}

/// The same for a sensor or projector whose picture has the given width over height.
pub(super) fn screen_height(scene: &mut Assembly<'_>, object: &Object, aspect: f64) -> Result<f64, Fault> {
    let mut axis =
        object.word("fov_axis", &["x", "y", "diagonal", "smaller", "larger"], &mut scene.stock.report)?;
    let fov = match (object.float("fov")?, object.string("focal_length")?) {
        (Some(fov), _) => fov,
        (None, length) => {
            // On a film of 36 x 24 mm, along its diagonal.
            let length = length.unwrap_or("50mm");
            let mm = super::params::number(length.trim().trim_end_matches("mm")).filter(|v| *v > 0.0);
            let Some(mm) = mm else {
                let message =
                    format!("focal_length \"{}\"; expected a length such as 50mm", printable(length));
                return Err(Fault::at(object.place_of("focal_length"), ErrorCode::WrongType, message));
            };
            axis = "diagonal";
            2.0 * atan2((36.0f64 * 36.0 + 24.0 * 24.0).sqrt() / 2.0, mm).to_degrees()
        }
    };
    let size = 2.0 * tan(radians(fov.clamp(1e-6, 179.999)) / 2.0);
    let along_x = match axis {
        "y" => false,
        "smaller" => aspect <= 1.0,
        "larger" => aspect > 1.0,
        _ => true,
    };
    Ok(match (axis, along_x) {
        ("diagonal", _) => size / (1.0 + aspect * aspect).sqrt(),
        (_, true) => size / aspect,
        (_, false) => size,
    })
}

fn size(v: Option<i64>, or: u32) -> u32 {
    v.map_or(or, |v| v.clamp(1, MAX_SIDE) as u32)
}

fn film(scene: &mut Assembly<'_>, object: &Object) -> Result<(), Fault> {
    let known = ["hdrfilm", "ldrfilm", "specfilm", "mfilm", "film"];
    if !known.contains(&object.kind.as_str()) {
        return Err(unknown("film", &object.kind, &known).or_at(object.place));
    }
    let frame = &mut scene.frame;
    frame.size = [size(object.integer("width")?, 768), size(object.integer("height")?, 576)];
    let part = |name| object.integer(name).map(|v| v.map(|v| v.clamp(0, MAX_SIDE) as u32));
    let [w, h] = frame.size;
    let (x, y) =
        (part("crop_offset_x")?.unwrap_or(0).min(w - 1), part("crop_offset_y")?.unwrap_or(0).min(h - 1));
    let (cw, ch) =
        (part("crop_width")?.unwrap_or(w).clamp(1, w - x), part("crop_height")?.unwrap_or(h).clamp(1, h - y));
    frame.crop = ([x, y, cw, ch] != [0, 0, w, h]).then_some([x, y, cw, ch]);
    // In Mitsuba 0.6, for the gamma curve; Reinhard's operator has a key instead.
    let exposure = object.float("exposure")?.filter(|v| v.is_finite());
    if object.kind == "ldrfilm" && object.string("tonemap_method")? != Some("reinhard") {
        scene.frame.exposure = exposure.unwrap_or(0.0).clamp(-64.0, 64.0);
    }
    // The command line names the output, and its name decides about the format.
    object.pass(&[
        "file_format",
        "pixel_format",
        "component_format",
        "banner",
        "high_quality_edges",
        "sample_border",
        "filename",
        "compensate",
        "attach_log",
        "gamma",
        "tonemap_method",
        "key",
        "burn",
    ]);
    if let Some(filter) = object.object("rfilter")? {
        scene.frame.filter = self::filter(&filter, &mut scene.stock.report)?;
        scene.finish(&filter);
    }
    scene.finish(object);
    Ok(())
}

fn filter(object: &Object, report: &mut Report) -> Result<(FilterKind, f64), Fault> {
    object.pass(&["lobes", "b", "c", "B", "C"]);
    let radius = object.float("radius")?;
    let deviation = object.float("stddev")?.unwrap_or(0.5);
    let (kind, radius) = match object.kind.as_str() {
        "box" => (FilterKind::Box, radius.unwrap_or(0.5)),
        "tent" => (FilterKind::Tent, radius.unwrap_or(1.0)),
        // Turner's Gaussian ends at three standard deviations.
        "gaussian" => (FilterKind::Gaussian, 3.0 * deviation),
        "mitchell" | "catmullrom" | "lanczos" => {
            let message = format!(
                "the filter \"{}\" has negative weights: \"blackman-harris\" replaces it",
                object.kind
            );
            report.approximated(object.place, message);
            (FilterKind::BlackmanHarris, 1.5)
        }
        other => {
            let all = ["box", "tent", "gaussian", "mitchell", "catmullrom", "lanczos"];
            return Err(unknown("rfilter", other, &all).or_at(object.place));
        }
    };
    Ok((kind, radius.clamp(0.01, 16.0)))
}

fn sampler(scene: &mut Assembly<'_>, object: &Object) -> Result<(), Fault> {
    let known = [
        "independent",
        "stratified",
        "multijitter",
        "orthogonal",
        "ldsampler",
        "halton",
        "hammersley",
        "sobol",
    ];
    if !known.contains(&object.kind.as_str()) {
        return Err(unknown("sampler", &object.kind, &known).or_at(object.place));
    }
    let count = object.integer("sample_count")?.unwrap_or(4);
    scene.frame.samples = count.clamp(1, 1 << 24) as u32;
    object.pass(&["seed", "jitter", "strength", "dimension", "scramble"]);
    scene.finish(object);
    Ok(())
}

impl Frame {
    /// Writes these settings into a scene.
    pub(super) fn apply(self, scene: &mut SceneDesc) {
        let film = &mut scene.film;
        [film.width, film.height] = self.size;
        film.crop = self.crop;
        film.antialias = Antialias::MonteCarlo;
        film.samples = self.samples;
        (film.filter, film.filter_radius) = (self.filter.0, Some(self.filter.1));
        film.transfer = turner::color::Transfer::Srgb;
        film.exposure = self.exposure;
        scene.integrator = self.integrator;
        let camera = self.camera.map(|value| Named { name: None, span: None, value });
        scene.cameras = camera.iter().cloned().collect();
        scene.camera = camera;
    }
}
