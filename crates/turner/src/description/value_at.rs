//! The values of parts of a description, by key path.

use super::borrowed_assets::BorrowedAssets;
use super::draft::{object, value_at};
use super::write::{Writer, with_name, write_light};
use crate::description::SceneDesc;
use crate::schema::value::{Data, Table, Value};
use crate::schema::{KeyPart, Named, SceneError};

impl SceneDesc {
    /// The value at a key path, as a scene file would have it: `film`, `object.7`, `object.7.radius`, `material.gold`,
    /// `light.0`, `group.tree.object.2`. Paths are those of [`edit`](SceneDesc::edit), and a value can be the value of
    /// an edit. Keys at their default are absent. Only the named part is written: an object takes the same time in a
    /// scene of ten objects and of ten thousand, apart from the time for the names of materials and textures.
    ///
    /// References are by the names of [`names`](SceneDesc::names), files by their URI. A mesh without a file is in the
    /// value itself if it is small; otherwise the value has a name for it, which `edit` understands.
    ///
    /// `None`: the scene does not have the part, or the key is at its default.
    ///
    /// Errors: an ID that the description does not have.
    pub fn value_at(&self, path: &str) -> Result<Option<Value>, SceneError> {
        let mut lent = BorrowedAssets::with_small_meshes_in_place(self);
        let mut cx = Writer::new(self, &mut lent);
        let parts = KeyPart::split(path);
        let keys: Vec<&str> = parts.iter().map(|part| part.key.as_str()).collect();
        let (part, rest) = match keys.as_slice() {
            [list @ ("object" | "light" | "view" | "animation"), index, rest @ ..] => {
                (item(&mut cx, list, index)?, rest)
            }
            ["group", name, "object", index, rest @ ..] => (object_of_group(&mut cx, name, index)?, rest),
            ["group", name, rest @ ..] => (named(&mut cx, "group", name)?, rest),
            [list @ ("texture" | "material" | "medium"), name, rest @ ..] => {
                (named(&mut cx, list, name)?, rest)
            }
            [section, rest @ ..] => (whole(&mut cx, section)?, rest),
            [] => (None, &[] as &[&str]),
        };
        Ok(part.and_then(|value| below(value, rest)))
    }
}

/// The value at the end of a path below a value.
fn below(mut value: Value, path: &[&str]) -> Option<Value> {
    for key in path {
        value = match value.data {
            Data::Table(table) => table.entries.into_iter().find(|entry| entry.key == *key)?.value,
            Data::Array(items) => items.into_iter().nth(key.parse().ok()?)?,
            _ => return None,
        };
    }
    Some(value)
}

/// An item of a list.
fn item(cx: &mut Writer<'_>, list: &str, index: &str) -> Result<Option<Value>, SceneError> {
    let Ok(index) = index.parse::<usize>() else { return Ok(None) };
    let desc = cx.desc;
    match list {
        "object" => desc.objects.get(index).map(|own| object(own, cx)).transpose(),
        "light" => {
            let write = |own| Ok(value_at(write_light(own, cx)?, own.span));
            desc.lights.get(index).map(write).transpose()
        }
        "animation" => {
            let write = |own: &Named<crate::animation::AnimationDesc>| {
                Ok(value_at(with_name(own.value.write(cx)?, &own.name), own.span))
            };
            desc.animations.get(index).map(write).transpose()
        }
        _ => {
            let write = |own: &Named<crate::camera::CameraDesc>| {
                Ok(value_at(with_name(own.value.write(cx)?, &own.name), own.span))
            };
            desc.cameras.get(index).map(write).transpose()
        }
    }
}

fn object_of_group(cx: &mut Writer<'_>, name: &str, index: &str) -> Result<Option<Value>, SceneError> {
    let group = cx.names.groups.iter().position(|own| own == name);
    let desc = cx.desc;
    let objects = group.map(|i| desc.groups[i].value.objects.as_slice());
    let own = index.parse::<usize>().ok().and_then(|i| objects?.get(i));
    own.map(|own| object(own, cx)).transpose()
}

/// A named part.
fn named(cx: &mut Writer<'_>, kind: &str, name: &str) -> Result<Option<Value>, SceneError> {
    let desc = cx.desc;
    let number = |names: &[String]| names.iter().position(|own| own == name);
    macro_rules! part {
        ($list:ident) => {
            number(&cx.names.$list)
                .map(|i| &desc.$list[i])
                .map(|own| Ok(value_at(own.value.write(cx)?, own.span)))
        };
    }
    match kind {
        "texture" => part!(textures).transpose(),
        "material" => part!(materials).transpose(),
        "medium" => part!(media).transpose(),
        _ => number(&cx.names.groups).map(|i| group(cx, i)).transpose(),
    }
}

fn group(cx: &mut Writer<'_>, number: usize) -> Result<Value, SceneError> {
    let own = &cx.desc.groups[number];
    let objects = own.value.objects.iter().map(|own| object(own, cx)).collect::<Result<_, _>>()?;
    let mut table = Table::default();
    table.push("object", Data::Array(objects));
    Ok(value_at(table, own.span))
}

/// A complete section.
fn whole(cx: &mut Writer<'_>, section: &str) -> Result<Option<Value>, SceneError> {
    let desc = cx.desc;
    let plain = |table| Ok(Some(Value::new(Data::Table(table))));
    let count = match section {
        "film" => return plain(desc.film.write_for(Some(desc.integrator.type_name()), cx)?),
        "integrator" => return plain(desc.integrator.write(cx)?),
        "background" => return plain(desc.background.write(cx)?),
        "studio" => {
            let Some(studio) = &desc.studio else { return Ok(None) };
            return plain(studio.write(cx)?);
        }
        "camera" => {
            let Some(own) = &desc.camera else { return Ok(None) };
            return Ok(Some(value_at(with_name(own.value.write(cx)?, &own.name), own.span)));
        }
        "object" => desc.objects.len(),
        "light" => desc.lights.len(),
        "animation" => desc.animations.len(),
        "view" => desc.cameras.len(),
        "texture" | "material" | "medium" | "group" => return all_named(cx, section),
        _ => return Ok(None),
    };
    let items = (0..count).filter_map(|i| item(cx, section, &i.to_string()).transpose());
    Ok(Some(Value::new(Data::Array(items.collect::<Result<_, _>>()?))))
}

fn all_named(cx: &mut Writer<'_>, kind: &str) -> Result<Option<Value>, SceneError> {
    let names = match kind {
        "texture" => cx.names.textures.clone(),
        "material" => cx.names.materials.clone(),
        "medium" => cx.names.media.clone(),
        _ => cx.names.groups.clone(),
    };
    let desc = cx.desc;
    let mut section = Table::default();
    for (i, name) in names.iter().enumerate() {
        let value = match kind {
            "texture" => Data::Table(desc.textures[i].value.write(cx)?),
            "material" => Data::Table(desc.materials[i].value.write(cx)?),
            "medium" => Data::Table(desc.media[i].value.write(cx)?),
            _ => group(cx, i)?.data,
        };
        section.push(name, value);
    }
    Ok(Some(Value::new(Data::Table(section))))
}
