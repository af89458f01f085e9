//! A description as a tree of values in the form of a scene file: parts that were written in place of their use are
//! marked, and models are single objects without their contents.

use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use turner::description::{ObjectContent, ObjectDesc, SceneAssetWriter, SceneDesc, write_scene};
use turner::image::Image;
use turner::schema::value::{Data, FileId, Span, Table, Value};
use turner::schema::{
    Asset, ErrorCode, FontFile, GridFile, ImageId, MaterialId, MeasuredFile, MediumId, MeshData, MeshId,
    ProfileFile, SceneError, TextureId, Transform, WriteContext,
};

use crate::convert::{ConvertOptions, Files, WrittenFile};

/// The first character of the names of parts that are written in place. No name in a file begins with it.
pub(super) const IN_PLACE: char = '\0';

/// The name of a part that is written in place, by its position.
fn in_place(span: Option<Span>, kind: char, number: usize) -> String {
    match span.filter(|span| span.file != Span::NONE.file) {
        Some(span) => format!("{IN_PLACE}{kind}{}:{}", span.file.0, span.start),
        None => format!("{IN_PLACE}{kind}new {number}"),
    }
}

/// The position of a part that is written in place, by its name.
pub(super) fn place_of(name: &str) -> Option<(FileId, u32)> {
    let (file, start) = name.strip_prefix(IN_PLACE)?.get(1..)?.split_once(':')?;
    Some((FileId(file.parse().ok()?), start.parse().ok()?))
}

/// The tree of a description. With `marked`, parts without a name get names that begin with [`IN_PLACE`].
pub(super) fn tree(
    desc: &SceneDesc,
    marked: bool,
    base: &Path,
    assets: &mut dyn SceneAssetWriter,
) -> Result<Value, SceneError> {
    let is_of_model = desc.model_spans();
    let mut own = desc.clone();
    own.lights.retain(|light| !is_of_model(light.span));
    own.cameras.retain(|camera| !is_of_model(camera.span));
    macro_rules! parts {
        ($list:ident, $kind:literal) => {
            for (number, part) in own.$list.iter_mut().enumerate() {
                if is_of_model(part.span) {
                    part.value = Default::default();
                } else if marked && part.name.is_none() {
                    part.name = Some(in_place(part.span, $kind, number));
                }
            }
        };
    }
    parts!(textures, 't');
    parts!(materials, 'm');
    parts!(media, 'd');
    for group in &mut own.groups {
        if group.name.is_none() && is_of_model(group.span) {
            group.value.objects.clear();
        }
    }
    let models: Vec<Option<Table>> = own
        .groups
        .iter()
        .map(|group| group.value.model.as_ref().map(|model| model.write(&mut Names(own.names()))).transpose())
        .collect::<Result<_, _>>()?;
    let turned = |object: &mut ObjectDesc,
                  groups: &[turner::schema::Named<turner::description::GroupDesc>]| {
        if let ObjectContent::Instance(id) = object.content
            && let Some(model) = groups.get(id.index()).and_then(|group| group.value.model.as_ref())
        {
            let back = model.up.rotation().inverse();
            object.transform = Transform(object.transform.0 * back);
            object.motion = object.motion.map(|motion| Transform(motion.0 * back));
        }
    };
    let groups = own.groups.clone();
    own.objects.iter_mut().for_each(|object| turned(object, &groups));
    own.groups.iter_mut().flat_map(|g| &mut g.value.objects).for_each(|object| turned(object, &groups));
    let names = own.names();
    let mut root = write_scene(&own, assets)?;
    let Data::Table(top) = &mut root.data else { return Ok(root) };
    set_spans(top, &own);
    let placed =
        |name: &str| names.groups.iter().position(|own| own == name).and_then(|i| models[i].as_ref());
    macro_rules! drop {
        ($key:literal, $list:ident) => {
            if let Some(Value { data: Data::Table(section), .. }) = top.get_mut($key) {
                let mut gone = own.$list.iter().map(|part| is_of_model(part.span));
                section.entries.retain(|_| !gone.next().unwrap_or(false));
            }
        };
    }
    drop!("texture", textures);
    drop!("material", materials);
    drop!("medium", media);
    if let Some(Value { data: Data::Array(objects), .. }) = top.get_mut("object") {
        objects.iter_mut().for_each(|object| as_model(object, base, &placed));
    }
    if let Some(Value { data: Data::Table(section), .. }) = top.get_mut("group") {
        let mut gone = own.groups.iter().map(|group| group.name.is_none() && is_of_model(group.span));
        section.entries.retain(|_| !gone.next().unwrap_or(false));
        for group in &mut section.entries {
            if let Data::Table(table) = &mut group.value.data
                && let Some(Value { data: Data::Array(objects), .. }) = table.get_mut("object")
            {
                objects.iter_mut().for_each(|object| as_model(object, base, &placed));
            }
        }
    }
    // An empty [studio] has a meaning, an empty list of materials has none.
    let is_empty = |value: &Value| matches!(&value.data, Data::Table(table) if table.entries.is_empty());
    let named = ["texture", "material", "medium", "group"];
    top.entries.retain(|entry| !named.contains(&entry.key.as_str()) || !is_empty(&entry.value));
    Ok(root)
}

/// Gives the items of the tree the positions of the description's.
fn set_spans(top: &mut Table, desc: &SceneDesc) {
    let mut list = |key: &str, spans: Vec<Option<Span>>| {
        let Some(section) = top.get_mut(key) else { return };
        let values: Vec<&mut Value> = match &mut section.data {
            Data::Array(items) => items.iter_mut().collect(),
            Data::Table(table) => table.entries.iter_mut().map(|entry| &mut entry.value).collect(),
            _ => return,
        };
        values.into_iter().zip(spans).for_each(|(value, span)| value.span = span.unwrap_or(Span::NONE));
    };
    list("object", desc.objects.iter().map(|o| o.span).collect());
    list("light", desc.lights.iter().map(|l| l.span).collect());
    list("animation", desc.animations.iter().map(|a| a.span).collect());
    list("view", desc.cameras.iter().map(|c| c.span).collect());
    list("texture", desc.textures.iter().map(|t| t.span).collect());
    list("material", desc.materials.iter().map(|m| m.span).collect());
    list("medium", desc.media.iter().map(|m| m.span).collect());
    list("group", desc.groups.iter().map(|g| g.span).collect());
    let Some(Value { data: Data::Table(groups), .. }) = top.get_mut("group") else { return };
    for (entry, group) in groups.entries.iter_mut().zip(&desc.groups) {
        if let Data::Table(table) = &mut entry.value.data
            && let Some(Value { data: Data::Array(items), .. }) = table.get_mut("object")
        {
            let spans = group.value.objects.iter().map(|o| o.span.unwrap_or(Span::NONE));
            items.iter_mut().zip(spans).for_each(|(item, span)| item.span = span);
        }
    }
}

/// Writes an instance of a model's group as the model.
fn as_model<'a>(object: &mut Value, base: &Path, model_of: &impl Fn(&str) -> Option<&'a Table>) {
    let Data::Table(table) = &mut object.data else { return };
    let Some(Data::String(group)) = table.get("group").map(|v| &v.data) else { return };
    let Some(model) = model_of(group) else { return };
    let mut keys = model.clone();
    if let Some(Value { data: Data::String(file), .. }) = keys.get_mut("file")
        && !base.as_os_str().is_empty()
    {
        *file = slashes(&base.join(&*file));
    }
    let mut out = Table::default();
    for entry in std::mem::take(&mut table.entries) {
        match entry.key.as_str() {
            "type" => out.push("type", Data::String("model".into())),
            "group" => out.entries.append(&mut keys.entries),
            _ => out.entries.push(entry),
        }
    }
    *table = out;
}

/// A path with `/` as separator.
fn slashes(path: &Path) -> String {
    let parts = path.components().filter(|part| *part != Component::CurDir);
    parts.map(|part| part.as_os_str().to_string_lossy().into_owned()).collect::<Vec<_>>().join("/")
}

/// Writes references by name; a model refers to nothing else.
struct Names(turner::description::PartNames);

fn other<T>() -> Result<T, SceneError> {
    Err(SceneError::new(ErrorCode::Internal, "a model refers to materials only"))
}

impl WriteContext for Names {
    fn texture(&self, _: TextureId) -> Result<Data, SceneError> {
        other()
    }
    fn material(&self, id: MaterialId) -> Result<Data, SceneError> {
        self.0.materials.get(id.index()).map_or_else(other, |name| Ok(Data::String(name.clone())))
    }
    fn medium(&self, _: MediumId) -> Result<Data, SceneError> {
        other()
    }
    fn image(&mut self, _: ImageId) -> Result<Data, SceneError> {
        other()
    }
    fn mesh(&mut self, _: MeshId) -> Result<(&MeshData, Option<String>), SceneError> {
        other()
    }
    fn light_profile(&mut self, _: &ProfileFile) -> Result<Data, SceneError> {
        other()
    }
    fn measured_brdf(&mut self, _: &MeasuredFile) -> Result<Data, SceneError> {
        other()
    }
    fn grid(&mut self, _: &GridFile) -> Result<Data, SceneError> {
        other()
    }
    fn font(&mut self, _: &FontFile) -> Result<Data, SceneError> {
        other()
    }
}

/// Names the files of a scene as they are, and copies those that lie outside the scene's folder.
pub(super) struct Uris<'a> {
    /// The scene as it was opened: its files keep their names.
    before: Option<&'a SceneDesc>,
    files: Option<Files<'a>>,
    /// Files that were copied, by their old names.
    pub(super) copied: Vec<(String, String)>,
}

impl<'a> Uris<'a> {
    /// Files as they are named.
    pub(super) fn as_named() -> Uris<'a> {
        Uris { before: None, files: None, copied: Vec::new() }
    }

    /// For a scene that is written to `out`. `before` is the scene as it was opened from the same folder.
    pub(super) fn beside(
        desc: &SceneDesc,
        before: Option<&'a SceneDesc>,
        out: &Path,
        options: &'a ConvertOptions,
    ) -> Result<Uris<'a>, SceneError> {
        Ok(Uris { before, files: Some(Files::new(desc, out, options)?), copied: Vec::new() })
    }

    /// All files written, with the scene itself.
    pub(super) fn finish(self, main: WrittenFile) -> Vec<WrittenFile> {
        match self.files {
            Some(files) => files.finish(main).files,
            None => vec![main],
        }
    }

    /// Whether a file keeps its name: the opened scene has it, or it lies in the scene's folder.
    fn stays<T>(&self, list: impl Fn(&'a SceneDesc) -> &'a [Asset<T>], asset: &Asset<T>) -> bool
    where
        T: 'a,
    {
        let is_same = |own: &Asset<T>| own.uri == asset.uri && Arc::ptr_eq(&own.data, &asset.data);
        self.files.is_none()
            || self.before.is_some_and(|desc| list(desc).iter().any(is_same))
            || is_inside(&asset.uri)
    }

    fn copy(
        &mut self,
        uri: &str,
        write: impl FnOnce(&mut Files<'a>) -> Result<String, SceneError>,
    ) -> Result<String, SceneError> {
        let Some(files) = &mut self.files else { return Ok(uri.to_owned()) };
        let name = write(files)?;
        let pair = (uri.to_owned(), name.clone());
        if !self.copied.contains(&pair) {
            self.copied.push(pair);
        }
        Ok(name)
    }
}

/// Whether a file name is a path inside the folder of the scene.
fn is_inside(uri: &str) -> bool {
    let path = PathBuf::from(uri);
    let is_plain = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
    !uri.is_empty() && !uri.contains(':') && path.components().all(is_plain)
}

/// Most vertices and triangles of a new mesh that is written in the scene itself.
const FEW: usize = 12;

impl SceneAssetWriter for Uris<'_> {
    fn image(&mut self, id: ImageId, image: &Asset<Image>) -> Result<String, SceneError> {
        if self.stays(|desc| &desc.images, image) {
            return Ok(image.uri.clone());
        }
        self.copy(&image.uri, |files| files.image(id, image))
    }
    fn mesh(&mut self, id: MeshId, mesh: &Asset<MeshData>) -> Result<Option<String>, SceneError> {
        if self.stays(|desc| &desc.meshes, mesh) {
            return Ok(Some(mesh.uri.clone()).filter(|uri| !uri.is_empty()));
        }
        if mesh.uri.is_empty() && mesh.data.positions.len().max(mesh.data.triangles.len()) <= FEW {
            return Ok(None);
        }
        let name = self.copy(&mesh.uri, |files| files.mesh(id, mesh).map(Option::unwrap_or_default))?;
        Ok(Some(name).filter(|name| !name.is_empty()))
    }
    fn light_profile(&mut self, profile: &ProfileFile) -> Result<String, SceneError> {
        if self.files.is_none() || is_inside(&profile.uri) {
            return Ok(profile.uri.clone());
        }
        self.copy(&profile.uri, |files| files.light_profile(profile))
    }
    fn measured_brdf(&mut self, measured: &MeasuredFile) -> Result<String, SceneError> {
        if self.files.is_none() || is_inside(&measured.uri) {
            return Ok(measured.uri.clone());
        }
        self.copy(&measured.uri, |files| files.measured_brdf(measured))
    }
    fn grid(&mut self, grid: &GridFile) -> Result<String, SceneError> {
        if self.files.is_none() || is_inside(&grid.uri) {
            return Ok(grid.uri.clone());
        }
        self.copy(&grid.uri, |files| files.grid(grid))
    }
    fn font(&mut self, font: &FontFile) -> Result<String, SceneError> {
        if self.files.is_none() || is_inside(&font.uri) {
            return Ok(font.uri.clone());
        }
        self.copy(&font.uri, |files| files.font(font))
    }
}
