//! One picture: from a prepared scene to the file, with its checkpoint.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::json;
use turner::film::Film;
use turner::render::Renderer;
use turner::schema::{ErrorCode, Limits, SceneError, Warning, WarningKind};
use turner_io::checkpoint::{Header, fingerprint};
use turner_io::scene::Sources;

use super::budget::Budget;
use super::denoiser::load_denoiser;
use super::report::{Report, late_warnings};
use super::saving::saving_time;
use super::trace::{Job, Traced, trace};
use super::viewers::Viewers;
use super::{RenderArgs, Resumed, threads};
use crate::checkpoint::{self, VERSION, Writer};
use crate::control::Control;
use crate::failure::{Failure, Labels};
use crate::film_picture::FilmPicture;
use crate::output::Output;
use crate::recipe::Recipe;
use crate::report::{Reporter, strict};
use crate::scene::{Hashes, Ready};
use crate::watch::Changes;

/// Metadata of an unfinished picture: the fraction of the work that is done.
pub(crate) const FINISHED: &str = "turner:finished";

/// Metadata of a picture of `--sample-range`.
pub(crate) const SAMPLE_RANGE: &str = "turner:sampleRange";

/// Metadata of a picture whose noise is known: see `turner help --noise`.
pub(super) const NOISE: &str = "turner:noise";

/// Metadata of a picture that a denoiser has changed: its name.
const DENOISED: &str = "turner:denoised";

/// Metadata of such a picture: the estimate of its error.
const LEFT: &str = "turner:errorAfterDenoising";

/// One picture to render.
pub(super) struct One<'a> {
    pub(super) args: &'a RenderArgs,
    pub(super) ready: &'a Ready,
    /// The hashes of this picture.
    pub(super) hashes: Hashes,
    /// What its metadata say about its making.
    pub(super) recipe: Recipe,
    /// Its index in a sequence.
    pub(super) step: Option<u32>,
    pub(super) output: &'a Output,
    pub(super) reporter: &'a Reporter,
    pub(super) control: &'a Control,
    /// Changes of files, for `turner watch`.
    pub(super) changes: Option<&'a Changes<'a>>,
}

impl One<'_> {
    /// Renders and writes the picture. Returns the exit code, or `None` if it stopped because a file changed.
    pub(super) fn render(&self, resumed: Option<Resumed>) -> Result<Option<u8>, Failure> {
        let Ready { prepared, sources, labels, .. } = self.ready;
        let (args, reporter, control) = (self.args, self.reporter, self.control);
        if let Some(expected) = &args.expected {
            let check = expected.check(&self.hashes.whole, prepared, &self.ready.desc.integrator);
            check.map_err(Failure::new)?;
        }
        let all = prepared.view.film.samples_per_pixel();
        if args.checkpoints.is_part() && prepared.view.film.adaptive_sampling {
            let message = "adaptive sampling decides from the whole picture, which --part and --sample-range cannot split";
            return Err(Failure::usage(
                SceneError::new(ErrorCode::Conflict, message)
                    .help("leave out --adaptive (`film.adaptive_sampling`)"),
            ));
        }
        let samples = args.checkpoints.samples(all)?;
        let resumed = self.found(resumed)?;
        let (mut renderer, path, header) = self.renderer(resumed)?;
        renderer.film.set_scene(fingerprint(&self.hashes.shared));
        let crop = &renderer.film.crop;
        self.output.check_space(crop.width, crop.height)?;
        // From here on an interrupt leaves a picture.
        control.begin_rendering();
        self.send_start(&renderer);
        let mut writer = self.writer(&renderer, path, header);
        let keeps = writer.as_ref().is_some_and(Writer::is_kept);
        let saving = || saving_time(&renderer, self.output, args.run.threads, keeps);
        let budget = Budget::new(&args.budget, control.begun, saving);
        let name = args.scene.scene.file_name().unwrap_or_default().to_string_lossy();
        let samples_of_job = samples.clone();
        let changes = self.changes;
        let job = Job {
            threads: args.run.threads,
            samples: samples_of_job,
            reporter,
            control,
            changes,
            budget,
            name: &name,
        };
        let mut save = |renderer: &Renderer| self.save_progress(renderer);
        let save: Option<&mut dyn FnMut(&Renderer)> = if changes.is_some() { Some(&mut save) } else { None };
        let mut viewers = Viewers::new(&args.viewers, &name, self.output, save, reporter, self.is_model())?;
        let mut traced = trace(renderer, &job, writer.as_mut(), &mut viewers);
        if traced.interrupted && !control.is_interrupted() {
            reporter.line("a file of the scene changed: rendering again");
            return Ok(None);
        }

        control.begin_saving();
        let start = Instant::now();
        let (saved, kept) = self.save_all(&traced, &samples, writer.as_mut());
        let remarks = saved.map_err(|failure| match &kept {
            Some(path) => failure.note(format!("the samples were kept: `{}`", checkpoint::command(path))),
            None => failure,
        })?;
        let written = remarks.is_some() && !self.output.is_part();
        let save_seconds = start.elapsed().as_secs_f64();
        let mut late = late_warnings(&traced, &self.ready.desc.integrator);
        late.extend(remarks.unwrap_or_default());
        if !args.strict {
            reporter.warnings(&late, sources, labels);
        }
        let named = written || self.output.is_part() && kept.is_some();
        let report = Report {
            traced: &traced,
            written: named,
            load_seconds: self.ready.seconds,
            save_seconds,
            hash: &self.hashes.whole,
            checkpoint: kept.as_deref(),
        };
        report.send(self.output, reporter);
        if let (Some(path), true) = (&kept, traced.interrupted || traced.fault.is_some()) {
            reporter.line(&format!("continue it with `{}`", checkpoint::command(path)));
        }
        if let Some(error) = control.starved() {
            return Err(Failure::new(error));
        }
        match traced.fault.take() {
            Some(fault) => Err(Failure::new(fault)),
            None if traced.interrupted => Ok(Some(control.exit_code())),
            None if args.strict && late.iter().any(|w| w.kind == WarningKind::Ignored) => {
                Err(strict(&late, sources, labels))
            }
            None if self.output.is_part() && !named => Ok(Some(crate::failure::FAILED)),
            None => Ok(Some(0)),
        }
    }

    /// Whether it is a model in the default studio, and the only picture.
    fn is_model(&self) -> bool {
        let desc = &self.ready.desc;
        desc.studio.is_some() && !desc.imports.is_empty() && !self.args.is_sequence()
    }

    /// Writes the picture of a film; `header` is that of its checkpoint.
    pub(super) fn develop(&self, header: &Header, film: Film) -> Result<(), Failure> {
        let path = Path::new(&header.scene);
        checkpoint::check_scene(path, header, &self.hashes.shared).map_err(Failure::new)?;
        let mut renderer = Renderer::resume(self.ready.prepared.clone(), film).map_err(Failure::new)?;
        load_denoiser(&mut renderer).map_err(Failure::new)?;
        let samples = 0..renderer.samples_per_pixel();
        let finished = renderer.film.finished(&samples);
        let noise = renderer.film.noise(self.args.run.threads);
        let traced =
            Traced { renderer, seconds: 0.0, finished, interrupted: false, ended: None, noise, fault: None };
        self.save(&traced, &samples).map(drop)
    }

    /// The checkpoint to continue: the given one; with `--resume`, the file beside the picture or the named one.
    fn found(&self, resumed: Option<Resumed>) -> Result<Option<Resumed>, Failure> {
        if resumed.is_some() || !self.args.checkpoints.resume {
            return Ok(resumed);
        }
        let limits = Limits { memory: self.control.memory(), ..Limits::default() };
        let read =
            |path: PathBuf| checkpoint::read(&path, &limits).map(|checkpoint| Resumed { path, checkpoint });
        let part = self.output.file().filter(|_| self.output.is_part()).map(PathBuf::from);
        if let Some(path) = self.args.checkpoints.checkpoint.clone().or(part) {
            return if path.exists() { read(path).map(Some) } else { Ok(None) };
        }
        let Some(picture) = self.output.file() else { return Ok(None) };
        let files = checkpoint::all_beside(picture);
        for path in &files {
            let found = read(path.clone())?;
            let header = &found.checkpoint.header;
            if header.scene_hash == self.hashes.shared && header.step == self.step {
                return Ok(Some(found));
            }
        }
        if let Some(path) = files.first() {
            let message = format!(
                "{} is of another scene or other options: rendering from the beginning",
                path.display()
            );
            self.reporter.warnings(
                &[Warning::new(WarningKind::Note, message)],
                &Sources::default(),
                &Labels::new(),
            );
        }
        Ok(None)
    }

    /// The renderer, with the file and the header of the checkpoint that it continues.
    fn renderer(
        &self,
        resumed: Option<Resumed>,
    ) -> Result<(Renderer, Option<PathBuf>, Option<Header>), Failure> {
        let Ready { prepared, sources, labels, .. } = self.ready;
        let Some(Resumed { path, checkpoint }) = resumed else {
            let mut renderer =
                Renderer::new(prepared.clone()).map_err(|e| Failure::in_scene(e, sources, labels))?;
            load_denoiser(&mut renderer).map_err(Failure::new)?;
            return Ok((renderer, None, None));
        };
        checkpoint::check_scene(&path, &checkpoint.header, &self.hashes.shared).map_err(Failure::new)?;
        let mut renderer = Renderer::extend(prepared.clone(), checkpoint.film).map_err(|mut error| {
            error.message = format!("{}: {}", path.display(), error.message);
            Failure::new(error)
        })?;
        load_denoiser(&mut renderer).map_err(Failure::new)?;
        Ok((renderer, Some(path), Some(checkpoint.header)))
    }

    fn send_start(&self, renderer: &Renderer) {
        let Some(events) = self.reporter.events else { return };
        events.send(json!({
            "event": "start",
            "scene": self.args.scene.scene.to_string_lossy(),
            "output": self.output.name(),
            "width": renderer.film.crop.width,
            "height": renderer.film.crop.height,
            "samples_per_pixel": (!self.args.is_open()).then(|| renderer.samples_per_pixel()),
            "threads": threads(self.args.run.threads),
        }));
    }

    /// Writes checkpoints; `None` if the render cannot be continued: a scene from standard input, a picture that is
    /// not a file, or `turner watch`. `path` and `header` are those of the checkpoint that this render continues.
    fn writer(&self, renderer: &Renderer, path: Option<PathBuf>, header: Option<Header>) -> Option<Writer> {
        let args = self.args;
        let asked = args.checkpoints.checkpoint.clone();
        let part = self.output.file().filter(|_| self.output.is_part()).map(PathBuf::from);
        let keep =
            asked.is_some() || part.is_some() || header.as_ref().is_some_and(|h| h.keep && path.is_some());
        let scene = args.scene.scene.to_str().filter(|scene| *scene != "-")?;
        let (film, crop) = (&renderer.film, renderer.film.crop);
        let folder = std::env::current_dir().ok()?.to_str()?.to_owned();
        let new = Header {
            turner: VERSION.to_owned(),
            scene: scene.to_owned(),
            folder,
            scene_hash: self.hashes.shared.clone(),
            arguments: args.recorded.clone()?,
            step: self.step,
            output: self.output.recorded(),
            keep,
            size: film.identity().size,
            crop: [crop.x, crop.y, crop.width, crop.height],
            samples: film.identity().samples,
            held: 0.0,
            seconds: header.map_or(0.0, |h| h.seconds),
        };
        let (interval, memory) = (args.checkpoints.checkpoint_interval, self.control.memory());
        if let Some(path) = asked.or(part) {
            return Some(Writer::new(path, new, interval, memory, true));
        }
        if let Some(path) = path {
            return Some(Writer::new(path, new, interval, memory, true));
        }
        let picture = self.output.file().filter(|_| self.changes.is_none())?;
        let path = checkpoint::beside(picture, 1);
        Some(Writer::new(path, new, interval, memory, false).beside(picture))
    }

    /// Writes the picture and returns remarks about it. `None` if there is none: no pixel has a sample or a preview.
    fn save(&self, traced: &Traced, samples: &Range<u32>) -> Result<Option<Vec<Warning>>, Failure> {
        if self.output.is_part() {
            return Ok(Some(Vec::new()));
        }
        let Ready { desc, prepared, .. } = self.ready;
        let all = traced.renderer.samples_per_pixel();
        let count = if traced.ended.is_some() { traced.renderer.film.mean_samples() as u32 } else { all };
        let picture = FilmPicture::new(&traced.renderer, self.args.run.threads);
        if picture.is_empty() {
            return Ok(None);
        }
        let hash = &self.hashes.whole;
        let shown = picture.transform();
        let mut metadata =
            self.output.metadata(prepared, &desc.integrator, hash, count, &shown, &self.recipe);
        if traced.finished < 1.0 {
            // Rounded down: an unfinished picture is never at 1.
            let finished = (traced.finished * 1e4).floor() / 1e4;
            metadata.insert(FINISHED.to_owned(), format!("{finished}").as_str().into());
        }
        if let Some(noise) = &traced.noise {
            metadata.insert(NOISE.to_owned(), format!("{:.5}", noise.value).as_str().into());
        }
        let denoiser = traced.renderer.denoiser().filter(|_| traced.renderer.denoiser_fault().is_none());
        if let Some(denoiser) = denoiser {
            metadata.insert(DENOISED.to_owned(), denoiser.as_str().into());
            if let Some(left) = traced.renderer.left_after_denoising() {
                metadata.insert(LEFT.to_owned(), format!("{left:.5}").as_str().into());
            }
        }
        if *samples != (0..all) {
            let range = format!("{}..{}", samples.start, samples.end);
            metadata.insert(SAMPLE_RANGE.to_owned(), range.as_str().into());
        }
        self.output.write(&picture, &traced.renderer, &metadata, self.args.run.threads)?;
        Ok(Some(self.output.remarks(&picture)))
    }

    /// For `turner watch`: writes the picture so far. An error shows when the finished picture is written.
    fn save_progress(&self, renderer: &Renderer) {
        let Ready { desc, prepared, .. } = self.ready;
        let picture = FilmPicture::progress(renderer, self.args.run.threads);
        let (shown, hash) = (picture.transform(), &self.hashes.whole);
        let samples = renderer.film.mean_samples() as u32;
        let mut metadata =
            self.output.metadata(prepared, &desc.integrator, hash, samples, &shown, &self.recipe);
        metadata.insert(FINISHED.to_owned(), "0".into());
        let _ = self.output.write(&picture, renderer, &metadata, self.args.run.threads);
    }

    /// Writes the picture and the checkpoint, both at once: the disk is busy with one while the other is encoded. The
    /// checkpoint of a finished picture is removed, unless the user named it; if the picture cannot be written, it is
    /// written after all. Returns the result of [`One::save`] and the file of the checkpoint, if there is one.
    fn save_all(
        &self,
        traced: &Traced,
        samples: &Range<u32>,
        writer: Option<&mut Writer>,
    ) -> (Result<Option<Vec<Warning>>, Failure>, Option<PathBuf>) {
        let Some(writer) = writer else { return (self.save(traced, samples), None) };
        let film = &traced.renderer.film;
        let reporter = self.reporter;
        let is_unfinished = traced.interrupted || traced.fault.is_some();
        let is_worth_it = film.samples() > 0 && self.control.starved().is_none();
        if !(writer.is_kept() || is_unfinished && is_worth_it) {
            let saved = self.save(traced, samples);
            if saved.is_err() && is_worth_it {
                return (saved, writer.write_last(film, traced.seconds, reporter).map(PathBuf::from));
            }
            if !is_unfinished && saved.is_ok() {
                writer.remove(reporter);
            }
            return (saved, None);
        }
        std::thread::scope(|scope| {
            let task = scope.spawn(|| writer.write_last(film, traced.seconds, reporter).map(PathBuf::from));
            let saved = self.save(traced, samples);
            (saved, task.join().unwrap_or_default())
        })
    }
}
