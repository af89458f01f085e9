//! Frames of the integrators `path` and `direct`.

use std::sync::Arc;

use crate::film::{Antialias, FilmDesc};
use crate::camera::Camera;
use crate::filter::Filter;
use crate::integrator::Prepared;
use crate::math::DVec2;
use crate::preview::buffers::{Guides, GuidesPart, Light, LightPart, Still};
use crate::preview::compose::{Composed, compose};
use crate::preview::filter::Pass;
use crate::preview::looks::Looks;
use crate::preview::pattern::Pattern;
use crate::preview::picture::PreviewPicture;
use crate::preview::walk::Frame;
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
struct Drawn {
    scene: Arc<Scene>,
    camera: Camera,
    film: FilmDesc,
    is_direct: bool,
}

/// The accumulated values of all pixels.
#[derive(Default)]
pub(super) struct Drawing {
    drawn: Option<Drawn>,
    looks: Looks,
    /// Frames in the means.
    frames: u32,
    guides: Guides,
    still: Vec<Still>,
    /// Frames in `still`, for each band of rows.
    counts: Vec<f32>,
    direct: Light,
    gloss: Light,
    /// On a grid of half the size.
    indirect: Light,
    second: Light,
    /// Their sum, with the light that is reflected more than twice.
    gathered: Light,
    grid: Guides,
    scratch: [Light; 2],
    /// Rows that have gloss.
    has_gloss: Vec<bool>,
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
        };
        let (width, height) = (view.film.width as usize, view.film.height as usize);
        let [grid_width, grid_height] = grid_size(width, height);
        let size = width * ROWS;
        let first_frame = self.frames == 0;
        let guides = self.guides.parts(size).zip(self.still.chunks_mut(size)).zip(self.counts.iter_mut());
        let full = self.direct.parts(size).zip(self.gloss.parts(size)).zip(self.has_gloss.iter_mut());
        let size_of_grid = grid_width * ROWS / 2;
        let grid = self.indirect.parts(size_of_grid).zip(self.second.parts(size_of_grid));
        let seen = picture.object.chunks_mut(size).zip(picture.depth.chunks_mut(size));
        let seen = seen.zip(picture.normal.chunks_mut(size));
        let tasks = guides.zip(full).zip(grid.zip(seen)).enumerate().map(|(index, ((guides, full), (grid, seen)))| {
            let ((guides, still), count) = guides;
            let ((direct, gloss), has_gloss) = full;
            let ((object, depth), normal) = seen;
            let (indirect, second) = grid;
            Band { index, guides, still, count, direct, gloss, indirect, second, has_gloss, object, depth, normal }
        });
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
        self.show([width, height], [grid_width, grid_height], options, workers, picture)
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
            self.guides.resize(count);
            (self.direct.resize(count), self.gloss.resize(count));
            for light in [&mut self.indirect, &mut self.second] {
                light.resize(grid_width * grid_height);
            }
            self.grid.resize(grid_width * grid_height);
            self.still.clear();
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

    /// Filters and shows what is accumulated.
    fn show(
        &mut self,
        [width, height]: [usize; 2],
        [grid_width, grid_height]: [usize; 2],
        options: &PreviewOptions<'_>,
        workers: &mut [Worker],
        picture: &mut PreviewPicture,
    ) -> Result<bool, SceneError> {
        let ambient = self.prepare_grid([width, height], [grid_width, grid_height]);
        let set = self.drawn.as_ref().map_or_else(Default::default, |drawn| drawn.scene.instruction_set);
        let frames = self.frames;
        let [a, b] = &mut self.scratch;
        let mut filter = |guides: &Guides, from: &Light, size: [usize; 2], steps: &[usize], by_roughness: bool| {
            let [width, height] = size;
            let mut results: [Light; 2] = [std::mem::take(a), std::mem::take(b)];
            for light in &mut results {
                light.resize(width * height);
            }
            let mut done = true;
            for (i, &step) in steps.iter().enumerate() {
                let [first, second] = &mut results;
                let (source, to) = match i {
                    0 => (from, first),
                    i if i % 2 == 1 => (&*first, second),
                    _ => (&*second, first),
                };
                let pass = Pass { width, height, guides, from: source, step, by_roughness };
                let tasks = to.parts(width * ROWS).enumerate().collect();
                done &= work::run(workers, options.cancel, tasks, |worker: &mut Worker, (i, mut to): (usize, LightPart<'_>)| {
                    pass.rows(set, i * ROWS, &mut to, &mut worker.row);
                })?;
            }
            let [first, second] = results;
            let result = match steps.len() {
                0 => from.clone(),
                n if n % 2 == 1 => first.clone(),
                _ => second.clone(),
            };
            (*a, *b) = (first, second);
            Ok::<_, SceneError>((result, done))
        };
        let steps: &[usize] = match frames {
            0..=3 => &[1, 2, 4],
            4..=15 => &[1, 2],
            _ => &[1],
        };
        let (direct, done_direct) = filter(&self.guides, &self.direct, [width, height], steps, false)?;
        let gloss_steps: &[usize] = if frames < 8 { &[1, 2] } else { &[1] };
        let has_gloss = self.has_gloss.iter().any(|g| *g);
        let gloss_steps = if has_gloss { gloss_steps } else { &[] };
        let (gloss, done_gloss) = filter(&self.guides, &self.gloss, [width, height], gloss_steps, true)?;
        let grid_steps: &[usize] = match frames {
            0..=7 => &[1, 2, 4, 8],
            8..=31 => &[1, 2, 4],
            _ => &[1, 2],
        };
        let (indirect, done_indirect) =
            filter(&self.grid, &self.gathered, [grid_width, grid_height], grid_steps, false)?;
        if !(done_direct && done_gloss && done_indirect) {
            return Ok(false);
        }
        let composed = Composed {
            size: [width, height],
            guides: &self.guides,
            grid: &self.grid,
            still: &self.still,
            direct: &direct,
            gloss: &gloss,
            indirect: &indirect,
            ambient,
        };
        let size = width * ROWS;
        let tasks = picture.color.chunks_mut(size).zip(picture.alpha.chunks_mut(size)).enumerate().collect();
        work::run(workers, options.cancel, tasks, |_, (i, (color, alpha))| {
            compose(&composed, i * ROWS, color, alpha);
        })
    }

    /// Adds the estimate of light that is reflected more than twice to the grid, and returns its mean.
    fn prepare_grid(&mut self, [width, _]: [usize; 2], [grid_width, grid_height]: [usize; 2]) -> [f32; 3] {
        for y in 0..grid_height {
            for x in 0..grid_width {
                let (to, from) = (y * grid_width + x, 2 * y * width + 2 * x);
                for (to_plane, plane) in self.grid.normal.iter_mut().zip(&self.guides.normal) {
                    to_plane[to] = plane[from];
                }
                self.grid.near[to] = self.guides.near[from];
                self.grid.key[to] = self.guides.key[from];
            }
        }
        self.gathered.count.clone_from(&self.indirect.count);
        let mut ambient = [0.0; 3];
        for (channel, ambient) in ambient.iter_mut().enumerate() {
            let (mut light, mut albedo, mut count) = (0.0, 0.0, 0.0);
            let planes = self.indirect.rgb[channel].iter().zip(&self.second.rgb[channel]);
            for ((l, a), n) in planes.zip(&self.indirect.count) {
                if *n > 0.0 {
                    light += f64::from(*l);
                    albedo += f64::from(*a);
                    count += 1.0;
                }
            }
            if count > 0.0 {
                let (light, albedo): (f64, f64) = (light / count, (albedo / count).min(0.9));
                *ambient = (light / (1.0 - albedo)) as f32;
            }
            let to = &mut self.gathered.rgb[channel];
            to.clear();
            let planes = self.indirect.rgb[channel].iter().zip(&self.second.rgb[channel]);
            to.extend(planes.map(|(light, albedo)| light + albedo * *ambient));
        }
        ambient
    }
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
fn trace_band(frame: &Frame<'_>, worker: &mut Worker, band: Band<'_>, first_frame: bool, options: &PreviewOptions<'_>) {
    let Band { index, mut guides, still, count, mut direct, mut gloss, mut indirect, mut second, .. } = band;
    let width = frame.view.film.width as usize;
    let rows = still.len() / width;
    let [grid_width, _] = grid_size(width, 0);
    *count = (*count + 1.0).min(MOST_STILL);
    for left in (0..width).step_by(GROUP) {
        if options.cancel.load(std::sync::atomic::Ordering::Relaxed) {
            return;
        }
        let walk = &mut worker.walk;
        walk.pixels.clear();
        // Squares of 4 x 4 pixels are coherent packets.
        for top in (0..rows).step_by(4) {
            for x in (left..width.min(left + GROUP)).step_by(4) {
                for y in top..rows.min(top + 4) {
                    walk.pixels.extend((x..width.min(x + 4)).map(|x| (x as u32, (index * ROWS + y) as u32)));
                }
            }
        }
        walk.trace(frame);
        for (&(x, y), sample) in walk.pixels.iter().zip(&walk.found) {
            let row = y as usize - index * ROWS;
            let i = row * width + x as usize;
            if first_frame {
                guides.set(i, sample);
                (band.object[i], band.depth[i], band.normal[i]) = (sample.object, sample.depth, sample.first_normal);
            }
            still[i].add(&Still::of(sample), *count);
            if sample.is_lit {
                direct.add(i, sample.direct, MOST_STILL);
                gloss.add(i, sample.gloss, MOST_STILL);
                *band.has_gloss |= !sample.gloss.is_black();
            }
            if frame.pattern.gathers(x, y) && !sample.albedo.is_black() {
                let i = row / 2 * grid_width + x as usize / 2;
                indirect.add(i, sample.indirect, MOST_STILL);
                second.add(i, sample.second, MOST_STILL);
            }
        }
    }
}
