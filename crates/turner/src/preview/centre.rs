//! Pictures of one sample through the centre of each pixel, by an integrator's own tracer: for the integrators that have no
//! noise to filter, and for those of other crates.
//!
//! While the view moves, pixels between four like ones are filled instead:
//!
//! ```text
//!   traced     then the middles     then the others
//!   # . # .       # . # .              # c # c
//!   . . . .       . b . b              c b c b
//!   # . # .       # . # .              # c # c
//! ```

use turner_bvh::lanes::LANES;

use crate::color::Spectrum;
use crate::integrator::{AskedDetails, CameraSamples, Prepared, Radiance, RayStats, Tracer};
use crate::math::DVec2;
use crate::preview::Effort;
use crate::preview::picture::NO_OBJECT;
use crate::sampler::SampleId;
use crate::scene::Hit;
use crate::view::{View, take_points};

/// Buffers of one thread.
#[derive(Default)]
pub(super) struct Centre {
    samples: CameraSamples,
    out: Vec<Radiance>,
    hits: Vec<Option<Hit>>,
    /// Columns and rows to trace, within the part.
    pixels: Vec<[usize; 2]>,
}

/// Rows of a picture.
pub(super) struct CentreRows<'a> {
    pub(super) first: u32,
    pub(super) color: &'a mut [[f32; 3]],
    pub(super) alpha: &'a mut [f32],
    pub(super) object: &'a mut [u32],
    pub(super) depth: &'a mut [f32],
}

/// Side of the squares in which pixels are traced, so that neighbours follow one another.
const SQUARE: usize = 64;

/// The largest difference of colours between which a pixel is filled: relative, and absolute.
const COLOR: [f32; 2] = [0.02, 0.003];

/// Part of a picture: rows of `width` pixels.
struct Part {
    width: usize,
    left: usize,
    columns: usize,
    rows: usize,
}

impl Centre {
    /// Draws rows; `view` is that of the preview.
    pub(super) fn draw(
        &mut self,
        prepared: &Prepared,
        view: &View,
        effort: Effort,
        mut rows: CentreRows<'_>,
    ) {
        let mut tracer = prepared.integrator.tracer(&prepared.scene, view);
        tracer.ask(AskedDetails { hits: true, ..AskedDetails::default() });
        let width = view.film.width as usize;
        let height = rows.color.len() / width.max(1);
        for left in (0..width).step_by(SQUARE) {
            let part = Part { width, left, columns: SQUARE.min(width - left), rows: height };
            if effort == Effort::Still {
                self.pixels.clear();
                self.pixels.extend((0..height).flat_map(|y| (0..part.columns).map(move |x| [x, y])));
                self.trace(&mut *tracer, prepared, view, &part, &mut rows);
                continue;
            }
            for stage in 0..3 {
                self.pixels.clear();
                for y in 0..height {
                    let [first, step] = columns_of(stage, y);
                    for x in (first..part.columns).step_by(step) {
                        if stage == 0 || !rows.fill(&part, stage, [x, y]) {
                            self.pixels.push([x, y]);
                        }
                    }
                }
                self.trace(&mut *tracer, prepared, view, &part, &mut rows);
            }
        }
    }

    /// Traces `pixels` of a part.
    fn trace(
        &mut self,
        tracer: &mut dyn Tracer,
        prepared: &Prepared,
        view: &View,
        part: &Part,
        rows: &mut CentreRows<'_>,
    ) {
        let scene = &*prepared.scene;
        self.samples.clear();
        let seed = u64::from(view.film.seed);
        let points = self.pixels.iter().map(|&[x, y]| {
            let (x, y) = ((part.left + x) as u32, rows.first + y as u32);
            let id = SampleId { x, y, index: 0, seed };
            (id, DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5))
        });
        take_points(view, &mut self.samples, points);
        tracer.radiance(&self.samples, &mut self.out, &mut RayStats::default());
        let mut hits = tracer.details().hits;
        if hits.len() != self.out.len() {
            scene.intersect_batch(&mut self.samples.rays, &mut self.hits);
            scene.look_past_hidden(&self.samples.rays, &mut self.hits);
            hits = &self.hits;
        }
        for ((i, radiance), hit) in self.out.iter().enumerate().zip(hits) {
            let [x, y] = self.pixels[i];
            let at = y * part.width + part.left + x;
            // Where the camera has no ray, nothing is seen.
            let is_seen = self.samples.rays.blocks()[i / LANES].t_max.0[i % LANES] >= 0.0;
            let mut radiance =
                if is_seen { *radiance } else { Radiance { color: Spectrum::BLACK, alpha: 0.0 } };
            radiance.color *= self.samples.weight(i);
            (rows.color[at], rows.alpha[at]) = (radiance.color.to_array(), radiance.alpha);
            let hit = hit.as_ref().filter(|_| is_seen);
            rows.object[at] = hit.map_or(NO_OBJECT, |hit| scene.primitive_id(hit));
            rows.depth[at] = hit.map_or(f32::INFINITY, |hit| hit.shape.t as f32);
        }
    }
}

/// The first column of row `y` that is drawn in a stage, and the step to the next such column. Stage 0 traces every second
/// pixel of every second row; later stages fill pixels from the neighbours of earlier ones.
fn columns_of(stage: usize, y: usize) -> [usize; 2] {
    match (stage, y % 2) {
        (0, 0) => [0, 2],
        (1, 1) => [1, 2],
        (2, odd) => [1 - odd, 2],
        _ => [usize::MAX, 1],
    }
}

impl CentreRows<'_> {
    /// Fills a pixel from the four around it, whose turn was before. Returns false where one is missing or they are not
    /// alike.
    fn fill(&mut self, part: &Part, stage: usize, [x, y]: [usize; 2]) -> bool {
        let offsets = match stage {
            1 => [(0, 0), (2, 2), (2, 0), (0, 2)],
            _ => [(0, 1), (2, 1), (1, 0), (1, 2)],
        };
        let mut around = [0; 4];
        for (i, (dx, dy)) in around.iter_mut().zip(offsets) {
            let (x, y) = (x + dx, y + dy);
            if x < 1 || y < 1 || x > part.columns || y > part.rows {
                return false;
            }
            *i = (y - 1) * part.width + part.left + x - 1;
        }
        let [a, others @ ..] = around;
        let alike = |b: usize| {
            let near = |p: f32, q: f32| (p - q).abs() <= COLOR[0] * p.abs().max(q.abs()) + COLOR[1];
            let colors = self.color[a].into_iter().zip(self.color[b]);
            self.object[a] == self.object[b] && self.alpha[a] == self.alpha[b] && { colors }
                .all(|(p, q)| near(p, q))
        };
        if !others.into_iter().all(alike) {
            return false;
        }
        let at = y * part.width + part.left + x;
        let mean = |values: [f32; 4]| values.iter().sum::<f32>() / 4.0;
        self.color[at] = std::array::from_fn(|c| mean(around.map(|i| self.color[i][c])));
        self.depth[at] = mean(around.map(|i| self.depth[i]));
        (self.alpha[at], self.object[at]) = (self.alpha[a], self.object[a]);
        true
    }
}
