//! What the window has found out about the picture: the explained pixel, the doctor's findings, a kept snapshot.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use turner::doctor::{Examination, Options, examine};
use turner::explain::{Explanation, Which, explain};
use turner_live::engine::{Frame, Stand};

use crate::task::Task;

/// Samples of a pixel among which that with the largest contribution is explained.
const SAMPLES: u32 = 8;

/// See the module.
#[derive(Default)]
pub struct Insight {
    /// The explanation of the chosen pixel, or why there is none.
    pub explanation: Option<Result<Arc<Explanation>, String>>,
    /// The sample to explain; `None` for that with the largest contribution.
    pub sample: Option<u32>,
    /// The number of bounces that are drawn; `None` for all.
    pub bounces: Option<usize>,
    /// The ray of the tree that is marked.
    pub marked: Option<usize>,
    explained: Option<(Arc<Stand>, [u32; 2], Option<u32>)>,
    traces_photons: bool,
    explaining: Option<Task<Result<Arc<Explanation>, String>>>,
    /// The doctor's findings, with the scene that they are about.
    pub examination: Option<(Arc<Examination>, Arc<turner::SceneDesc>)>,
    examining: Option<(Task<Examination>, Arc<turner::SceneDesc>)>,
    /// A kept picture to compare with.
    pub snapshot: Option<Arc<Frame>>,
    /// How the snapshot is compared.
    pub comparison: Comparison,
    /// The depth of the BVH whose boxes are drawn.
    pub boxes: Option<u32>,
}

/// How the snapshot and the picture are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Comparison {
    /// Only the picture.
    #[default]
    Off,
    /// The snapshot to the left of this fraction of the width, the picture to the right.
    Wipe(f32),
    /// The differences of display values, enlarged.
    Difference,
    /// FLIP: the difference that an observer sees.
    Flip,
}

impl Insight {
    /// Takes what is finished, and explains the chosen pixel again if the picture shows another scene.
    pub fn poll(&mut self, wake: &egui::Context, stand: Option<&Arc<Stand>>, pixel: Option<[u32; 2]>) {
        if let Some(task) = &self.explaining
            && let Some(result) = task.poll()
        {
            self.explanation = Some(result.unwrap_or_else(|fault| Err(fault.to_owned())));
            self.explaining = None;
        }
        if let Some((task, desc)) = &self.examining
            && let Some(result) = task.poll()
        {
            self.examination = result.ok().map(|examination| (Arc::new(examination), Arc::clone(desc)));
            self.examining = None;
        }
        let (Some(stand), Some(pixel)) = (stand, pixel) else {
            (self.explanation, self.explained, self.explaining) = (None, None, None);
            return;
        };
        let wanted = (stand, pixel, self.sample);
        let is_same = self
            .explained
            .as_ref()
            .is_some_and(|(of, at, n)| Arc::ptr_eq(of, wanted.0) && (*at, *n) == (wanted.1, wanted.2));
        if is_same || self.explaining.is_some() {
            return;
        }
        self.explained = Some((Arc::clone(stand), pixel, self.sample));
        let (stand, [x, y]) = (Arc::clone(stand), pixel);
        // Each sample with photons takes the light paths of its index.
        let finds_photons = stand.prepared.integrator.finds_photons();
        let most = if finds_photons { 1 } else { stand.prepared.view.film.samples_per_pixel().min(SAMPLES) };
        self.traces_photons = finds_photons;
        let which = self.sample.map_or(Which::Largest(most), Which::Index);
        self.explaining = Some(Task::start(wake, move |_| {
            let Stand { prepared, desc } = &*stand;
            explain(prepared, desc, x, y, which).map(Arc::new).map_err(|error| error.message)
        }));
    }

    /// What an explanation that is not there yet waits for.
    pub fn waits_for(&self) -> &'static str {
        match self.explaining.is_some() && self.traces_photons {
            true => "Tracing the photons of this sample. They are kept for further pixels.",
            false => "Tracing the sample",
        }
    }

    /// Starts the doctor.
    pub fn examine(&mut self, wake: &egui::Context, stand: Arc<Stand>) {
        let desc = Arc::clone(&stand.desc);
        let task = Task::start(wake, move |stop| {
            let enough = || stop.load(Ordering::Relaxed);
            let options = Options { threads: 1, stop: &enough, ..Options::default() };
            examine(&stand.prepared, &stand.desc, &options)
        });
        self.examining = Some((task, desc));
    }

    /// Whether the doctor is at work.
    pub fn is_examining(&self) -> bool {
        self.examining.is_some()
    }
}
