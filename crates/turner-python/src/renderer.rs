//! The class behind `turner.Renderer`: passes, progress, cancel, films.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use turner::film::{Antialias, Film};
use turner::render::{PassOptions, PassRange, Renderer as Tracer};
use turner::schema::{ErrorCode, Limits, SceneError};
use turner_io::scene::Sources;

use crate::errors::Origin;
use crate::picture;
use crate::places::Places;
use crate::scene::Made;
use crate::turns::{Run, Turns};
use crate::work::attend;

/// The most samples per pixel, which no render reaches: time or noise ends it.
const UNLIMITED: u32 = 1 << 24;

/// The time that choices of the integrator take before a pass asks for them again; twice as long after each pass.
const CHOICE: Duration = Duration::from_millis(200);

/// Time between two looks whether they are made.
const POLL: Duration = Duration::from_millis(2);

/// Fewer samples per pixel do not show their noise reliably.
const LEAST_SAMPLES: u32 = 16;

/// Renders a scene pass by pass.
#[pyclass(frozen, module = "turner._turner")]
pub struct Renderer {
    tracer: Turns<Tracer>,
    made: Made,
    threads: usize,
}

/// When a run ends.
struct Goal {
    /// Sample indices.
    samples: std::ops::Range<u32>,
    deadline: Option<Instant>,
    noise: Option<f64>,
}

/// A pass of a run. One that readers interrupt continues with the samples that are left, so that passes end where they do
/// without readers.
struct Pass {
    range: PassRange,
    /// Samples per pixel before it.
    done: u32,
    /// Samples per pixel that it adds.
    size: f64,
}

/// What a step of a run led to.
enum Step {
    /// The run is over; whether it reached its goal or its deadline.
    Ended(bool),
    /// A pass was traced.
    Traced,
    /// A reader or a cancel interrupted the pass.
    Interrupted {
        /// Whether the film has more samples than before.
        gained: bool,
    },
}

/// Samples per pixel of the next pass: early pictures first, then passes long enough to keep the threads busy.
fn pass_samples(done: u32) -> u32 {
    match done {
        0 => 1,
        1..16 => done.next_power_of_two(),
        _ => (done / 8).clamp(16, 256),
    }
}

impl Goal {
    fn count(&self) -> u32 {
        self.samples.end.saturating_sub(self.samples.start).max(1)
    }

    /// The next pass; `None` if the film has all samples.
    fn next_pass(&self, tracer: &mut Tracer, threads: usize) -> Option<Pass> {
        let (range, done) = if tracer.film.identity().adaptive {
            if !tracer.allot(threads) || tracer.film.mean_samples() >= f64::from(self.samples.end) {
                return None;
            }
            (PassRange::all_tiles(0..u32::MAX), tracer.film.mean_samples() as u32)
        } else {
            let first = tracer.film.first_missing_in(&self.samples)?;
            let done = first - self.samples.start;
            let end = first.saturating_add(pass_samples(done)).min(self.samples.end);
            (PassRange::all_tiles(first..end), done)
        };
        let count = self.count();
        let size = f64::from(pass_samples(done).min(count - done.min(count - 1)));
        Some(Pass { range, done, size })
    }
}

impl Renderer {
    pub(crate) fn new(py: Python<'_>, made: Made, threads: usize) -> PyResult<Renderer> {
        let tracer = Tracer::new(made.prepared.clone());
        let tracer =
            tracer.map_err(|e| Origin { sources: &made.sources, places: &made.places }.error(py, &e))?;
        Ok(Renderer { tracer: Turns::new(tracer), made, threads })
    }

    fn error(&self, py: Python<'_>, error: &SceneError) -> PyErr {
        Origin { sources: &self.made.sources, places: &self.made.places }.error(py, error)
    }

    /// Traces until the goal, a deadline, low noise or a cancel. Returns whether the goal was reached. No GIL is needed.
    fn trace(&self, run: &Run<'_, Tracer>, goal: &Goal, progress: &AtomicU64) -> Result<bool, SceneError> {
        let prepared = run.slice(|tracer, _| tracer.prepared().clone());
        if turner_cli::threads(self.threads) == 1 {
            // A pass of one thread makes the choices first, and cannot be interrupted meanwhile.
            run.aside(|| prepared.choose(1));
        }
        let mut pass = None;
        let mut patience = CHOICE;
        loop {
            match run.slice(|tracer, stop| self.step(tracer, stop, goal, &mut pass, progress))? {
                Step::Ended(reached) => return Ok(reached),
                Step::Interrupted { gained: false } if prepared.integrator.has_chosen() => run.lengthen(),
                Step::Traced | Step::Interrupted { .. } => {}
            }
            if !prepared.integrator.has_chosen() {
                // A thread that the pass has started makes the choices. After a panic there they are never made, and the
                // next pass tells.
                let until = Instant::now() + patience;
                let is_waiting = || !prepared.integrator.has_chosen() && !self.tracer.is_cancelled();
                run.aside(|| {
                    while is_waiting() && Instant::now() < until {
                        std::thread::sleep(POLL);
                    }
                });
                patience *= 2;
            }
        }
    }

    /// Traces a pass, or what is left of it, until `stop` is set.
    fn step(
        &self,
        tracer: &mut Tracer,
        stop: &AtomicBool,
        goal: &Goal,
        begun: &mut Option<Pass>,
        progress: &AtomicU64,
    ) -> Result<Step, SceneError> {
        let Some(pass) = begun.take().or_else(|| goal.next_pass(tracer, self.threads)) else {
            return Ok(Step::Ended(true));
        };
        let is_over = goal.deadline.is_some_and(|deadline| Instant::now() >= deadline);
        if is_over && pass.done > 0 || self.tracer.is_cancelled() {
            return Ok(Step::Ended(is_over));
        }
        let count = f64::from(goal.count());
        let (first, last) = (f64::from(pass.done) / count, (f64::from(pass.done) + pass.size) / count);
        let from = f64::from_bits(progress.load(Ordering::Relaxed)).max(first).min(last);
        let tick = |part: usize, parts: usize| {
            let now = from + (last - from) * part as f64 / parts.max(1) as f64;
            progress.store(now.min(1.0).to_bits(), Ordering::Relaxed);
        };
        let options = PassOptions { threads: self.threads, cancel: stop, progress: Some(&tick) };
        let before = tracer.film.samples();
        if !tracer.pass_over(&pass.range, &options)? {
            *begun = Some(pass);
            return Ok(Step::Interrupted { gained: tracer.film.samples() > before });
        }
        let noise = |tracer: &Tracer| tracer.film.noise(self.threads).map(|noise| noise.value);
        let is_clean = pass.done + pass.size as u32 >= LEAST_SAMPLES
            && goal.noise.is_some_and(|least| noise(tracer).is_some_and(|now| now <= least));
        Ok(if is_clean { Step::Ended(true) } else { Step::Traced })
    }

    /// Numbers about the samples so far; with `noise`, also that.
    fn numbers(&self, tracer: &Tracer, noise: bool) -> Numbers {
        let area = (tracer.film.region.area() as f64).max(1.0);
        Numbers {
            samples: tracer.film.samples() as f64 / area,
            total: tracer.samples_per_pixel(),
            complete: tracer.is_complete(),
            rays: tracer.stats.total(),
            non_finite: tracer.film.non_finite.count,
            noise: noise.then(|| tracer.film.noise(self.threads)).flatten().map(|noise| noise.value),
        }
    }
}

/// Numbers about a film.
#[derive(IntoPyObject)]
struct Numbers {
    samples: f64,
    total: u32,
    complete: bool,
    rays: u64,
    non_finite: u64,
    noise: Option<f64>,
}

#[pymethods]
impl Renderer {
    /// Traces sample indices `first` to `end` - 1 of every pixel that the film lacks.
    #[pyo3(signature = (first=0, end=None, seconds=None, noise=None, progress=None))]
    fn run(
        &self,
        py: Python<'_>,
        first: u32,
        end: Option<u32>,
        seconds: Option<f64>,
        noise: Option<f64>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<bool> {
        let begun = Instant::now();
        let deadline = seconds
            .map(|s| Duration::try_from_secs_f64(s).map(|time| begun + time))
            .transpose()
            .map_err(|e| pyo3::exceptions::PyValueError::new_err(format!("seconds: {e}")))?;
        let total = py.detach(|| self.tracer.read(Tracer::samples_per_pixel));
        let goal = Goal { samples: first..end.unwrap_or(total).min(total), deadline, noise };
        let done = AtomicU64::new(0);
        let over = AtomicBool::new(false);
        let report = progress.map(|p| p.clone().unbind());
        let work = || {
            let run = self.tracer.run();
            let result = match deadline {
                None => self.trace(&run, &goal, &done),
                Some(at) => std::thread::scope(|scope| {
                    let (end, wait) = std::sync::mpsc::channel::<()>();
                    let (over, tracer) = (&over, &self.tracer);
                    scope.spawn(move || {
                        let left = at.saturating_duration_since(Instant::now());
                        if wait.recv_timeout(left) == Err(std::sync::mpsc::RecvTimeoutError::Timeout) {
                            over.store(true, Ordering::SeqCst);
                            tracer.cancel();
                        }
                    });
                    let result = self.trace(&run, &goal, &done);
                    drop(end);
                    result
                }),
            };
            // A picture without a hole, whatever the time was.
            if over.load(Ordering::SeqCst) {
                run.slice(|tracer, _| {
                    if !tracer.is_covered() {
                        let never = AtomicBool::new(false);
                        let options = PassOptions { threads: self.threads, cancel: &never, progress: None };
                        let _ = tracer.preview_pass(&options);
                    }
                });
            }
            result
        };
        let mut last = f64::NAN;
        let tick = |py: Python<'_>| {
            let Some(report) = &report else { return Ok(()) };
            let now = f64::from_bits(done.load(Ordering::Relaxed));
            if now == last {
                return Ok(());
            }
            last = now;
            report.call1(py, (now,)).map(drop)
        };
        let result = attend(py, || self.tracer.cancel(), work, tick);
        let was_cancelled = self.tracer.uncancel() && !over.load(Ordering::SeqCst);
        let reached = result?.map_err(|e| self.error(py, &e))?;
        if let (Some(report), true) = (&report, reached) {
            report.call1(py, (1.0,))?;
        }
        Ok(reached && !was_cancelled || over.load(Ordering::SeqCst))
    }

    /// Stops a run on another thread within milliseconds; without one, the next run returns at once.
    fn cancel(&self) {
        self.tracer.cancel();
    }

    /// The picture of the samples so far, as a dict of arrays, with its numbers as `state`.
    fn develop<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let look = |tracer: &Tracer| (picture::develop(tracer, self.threads), self.numbers(tracer, true));
        let (developed, numbers) = attend(py, || (), || self.tracer.read(look), |_| Ok(()))?;
        let out = developed.into_dict(py)?;
        out.set_item("state", numbers)?;
        Ok(out)
    }

    /// The samples as bytes, for `load_film` and `merge_films`.
    fn film<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        let bytes = py.detach(|| self.tracer.read(|tracer| tracer.film.to_bytes()));
        PyBytes::new(py, &bytes)
    }

    /// Replaces the samples by those of a film of the same picture.
    fn load_film(&self, py: Python<'_>, bytes: Vec<u8>) -> PyResult<()> {
        let result = py.detach(|| {
            let film = Film::from_bytes(&bytes, &Limits::default())?;
            let renewed = Tracer::resume(self.made.prepared.clone(), film)?;
            self.tracer.change(|tracer| *tracer = renewed);
            Ok(())
        });
        result.map_err(|e: SceneError| self.error(py, &e))
    }

    /// Adds the samples of a film of the same picture.
    fn merge_film(&self, py: Python<'_>, bytes: Vec<u8>) -> PyResult<()> {
        let result = py.detach(|| {
            let film = Film::from_bytes(&bytes, &Limits::default())?;
            self.tracer.change(|tracer| {
                tracer.prepared().choose(1);
                tracer.film.merge(&film)
            })
        });
        result.map_err(|e: SceneError| self.error(py, &e))
    }

    /// Numbers: samples per pixel so far and in all, rays, non-finite samples, whether the picture is complete; `noise` is
    /// None.
    fn state(&self, py: Python<'_>) -> Numbers {
        py.detach(|| self.tracer.read(|tracer| self.numbers(tracer, false)))
    }

    /// The relative error that 95 % of the pixels do not exceed; None with too few samples.
    fn noise(&self, py: Python<'_>) -> Option<f64> {
        py.detach(|| self.tracer.read(|tracer| self.numbers(tracer, true).noise))
    }

    /// Whether the samples per pixel follow the noise.
    fn is_adaptive(&self, py: Python<'_>) -> bool {
        py.detach(|| self.tracer.read(|tracer| tracer.film.identity().adaptive))
    }

    /// Lifts the limit of the samples per pixel: time or noise ends the run. Before the first run.
    fn open(&self, py: Python<'_>) -> PyResult<()> {
        let result = py.detach(|| {
            let mut prepared = self.made.prepared.clone();
            if prepared.view.sobol && prepared.view.film.antialias == Antialias::MonteCarlo {
                prepared.view.film.samples = UNLIMITED;
            }
            let renewed = Tracer::new(prepared)?;
            self.tracer.change(|tracer| *tracer = renewed);
            Ok(())
        });
        result.map_err(|e: SceneError| self.error(py, &e))
    }

    /// Issues the warnings about the scene.
    fn warn(&self, py: Python<'_>) -> PyResult<()> {
        let mut warnings = self.made.prepared.warnings.clone();
        warnings.extend(py.detach(|| turner::lint::lint(&self.made.desc, &self.made.prepared)));
        warnings.retain(|w| w.kind != turner::schema::WarningKind::Note);
        Origin { sources: &self.made.sources, places: &self.made.places }.warn(py, &warnings)
    }

    /// The camera as numbers.
    fn camera<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        crate::plain::of_json(py, &turner_cli::camera::json(&self.made.prepared.view).to_string())
    }
}

/// The films of parts of a picture as one. Errors name the films by their places in the list, from 0.
#[pyfunction]
pub fn merge_films<'py>(py: Python<'py>, films: Vec<Vec<u8>>) -> PyResult<Bound<'py, PyBytes>> {
    let merged = py.detach(|| {
        let mut parts: Vec<(usize, Film)> = Vec::new();
        for (i, bytes) in films.iter().enumerate() {
            let film =
                Film::from_bytes(bytes, &Limits::default()).map_err(|e| at(format!("films[{i}]"), e))?;
            match parts.iter_mut().find(|(_, part)| part.crop == film.crop) {
                Some((first, part)) => {
                    part.merge(&film).map_err(|e| at(format!("films[{first}] and films[{i}]"), e))?;
                }
                None => parts.push((i, film)),
            }
        }
        let parts: Vec<Film> = parts.into_iter().map(|(_, film)| film).collect();
        match parts.as_slice() {
            [] => Err(SceneError::new(ErrorCode::Film, "there are no films to merge")
                .help("give the films of all parts (`Renderer.film`)")),
            [only] => Ok(only.to_bytes()),
            several => Film::stitch(several).map(|film| film.to_bytes()),
        }
    });
    match merged {
        Ok(bytes) => Ok(PyBytes::new(py, &bytes)),
        Err(error) => {
            Err(Origin { sources: &Sources::default(), places: &Places::default() }.error(py, &error))
        }
    }
}

/// An error that says which films it is about.
fn at(films: String, mut error: SceneError) -> SceneError {
    error.message = format!("{films}: {}", error.message);
    error
}
