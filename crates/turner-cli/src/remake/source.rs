//! What the header of a picture says about its render. Any file may be hostile: a header chooses only the scene and
//! options that pictures record, never an output file, a permission or a limit.

use std::path::{Path, PathBuf};

use turner::schema::error::escape;
use turner::schema::{ErrorCode, SceneError};
use turner_io::image::Metadata;

use crate::checkpoint::{VERSION, arguments, parse_range};
use crate::failure::{FAILED, Failure};
use crate::picture_file::PictureFile;
use crate::recipe::{COMMAND, Expected, FILM, INTEGRATOR, SCENE, SCENE_HASH, STEP};
use crate::render::{FINISHED, RenderArgs, SAMPLE_RANGE};

/// Longest text of the options, in bytes, and their largest number.
const MOST: (usize, usize) = (1 << 20, 10_000);

/// What a header says.
pub(super) struct Source {
    name: String,
    software: String,
    scene: String,
    hash: String,
    command: Vec<String>,
    step: Option<u32>,
    range: Option<String>,
    settings: [Option<String>; 2],
}

fn refused(name: &str, message: &str, help: &str) -> Failure {
    let message = format!("{}: {message}", escape(name));
    Failure::new(SceneError::new(ErrorCode::Image, message).help(help))
}

impl Source {
    /// Reads the metadata of a picture.
    ///
    /// Errors: metadata that are missing or make no sense; an unfinished picture.
    pub(super) fn read(file: &PictureFile) -> Result<Source, Failure> {
        let metadata = file.metadata()?;
        let name = file.name.clone();
        let text = |key: &str| metadata.get(key).map(ToString::to_string);
        let (Some(hash), Some(command), Some(scene)) = (text(SCENE_HASH), text(COMMAND), text(SCENE)) else {
            return Err(missing(&name, &metadata));
        };
        if let Some(finished) = text(FINISHED) {
            let message = format!("the picture is unfinished ({FINISHED} = {})", escape(&finished));
            return Err(refused(&name, &message, "finish it with `turner resume`, or render it again"));
        }
        let software = text("Software").or_else(|| text("turner:software")).unwrap_or_default();
        let words: Option<Vec<String>> =
            (command.len() <= MOST.0).then(|| serde_json::from_str(&command).ok()).flatten();
        let Some(command) = words.filter(|words| words.len() <= MOST.1) else {
            let message = format!("{COMMAND} is `{}`; expected a JSON array of options", escape(&command));
            return Err(refused(&name, &message, "name a picture that Turner wrote"));
        };
        let step = match text(STEP).map(|step| (step.parse::<u32>(), step)) {
            None => None,
            Some((Ok(step), _)) => Some(step),
            Some((Err(_), step)) => {
                let message = format!("{STEP} is `{}`; expected a number", escape(&step));
                return Err(refused(&name, &message, "name a picture that Turner wrote"));
            }
        };
        let settings = [text(FILM), text(INTEGRATOR)];
        Ok(Source { name, software, scene, hash, command, step, range: text(SAMPLE_RANGE), settings })
    }

    /// An error unless this version of Turner wrote the picture.
    pub(super) fn check_version(&self, name: &str) -> Result<(), Failure> {
        if self.software == format!("Turner {VERSION}") {
            return Ok(());
        }
        let message = format!("written by {}; this is Turner {VERSION}", escape(&self.software));
        let help =
            "samples may differ between versions: use that version, or render it all the same with --anyway";
        Err(refused(name, &message, help))
    }

    /// What the scene must be.
    pub(super) fn expected(&self, name: &str) -> Expected {
        Expected { file: name.to_owned(), hash: self.hash.clone(), settings: self.settings.clone() }
    }

    /// The arguments of the render. `scene` replaces the recorded one.
    pub(super) fn render_args(&self, file: &Path, scene: Option<&Path>) -> Result<RenderArgs, Failure> {
        let odd = |what: &str, value: &str| {
            let message = format!("{what} `{}`, which a picture does not record", escape(value));
            refused(&self.name, &message, "name a picture that Turner wrote")
        };
        if let Some(word) = arguments::refused(&crate::cli::render_command(), &self.command) {
            return Err(odd(&format!("{COMMAND} has"), word));
        }
        let found = match scene {
            Some(scene) => scene.to_owned(),
            None => self.find_scene(file)?,
        };
        let mut render = crate::cli::render_args(&self.command, &found).map_err(|mut failure| {
            failure.exit = FAILED;
            for error in &mut failure.errors {
                error.message = format!("{}: {COMMAND}: {}", escape(&self.name), error.message);
            }
            failure
        })?;
        render.named = Some(self.scene.clone());
        if let Some(environment) = render.scene.studio.environment.take() {
            let places = [Path::new(""), folder(file), folder(&found)];
            let is_relative = !environment.is_absolute() && !environment.has_root();
            let shown = environment.to_string_lossy().into_owned();
            let path = places.iter().map(|place| place.join(&environment)).find(|path| path.is_file());
            let Some(path) = path.filter(|_| is_relative) else {
                let message = format!("its environment map {} does not exist here", escape(&shown));
                return Err(refused(&self.name, &message, "run the command in the folder of that file"));
            };
            render.scene.studio.environment = Some(path);
        }
        if let Some(range) = &self.range {
            let range = parse_range(range).map_err(|_| odd(&format!("{SAMPLE_RANGE} is"), range))?;
            render.checkpoints.sample_range = Some(range);
        }
        if let Some(step) = self.step {
            render.sequence.restrict(step);
        }
        if render.sequence.steps().len() != 1 {
            let step = self.step.map_or("none".to_owned(), |step| step.to_string());
            return Err(odd(&format!("{STEP} is"), &step));
        }
        Ok(render)
    }

    /// The recorded scene: relative to the current folder, then to that of the picture.
    fn find_scene(&self, file: &Path) -> Result<PathBuf, Failure> {
        let scene = Path::new(&self.scene);
        let is_relative = !scene.is_absolute() && !scene.has_root() && scene != Path::new("-");
        let mut places = [PathBuf::from(scene), folder(file).join(scene)].into_iter();
        places.find(|path| is_relative && path.is_file()).ok_or_else(|| {
            let message = format!("its scene {} does not exist here", escape(&self.scene));
            let help = "name the scene with --scene FILE, or run the command in the folder of the render";
            refused(&self.name, &message, help)
        })
    }
}

fn folder(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

fn missing(name: &str, metadata: &Metadata) -> Failure {
    let key = [SCENE_HASH, SCENE, COMMAND].into_iter().find(|key| !metadata.contains_key(*key));
    let message = format!("does not say how it was rendered: it has no metadata {}", key.unwrap_or(COMMAND));
    refused(name, &message, "name a PNG or EXR file that this version of `turner render` wrote")
}
