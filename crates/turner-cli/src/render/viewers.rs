//! Pictures while a render runs: in the terminal, in the viewer tev, and in the file that `turner watch` writes.
//!
//! The first one comes at once: a coarse preview if a whole sample of each pixel takes longer. Further ones follow when
//! the number of samples has doubled.

use std::io::IsTerminal;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use clap::Args;
use turner::film::{Denoise, Picture};
use turner::render::{PassOptions, Renderer};
use turner::schema::{ErrorCode, SceneError};

use super::tev::Tev;
use super::trace::until;
use crate::failure::Failure;
use crate::output::Output;
use crate::preview::{self, Protocol, Shot, Terminal};
use crate::report::Reporter;

/// Options to see the picture while it is rendered.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct ViewerArgs {
    /// Show the picture in the terminal, again and again while it is rendered [default: first and last picture of a model]
    #[arg(long, value_name = "MODE", num_args = 0..=1, require_equals = true, default_missing_value = "auto")]
    preview: Option<PreviewArg>,
    /// Show the picture in the viewer tev while it is rendered, e.g. 127.0.0.1:14158
    #[arg(long, value_name = "HOST:PORT")]
    tev: Option<String>,
}

/// Values of `--preview`.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum PreviewArg {
    /// What the terminal supports
    Auto,
    /// Half blocks in 24-bit colour, two pixels per character
    Blocks,
    /// The graphics protocol of kitty
    Kitty,
    /// Inline images of iTerm2
    Iterm,
    /// Sixel graphics of the VT340
    Sixel,
    /// Nothing
    Off,
}

impl PreviewArg {
    fn protocol(self) -> Option<Protocol> {
        match self {
            PreviewArg::Auto | PreviewArg::Off => None,
            PreviewArg::Blocks => Some(Protocol::Blocks),
            PreviewArg::Kitty => Some(Protocol::Kitty),
            PreviewArg::Iterm => Some(Protocol::Iterm),
            PreviewArg::Sixel => Some(Protocol::Sixel),
        }
    }
}

/// Where pictures are shown.
pub(super) struct Viewers<'a> {
    terminal: Option<Terminal>,
    /// Whether the terminal shows the first and the last picture alone.
    is_brief: bool,
    tev: Option<Tev>,
    /// Writes the picture to its file.
    save: Option<&'a mut dyn FnMut(&Renderer)>,
}

/// The longest time for the coarse preview.
const FIRST: Duration = Duration::from_millis(180);

/// The time that it takes even if the time is over: without it there would be no picture.
const LEAST: Duration = Duration::from_millis(60);

impl<'a> Viewers<'a> {
    /// Connects to the viewers that are asked for; `save` writes the picture so far. Without `--preview` a terminal with
    /// pictures or 24-bit colour shows the first and the last picture if `by_default`.
    ///
    /// Errors: tev does not answer.
    pub(super) fn new(
        args: &ViewerArgs,
        name: &str,
        output: &Output,
        save: Option<&'a mut dyn FnMut(&Renderer)>,
        reporter: &Reporter,
        by_default: bool,
    ) -> Result<Viewers<'a>, Failure> {
        let asked = args.preview.filter(|mode| !matches!(mode, PreviewArg::Off));
        let is_terminal = std::io::stderr().is_terminal();
        let wanted = asked.filter(|mode| mode.protocol().is_some() || is_terminal);
        let is_brief = args.preview.is_none() && by_default && is_terminal && reporter.shows_progress();
        let terminal = match is_brief {
            true => Terminal::detect(None).filter(Terminal::has_colors),
            false => wanted.and_then(|mode| Terminal::detect(mode.protocol())),
        };
        if asked.is_some() && terminal.is_none() {
            reporter.line(
                "no preview: standard error is no terminal that shows pictures (`--preview=blocks` tries)",
            );
        }
        let title = if output.is_stdout() { name.to_owned() } else { output.name() };
        let tev =
            args.tev.as_deref().map(|address| Tev::connect(address, &title)).transpose().map_err(|e| {
                let message = format!("tev at {}: {e}", args.tev.as_deref().unwrap_or_default());
                let help = "start tev first; it listens at 127.0.0.1:14158";
                Failure::new(SceneError::new(ErrorCode::Output, message).help(help))
            })?;
        Ok(Viewers { terminal, is_brief, tev, save })
    }

    fn is_empty(&self) -> bool {
        self.terminal.is_none() && self.tev.is_none() && self.save.is_none()
    }

    /// Shows a coarse preview before the first pass of a new film. `pause` ends it; it is set if the time is over. A
    /// render that may end before its first pass does, at `deadline`, has the preview as well.
    pub(super) fn begin(
        &mut self,
        renderer: &mut Renderer,
        threads: usize,
        pause: &AtomicBool,
        deadline: Option<Instant>,
    ) {
        if self.is_empty() && deadline.is_none() || renderer.film.samples() > 0 {
            return;
        }
        let now = Instant::now();
        let longest = deadline.map_or(FIRST, |end| FIRST.min(end.saturating_duration_since(now) / 4));
        let _ = until(Some(now + longest.max(LEAST)), pause, || {
            renderer.preview_pass(&PassOptions { threads, cancel: pause, progress: None })
        });
        if !self.is_empty() {
            let is_brief = std::mem::take(&mut self.is_brief);
            self.show(renderer, threads, false);
            self.is_brief = is_brief;
        }
    }

    /// Shows the picture so far. The last one is not written to the file, which the finished picture replaces.
    pub(super) fn show(&mut self, renderer: &Renderer, threads: usize, is_last: bool) {
        if let Some(save) = self.save.as_mut().filter(|_| !is_last) {
            save(renderer);
        }
        let terminal = self.terminal.as_ref().filter(|_| is_last || !self.is_brief);
        if terminal.is_none() && self.tev.is_none() {
            return;
        }
        // A terminal is too small to show the difference, and the picture is denoised again for its file.
        let is_final = is_last && self.tev.is_some();
        let mode = if is_final { renderer.prepared().view.film.denoise } else { Denoise::Fast };
        let picture = renderer.develop_as(mode, threads);
        if let Some(terminal) = terminal {
            let Picture { width, height, display, .. } = &picture;
            let shot = Shot { width: *width, height: *height, pixels: display };
            // The terminal may be gone.
            let _ = preview::show(&mut std::io::stderr().lock(), &shot, terminal);
        }
        // The viewer may be closed while the render continues.
        if self.tev.as_mut().is_some_and(|tev| tev.show(&picture).is_err()) {
            self.tev = None;
        }
    }
}
