//! The displacement of a `plymesh`: a float texture in units of the object along the normals, once edges are no longer than
//! `displacement.edgelength` in units of the scene.

use turner::color::Spectrum;
use turner::image::Pixels;
use turner::math::elementary::cbrt;
use turner::schema::{ColorSource, Transform};
use turner::shape::displacement::Displacement;
use turner::texture::{Encoding, ImageDesc, Mapping, TextureDesc, Wrap};

use super::super::assembly::Assembly;
use super::super::params::{Params, Type};
use super::super::report::Fault;
use super::super::state::State;
use super::super::textures::source_named;

/// The displacement of a shape, and its longest edge in units of the object.
pub(super) fn of_shape(
    scene: &mut Assembly<'_>,
    state: &State,
    kind: &str,
    params: &Params,
) -> Result<Option<(Displacement, f64)>, Fault> {
    if kind != "plymesh" {
        return Ok(None);
    }
    let edge = params.float("displacement.edgelength").or_else(|| params.float("edgelength"));
    params.pass(&["displacement", "edgelength", "displacement.edgelength"]);
    if !params.is("displacement", Type::Texture) {
        return Ok(None);
    }
    let place = params.place_of("displacement");
    let name = params.texture("displacement").unwrap_or_default().to_owned();
    let source = source_named(scene, &name, place)?;
    if source == ColorSource::Constant(Spectrum::BLACK) {
        return Ok(None);
    }
    let Some((displacement, decoded)) = of_texture(scene, source) else {
        let message = "the displacement of a plymesh by a texture other than an image over (u, v)";
        scene.report.ignored(place, message);
        return Ok(None);
    };
    if decoded {
        let message = "displacement by an sRGB-encoded image: its values are used without decoding";
        scene.report.approximated(place, message);
    }
    // pbrt measures edges in the space of the scene.
    let scale = cbrt(state.ctm[0].matrix3.determinant().abs());
    let longest = edge.filter(|e| *e > 0.0).unwrap_or(1.0) / scale;
    Ok(longest.is_finite().then_some((displacement, longest)))
}

/// An image texture as displacement, and whether its values would have to be decoded.
fn of_texture(scene: &Assembly<'_>, source: ColorSource) -> Option<(Displacement, bool)> {
    let TextureDesc::Image(image) = scene.texture_desc(source)? else { return None };
    let ImageDesc { file, gain, tint, offset, encoding, .. } = image;
    let grey = |c: &Spectrum| (c.r == c.g && c.g == c.b).then_some(f64::from(c.r));
    let (scale, offset) = (gain * grey(tint)?, grey(offset)?);
    let is_plain = image.wrap == Wrap::Repeat
        && image.mapping == Mapping::Uv
        && image.transform == Transform::IDENTITY
        && image.uv_matrix.is_none()
        && image.density == 1.0;
    if !is_plain || scale == 0.0 {
        return None;
    }
    let pixels = &scene.images.get(file.index())?.data.pixels;
    let decoded = !matches!(pixels, Pixels::F32(_)) && *encoding != Encoding::Linear;
    Some((Displacement { image: *file, scale, midlevel: -offset / scale }, decoded))
}
