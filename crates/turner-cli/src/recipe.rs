//! The metadata of a picture that say how to render it again: the scene, the options, the settings.
//!
//! They are equal on every machine: no absolute paths, no thread count, no times.

use std::path::{Component, Path};

use turner::integrator::{IntegratorDesc, Prepared};
use turner::schema::error::escape;
use turner::schema::{ErrorCode, SceneError};
use turner_io::convert::settings_text;
use turner_io::image::Metadata;

use crate::render::RenderArgs;
use crate::sequence::Step;

/// The scene file, as given.
pub(crate) const SCENE: &str = "turner:scene";
/// Hash of the scene, its files, and the options that change it.
pub(crate) const SCENE_HASH: &str = "turner:sceneHash";
/// The options, as a JSON array.
pub(crate) const COMMAND: &str = "turner:command";
/// The index of the picture in a turntable.
pub(crate) const STEP: &str = "turner:step";
/// `[film]` as TOML.
pub(crate) const FILM: &str = "turner:film";
/// `[integrator]` as TOML.
pub(crate) const INTEGRATOR: &str = "turner:integrator";
/// The camera as JSON.
pub(crate) const CAMERA: &str = "turner:camera";

/// Options of an encoding, which depend on the format of the file.
pub(crate) const ENCODING: [&str; 4] = ["--bit-depth", "--display-space", "--dither", "--exr-compression"];

/// Options that checkpoints record and the picture does not depend on, or that have metadata of their own.
const LEFT_OUT: [&str; 3] = ["--bvh-quality", "--sample-range", "--part"];

/// The option of a recorded word such as `--samples=4`.
pub(crate) fn option(word: &str) -> &str {
    word.split_once('=').map_or(word, |(option, _)| option)
}

/// The options of the encoding in the metadata of a picture.
pub(crate) fn encoding(metadata: &Metadata) -> Option<Vec<String>> {
    let mut words: Vec<String> = serde_json::from_str(&metadata.get(COMMAND)?.to_string()).ok()?;
    words.retain(|word| ENCODING.contains(&option(word)));
    Some(words)
}

/// How a picture is rendered, as its metadata say.
#[derive(Clone, Debug, Default)]
pub(crate) struct Recipe {
    scene: String,
    command: Option<Vec<String>>,
    step: Option<u32>,
}

impl Recipe {
    /// Of one picture of a render.
    pub(crate) fn new(args: &RenderArgs, step: &Step) -> Recipe {
        let path = args.named.as_deref().map_or(args.scene.scene.as_path(), Path::new);
        let words = args.recorded.iter().flatten();
        let mut command: Vec<String> = words
            .filter(|word| !LEFT_OUT.contains(&option(word)))
            .map(|word| match (step, word.split_once('=')) {
                // The same as the picture alone, and as a part of any longer sequence.
                (Step::Frame(frame), Some(("--frames", _))) => format!("--frame={frame}"),
                (_, Some(("--environment", path))) => format!("--environment={}", portable(Path::new(path))),
                _ => word.clone(),
            })
            .collect();
        // Options that were replaced are at the end; those of one name keep their order.
        command.sort_by(|a, b| option(a).cmp(option(b)));
        let step = if let Step::Turn(index, _) = step { Some(*index) } else { None };
        Recipe { scene: portable(path), command: args.recorded.is_some().then_some(command), step }
    }

    /// The metadata.
    pub(crate) fn entries(&self) -> impl Iterator<Item = (&'static str, String)> {
        let command = self.command.as_ref().map(|words| serde_json::json!(words).to_string());
        let scene = Some(self.scene.clone());
        let all = [(SCENE, scene), (COMMAND, command), (STEP, self.step.map(|step| step.to_string()))];
        all.into_iter().filter_map(|(key, value)| Some((key, value?)))
    }
}

/// A path that is the same on every machine: as given, or only its name if it is absolute.
fn portable(path: &Path) -> String {
    if path.is_absolute() || path.has_root() {
        return path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    }
    let parts = path.components().filter(|part| *part != Component::CurDir);
    parts.map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

/// The settings as metadata.
pub(crate) fn settings(prepared: &Prepared, integrator: &IntegratorDesc) -> [(&'static str, String); 2] {
    // Film and integrator refer to no files, so writing them cannot fail.
    let [film, integrator] = settings_text(&prepared.view.film, integrator).unwrap_or_default();
    [(FILM, film), (INTEGRATOR, integrator)]
}

/// The type of an integrator in its metadata; older pictures have nothing but the type.
pub(crate) fn integrator_type(text: &str) -> &str {
    text.lines().find_map(|line| line.strip_prefix("type = \"")?.strip_suffix('"')).unwrap_or(text)
}

/// What the scene of a picture must be.
#[derive(Clone, Debug)]
pub(crate) struct Expected {
    /// The picture, for messages.
    pub(crate) file: String,
    /// Its metadata.
    pub(crate) hash: String,
    /// `[film]` and `[integrator]` as TOML.
    pub(crate) settings: [Option<String>; 2],
}

impl Expected {
    /// An error that names the difference, unless the scene is the same.
    pub(crate) fn check(
        &self,
        hash: &str,
        prepared: &Prepared,
        integrator: &IntegratorDesc,
    ) -> Result<(), SceneError> {
        if self.hash == hash {
            return Ok(());
        }
        let short = |hash: &str| escape(hash).chars().take(16).collect::<String>();
        let mut message = format!(
            "{}: the scene or its files changed since: its hash was {} and is {}",
            escape(&self.file),
            short(&self.hash),
            short(hash)
        );
        for ((key, now), then) in settings(prepared, integrator).iter().zip(&self.settings) {
            let section = key.trim_start_matches("turner:");
            if let Some((was, is)) = then.as_deref().and_then(|then| difference(then, now)) {
                message += &format!("; [{section}] had `{}` and has `{}`", escape(was), escape(is));
            }
        }
        let help = "restore the files of the scene (scene, models, textures), name another with --scene, or render it all the same with --anyway";
        Err(SceneError::new(ErrorCode::Conflict, message).help(help))
    }
}

/// The first lines that differ; a missing one is the default.
fn difference<'a>(then: &'a str, now: &'a str) -> Option<(&'a str, &'a str)> {
    const NONE: &str = "its default";
    let lacks = |text: &str, line: &str| !text.lines().any(|own| own == line);
    let was = then.lines().find(|line| lacks(now, line));
    let is = now.lines().find(|line| lacks(then, line));
    (was.is_some() || is.is_some()).then(|| (was.unwrap_or(NONE), is.unwrap_or(NONE)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_the_same_on_every_machine() {
        for (path, expected) in [
            ("a.toml", "a.toml"),
            ("./b/a.toml", "b/a.toml"),
            ("../a", "../a"),
            ("/home/me/a.toml", "a.toml"),
        ] {
            assert_eq!(portable(Path::new(path)), expected);
        }
    }

    #[test]
    fn the_type_of_an_integrator_is_read() {
        assert_eq!(integrator_type("type = \"path\"\nmax_depth = 3\n"), "path");
        assert_eq!(integrator_type("depth"), "depth");
    }

    #[test]
    fn differences_are_named() {
        let a = "width = 3\nseed = 1\n";
        assert_eq!(difference(a, a), None);
        assert_eq!(difference(a, "width = 3\nseed = 2\n"), Some(("seed = 1", "seed = 2")));
        assert_eq!(difference(a, "width = 3\n"), Some(("seed = 1", "its default")));
    }
}
