//! Shapes: meshes and full quadrics keep their type, all others become triangles.

mod curve;
mod mesh;
mod patch;
mod quadric;
mod subdivision;

use turner::color::Spectrum;
use turner::description::ObjectContent;
use turner::math::DMat3;
use turner::schema::{ColorSource, ErrorCode, MaterialId, MeshData, MeshId};
use turner::shape::ShapeDesc;
use turner::shape::mesh::MeshDesc;

use super::assembly::Assembly;
use super::lights;
use super::materials::Use;
use super::params::{Params, Type};
use super::report::Fault;
use super::source::Place;
use super::state::{Ctm, State};
use super::textures::source_named;
use crate::assets::printable;
use crate::scene_import::orient;

/// The result of a `Shape` directive.
pub(super) enum Made {
    /// A mesh of its own.
    Mesh(MeshData),
    /// A mesh that several shapes share.
    Shared(MeshId),
    /// A shape, and the transform from its space to that of pbrt's shape.
    Shape(ShapeDesc, turner::math::DAffine3),
    /// Nothing, after a report.
    Nothing,
}

/// Adds a shape.
pub(super) fn add(
    scene: &mut Assembly<'_>,
    state: &State,
    name: &str,
    mut params: Params,
    in_object: bool,
) -> Result<(), Fault> {
    let place = params.place;
    let alpha = alpha(scene, &params)?;
    let made = match name {
        "trianglemesh" => mesh::triangles(scene, state, &mut params)?,
        "plymesh" => mesh::ply(scene, state, &params)?,
        "bilinearmesh" => patch::patches(scene, state, &mut params)?,
        "loopsubdiv" => subdivision::surface(scene, state, &mut params)?,
        "curve" => curve::curve(scene, state, &mut params)?,
        "sphere" | "disk" | "cylinder" => quadric::quadric(scene, state, name, &params)?,
        other => {
            let all = [
                "sphere",
                "disk",
                "cylinder",
                "trianglemesh",
                "plymesh",
                "bilinearmesh",
                "loopsubdiv",
                "curve",
            ];
            return Err(super::reader::unknown("shape", other, &all).or_at(place));
        }
    };
    params.finish(&format!("the shape \"{}\"", printable(name)), &mut scene.report);
    scene.shapes += 1;
    let unseen = matches!(&alpha, Some(ColorSource::Constant(a)) if *a == Spectrum::BLACK);
    if let (true, false, Some(light)) = (unseen, in_object, &state.area_light) {
        return lights::unseen(scene, state, light, &made, place);
    }
    let content = match made {
        Made::Nothing => return Ok(()),
        Made::Shape(shape, own) => {
            let area = |m: &DMat3| quadric::area(&shape, m);
            let material = material(scene, state, alpha, in_object, place, area)?;
            let ctm: Ctm = state.ctm.map(|m| m * own);
            return scene.place_at(ObjectContent::Shape(shape), Some(material), ctm, place);
        }
        Made::Mesh(data) => {
            if data.triangles.is_empty() {
                scene.report.doubtful(place, format!("a {} without triangles", printable(name)));
                return Ok(());
            }
            if data.positions.len() > u32::MAX as usize {
                return Err(Fault::at(place, ErrorCode::TooLarge, "a mesh of more than 2^32 vertices"));
            }
            scene.mesh(String::new(), data)
        }
        Made::Shared(id) => id,
    };
    let data = scene.meshes.get(content.index()).map(|m| m.data.clone());
    let area = |m: &DMat3| data.map_or(1.0, |data| mesh::mean_area(&data, m));
    let material = material(scene, state, alpha, in_object, place, area)?;
    let desc = ShapeDesc::Mesh(MeshDesc { mesh: content, smooth: None, materials: Vec::new() });
    scene.place(ObjectContent::Shape(desc), Some(material), state, place)
}

/// The `alpha` of a shape, a number or a texture; `None` if it is opaque.
fn alpha(scene: &mut Assembly<'_>, params: &Params) -> Result<Option<ColorSource>, Fault> {
    params.pass(&["shadowalpha"]);
    if params.is("alpha", Type::Texture) {
        let name = params.texture("alpha").unwrap_or_default().to_owned();
        return source_named(scene, &name, params.place_of("alpha")).map(Some);
    }
    let alpha = params.float("alpha").filter(|a| *a < 1.0);
    Ok(alpha.map(|a| ColorSource::Constant(Spectrum::grey(a.max(0.0) as f32))))
}

/// The state's material as this shape uses it.
fn material(
    scene: &mut Assembly<'_>,
    state: &State,
    alpha: Option<ColorSource>,
    in_object: bool,
    place: Place,
    part_area: impl FnOnce(&DMat3) -> f64,
) -> Result<MaterialId, Fault> {
    let mut usage = Use { alpha, ..Use::default() };
    if let Some(light) = &state.area_light {
        if in_object {
            // As in pbrt.
            scene.report.ignored(place, "an area light inside an instanced object: it emits no light");
        } else {
            usage.emission = lights::area(scene, state, light, part_area)?;
        }
    }
    let inside = &state.media[0];
    if !inside.is_empty() {
        let Some(&medium) = scene.media.get(inside) else {
            let names: Vec<&str> = scene.media.keys().map(String::as_str).collect();
            return Err(super::reader::unknown("medium", inside, &names).or_at(place));
        };
        if scene.frame.shows_media {
            usage.interior = Some(medium);
        } else {
            let message = "a medium, with an integrator that ignores media: omitted, as in pbrt (volpath renders media)";
            scene.report.doubtful(place, message);
        }
    }
    Ok(scene.materials.wanted(state.material, usage))
}
