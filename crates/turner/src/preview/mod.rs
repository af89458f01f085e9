//! Approximate pictures for display: a window shows them while a scene is edited or its camera moves, until a film has
//! enough samples.
//!
//! A preview answers within a few hundredths of a second on two cores. It may be biased, is never saved, and depends on
//! nothing but the sequence of calls: the number of threads does not change a bit.
//!
//! ```text
//!  walk, surfaces   rays from pixel centres: first hits, mirrors and glass, cut-outs, sampled light and a bounce
//!      │            at one pixel of sixteen
//!      ▼
//!  buffers          light over albedo, accumulated over frames
//!      │
//!      ▼
//!  filter           à-trous passes that stop at edges, on a grid of cells of 4 x 4 pixels; in still views 2 x 2, and
//!      │            direct light at every pixel
//!      ▼
//!  upsample         the light of the grid at every pixel, by surface
//!      │
//!      ▼
//!  compose          light x albedo + what is seen ──► PreviewPicture
//! ```
//!
//! Approximations: light that is reflected more than twice is estimated from the mean of the picture, caustics are left to
//! the film, subsurface scattering is diffuse reflection, moving objects stand still, nested solids refract as if next to air, and
//! participating media are not drawn.
//!
//! The integrators `path` and `direct` are drawn so. All others trace one sample through the centre of each pixel,
//! or of one of four while the view moves (`centre`).

mod band;
mod buffers;
mod catcher;
mod centre;
mod compose;
mod draw;
mod fill;
mod filter;
mod history;
mod looks;
mod pattern;
mod picture;
mod show;
mod surfaces;
#[cfg(test)]
mod tests;
mod upsample;
mod walk;
mod work;

use std::sync::atomic::AtomicBool;

pub use picture::{NO_OBJECT, PreviewPicture};

use crate::camera::PixelCone;
use crate::integrator::Prepared;
use crate::preview::centre::{Centre, CentreRows};
use crate::preview::draw::Drawing;
use crate::preview::filter::FilterRow;
use crate::preview::upsample::UpsampleRow;
use crate::preview::walk::Walk;
use crate::schema::SceneError;
use crate::view::View;

/// What a frame of a preview is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// The scene or the view has changed, or may change in the next frame: light is sampled at one pixel of sixteen, and
    /// pixels between like ones are filled.
    Moving,
    /// A further frame of the same scene and view: it adds to those before it.
    Still,
}

impl Effort {
    /// Pixels along a side of the squares that share sampled light in the first frame of a view.
    fn cell(self) -> usize {
        match self {
            Effort::Moving => 4,
            Effort::Still => 2,
        }
    }
}

/// How a frame is drawn.
#[derive(Clone, Copy, Debug)]
pub struct PreviewOptions<'a> {
    /// Number of threads; 0 uses all.
    pub threads: usize,
    /// Ends the frame early when it becomes true.
    pub cancel: &'a AtomicBool,
    /// What the frame is for.
    pub effort: Effort,
    /// Sequence number of the frame: it selects the random numbers.
    pub frame: u32,
    /// Columns and rows. The aspect ratio should be that of the film.
    pub size: [u32; 2],
}

/// Draws approximate pictures of prepared scenes for display.
///
/// ```
/// use std::sync::atomic::AtomicBool;
/// use turner::preview::{Effort, Preview, PreviewOptions};
/// use turner::{PrepareOptions, SceneDesc};
///
/// let prepared = SceneDesc::default().prepare(&PrepareOptions::default())?;
/// let mut preview = Preview::new();
/// let cancel = AtomicBool::new(false);
/// let options = PreviewOptions { threads: 1, cancel: &cancel, effort: Effort::Moving, frame: 0, size: [32, 18] };
/// assert!(preview.frame(&prepared, &options)?);
/// assert_eq!(preview.picture().color.len(), 32 * 18);
/// # Ok::<(), turner::SceneError>(())
/// ```
#[derive(Default)]
pub struct Preview {
    picture: PreviewPicture,
    workers: Vec<Worker>,
    drawing: Drawing,
}

/// The buffers of one thread.
#[derive(Default)]
struct Worker {
    walk: Walk,
    row: FilterRow,
    upsample: UpsampleRow,
    centre: Centre,
}

/// Rows per task.
const ROWS: usize = 16;

/// The most columns or rows of a preview.
const MOST_SIDE: u32 = 16384;

impl Preview {
    /// A preview that has drawn nothing yet.
    pub fn new() -> Preview {
        Preview::default()
    }

    /// Draws a frame. Returns false if it was cancelled: parts of the picture may then be those of the frame before, or
    /// black if the size has changed.
    ///
    /// Errors: a fault of the program.
    pub fn frame(&mut self, prepared: &Prepared, options: &PreviewOptions<'_>) -> Result<bool, SceneError> {
        let [width, height] = options.size.map(|side| side.clamp(1, MOST_SIDE));
        let threads = match options.threads {
            0 => turner_host::thread::available(),
            n => n,
        };
        self.workers.resize_with(threads, Worker::default);
        if (self.picture.width, self.picture.height) != (width, height) {
            self.picture = PreviewPicture::default();
            self.picture.resize(width, height);
        }
        let view = view_of(prepared, width, height);
        if prepared.path().is_some() {
            return self.drawing.frame(prepared, view, options, &mut self.workers, &mut self.picture);
        }
        self.drawing.forget();
        self.draw_centres(prepared, &view, options)
    }

    /// The picture of the last frame that was not cancelled.
    pub fn picture(&self) -> &PreviewPicture {
        &self.picture
    }

    fn draw_centres(
        &mut self,
        prepared: &Prepared,
        view: &View,
        options: &PreviewOptions<'_>,
    ) -> Result<bool, SceneError> {
        let next = &mut self.picture;
        let width = next.width as usize;
        let size = width * ROWS;
        let rows = next.color.chunks_mut(size).zip(next.alpha.chunks_mut(size));
        let rows = rows.zip(next.object.chunks_mut(size).zip(next.depth.chunks_mut(size)));
        let tasks = rows.enumerate().map(|(i, ((color, alpha), (object, depth)))| CentreRows {
            first: (i * ROWS) as u32,
            color,
            alpha,
            object,
            depth,
        });
        let tasks = tasks.collect();
        work::run(&mut self.workers, options.cancel, tasks, |worker: &mut Worker, rows| {
            worker.centre.draw(prepared, view, options.effort, rows);
        })
    }
}

/// The view at the size of the preview, through the centre of the lens.
fn view_of(prepared: &Prepared, width: u32, height: u32) -> View {
    let mut view = prepared.view.clone();
    (view.film.width, view.film.height) = (width, height);
    view.film.crop = None;
    if view.pixel_cone.is_some() {
        view.pixel_cone = Some(PixelCone::new(&view.camera, &view.film));
    }
    (view.labels, view.moves) = (true, false);
    view
}
