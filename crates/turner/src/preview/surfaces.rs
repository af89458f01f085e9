//! What rays find: surfaces with their light, and the environment.

use std::f64::consts::FRAC_1_PI;

use crate::bsdf::{Bsdf, BsdfSample, MOST_DELTAS, sample_cosine};
use crate::color::Spectrum;
use crate::material::vertex::{Vertex, coated, prepare};
use crate::material::{AlphaMode, Material, OpenPbr};
use crate::math::{DVec3, Ray};
use crate::preview::buffers::CATCHER;
use crate::preview::looks::{Lobes, absorption};
use crate::preview::walk::{Frame, MOST_ROUNDS, Role, Sent, Target, Walk, Walker};
use crate::sampler::VertexNumbers;
use crate::scene::light_sample::LightSample;
use crate::scene::{Hit, SurfaceInteraction};

/// Branches with less of the light are not followed.
const FAINT: f32 = 0.01;

impl Walker {
    fn target(&self) -> Target {
        match self.role {
            Role::Camera => Target::Seen,
            Role::Bounce => Target::Indirect,
            Role::Gloss => Target::Gloss,
        }
    }

    /// MIS weight of an emitter that a ray hits, for the density with which light sampling finds it.
    fn weight_found(&self, light_pdf: f64) -> f32 {
        if self.is_specular || light_pdf <= 0.0 {
            return 1.0;
        }
        let ratio = light_pdf / self.pdf;
        (1.0 / (1.0 + ratio * ratio)) as f32
    }
}

/// A light sample's density per solid angle, and the weight of light sampling against rays of density `pdf`.
pub(super) fn weight_sampled(lit: &LightSample, pdf: f64) -> f64 {
    if lit.is_delta {
        return 1.0;
    }
    let ratio = pdf / lit.pdf;
    1.0 / (1.0 + ratio * ratio)
}

impl Walk {
    /// A ray that leaves the scene.
    pub(super) fn escape(
        &mut self,
        frame: &Frame<'_>,
        walker: &Walker,
        ray: &Ray,
        lights: impl Iterator<Item = (usize, Spectrum, f64)>,
    ) {
        let scene = frame.scene;
        let pixel = &mut self.found[walker.pixel as usize];
        if walker.role == Role::Camera && walker.seen_through && scene.background.transparent {
            pixel.alpha -= (walker.beta.to_array().iter().sum::<f32>() / 3.0).clamp(0.0, 1.0);
            return;
        }
        let mut beta = walker.beta;
        if walker.absorption != [0.0; 3] {
            beta = Spectrum::BLACK;
        }
        if walker.role == Role::Camera && walker.seen_through && !scene.background.environment {
            pixel.seen += beta * scene.background.color(ray.direction);
            return;
        }
        let mut found = Spectrum::BLACK;
        for (_, radiance, light_pdf) in lights {
            found += radiance * walker.weight_found(light_pdf);
        }
        if !scene.emitters.has_infinite_lights() {
            found += scene.background.color(ray.direction);
        }
        if !walker.from_camera {
            found += scene.ambient;
        }
        self.add(walker, beta * found);
    }

    /// Adds light that a ray finds.
    fn add(&mut self, walker: &Walker, light: Spectrum) {
        let pixel = &mut self.found[walker.pixel as usize];
        match walker.role {
            Role::Camera => pixel.seen += light,
            Role::Bounce => pixel.indirect += light,
            Role::Gloss => pixel.gloss += light,
        }
    }

    /// Sends a ray straight on.
    pub(super) fn pass(&mut self, walker: &Walker, surface: &SurfaceInteraction, ray: &Ray) {
        if walker.rounds < MOST_ROUNDS {
            let length = walker.length + surface.hit.shape.t;
            self.next.push(Walker { rounds: walker.rounds + 1, length, ..*walker }, surface, ray.direction);
        }
    }

    /// A ray that hits a surface.
    pub(super) fn arrive(
        &mut self,
        frame: &Frame<'_>,
        walker: &Walker,
        ray: &Ray,
        surface: &SurfaceInteraction,
        lit: Option<LightSample>,
        numbers: &VertexNumbers,
    ) {
        let scene = frame.scene;
        let mut walker = *walker;
        let outside = ray.direction.dot(surface.ng) < 0.0;
        if walker.absorption != [0.0; 3] {
            let t = surface.hit.shape.t;
            let left = walker.absorption.map(|a| crate::math::elementary::exp(-f64::from(a) * t) as f32);
            walker.beta = walker.beta * Spectrum::from(left);
        }
        if walker.rounds == 0 {
            self.see(frame, &walker, surface, outside);
        }
        if walker.from_camera && scene.is_shadow_catcher(&surface.hit) {
            return self.catch(frame, &walker, ray, surface, numbers);
        }
        let met = match scene.material_at(&surface.hit) {
            Material::OpenPbr(m) if m.desc.alpha_mode != AlphaMode::Blend => Some(&**m),
            Material::OpenPbr(m) => {
                let opacity = f64::from(m.desc.coverage(scene, surface));
                (opacity >= 1.0 || numbers.first()[3] < opacity).then_some(&**m)
            }
            Material::Mix(m) => m.choose(scene, surface, outside, numbers.first()[3]),
            Material::Classic(_) | Material::Principled(..) => return,
        };
        let Some(material) = met.filter(|m| !m.boundary) else {
            return self.pass(&walker, surface, ray);
        };
        if material.desc.unlit {
            let at = scene.texture_point(surface);
            let d = &material.desc;
            let color = scene.textures.color(d.base_color, &at) * scene.textures.color(d.base_weight, &at);
            return self.add(&walker, walker.beta * color);
        }
        if material.is_emissive() && (outside || material.emits_backwards()) {
            self.emission(frame, &walker, surface, material);
        }
        let is_mix = matches!(scene.material_at(&surface.hit), Material::Mix(_));
        let made;
        let constant = if is_mix { None } else { frame.looks.get(surface.material.index(), outside) };
        let (bsdf, lobes) = match constant {
            Some(look) => look,
            None => {
                let bsdf = material.bsdf(scene, surface, 1.0, outside).without_walk();
                made = (bsdf, Lobes::of(&bsdf));
                &made
            }
        };
        let d = &material.desc;
        if walker.role == Role::Camera
            && walker.is_main
            && !lobes.has_delta
            && d.bump().is_none()
            && d.normal_map.is_none()
        {
            let (x, y) = self.place(walker.pixel);
            if !frame.pattern.lights(x, y) && !frame.pattern.gathers(x, y) {
                return self.guide(&walker, surface, lobes, outside);
            }
        }
        let with_coat: Option<Bsdf<'_>> = coated(scene, ray, material, surface, bsdf, outside);
        let vertex = prepare(scene, ray, material, surface, with_coat.as_ref().unwrap_or(bsdf), outside);
        let at = At { walker: &walker, vertex: &vertex, material, lobes, numbers, lit };
        let is_main = self.follow_deltas(frame, &at);
        if lobes.is_smooth() {
            match walker.role {
                Role::Camera if is_main => self.light_main(frame, &at),
                _ => self.light_other(frame, &at),
            }
        }
    }

    /// Notes a hit of a camera ray that is not lit in this frame, if its material needs no more than that: nothing is seen
    /// beside or behind it, and it is the same everywhere.
    pub(super) fn see_unlit(&mut self, frame: &Frame<'_>, pixel: u32, ray: &Ray, hit: &Hit) -> bool {
        let (x, y) = self.place(pixel);
        if frame.pattern.lights(x, y) || frame.pattern.gathers(x, y) {
            return false;
        }
        let scene = frame.scene;
        let Some(sides) = frame.looks.plain(scene.material_id_at(hit).index()) else { return false };
        if scene.is_shadow_catcher(hit) {
            return false;
        }
        let surface = scene.surface(ray, hit);
        let outside = ray.direction.dot(surface.ng) < 0.0;
        let (_, lobes) = &sides[usize::from(!outside)];
        let near = (1.0 / hit.shape.t.max(1e-30)) as f32;
        let normal = (surface.ns * if outside { 1.0 } else { -1.0 }).as_vec3().to_array();
        let pixel = &mut self.found[pixel as usize];
        pixel.object = scene.primitive_id(hit);
        (pixel.first_near, pixel.near) = (near, near);
        pixel.normal = normal;
        (pixel.key, pixel.albedo, pixel.roughness) = (0, lobes.albedo(), lobes.roughness);
        true
    }

    /// Notes what the camera ray hits.
    fn see(&mut self, frame: &Frame<'_>, walker: &Walker, surface: &SurfaceInteraction, outside: bool) {
        let pixel = &mut self.found[walker.pixel as usize];
        pixel.object = frame.scene.primitive_id(&surface.hit);
        pixel.first_near = (1.0 / surface.hit.shape.t.max(1e-30)) as f32;
        let side = if outside { 1.0 } else { -1.0 };
        pixel.normal = (surface.ns * side).as_vec3().to_array();
        (pixel.near, pixel.key) = (pixel.first_near, 0);
    }

    /// Notes a surface that is not lit in this frame.
    fn guide(&mut self, walker: &Walker, surface: &SurfaceInteraction, lobes: &Lobes, outside: bool) {
        let pixel = &mut self.found[walker.pixel as usize];
        let side = if outside { 1.0 } else { -1.0 };
        pixel.normal = (surface.ns * side).as_vec3().to_array();
        pixel.near = (1.0 / (walker.length + surface.hit.shape.t).max(1e-30)) as f32;
        pixel.key = walker.key;
        pixel.albedo = walker.beta * lobes.albedo();
        pixel.roughness = lobes.roughness;
    }

    fn emission(
        &mut self,
        frame: &Frame<'_>,
        walker: &Walker,
        surface: &SurfaceInteraction,
        material: &OpenPbr,
    ) {
        let scene = frame.scene;
        let radiance = material
            .constant_emission()
            .unwrap_or_else(|| material.desc.emitted_color(scene, &scene.texture_point(surface)));
        let pdf =
            if walker.is_specular { 0.0 } else { scene.emitters.pdf_hit(scene, walker.origin, surface) };
        // Light sampling alone brings the light of emissive surfaces to diffuse ones.
        let weight = if walker.role == Role::Bounce && pdf > 0.0 { 0.0 } else { walker.weight_found(pdf) };
        self.add(walker, walker.beta * radiance * weight);
    }

    /// Follows delta lobes. Returns whether the other lobes are those of the pixel's surface.
    fn follow_deltas(&mut self, frame: &Frame<'_>, at: &At<'_>) -> bool {
        let &At { walker, vertex, lobes, .. } = at;
        if !lobes.has_delta || walker.rounds >= MOST_ROUNDS {
            return walker.is_main;
        }
        let mut all = vertex.bsdf.deltas();
        let weight = |s: &Option<BsdfSample>| s.map_or(0.0, |s| (s.f * s.wi.z.abs() as f32).luminance());
        let sum: f32 = all.iter().map(weight).sum();
        let smooth = if lobes.is_smooth() { (lobes.albedo() + lobes.specular).luminance() } else { 0.0 };
        let mut strongest = usize::MAX;
        let mut most = smooth;
        for (i, s) in all.iter().enumerate() {
            if weight(s) > most {
                (strongest, most) = (i, weight(s));
            }
        }
        let splits = walker.role == Role::Camera && walker.rounds == 0;
        if !splits && sum > 0.0 {
            // One of them, by its weight.
            let u = at.numbers.second()[3] as f32 * sum;
            let mut before = 0.0;
            let mut taken: [Option<BsdfSample>; MOST_DELTAS] = [None; MOST_DELTAS];
            for (to, s) in taken.iter_mut().zip(&all) {
                let w = weight(s);
                if u >= before
                    && u < before + w
                    && let Some(s) = s
                {
                    *to = Some(BsdfSample { f: s.f * (sum / w), ..*s });
                }
                before += w;
            }
            all = taken;
        }
        let mut is_main = walker.is_main && strongest == usize::MAX;
        if !splits && walker.is_main && strongest != usize::MAX {
            strongest = all.iter().position(Option::is_some).unwrap_or(usize::MAX);
            is_main = strongest == usize::MAX;
        }
        for (i, s) in all.iter().enumerate() {
            let Some(s) = s else { continue };
            self.follow(frame, at, s, walker.is_main && i == strongest);
        }
        is_main
    }

    fn follow(&mut self, frame: &Frame<'_>, at: &At<'_>, s: &BsdfSample, is_main: bool) {
        let &At { walker, vertex, material, .. } = at;
        let beta = walker.beta * s.f * (s.wi.z.abs() / s.pdf) as f32;
        let wi = vertex.frame.to_world(s.wi);
        let Some(crosses) = vertex.crosses(wi, s.wi) else { return };
        if beta.max_component() < FAINT {
            return;
        }
        let surface = vertex.surface;
        let mut absorbs = walker.absorption;
        if crosses && material.has_inside() {
            let enters = wi.dot(vertex.ng) < 0.0;
            absorbs = [0.0; 3];
            if enters {
                absorbs = absorption(frame.scene, material, &frame.scene.texture_point(surface));
            }
        }
        let side = if vertex.wo.dot(surface.ng) >= 0.0 { 1.0 } else { -1.0 };
        let curvature = side * frame.scene.curvature(&surface.hit);
        let cone =
            if crosses { walker.cone.refracted(s.eta, curvature) } else { walker.cone.reflected(curvature) };
        let next = Walker {
            is_main,
            beta,
            from_camera: false,
            seen_through: walker.seen_through && crosses,
            cone,
            length: walker.length + surface.hit.shape.t,
            absorption: absorbs,
            key: walker
                .key
                .wrapping_mul(31)
                .wrapping_add(2 * frame.scene.primitive_id(&surface.hit) + 1 + u32::from(crosses))
                & !CATCHER,
            rounds: walker.rounds + 1,
            is_specular: walker.is_specular,
            ..*walker
        };
        self.next.push(next, surface, wi);
    }

    /// The pixel's surface: its guides, sampled light, and rays for indirect light and gloss.
    fn light_main(&mut self, frame: &Frame<'_>, at: &At<'_>) {
        let &At { walker, vertex, lobes, numbers, .. } = at;
        let (x, y) = self.place(walker.pixel);
        let surface = vertex.surface;
        let is_lit = frame.pattern.lights(x, y);
        let pixel = &mut self.found[walker.pixel as usize];
        pixel.normal = vertex.frame.z.as_vec3().to_array();
        pixel.near = (1.0 / (walker.length + surface.hit.shape.t).max(1e-30)) as f32;
        pixel.key = walker.key;
        pixel.albedo = walker.beta * lobes.albedo();
        pixel.roughness = lobes.roughness;
        pixel.is_lit = is_lit;
        let pick = vertex.bsdf.diffuse_probability();
        if is_lit && let Some(lit) = &at.lit {
            self.connect_main(at, lit, pick);
        }
        let length = walker.length + surface.hit.shape.t;
        let [u0, u1, u2, _] = numbers.second();
        let next = Walker {
            is_main: false,
            is_specular: false,
            from_camera: false,
            seen_through: false,
            length,
            rounds: walker.rounds + 1,
            origin: frame.scene.receiver(surface, -vertex.wo),
            ..*walker
        };
        if !frame.is_direct && frame.pattern.gathers(x, y) && !lobes.albedo().is_black() {
            let [reflects, transmits] = lobes.diffuse.map(Spectrum::luminance);
            let side = if u2 * f64::from(reflects + transmits) < f64::from(reflects) { 1.0 } else { -1.0 };
            let local = sample_cosine([u0, u1]);
            let local = DVec3::new(local.x, local.y, local.z * side);
            let wi = vertex.frame.to_world(local);
            let crosses = (wi.dot(vertex.ng) > 0.0) != (vertex.wo.dot(vertex.ng) > 0.0);
            if crosses == (side < 0.0) {
                let pdf = local.z.abs() * FRAC_1_PI;
                let cone = self.widened(frame, walker, pdf);
                self.next.push(
                    Walker { role: Role::Bounce, beta: Spectrum::WHITE, pdf, cone, ..next },
                    surface,
                    wi,
                );
            }
        }
        if lobes.has_gloss && is_lit {
            let Some(s) = vertex.bsdf.sample_gloss([u2, u0, u1]).filter(|s| !s.lobe.is_delta) else { return };
            let wi = vertex.frame.to_world(s.wi);
            if vertex.crosses(wi, s.wi).is_none() {
                return;
            }
            let pdf = gloss_pdf(s.pdf, s.wi.z, pick);
            let f = gloss_part(s.f, lobes, s.wi.z);
            let beta = walker.beta * f * (s.wi.z.abs() / pdf) as f32;
            if pdf > 0.0 && beta.max_component() > FAINT && beta.is_finite() {
                let cone = self.widened(frame, walker, pdf);
                self.next.push(Walker { role: Role::Gloss, beta, pdf, cone, ..next }, surface, wi);
            }
        }
    }

    fn widened(&self, frame: &Frame<'_>, walker: &Walker, pdf: f64) -> crate::math::RayCone {
        let pixel = frame.view.pixel_cone.as_ref();
        pixel.map_or(walker.cone, |pixel| walker.cone.reflected(0.0).scattered(pdf, pixel.share))
    }

    /// Sampled light at the pixel's surface.
    fn connect_main(&mut self, at: &At<'_>, lit: &LightSample, pick: f64) {
        let &At { walker, vertex, lobes, .. } = at;
        let Some(met) = vertex.met(lit.to_light).filter(|met| !met.f.is_black()) else { return };
        let gloss = gloss_part(met.f, lobes, met.wi_local.z);
        let diffuse = met.f - gloss;
        let cos = met.wi_local.z.abs();
        let k = cos / lit.pdf;
        // Bounces find infinite lights, too.
        let by_bounce = if lit.finite { 0.0 } else { cos * FRAC_1_PI };
        let arrives = lit.radiance * (k * weight_sampled(lit, by_bounce)) as f32;
        let albedo = lobes.albedo();
        let over = |a: f32, b: f32| if b > 1e-6 { a / b } else { 0.0 };
        let light =
            Spectrum::new(over(diffuse.r, albedo.r), over(diffuse.g, albedo.g), over(diffuse.b, albedo.b))
                * arrives;
        let weight = weight_sampled(lit, gloss_pdf(met.pdf, met.wi_local.z, pick));
        let gloss = walker.beta * gloss * lit.radiance * (k * weight) as f32;
        if (light + gloss).is_black() || !(light + gloss).is_finite() {
            return;
        }
        let sent = Sent { pixel: walker.pixel, target: Target::Surface, light, gloss };
        self.push_shadow(vertex.surface, lit.to_light, lit.finite, sent);
    }

    /// Sampled light at any other surface; further light there is estimated.
    fn light_other(&mut self, frame: &Frame<'_>, at: &At<'_>) {
        let &At { walker, vertex, lobes, .. } = at;
        let albedo = walker.beta * (lobes.albedo() + lobes.specular);
        let pixel = &mut self.found[walker.pixel as usize];
        match walker.role {
            Role::Bounce => pixel.second += albedo,
            Role::Camera => pixel.bounced += albedo,
            // Only some pixels have gloss rays, so this is part of the light that is filtered.
            Role::Gloss => pixel.gloss += albedo * frame.ambient,
        }
        let Some(lit) = &at.lit else { return };
        let Some(met) = vertex.met(lit.to_light).filter(|met| !met.f.is_black()) else { return };
        let light = walker.beta * met.f * lit.radiance * (met.wi_local.z.abs() / lit.pdf) as f32;
        if light.is_black() || !light.is_finite() {
            return;
        }
        let sent = Sent { pixel: walker.pixel, target: walker.target(), light, gloss: Spectrum::BLACK };
        self.push_shadow(vertex.surface, lit.to_light, lit.finite, sent);
    }
}

/// A ray at a surface.
struct At<'a> {
    walker: &'a Walker,
    vertex: &'a Vertex<'a>,
    material: &'a OpenPbr,
    lobes: &'a Lobes,
    numbers: &'a VertexNumbers,
    lit: Option<LightSample>,
}

/// What of a BSDF's value is not that of the diffuse base.
fn gloss_part(f: Spectrum, lobes: &Lobes, z: f64) -> Spectrum {
    if !lobes.has_gloss {
        return Spectrum::BLACK;
    }
    let diffuse = lobes.diffuse[usize::from(z < 0.0)] * FRAC_1_PI as f32;
    Spectrum::new((f.r - diffuse.r).max(0.0), (f.g - diffuse.g).max(0.0), (f.b - diffuse.b).max(0.0))
}

/// The density of the lobes beside the diffuse base, from that of all lobes; `pick` is the probability of the base.
fn gloss_pdf(pdf: f64, z: f64, pick: f64) -> f64 {
    if pick >= 1.0 {
        return 0.0;
    }
    ((pdf - pick * z.abs() * FRAC_1_PI) / (1.0 - pick)).max(0.0)
}
