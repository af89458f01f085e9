//! Lights, and what shapes emit.
//!
//! Strengths follow pbrt: a light's spectrum is divided by its luminance (what is left of `rgb` is the colour as written), then multiplied with
//! `scale`; `power` and `illuminance` take the place of its own strength. At last comes the exposure of the film.

use std::f64::consts::{PI, TAU};

use turner::color::Spectrum;
use turner::light::{
    Attenuation, DirectionalDesc, EnvironmentDesc, LightDesc, PointDesc, SphereLightDesc, SpotDesc,
};
use turner::math::elementary::{cbrt, cos};
use turner::math::{DMat3, DVec3, radians};
use turner::shape::ShapeDesc;

use super::assembly::Assembly;
use super::environment;
use super::params::Params;
use super::report::Fault;
use super::shapes::Made;
use super::source::Place;
use super::spectra::{Role, color};
use super::state::State;
use crate::assets::printable;
use crate::whole::surroundings;

/// By 1/d².
const INVERSE_SQUARE: Attenuation = Attenuation { coefficients: [0.0, 0.0, 1.0] };

/// The widest cone that a spot may have, degrees.
const MAX_CONE: f64 = 180.0;

/// Adds a light.
pub(super) fn add(scene: &mut Assembly<'_>, state: &State, name: &str, params: Params) -> Result<(), Fault> {
    let place = params.place;
    let to_world = state.ctm[0];
    if state.ctm[0] != state.ctm[1] {
        scene.report.approximated(place, "a light moves: it stands where it begins");
    }
    let mut scale = params.float("scale").unwrap_or(1.0) * scene.frame.exposure();
    let light_color = |scene: &mut Assembly<'_>, name| {
        let found = color(scene, state.color_space, &params, name, Role::Light)?;
        Ok::<_, Fault>(scene.frame.balanced(found.unwrap_or(Spectrum::WHITE)))
    };
    let light: LightDesc = match name {
        "point" | "goniometric" => {
            let color = light_color(scene, "I")?;
            if let Some(power) = params.float("power").filter(|p| *p > 0.0) {
                scale *= power / (4.0 * PI);
            }
            if name == "goniometric" {
                params.pass(&["filename"]);
                scene.report.approximated(place, "a goniometric light shines in all directions alike");
            }
            let from = params.vector("from").unwrap_or(DVec3::ZERO);
            LightDesc::Point(PointDesc {
                position: to_world.transform_point3(from),
                color,
                intensity: sound(scale),
                attenuation: INVERSE_SQUARE,
                ..PointDesc::default()
            })
        }
        "spot" | "projection" => {
            let color = light_color(scene, "I")?;
            let is_projection = name == "projection";
            let (cone, delta) = if is_projection {
                params.pass(&["filename"]);
                scene
                    .report
                    .approximated(place, "a projection light is shown as a spot light without its picture");
                (params.float("fov").unwrap_or(90.0) / 2.0, 0.0)
            } else {
                (params.float("coneangle").unwrap_or(30.0), params.float("conedeltaangle").unwrap_or(5.0))
            };
            let cone = cone.clamp(1e-3, MAX_CONE);
            let delta = delta.clamp(0.0, cone);
            if let Some(power) = params.float("power").filter(|p| *p > 0.0) {
                let (end, start) = (cos(radians(cone)), cos(radians(cone - delta)));
                scale *= power / (TAU * ((1.0 - start) + (start - end) / 2.0));
            }
            let from = if is_projection { DVec3::ZERO } else { params.vector("from").unwrap_or(DVec3::ZERO) };
            let to = if is_projection { DVec3::Z } else { params.vector("to").unwrap_or(DVec3::Z) };
            let (position, look_at) = (to_world.transform_point3(from), to_world.transform_point3(to));
            if position == look_at {
                scene.report.doubtful(place, "a spot light without a direction is left out");
                return Ok(());
            }
            LightDesc::Spot(SpotDesc {
                position,
                look_at,
                angle: cone,
                penumbra: delta,
                color,
                intensity: sound(scale),
                attenuation: INVERSE_SQUARE,
                ..SpotDesc::default()
            })
        }
        "distant" => {
            let color = light_color(scene, "L")?;
            if let Some(illuminance) = params.float("illuminance").filter(|v| *v > 0.0) {
                scale *= illuminance;
            }
            let from = params.vector("from").unwrap_or(DVec3::ZERO);
            let to = params.vector("to").unwrap_or(DVec3::Z);
            let Some(direction) = to_world.transform_vector3(to - from).try_normalize() else {
                scene.report.doubtful(place, "a distant light without a direction is left out");
                return Ok(());
            };
            LightDesc::Directional(DirectionalDesc {
                direction: Some(direction),
                color,
                intensity: sound(scale),
                ..DirectionalDesc::default()
            })
        }
        "infinite" => {
            let illuminance = params.float("illuminance").filter(|v| *v > 0.0);
            if params.has("portal") {
                let message = "the portal of an infinite light: light comes from all around";
                scene.report.approximated(params.place_of("portal"), message);
                params.pass(&["portal"]);
            }
            let file = params.string("filename").map(str::to_owned);
            let color = match &file {
                Some(_) if params.has("L") => {
                    let message =
                        "an infinite light has a picture or a colour L, not both: the picture is taken";
                    scene.report.doubtful(params.place_of("L"), message);
                    params.pass(&["L"]);
                    scene.frame.balanced(Spectrum::WHITE)
                }
                Some(_) => scene.frame.balanced(Spectrum::WHITE),
                None => light_color(scene, "L")?,
            };
            let (image, mean_irradiance) = match file {
                None => (surroundings::white(scene), PI),
                Some(name) => {
                    let Some(made) = environment::equirectangular(
                        scene,
                        &name,
                        to_world.matrix3,
                        params.place_of("filename"),
                    ) else {
                        return Ok(());
                    };
                    made
                }
            };
            if let Some(illuminance) = illuminance {
                scale *= illuminance / mean_irradiance.max(1e-30);
            }
            LightDesc::Environment(EnvironmentDesc {
                file: Some(image),
                strength: sound(scale),
                rotation: 0.0,
                tint: color,
            })
        }
        other => {
            let fault = super::reader::unknown(
                "light",
                other,
                &["point", "spot", "distant", "infinite", "goniometric", "projection"],
            );
            return Err(fault.or_at(place));
        }
    };
    params.finish(&format!("the light \"{}\"", printable(name)), &mut scene.report);
    scene.lights.push(light.into());
    Ok(())
}

/// A strength that a scene may have.
pub(super) fn sound(v: f64) -> f64 {
    if v.is_finite() { v.clamp(0.0, 1e30) } else { 0.0 }
}

/// What a surface emits.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Emission {
    pub(super) color: Spectrum,
    /// Radiance, as a factor of the colour.
    pub(super) radiance: f64,
    pub(super) two_sided: bool,
}

/// A shape that shines but is not there (its alpha is 0): rays pass it, its light is sampled. A whole sphere becomes a light of its own kind; other
/// shapes are reported.
pub(super) fn unseen(
    scene: &mut Assembly<'_>,
    state: &State,
    params: &Params,
    made: &Made,
    place: Place,
) -> Result<(), Fault> {
    let Made::Shape(ShapeDesc::Sphere(sphere), _) = made else {
        scene
            .report
            .ignored(place, "a light that is not seen (alpha 0) and no whole sphere: it does not shine");
        return Ok(());
    };
    let to_world = &state.ctm[0];
    let size = cbrt(to_world.matrix3.determinant().abs());
    let radius = sphere.radius * size;
    let Some(emission) = area(scene, state, params, |_| 4.0 * PI * radius * radius)? else { return Ok(()) };
    if !(radius > 0.0 && radius.is_finite()) {
        scene.report.doubtful(place, "a light without extent is left out");
        return Ok(());
    }
    scene
        .report
        .approximated(place, "a light that is not seen (alpha 0): it shines from all points of a ball");
    // As strong as its radiance times the disk that it is seen as.
    let light = SphereLightDesc {
        center: to_world.transform_point3(DVec3::ZERO),
        radius,
        samples: 1,
        jitter: true,
        color: emission.color,
        intensity: sound(emission.radiance * PI * radius * radius),
        attenuation: INVERSE_SQUARE,
    };
    scene.lights.push(LightDesc::Sphere(light).into());
    Ok(())
}

/// The emission of a shape whose parts have so much surface each, on average.
pub(super) fn area(
    scene: &mut Assembly<'_>,
    state: &State,
    params: &Params,
    part_area: impl FnOnce(&DMat3) -> f64,
) -> Result<Option<Emission>, Fault> {
    let mut radiance = params.float("scale").unwrap_or(1.0) * scene.frame.exposure();
    let color = color(scene, state.color_space, params, "L", Role::Light)?.unwrap_or(Spectrum::WHITE);
    let color = scene.frame.balanced(color);
    let two_sided = params.bool("twosided").unwrap_or(false);
    if let Some(power) = params.float("power").filter(|p| *p > 0.0) {
        let sides = if two_sided { 2.0 } else { 1.0 };
        radiance *= power / (sides * PI * part_area(&state.ctm[0].matrix3).max(1e-30));
    }
    if params.has("filename") {
        params.pass(&["filename"]);
        let message = "the picture of an area light: it shines evenly";
        scene.report.approximated(params.place_of("filename"), message);
    }
    params.pass(&["nsamples", "samples"]);
    params.finish("the area light", &mut scene.report);
    let radiance = radiance.clamp(0.0, 1e15);
    Ok((radiance > 0.0 && radiance.is_finite()).then_some(Emission { color, radiance, two_sided }))
}
