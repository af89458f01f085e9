//! From accumulated light to the picture: filters, and the estimate of what is not traced.

use std::sync::atomic::Ordering;

use turner_bvh::InstructionSet;

use crate::preview::buffers::{Guides, Light, LightPart};
use crate::preview::compose::{Composed, compose};
use crate::preview::draw::{Drawing, grid_size};
use crate::preview::filter::Pass;
use crate::preview::picture::PreviewPicture;
use crate::preview::{PreviewOptions, ROWS, Worker, work};
use crate::schema::SceneError;

/// Distances between the taps of the passes.
struct Steps {
    direct: &'static [usize],
    gloss: &'static [usize],
    indirect: &'static [usize],
}

impl Steps {
    /// For means over this many frames.
    fn of(frames: u32) -> Steps {
        let (direct, gloss, indirect): (&[usize], &[usize], &[usize]) = match frames {
            0..=2 => (&[1, 2, 4], &[1, 2, 4], &[1, 2, 4, 8]),
            3..=7 => (&[1, 2, 4], &[1, 2], &[1, 2, 4, 8]),
            8..=15 => (&[1, 2], &[1, 2], &[1, 2, 4]),
            16..=63 => (&[1, 2], &[1], &[1, 2, 4]),
            _ => (&[1], &[1], &[1, 2]),
        };
        Steps { direct, gloss, indirect }
    }
}

/// What all passes have in common.
struct Passes<'a, 'b> {
    options: &'a PreviewOptions<'b>,
    set: InstructionSet,
    workers: &'a mut [Worker],
}

impl Passes<'_, '_> {
    /// Filters light; the result is in one of `to`, or still in `from` without passes.
    fn run<'l>(
        &mut self,
        guides: &Guides,
        [width, height]: [usize; 2],
        steps: &[usize],
        by_roughness: bool,
        from: &'l Light,
        to: &'l mut [Light; 2],
    ) -> Result<&'l Light, SceneError> {
        for light in to.iter_mut() {
            light.set_len(width * height);
        }
        for (i, &step) in steps.iter().enumerate() {
            let [first, second] = &mut *to;
            let (source, target) = match i {
                0 => (from, first),
                i if i % 2 == 1 => (&*first, second),
                _ => (&*second, first),
            };
            let pass = Pass { width, height, guides, from: source, step, by_roughness };
            let tasks = target.parts(width * ROWS).enumerate().collect();
            let set = self.set;
            let rows = |worker: &mut Worker, (i, mut to): (usize, LightPart<'_>)| {
                pass.rows(set, i * ROWS, &mut to, &mut worker.row);
            };
            work::run(self.workers, self.options.cancel, tasks, rows)?;
        }
        Ok(match steps.len() {
            0 => from,
            n => &to[(n + 1) % 2],
        })
    }
}

impl Drawing {
    /// Filters and shows what is accumulated. Returns false if cancelled.
    pub(super) fn show(
        &mut self,
        options: &PreviewOptions<'_>,
        workers: &mut [Worker],
        picture: &mut PreviewPicture,
    ) -> Result<bool, SceneError> {
        let (width, height) = (picture.width as usize, picture.height as usize);
        let ambient = self.prepare_grid(width, height);
        self.ambient = Some(ambient.into());
        let Some(drawn) = &self.drawn else { return Ok(false) };
        let steps = Steps::of(self.frames);
        let layers = &self.layers;
        let [direct, gloss, indirect] = &mut self.shown;
        let set = drawn.scene.instruction_set;
        let mut passes = Passes { options, set, workers };
        let size = [width, height];
        let direct = passes.run(&layers.guides, size, steps.direct, false, &layers.direct, direct)?;
        let gloss = match self.has_gloss.contains(&true) {
            true => Some(passes.run(&layers.guides, size, steps.gloss, true, &layers.gloss, gloss)?),
            false => None,
        };
        let grid = grid_size(width, height);
        let indirect = passes.run(&self.grid, grid, steps.indirect, false, &self.gathered, indirect)?;
        if options.cancel.load(Ordering::Relaxed) {
            return Ok(false);
        }
        let composed = Composed {
            size,
            guides: &layers.guides,
            grid: &self.grid,
            still: &self.still,
            direct,
            unfiltered: &layers.direct,
            gloss,
            indirect,
            ambient,
        };
        let rows = width * ROWS;
        let tasks = picture.color.chunks_mut(rows).zip(picture.alpha.chunks_mut(rows)).enumerate().collect();
        // Too short to be worth a cancel.
        let never = std::sync::atomic::AtomicBool::new(false);
        work::run(passes.workers, &never, tasks, |_: &mut Worker, (i, (color, alpha))| {
            compose(&composed, i * ROWS, color, alpha);
        })
    }

    /// Adds the estimate of light that is reflected more than twice to the grid, and returns its mean.
    fn prepare_grid(&mut self, width: usize, height: usize) -> [f32; 3] {
        let [grid_width, grid_height] = grid_size(width, height);
        for y in 0..grid_height {
            for x in 0..grid_width {
                let (to, from) = (y * grid_width + x, 2 * y * width + 2 * x);
                for (to_plane, plane) in self.grid.normal.iter_mut().zip(&self.layers.guides.normal) {
                    to_plane[to] = plane[from];
                }
                self.grid.near[to] = self.layers.guides.near[from];
                self.grid.key[to] = self.layers.guides.key[from];
            }
        }
        self.gathered.count.clone_from(&self.layers.indirect.count);
        let mut ambient = [0.0; 3];
        for (channel, ambient) in ambient.iter_mut().enumerate() {
            let (mut light, mut albedo, mut count) = (0.0, 0.0, 0.0);
            let planes = self.layers.indirect.rgb[channel].iter().zip(&self.layers.second.rgb[channel]);
            for ((l, a), n) in planes.zip(&self.layers.indirect.count) {
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
            let planes = self.layers.indirect.rgb[channel].iter().zip(&self.layers.second.rgb[channel]);
            to.extend(planes.map(|(light, albedo)| light + albedo * *ambient));
        }
        ambient
    }
}
