//! Files of other programs as scenes: a model in the default studio, or a scene of another renderer with its
//! own settings.

use std::io::Read;

use turner::color::{Spectrum, Tonemap, Transfer};
use turner::description::default_studio::BACKDROP;
use turner::description::{ModelDesc, SceneDesc, StudioDesc};
use turner::film::{Antialias, Denoise, FilmDesc, Fireflies};
use turner::integrator::{IntegratorDesc, PathDesc};
use turner::light::BackgroundDesc;
use turner::schema::value::{Data, FileId, Span, Table, Value};
use turner::schema::{KeyEdit, SceneError};

use super::files::{Given, SceneFiles, import_whole};
use super::hash::SceneHash;
use super::sources::{SourceFile, Sources};
use super::{LoadError, LoadOptions, Loaded, SceneFormat, overrides};
use crate::assets::{AssetError, AssetSource, printable};

/// Integrators whose pixels hold data: their values are averaged only on request, because the mean of a depth and of the
/// background behind it means nothing.
const DATA: [&str; 5] = ["depth", "ids", "normals", "position", "uv"];

/// Samples per pixel of a model's picture, which is denoised.
const MODEL_SAMPLES: u32 = 8;

/// The scene around a single model: the default studio, path traced unless another integrator is asked for.
fn showing(integrator: Option<&str>) -> SceneDesc {
    let scene = SceneDesc::default();
    // The means of other integrators are of data.
    let is_light = integrator.is_none_or(|name| ["path", "direct"].contains(&name));
    let denoise = if is_light { Denoise::On } else { Denoise::Off };
    let film = match integrator {
        Some(name) if DATA.contains(&name) => scene.film,
        _ => FilmDesc { antialias: Antialias::MonteCarlo, samples: MODEL_SAMPLES, denoise, ..scene.film },
    };
    let fireflies = if is_light { Fireflies::Remove } else { Fireflies::Keep };
    SceneDesc {
        film: FilmDesc { transfer: Transfer::Srgb, tonemap: Tonemap::Studio, fireflies, ..film },
        integrator: IntegratorDesc::Path(PathDesc::default()),
        // Lights a model whose own lights replace those of the studio.
        background: BackgroundDesc { color: Spectrum::WHITE, ..scene.background },
        studio: Some(StudioDesc { backdrop: Some(BACKDROP), metering: true, ..StudioDesc::default() }),
        ..scene
    }
}

/// The `[[object]]` table of a model file.
pub(super) fn object(file: &str, format: SceneFormat) -> Value {
    let mut table = Table::default();
    table.push("type", Data::String(ModelDesc::DOC.name.to_owned()));
    table.push("file", Data::String(file.to_owned()));
    let up = match format {
        SceneFormat::Stl => "z",
        SceneFormat::Toml
        | SceneFormat::Gltf
        | SceneFormat::Usd
        | SceneFormat::Obj
        | SceneFormat::Ply
        | SceneFormat::Pbrt
        | SceneFormat::Mitsuba => "y",
    };
    table.push("up", Data::String(up.to_owned()));
    Value::new(Data::Table(table))
}

/// Assigns a value and everything in it to a file, so that paths in it are relative to that file.
pub(super) fn stand_in(value: &mut Value, file: FileId) {
    value.span = Span { file, start: 0, end: 0 };
    match &mut value.data {
        Data::Array(items) => items.iter_mut().for_each(|item| stand_in(item, file)),
        Data::Table(table) => {
            for entry in &mut table.entries {
                entry.key_span = value.span;
                stand_in(&mut entry.value, file);
            }
        }
        _ => {}
    }
}

/// Loads a scene of another renderer with its own camera, film and integrator. `name` is the path as the user
/// wrote it, `uri` its last component. The file itself is read through `named`, the files it names through
/// `assets`.
pub(super) fn load_whole(
    name: &str,
    uri: &str,
    (named, assets): (&dyn AssetSource, &dyn AssetSource),
    options: &LoadOptions,
) -> Result<Loaded, LoadError> {
    let import = || {
        let path = assets.resolve(uri, uri).map_err(|e| e.to_scene_error())?;
        import_whole(&path, &Named { named, assets, path: &path }, options)
    };
    let (scene, hashes) = import().map_err(|error| LoadError { error, sources: Sources::default() })?;
    // Nothing is added to the scene: without lights it is dark.
    let scene = SceneDesc {
        studio: Some(StudioDesc { ground: Some(false), lights: false, ..StudioDesc::default() }),
        ..scene
    };
    changed(scene, (name, uri), assets, options, |files, edits| {
        files.add_hashes(&hashes);
        Ok(edits)
    })
}

/// The file that the user named may be a link to anywhere; the files it names may not.
struct Named<'a> {
    named: &'a dyn AssetSource,
    assets: &'a dyn AssetSource,
    path: &'a str,
}

impl Named<'_> {
    fn of(&self, uri: &str) -> &dyn AssetSource {
        if uri == self.path { self.named } else { self.assets }
    }
}

impl AssetSource for Named<'_> {
    fn read(&self, uri: &str, limit: u64) -> Result<Vec<u8>, AssetError> {
        self.of(uri).read(uri, limit)
    }
    fn read_ahead(&self, uri: &str, limit: u64) -> Result<(Vec<u8>, String), AssetError> {
        self.of(uri).read_ahead(uri, limit)
    }
    fn used(&self, mark: String) {
        self.assets.used(mark);
    }
    fn open<'a>(&'a self, uri: &str, limit: u64) -> Result<Box<dyn Read + 'a>, AssetError> {
        self.of(uri).open(uri, limit)
    }
    fn describe(&self, uri: &str) -> String {
        self.assets.describe(uri)
    }
    fn resolve(&self, from: &str, uri: &str) -> Result<String, AssetError> {
        self.assets.resolve(from, uri)
    }
}

/// `text` as a TOML string in quotes.
pub(crate) fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c.is_control() => out += &format!("\\u{:04X}", u32::from(c)),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

/// Loads a model from its bytes; `name` is the path as the user wrote it, `uri` its last component. The model
/// is `object.0`.
pub(super) fn load(
    bytes: Vec<u8>,
    format: SceneFormat,
    name: &str,
    uri: &str,
    assets: &dyn AssetSource,
    options: &LoadOptions,
) -> Result<Loaded, LoadError> {
    changed(showing(options.integrator.as_deref()), (name, uri), assets, options, |files, edits| {
        files.given = assets.resolve(uri, uri).ok().map(|path| Given { path, bytes });
        let list = Data::Array(vec![object(uri, format)]);
        let framed =
            refines_camera(&edits).then(|| KeyEdit::new("studio.camera", Data::String(ORBIT.into())));
        Ok([KeyEdit::new("object", list)].into_iter().chain(framed).chain(edits).collect())
    })
}

/// The camera of a model whose overrides name only keys of the lens.
const ORBIT: &str = "orbit:35,22";

/// Whether overrides change a camera without placing it: then they refine the framed camera.
fn refines_camera(edits: &[KeyEdit]) -> bool {
    let keys = || edits.iter().filter(|e| e.path.first().is_some_and(|part| part.key == "camera"));
    let is_placed = |e: &KeyEdit| match e.path.get(1) {
        Some(part) => ["position", "look_at", "viewport"].contains(&part.key.as_str()),
        None => true,
    };
    keys().next().is_some() && !keys().any(is_placed)
}

/// Applies the overrides of `options` to a scene. `prepare` adds what was read to the files and may add edits.
fn changed(
    mut desc: SceneDesc,
    (name, uri): (&str, &str),
    assets: &dyn AssetSource,
    options: &LoadOptions,
    prepare: impl FnOnce(&mut SceneFiles<'_>, Vec<KeyEdit>) -> Result<Vec<KeyEdit>, SceneError>,
) -> Result<Loaded, LoadError> {
    let mut sources = Sources::default();
    // An empty text: no error has a position in this file.
    let text = String::new();
    sources.add(SourceFile { name: printable(name), uri: uri.to_owned(), text, is_argument: false });
    let mut hash = SceneHash::new();
    super::hash_defines(options, &mut hash);
    let edits = match overrides::edits(options, uri, &mut sources, &mut hash) {
        Ok(edits) => edits,
        Err(error) => return Err(LoadError { error, sources }),
    };
    let mut files = SceneFiles::with_hash(assets, &sources, hash);
    files.options = options.clone();
    let blur = edits.iter().rev().find(|edit| {
        let mut keys = edit.path.iter().map(|part| part.key.as_str());
        [keys.next(), keys.next(), keys.next()] == [Some("film"), Some("motion_blur"), None]
    });
    if blur.is_some_and(|edit| edit.value.data == Data::Bool(true)) {
        files.frame = Some(options.models.frame.unwrap_or(super::FRAME));
    }
    let made = prepare(&mut files, edits).and_then(|edits| desc.edit(&edits, &mut files));
    let (warnings, hash) = files.finish();
    desc.warnings.extend(warnings);
    match made {
        Ok(()) => {
            let (hash, shared_hash) = overrides::hashes(hash, options);
            Ok(Loaded { desc, sources, hash, shared_hash })
        }
        Err(error) => Err(LoadError { error, sources }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_name_is_quoted() {
        assert_eq!(quoted("a \"b\" \\ c\n"), "\"a \\\"b\\\" \\\\ c\\u000A\"");
    }
}
