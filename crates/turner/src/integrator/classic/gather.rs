//! The hits of a round, gathered into blocks.
//!
//! Eight rays of the queue that hit one sphere are copied as a block. Other hits fill one block after the other, lane by
//! lane. A sample has at most one hit in a round, so their order changes nothing.

use std::ops::Range;

use turner_bvh::lanes::{Block, Block32, LANES};

use super::points::{PointBlock, get, set};
use super::queue::resume;
use super::radiance::{ShadedHit, Task, TreeBatch, Weights};
use super::record::Record;
use crate::color::Spectrum;
use crate::integrator::Radiance;
use crate::material::{Material, color_at};
use crate::math::{Ray, RayCone};
use crate::scene::{Hit, SpectrumBlock};
use crate::schema::ColorSource;

impl<R: Record> TreeBatch<'_, R> {
    /// Finishes the rays that hit nothing and gathers the hits of the others into blocks.
    pub(super) fn gather(&mut self, out: &mut [Radiance]) {
        self.blocks = 0;
        self.open = (0, LANES);
        self.slots.clear();
        self.shaded_hits.clear();
        self.converted.clear();
        for first in (0..self.hits.len()).step_by(LANES) {
            if R::NOTES || !self.gather_sphere(first) {
                self.gather_lanes(first..(first + LANES).min(self.hits.len()), out);
            }
        }
    }

    /// Adds a block without hits; returns its index.
    fn add_block(&mut self) -> usize {
        const EMPTY: ShadedHit<'static> = ShadedHit {
            task: Task {
                sample: 0,
                depth: 0,
                weight: 0.0,
                cone: RayCone { width: 0.0, spread: 0.0 },
                curvature: 0.0,
            },
            material: Err(usize::MAX),
            weights: Weights { local: 0.0, reflect: 0.0, refract: 0.0 },
            refracted: None,
        };
        self.blocks += 1;
        if self.blocks > self.points.len() {
            self.points.push(PointBlock::default());
        }
        self.points[self.blocks - 1].clear();
        self.shaded_hits.resize(self.blocks * LANES, EMPTY);
        self.blocks - 1
    }

    /// Makes a block of eight rays of the queue that hit one sphere of one colour. False if they do not.
    #[inline]
    fn gather_sphere(&mut self, first: usize) -> bool {
        let Some(&[Some(hit), ..]) = self.hits.get(first..first + LANES) else { return false };
        let is_same = |other: &Option<Hit>| other.is_some_and(|other| other.primitive == hit.primitive);
        if self.view.pixel_cone.is_some() || !self.hits[first..first + LANES].iter().all(is_same) {
            return false;
        }
        let scene = self.scene;
        let (Some(sphere), Material::Classic(material)) = (scene.sphere_at(&hit), scene.material_at(&hit))
        else {
            return false;
        };
        let (ColorSource::Constant(color), None) = (material.color, material.bump) else { return false };
        let block = self.add_block();
        let b = &mut self.points[block];
        let rays = &self.queue.rays.blocks()[first / LANES];
        (b.d, b.origin) = (rays.direction, rays.origin);
        b.on_sphere = u8::MAX;
        b.center = sphere.center.to_array().map(|v| Block([v; LANES]));
        b.radius = Block([sphere.radius; LANES]);
        b.color = SpectrumBlock(color.to_array().map(|v| Block32([v; LANES])));
        for lane in 0..LANES {
            b.t.0[lane] = self.hits[first + lane].map_or(0.0, |hit| hit.shape.t);
            self.integrator.coefficients(material, b, lane);
            let hit = &mut self.shaded_hits[block * LANES + lane];
            (hit.task, hit.material) = (self.queue.tasks[first + lane], Ok(material));
            self.slots.push((block * LANES + lane) as u32);
        }
        true
    }

    /// Gathers single hits into the open block.
    fn gather_lanes(&mut self, rays: Range<usize>, out: &mut [Radiance]) {
        for i in rays {
            let mut task = self.queue.tasks[i];
            let (depth, weight) = (task.depth, task.weight);
            let ray = || self.queue.rays.get(i);
            self.record.note(|n| ray().iter().for_each(|ray| n.traced(ray, depth, weight)));
            let Some(hit) = self.hits[i] else {
                let tree = &mut self.trees[task.sample as usize];
                let direction = || get(&self.queue.rays.blocks()[i / LANES].direction, i % LANES);
                let pixel = &mut out[task.sample as usize];
                if !R::NOTES
                    && let Some(seen) = self.plain_miss
                {
                    pixel.color += seen * task.weight as f32;
                    resume(tree, &mut self.waiting, &mut self.next);
                    continue;
                }
                self.integrator.miss(self.scene, &task, direction, pixel, &mut self.record);
                resume(tree, &mut self.waiting, &mut self.next);
                continue;
            };
            let hit = &hit;
            self.record.note(|n| ray().iter().for_each(|ray| n.hit_surface(self.scene, ray, hit)));
            if self.open.1 == LANES {
                self.open = (self.add_block(), 0);
            }
            let (block, lane) = self.open;
            let b = &mut self.points[block];
            let filtered = self.view.pixel_cone.is_some();
            let surface_of = |ray: &Ray, task: &mut Task| {
                let mut surface = self.scene.surface(ray, hit);
                if filtered {
                    task.arrive(self.scene, &mut surface, ray.direction, hit.shape.t);
                }
                surface
            };
            let (material, seen) = match self.scene.material_at(hit) {
                Material::Classic(material) => (Ok(material), None),
                // Materials are never prepared like this for the classic integrator.
                Material::OpenPbr(_) => continue,
                Material::Principled(physical, _) => {
                    let Some(ray) = self.queue.rays.get(i) else { continue };
                    let mut surface = surface_of(&ray, &mut task);
                    let (converted, emitted) = physical.as_classic(self.scene, &mut surface, ray.direction);
                    let emitted = emitted * task.weight as f32;
                    out[task.sample as usize].color += emitted;
                    self.record.note(|n| n.emitted(emitted));
                    self.converted.push(converted);
                    (Err(self.converted.len() - 1), Some(surface))
                }
                Material::Mix(mix) => {
                    let Some(ray) = self.queue.rays.get(i) else { continue };
                    let mut surface = surface_of(&ray, &mut task);
                    let (converted, emitted) = mix.as_classic(self.scene, &mut surface, ray.direction);
                    let emitted = emitted * task.weight as f32;
                    out[task.sample as usize].color += emitted;
                    self.record.note(|n| n.emitted(emitted));
                    self.converted.push(converted);
                    (Err(self.converted.len() - 1), Some(surface))
                }
            };
            let classic = material.unwrap_or_else(|i| &self.converted[i]);
            let rays = &self.queue.rays.blocks()[i / LANES];
            for axis in 0..3 {
                b.d[axis].0[lane] = rays.direction[axis].0[i % LANES];
                b.origin[axis].0[lane] = rays.origin[axis].0[i % LANES];
            }
            b.t.0[lane] = hit.shape.t;
            let sphere = if seen.is_none() { self.scene.sphere_at(hit) } else { None };
            if let Some(sphere) = sphere {
                b.on_sphere |= 1 << lane;
                set(&mut b.center, lane, sphere.center);
                b.radius.0[lane] = sphere.radius;
            }
            let mut color = None;
            if let ColorSource::Constant(c) = classic.color
                && sphere.is_some()
                && !filtered
                && classic.bump.is_none()
            {
                color = Some(c);
            } else if let Some(ray) = self.queue.rays.get(i) {
                let mut surface = seen.unwrap_or_else(|| surface_of(&ray, &mut task));
                if let Some(bump) = classic.bump {
                    crate::material::apply_bump_map(self.scene, &mut surface, bump);
                }
                b.on_sphere &= !(1 << lane);
                set(&mut b.p, lane, surface.p);
                set(&mut b.ng, lane, surface.ng);
                set(&mut b.ns, lane, surface.ns);
                b.error.0[lane] = surface.error;
                color = Some(color_at(classic.color, self.scene, &surface));
            }
            b.color.set(lane, color.unwrap_or(Spectrum::BLACK));
            self.integrator.coefficients(classic, b, lane);
            let place = &mut self.shaded_hits[block * LANES + lane];
            (place.task, place.material) = (task, material);
            self.slots.push((block * LANES + lane) as u32);
            self.open.1 += 1;
        }
    }
}
