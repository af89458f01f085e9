//! The class behind `turner.Renderer`: passes, progress, cancel, films.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use turner::film::{Antialias, Film};
use turner::render::{PassOptions, PassRange, Renderer as Tracer};
use turner::schema::{ErrorCode, Limits, SceneError};

use crate::errors::Origin;
use crate::picture;
use crate::scene::Made;
use crate::work::attend;

/// The most samples per pixel, which no render reaches: time or noise ends it.
const UNLIMITED: u32 = 1 << 24;

/// Fewer samples per pixel do not show their noise reliably.
const LEAST_SAMPLES: u32 = 16;

/// Renders a scene pass by pass.
#[pyclass(frozen, module = "turner._turner")]
pub struct Renderer {
    tracer: Mutex<Tracer>,
    made: Made,
    threads: usize,
    cancel: AtomicBool,
}

/// When a run ends.
struct Goal {
    /// Sample indices.
    samples: std::ops::Range<u32>,
    deadline: Option<Instant>,
    noise: Option<f64>,
}

/// Samples per pixel of the next pass: early pictures first, then passes long enough to keep the threads busy.
fn pass_samples(done: u32) -> u32 {
    match done {
        0 => 1,
        1..16 => done.next_power_of_two(),
        _ => (done / 8).clamp(16, 256),
    }
}

impl Renderer {
    pub(crate) fn new(py: Python<'_>, made: Made, threads: usize) -> PyResult<Renderer> {
        let tracer = Tracer::new(made.prepared.clone());
        let tracer =
            tracer.map_err(|e| Origin { sources: &made.sources, places: &made.places }.error(py, &e))?;
        Ok(Renderer { tracer: Mutex::new(tracer), made, threads, cancel: AtomicBool::new(false) })
    }

    fn lock(&self) -> MutexGuard<'_, Tracer> {
        self.tracer.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn error(&self, py: Python<'_>, error: &SceneError) -> PyErr {
        Origin { sources: &self.made.sources, places: &self.made.places }.error(py, error)
    }

    /// Traces until the goal, a deadline, low noise or a cancel. Returns whether the goal was reached. No GIL is needed.
    fn trace(&self, goal: &Goal, progress: &AtomicU64) -> Result<bool, SceneError> {
        let mut tracer = self.lock();
        let count = goal.samples.end.saturating_sub(goal.samples.start).max(1);
        loop {
            let is_adaptive = tracer.film.identity().adaptive;
            let (range, done) = if is_adaptive {
                if !tracer.allot(self.threads) || tracer.film.mean_samples() >= f64::from(goal.samples.end) {
                    return Ok(true);
                }
                (PassRange::all_tiles(0..u32::MAX), tracer.film.mean_samples() as u32)
            } else {
                let Some(first) = tracer.film.first_missing_in(&goal.samples) else { return Ok(true) };
                let done = first - goal.samples.start;
                let end = first.saturating_add(pass_samples(done)).min(goal.samples.end);
                (PassRange::all_tiles(first..end), done)
            };
            let is_over = goal.deadline.is_some_and(|deadline| Instant::now() >= deadline);
            if is_over && done > 0 || self.cancel.load(Ordering::SeqCst) {
                return Ok(is_over);
            }
            let size = f64::from(pass_samples(done).min(count - done.min(count - 1)));
            let tick = |part: usize, parts: usize| {
                let now = f64::from(done) + size * part as f64 / parts.max(1) as f64;
                progress.store((now / f64::from(count)).min(1.0).to_bits(), Ordering::Relaxed);
            };
            let options = PassOptions { threads: self.threads, cancel: &self.cancel, progress: Some(&tick) };
            let is_whole = tracer.pass_over(&range, &options)?;
            let now = done + size as u32;
            if is_whole
                && now >= LEAST_SAMPLES
                && goal
                    .noise
                    .is_some_and(|least| tracer.film.noise(self.threads).is_some_and(|n| n.value <= least))
            {
                return Ok(true);
            }
        }
    }
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
        let total = py.detach(|| self.lock().samples_per_pixel());
        let goal = Goal { samples: first..end.unwrap_or(total).min(total), deadline, noise };
        let done = AtomicU64::new(0);
        let over = AtomicBool::new(false);
        let report = progress.map(|p| p.clone().unbind());
        let work = || {
            let result = match deadline {
                None => self.trace(&goal, &done),
                Some(at) => std::thread::scope(|scope| {
                    let (end, wait) = std::sync::mpsc::channel::<()>();
                    let (over, cancel) = (&over, &self.cancel);
                    scope.spawn(move || {
                        let left = at.saturating_duration_since(Instant::now());
                        if wait.recv_timeout(left) == Err(std::sync::mpsc::RecvTimeoutError::Timeout) {
                            over.store(true, Ordering::SeqCst);
                            cancel.store(true, Ordering::SeqCst);
                        }
                    });
                    let result = self.trace(&goal, &done);
                    drop(end);
                    result
                }),
            };
            // A picture without a hole, whatever the time was.
            if over.load(Ordering::SeqCst) {
                let mut tracer = self.lock();
                if !tracer.is_covered() {
                    let never = AtomicBool::new(false);
                    let options = PassOptions { threads: self.threads, cancel: &never, progress: None };
                    let _ = tracer.preview_pass(&options);
                }
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
        let result = attend(py, &self.cancel, work, tick);
        let was_cancelled = self.cancel.swap(false, Ordering::SeqCst) && !over.load(Ordering::SeqCst);
        let reached = result?.map_err(|e| self.error(py, &e))?;
        if let (Some(report), true) = (&report, reached) {
            report.call1(py, (1.0,))?;
        }
        Ok(reached && !was_cancelled || over.load(Ordering::SeqCst))
    }

    /// Stops a run on another thread within milliseconds; without one, the next run returns at once.
    fn cancel(&self) {
        self.cancel.store(true, Ordering::SeqCst);
    }

    /// The picture of the samples so far, as a dict of arrays.
    fn develop<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let never = AtomicBool::new(false);
        let developed = attend(py, &never, || picture::develop(&self.lock(), self.threads), |_| Ok(()))?;
        developed.into_dict(py)
    }

    /// The samples as bytes, for `load_film` and `merge_films`.
    fn film<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        let bytes = py.detach(|| self.lock().film.to_bytes());
        PyBytes::new(py, &bytes)
    }

    /// Replaces the samples by those of a film of the same picture.
    fn load_film(&self, py: Python<'_>, bytes: Vec<u8>) -> PyResult<()> {
        let result = py.detach(|| {
            let film = Film::from_bytes(&bytes, &Limits::default())?;
            let renewed = Tracer::resume(self.made.prepared.clone(), film)?;
            *self.lock() = renewed;
            Ok(())
        });
        result.map_err(|e: SceneError| self.error(py, &e))
    }

    /// Adds the samples of a film of the same picture.
    fn merge_film(&self, py: Python<'_>, bytes: Vec<u8>) -> PyResult<()> {
        let result = py.detach(|| {
            let film = Film::from_bytes(&bytes, &Limits::default())?;
            let mut tracer = self.lock();
            tracer.prepared().choose();
            tracer.film.merge(&film)
        });
        result.map_err(|e: SceneError| self.error(py, &e))
    }

    /// Numbers: samples per pixel so far and in all, rays, noise, non-finite samples, whether the picture is complete.
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (total, complete, samples, rays, bad, noise) = py.detach(|| {
            let tracer = self.lock();
            let area = (tracer.film.region.area() as f64).max(1.0);
            let noise = tracer.film.noise(self.threads).map(|noise| noise.value);
            let (total, complete) = (tracer.samples_per_pixel(), tracer.is_complete());
            (
                total,
                complete,
                tracer.film.samples() as f64 / area,
                tracer.stats.total(),
                tracer.film.non_finite.count,
                noise,
            )
        });
        let out = PyDict::new(py);
        out.set_item("samples", samples)?;
        out.set_item("total", total)?;
        out.set_item("complete", complete)?;
        out.set_item("rays", rays)?;
        out.set_item("non_finite", bad)?;
        out.set_item("noise", noise)?;
        Ok(out)
    }

    /// Whether the samples per pixel follow the noise.
    fn is_adaptive(&self, py: Python<'_>) -> bool {
        py.detach(|| self.lock().film.identity().adaptive)
    }

    /// Lifts the limit of the samples per pixel: time or noise ends the run. Before the first run.
    fn open(&self, py: Python<'_>) -> PyResult<()> {
        let result = py.detach(|| {
            let mut prepared = self.made.prepared.clone();
            if prepared.view.sobol && prepared.view.film.antialias == Antialias::MonteCarlo {
                prepared.view.film.samples = UNLIMITED;
            }
            *self.lock() = Tracer::new(prepared)?;
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

/// The films of parts of a picture as one.
#[pyfunction]
pub fn merge_films<'py>(py: Python<'py>, films: Vec<Vec<u8>>) -> PyResult<Bound<'py, PyBytes>> {
    let merged = py.detach(|| {
        let mut parts: Vec<Film> = Vec::new();
        for bytes in &films {
            let film = Film::from_bytes(bytes, &Limits::default())?;
            match parts.iter_mut().find(|part| part.crop == film.crop) {
                Some(part) => part.merge(&film)?,
                None => parts.push(film),
            }
        }
        match parts.as_slice() {
            [] => Err(SceneError::new(ErrorCode::Film, "there are no films to merge")),
            [only] => Ok(only.to_bytes()),
            several => Film::stitch(several).map(|film| film.to_bytes()),
        }
    });
    match merged {
        Ok(bytes) => Ok(PyBytes::new(py, &bytes)),
        Err(error) => Err(PyRuntimeError::new_err(error.message)),
    }
}
