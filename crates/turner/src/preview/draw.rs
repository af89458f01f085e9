//! Frames of the integrators `path` and `direct`.

use std::sync::Arc;

use crate::camera::Camera;
use crate::color::Spectrum;
use crate::film::{Antialias, FilmDesc};
use crate::filter::Filter;
use crate::integrator::Prepared;
use crate::math::DVec2;
use crate::preview::band::{Band, estimate_ambient, trace_band};
use crate::preview::buffers::{Grid, Layers, Light, Still};
use crate::preview::history::Past;
use crate::preview::looks::Looks;
use crate::preview::pattern::Pattern;
use crate::preview::picture::PreviewPicture;
use crate::preview::walk::Frame;
use crate::preview::{Effort, PreviewOptions, ROWS, Worker, work};
use crate::sampler::{OwenSobol, SampleId};
use crate::scene::Scene;
use crate::schema::SceneError;
use crate::view::View;

/// What a frame was drawn for.
pub(super) struct Drawn {
    pub(super) scene: Arc<Scene>,
    pub(super) camera: Camera,
    pub(super) film: FilmDesc,
    is_direct: bool,
}

/// The accumulated values of all pixels.
#[derive(Default)]
pub(super) struct Drawing {
    pub(super) drawn: Option<Drawn>,
    looks: Looks,
    /// Frames in the means.
    pub(super) frames: u32,
    pub(super) layers: Layers,
    /// The layers of the frame before, if the camera may have moved since.
    past: Layers,
    /// Whether the layers are only history, because the frame after them was cancelled.
    is_history: bool,
    pub(super) still: Vec<Still>,
    /// Frames in `still`, for each band of rows.
    counts: Vec<f32>,
    /// Indirect light, with the light that is reflected more than twice.
    pub(super) gathered: Light,
    /// Filtered light: results of odd and even passes.
    pub(super) shown: [[Light; 2]; 3],
    /// Light that arrives at a surface from others, over π, as the mean of the last frame of this scene.
    pub(super) ambient: Option<Spectrum>,
    /// Rows that have gloss.
    pub(super) has_gloss: Vec<bool>,
}

impl Drawing {
    /// Forgets all frames.
    pub(super) fn forget(&mut self) {
        (self.drawn, self.ambient) = (None, None);
    }

    /// Draws a frame.
    pub(super) fn frame(
        &mut self,
        prepared: &Prepared,
        view: View,
        options: &PreviewOptions<'_>,
        workers: &mut [Worker],
        picture: &mut PreviewPicture,
    ) -> Result<bool, SceneError> {
        let is_direct = prepared.integrator.name() == crate::integrator::DirectDesc::DOC.name;
        let (view, past) = self.begin(prepared, view, options.effort, is_direct);
        let before = past.as_ref().map(|(camera, film)| Past {
            camera,
            film,
            is_moved: *camera != view.camera,
            layers: &self.past,
        });
        let frame = Frame {
            scene: &prepared.scene,
            view: &view,
            looks: &self.looks,
            pattern: Pattern {
                frame: options.frame,
                seed: u64::from(view.film.seed),
                is_first: self.frames == 0,
                cell: self.layers.grid.cell as u32,
            },
            within: if self.frames == 0 { DVec2::splat(0.5) } else { within(&view, options.frame) },
            is_direct,
            ambient: self.ambient.unwrap_or(Spectrum::BLACK),
            white: white(&view.film),
        };
        let mut frame = frame;
        if self.ambient.is_none()
            && !is_direct
            && let [worker, ..] = &mut *workers
        {
            frame.ambient = estimate_ambient(&frame, &mut worker.walk);
        }
        let frame = frame;
        let width = view.film.width as usize;
        let size = width * ROWS;
        let first_frame = self.frames == 0;
        let layers = &mut self.layers;
        if self.frames == 1 && layers.is_on_grid() {
            layers.spread(width);
        }
        let cells = layers.grid;
        let size_of_grid = cells.columns * ROWS / cells.cell;
        let size_of_light = if layers.is_on_grid() { size_of_grid } else { size };
        let guides = layers.guides.parts(size).zip(layers.heads.parts(size_of_grid));
        let guides = guides.zip(self.still.chunks_mut(size)).zip(self.counts.iter_mut());
        let full = layers.direct.parts(size_of_light).zip(layers.gloss.parts(size_of_light));
        let full = full.zip(self.has_gloss.iter_mut());
        let grid = layers.indirect.parts(size_of_grid).zip(layers.second.parts(size_of_grid));
        let seen = picture.object.chunks_mut(size).zip(picture.depth.chunks_mut(size));
        let tasks = guides.zip(full).zip(grid.zip(seen)).enumerate().map(
            |(index, ((guides, full), (grid, seen)))| {
                let (((guides, heads), still), count) = guides;
                let ((direct, gloss), has_gloss) = full;
                let (object, depth) = seen;
                let (indirect, second) = grid;
                Band {
                    index,
                    guides,
                    grid: cells,
                    heads,
                    still,
                    count,
                    direct,
                    gloss,
                    indirect,
                    second,
                    has_gloss,
                    object,
                    depth,
                }
            },
        );
        let tasks: Vec<Band<'_>> = tasks.collect();
        let done = work::run(workers, options.cancel, tasks, |worker, band| {
            trace_band(&frame, worker, band, before.as_ref(), options);
        })?;
        if !done || options.cancel.load(std::sync::atomic::Ordering::Relaxed) {
            if first_frame {
                // Only the frame before is left, as history.
                self.drawn = past.map(|(camera, film)| Drawn {
                    scene: prepared.scene.clone(),
                    camera,
                    film,
                    is_direct,
                });
                std::mem::swap(&mut self.layers, &mut self.past);
                (self.frames, self.is_history) = (1, true);
            }
            return Ok(false);
        }
        self.frames += 1;
        self.show(options, workers, picture)
    }

    /// Starts again if scene or view are others; returns the view of the frame, and that of the frame before if its light may
    /// be used.
    fn begin(
        &mut self,
        prepared: &Prepared,
        view: View,
        effort: Effort,
        is_direct: bool,
    ) -> (View, Option<(Camera, FilmDesc)>) {
        let same = self.drawn.as_ref().is_some_and(|drawn| {
            Arc::ptr_eq(&drawn.scene, &prepared.scene)
                && drawn.camera == view.camera
                && drawn.film == view.film
                && drawn.is_direct == is_direct
        });
        let is_fine = self.layers.grid.cell == Effort::Still.cell();
        let continues = same && effort == Effort::Still && is_fine && !self.is_history;
        let same_scene = self.drawn.as_ref().is_some_and(|drawn| Arc::ptr_eq(&drawn.scene, &prepared.scene));
        let mut past = None;
        if !continues {
            let size = [view.film.width as usize, view.film.height as usize];
            if let Some(drawn) = self.drawn.take().filter(|drawn| {
                let same_size = [drawn.film.width, drawn.film.height] == [view.film.width, view.film.height];
                same_scene && same_size && self.frames > 0 && drawn.is_direct == is_direct
            }) {
                std::mem::swap(&mut self.layers, &mut self.past);
                self.past.gather(size[0]);
                past = Some((drawn.camera, drawn.film));
            }
            self.layers.begin(size, Grid::new(size, effort.cell()));
            self.still.resize(size[0] * size[1], Still::default());
            let bands = size[1].div_ceil(ROWS);
            self.counts = vec![0.0; bands];
            self.has_gloss = vec![false; bands];
            (self.frames, self.is_history) = (0, false);
        }
        if !same_scene {
            self.looks = Looks::of(&prepared.scene);
            self.ambient = None;
        }
        let (scene, camera, film) = (prepared.scene.clone(), view.camera.clone(), view.film.clone());
        self.drawn = Some(Drawn { scene, camera, film, is_direct });
        (View { labels: self.frames == 0, ..view }, past)
    }
}

/// The luminance that is shown as white, or more.
fn white(film: &FilmDesc) -> f32 {
    if film.auto_exposure { f32::INFINITY } else { crate::math::elementary::pow(2.0, -film.exposure) as f32 }
}

/// The position of samples within their pixels, the same for all pixels.
fn within(view: &View, frame: u32) -> DVec2 {
    let filter = match view.film.antialias {
        Antialias::MonteCarlo => view.film.filter(),
        _ => Filter::new(crate::filter::FilterKind::Box, None),
    };
    let id = SampleId { x: 0, y: 0, index: frame, seed: 0 };
    filter.place(OwenSobol::new(&id).two(0).into())
}
