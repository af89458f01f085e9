//! Lights, and the emission of shapes.

use std::sync::Arc;

use turner::color::Spectrum;
use turner::light::{Attenuation, DirectionalDesc, EnvironmentDesc, LightDesc, PointDesc, SpotDesc};
use turner::math::DVec3;
use turner::schema::{ColorSource, LightProfile, ProfileFile};
use turner::texture::Wrap;

use super::assembly::Assembly;
use super::environment;
use super::params::Object;
use super::projected;
use super::sky;
use super::spectra::Role;
use super::textures::{Surface, is_source, source};
use crate::scene_import::report::Fault;
use crate::scene_import::{environment_light, unknown};

/// Falls off with 1/d².
pub(super) const INVERSE_SQUARE: Attenuation = Attenuation { coefficients: [0.0, 0.0, 1.0] };

/// The emission of the outer side of a surface.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Emission {
    pub(super) radiance: ColorSource,
}

/// The emission of a shape by its emitter.
pub(super) fn area(
    scene: &mut Assembly<'_>,
    emitter: &Object,
    on: Surface,
) -> Result<Option<Emission>, Fault> {
    if emitter.kind != "area" {
        if emitter.kind == "directionalarea" {
            emitter.pass_all();
            scene.report.ignored(emitter.place, "a directionalarea emitter: it emits no light");
            return Ok(None);
        }
        return Err(
            unknown("emitter of a shape", &emitter.kind, &["area", "directionalarea"]).or_at(emitter.place)
        );
    }
    emitter.pass(&["sampling_weight"]);
    let radiance = match light_source(emitter, "radiance")? {
        Some(node) => source(scene, node, Role::Light, on)?,
        None => ColorSource::Constant(Spectrum::WHITE),
    };
    scene.finish(emitter);
    Ok((radiance != ColorSource::Constant(Spectrum::BLACK)).then_some(Emission { radiance }))
}

fn light_source(object: &Object, name: &'static str) -> Result<Option<usize>, Fault> {
    let Some((index, _)) = object.find(name) else { return Ok(None) };
    let node = object.document.resolve(index)?;
    Ok(object.document.node(node).filter(|n| is_source(&n.tag)).map(|_| node))
}

pub(super) fn light_color(
    scene: &mut Assembly<'_>,
    object: &Object,
    name: &'static str,
) -> Result<Spectrum, Fault> {
    match light_source(object, name)? {
        Some(node) => match source(scene, node, Role::Light, Surface::Same)? {
            ColorSource::Constant(c) => Ok(c),
            ColorSource::Texture(_) => {
                scene.report.ignored(
                    object.place_of(name),
                    format!("a texture as {name} of {}: white replaces it", object.title()),
                );
                Ok(Spectrum::WHITE)
            }
        },
        None => Ok(Spectrum::WHITE),
    }
}

/// Adds a light.
pub(super) fn add(scene: &mut Assembly<'_>, object: &Object) -> Result<(), Fault> {
    let place = object.place;
    object.pass(&["sampling_weight"]);
    let light = match object.kind.as_str() {
        "point" => {
            let to_world = object.transform("to_world")?;
            let own = object.vector("position")?.unwrap_or(DVec3::ZERO);
            let color = light_color(scene, object, "intensity")?;
            Some(LightDesc::Point(PointDesc {
                position: to_world.transform_point3(own),
                color,
                attenuation: INVERSE_SQUARE,
                ..PointDesc::default()
            }))
        }
        "spot" => spot(scene, object)?,
        "projector" => projected::projector(scene, object)?,
        "directionalarea" => {
            object.pass_all();
            scene.report.ignored(place, "a directionalarea emitter: it emits no light");
            None
        }
        "directional" => {
            let to_world = object.transform("to_world")?;
            let own = object.vector("direction")?;
            let direction = own.unwrap_or(to_world.transform_vector3(DVec3::Z));
            let color = light_color(scene, object, "irradiance")?;
            match direction.try_normalize() {
                Some(direction) => Some(LightDesc::Directional(DirectionalDesc {
                    direction: Some(direction),
                    color,
                    ..DirectionalDesc::default()
                })),
                None => {
                    scene.report.doubtful(place, "a directional light without a direction: omitted");
                    None
                }
            }
        }
        "constant" => {
            let tint = light_color(scene, object, "radiance")?;
            let file = Some(environment_light::white(scene));
            Some(LightDesc::Environment(EnvironmentDesc { file, tint, ..EnvironmentDesc::default() }))
        }
        "envmap" => envmap(scene, object)?,
        "sky" | "sun" | "sunsky" => Some(sky::light(scene, object)?),
        "area" => {
            object.pass_all();
            scene.report.ignored(place, "an area emitter outside a shape");
            None
        }
        other => {
            let all = [
                "area",
                "point",
                "constant",
                "envmap",
                "spot",
                "projector",
                "directional",
                "directionalarea",
                "sunsky",
            ];
            return Err(unknown("emitter", other, &all).or_at(place));
        }
    };
    scene.finish(object);
    scene.lights.extend(light.map(Into::into));
    Ok(())
}

/// A spot light. The intensity falls linearly with the angle from the beam width to the cutoff, which a light
/// profile of four angles expresses exactly.
fn spot(scene: &mut Assembly<'_>, object: &Object) -> Result<Option<LightDesc>, Fault> {
    let to_world = object.transform("to_world")?;
    let cutoff = object.float("cutoff_angle")?.unwrap_or(20.0).clamp(1e-3, 180.0);
    let beam = object.float("beam_width")?.unwrap_or(cutoff * 0.75).clamp(0.0, cutoff);
    let slide = projected::slide(scene, object)?;
    let color = light_color(scene, object, "intensity")?;
    let position = to_world.translation;
    let Some(axis) = to_world.transform_vector3(DVec3::Z).try_normalize() else {
        scene.report.doubtful(object.place, "a spot light without a direction: omitted");
        return Ok(None);
    };
    let mut steps = vec![(0.0, 1.0), (beam, 1.0), (cutoff, 0.0), (180.0, 0.0)];
    steps.dedup_by(|b, a| b.0 - a.0 < 1e-9);
    let (angles, values): (Vec<f64>, Vec<f32>) = steps.into_iter().unzip();
    let profile = LightProfile::new(angles, vec![0.0], values).ok();
    let look_at = position + axis * (1.0 + position.abs().max_element());
    Ok(Some(LightDesc::Spot(SpotDesc {
        position,
        look_at,
        angle: cutoff,
        penumbra: if profile.is_some() { 0.0 } else { cutoff - beam },
        color,
        attenuation: INVERSE_SQUARE,
        ies: profile.map(|data| ProfileFile { uri: String::new(), data: Arc::new(data) }),
        image: slide.map(|slide| slide.image),
        image_wrap: slide.map_or(Wrap::Clamp, |slide| slide.wrap),
        image_fov: Some((2.0 * cutoff).min(180.0)),
        image_aspect: Some(1.0),
        // Row 0 is at v = 0, where y is negative.
        image_up: -to_world.matrix3.y_axis,
        ..SpotDesc::default()
    })))
}

fn envmap(scene: &mut Assembly<'_>, object: &Object) -> Result<Option<LightDesc>, Fault> {
    let to_world = object.transform("to_world")?;
    let strength = object.float("scale")?.unwrap_or(1.0).clamp(0.0, 1e30);
    object.pass(&["mis_compensation", "gamma", "cache"]);
    let place = object.place_of("filename");
    let mut name = object.string("filename")?.map(str::to_owned);
    if name.is_none()
        && let Some(bitmap) = object.object("texture")?
    {
        name = bitmap.string("filename")?.map(str::to_owned);
    }
    let Some(name) = name else {
        scene.report.ignored(object.place, "an envmap without filename: it emits no light");
        return Ok(None);
    };
    let name = scene.picture_name(&name);
    let made = environment::light(scene, &name, to_world.matrix3, place);
    Ok(made.map(|light| LightDesc::Environment(EnvironmentDesc { strength, ..light })))
}
