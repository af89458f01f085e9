//! Reads a complete scene from its tree of values.
//!
//! Reading continues after an error, with the default in place of the invalid value, so that one run reports all
//! errors.

use super::read::{Reader, SECTIONS, SceneAssets, noted};
use super::read_object::read_object;
use super::read_parts::*;
use crate::animation::read_animation;
use crate::description::*;
use crate::schema::error::escape;
use crate::schema::value::{Data, Span, Table, Value};
use crate::schema::{
    ErrorCode, GroupId, MaterialId, MediumId, Named, ReadContext, SceneError, TableReader, TextureId,
};

/// Reads a complete scene. `root` is the table of the file with its includes already merged.
///
/// Errors: the first one in the order of the files, with up to 99 others as [`SceneError::more`]. Errors that would be
/// consequences of others are not reported.
pub fn read_scene(root: &Value, assets: &mut dyn SceneAssets) -> Result<SceneDesc, SceneError> {
    let mut cx = Reader::new(assets);
    cx.faults = Some(Vec::new());
    let read = read_sections(root, &mut cx);
    let mut errors = cx.faults.take().unwrap_or_default();
    match read {
        Ok(mut desc) if errors.is_empty() => {
            desc.textures.extend(cx.textures.into_iter().flatten());
            desc.materials.extend(cx.materials.into_iter().flatten());
            desc.media.extend(cx.media.into_iter().flatten());
            (desc.images, desc.meshes) = (cx.images, cx.meshes);
            (desc.imports, desc.warnings) = (cx.imports, cx.warnings);
            Ok(desc)
        }
        read => {
            errors.extend(read.err());
            Err(SceneError::all(errors).unwrap_or_else(|| SceneError::new(ErrorCode::Internal, "no error")))
        }
    }
}

/// Reads an optional section; the default if it is invalid.
fn section<T: Default>(
    value: &Value,
    cx: &mut Reader<'_>,
    read: impl FnOnce(&Value, &mut dyn ReadContext) -> Result<T, SceneError>,
) -> Result<T, SceneError> {
    let read = read(value, cx);
    Ok(noted(cx, read)?.unwrap_or_default())
}

/// Reads the items of a list and skips invalid ones.
fn items<T>(
    section: Option<&Value>,
    kind: &str,
    cx: &mut Reader<'_>,
    mut read: impl FnMut(&Value, &mut Reader<'_>) -> Result<T, SceneError>,
) -> Result<Vec<T>, SceneError> {
    let values = noted(cx, array_of_tables(section, kind))?.unwrap_or_default();
    let mut list = Vec::with_capacity(values.len());
    for value in values {
        let item = read(value, cx);
        list.extend(noted(cx, item)?);
    }
    Ok(list)
}

fn named_items<'a>(
    top: &mut TableReader<'a>,
    kind: &'static str,
    cx: &mut Reader<'_>,
) -> Result<Vec<(&'a str, Span, &'a Value)>, SceneError> {
    let section = top.take(kind);
    Ok(noted(cx, named_tables(section, kind))?.unwrap_or_default())
}

/// Reads everything except the lists that the reader holds itself.
fn read_sections(root: &Value, cx: &mut Reader<'_>) -> Result<SceneDesc, SceneError> {
    let mut top = TableReader::of(root, "the scene")?;
    for section in SECTIONS.iter().map(|(section, _)| *section).chain(["stage"]) {
        top.take(section);
    }
    top.finish(cx)?;
    // The film comes first, because its transfer curve decodes hex colours. Some of its defaults depend on the
    // integrator.
    let empty = Value { data: Data::Table(Table::default()), span: root.span };
    let integrator = top.take("integrator").unwrap_or(&empty);
    let film = top.take("film").unwrap_or(&empty);
    let film = section(film, cx, |film, cx| read_film(film, integrator_type(integrator), cx))?;
    cx.transfer = film.transfer;
    let mut groups = read_named(&mut top, cx)?;
    let objects = read_objects(top.take("object"), cx)?;
    groups.append(&mut cx.more_groups);
    let mut lights = items(top.take("light"), "light", cx, |value, cx| read_light(value, cx))?;
    lights.append(&mut cx.model_lights);
    let camera = match top.take("camera").map(|value| read_camera(value, "[camera]", cx)) {
        None => None,
        Some(camera) => noted(cx, camera)?,
    };
    let mut cameras = items(top.take("view"), "view", cx, |value, cx| read_camera(value, "a view", cx))?;
    cameras.append(&mut cx.cameras);
    let animations = items(top.take("animation"), "animation", cx, |value, cx| read_animation(value, cx))?;
    let integrator = section(integrator, cx, read_integrator)?;
    let background = section(top.take("background").unwrap_or(&empty), cx, read_background)?;
    let studio = match top.take_renamed("studio", cx).map(|value| read_studio(value, cx)) {
        None => None,
        Some(studio) => noted(cx, studio)?,
    };
    if objects.is_empty() {
        (cx as &mut dyn ReadContext)
            .warn(None, "the scene has no [[object]]: the picture shows only the background. Add an object; `turner new first` writes an example scene and `turner help scene` describes the format");
    }
    Ok(SceneDesc {
        camera,
        film,
        integrator,
        background,
        textures: Vec::new(),
        materials: Vec::new(),
        media: Vec::new(),
        groups,
        objects,
        lights,
        animations,
        images: Vec::new(),
        meshes: Vec::new(),
        cameras,
        studio,
        imports: Vec::new(),
        warnings: Vec::new(),
    })
}

/// Reads named textures, media and materials into the reader's lists and returns the groups. All names are registered
/// first, so that they can refer to each other.
fn read_named(top: &mut TableReader<'_>, cx: &mut Reader<'_>) -> Result<Vec<Named<GroupDesc>>, SceneError> {
    let textures = named_items(top, "texture", cx)?;
    let materials = named_items(top, "material", cx)?;
    let media = named_items(top, "medium", cx)?;
    let groups = named_items(top, "group", cx)?;
    for (i, (name, key_span, _)) in textures.iter().enumerate() {
        noted(cx, check_texture_name(name, *key_span))?;
        cx.texture_ids.insert((*name).to_owned(), TextureId(i as u32));
        cx.textures.push(None);
    }
    for (i, (name, ..)) in materials.iter().enumerate() {
        cx.material_ids.insert((*name).to_owned(), MaterialId(i as u32));
        cx.materials.push(None);
    }
    for (i, (name, ..)) in media.iter().enumerate() {
        cx.medium_ids.insert((*name).to_owned(), MediumId(i as u32));
        cx.media.push(None);
    }
    for (i, (name, ..)) in groups.iter().enumerate() {
        cx.group_ids.insert((*name).to_owned(), GroupId(i as u32));
    }
    cx.group_count = groups.len() as u32;
    macro_rules! read_all {
        ($list:ident, $read:ident) => {
            for (i, (name, _, value)) in $list.iter().enumerate() {
                let read = $read(value, cx);
                cx.$list[i] = noted(cx, read)?.map(|read| named(name, value, read));
            }
        };
    }
    read_all!(textures, read_texture);
    read_all!(media, read_medium);
    read_all!(materials, read_material);
    let mut group_descs = Vec::with_capacity(groups.len());
    cx.in_group = true;
    for (name, _, value) in &groups {
        let objects = read_group(name, value, cx);
        let objects = noted(cx, objects)?.unwrap_or_default();
        group_descs.push(named(name, value, GroupDesc { objects, model: None }));
    }
    cx.in_group = false;
    Ok(group_descs)
}

fn named<T>(name: &str, value: &Value, read: T) -> Named<T> {
    Named { name: Some(name.to_owned()), span: Some(value.span), value: read }
}

/// Reads the objects of a group.
fn read_group(name: &str, value: &Value, cx: &mut Reader<'_>) -> Result<Vec<ObjectDesc>, SceneError> {
    let mut table = TableReader::of(value, format!("the group \"{}\"", escape(name)))?;
    let objects = read_objects(table.take("object"), cx)?;
    table.finish(cx)?;
    Ok(objects)
}

fn read_objects(section: Option<&Value>, cx: &mut Reader<'_>) -> Result<Vec<ObjectDesc>, SceneError> {
    items(section, "object", cx, read_object)
}
