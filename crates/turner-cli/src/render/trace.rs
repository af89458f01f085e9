//! The trace loop: pass after pass, until the picture is complete or something stops it.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use turner::film::Noise;
use turner::render::{PassOptions, PassRange, Renderer};
use turner::schema::SceneError;

use super::budget::{Budget, End};
use super::viewers::Viewers;
use crate::checkpoint::Writer;
use crate::control::Control;
use crate::progress::Progress;
use crate::report::Reporter;
use crate::watch::Changes;

/// What is traced, and what may stop it.
pub(super) struct Job<'a> {
    /// Number of threads; 0 uses all.
    pub(super) threads: usize,
    /// The sample indices.
    pub(super) samples: Range<u32>,
    /// Receives progress.
    pub(super) reporter: &'a Reporter,
    /// The user's interrupts.
    pub(super) control: &'a Control,
    /// Changes of the scene's files, which stop it.
    pub(super) changes: Option<&'a Changes<'a>>,
    /// Time and noise.
    pub(super) budget: Budget,
    /// The name of the scene, for the progress line.
    pub(super) name: &'a str,
}

/// The result of tracing.
pub(super) struct Traced {
    pub(super) renderer: Renderer,
    /// Seconds of tracing.
    pub(super) seconds: f64,
    /// Fraction of the work that is done.
    pub(super) finished: f64,
    /// Whether it stopped before the end without a fault.
    pub(super) interrupted: bool,
    /// The part of its budget that ended it.
    pub(super) ended: Option<End>,
    /// The noise of the picture, if it can be estimated.
    pub(super) noise: Option<Noise>,
    /// The panic of a worker.
    pub(super) fault: Option<SceneError>,
}

/// Samples per pixel of the next pass. The first pass has one sample, so that a whole picture exists early. Each of the
/// next ones doubles the number of samples, up to 16. Later passes add an eighth, because each pass starts its threads
/// again. Passes end at the same numbers of samples in every render.
fn pass_samples(done: u32) -> u32 {
    match done {
        0 => 1,
        1..16 => done.next_power_of_two(),
        _ => (done / 8).clamp(16, 256),
    }
}

/// Renders pass after pass until all samples are done, the user interrupts, a file changes, or a worker fails. A pass
/// that is due for a checkpoint is cancelled and continued afterwards: the film keeps its finished samples.
pub(super) fn trace(
    mut renderer: Renderer,
    job: &Job<'_>,
    mut checkpoints: Option<&mut Writer>,
    viewers: &mut Viewers<'_>,
) -> Traced {
    let Job { control, reporter, samples, budget, .. } = job;
    let total = samples.end - samples.start;
    let progress = Progress::new(reporter, job.name, total, renderer.film.finished(samples), budget.deadline);
    let start = Instant::now();
    let (mut fault, mut ended, fault_after) = (None, None, fault_after());
    let changed = AtomicBool::new(false);
    viewers.begin(&mut renderer, job.threads, &control.pause, budget.deadline);
    while let Some((range, done, goal)) = next(&mut renderer, job)
        && fault.is_none()
    {
        // Before the test for an interrupt, which sets it again.
        control.pause.store(false, Ordering::SeqCst);
        if control.is_interrupted() || changed.load(Ordering::SeqCst) {
            break;
        }
        if budget.is_over(done) {
            ended = Some(End::Time);
            break;
        }
        let Some(goal) = budget.limit(done, goal, start.elapsed()) else {
            ended = Some(End::Time);
            break;
        };
        let range = match range {
            Some(range) => PassRange::all_tiles(range.start..samples.start + goal),
            None => PassRange::all_tiles(0..u32::MAX),
        };
        progress.begin_pass(renderer.film.finished(samples) * f64::from(total), goal);
        let tile = |done, tiles| {
            progress.tile(done, tiles);
            assert!(Some(done) != fault_after, "injected by {FAULT_AFTER}");
            if job.changes.is_some_and(Changes::any) {
                changed.store(true, Ordering::SeqCst);
                control.pause.store(true, Ordering::SeqCst);
            }
            if checkpoints.as_ref().is_some_and(|c| c.is_due()) {
                control.pause.store(true, Ordering::SeqCst);
            }
        };
        let options = PassOptions { threads: job.threads, cancel: &control.pause, progress: Some(&tile) };
        let result =
            until(budget.deadline_for(goal), &control.pause, || renderer.pass_over(&range, &options));
        fault = result.as_ref().err().cloned();
        if let Some(writer) = checkpoints.as_mut().filter(|c| c.is_due()) {
            writer.write(&renderer.film, start.elapsed().as_secs_f64(), reporter);
        }
        if matches!(result, Ok(true)) {
            progress.end_pass();
            let noise = || renderer.film.noise(job.threads);
            let is_clean = budget.is_clean(goal, || {
                let noise = noise();
                progress.set_noise(goal, budget, || noise);
                noise
            });
            if goal.is_power_of_two() {
                if !budget.has_noise() {
                    progress.set_noise(goal, budget, noise);
                }
                viewers.show(&renderer, job.threads, goal == total);
            }
            if is_clean && goal < total {
                ended = Some(End::Noise);
                break;
            }
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    progress.finish();
    let interrupted = is_unfinished(&renderer, samples) && fault.is_none() && ended.is_none();
    if interrupted && control.is_interrupted() || ended.is_some() && !renderer.film.has_preview() {
        cover(&mut renderer, job.threads);
    }
    let finished = if ended.is_some() { 1.0 } else { renderer.film.finished(samples) };
    let noise = renderer.film.noise(job.threads);
    Traced { renderer, seconds, finished, interrupted, ended, noise, fault }
}

/// The next pass: its range of sample indices, the samples per pixel before and after it. Passes of an adaptive film go
/// from one decision to the next, over all indices.
fn next(renderer: &mut Renderer, job: &Job<'_>) -> Option<(Option<Range<u32>>, u32, u32)> {
    let samples = &job.samples;
    if !renderer.film.identity().adaptive {
        let first = renderer.film.first_missing_in(samples)?;
        let done = first - samples.start;
        let goal = done.saturating_add(pass_samples(done)).min(samples.end - samples.start);
        return Some((Some(first..samples.start + goal), done, goal));
    }
    let done = renderer.film.mean_samples();
    if done == 0.0 && !job.control.is_interrupted() {
        // A whole picture early.
        return Some((Some(0..1), 0, 1));
    }
    renderer.allot(job.threads).then(|| (None, done as u32, renderer.film.mean_goal()))
}

fn is_unfinished(renderer: &Renderer, samples: &Range<u32>) -> bool {
    match renderer.film.identity().adaptive {
        true => !renderer.is_complete(),
        false => renderer.film.first_missing_in(samples).is_some(),
    }
}

/// Runs `work` and sets `pause` at the deadline.
pub(super) fn until<T>(deadline: Option<Instant>, pause: &AtomicBool, work: impl FnOnce() -> T) -> T {
    let Some(deadline) = deadline else { return work() };
    std::thread::scope(|scope| {
        let (done, wait) = channel::<()>();
        scope.spawn(move || {
            let left = deadline.saturating_duration_since(Instant::now());
            if wait.recv_timeout(left) == Err(RecvTimeoutError::Timeout) {
                pause.store(true, Ordering::SeqCst);
            }
        });
        let result = work();
        drop(done);
        result
    })
}

/// The longest time that the preview of an interrupted render takes.
const COVER: Duration = Duration::from_millis(400);

/// Traces a coarse preview where pixels have no samples yet.
fn cover(renderer: &mut Renderer, threads: usize) {
    if renderer.is_covered() {
        return;
    }
    let late = AtomicBool::new(false);
    // Without it, the missing pixels are transparent.
    let _ = until(Some(Instant::now() + COVER), &late, || {
        renderer.preview_pass(&PassOptions { threads, cancel: &late, progress: None })
    });
}

/// For tests: environment variable with the number of tiles, or batches of light paths, of a pass after which a worker
/// panics.
const FAULT_AFTER: &str = "TURNER_FAULT_AFTER";

fn fault_after() -> Option<usize> {
    std::env::var(FAULT_AFTER).ok()?.parse().ok()
}
