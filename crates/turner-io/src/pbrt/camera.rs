//! Cameras.

use turner::camera::{
    CameraDesc, EquirectangularDesc, Handedness, MAX_SHIFT, OrthographicDesc, PanoramaMapping, PinholeDesc,
    RealisticDesc, ThinLensDesc, Viewport,
};
use turner::math::{DVec2, DVec3};
use turner::schema::{ErrorCode, Named};

use super::assembly::Assembly;
use super::params::Params;
use super::report::Fault;
use super::state::State;
use super::transform::{half_height, is_sound};
use crate::assets::printable;

/// Position and orientation of a camera.
struct Pose {
    position: DVec3,
    look_at: DVec3,
    up: DVec3,
    /// The x axis of camera space.
    right: DVec3,
    handedness: Handedness,
    /// World length of one unit of camera space along the viewing direction.
    unit: f64,
}

/// The screen at distance 1.
#[derive(Clone, Copy)]
struct Screen {
    half: DVec2,
    /// Offset of its centre to the right and up, as a fraction of its size.
    shift: DVec2,
    is_own: bool,
}

impl Screen {
    /// Its size times a factor. Unless the file gives both sides, its width follows the film.
    fn viewport(self, by: f64) -> Viewport {
        if self.is_own {
            Viewport::Size(self.half * 2.0 * by)
        } else {
            Viewport::Height(self.half.y * 2.0 * by)
        }
    }
}

/// Defines the camera of the file. The state's transform maps world space to camera space.
pub(super) fn define(
    scene: &mut Assembly<'_>,
    state: &State,
    name: &str,
    params: Params,
) -> Result<(), Fault> {
    let place = params.place;
    if state.ctm[0] != state.ctm[1] {
        scene.report.approximated(place, "camera motion: the start position is used");
    }
    let pose = pose(scene, state, &params)?;
    scene.frame.shutter =
        [params.float("shutteropen").unwrap_or(0.0), params.float("shutterclose").unwrap_or(1.0)];
    scene.frame.medium.clone_from(&state.media[1]);
    let screen = screen(scene, &params);
    let camera = match name {
        "perspective" => perspective(&params, pose, screen),
        "orthographic" => {
            if params.float("lensradius").is_some_and(|r| r > 0.0) {
                let message = "the lens of an orthographic camera: no defocus";
                scene.report.ignored(params.place_of("lensradius"), message);
            }
            params.pass(&["focaldistance", "fov"]);
            let viewport = screen.viewport(pose.unit);
            let Pose { position, look_at, up, handedness, unit, .. } = pose;
            let aside = 2.0 * screen.half * screen.shift * unit;
            let right = match handedness {
                Handedness::Right => (look_at - position).cross(up),
                Handedness::Left => up.cross(look_at - position),
            };
            let aside = right.normalize_or_zero() * aside.x + up.normalize_or_zero() * aside.y;
            let (position, look_at) = (position + aside, look_at + aside);
            CameraDesc::Orthographic(OrthographicDesc {
                motion: None,
                position,
                look_at,
                up,
                handedness,
                viewport,
                near: 0.0,
                far: None,
            })
        }
        "spherical" | "environment" => {
            match params.string("mapping").unwrap_or(if name == "spherical" {
                "equalarea"
            } else {
                "equirectangular"
            }) {
                "equirectangular" => spherical(&pose),
                "equalarea" => {
                    let Pose { position, look_at, up, handedness, .. } = pose;
                    let mapping = PanoramaMapping::EqualArea;
                    let desc = EquirectangularDesc {
                        position,
                        look_at,
                        up,
                        handedness,
                        mapping,
                        ..Default::default()
                    };
                    CameraDesc::Equirectangular(desc)
                }
                other => {
                    let all = ["equalarea", "equirectangular"];
                    return Err(
                        super::reader::unknown("mapping", other, &all).or_at(params.place_of("mapping"))
                    );
                }
            }
        }
        "realistic" => {
            let Pose { position, look_at, up, handedness, unit, .. } = pose;
            let desc = RealisticDesc { position, look_at, up, handedness, ..RealisticDesc::default() };
            CameraDesc::Realistic(super::lens::realistic(scene, &params, desc, unit)?)
        }
        other => {
            let fault = super::reader::unknown(
                "camera",
                other,
                &["perspective", "orthographic", "spherical", "realistic"],
            );
            return Err(fault.or_at(place));
        }
    };
    params.finish(&format!("the camera \"{}\"", printable(name)), &mut scene.report);
    scene.frame.camera = Some(Named { name: None, span: None, value: camera });
    Ok(())
}

fn pose(scene: &mut Assembly<'_>, state: &State, params: &Params) -> Result<Pose, Fault> {
    if !is_sound(&state.ctm[0]) {
        let message = "the camera's transform is not invertible";
        return Err(Fault::at(params.place, ErrorCode::Transform, message));
    }
    let to_world = state.ctm[0].inverse();
    let [right, up, forward] = [to_world.matrix3.x_axis, to_world.matrix3.y_axis, to_world.matrix3.z_axis];
    let lengths = [right, up, forward].map(DVec3::length);
    let unit = lengths[2];
    let askew =
        [right.dot(up), up.dot(forward), forward.dot(right)].iter().any(|d| d.abs() > 1e-3 * unit * unit);
    if askew || lengths.iter().any(|l| (l / unit - 1.0).abs() > 1e-3) {
        scene.report.approximated(
            params.place,
            "the camera's transform has shear or non-uniform scale: the camera uses its position and directions only",
        );
    }
    let handedness = if to_world.matrix3.determinant() < 0.0 { Handedness::Right } else { Handedness::Left };
    let position = to_world.translation;
    // Far enough that rounding does not change the direction.
    let look_at = position + forward / unit * (1.0 + position.abs().max_element());
    Ok(Pose { position, look_at, up, right, handedness, unit })
}

/// Half the size of the screen, whose shorter side is 2 unless the file sets it; its shift; whether the file sets it.
fn screen(scene: &mut Assembly<'_>, params: &Params) -> Screen {
    let aspect = params.float("frameaspectratio").filter(|a| *a > 0.0).unwrap_or(scene.frame.aspect());
    let mut half = if aspect > 1.0 { DVec2::new(aspect, 1.0) } else { DVec2::new(1.0, 1.0 / aspect) };
    let mut shift = DVec2::ZERO;
    if let &[x0, x1, y0, y1] = params.floats("screenwindow") {
        let window = DVec2::new(x1 - x0, y1 - y0) / 2.0;
        if window.min_element() > 0.0 {
            half = window;
        }
        let by = DVec2::new(x0 + x1, y0 + y1) / (4.0 * half);
        if by.abs().max_element() <= MAX_SHIFT {
            shift = by;
        } else {
            let message = "a screen window far off centre: it is centred";
            scene.report.ignored(params.place_of("screenwindow"), message);
        }
    }
    Screen { half, shift, is_own: params.has("screenwindow") || params.has("frameaspectratio") }
}

/// pbrt's columns are azimuths 2πu from +x towards +z: the centre of the picture is −x, and what is right of it is
/// mirrored.
fn spherical(pose: &Pose) -> CameraDesc {
    let Pose { position, up, right, handedness, .. } = *pose;
    let look_at = position - right.normalize_or(DVec3::X) * (1.0 + position.abs().max_element());
    let handedness = match handedness {
        Handedness::Right => Handedness::Left,
        Handedness::Left => Handedness::Right,
    };
    CameraDesc::Equirectangular(EquirectangularDesc {
        position,
        look_at,
        up,
        handedness,
        ..EquirectangularDesc::default()
    })
}

fn perspective(params: &Params, pose: Pose, screen: Screen) -> CameraDesc {
    let fov = params.float("fov").or_else(|| params.float("halffov").map(|v| 2.0 * v)).unwrap_or(90.0);
    let radius = params.float("lensradius").unwrap_or(0.0);
    let focus = params.float("focaldistance").unwrap_or(1e6);
    let lens = (radius > 0.0 && focus > 0.0).then_some((radius, focus));
    perspective_of(pose, half_height(fov), screen, lens)
}

fn perspective_of(pose: Pose, half: f64, screen: Screen, lens: Option<(f64, f64)>) -> CameraDesc {
    let Pose { position, look_at, up, handedness, unit, .. } = pose;
    let viewport = Some(screen.viewport(half));
    let (fov, distance, near) = (None, Some(1.0), 0.0);
    match lens {
        None => CameraDesc::Pinhole(PinholeDesc {
            motion: None,
            position,
            look_at,
            up,
            handedness,
            fov,
            viewport,
            distance,
            shift: screen.shift,
            near,
            far: None,
        }),
        Some((radius, focus)) => CameraDesc::ThinLens(ThinLensDesc {
            position,
            look_at,
            up,
            handedness,
            fov,
            viewport,
            distance,
            shift: screen.shift,
            lens_radius: radius * unit,
            focus_distance: Some(focus * unit),
            near,
            ..ThinLensDesc::default()
        }),
    }
}
