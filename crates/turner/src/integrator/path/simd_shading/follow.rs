//! The rays that leave the vertices of a block.

use super::{Shading, VertexBlock, get32};
use crate::bsdf::Lobe;
use crate::integrator::path::caustics::NextVertex;
use crate::integrator::path::lobe_split::Share;
use crate::integrator::path::path_batch::PathBatch;
use crate::integrator::path::record::Record;
use crate::integrator::path::shared_paths::{SecondLight, SecondNext};
use crate::integrator::{RayStats, footprint};
use crate::math::Ray;
use crate::math::block::vector;

impl<R: Record> PathBatch<'_, R> {
    /// Traces the shadow ray of a lane.
    #[inline]
    pub(super) fn connect_lane<K>(&mut self, block: &VertexBlock<K>, shading: &Shading, lane: usize) {
        let sample = block.samples[lane];
        let indirect = self.paths[sample as usize].bounces.total > 0;
        let light = self.settings.clamped(get32(&shading.light, lane), indirect);
        let t_max = if shading.finite >> lane & 1 == 1 { 1.0 } else { f64::INFINITY };
        let ray =
            Ray { t_max, ..Ray::new(vector(&shading.shadow_origin, lane), vector(&shading.shadow, lane)) };
        if shading.second >> lane & 1 == 1
            && let Some(second) = self.shared_paths.directional_at(sample)
        {
            let wi = vector(&shading.local[0], lane);
            let pdf = shading.light_pdf.0[lane];
            second.set_light(SecondLight {
                wi,
                radiance: get32(&shading.radiance, lane),
                k: wi.z.abs() / pdf,
                softening: shading.softening[0].0[lane],
                pdf,
                weighed: shading.weighed >> lane & 1 == 1,
                ray: self.shadows.light.len(),
            });
        }
        self.groups.push_shadow_ray(shading.groups[lane]);
        // Other BSDFs are not in blocks while lobes are told apart.
        self.lobes.push_shadow_ray(sample, || Share::lobe(true));
        self.shadows.push(&ray, [block.from[lane], shading.targets[lane]], sample, light);
    }

    /// Continues the path of a lane, unless Russian roulette ends it.
    #[inline]
    pub(super) fn follow_lane<K>(
        &mut self,
        block: &VertexBlock<K>,
        shading: &Shading,
        lane: usize,
        stats: &mut RayStats,
    ) {
        let sample = block.samples[lane];
        let path = &mut self.paths[sample as usize];
        let is = |mask: u8| mask >> lane & 1 == 1;
        let (is_delta, is_diffuse) = (is(shading.delta), is(shading.diffuse));
        let lobe = Lobe { is_delta, is_transmission: false, is_diffuse };
        let Some(bounces) = self.settings.count(&path.bounces, &lobe) else { return };
        if self.strategy.is_some() {
            let (p, ng) = (block.surfaces.point(lane), block.surfaces.normal(lane));
            let first = path.bounces.total == 0;
            let (wi, pdf) = (vector(&shading.next, lane), shading.pdf.0[lane]);
            let to = NextVertex { p, ng, wi, pdf, is_delta: false, is_specular: false, from_camera: first };
            self.update_reverse_pdf_lambert(sample, &to, -block.surfaces.direction(lane));
        }
        let path = &mut self.paths[sample as usize];
        self.lobes.leaves(sample, || Share::lobe(is_diffuse));
        path.beta = get32(&shading.beta_next, lane);
        let is_second = is(shading.second);
        if is_second
            && is_delta
            && let Some(second) = self.shared_paths.directional_at(sample)
        {
            second.take_back(path);
            path.beta = path.beta * get32(&shading.f_next, lane) * shading.k_next.0[lane];
        }
        path.bounces = bounces;
        path.from_camera = false;
        path.seen_through = false;
        path.specular_bounce = is_delta;
        path.any_nonspecular |= !is_delta;
        path.pdf = shading.pdf.0[lane];
        if let Some(receiver) = block.receivers[lane] {
            path.origin = receiver;
        }
        if let Some(pixel) = &self.view.pixel_cone {
            let is_outside = block.surfaces.direction(lane).dot(block.surfaces.normal(lane)) <= 0.0;
            let curvature = if is_outside { block.curvature.0[lane] } else { -block.curvature.0[lane] };
            path.cone = footprint::leave_reflected(pixel, path.cone, curvature, path.pdf, is_delta);
        }
        stats.reflected += 1;
        path.begin_roulette();
        let mut survived = 1.0;
        if let Some(survival) = self.settings.survival(path) {
            let [.., u] = path.numbers.second();
            let survives = u < f64::from(survival);
            if !survives {
                return;
            }
            path.beta *= 1.0 / survival;
            survived = survival;
        }
        if path.beta.is_black() {
            return;
        }
        if is_second
            && !is_delta
            && let Some(second) = self.shared_paths.directional_at(sample)
        {
            let wi = vector(&shading.local[1], lane);
            let softening = shading.softening[1].0[lane];
            second.set_next(SecondNext { wi, k: wi.z.abs(), softening, survival: survived });
        }
        let ray = Ray::new(vector(&shading.origin, lane), vector(&shading.next, lane));
        self.next.push_ray(sample, &ray, block.from[lane]);
    }
}
