//! Caustic targets: objects that focus light, and the sampling of light paths aimed at them.
//!
//! Photons sent in all directions rarely hit a small glass. Here they are aimed: primitives of glass, metal and the
//! like are divided into at most 64 groups, each with a bounding sphere. A light path chooses a group, then a light
//! (as a point at the group's centre would choose it), then a ray through the sphere:
//!
//! ```text
//!   infinite light: uniform over the disc         light at a finite distance: uniform over the
//!   perpendicular to the light's direction        cone that the sphere subtends, from q
//!      | | | | |                                            q
//!      v v v v v                                           /|\
//!     -----------   disc of the sphere's radius           / | \
//!      ( group )                                         ( group )
//!   pdf = P(group) · P(light) · pdf(ω) / (π r²)   pdf = P(group) · pdf_A(q) / (2π (1 − cos θ))
//! ```
//!
//! The first hit of such a path must belong to its group, or the path ends. Every caustic path therefore has exactly
//! one pdf, known from its ends, which MIS with camera paths needs.

use std::f64::consts::{PI, TAU};

use crate::light::Receiver;
use crate::material::Material;
use crate::math::{Bounds, DVec2, DVec3, Frame, Ray};
use crate::sampler::{AliasTable, OwenSobol, SampleId, concentric_disk, uniform_sphere};
use crate::scene::emitters::NONE;
use crate::scene::scene::{NO_TRANSFORM, Primitive};
use crate::scene::{Scene, SurfaceInteraction};
use crate::shape::{Shape, ShapeHit};

/// No group.
pub const NO_GROUP: u32 = u32::MAX;

const MAX_GROUPS: usize = 64;

/// Light samples for the estimate of the light that arrives at a group.
const ESTIMATES: u32 = 64;

/// Primitives that focus light, within a sphere.
#[derive(Clone, Debug)]
struct Group {
    center: DVec3,
    radius: f64,
    /// The probability of choosing a delta light, and the choice among them.
    delta: f64,
    lights: AliasTable,
}

/// The caustic targets of a scene.
#[derive(Clone, Debug)]
pub struct CausticTargets {
    groups: Vec<Group>,
    choice: AliasTable,
    /// The group of each primitive.
    of_primitive: Vec<u32>,
    /// Indices of the delta lights.
    delta_lights: Vec<u32>,
    /// Rays from infinite lights start this far from a group's centre, and more.
    outside: f64,
}

/// The start of a light path.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// The ray, with unit direction.
    pub ray: Ray,
    /// The group at which it is aimed.
    pub group: u32,
    /// Its light source.
    pub from: Source,
}

/// The source of a light path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// An emissive shape; the ray starts on it.
    Shape,
    /// An environment or a directional light with an extent, by index.
    Infinite(u32),
    /// A delta light, by index, and the numbers that chose its point.
    Delta(u32, [f64; 2]),
}

impl CausticTargets {
    /// The targets of a scene that is otherwise prepared; `None` if no object focuses light, or nothing emits light.
    pub(crate) fn new(scene: &Scene) -> Option<CausticTargets> {
        let bounds = scene.stats.bounds?;
        if scene.emitters.is_empty() {
            return None;
        }
        let focusing: Vec<bool> =
            scene.materials.iter().map(|m| m.casts_caustics(&scene.materials)).collect();
        let mut members: Vec<(u32, Bounds)> = Vec::new();
        for (i, primitive) in scene.primitives.iter().enumerate() {
            if scene.focuses_light(primitive, &focusing)
                && let Some(bounds) = scene.static_bounds(primitive)
            {
                members.push((i as u32, bounds));
            }
        }
        let mut of_primitive = vec![NO_GROUP; if members.is_empty() { 0 } else { scene.primitives.len() }];
        let mut groups = Vec::new();
        let delta_lights: Vec<u32> =
            (0..scene.lights.len() as u32).filter(|i| scene.lights[*i as usize].is_delta()).collect();
        for part in split_into_groups(&mut members) {
            let bounds = part.iter().fold(Bounds::EMPTY, |all, (_, b)| all.union(b));
            let (center, mut radius) = (bounds.center(), 0.5 * bounds.size().length());
            if let [(one, _)] = part
                && let Shape::Sphere(_) = scene.primitives[*one as usize].shape
            {
                radius = 0.5 * bounds.size().max_element();
            }
            for (i, _) in part {
                of_primitive[*i as usize] = groups.len() as u32;
            }
            // Rounding must not exclude the edge.
            let radius = radius * (1.0 + 1e-6);
            groups.push(Group { center, radius, delta: 0.0, lights: AliasTable::default() });
        }
        groups.first()?;
        let mut caustic_targets = CausticTargets {
            groups,
            choice: AliasTable::default(),
            of_primitive,
            delta_lights,
            outside: bounds.size().length(),
        };
        let weights: Vec<f64> =
            (0..caustic_targets.groups.len()).map(|g| caustic_targets.prepare_lights(scene, g)).collect();
        caustic_targets.choose_by(&weights)?;
        Some(caustic_targets)
    }

    /// Prepares the choice of lights for a group; returns the estimated light that arrives in its sphere.
    fn prepare_lights(&mut self, scene: &Scene, g: usize) -> f64 {
        let group = &mut self.groups[g];
        let mut sampled_light = 0.0;
        for i in 0..ESTIMATES {
            let numbers = OwenSobol::new(&SampleId { x: g as u32, y: 0, index: i, seed: 0x5eed });
            let [u0, u1, u2, _] = numbers.four(0);
            let lit = scene.emitters.sample(scene, Receiver::from(group.center), [u0, u1, u2]);
            if let Some(lit) = lit.filter(|lit| !lit.is_delta) {
                let light = f64::from(lit.radiance.luminance()) / lit.pdf;
                sampled_light += if light.is_finite() { light } else { 0.0 };
            }
        }
        sampled_light /= f64::from(ESTIMATES);
        // The brightest of a few positions counts: a spot light may miss the centre.
        let positions = [DVec3::ZERO, DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
        let contribution = |light: &u32| {
            let at = |d: &DVec3| {
                let p = group.center + 0.7 * group.radius * *d;
                let lit = scene.lights[*light as usize].sample(p, [0.5, 0.5], *light);
                lit.map_or(0.0, |l| f64::from(l.radiance.luminance())).min(1e30)
            };
            positions.iter().map(at).fold(0.0, f64::max)
        };
        let mut weights: Vec<f64> = self.delta_lights.iter().map(contribution).collect();
        let delta: f64 = weights.iter().sum();
        // None gets probability 0: all sampled positions may be dark.
        let uniform = 0.1 * delta / weights.len().max(1) as f64;
        weights.iter_mut().for_each(|w| *w += uniform);
        group.delta = match (self.delta_lights.is_empty(), sampled_light > 0.0) {
            (true, _) => 0.0,
            (false, false) => 1.0,
            (false, true) => (delta / (delta + sampled_light)).clamp(0.1, 0.9),
        };
        group.lights = AliasTable::new(&weights).unwrap_or_default();
        (delta + sampled_light) * group.radius * group.radius
    }

    /// From here on chooses groups in proportion to these weights, each with a minimum probability; `None` if there
    /// are no groups, or all weights are 0.
    pub(crate) fn choose_by(&mut self, weights: &[f64]) -> Option<()> {
        let sum: f64 = weights.iter().filter(|w| w.is_finite()).sum();
        if sum <= 0.0 || !sum.is_finite() {
            return None;
        }
        let uniform = 0.1 / weights.len() as f64;
        let weights: Vec<f64> =
            weights.iter().map(|w| if w.is_finite() { w / sum } else { 0.0 } + uniform).collect();
        self.choice = AliasTable::new(&weights)?;
        Some(())
    }

    /// The probability with which a group is chosen.
    pub(crate) fn probability(&self, group: u32) -> f64 {
        self.choice.probability(group)
    }

    /// The number of groups.
    pub fn len(&self) -> usize {
        self.groups.len()
    }

    /// Whether there is no group.
    pub fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }

    /// The group of the object that was hit; [`NO_GROUP`] if it has none.
    #[inline]
    pub fn group(&self, surface: &SurfaceInteraction) -> u32 {
        self.of_primitive.get(surface.hit.primitive as usize).copied().unwrap_or(NO_GROUP)
    }

    /// The start of a light path: three numbers choose the group and the light, two the point on the light, two the
    /// direction.
    pub fn start(&self, scene: &Scene, choose: [f64; 3], place: [f64; 2], aim: [f64; 2]) -> Option<Start> {
        let (g, _, _) = self.choice.sample(choose[0]);
        let group = self.groups.get(g as usize)?;
        let (from, ray) = if choose[1] < group.delta {
            let (i, _, _) = group.lights.sample(choose[2]);
            let light = *self.delta_lights.get(i as usize)?;
            let from = Source::Delta(light, place);
            match scene.lights[light as usize].point(place) {
                Some(p) => (from, group.ray_from(p, aim)),
                None => {
                    let lit = scene.lights[light as usize].sample(group.center, place, light)?;
                    (from, group.ray_along(lit.to_light, aim, self.outside))
                }
            }
        } else {
            let lit = scene.emitters.sample(
                scene,
                Receiver::from(group.center),
                [place[0], place[1], choose[2]],
            )?;
            match (lit.is_delta, lit.finite) {
                (true, _) => return None,
                (false, true) => (Source::Shape, group.ray_from(group.center + lit.to_light, aim)),
                (false, false) => {
                    (Source::Infinite(lit.light), group.ray_along(lit.to_light, aim, self.outside))
                }
            }
        };
        ray.is_finite().then_some(Start { ray, group: g, from })
    }

    /// The pdf with which light paths start at a point of an emissive shape, per area, and leave in a unit direction,
    /// per solid angle.
    pub fn density_on_shape(&self, scene: &Scene, group: u32, at: &SurfaceInteraction) -> (f64, f64) {
        let Some(g) = self.groups.get(group as usize) else { return (0.0, 0.0) };
        let to_center = at.p - g.center;
        let d2 = to_center.length_squared();
        let chosen = scene.emitters.pdf_hit(scene, Receiver::from(g.center), at);
        let per_area = chosen * to_center.dot(at.ng).abs() / (d2 * d2.sqrt());
        (self.choice.probability(group) * (1.0 - g.delta) * per_area, g.density_from(at.p))
    }

    /// The pdf with which light paths come from an infinite light, per solid angle, and pass a point, per area
    /// perpendicular to the direction.
    pub fn infinite_pdf(&self, scene: &Scene, group: u32, light: u32, direction: DVec3) -> (f64, f64) {
        let Some(g) = self.groups.get(group as usize) else { return (0.0, 0.0) };
        let chosen = scene.emitters.infinite_one(scene, light, direction).map_or(0.0, |(_, pdf)| pdf);
        (self.choice.probability(group) * (1.0 - g.delta) * chosen, g.density_along())
    }

    /// The probability with which light paths come from a delta light, and their pdf: per solid angle from the point
    /// `from`, or per perpendicular area for a light at infinity.
    pub fn density_of_delta(&self, group: u32, light: u32, from: Option<DVec3>) -> (f64, f64) {
        let Some(g) = self.groups.get(group as usize) else { return (0.0, 0.0) };
        let Ok(i) = self.delta_lights.binary_search(&light) else { return (0.0, 0.0) };
        let chosen = self.choice.probability(group) * g.delta * g.lights.probability(i as u32);
        (chosen, from.map_or(g.density_along(), |p| g.density_from(p)))
    }
}

impl Group {
    /// A ray from a point through the sphere.
    fn ray_from(&self, p: DVec3, aim: [f64; 2]) -> Ray {
        let to_center = self.center - p;
        match self.cap(p) {
            Some(cap) => {
                let x = aim[0] * cap;
                let (cos, sin) = (1.0 - x, (x * (2.0 - x)).max(0.0).sqrt());
                let (s, c) = crate::math::elementary::sin_cos_turns(aim[1]);
                let frame = Frame::from_z(to_center.normalize());
                Ray::new(p, frame.to_world(DVec3::new(sin * c, sin * s, cos)))
            }
            None => Ray::new(p, uniform_sphere(DVec2::from(aim))),
        }
    }

    /// 1 − cos of the half angle that the sphere subtends at `p`; `None` from inside.
    fn cap(&self, p: DVec3) -> Option<f64> {
        let sin2 = self.radius * self.radius / (self.center - p).length_squared();
        (sin2 < 1.0).then(|| sin2 / (1.0 + (1.0 - sin2).sqrt()))
    }

    fn density_from(&self, p: DVec3) -> f64 {
        match self.cap(p) {
            Some(cap) => 1.0 / (TAU * cap),
            None => 0.25 / PI,
        }
    }

    /// A ray opposite to a direction, through the sphere's disc.
    fn ray_along(&self, to_light: DVec3, aim: [f64; 2], outside: f64) -> Ray {
        let to_light = to_light.normalize();
        let frame = Frame::from_z(to_light);
        let d = concentric_disk(DVec2::from(aim)) * self.radius;
        let far = outside + 2.0 * self.radius;
        Ray::new(self.center + d.x * frame.x + d.y * frame.y + far * to_light, -to_light)
    }

    fn density_along(&self) -> f64 {
        1.0 / (PI * self.radius * self.radius)
    }
}

/// Splits primitives at the median of their centres along the longest axis until there are `MAX_GROUPS` parts.
fn split_into_groups(members: &mut [(u32, Bounds)]) -> Vec<&[(u32, Bounds)]> {
    if members.is_empty() {
        return Vec::new();
    }
    let mut parts: Vec<&mut [(u32, Bounds)]> = vec![members];
    while parts.len() < MAX_GROUPS {
        // The largest part that can be split; the first among equals.
        let mut widest: Option<(usize, f64)> = None;
        for (i, part) in parts.iter().enumerate().filter(|(_, part)| part.len() > 1) {
            let size = part.iter().fold(Bounds::EMPTY, |all, (_, b)| all.union(b)).size().length();
            if widest.is_none_or(|(_, most)| size > most) {
                widest = Some((i, size));
            }
        }
        let Some((i, _)) = widest else { break };
        let part = parts.swap_remove(i);
        let positions = Bounds::of(part.iter().map(|(_, b)| b.center()));
        let axis = positions.size().max_position();
        part.sort_by(|a, b| a.1.center()[axis].total_cmp(&b.1.center()[axis]).then(a.0.cmp(&b.0)));
        let (low, high) = part.split_at_mut(part.len() / 2);
        parts.push(low);
        parts.push(high);
    }
    parts.into_iter().map(|part| &*part).collect()
}

impl Scene {
    /// Whether any material of a primitive focuses light.
    fn focuses_light(&self, primitive: &Primitive, focusing: &[bool]) -> bool {
        match &primitive.shape {
            Shape::Mesh(mesh) if primitive.faces != super::alpha_test::NO_FACES => {
                let count = mesh.data().triangles.len() as u32;
                (0..count).any(|part| {
                    let id = self.material_of(primitive, &ShapeHit { t: 0.0, part, u: 0.3, v: 0.3 });
                    focusing.get(id.index()).copied().unwrap_or(false)
                })
            }
            _ => {
                let id = self.material_of(primitive, &ShapeHit { t: 0.0, part: 0, u: 0.3, v: 0.3 });
                focusing.get(id.index()).copied().unwrap_or(false)
            }
        }
    }

    /// World-space bounds of a bounded primitive that does not move.
    fn static_bounds(&self, primitive: &Primitive) -> Option<Bounds> {
        if primitive.transform != NO_TRANSFORM
            && self.transforms[primitive.transform as usize].motion.is_some()
        {
            return None;
        }
        let bounds = primitive.shape.bounds()?;
        let placed = if primitive.transform == NO_TRANSFORM {
            bounds
        } else {
            bounds.transformed(&self.to_world(primitive))
        };
        (placed.is_finite() && !placed.is_empty()).then_some(placed)
    }
}

impl Material {
    /// Whether it, or a component of a mix, casts caustics.
    fn casts_caustics(&self, all: &[Material]) -> bool {
        match self {
            Material::OpenPbr(m) => m.casts_caustics,
            Material::Mix(m) => m.shares().any(|(id, weight)| {
                weight > 0.0 && all.get(id.index()).is_some_and(|m| m.casts_caustics(all))
            }),
            Material::Classic(_) | Material::Principled(..) => false,
        }
    }
}

const _: () = assert!(NONE == NO_GROUP);
