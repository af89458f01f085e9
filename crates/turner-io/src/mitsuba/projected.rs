//! Projectors, and the textures of spot lights: images as slides of a spot.

use std::f64::consts::PI;

use turner::color::Spectrum;
use turner::light::{LightDesc, SlideUnits, SpotDesc};
use turner::math::elementary::atan2;
use turner::math::{DVec2, DVec3};
use turner::schema::ImageId;
use turner::texture::Wrap;

use super::assembly::Assembly;
use super::emitters::{INVERSE_SQUARE, light_color};
use super::frame::screen_height;
use super::params::Object;
use crate::scene_import::environment_light;
use crate::scene_import::report::Fault;

/// The image of a bitmap.
#[derive(Clone, Copy, Debug)]
pub(super) struct Picture {
    pub(super) image: ImageId,
    pub(super) wrap: Wrap,
    /// Width over height.
    aspect: f64,
}

/// The bitmap that an emitter projects. `None` for textures of other types, which are reported as ignored.
pub(super) fn slide(scene: &mut Assembly<'_>, object: &Object) -> Result<Option<Picture>, Fault> {
    let Some(&texture) = object.objects(&["texture"])?.first() else { return Ok(None) };
    let texture = Object::new(&scene.document, texture)?;
    let name = texture.string("filename")?.map(str::to_owned);
    let Some(name) = name.filter(|_| texture.kind == "bitmap") else {
        texture.pass_all();
        let message = format!("{} in an emitter: white replaces it", texture.title());
        scene.report.ignored(texture.place, message);
        return Ok(None);
    };
    if texture.has("to_uv") {
        scene.report.ignored(texture.place_of("to_uv"), "to_uv of the texture of an emitter");
    }
    let wrap = match texture.string("wrap_mode")? {
        Some("clamp") => Wrap::Clamp,
        Some("mirror") => Wrap::Mirror,
        _ => Wrap::Repeat,
    };
    texture.pass(&["raw", "filter_type", "wrap_mode", "to_uv", "accel", "format"]);
    let place = texture.place_of("filename");
    let name = scene.picture_name(&name);
    scene.finish(&texture);
    let Some(image) = scene.image(&name, place) else { return Ok(None) };
    let aspect = scene
        .images
        .get(image.index())
        .map_or(1.0, |a| f64::from(a.data.width.max(1)) / f64::from(a.data.height.max(1)));
    Ok(Some(Picture { image, wrap, aspect }))
}

/// A projector: a spot light around its image. Its values are irradiances over π on a screen at distance 1.
pub(super) fn projector(scene: &mut Assembly<'_>, object: &Object) -> Result<Option<LightDesc>, Fault> {
    let to_world = object.transform("to_world")?;
    let scale = object.float("scale")?.unwrap_or(1.0).clamp(0.0, 1e30);
    let (picture, color) = match slide(scene, object)? {
        Some(picture) => (picture, Spectrum::WHITE),
        // An even light on a square screen.
        None => {
            let color = light_color(scene, object, "irradiance")?;
            let white = environment_light::white(scene);
            (Picture { image: white, wrap: Wrap::Clamp, aspect: 1.0 }, color)
        }
    };
    object.pass(&["irradiance"]);
    let position = to_world.translation;
    let Some(forward) = to_world.transform_vector3(DVec3::Z).try_normalize() else {
        scene.report.doubtful(object.place, "a projector without a direction: omitted");
        return Ok(None);
    };
    let aspect = picture.aspect;
    let across = 0.5 * aspect * screen_height(scene, object, aspect)?;
    let corner = DVec2::new(across, across / aspect).length();
    Ok(Some(LightDesc::Spot(SpotDesc {
        position,
        look_at: position + forward * (1.0 + position.abs().max_element()),
        // A margin, so that rounding does not cut the corners off.
        angle: (atan2(corner, 1.0).to_degrees() * 1.001).min(180.0),
        penumbra: 0.0,
        color,
        intensity: PI * scale,
        attenuation: INVERSE_SQUARE,
        image: Some(picture.image),
        image_fov: Some(2.0 * atan2(across, 1.0).to_degrees()),
        image_aspect: Some(picture.aspect),
        image_wrap: picture.wrap,
        image_up: to_world.matrix3.y_axis,
        image_units: SlideUnits::Irradiance,
        ..SpotDesc::default()
    })))
}
