//! Shapes: spheres, rectangles, disks, cylinders, curves and distance grids keep their type, all others become triangles.

use std::f64::consts::PI;

use turner::description::ObjectContent;
use turner::math::{DAffine3, DMat3, DVec3};
use turner::schema::{ErrorCode, GroupId, MaterialId, MeshData, MeshId};
use turner::shape::mesh::MeshDesc;
use turner::shape::{CylinderDesc, DiskDesc, RectangleDesc, ShapeDesc, SphereDesc};

use super::assembly::Assembly;
use super::document::Document;
use super::materials::Use;
use super::meshes::{self, Made};
use super::params::Object;
use super::textures::Surface;
use super::{emitters, media};
use crate::scene_import::report::Fault;
use crate::scene_import::{ALONG, AROUND, Surface as Round, orient, unknown, upright};

/// Known shapes that are not supported.
const UNSUPPORTED: &[&str] = &["ellipsoids", "ellipsoidsmesh", "heightfield", "deformable"];

/// Shapes that are supported, for messages.
const KNOWN: &[&str] = &[
    "sphere",
    "rectangle",
    "disk",
    "cube",
    "cylinder",
    "obj",
    "ply",
    "serialized",
    "shapegroup",
    "instance",
    "merge",
    "bsplinecurve",
    "linearcurve",
    "hair",
    "sdfgrid",
];

/// Deepest nesting of groups.
const MAX_NESTING: u32 = 16;

/// Adds a shape.
pub(super) fn add(scene: &mut Assembly<'_>, object: &Object) -> Result<(), Fault> {
    add_to(scene, object, 0)
}

fn add_to(scene: &mut Assembly<'_>, object: &Object, depth: u32) -> Result<(), Fault> {
    let place = object.place;
    if depth > MAX_NESTING {
        let message = format!("groups nest deeper than {MAX_NESTING}");
        return Err(Fault::at(place, ErrorCode::TooLarge, message));
    }
    // For differentiable rendering.
    object.pass(&["silhouette_sampling_weight"]);
    let kind = object.kind.as_str();
    match kind {
        // A group is rendered by its instances only.
        "shapegroup" => return Ok(()),
        "instance" => return instance(scene, object, depth),
        "merge" => {
            for child in object.objects(&["shape"])? {
                let child = Object::new(&scene.document, child)?;
                add_to(scene, &child, depth + 1)?;
            }
            scene.finish(object);
            return Ok(());
        }
        kind if UNSUPPORTED.contains(&kind) => {
            object.pass_all();
            scene.report.ignored(place, format!("{} is not supported", object.title()));
            return Ok(());
        }
        _ => {}
    }
    let mut to_world = object.transform("to_world")?;
    let flip = object.boolean("flip_normals")?.unwrap_or(false);
    let (content, own, surface) = match kind {
        "sphere" => sphere(scene, object, flip)?,
        "rectangle" => match area_light(object, &to_world)?.filter(|_| !flip) {
            Some(light) => {
                to_world = DAffine3::IDENTITY;
                (ShapeDesc::Rectangle(light), DAffine3::IDENTITY, Surface::Same)
            }
            None => {
                let id = shared(scene, "\0rectangle", flip, meshes::rectangle);
                (mesh_of(id), DAffine3::IDENTITY, Surface::Same)
            }
        },
        "disk" => {
            let (normal, surface) =
                if flip { (DVec3::NEG_Z, Surface::PolarBehind) } else { (DVec3::Z, Surface::Polar) };
            let disk = DiskDesc { normal, polar: true, ..DiskDesc::default() };
            (ShapeDesc::Disk(disk), DAffine3::IDENTITY, surface)
        }
        "cylinder" => match cylinder(scene, object, flip)? {
            Some(made) => made,
            None => return Ok(()),
        },
        "cube" => {
            let id = shared(scene, "\0cube", flip, meshes::cube);
            (mesh_of(id), DAffine3::IDENTITY, Surface::Same)
        }
        "bsplinecurve" | "linearcurve" => {
            let curves = super::hair::curves(scene, object)?;
            (ShapeDesc::Curves(curves), DAffine3::IDENTITY, Surface::Same)
        }
        "hair" => {
            let curves = super::hair::polylines(scene, object, &to_world)?;
            (ShapeDesc::Curves(curves), DAffine3::IDENTITY, Surface::Same)
        }
        "sdfgrid" => match super::distance_grids::shape(scene, object)? {
            Some(grid) => (grid, DAffine3::IDENTITY, Surface::Point),
            None => {
                object.pass_all();
                return Ok(());
            }
        },
        "obj" | "ply" | "serialized" => {
            let mirrored = to_world.matrix3.determinant() < 0.0;
            match meshes::of_file(scene, object, flip, mirrored)? {
                Made::Nothing => return Ok(()),
                Made::Mesh(id, surface) => (mesh_of(id), DAffine3::IDENTITY, surface),
            }
        }
        other => return Err(unknown("shape", other, KNOWN).or_at(place)),
    };
    let material = material(scene, object, surface)?;
    scene.finish(object);
    scene.shapes += 1;
    let mut at = to_world * own;
    let mut content = content;
    if let ShapeDesc::Sphere(sphere) = &mut content
        && let Some(scale) = similarity(&at)
        && !has_directions(&scene.document, object.node)
    {
        // Spheres without a transform are faster.
        *sphere = SphereDesc { center: at.translation, radius: sphere.radius * scale };
        at = DAffine3::IDENTITY;
    }
    scene.place_at(ObjectContent::Shape(content), Some(material), [at, at], place)
}

/// The factor by which a transform scales all lengths, if it keeps angles and does not mirror.
fn similarity(m: &DAffine3) -> Option<f64> {
    let scale = m.matrix3.x_axis.length();
    let product = m.matrix3.transpose() * m.matrix3;
    let difference = product.to_cols_array().into_iter().zip(DMat3::IDENTITY.to_cols_array());
    let is_near = difference.map(|(a, b)| (a / (scale * scale) - b).abs()).all(|d| d < 1e-9);
    (is_near && scale.is_finite() && m.matrix3.determinant() > 0.0).then_some(scale)
}

/// Whether an element contains a texture or an anisotropic BSDF, so that (u, v) count.
fn has_directions(document: &Document, index: usize) -> bool {
    /// Most elements to look at.
    const MOST: usize = 1000;
    let mut open = vec![index];
    let mut seen = 0;
    while let Some(index) = open.pop() {
        seen += 1;
        let Some(node) = document.resolve(index).ok().and_then(|index| document.node(index)) else {
            return true;
        };
        let is_along =
            node.attribute("name").is_some_and(|name| matches!(name, "alpha_u" | "alphaU" | "anisotropic"));
        // A measured BRDF may depend on the azimuth.
        let is_measured = node.attribute("type") == Some("measured");
        if node.tag == "texture" || is_along || is_measured || seen > MOST {
            return true;
        }
        open.extend(&node.children);
    }
    false
}

fn mesh_of(mesh: MeshId) -> ShapeDesc {
    ShapeDesc::Mesh(MeshDesc { mesh, ..MeshDesc::default() })
}

/// A mesh that all shapes of this name share; it is no file name.
fn shared(scene: &mut Assembly<'_>, name: &str, flip: bool, make: impl Fn() -> MeshData) -> MeshId {
    let key = (name.to_owned(), flip);
    if let Some(Some(known)) = scene.mesh_ids.get(&key) {
        return *known;
    }
    let mut data = make();
    if flip {
        orient(&mut data, true);
    }
    let id = scene.mesh(String::new(), data);
    scene.mesh_ids.insert(key, Some(id));
    id
}

/// A shape, the transform from its space to that of Mitsuba's shape, and how its (u, v) relate to Mitsuba's.
type Placed = (ShapeDesc, DAffine3, Surface);

fn sphere(scene: &mut Assembly<'_>, object: &Object, flip: bool) -> Result<Placed, Fault> {
    let center = object.vector("center")?.unwrap_or(DVec3::ZERO);
    let radius = object.float("radius")?.unwrap_or(1.0).abs().clamp(1e-30, 1e30);
    let to_center = DAffine3::from_translation(center);
    if !flip {
        let sphere = SphereDesc { center: DVec3::ZERO, radius };
        return Ok((ShapeDesc::Sphere(sphere), to_center * upright(), Surface::Flipped));
    }
    scene.report.approximated(object.place, "a sphere with flipped normals: rendered as triangles");
    scene.divide(u64::from(AROUND + 1) * u64::from(ALONG + 1), object.place)?;
    let id =
        shared(scene, "\0sphere", true, || Round::Sphere { radius: 1.0, from: PI, to: 0.0 }.cut(2.0 * PI));
    Ok((mesh_of(id), to_center * DAffine3::from_scale(DVec3::splat(radius)), Surface::Flipped))
}

fn cylinder(scene: &mut Assembly<'_>, object: &Object, flip: bool) -> Result<Option<Placed>, Fault> {
    let from = object.vector("p0")?.unwrap_or(DVec3::ZERO);
    let to = object.vector("p1")?.unwrap_or(DVec3::Z);
    let radius = object.float("radius")?.unwrap_or(1.0).abs().clamp(1e-30, 1e30);
    let Some(axis) = (to - from).try_normalize() else {
        scene.report.doubtful(object.place, "a cylinder of length 0: omitted");
        return Ok(None);
    };
    // Maps z to the axis.
    let frame = turner::math::Frame::from_z(axis);
    let matrix = turner::math::DMat3::from_cols(frame.x, frame.y, frame.z);
    let lie = DAffine3::from_mat3_translation(matrix, from);
    let length = (to - from).length();
    if !flip {
        let cylinder = CylinderDesc { from: DVec3::ZERO, to: DVec3::Y * length, radius, capped: false };
        return Ok(Some((ShapeDesc::Cylinder(cylinder), lie * upright(), Surface::Same)));
    }
    scene.report.approximated(object.place, "a cylinder with flipped normals: rendered as triangles");
    scene.divide(u64::from(AROUND + 1) * u64::from(ALONG + 1), object.place)?;
    let id = shared(scene, "\0cylinder", true, || {
        Round::Cylinder { radius: 1.0, from: 0.0, to: 1.0 }.cut(2.0 * PI)
    });
    let scale = DAffine3::from_scale(DVec3::new(radius, radius, length));
    Ok(Some((mesh_of(id), lie * scale, Surface::Same)))
}

/// The shape's material: its BSDF with its emitter and its media.
fn material(scene: &mut Assembly<'_>, object: &Object, surface: Surface) -> Result<MaterialId, Fault> {
    let mut usage = Use { surface, ..Use::default() };
    if let Some(emitter) = object.object("emitter")? {
        usage.emission = emitters::area(scene, &emitter, surface)?;
    }
    if let Some((interior, _)) = object.find("interior") {
        usage.interior = media::medium(scene, interior)?;
    }
    if let Some((exterior, _)) = object.find("exterior") {
        // The medium outside a shape is that inside of another one, or around the camera.
        media::medium(scene, exterior)?;
    }
    let bsdfs = object.objects(&["bsdf"])?;
    if bsdfs.len() > 1 {
        scene.report.doubtful(object.place, "a shape with several BSDFs: the first one is used");
    }
    if !object.objects(&["subsurface"])?.is_empty() {
        scene.report.ignored(object.place, "the subsurface scattering of Mitsuba 0.6");
    }
    Ok(scene.materials.wanted(bsdfs.first().copied(), usage))
}

fn instance(scene: &mut Assembly<'_>, object: &Object, depth: u32) -> Result<(), Fault> {
    let to_world = object.transform("to_world")?;
    let groups = object.objects(&["shape"])?;
    let Some(&group) = groups.first() else {
        return Err(Fault::at(object.place, ErrorCode::MissingKey, "an instance needs a shapegroup"));
    };
    let group = Object::new(&scene.document, group)?;
    scene.finish(object);
    let Some(id) = shape_group(scene, &group, depth)? else { return Ok(()) };
    scene.place_at(ObjectContent::Instance(id), None, [to_world, to_world], object.place)
}

/// A group, made for its first instance; `None` if it is empty.
fn shape_group(scene: &mut Assembly<'_>, object: &Object, depth: u32) -> Result<Option<GroupId>, Fault> {
    if object.kind != "shapegroup" {
        let message = format!("an instance of {}; expected a shapegroup", object.title());
        return Err(Fault::at(object.place, ErrorCode::WrongType, message));
    }
    match scene.shape_groups.get(&object.node) {
        Some(Some(known)) => return Ok(Some(*known)),
        Some(None) => {
            let message = "a shapegroup that contains itself or is empty";
            return Err(Fault::at(object.place, ErrorCode::Syntax, message));
        }
        None => {}
    }
    scene.shape_groups.insert(object.node, None);
    let first = scene.objects.len();
    for child in object.objects(&["shape"])? {
        let child = Object::new(&scene.document, child)?;
        add_to(scene, &child, depth + 1)?;
    }
    scene.finish(object);
    if scene.objects.len() == first {
        scene.report.doubtful(object.place, "a shapegroup without shapes");
        return Ok(None);
    }
    let name = object.id().unwrap_or_default();
    let id = scene.group(&name, first, object.place)?;
    scene.shape_groups.insert(object.node, Some(id));
    Ok(Some(id))
}

/// An emissive rectangle in world space: as one shape it is sampled as one area light. `None` if it does not emit; it
/// then becomes two triangles, which are traced and shaded in batches.
fn area_light(object: &Object, to_world: &DAffine3) -> Result<Option<RectangleDesc>, Fault> {
    let emits = object.object("emitter")?.is_some();
    // A transform that mirrors would flip the normal, edge_u x edge_v.
    let is_kept = emits && to_world.matrix3.determinant() > 0.0;
    Ok(is_kept.then(|| RectangleDesc {
        center: to_world.translation,
        edge_u: to_world.matrix3.x_axis * 2.0,
        edge_v: to_world.matrix3.y_axis * 2.0,
    }))
}
