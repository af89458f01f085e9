//! Shapes: meshes, full quadrics and curves keep their type, all others become triangles.

mod curve;
mod default_uvs;
mod displacement;
mod fibres;
mod height_field;
mod light_parts;
mod mesh;
mod patch;
mod quadric;
mod subdivision;

use turner::color::Spectrum;
use turner::description::ObjectContent;
use turner::math::DAffine3;
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
pub(super) use fibres::Open as OpenCurves;
use light_parts::LightParts;
use turner::shape::curves::CurveKind;

/// The result of a `Shape` directive.
pub(super) enum Made {
    /// A mesh of its own, and its lights.
    Mesh(MeshData, LightParts),
    /// A mesh that several shapes share, and its lights.
    Shared(MeshId, LightParts),
    /// A shape, the transform from its space to that of pbrt's shape, and the area of its light. As in pbrt, a scaled
    /// shape counts with the area that it has without the scale.
    Shape(ShapeDesc, DAffine3, f64),
    /// One curve of the shape "curves".
    Curve(MeshData, CurveKind),
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
    let displaced = displacement::of_shape(scene, state, name, &params)?;
    let made = match name {
        "trianglemesh" => mesh::triangles(scene, state, &mut params, alpha)?,
        "plymesh" => mesh::ply(scene, state, &params, alpha)?,
        "bilinearmesh" => patch::patches(scene, state, &mut params)?,
        "loopsubdiv" => subdivision::surface(scene, state, &mut params)?,
        "curve" => curve::curve(scene, state, &mut params)?,
        "sphere" | "disk" | "cylinder" | "cone" | "paraboloid" | "hyperboloid" => {
            quadric::quadric(scene, state, name, &params)?
        }
        "heightfield" => height_field::surface(scene, state, &params)?,
        "nurbs" => {
            scene.report.ignored(place, "a NURBS surface: omitted");
            return Ok(());
        }
        other => {
            let all = [
                "sphere",
                "disk",
                "cylinder",
                "cone",
                "paraboloid",
                "hyperboloid",
                "heightfield",
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
    let has_power = !in_object && state.area_light.as_ref().is_some_and(|light| light.has("power"));
    let mut areas = vec![1.0];
    let mesh = match made {
        Made::Nothing => return Ok(()),
        Made::Shape(shape, own, area) => {
            let material = materials(scene, state, alpha, in_object, place, &[area])?.first().copied();
            let ctm: Ctm = state.ctm.map(|m| m * own);
            return scene.place_at(ObjectContent::Shape(shape), material, ctm, place);
        }
        Made::Curve(data, kind) => {
            let material = materials(scene, state, alpha, in_object, place, &[1.0])?.first().copied();
            return fibres::place(scene, state, (data, kind), material, in_object, place);
        }
        Made::Mesh(mut data, parts) => {
            if data.triangles.is_empty() {
                scene.report.doubtful(place, format!("a {} without triangles", printable(name)));
                return Ok(());
            }
            if data.positions.len() > u32::MAX as usize {
                return Err(Fault::at(place, ErrorCode::TooLarge, "a mesh of more than 2^32 vertices"));
            }
            if has_power {
                (areas, data.face_materials) = parts.areas(&data, &state.ctm[0].matrix3);
            }
            scene.mesh(String::new(), data)
        }
        Made::Shared(id, parts) if has_power => {
            let own;
            (areas, own) = with_areas(scene, state, id, &parts, place);
            own.unwrap_or(id)
        }
        Made::Shared(id, _) => id,
    };
    let made = materials(scene, state, alpha, in_object, place, &areas)?;
    let first = made.first().copied();
    let materials = if made.len() > 1 { made.into_iter().map(Some).collect() } else { Vec::new() };
    let (displacement, edge_length) = displaced.unzip();
    let desc = MeshDesc { mesh, materials, edge_length, displacement, ..MeshDesc::default() };
    let desc = ShapeDesc::Mesh(desc);
    scene.place(ObjectContent::Shape(desc), first, state, place)
}

/// The areas of the lights of a shared mesh, and a copy of it whose triangles refer to them, if there are several.
fn with_areas(
    scene: &mut Assembly<'_>,
    state: &State,
    id: MeshId,
    parts: &LightParts,
    place: Place,
) -> (Vec<f64>, Option<MeshId>) {
    let Some(data) = scene.meshes.get(id.index()).map(|m| m.data.clone()) else { return (vec![1.0], None) };
    let (areas, of_triangles) = parts.areas(&data, &state.ctm[0].matrix3);
    if of_triangles.is_empty() {
        return (areas, None);
    }
    if scene.divide(data.positions.len() as u64, place).is_err() {
        let message = "the power of an area light on a large mesh: all its triangles have the same radiance";
        scene.report.approximated(place, message);
        return (vec![areas.iter().sum::<f64>() / areas.len() as f64], None);
    }
    let name = scene.meshes.get(id.index()).map_or_else(String::new, |m| m.uri.clone());
    let copy = MeshData { face_materials: of_triangles, ..(*data).clone() };
    (areas, Some(scene.mesh(name, copy)))
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

/// The state's material as this shape uses it, once for each of the areas of its lights.
fn materials(
    scene: &mut Assembly<'_>,
    state: &State,
    alpha: Option<ColorSource>,
    in_object: bool,
    place: Place,
    areas: &[f64],
) -> Result<Vec<MaterialId>, Fault> {
    let mut usage = Use { alpha, ..Use::default() };
    let mut emissions = vec![None];
    if let Some(light) = &state.area_light {
        if in_object {
            // As in pbrt.
            scene.report.ignored(place, "an area light inside an instanced object: it emits no light");
        } else {
            emissions = lights::area(scene, state, light, areas)?;
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
    let mut wanted = |emission| scene.materials.wanted(state.material, Use { emission, ..usage.clone() });
    Ok(emissions.into_iter().map(&mut wanted).collect())
}
