//! Shadow catchers: the camera sees nothing of them but the shadow on them.

use std::f64::consts::FRAC_1_PI;

use crate::bsdf::sample_cosine;
use crate::color::Spectrum;
use crate::light::Receiver;
use crate::math::{DVec3, Frame as LocalFrame, Ray};
use crate::preview::buffers::CATCHER;
use crate::preview::surfaces::weight_sampled;
use crate::preview::walk::{Frame, Sent, Target, Walk, Walker};
use crate::sampler::VertexNumbers;
use crate::scene::SurfaceInteraction;

impl Walk {
    /// A shadow catcher: the light there, with and without what is in the way; the ray passes.
    pub(super) fn catch(
        &mut self,
        frame: &Frame<'_>,
        walker: &Walker,
        ray: &Ray,
        surface: &SurfaceInteraction,
        numbers: &VertexNumbers,
    ) {
        let is_main = walker.is_main;
        self.pass(&Walker { is_main: false, ..*walker }, surface, ray);
        let (x, y) = self.place(walker.pixel);
        if !is_main {
            return;
        }
        let side = if surface.ng.dot(ray.direction) > 0.0 { -1.0 } else { 1.0 };
        let n = surface.ns * side;
        let pixel = &mut self.found[walker.pixel as usize];
        pixel.is_catcher = true;
        pixel.normal = n.as_vec3().to_array();
        pixel.near = (1.0 / (walker.length + surface.hit.shape.t).max(1e-30)) as f32;
        pixel.key = CATCHER;
        pixel.is_lit = frame.pattern.lights(x, y);
        if !pixel.is_lit {
            return;
        }
        let scene = frame.scene;
        let send = |walk: &mut Walk, to: DVec3, finite: bool, light: Spectrum| {
            if light.is_finite() && !light.is_black() {
                let sent =
                    Sent { pixel: walker.pixel, target: Target::Catcher, light, gloss: Spectrum::BLACK };
                walk.push_shadow(surface, to, finite, sent);
            }
        };
        let at = match scene.emitters.use_surface_sides() {
            true => Receiver::facing(surface.p, n),
            false => Receiver::from(surface.p),
        };
        let [u0, u1, u2, _] = numbers.first();
        if let Some(lit) = scene.emitters.sample(scene, at, [u0, u1, u2]) {
            let cos = lit.to_light.normalize().dot(n);
            let by_sky = if lit.finite { 0.0 } else { cos * FRAC_1_PI };
            let weight = weight_sampled(&lit, by_sky);
            if cos > 0.0 {
                send(
                    self,
                    lit.to_light,
                    lit.finite,
                    lit.radiance * (cos * weight * FRAC_1_PI / lit.pdf) as f32,
                );
            }
        }
        let [v0, v1, ..] = numbers.second();
        let local = sample_cosine([v0, v1]);
        let direction = LocalFrame::from_z(n).to_world(local);
        let pdf = local.z * FRAC_1_PI;
        let mut light = scene.ambient;
        for &id in scene.emitters.infinite_ids() {
            if let Some((radiance, other)) = scene.emitters.infinite_one(scene, id, direction) {
                light += radiance * (pdf * pdf / (pdf * pdf + other * other)) as f32;
            }
        }
        if !scene.emitters.has_infinite_lights() {
            light += scene.background.color(direction);
        }
        send(self, direction, false, light);
    }
}
