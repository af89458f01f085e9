//! Light of surfaces that a path hits.

use super::path_batch::PathBatch;
use super::record::{End, Record};
use crate::integrator::Radiance;
use crate::material::OpenPbr;
use crate::scene::SurfaceInteraction;

impl<R: Record> PathBatch<'_, R> {
    /// Adds the colour of an unlit surface that was hit, where the path ends.
    pub(super) fn add_unlit(
        &mut self,
        sample: u32,
        material: &OpenPbr,
        surface: &SurfaceInteraction,
        pixel: &mut Radiance,
    ) {
        let (scene, path) = (self.scene, &self.paths[sample as usize]);
        let at = scene.texture_point(surface);
        let color = scene.textures.color(material.desc.base_color, &at)
            * scene.textures.color(material.desc.base_weight, &at);
        let added = self.settings.add(path, path.beta * color, pixel);
        self.groups.hit(scene, sample, path, surface.hit.primitive, added);
        self.record.note(|r| {
            r.hit_emitter(path, color, 0.0, 1.0, added);
            r.end = End::Unlit;
        });
    }

    /// Adds the emission of a surface that was hit.
    pub(super) fn add_emission(
        &mut self,
        sample: u32,
        material: &OpenPbr,
        surface: &SurfaceInteraction,
        pixel: &mut Radiance,
    ) {
        let (scene, path) = (self.scene, &self.paths[sample as usize]);
        let radiance = match material.constant_emission() {
            Some(radiance) => radiance,
            // Light sampling evaluates textures unfiltered. A hit that is weighted against it must do the same.
            None if path.specular_bounce => material.desc.emitted_color(scene, &scene.texture_point(surface)),
            None => material.desc.emitted_color(scene, &scene.texture_point(&surface.sharp())),
        };
        let pdf =
            if path.specular_bounce { 0.0 } else { scene.emitters.pdf_hit(scene, path.origin, surface) };
        let light_path_ratio = match self.strategy {
            Some(_)
                if self.counted_by_photons(sample, |caustic_targets, group| {
                    caustic_targets.density_on_shape(scene, group, surface)
                }) =>
            {
                return;
            }
            Some(_) => self.light_path_ratio_hit(sample, surface),
            None => 0.0,
        };
        let weight = self.settings.weight_found(path, pdf, light_path_ratio);
        let added = self.settings.add(path, path.beta * radiance * weight as f32, pixel);
        self.groups.hit(scene, sample, path, surface.hit.primitive, added);
        self.record.note(|r| r.hit_emitter(path, radiance, pdf, weight, added));
    }
}
