//! From accumulated light to the picture: filters, and the estimate of what is not traced.

use std::sync::atomic::Ordering;

use turner_bvh::InstructionSet;

use crate::math::DVec2;
use crate::preview::buffers::{Grid, Guides, Light, LightPart};
use crate::preview::compose::{Composed, Full};
use crate::preview::draw::Drawing;
use crate::preview::filter::Pass;
use crate::preview::picture::PreviewPicture;
use crate::preview::upsample::Upsampled;
use crate::preview::{PreviewOptions, ROWS, Worker, work};
use crate::schema::SceneError;

/// Distances between the taps of the passes.
struct Steps {
    direct: &'static [usize],
    gloss: &'static [usize],
    indirect: &'static [usize],
}

impl Steps {
    /// For means over this many frames; those of the first frame are all on the grid.
    fn of(frames: u32, grid: Grid) -> Steps {
        let (direct, gloss, indirect): (&[usize], &[usize], &[usize]) = match frames {
            0..=1 if grid.cell > 2 => (&[1, 2], &[1, 2], &[1, 2, 4]),
            0..=1 => (&[1, 2], &[1, 2], &[1, 2, 4, 8]),
            2 => (&[1, 2, 4], &[1, 2, 4], &[1, 2, 4, 8]),
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
    /// Pixels along a side of what is filtered.
    pixels: usize,
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
            let pass = Pass { width, height, guides, from: source, step, by_roughness, pixels: self.pixels };
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
        let ambient = self.estimate_further();
        self.ambient = Some(ambient.into());
        let Some(drawn) = &self.drawn else { return Ok(false) };
        let steps = Steps::of(self.frames, self.layers.grid);
        let layers = &self.layers;
        let [direct, gloss, indirect] = &mut self.shown;
        let set = drawn.scene.instruction_set;
        let mut passes = Passes { options, set, workers, pixels: 1 };
        let (size, grid) = ([width, height], layers.grid);
        let cells = [grid.columns, grid.rows];
        let on_grid = self.frames == 1;
        let (lit, size_of_light) = if on_grid { (&layers.heads, cells) } else { (&layers.guides, size) };
        passes.pixels = if on_grid { grid.cell } else { 1 };
        let direct = passes.run(lit, size_of_light, steps.direct, false, &layers.direct, direct)?;
        let gloss = match self.has_gloss.contains(&true) {
            true => Some(passes.run(lit, size_of_light, steps.gloss, true, &layers.gloss, gloss)?),
            false => None,
        };
        let indirect = passes.run(&layers.heads, cells, steps.indirect, false, &self.gathered, indirect)?;
        if options.cancel.load(Ordering::Relaxed) {
            return Ok(false);
        }
        let full = Full { direct, unfiltered: &layers.direct, gloss };
        let lights =
            if on_grid { [Some(direct), gloss, Some(indirect)] } else { [None, None, Some(indirect)] };
        let composed = Composed {
            set,
            grid: Upsampled { size, guides: &layers.guides, grid, heads: &layers.heads, lights },
            full: (!on_grid).then_some(full),
            still: &self.still,
            has_gloss: gloss.is_some(),
            ambient,
        };
        let rows = width * ROWS;
        let tasks = picture.color.chunks_mut(rows).zip(picture.alpha.chunks_mut(rows)).enumerate().collect();
        // Too short to be worth a cancel.
        let never = std::sync::atomic::AtomicBool::new(false);
        work::run(passes.workers, &never, tasks, |worker: &mut Worker, (i, (color, alpha))| {
            composed.rows(i * ROWS, color, alpha, &mut worker.upsample);
            if drawn.camera.has_weights() {
                for (k, color) in color.iter_mut().enumerate() {
                    let (x, y) = ((k % width) as f64, (i * ROWS + k / width) as f64);
                    let at = drawn.film.on_screen(DVec2::new(x + 0.5, y + 0.5));
                    let weight = drawn.camera.weight(at);
                    *color = color.map(|v| v * weight);
                }
            }
        })
    }

    /// Adds the estimate of light that is reflected more than twice to indirect light, and returns its mean.
    fn estimate_further(&mut self) -> [f32; 3] {
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
