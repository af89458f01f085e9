//! Frames of the integrators `path` and `direct`.

use std::sync::Arc;

use crate::camera::Camera;
use crate::color::Spectrum;
use crate::film::{Antialias, FilmDesc};
use crate::filter::Filter;
use crate::integrator::Prepared;
use crate::math::DVec2;
use crate::preview::buffers::{Guides, GuidesPart, Light, LightPart, Still};
use crate::preview::fill::between;
use crate::preview::looks::Looks;
use crate::preview::pattern::Pattern;
use crate::preview::picture::PreviewPicture;
use crate::preview::walk::{Frame, Walk};
use crate::preview::{Effort, PreviewOptions, ROWS, Worker, work};
use crate::sampler::{OwenSobol, SampleId};
use crate::scene::Scene;
use crate::schema::SceneError;
use crate::view::View;

/// Side of the groups of pixels that one call traces: a multiple of [`super::pattern::SQUARE`].
const GROUP: usize = 64;

/// The most frames that a mean covers while the camera moves, and while it stands still.
const MOST_STILL: f32 = 4096.0;

/// What a frame was drawn for.
pub(super) struct Drawn {
    pub(super) scene: Arc<Scene>,
    camera: Camera,
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
    pub(super) guides: Guides,
    pub(super) still: Vec<Still>,
    /// Frames in `still`, for each band of rows.
    counts: Vec<f32>,
    pub(super) direct: Light,
    pub(super) gloss: Light,
    /// On a grid of half the size.
    pub(super) indirect: Light,
    pub(super) second: Light,
    /// Their sum, with the light that is reflected more than twice.
    pub(super) gathered: Light,
    pub(super) grid: Guides,
    /// Filtered light: results of odd and even passes.
    pub(super) shown: [[Light; 2]; 3],
    /// Rows that have gloss.
    pub(super) has_gloss: Vec<bool>,
}

/// The rows of one task.
struct Band<'a> {
    index: usize,
    guides: GuidesPart<'a>,
    still: &'a mut [Still],
    count: &'a mut f32,
    direct: LightPart<'a>,
    gloss: LightPart<'a>,
    indirect: LightPart<'a>,
    second: LightPart<'a>,
    has_gloss: &'a mut bool,
    object: &'a mut [u32],
    depth: &'a mut [f32],
    normal: &'a mut [[f32; 3]],
}

/// The size of the grid of indirect light.
pub(super) fn grid_size(width: usize, height: usize) -> [usize; 2] {
    [width.div_ceil(2), height.div_ceil(2)]
}

impl Drawing {
    /// Forgets all frames.
    pub(super) fn forget(&mut self) {
        self.drawn = None;
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
        let view = self.begin(prepared, view, options.effort, is_direct);
        let frame = Frame {
            scene: &prepared.scene,
            view: &view,
            looks: &self.looks,
            pattern: Pattern { frame: options.frame, seed: u64::from(view.film.seed) },
            within: if self.frames == 0 { DVec2::splat(0.5) } else { within(&view, options.frame) },
            is_direct,
            fills: self.frames == 0,
            white: white(&view.film),
        };
        let (width, height) = (view.film.width as usize, view.film.height as usize);
        let [grid_width, _] = grid_size(width, height);
        let size = width * ROWS;
        let first_frame = self.frames == 0;
        let guides = self.guides.parts(size).zip(self.still.chunks_mut(size)).zip(self.counts.iter_mut());
        let full = self.direct.parts(size).zip(self.gloss.parts(size)).zip(self.has_gloss.iter_mut());
        let size_of_grid = grid_width * ROWS / 2;
        let grid = self.indirect.parts(size_of_grid).zip(self.second.parts(size_of_grid));
        let seen = picture.object.chunks_mut(size).zip(picture.depth.chunks_mut(size));
        let seen = seen.zip(picture.normal.chunks_mut(size));
        let tasks = guides.zip(full).zip(grid.zip(seen)).enumerate().map(
            |(index, ((guides, full), (grid, seen)))| {
                let ((guides, still), count) = guides;
                let ((direct, gloss), has_gloss) = full;
                let ((object, depth), normal) = seen;
                let (indirect, second) = grid;
                Band {
                    index,
                    guides,
                    still,
                    count,
                    direct,
                    gloss,
                    indirect,
                    second,
                    has_gloss,
                    object,
                    depth,
                    normal,
                }
            },
        );
        let tasks: Vec<Band<'_>> = tasks.collect();
        let done = work::run(workers, options.cancel, tasks, |worker, band| {
            trace_band(&frame, worker, band, first_frame, options);
        })?;
        if !done || options.cancel.load(std::sync::atomic::Ordering::Relaxed) {
            if first_frame {
                self.forget();
            }
            return Ok(false);
        }
        self.frames += 1;
        self.show(options, workers, picture)
    }

    /// Starts again if scene or view are others; returns the view of the frame.
    fn begin(&mut self, prepared: &Prepared, view: View, effort: Effort, is_direct: bool) -> View {
        let same = self.drawn.as_ref().is_some_and(|drawn| {
            Arc::ptr_eq(&drawn.scene, &prepared.scene)
                && drawn.camera == view.camera
                && drawn.film == view.film
                && drawn.is_direct == is_direct
        });
        let continues = same && effort == Effort::Still;
        if !continues {
            let count = view.film.width as usize * view.film.height as usize;
            let [grid_width, grid_height] = grid_size(view.film.width as usize, view.film.height as usize);
            self.guides.set_len(count);
            (self.direct.begin(count), self.gloss.begin(count));
            for light in [&mut self.indirect, &mut self.second] {
                light.begin(grid_width * grid_height);
            }
            self.grid.set_len(grid_width * grid_height);
            self.still.resize(count, Still::default());
            let bands = (view.film.height as usize).div_ceil(ROWS);
            self.counts = vec![0.0; bands];
            self.has_gloss = vec![false; bands];
            self.frames = 0;
        }
        if !self.drawn.as_ref().is_some_and(|drawn| Arc::ptr_eq(&drawn.scene, &prepared.scene)) {
            self.looks = Looks::of(&prepared.scene);
        }
        let (scene, camera, film) = (prepared.scene.clone(), view.camera.clone(), view.film.clone());
        self.drawn = Some(Drawn { scene, camera, film, is_direct });
        View { labels: self.frames == 0, ..view }
    }
}

/// The luminance that is shown as white, or more.
fn white(film: &FilmDesc) -> f32 {
    if film.auto_exposure { f32::INFINITY } else { crate::math::elementary::pow(2.0, -film.exposure) as f32 }
}

/// Light of at most this luminance: rare bright samples would be spots.
fn capped(light: Spectrum, most: f32) -> Spectrum {
    let luminance = light.luminance();
    if luminance > most { light * (most / luminance) } else { light }
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

/// Traces the pixels of a band.
fn trace_band(
    frame: &Frame<'_>,
    worker: &mut Worker,
    band: Band<'_>,
    first_frame: bool,
    options: &PreviewOptions<'_>,
) {
    let Band { index, mut guides, still, count, mut direct, mut gloss, mut indirect, mut second, .. } = band;
    let width = frame.view.film.width as usize;
    let rows = still.len() / width;
    let [grid_width, _] = grid_size(width, 0);
    *count = (*count + 1.0).min(MOST_STILL);
    let mut filled = Vec::new();
    for left in (0..width).step_by(GROUP) {
        if options.cancel.load(std::sync::atomic::Ordering::Relaxed) {
            return;
        }
        let columns = GROUP.min(width - left);
        let walk = &mut worker.walk;
        walk.group.clear();
        walk.group.resize(columns * rows, None);
        // Squares of 4 x 4 pixels are coherent packets.
        let all = (0..rows).step_by(4).flat_map(move |top| {
            (0..columns).step_by(4).flat_map(move |x| {
                (top..rows.min(top + 4)).flat_map(move |y| (x..columns.min(x + 4)).map(move |x| (x, y)))
            })
        });
        let place = |x: usize, y: usize| ((left + x) as u32, (index * ROWS + y) as u32);
        let trace = |walk: &mut Walk| {
            walk.trace(frame);
            for (&(x, y), sample) in walk.pixels.iter().zip(&walk.found) {
                walk.group[(y as usize - index * ROWS) * columns + x as usize - left] = Some(*sample);
            }
        };
        walk.pixels.clear();
        walk.pixels.extend(
            all.clone()
                .map(|(x, y)| place(x, y))
                .filter(|&(x, y)| !frame.fills || frame.pattern.lights(x, y) || frame.pattern.gathers(x, y)),
        );
        trace(walk);
        if frame.fills {
            walk.pixels.clear();
            for (x, y) in all {
                let at = y * columns + x;
                if walk.group[at].is_some() {
                    continue;
                }
                let of = |inside: bool, at: usize| if inside { walk.group.get(at)?.as_ref() } else { None };
                let neighbours = [
                    of(x > 0, at.wrapping_sub(1)),
                    of(x + 1 < columns, at + 1),
                    of(y > 0, at.wrapping_sub(columns)),
                    of(y + 1 < rows, at + columns),
                ];
                match between(neighbours) {
                    Some(sample) => filled.push((at, sample)),
                    None => walk.pixels.push(place(x, y)),
                }
            }
            trace(walk);
            for (at, sample) in filled.drain(..) {
                walk.group[at] = Some(sample);
            }
        }
        for (at, sample) in walk.group.iter().enumerate() {
            let Some(sample) = sample else { continue };
            let (column, row) = (at % columns, at / columns);
            let (x, y) = place(column, row);
            let i = row * width + left + column;
            if first_frame {
                guides.set(i, sample);
                (band.object[i], band.depth[i], band.normal[i]) =
                    (sample.object, sample.depth, sample.first_normal);
            }
            still[i].add(&Still::of(sample), *count);
            if sample.is_lit {
                direct.add(i, sample.direct, MOST_STILL);
                gloss.add(i, capped(sample.gloss, 6.0 * frame.white), MOST_STILL);
                *band.has_gloss |= !sample.gloss.is_black();
            }
            if frame.pattern.gathers(x, y) && !sample.albedo.is_black() {
                let i = row / 2 * grid_width + (left + column) / 2;
                indirect.add(i, capped(sample.indirect, 4.0 * frame.white), MOST_STILL);
                second.add(i, sample.second, MOST_STILL);
            }
        }
    }
}
