//! A model by itself: a small scene around it.

use super::error::asset_error;
use super::files::{Given, import_whole};
use super::sources::{SourceFile, Sources};
use super::{LoadError, LoadOptions, Loaded, SceneFormat, read};
use crate::assets::{AssetError, AssetSource, printable};
use std::io::Read;
use std::path::Path;
use turner::color::Spectrum;
use turner::integrator::IntegratorDesc;
use turner::medium::MediumDesc;
use turner::scene::SceneDesc;

/// The scene that shows a model: on a stage, in physical light. What it says can be replaced as in any other scene, its one
/// object being `object.0`.
pub(super) fn scene_around(file: &str, format: SceneFormat) -> String {
    let up = if format == SceneFormat::Stl { "z" } else { "y" };
    format!(
        "[film]\ntransfer = \"srgb\"\ntonemap = \"neutral\"\nantialias = \"monte-carlo\"\nsamples = 32\n\n[integrator]\ntype = \"path\"\n\n\
         [background]\ncolor = 1\n\n\
         [stage]\n\n\
         [[object]]\ntype = \"model\"\nfile = {}\nup = \"{up}\"\n",
        quoted(file)
    )
}

/// The scene that shows a scene of another renderer as it wants to be shown.
fn scene_around_whole(file: &str, scene: &SceneDesc) -> String {
    let film = &scene.film;
    let mut text = String::from("[film]\n");
    let mut film_key = |key: &str, value: String| text += &format!("{key} = {value}\n");
    film_key("width", film.width.to_string());
    film_key("height", film.height.to_string());
    if let Some(crop) = film.crop {
        film_key("crop", format!("{crop:?}"));
    }
    film_key("transfer", "\"srgb\"".into());
    film_key("antialias", "\"monte-carlo\"".into());
    film_key("samples", film.samples.to_string());
    film_key("filter", format!("\"{}\"", film.filter.word()));
    if let Some(radius) = film.filter_radius {
        film_key("filter_radius", format!("{radius:?}"));
    }
    if film.max_sample > 0.0 {
        film_key("max_sample", format!("{:?}", film.max_sample));
    }
    text += "\n[integrator]\n";
    match &scene.integrator {
        IntegratorDesc::Path(path) => text += &format!("type = \"path\"\nmax_depth = {}\n", path.max_depth),
        _ => text += "type = \"ambient-occlusion\"\n",
    }
    if let Some(id) = scene.background.medium
        && let Some(MediumDesc::Homogeneous(m)) = scene.media.get(id.index()).map(|m| &m.value)
    {
        let color = |c: Option<Spectrum>| format!("{:?}", c.unwrap_or(Spectrum::BLACK).to_array());
        text += &format!(
            "\n[background]\nmedium = {{ density = {:?}, absorption = {}, scattering = {}, anisotropy = {:?}, emission = {} }}\n",
            m.density,
            color(m.absorption),
            color(m.scattering),
            m.anisotropy,
            color(Some(m.emission)),
        );
    }
    // Nothing is added to it: what it does not light is dark.
    text += "\n[stage]\nground = false\nstudio = false\n\n";
    text + &included(file, SceneFormat::of_path(Path::new(file)).unwrap_or(SceneFormat::Pbrt))
}

/// Loads a scene of another renderer; `name` is the path as the user wrote it, `uri` its last part. The file itself is read through the first of the
/// assets, what it names through the second.
pub(super) fn load_whole(
    name: &str,
    uri: &str,
    (named, assets): (&dyn AssetSource, &dyn AssetSource),
    options: &LoadOptions,
) -> Result<Loaded, LoadError> {
    let bare = |error| LoadError { error, sources: Sources::default() };
    let path = assets.resolve(uri, uri).map_err(|e| bare(asset_error(e)))?;
    let given = import_whole(&path, &Named { named, assets, path: &path }, options).map_err(bare)?;
    let text = match &given {
        Given::Scene(_, scene, _) => scene_around_whole(uri, scene),
        Given::Bytes(..) => String::new(),
    };
    read_around(text, (name, uri), assets, options, Some(given))
}

/// The file that the user named may be a link to anywhere; what it names may not.
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

/// The text that brings a model into the scene which includes it.
pub(super) fn included(file: &str, format: SceneFormat) -> String {
    let up = if format == SceneFormat::Stl { "z" } else { "y" };
    format!("[[object]]\ntype = \"model\"\nfile = {}\nup = \"{up}\"\n", quoted(file))
}

/// As a string of TOML.
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

/// Loads a model whose bytes were read; `name` is the path as the user wrote it, `uri` its last part.
pub(super) fn load(
    bytes: Vec<u8>,
    format: SceneFormat,
    name: &str,
    uri: &str,
    assets: &dyn AssetSource,
    options: &LoadOptions,
) -> Result<Loaded, LoadError> {
    let given = assets.resolve(uri, uri).ok().map(|path| Given::Bytes(path, bytes));
    read_around(scene_around(uri, format), (name, uri), assets, options, given)
}

/// Reads the scene that stands around a model.
fn read_around(
    text: String,
    (name, uri): (&str, &str),
    assets: &dyn AssetSource,
    options: &LoadOptions,
    given: Option<Given>,
) -> Result<Loaded, LoadError> {
    let mut sources = Sources::default();
    match read(text, (name, uri), assets, options, &mut sources, given) {
        Ok((desc, hash)) => Ok(Loaded { desc, sources, hash }),
        Err(mut error) => {
            // A place in the text above would tell nobody anything.
            let is_ours = |file: &SourceFile| !file.is_argument && file.name == printable(name);
            if error.span.is_some_and(|span| sources.get(span.file).is_some_and(is_ours)) {
                error.span = None;
            }
            Err(LoadError { error, sources })
        }
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
