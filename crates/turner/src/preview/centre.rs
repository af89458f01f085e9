//! Pictures of one sample through the centre of each pixel, by an integrator's own tracer: for the integrators that have no
//! noise to filter, and for those of other crates.

use crate::color::Spectrum;
use crate::integrator::{CameraSamples, Prepared, Radiance, RayStats};
use crate::math::DVec2;
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

impl Centre {
    /// Draws rows; `view` is that of the preview.
    pub(super) fn draw(&mut self, prepared: &Prepared, view: &View, rows: CentreRows<'_>) {
        let scene = &*prepared.scene;
        let mut tracer = prepared.integrator.tracer(scene, view);
        let width = view.film.width as usize;
        let height = rows.color.len() / width.max(1);
        for left in (0..width).step_by(SQUARE) {
            let columns = SQUARE.min(width - left);
            let place = |i: usize| (left + i % columns, i / columns);
            self.samples.clear();
            let seed = u64::from(view.film.seed);
            let points = (0..columns * height).map(|i| {
                let (x, y) = place(i);
                let (x, y) = (x as u32, rows.first + y as u32);
                let id = SampleId { x, y, index: 0, seed };
                (id, DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5))
            });
            take_points(view, &mut self.samples, points);
            tracer.radiance(&self.samples, &mut self.out, &mut RayStats::default());
            scene.intersect_batch(&mut self.samples.rays, &mut self.hits);
            for (i, (radiance, hit)) in self.out.iter().zip(&self.hits).enumerate() {
                let (x, y) = place(i);
                let at = y * width + x;
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
}
