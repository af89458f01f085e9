//! The recursion, with a stack of its own.

use super::{AtDepth, ClassicDesc, Combine, Facing, Highlight, Miss};
use crate::color::Spectrum;
use crate::integrator::{CameraSample, Integrator, Radiance, RayStats};
use crate::light::Light;
use crate::material::{Classic, Fresnel, Material, color_at};
use crate::math::elementary::pow;
use crate::math::{DVec2, DVec3, Ray, reflect, refract};
use crate::sampler::SampleId;
use crate::scene::{Scene, SurfaceInteraction};

/// A ray of the tree that is still to be traced.
#[derive(Clone, Copy)]
struct Task {
    ray: Ray,
    /// Its share of the pixel.
    weight: f64,
    depth: u32,
}

/// What the tree of one sample has come to.
struct Tree {
    color: Spectrum,
    alpha: f32,
    /// Rays spawned.
    spawned: u32,
    /// Rays numbered for the jitter of area lights.
    shaded: u64,
    id: SampleId,
    /// The documents' length of a ray's direction, which reflection and refraction keep: `epsilon` is a t.
    length: f64,
}

impl Integrator for ClassicDesc {
    fn radiance(
        &self,
        scene: &Scene,
        samples: &[CameraSample],
        out: &mut Vec<Radiance>,
        stats: &mut RayStats,
    ) {
        let mut stack: Vec<Task> = Vec::with_capacity(32);
        for sample in samples {
            let mut tree = Tree {
                color: Spectrum::BLACK,
                alpha: 1.0,
                spawned: 0,
                shaded: 0,
                id: sample.id,
                length: sample.length,
            };
            stats.camera += 1;
            stack.push(Task { ray: sample.ray, weight: 1.0, depth: 0 });
            while let Some(task) = stack.pop() {
                self.trace(scene, &task, &mut tree, &mut stack, stats);
            }
            stats.dropped += u64::from(tree.spawned > self.max_rays);
            out.push(Radiance { color: tree.color, alpha: tree.alpha });
        }
    }
}

/// Weights of the three terms at a hit.
struct Weights {
    local: f64,
    reflect: f64,
    refract: f64,
}

/// A hit as shading sees it.
struct Shading<'a> {
    surface: &'a SurfaceInteraction,
    material: &'a Classic,
    color: Spectrum,
    /// Unit direction of the ray.
    d: DVec3,
    /// Shading normal, towards the viewer.
    n: DVec3,
    /// The same, or pointing outward: the N of the shading rule.
    lit: DVec3,
}

impl ClassicDesc {
    fn trace(
        &self,
        scene: &Scene,
        task: &Task,
        tree: &mut Tree,
        stack: &mut Vec<Task>,
        stats: &mut RayStats,
    ) {
        let Some(hit) = scene.intersect(&task.ray) else {
            self.miss(scene, task, tree);
            return;
        };
        let surface = scene.surface(&task.ray, &hit);
        let Material::Classic(material) = &scene.materials[surface.material.index()];
        let d = task.ray.direction;
        let entering = d.dot(surface.ng) <= 0.0;
        let (n, ng) = if entering { (surface.ns, surface.ng) } else { (-surface.ns, -surface.ng) };
        let lit = match self.facing {
            Facing::Viewer => n,
            Facing::Outward => surface.ns,
        };
        let color = color_at(material.color, scene, &surface);
        let s = Shading { surface: &surface, material, color, d, n, lit };

        let eta = if entering { 1.0 / material.ior } else { material.ior };
        let (weights, refracted) = self.weights(&s, eta, task.depth);
        if weights.local > 0.0 {
            let local = self.local(scene, &s, tree, stats);
            tree.color += local * (task.weight * weights.local) as f32;
        }
        // The refracted ray is pushed first, so that the reflected one is traced first: the documents' order.
        if let Some(direction) = refracted
            && weights.refract > 0.0
        {
            let spawned = self.spawn(scene, &s, direction, task, weights.refract, tree, stack);
            stats.refracted += u64::from(spawned);
        }
        if weights.reflect > 0.0 {
            // A shading normal may tip the mirror direction below the surface: then the geometric one serves.
            let mut direction = reflect(d, n);
            if direction.dot(ng) <= 0.0 {
                direction = reflect(d, ng);
            }
            let spawned = self.spawn(scene, &s, direction, task, weights.reflect, tree, stack);
            stats.reflected += u64::from(spawned);
        }
    }

    /// The weights of local, reflected and refracted colour, and the refracted direction if there is one.
    fn weights(&self, s: &Shading<'_>, eta: f64, depth: u32) -> (Weights, Option<DVec3>) {
        let m = s.material;
        let k_reflect = if self.reflection { m.k_reflect } else { 0.0 };
        let k_refract = if self.refraction { m.k_refract } else { 0.0 };
        if k_reflect == 0.0 && k_refract == 0.0 {
            return (Weights { local: m.k_local.unwrap_or(1.0), reflect: 0.0, refract: 0.0 }, None);
        }
        if self.at_depth == AtDepth::Local && depth >= self.max_depth {
            return (Weights { local: 1.0, reflect: 0.0, refract: 0.0 }, None);
        }
        let direction = if k_refract > 0.0 { refract(s.d, s.n, eta) } else { None };
        let (reflect, refracted) = match (m.fresnel, k_refract > 0.0 && direction.is_none()) {
            // Total internal reflection: the refracted share goes along the mirror direction.
            (Fresnel::Off, true) => (k_reflect + k_refract, 0.0),
            (_, true) => (k_reflect.max(k_refract), 0.0),
            (Fresnel::Off, false) => (k_reflect, k_refract),
            (fresnel, false) => {
                let f = fresnel.reflectance((-s.d.dot(s.n)).clamp(0.0, 1.0), eta);
                (k_reflect * f, k_refract * (1.0 - f))
            }
        };
        let local = m.k_local.unwrap_or(match self.combine {
            Combine::Add => 1.0,
            Combine::Blend => (1.0 - reflect - refracted).max(0.0),
        });
        (Weights { local, reflect, refract: refracted }, direction)
    }

    /// Puts a reflected or refracted ray on the stack; beyond the depth limit adds what stands for it instead.
    /// Returns whether there is such a ray.
    #[allow(clippy::too_many_arguments)]
    fn spawn(
        &self,
        scene: &Scene,
        s: &Shading<'_>,
        direction: DVec3,
        from: &Task,
        weight: f64,
        tree: &mut Tree,
        stack: &mut Vec<Task>,
    ) -> bool {
        let weight = from.weight * weight;
        let depth = from.depth + 1;
        if depth > self.max_depth {
            let color = match self.at_depth {
                AtDepth::Background => scene.background.color(direction),
                AtDepth::Ambient => scene.ambient,
                AtDepth::Black | AtDepth::Local => return false,
            };
            tree.color += color * weight as f32;
            return false;
        }
        tree.spawned = tree.spawned.saturating_add(1);
        if tree.spawned > self.max_rays {
            return false;
        }
        let mut ray = Ray::new(s.surface.p, direction);
        if self.epsilon > 0.0 {
            ray.t_min = self.epsilon * tree.length;
        } else {
            ray.origin = s.surface.leave(direction);
        }
        stack.push(Task { ray, weight, depth });
        true
    }

    fn miss(&self, scene: &Scene, task: &Task, tree: &mut Tree) {
        let d = task.ray.direction;
        if self.light_seen {
            let mut seen = Spectrum::BLACK;
            let mut any = false;
            for light in &scene.lights {
                if let Light::Directional(light) = light
                    && light.is_seen(d)
                {
                    seen += light.intensity;
                    any = true;
                }
            }
            if any {
                tree.color += seen * task.weight as f32;
                return;
            }
        }
        if task.depth == 0 && scene.background.transparent {
            tree.alpha = 0.0;
            return;
        }
        if self.miss == Miss::Background {
            tree.color += scene.background.color(d) * task.weight as f32;
        }
    }

    /// ka·Ia·C + Σ S·I·(kd·C·max(0, N·L) + ks·H·max(0, R·V)^n)
    fn local(&self, scene: &Scene, s: &Shading<'_>, tree: &mut Tree, stats: &mut RayStats) -> Spectrum {
        let m = s.material;
        let mut local = Spectrum::BLACK;
        if self.ambient {
            local += scene.ambient * s.color * m.ka as f32;
        }
        let kd = if self.diffuse { m.kd } else { 0.0 };
        let ks = if self.highlights { m.ks } else { 0.0 };
        if kd == 0.0 && ks == 0.0 {
            return local;
        }
        let highlight_color = match self.highlight {
            Highlight::Light => Spectrum::WHITE,
            Highlight::Material => s.color,
        };
        let p = s.surface.p;
        for (number, light) in scene.lights.iter().enumerate() {
            for i in 0..light.samples() {
                let jitter = if light.is_jittered() {
                    tree.id.unit_square(jitter_dimension(tree.shaded, number, i))
                } else {
                    DVec2::ZERO
                };
                let Some(lit) = light.illuminate(p, i, jitter) else { continue };
                let l = lit.to_light * lit.to_light.length().recip();
                let n_dot_l = s.lit.dot(l);
                let mut term = Spectrum::BLACK;
                if kd > 0.0 && n_dot_l > 0.0 {
                    term += s.color * (kd * n_dot_l) as f32;
                }
                if ks > 0.0 {
                    // R is L mirrored about N; V is −d.
                    let r_dot_v = -(2.0 * n_dot_l * s.lit - l).dot(s.d);
                    if r_dot_v > 0.0 {
                        term += highlight_color * (ks * pow(r_dot_v.min(1.0), m.exponent)) as f32;
                    }
                }
                // What no light reaches needs no shadow ray.
                if term.is_black() || lit.intensity.is_black() {
                    continue;
                }
                local += term * lit.intensity * self.visibility(scene, s, lit.to_light, lit.finite, stats);
            }
        }
        tree.shaded += 1;
        local
    }

    /// The share of a light that arrives: shadow rays, tinted shadows, the paper's shadow factor.
    #[inline]
    fn visibility(
        &self,
        scene: &Scene,
        s: &Shading<'_>,
        to_light: DVec3,
        finite: bool,
        stats: &mut RayStats,
    ) -> Spectrum {
        if !self.shadows {
            return Spectrum::WHITE;
        }
        stats.shadow += 1;
        let p = s.surface.p;
        let mut ray = Ray::new(p, to_light);
        if self.epsilon > 0.0 {
            ray.t_min = self.epsilon;
        } else {
            ray.origin = s.surface.leave(to_light);
            if finite {
                ray.direction = p + to_light - ray.origin;
            }
        }
        if finite {
            ray.t_max = 1.0;
        }
        let seen = scene.transmittance(&ray);
        let f = self.shadow_factor as f32;
        if f > 0.0 { seen * (1.0 - f) + Spectrum::grey(f) } else { seen }
    }
}

/// A dimension of its own for each shaded point, light and shadow ray of a sample.
fn jitter_dimension(shaded: u64, light: usize, i: u32) -> u64 {
    16 + ((shaded << 40) ^ ((light as u64) << 20) ^ u64::from(i))
}
