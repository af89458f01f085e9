//! How the rendering code fills a [`PathRecord`].

use super::caustics::Gathered;
use super::path_batch::Path;
use super::record::{
    EmissionRecord, EscapeRecord, LightRecord, MediumSegmentRecord, Passage, PathRecord, PhotonsRecord,
    RandomWalkRecord, Roulette, ScatterRecord, VertexRecord,
};
use crate::bsdf::{BsdfSample, Entry, Lobe};
use crate::color::Spectrum;
use crate::material::{Material, OpenPbr};
use crate::math::{DVec3, Ray};
use crate::scene::light_sample::LightSample;
use crate::scene::{Hit, Scene, SurfaceInteraction};
use crate::schema::MaterialId;

impl Path {
    /// Density of the ray's direction, where light sampling could have found what it hits.
    fn pdf_for_mis(&self) -> Option<f64> {
        (!self.specular_bounce).then_some(self.pdf)
    }
}

impl PathRecord {
    /// Edits the current vertex.
    pub(super) fn at(&mut self, f: impl FnOnce(&mut VertexRecord)) {
        if let Some(vertex) = self.vertices.last_mut() {
            f(vertex);
        }
    }

    /// Photons contributed at the current vertex.
    pub(super) fn gathered(&mut self, radius: f64, g: Gathered, contribution: Spectrum) {
        let photons = PhotonsRecord { radius, count: g.count, radiance: g.radiance, contribution };
        self.at(|v| v.photons = Some(photons));
    }

    /// Edits the record of what the ray found that left the scene.
    pub(super) fn at_escape(&mut self, f: impl FnOnce(&mut EscapeRecord)) {
        if let Some(escape) = &mut self.escape {
            f(escape);
        }
    }

    /// The path hit a surface; `path` is its state on arrival.
    pub(super) fn hit_surface(
        &mut self,
        scene: &Scene,
        path: &Path,
        ray: &Ray,
        hit: &Hit,
        surface: &SurfaceInteraction,
        transmittance: Option<Spectrum>,
    ) {
        let way = self.way.take();
        self.vertices.push(VertexRecord {
            way,
            origin: ray.origin,
            direction: ray.direction,
            t: hit.shape.t,
            p: surface.p,
            ng: surface.ng,
            ns: surface.ns,
            primitive: scene.primitive_id(hit),
            shape: scene.shape_word(hit),
            part: hit.shape.part,
            uv: [hit.shape.u, hit.shape.v],
            material: surface.material,
            chosen: None,
            outside: ray.direction.dot(surface.ng) < 0.0,
            inside: path.media.materials().collect(),
            transmittance,
            throughput: path.beta,
            passage: Passage::Surface,
            walk: None,
            emission: None,
            ior_around: None,
            band: path.band,
            dispersed: None,
            photons: None,
            lights: Vec::new(),
            scatter: None,
        });
    }

    /// Notes the material at the vertex, if a mix chose it.
    pub(super) fn chose_material(&mut self, scene: &Scene, material: &OpenPbr) {
        let is = |m: &Material| matches!(m, Material::OpenPbr(p) if std::ptr::eq(&**p, material));
        self.at(|v| {
            if !scene.materials.get(v.material.index()).is_some_and(is) {
                v.chosen = scene.materials.iter().position(is).map(|i| MaterialId(i as u32));
            }
        });
    }

    /// Dispersion left one band with this throughput.
    pub(super) fn dispersed(&mut self, band: u8, throughput: Spectrum) {
        self.at(|v| (v.band, v.dispersed) = (Some(band), Some(throughput)));
    }

    /// The ray hit an emissive surface.
    pub(super) fn hit_emitter(
        &mut self,
        path: &Path,
        radiance: Spectrum,
        light_pdf: f64,
        weight: f64,
        added: Spectrum,
    ) {
        let pdf = path.pdf_for_mis();
        self.at(|v| {
            v.emission = Some(EmissionRecord { radiance, pdf, light_pdf, weight, contribution: added });
        });
    }

    /// A light was sampled; `candidates` and the resampling weight `counts` as in [`LightRecord`].
    pub(super) fn sampled_light(
        &mut self,
        lit: &LightSample,
        direction: DVec3,
        bsdf: Spectrum,
        bsdf_pdf: f64,
        cosine: f64,
        (candidates, counts): (u32, f32),
    ) {
        let light = sampled(lit, direction, bsdf, bsdf_pdf, cosine);
        self.at(|v| v.lights.push(LightRecord { candidates, counts, ..light }));
    }

    /// The MIS weight of the sampled light, and its unshadowed contribution.
    pub(super) fn weighted_light(
        &mut self,
        weight: f64,
        transmittance: Option<Spectrum>,
        unshadowed: Spectrum,
    ) {
        self.at(|v| {
            if let Some(light) = v.lights.last_mut() {
                (light.weight, light.transmittance, light.unshadowed) = (weight, transmittance, unshadowed);
            }
        });
    }

    /// The shadow ray, and the fraction that passes.
    pub(super) fn shadow_ray(&mut self, scene: &Scene, ray: Option<Ray>, through: Spectrum) {
        let Some(ray) = ray else { return };
        self.pending_light(|light| {
            light.shadow_origin = Some(ray.origin);
            if through != Spectrum::WHITE {
                light.casters = scene.shadow_casters(&ray);
            }
        });
    }

    /// The contribution of the shadow ray.
    pub(super) fn light_arrived(&mut self, visible: Spectrum, contribution: Spectrum) {
        self.pending_light(|light| {
            (light.visible, light.contribution) = (Some(visible), contribution);
        });
    }

    /// Edits the light of the next pending shadow ray: of several lights they come in their order. At the exit of a random
    /// walk, those of the entry vertex come first.
    fn pending_light(&mut self, f: impl FnOnce(&mut LightRecord)) {
        let is_only = |v: &VertexRecord| v.walk.is_none() && v.lights.len() <= 1;
        if self.next_is_equiangular || self.vertices.last().is_none_or(is_only) {
            return self.at_light(self.next_is_equiangular, f);
        }
        let is_pending = |l: &&mut LightRecord| l.visible.is_none() && !l.unshadowed.is_black();
        let is_exit = self.vertices.last().is_some_and(|v| v.walk.is_some());
        let first = self.vertices.len().saturating_sub(if is_exit { 2 } else { 1 });
        let mut lights = self.vertices.iter_mut().skip(first).flat_map(|v| &mut v.lights);
        if let Some(light) = lights.find(is_pending) {
            f(light);
        }
    }

    /// A direction was sampled and taken; `throughput` is the new one.
    pub(super) fn scattered(
        &mut self,
        direction: DVec3,
        s: &BsdfSample,
        terminator: f64,
        throughput: Spectrum,
    ) {
        let cosine = s.wi.z.abs();
        self.at(|v| {
            v.scatter = Some(ScatterRecord {
                direction,
                lobe: s.lobe,
                bsdf: s.f,
                pdf: s.pdf,
                cosine,
                eta: s.eta,
                terminator,
                weight: s.f * (cosine / s.pdf) as f32,
                roulette: None,
                throughput,
            });
        });
    }

    /// The path enters a translucent body in this direction.
    pub(super) fn entered_body(&mut self, direction: DVec3, entry: &Entry, throughput: Spectrum) {
        let cosine = entry.wi.z.abs();
        let pdf = entry.probability * cosine * std::f64::consts::FRAC_1_PI;
        self.at(|v| {
            v.scatter = Some(ScatterRecord {
                direction,
                lobe: Lobe { is_delta: false, is_transmission: true, is_diffuse: true },
                bsdf: entry.weight * (entry.probability * std::f64::consts::FRAC_1_PI) as f32,
                pdf,
                cosine,
                eta: 1.0,
                terminator: 1.0,
                weight: entry.weight,
                roulette: None,
                throughput,
            });
        });
    }

    /// The vertex was reached by a random walk in a translucent body.
    pub(super) fn random_walk(&mut self, passage: Passage, walk: RandomWalkRecord) {
        self.at(|v| (v.passage, v.walk) = (passage, Some(walk)));
    }

    /// Russian roulette was played.
    pub(super) fn roulette(&mut self, roulette: Roulette) {
        self.at(|v| {
            if let Some(scatter) = &mut v.scatter {
                scatter.roulette = Some(roulette);
            }
        });
    }

    /// The throughput after Russian roulette.
    pub(super) fn set_throughput(&mut self, throughput: Spectrum) {
        self.at(|v| {
            if let Some(scatter) = &mut v.scatter {
                scatter.throughput = throughput;
            }
        });
    }

    /// The direct light of a shared vertex without its BSDF, which is part of the weight of the path.
    pub(super) fn donates_direct(&mut self, weight: f64, bsdf_pdf: f64, unshadowed: Spectrum) {
        self.at(|v| {
            if let Some(light) = v.lights.last_mut() {
                (light.bsdf, light.bsdf_pdf) = (Spectrum::WHITE, bsdf_pdf);
                (light.weight, light.unshadowed) = (weight, unshadowed);
            }
        });
    }

    /// The same for the next direction.
    pub(super) fn donates_next(&mut self, weight: Spectrum, pdf: f64, throughput: Spectrum) {
        self.at(|v| {
            if let Some(scatter) = &mut v.scatter {
                (scatter.bsdf, scatter.pdf) = (Spectrum::WHITE, pdf);
                (scatter.weight, scatter.throughput) = (weight, throughput);
            }
        });
    }

    /// The ray left the scene; `throughput` is the fraction of what it finds that reaches the pixel.
    pub(super) fn escaped(
        &mut self,
        path: &Path,
        ray: &Ray,
        transmittance: Option<Spectrum>,
        throughput: Spectrum,
    ) {
        let way = self.way.take();
        self.escape = Some(EscapeRecord {
            way,
            origin: ray.origin,
            direction: ray.direction,
            transmittance,
            throughput,
            pdf: path.pdf_for_mis(),
            lights: Vec::new(),
            background: Spectrum::BLACK,
            ambient: Spectrum::BLACK,
            contribution: Spectrum::BLACK,
        });
    }
}

/// The record of a sampled light before its shadow ray is traced.
fn sampled(lit: &LightSample, direction: DVec3, f: Spectrum, f_pdf: f64, cosine: f64) -> LightRecord {
    LightRecord {
        direction,
        distance: if lit.finite { lit.to_light.length() } else { f64::INFINITY },
        pdf: lit.pdf,
        candidates: 1,
        counts: 1.0,
        is_delta: lit.is_delta,
        radiance: lit.radiance,
        bsdf: f,
        bsdf_pdf: f_pdf,
        cosine,
        weight: 1.0,
        transmittance: None,
        unshadowed: Spectrum::BLACK,
        visible: None,
        shadow_origin: None,
        casters: Vec::new(),
        contribution: Spectrum::BLACK,
    }
}

/// Segments through media.
impl PathRecord {
    /// The path travels through a medium.
    pub(super) fn medium_segment(&mut self, solid: Option<MaterialId>, length: f64, weight: Spectrum) {
        self.way =
            Some(MediumSegmentRecord { solid, length, weight, beside: 0.0, emission: None, second: None });
    }

    /// The current segment, or the last one.
    fn last_segment(&mut self) -> Option<&mut MediumSegmentRecord> {
        if self.way.is_some() {
            return self.way.as_mut();
        }
        match &mut self.escape {
            Some(escape) => escape.way.as_mut(),
            None => self.vertices.last_mut()?.way.as_mut(),
        }
    }

    /// The medium of the segment emits.
    pub(super) fn segment_emitted(&mut self, added: Spectrum) {
        if let Some(segment) = self.last_segment() {
            segment.emission = Some(added);
        }
    }

    /// Density of the equiangular point over that of distance sampling, where the path scattered.
    pub(super) fn equiangular_ratio(&mut self, ratio: f64) {
        if let Some(segment) = self.last_segment() {
            segment.beside = ratio;
        }
    }

    /// The path scattered in the medium.
    pub(super) fn scattered_in_medium(&mut self, path: &Path, ray: &Ray, t: f64, p: DVec3) {
        let way = self.way.take();
        self.vertices.push(VertexRecord {
            way,
            origin: ray.origin,
            direction: ray.direction,
            t,
            p,
            ng: DVec3::ZERO,
            ns: DVec3::ZERO,
            primitive: u32::MAX,
            shape: "medium",
            part: 0,
            uv: [0.0; 2],
            material: path.media.top().unwrap_or(MaterialId(u32::MAX)),
            chosen: None,
            outside: false,
            inside: path.media.materials().collect(),
            transmittance: path.media.transmittance(t),
            throughput: path.beta,
            passage: Passage::Medium,
            walk: None,
            emission: None,
            ior_around: None,
            band: path.band,
            dispersed: None,
            photons: None,
            lights: Vec::new(),
            scatter: None,
        });
    }

    /// A light was sampled in a medium: at the equiangular point, at distance `equiangular` along the segment, or at
    /// the scattering event.
    pub(super) fn sampled_light_in_medium(
        &mut self,
        equiangular: Option<f64>,
        lit: &LightSample,
        direction: DVec3,
        phase: f64,
    ) {
        let light = sampled(lit, direction, Spectrum::grey(phase as f32), phase, 1.0);
        match equiangular {
            Some(t) => {
                if let Some(segment) = self.last_segment() {
                    segment.second = Some((t, light));
                }
            }
            None => self.at(|v| v.lights.push(light)),
        }
    }

    /// Edits the light sampled at the equiangular point of the segment, or at the vertex.
    pub(super) fn at_light(&mut self, equiangular: bool, f: impl FnOnce(&mut LightRecord)) {
        let light = if equiangular {
            self.last_segment().and_then(|w| w.second.as_mut()).map(|(_, light)| light)
        } else {
            self.vertices.last_mut().and_then(|v| v.lights.last_mut())
        };
        light.map(f);
    }

    /// Whether the next shadow ray starts at the equiangular point.
    pub(super) fn next_shadow_ray(&mut self, equiangular: bool) {
        self.next_is_equiangular = equiangular;
    }

    /// The phase function sampled a direction.
    pub(super) fn scattered_by_phase(&mut self, direction: DVec3, pdf: f64, throughput: Spectrum) {
        self.at(|v| {
            v.scatter = Some(ScatterRecord {
                direction,
                lobe: Lobe { is_delta: false, is_transmission: false, is_diffuse: false },
                bsdf: Spectrum::grey(pdf as f32),
                pdf,
                cosine: 1.0,
                eta: 1.0,
                terminator: 1.0,
                weight: Spectrum::WHITE,
                roulette: None,
                throughput,
            });
        });
    }
}
