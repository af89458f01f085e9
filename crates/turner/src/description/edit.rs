//! Edits of a description by key paths, as in `-D film.samples=64`.
//!
//! An edit names a key of the scene file, but the description is already parsed. Writing and reading the complete scene
//! for one key would take time proportional to the size of the scene, so only the parts that the paths name are
//! converted:
//!
//! ```text
//! SceneDesc ──write named parts──► tree of values ──set──► edited tree ──read──► Changes ──commit──► SceneDesc
//! ```
//!
//! 1. [`Draft`] writes the parts as values, sets the new values, and drops keys of a type that an edit replaced. Items
//!    of lists that no path names stay placeholders with their index.
//! 2. [`Changes::read`] reads the edited tree with the functions that read scene files, so keys, types and ranges are
//!    checked and errors are worded as for a file. References work by the names that [`Draft`] gave to textures,
//!    materials, media and groups. Images and meshes are not copied: [`BorrowedAssets`] hands them through.
//! 3. [`Changes::commit`] stores the result, and only if everything could be read. Otherwise the description stays the
//!    same.

use super::borrowed_assets::{BorrowedAssets, WithBorrowed};
use super::draft::{Draft, kept};
use super::read::{Reader, SECTIONS};
use super::read_object::read_object;
use super::read_parts::*;
use super::write_names::PartNames;
use crate::animation::{AnimationDesc, read_animation};
use crate::camera::CameraDesc;
use crate::description::{GroupDesc, ModelDesc, ObjectDesc, SceneAssets, SceneDesc, SceneLight, StudioDesc};
use crate::film::FilmDesc;
use crate::integrator::IntegratorDesc;
use crate::light::{BackgroundDesc, LightDesc};
use crate::material::MaterialDesc;
use crate::medium::MediumDesc;
use crate::schema::old_names;
use crate::schema::value::{Data, Span, Table, Value};
use crate::schema::{
    FamilyDoc, GroupId, KeyEdit, MaterialId, MediumId, Named, SceneError, TableReader, TextureId,
};
use crate::shape::ShapeDesc;
use crate::texture::TextureDesc;

impl SceneDesc {
    /// Sets values by their key paths, in order: `film.width`, `object.0.radius`, `material.gold.specular_roughness`.
    /// Paths are those of the scene file that [`write_scene`](super::write_scene) writes. A part without a name has its
    /// kind and number as its name there, e.g. `material-3`. Parts that no path names do not change.
    ///
    /// A new type (`integrator.type`) drops the keys of the old type that the new one does not have. The film keeps its
    /// values if the integrator changes; only an edit that replaces all of `film` sets the film's defaults for the
    /// integrator. `assets` reads the files that new values name.
    ///
    /// Errors: those of reading a scene, at the part of the path or the value concerned. The description then stays the
    /// same.
    pub fn edit(&mut self, edits: &[KeyEdit], assets: &mut dyn SceneAssets) -> Result<(), SceneError> {
        let mut lent = BorrowedAssets::of(self);
        self.edit_with(edits, assets, &mut lent).map_err(|mut error| {
            // Positions that are in no file are of no use to the caller.
            error.span = error.span.filter(|span| span.file != Span::NONE.file);
            error
        })
    }

    fn edit_with(
        &mut self,
        edits: &[KeyEdit],
        assets: &mut dyn SceneAssets,
        lent: &mut BorrowedAssets,
    ) -> Result<(), SceneError> {
        let mut edits = edits.to_vec();
        edits.iter_mut().for_each(|edit| old_names::update_path(&mut edit.path));
        let (root, names) = Draft::apply(self, &edits, lent)?;
        let mut assets = WithBorrowed { lent, files: assets };
        let mut cx = Reader::new(&mut assets);
        let lengths = self.lend_lists(&mut cx, &names);
        let changes = Changes::read(&root, &names, self.integrator.type_name(), &mut cx);
        if changes.is_err() {
            let [textures, materials, media, images, meshes] = lengths;
            cx.textures.truncate(textures);
            cx.materials.truncate(materials);
            cx.media.truncate(media);
            cx.images.truncate(images);
            cx.meshes.truncate(meshes);
        }
        self.textures = cx.textures.into_iter().flatten().collect();
        self.materials = cx.materials.into_iter().flatten().collect();
        self.media = cx.media.into_iter().flatten().collect();
        (self.images, self.meshes) = (cx.images, cx.meshes);
        changes?.commit(self);
        // Groups, lights and cameras of models that the edits placed.
        self.groups.append(&mut cx.more_groups);
        self.lights.append(&mut cx.model_lights);
        self.cameras.append(&mut cx.cameras);
        self.imports.append(&mut cx.imports);
        self.warnings.append(&mut cx.warnings);
        Ok(())
    }

    /// Moves the lists that reading may extend into the reader. Returns their lengths: textures, materials, media,
    /// images, meshes.
    fn lend_lists(&mut self, cx: &mut Reader<'_>, names: &PartNames) -> [usize; 5] {
        fn numbered<T>(names: &[String], id: impl Fn(u32) -> T) -> impl Iterator<Item = (String, T)> {
            names.iter().enumerate().map(move |(i, name)| (name.clone(), id(i as u32)))
        }
        cx.transfer = self.film.transfer;
        cx.texture_ids.extend(numbered(&names.textures, TextureId));
        cx.material_ids.extend(numbered(&names.materials, MaterialId));
        cx.medium_ids.extend(numbered(&names.media, MediumId));
        cx.group_ids.extend(numbered(&names.groups, GroupId));
        cx.group_count = self.groups.len() as u32;
        cx.textures = std::mem::take(&mut self.textures).into_iter().map(Some).collect();
        cx.materials = std::mem::take(&mut self.materials).into_iter().map(Some).collect();
        cx.media = std::mem::take(&mut self.media).into_iter().map(Some).collect();
        cx.images = std::mem::take(&mut self.images);
        cx.meshes = std::mem::take(&mut self.meshes);
        [cx.textures.len(), cx.materials.len(), cx.media.len(), cx.images.len(), cx.meshes.len()]
    }
}

/// An item of a list after edits.
enum Item<T> {
    /// Unchanged; its index in the old list.
    Kept(usize),
    /// Changed or new.
    Read(T),
}

/// The parts that edits changed.
#[derive(Default)]
struct Changes {
    film: Option<FilmDesc>,
    integrator: Option<IntegratorDesc>,
    background: Option<BackgroundDesc>,
    studio: Option<StudioDesc>,
    camera: Option<Named<CameraDesc>>,
    cameras: Option<Vec<Item<Named<CameraDesc>>>>,
    lights: Option<Vec<Item<SceneLight>>>,
    animations: Option<Vec<Item<Named<AnimationDesc>>>>,
    objects: Option<Vec<Item<ObjectDesc>>>,
    /// By index. New ones are already in the reader's lists.
    textures: Vec<(usize, TextureDesc)>,
    materials: Vec<(usize, MaterialDesc)>,
    media: Vec<(usize, MediumDesc)>,
    /// By index, new ones last.
    groups: Vec<(usize, Option<String>, Vec<Item<ObjectDesc>>)>,
}

impl Changes {
    /// Reads the edited tree. `integrator` is the description's integrator type, used unless an edit changes it.
    fn read(
        root: &Value,
        names: &PartNames,
        integrator: &str,
        cx: &mut Reader<'_>,
    ) -> Result<Changes, SceneError> {
        let mut top = TableReader::of(root, "the scene")?;
        for (section, _) in SECTIONS {
            top.take(section);
        }
        top.finish(cx)?;
        let integrator = top.take("integrator").map_or(integrator, integrator_type);
        let mut changes = Changes {
            film: top.take("film").map(|value| read_film(value, integrator, cx)).transpose()?,
            ..Changes::default()
        };
        if let Some(film) = &changes.film {
            cx.transfer = film.transfer;
        }
        changes.read_named(&mut top, names, cx)?;
        changes.objects = list(top.take("object"), "object", |value| read_object(value, cx))?;
        changes.lights = list(top.take("light"), "light", |value| read_light(value, cx))?;
        changes.animations = list(top.take("animation"), "animation", |value| read_animation(value, cx))?;
        changes.camera = top.take("camera").map(|value| read_camera(value, "[camera]", cx)).transpose()?;
        changes.cameras = list(top.take("view"), "view", |value| read_camera(value, "a view", cx))?;
        changes.integrator = top.take("integrator").map(|value| read_integrator(value, cx)).transpose()?;
        changes.background = top.take("background").map(|value| read_background(value, cx)).transpose()?;
        changes.studio = top.take("studio").map(|value| read_studio(value, cx)).transpose()?;
        Ok(changes)
    }

    /// Reads named textures, media, materials and groups. All new names are registered first, so that they can refer to
    /// each other.
    fn read_named(
        &mut self,
        top: &mut TableReader<'_>,
        names: &PartNames,
        cx: &mut Reader<'_>,
    ) -> Result<(), SceneError> {
        macro_rules! numbered {
            ($key:literal, $names:ident, $new:expr) => {{
                let mut found = Vec::new();
                for (name, span, value) in named_tables(top.take($key), $key)? {
                    let own = names.$names.iter().position(|own| own == name);
                    let number = match own {
                        Some(number) => number,
                        None => $new(name, span, &mut *cx)?,
                    };
                    found.push((number, own.is_none().then_some(name), value));
                }
                found
            }};
        }
        let textures = numbered!("texture", textures, |name: &str, span, cx: &mut Reader<'_>| {
            check_texture_name(name, span)?;
            let number = cx.textures.len();
            cx.textures.push(None);
            cx.texture_ids.insert(name.to_owned(), TextureId(number as u32));
            Ok::<usize, SceneError>(number)
        });
        let media = numbered!("medium", media, |name: &str, _, cx: &mut Reader<'_>| {
            let number = cx.media.len();
            cx.media.push(None);
            cx.medium_ids.insert(name.to_owned(), MediumId(number as u32));
            Ok::<usize, SceneError>(number)
        });
        let materials = numbered!("material", materials, |name: &str, _, cx: &mut Reader<'_>| {
            let number = cx.materials.len();
            cx.materials.push(None);
            cx.material_ids.insert(name.to_owned(), MaterialId(number as u32));
            Ok::<usize, SceneError>(number)
        });
        let groups = numbered!("group", groups, |name: &str, _, cx: &mut Reader<'_>| {
            cx.group_ids.insert(name.to_owned(), GroupId(cx.group_count));
            cx.group_count += 1;
            Ok::<usize, SceneError>(cx.group_count as usize - 1)
        });
        macro_rules! read_all {
            ($list:ident, $read:ident) => {
                for (number, new, value) in $list {
                    let read = $read(value, cx)?;
                    match new {
                        None => self.$list.push((number, read)),
                        Some(name) => {
                            let name = Some(name.to_owned());
                            cx.$list[number] = Some(Named { name, span: in_file(value.span), value: read });
                        }
                    }
                }
            };
        }
        read_all!(textures, read_texture);
        read_all!(media, read_medium);
        read_all!(materials, read_material);
        cx.in_group = true;
        for (number, new, value) in groups {
            let name = new.map(str::to_owned);
            let mut table = TableReader::of(value, "a group")?;
            let objects = list(table.take("object"), "object", |value| read_object(value, cx))?;
            table.finish(cx)?;
            self.groups.push((number, name, objects.unwrap_or_default()));
        }
        cx.in_group = false;
        Ok(())
    }

    /// Stores the changes in the description.
    fn commit(self, desc: &mut SceneDesc) {
        fn set<T>(target: &mut T, value: Option<T>) {
            if let Some(value) = value {
                *target = value;
            }
        }
        set(&mut desc.film, self.film);
        set(&mut desc.integrator, self.integrator);
        set(&mut desc.background, self.background);
        desc.studio = self.studio.or(desc.studio.take());
        desc.camera =
            self.camera.map(|c| Named { span: c.span.and_then(in_file), ..c }).or(desc.camera.take());
        for (number, value) in self.textures {
            desc.textures[number].value = value;
        }
        for (number, value) in self.materials {
            desc.materials[number].value = value;
        }
        for (number, value) in self.media {
            desc.media[number].value = value;
        }
        for (number, name, objects) in self.groups {
            if number == desc.groups.len() {
                desc.groups.push(Named { name, span: None, value: GroupDesc::default() });
            }
            rebuild(&mut desc.groups[number].value.objects, objects, |o| &mut o.span);
        }
        if let Some(items) = self.objects {
            rebuild(&mut desc.objects, items, |o| &mut o.span);
        }
        if let Some(items) = self.lights {
            rebuild(&mut desc.lights, items, |l| &mut l.span);
        }
        if let Some(items) = self.animations {
            rebuild(&mut desc.animations, items, |a| &mut a.span);
        }
        if let Some(items) = self.cameras {
            rebuild(&mut desc.cameras, items, |c| &mut c.span);
        }
    }
}

/// The span, if it is in a file.
fn in_file(span: Span) -> Option<Span> {
    Some(span).filter(|span| span.file != Span::NONE.file)
}

/// Reads the items of a list that edits changed.
fn list<T>(
    section: Option<&Value>,
    kind: &str,
    mut read: impl FnMut(&Value) -> Result<T, SceneError>,
) -> Result<Option<Vec<Item<T>>>, SceneError> {
    let Some(section) = section else { return Ok(None) };
    let item = |value: &Value| match kept(value) {
        Some(number) => Ok(Item::Kept(number)),
        None => read(value).map(Item::Read),
    };
    array_of_tables(Some(section), kind)?.iter().map(item).collect::<Result<_, _>>().map(Some)
}

/// Rebuilds a list from unchanged and changed items.
fn rebuild<T>(list: &mut Vec<T>, items: Vec<Item<T>>, span: impl Fn(&mut T) -> &mut Option<Span>) {
    let mut old: Vec<Option<T>> = std::mem::take(list).into_iter().map(Some).collect();
    list.extend(items.into_iter().filter_map(|item| match item {
        Item::Kept(number) => old.get_mut(number)?.take(),
        Item::Read(mut new) => {
            let at = span(&mut new);
            *at = at.and_then(in_file);
            Some(new)
        }
    }));
}

/// Removes keys that belong to other types of the section's family (`integrator`, `object`, …) than the table's own
/// `type`, unless `keeps` returns true for them. A table whose `type` is missing or unknown stays the same.
pub fn drop_foreign_keys(section: &str, table: &mut Table, keeps: &dyn Fn(&str) -> bool) {
    let Some(Data::String(kind)) = table.get("type").map(|value| &value.data) else { return };
    let family: &FamilyDoc = match section {
        "integrator" => &IntegratorDesc::DOC,
        "camera" | "view" => &CameraDesc::DOC,
        "light" => &LightDesc::DOC,
        "texture" => &TextureDesc::DOC,
        "material" => &MaterialDesc::DOC,
        "medium" => &MediumDesc::DOC,
        "object" => &ShapeDesc::DOC,
        _ => return,
    };
    let of_objects = [&ModelDesc::DOC].into_iter().filter(|_| section == "object");
    let entries: Vec<_> = family.entries.iter().copied().chain(of_objects).collect();
    let own: &[_] = match entries.iter().find(|entry| entry.name == *kind) {
        Some(entry) => entry.fields,
        None if section == "object" && kind == "instance" => &[],
        None => return,
    };
    let has = |fields: &[crate::schema::Field], key: &str| {
        fields.iter().any(|field| field.name == key || old_names::of_key(field.name) == Some(key))
    };
    table.entries.retain(|entry| {
        let key = entry.key.as_str();
        let is_foreign = !has(own, key) && entries.iter().any(|other| has(other.fields, key));
        !is_foreign || keeps(key)
    });
}
