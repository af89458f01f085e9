//! `turner watch`: renders again whenever a file of the scene is saved.
//!
//! Modification time and length of the files are polled a few times a second. Polling needs no service of the system
//! and works on network folders and with editors that replace files.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant, SystemTime};

use clap::Args;
use turner::description::SceneDesc;
use turner::schema::{ErrorCode, SceneError};
use turner_io::scene::Sources;

use crate::checkpoint::CheckpointArgs;
use crate::control::Control;
use crate::failure::Failure;
use crate::render::{self, RenderArgs};
use crate::report::Reporter;

/// Render a scene again after each change of its files; Ctrl-C stops
#[derive(Debug, Args)]
pub(crate) struct WatchArgs {
    #[command(flatten)]
    render: RenderArgs,
    /// Stop after N pictures and errors
    #[arg(long, value_name = "N")]
    count: Option<u32>,
}

impl WatchArgs {
    /// Sets the options that a picture records.
    pub(crate) fn set_recorded(&mut self, recorded: Option<Vec<String>>) {
        self.render.recorded = recorded;
    }
}

/// Interval between two checks of the files.
const INTERVAL: Duration = Duration::from_millis(150);

/// Modification time and length of a file; `None` if it does not exist.
type Stamp = Option<(SystemTime, u64)>;

fn stamp(path: &Path) -> Stamp {
    let meta = std::fs::metadata(path).ok()?;
    Some((meta.modified().ok()?, meta.len()))
}

/// The files of a scene, with their state when it was loaded.
#[derive(Clone, Debug, Default)]
pub(crate) struct Watched {
    files: Vec<(PathBuf, Stamp)>,
}

impl Watched {
    /// The scene file alone.
    fn scene(path: &Path) -> Watched {
        Watched { files: vec![(path.to_owned(), stamp(path))] }
    }

    /// Adds the files of a scene in their current state.
    pub(crate) fn add(&mut self, scene: &Path, sources: &Sources, desc: Option<&SceneDesc>) {
        let folder = scene.parent().unwrap_or(Path::new(""));
        let texts = sources.files().iter().filter(|f| !f.is_argument).map(|f| folder.join(&f.uri));
        let pictures = desc.iter().flat_map(|d| &d.images).map(|i| folder.join(&i.uri));
        let meshes = desc.iter().flat_map(|d| &d.meshes).map(|m| folder.join(&m.uri));
        let imports = desc.iter().flat_map(|d| &d.imports).map(|i| folder.join(&i.file));
        self.add_all(texts.chain(pictures).chain(meshes).chain(imports));
    }

    fn add_all(&mut self, paths: impl Iterator<Item = PathBuf>) {
        for path in paths {
            // Some parts of a model have names that are not files.
            if path.is_file() && !self.files.iter().any(|(known, _)| *known == path) {
                let now = stamp(&path);
                self.files.push((path, now));
            }
        }
    }

    /// Whether a file changed.
    fn has_changed(&self) -> bool {
        self.files.iter().any(|(path, then)| stamp(path) != *then)
    }

    /// Waits until a file has changed, all files are stable, and the scene file exists. Returns false after an
    /// interrupt.
    fn wait(&self, control: &Control, reporter: &Reporter) -> bool {
        let mut said = false;
        loop {
            if control.is_interrupted() {
                return false;
            }
            std::thread::sleep(INTERVAL);
            if !self.has_changed() {
                continue;
            }
            let Some((scene, _)) = self.files.first() else { return false };
            let before: Vec<Stamp> = self.files.iter().map(|(path, _)| stamp(path)).collect();
            if before[0].is_none_or(|(_, length)| length == 0) {
                if !said && before[0].is_none() {
                    reporter.line(&format!("{} does not exist: waiting for it", scene.display()));
                    said = true;
                }
                continue;
            }
            std::thread::sleep(INTERVAL);
            if self.files.iter().zip(&before).all(|((path, _), before)| stamp(path) == *before) {
                return true;
            }
        }
    }
}

/// Checks a few times a second whether files changed. Threads share the result.
pub(crate) struct Changes<'a> {
    watched: &'a Watched,
    last: Mutex<(Instant, bool)>,
}

impl<'a> Changes<'a> {
    pub(crate) fn new(watched: &'a Watched) -> Changes<'a> {
        Changes { watched, last: Mutex::new((Instant::now(), false)) }
    }

    pub(crate) fn any(&self) -> bool {
        let mut last = self.last.lock().unwrap_or_else(|e| e.into_inner());
        if !last.1 && last.0.elapsed() >= INTERVAL {
            *last = (Instant::now(), self.watched.has_changed());
        }
        last.1
    }
}

/// Runs the command.
pub(crate) fn run(args: &WatchArgs, control: &Control) -> u8 {
    let scene = args.render.scene_path();
    let (output, reporter) = match args.render.begin() {
        Ok(begun) => begun,
        Err((failure, reporter)) => {
            reporter.failure(&failure);
            return failure.exit;
        }
    };
    if let Some(failure) = refusal(scene, &output, &args.render) {
        reporter.failure(&failure);
        return failure.exit;
    }
    let mut watched = Watched::scene(scene);
    let mut rounds = 0;
    loop {
        let mut now = Watched::scene(scene);
        let result = render::again(&args.render, &output, &reporter, control, &mut now);
        control.end();
        if control.is_interrupted() {
            return control.exit_code();
        }
        if result.is_err() {
            // A scene that fails to load keeps the files of the last successful load.
            now.add_all(watched.files.drain(..).map(|(path, _)| path));
        }
        watched = now;
        let code = result.unwrap_or_else(|failure| {
            reporter.failure(&failure);
            Some(failure.exit)
        });
        if let Some(code) = code {
            rounds += 1;
            if args.count.is_some_and(|count| rounds >= count) {
                return code;
            }
        }
        if !watched.wait(control, &reporter) {
            return control.exit_code();
        }
    }
}

/// The error for inputs and outputs that cannot be watched.
fn refusal(scene: &Path, output: &crate::output::Output, args: &RenderArgs) -> Option<Failure> {
    let usage = |message: &str, help: &str| {
        Some(Failure::usage(SceneError::new(ErrorCode::Output, message.to_owned()).help(help)))
    };
    if scene == Path::new("-") {
        return usage("cannot watch standard input", "name a scene file");
    }
    if output.is_stdout() {
        return usage("`turner watch` writes a file repeatedly", "name the file with `-o FILE`");
    }
    let CheckpointArgs { checkpoint, checkpoint_interval, resume, .. } = &args.checkpoints;
    let asked =
        checkpoint.is_some() || checkpoint_interval.is_some() || *resume || args.checkpoints.is_part();
    if asked || output.is_part() {
        return usage("`turner watch` writes no checkpoints", "omit the option, or use `turner render`");
    }
    if args.is_sequence() {
        return usage("cannot watch sequences of pictures", "render one picture, or use `turner render`");
    }
    None
}
