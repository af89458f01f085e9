//! All AOVs and debug views of the pixel under the pointer, found in a thread. Nothing of it is held by the film.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use turner::integrator::{IntegratorDesc, Prepared};
use turner::render::{PixelAov, label_name, pixel_aovs, pixel_samples};
use turner_live::engine::Stand;

use crate::task::Task;

/// The most samples of a pixel that its AOVs are found from.
const MOST: u32 = 256;

/// Samples of a debug view.
const OF_VIEWS: u32 = 16;

/// What is found of a pixel.
pub(crate) struct Found {
    /// Samples of the AOVs.
    pub(crate) samples: u32,
    /// The AOVs, in the order of their documentation.
    pub(crate) aovs: Vec<PixelAov>,
    /// Each debug view by its name, with its value: red, green, blue, alpha.
    pub(crate) views: Vec<(&'static str, [f32; 4])>,
    /// Why there are no AOVs.
    pub(crate) fault: Option<String>,
}

/// What is asked for.
#[derive(Clone)]
struct Asked {
    stand: Arc<Stand>,
    pixel: [u32; 2],
    samples: u32,
}

impl Asked {
    fn is_same(&self, other: &Asked) -> bool {
        Arc::ptr_eq(&self.stand, &other.stand) && (self.pixel, self.samples) == (other.pixel, other.samples)
    }
}

/// The state of the inspector.
#[derive(Default)]
pub(crate) struct PixelValues {
    found: Option<(Asked, Result<Found, String>)>,
    task: Option<(Asked, Task<Found>)>,
}

impl PixelValues {
    /// What is known of a pixel now; asks for the rest, if `may_trace`. `samples` of the pixel are in the film so far.
    pub(crate) fn of(
        &mut self,
        wake: &egui::Context,
        stand: &Arc<Stand>,
        pixel: [u32; 2],
        samples: u32,
        may_trace: bool,
    ) -> Option<&Result<Found, String>> {
        if let Some((asked, task)) = &self.task
            && let Some(result) = task.poll()
        {
            self.found = Some((asked.clone(), result.map_err(str::to_owned)));
            self.task = None;
        }
        // Powers of two: a film that fills is not followed sample by sample. With photons each further sample takes all
        // light paths of its index.
        let photons = stand.prepared.integrator.finds_photons();
        let samples = if photons { 1 } else { samples.clamp(1, MOST) };
        let samples = 1 << samples.ilog2();
        let asked = Asked { stand: Arc::clone(stand), pixel, samples };
        let is_known = self.found.as_ref().is_some_and(|(of, _)| of.is_same(&asked));
        if !is_known && self.task.is_none() && may_trace {
            let of_task = asked.clone();
            self.task = Some((asked.clone(), Task::start(wake, move |stop| find(&of_task, stop))));
        }
        let (of, found) = self.found.as_ref()?;
        (Arc::ptr_eq(&of.stand, stand) && of.pixel == pixel).then_some(found)
    }
}

fn find(asked: &Asked, stop: &AtomicBool) -> Found {
    let Asked { stand, pixel: [x, y], samples } = asked;
    let prepared = &stand.prepared;
    let (aovs, fault) = match pixel_aovs(prepared, *x, *y, *samples, stop) {
        Ok(aovs) => (aovs, None),
        Err(error) => (Vec::new(), Some(error.message)),
    };
    let mut views = Vec::new();
    for entry in IntegratorDesc::DOC.entries {
        if stop.load(Ordering::Relaxed) {
            break;
        }
        views.extend(view(prepared, entry.name, [*x, *y]).map(|value| (entry.name, value)));
    }
    Found { samples: *samples, aovs, views, fault }
}

/// The value of a debug view: the mean of some samples. `None` for integrators that show light, and for those that need more
/// of the scene than was prepared.
fn view(prepared: &Prepared, name: &str, [x, y]: [u32; 2]) -> Option<[f32; 4]> {
    let desc = IntegratorDesc::of_type(name)?;
    let needs = desc.capabilities();
    if !needs.debug || needs.physical && !prepared.integrator.capabilities().physical {
        return None;
    }
    let shown = prepared.with_integrator(desc.integrator()).ok()?;
    let samples = pixel_samples(&shown, x, y, 0..OF_VIEWS).ok()?;
    let mut sum = [0.0; 4];
    for sample in &samples {
        let [r, g, b] = sample.radiance.color.to_array();
        for (sum, v) in sum.iter_mut().zip([r, g, b, sample.radiance.alpha]) {
            *sum += v * sample.weight as f32;
        }
    }
    Some(sum)
}

/// The name of what an AOV of labels numbers, such as an object.
pub(crate) fn name_of(aov: &PixelAov, prepared: &Prepared) -> Option<String> {
    Some(label_name(&prepared.scene, aov.aov.labels()?, aov.label()?))
}
