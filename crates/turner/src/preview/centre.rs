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

use crate::color::Spectrum;
use crate::integrator::{CameraSamples, Prepared, Radiance, RayStats, Tracer};
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
    pub(super) normal: &'a mut [[f32; 3]],
}

/// Side of the squares in which pixels are traced, so that neighbours follow one another.
const SQUARE: usize = 16;

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
        let width = view.film.width as usize;
        let height = rows.color.len() / width.max(1);
        for left in (0..width).step_by(SQUARE) {
            let part = Part { width, left, columns: SQUARE.min(width - left), rows: height };
            let all = (0..part.columns * height).map(|i| [i % part.columns, i / part.columns]);
            if effort == Effort::Still {
                self.pixels.clear();
                self.pixels.extend(all);
                self.trace(&mut *tracer, prepared, view, &part, &mut rows);
                continue;
            }
            for stage in 0..3 {
                self.pixels.clear();
                for [x, y] in all.clone().filter(|[x, y]| stage_of(*x, *y) == stage) {
                    if stage == 0 || !rows.fill(&part, [x, y]) {
                        self.pixels.push([x, y]);
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
        scene.intersect_batch(&mut self.samples.rays, &mut self.hits);
        for (i, (radiance, hit)) in self.out.iter().zip(&self.hits).enumerate() {
            let [x, y] = self.pixels[i];
            let at = y * part.width + part.left + x;
            let ray = self.samples.rays.get(i).filter(|ray| ray.t_max >= 0.0);
            let radiance =
                if ray.is_some() { *radiance } else { Radiance { color: Spectrum::BLACK, alpha: 0.0 } };
            (rows.color[at], rows.alpha[at]) = (radiance.color.to_array(), radiance.alpha);
            (rows.object[at], rows.depth[at], rows.normal[at]) = (NO_OBJECT, f32::INFINITY, [0.0; 3]);
            if let (Some(hit), Some(ray)) = (hit, ray) {
                let surface = scene.surface(&ray, hit);
                let side = if surface.ng.dot(ray.direction) > 0.0 { -1.0 } else { 1.0 };
                rows.object[at] = scene.primitive_id(hit);
                rows.depth[at] = hit.shape.t as f32;
                rows.normal[at] = (surface.ns * side).as_vec3().to_array();
            }
        }
    }
}

/// When a pixel's turn is: after those around it.
fn stage_of(x: usize, y: usize) -> usize {
    match (x % 2, y % 2) {
        (0, 0) => 0,
        (1, 1) => 1,
        _ => 2,
    }
}

impl CentreRows<'_> {
    /// Fills a pixel from the four around it, whose turn was before. Returns false where one is missing or they are not
    /// alike.
    fn fill(&mut self, part: &Part, [x, y]: [usize; 2]) -> bool {
        let offsets = match stage_of(x, y) {
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
        self.normal[at] = std::array::from_fn(|c| mean(around.map(|i| self.normal[i][c])));
        self.depth[at] = mean(around.map(|i| self.depth[i]));
        (self.alpha[at], self.object[at]) = (self.alpha[a], self.object[a]);
        true
    }
}
