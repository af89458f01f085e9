//! All that shines in a scene, ready to be chosen from: lights, and shapes with an emissive material.
//!
//! | shape | sampled |
//! |---|---|
//! | sphere | by the cone it fills; with a transform that scales unevenly only hit by chance |
//! | rectangle, faces of a box | by solid angle where near and right-angled, else by area |
//! | disk, ring | by area |
//! | triangles of a mesh | chosen by area × mean emission; by solid angle where near, else by area |
//! | plane, cylinder, cone, torus, whatever moves | only hit by chance |
//!
//! "Only hit by chance" is right all the same, but noisier. A light is chosen with a probability half in proportion to
//! what it brings to the scene, half the same for all.

use super::desc::MaterialId;
use super::scene::{Hit, NO_TRANSFORM, Primitive, Scene, SurfaceInteraction};
use crate::color::Spectrum;
use crate::light::Light;
use crate::light::emission::{DiskEmitter, EmitterSample, RectangleEmitter, SphereEmitter, TriangleEmitter};
use crate::material::{Material, Physical};
use crate::math::{DAffine3, DVec3};
use crate::sampler::AliasTable;
use crate::shape::{ROUNDING, Shape, ShapeHit, SurfacePoint, TriangleMesh};

/// No emitter stands for a primitive.
const NONE: u32 = u32::MAX;

/// Light from one direction at a point.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Towards the light; for one with a place, as far as the light, so that a shadow ray ends at t = 1.
    pub to_light: DVec3,
    /// Whether the light has a place.
    pub finite: bool,
    /// Radiance; of lights that are a point or a direction, what arrives at a surface that faces them.
    pub radiance: Spectrum,
    /// Density per solid angle, the choice of the light included; of a point or a direction the probability of its choice.
    pub pdf: f64,
    /// Whether rays cannot hit the light by chance.
    pub is_delta: bool,
}

/// The lights of a scene.
#[derive(Debug, Default)]
pub struct Emitters {
    lights: Vec<Emitter>,
    choice: AliasTable,
    /// For each primitive its first emitter; empty if no shape shines.
    of_primitive: Vec<u32>,
    /// The numbers of the scene's lights that rays find which leave it: environments, and directional lights with an extent.
    around: Vec<u32>,
    /// Whether there is an environment.
    surrounded: bool,
}

#[derive(Debug)]
enum Emitter {
    /// One of the scene's lights.
    Light(u32),
    Shape(ShapeEmitter),
}

#[derive(Debug)]
struct ShapeEmitter {
    primitive: u32,
    /// The face of a box.
    part: u32,
    form: Form,
    /// The largest coordinate around: roundings go with it.
    reach: f64,
}

#[derive(Debug)]
enum Form {
    Sphere(SphereEmitter),
    Rectangle(RectangleEmitter),
    Disk(DiskEmitter),
    /// The triangles' numbers and the choice among them, by position; where each triangle stands in it is `place`.
    Mesh {
        triangles: Vec<u32>,
        place: Vec<u32>,
        choice: AliasTable,
    },
}

impl Emitters {
    /// Those of a scene that is otherwise ready.
    pub(super) fn new(scene: &Scene) -> Emitters {
        let mut emitters = Emitters::default();
        let mut weights = Vec::new();
        let bounds = scene.stats.bounds;
        let center = bounds.map_or(DVec3::ZERO, |b| b.center());
        let radius = bounds.map_or(1.0, |b| 0.5 * b.size().length()).max(1e-30);
        for (i, light) in scene.lights.iter().enumerate() {
            emitters.lights.push(Emitter::Light(i as u32));
            weights.push(light.reach(center, radius));
            let surrounds = matches!(light, Light::Environment(_));
            emitters.surrounded |= surrounds;
            if surrounds || matches!(light, Light::Directional(l) if l.is_disc()) {
                emitters.around.push(i as u32);
            }
        }
        for (i, primitive) in scene.primitives.iter().enumerate() {
            for (emitter, power) in shape_emitters(scene, i as u32, primitive) {
                if emitters.of_primitive.is_empty() {
                    emitters.of_primitive.resize(scene.primitives.len(), NONE);
                }
                let first = &mut emitters.of_primitive[i];
                if *first == NONE {
                    *first = emitters.lights.len() as u32;
                }
                emitters.lights.push(Emitter::Shape(emitter));
                // Per π of intensity, as that of the lights.
                weights.push(0.25 * power);
            }
        }
        let sum: f64 = weights.iter().filter(|w| w.is_finite()).sum();
        let even = 1.0 / weights.len().max(1) as f64;
        for w in &mut weights {
            *w = even + if sum > 0.0 && w.is_finite() { *w / sum } else { 0.0 };
        }
        if let Some(choice) = AliasTable::new(&weights) {
            emitters.choice = choice;
        } else {
            emitters.lights.clear();
            emitters.of_primitive.clear();
        }
        emitters
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.lights.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.lights.is_empty()
    }

    /// Light that arrives at `p`, by `u`: two numbers for the place on the light and one for the choice of the light.
    pub fn sample(&self, scene: &Scene, p: DVec3, u: [f64; 3]) -> Option<LightSample> {
        if self.lights.is_empty() {
            return None;
        }
        let (chosen, choice, left) = self.choice.sample(u[2]);
        match &self.lights[chosen as usize] {
            Emitter::Light(i) => {
                let lit = scene.lights[*i as usize].sample(p, [u[0], u[1]])?;
                Some(LightSample { pdf: lit.pdf * choice, ..lit })
            }
            Emitter::Shape(emitter) => {
                let lit = emitter.sample(scene, p, [u[0], u[1], left])?;
                Some(LightSample { pdf: lit.pdf * choice, ..lit })
            }
        }
    }

    /// The density with which `sample` at `p` gives the direction to a hit of a shape that shines; 0 if it never does.
    pub fn pdf_hit(&self, scene: &Scene, p: DVec3, surface: &SurfaceInteraction) -> f64 {
        let Hit { shape, primitive } = &surface.hit;
        let first = self.of_primitive.get(*primitive as usize).copied().unwrap_or(NONE);
        if first == NONE {
            return 0.0;
        }
        let face =
            if matches!(scene.primitives[*primitive as usize].shape, Shape::Box(_)) { shape.part } else { 0 };
        let index = first + face;
        let Some(Emitter::Shape(emitter)) = self.lights.get(index as usize) else { return 0.0 };
        self.choice.probability(index) * emitter.pdf(scene, p, surface)
    }

    /// Whether an environment stands in the background's place.
    pub fn surrounded(&self) -> bool {
        self.surrounded
    }

    /// What a ray finds that leaves the scene in a unit direction: for each light that is there its radiance and the density with which
    /// `sample` gives the direction.
    pub fn around<'a>(
        &'a self,
        scene: &'a Scene,
        direction: DVec3,
    ) -> impl Iterator<Item = (Spectrum, f64)> + 'a {
        self.around.iter().filter_map(move |&i| match scene.lights.get(i as usize) {
            // Lights stand before shapes: their numbers are those of the choice.
            Some(Light::Environment(l)) => {
                let (radiance, pdf) = l.found(direction);
                Some((radiance, self.choice.probability(i) * pdf))
            }
            Some(Light::Directional(l)) => {
                l.found(direction).map(|(radiance, pdf)| (radiance, self.choice.probability(i) * pdf))
            }
            _ => None,
        })
    }
}

/// What of a primitive shines, with its power (up to π).
fn shape_emitters(scene: &Scene, index: u32, primitive: &Primitive) -> Vec<(ShapeEmitter, f64)> {
    let to_world = scene.to_world(primitive);
    // What moves is found by chance.
    let moves = |i: u32| scene.transforms.get(i as usize).is_some_and(|t| t.motion.is_some());
    if moves(primitive.transform) {
        return Vec::new();
    }
    let Some(bounds) = primitive.shape.bounds() else { return Vec::new() };
    if bounds.is_empty() {
        return Vec::new();
    }
    let reach = bounds.transformed(&to_world);
    let reach = reach.min.abs().max(reach.max.abs()).max_element() + to_world.translation.abs().max_element();
    let point = |p: DVec3| to_world.transform_point3(p);
    let vector = |v: DVec3| to_world.transform_vector3(v);
    // A mirroring transform turns the order of a form's edges around, but not what is outside.
    let mirrored = to_world.matrix3.determinant() < 0.0;
    let material = scene.material_of(primitive, &ShapeHit { t: 0.0, part: 0, u: 0.0, v: 0.0 });
    let brightness = mean_emission(scene, material);
    let emitter = |part: u32, form: Form| ShapeEmitter { primitive: index, part, form, reach };
    let rectangle = |part: u32, corner: DVec3, u: DVec3, v: DVec3| {
        let side = if mirrored { -1.0 } else { 1.0 };
        let form = RectangleEmitter::new(point(corner), vector(u), vector(v), side)?;
        let power = form.area() * brightness;
        Some((emitter(part, Form::Rectangle(form)), power))
    };
    if let Shape::Mesh(mesh) = &primitive.shape {
        let form = mesh_form(scene, index, primitive, mesh);
        return form.map(|(form, power)| (emitter(0, form), power)).into_iter().collect();
    }
    if brightness <= 0.0 {
        return Vec::new();
    }
    match &primitive.shape {
        Shape::Sphere(s) => {
            let Some(scale) = similarity(&to_world) else { return Vec::new() };
            let form = SphereEmitter { center: point(s.center), radius: s.radius * scale };
            let power = form.area() * brightness;
            vec![(emitter(0, Form::Sphere(form)), power)]
        }
        Shape::Rectangle(r) => {
            let (corner, u, v) = r.corner_and_edges();
            rectangle(0, corner, u, v).into_iter().collect()
        }
        Shape::Disk(d) => {
            let (center, x, y, hole) = d.center_and_radii();
            let (x, y) = if mirrored { (y, x) } else { (x, y) };
            let form = DiskEmitter::new(point(center), vector(x), vector(y), hole);
            form.map(|form| (form.area() * brightness, form))
                .map(|(power, form)| (emitter(0, Form::Disk(form)), power))
                .into_iter()
                .collect()
        }
        Shape::Box(b) => {
            let size = b.max - b.min;
            let (x, y, z) = (DVec3::X * size.x, DVec3::Y * size.y, DVec3::Z * size.z);
            // By part: −x, +x, −y, +y, −z, +z, each with u × v outwards.
            let faces = [
                (b.min, z, y),
                (b.min + x, y, z),
                (b.min, x, z),
                (b.min + y, z, x),
                (b.min, y, x),
                (b.min + z, x, y),
            ];
            let faces: Option<Vec<_>> =
                faces.into_iter().zip(0..).map(|((c, u, v), part)| rectangle(part, c, u, v)).collect();
            // All six or none: a hit finds its face by its number.
            faces.unwrap_or_default()
        }
        _ => Vec::new(),
    }
}

/// The scale of a transform that keeps shapes similar.
fn similarity(to_world: &DAffine3) -> Option<f64> {
    let m = to_world.matrix3;
    let l2 = m.x_axis.length_squared();
    let even = |v: f64| (v - l2).abs() <= 1e-9 * l2;
    let square = |v: f64| v.abs() <= 1e-9 * l2;
    let similar = even(m.y_axis.length_squared())
        && even(m.z_axis.length_squared())
        && square(m.x_axis.dot(m.y_axis))
        && square(m.y_axis.dot(m.z_axis))
        && square(m.z_axis.dot(m.x_axis));
    similar.then_some(l2.sqrt())
}

/// A material's mean emission, both sides counted; textures by what they are in the middle of nowhere count as 1.
fn mean_emission(scene: &Scene, material: MaterialId) -> f64 {
    let Some(Material::Physical(m)) = scene.materials.get(material.index()) else { return 0.0 };
    m.emission_estimate()
}

/// The triangles of a mesh that shine.
fn mesh_form(scene: &Scene, index: u32, primitive: &Primitive, mesh: &TriangleMesh) -> Option<(Form, f64)> {
    let shines = |m: &Material| matches!(m, Material::Physical(m) if m.is_emissive());
    if !scene.materials.iter().any(shines) {
        return None;
    }
    let (mut triangles, mut weights, mut place) = (Vec::new(), Vec::new(), Vec::new());
    for part in 0..mesh.data().triangles.len() as u32 {
        let hit = |u, v| ShapeHit { t: 0.0, part, u, v };
        let id = scene.material_of(primitive, &hit(0.3, 0.3));
        let Material::Physical(material) = &scene.materials[id.index()] else { continue };
        if !material.is_emissive() {
            continue;
        }
        let Some(form) = triangle(scene, index, mesh, part) else { continue };
        // Some places of the texture; never 0, for what lies between them may be bright.
        let mut brightness = 0.1 * material.emission_estimate();
        if material.has_emission_texture() {
            const PLACES: [(f64, f64); 4] = [(0.33, 0.33), (0.6, 0.2), (0.2, 0.6), (0.2, 0.2)];
            for (u, v) in PLACES {
                let hit = hit(u, v);
                let at = primitive.shape.texture_point(&hit, &mesh.surface(&hit));
                brightness += 0.25 * material.emitted(scene, &at).luminance() as f64 * material.sides();
            }
        } else {
            brightness = material.emission_estimate();
        }
        triangles.push(part);
        weights.push(brightness * form.area());
    }
    let choice = AliasTable::new(&weights)?;
    if triangles.len() != mesh.data().triangles.len() {
        place.resize(mesh.data().triangles.len(), NONE);
        for (i, part) in triangles.iter().enumerate() {
            place[*part as usize] = i as u32;
        }
    }
    let power = weights.iter().sum();
    Some((Form::Mesh { triangles, place, choice }, power))
}

/// A triangle of a mesh, in the scene.
fn triangle(scene: &Scene, primitive: u32, mesh: &TriangleMesh, part: u32) -> Option<TriangleEmitter> {
    let (corners, side) = scene.corners(primitive, mesh, part)?;
    TriangleEmitter::new(corners, side)
}

impl ShapeEmitter {
    fn sample(&self, scene: &Scene, p: DVec3, u: [f64; 3]) -> Option<LightSample> {
        let uv = [u[0], u[1]];
        let primitive = &scene.primitives[self.primitive as usize];
        let (s, part): (EmitterSample, u32) = match &self.form {
            Form::Sphere(f) => (f.sample(p, uv)?, 0),
            Form::Rectangle(f) => (f.sample(p, uv)?, self.part),
            Form::Disk(f) => (f.sample(p, uv)?, 0),
            Form::Mesh { triangles, choice, .. } => {
                let Shape::Mesh(mesh) = &primitive.shape else { return None };
                let (i, probability, _) = choice.sample(u[2]);
                let part = *triangles.get(i as usize)?;
                let form = triangle(scene, self.primitive, mesh, part)?;
                let s = form.sample(p, uv)?;
                (EmitterSample { pdf: s.pdf * probability, ..s }, part)
            }
        };
        let side = (p - s.q).dot(s.n);
        let hit = ShapeHit { t: 0.0, part, u: s.u, v: s.v };
        let Material::Physical(material) = &scene.materials[scene.material_of(primitive, &hit).index()]
        else {
            return None;
        };
        if side < 0.0 && !material.shines_backwards() {
            return None;
        }
        let radiance = self.emitted(scene, primitive, material, &s, &hit);
        if radiance.is_black() {
            return None;
        }
        // The shadow ray ends before the light.
        let end = s.q + s.n * (4.0 * ROUNDING * (self.reach + s.q.abs().max_element())).copysign(side);
        Some(LightSample { to_light: end - p, finite: true, radiance, pdf: s.pdf, is_delta: false })
    }

    fn emitted(
        &self,
        scene: &Scene,
        primitive: &Primitive,
        material: &Physical,
        s: &EmitterSample,
        hit: &ShapeHit,
    ) -> Spectrum {
        if let Some(constant) = material.constant_emission() {
            return constant;
        }
        let point = match &primitive.shape {
            Shape::Mesh(mesh) => mesh.surface(hit),
            _ => {
                let (p, n) = match primitive.transform {
                    NO_TRANSFORM => (s.q, s.n),
                    i => {
                        let t = &scene.transforms[i as usize];
                        (
                            t.to_object.transform_point3(s.q),
                            (t.to_world.matrix3.transpose() * s.n).normalize(),
                        )
                    }
                };
                SurfacePoint { p, error: 0.0, ng: n, ns: n }
            }
        };
        material.emitted(scene, &primitive.shape.texture_point(hit, &point))
    }

    fn pdf(&self, scene: &Scene, p: DVec3, surface: &SurfaceInteraction) -> f64 {
        let q = surface.p;
        match &self.form {
            Form::Sphere(f) => f.pdf(p, q, surface.ng),
            Form::Rectangle(f) => f.pdf(p, q),
            Form::Disk(f) => f.pdf(p, q),
            Form::Mesh { place, choice, .. } => {
                let primitive = &scene.primitives[self.primitive as usize];
                let Shape::Mesh(mesh) = &primitive.shape else { return 0.0 };
                let part = surface.hit.shape.part;
                let place =
                    if place.is_empty() { part } else { place.get(part as usize).copied().unwrap_or(NONE) };
                let form = triangle(scene, self.primitive, mesh, part);
                form.map_or(0.0, |form| choice.probability(place) * form.pdf(p, q))
            }
        }
    }
}

impl Light {
    /// Light that arrives at `p`; the place on it by `u`. The density is 1 for lights that rays cannot hit.
    fn sample(&self, p: DVec3, u: [f64; 2]) -> Option<LightSample> {
        if let Light::Environment(l) = self {
            let s = l.sample(u)?;
            return Some(LightSample {
                to_light: s.direction,
                finite: false,
                radiance: s.radiance,
                pdf: s.pdf,
                is_delta: false,
            });
        }
        if let Light::Directional(l) = self
            && let Some((to_light, radiance, pdf)) = l.sample(u)
        {
            return Some(LightSample { to_light, finite: false, radiance, pdf, is_delta: false });
        }
        let lit = self.illuminate_at(p, u)?;
        let to_light = if lit.finite { lit.to_light } else { lit.to_light.normalize() };
        Some(LightSample { to_light, finite: lit.finite, radiance: lit.intensity, pdf: 1.0, is_delta: true })
    }

    /// What it brings to a scene, to choose by.
    fn reach(&self, center: DVec3, radius: f64) -> f64 {
        const DIRECTIONS: [DVec3; 7] =
            [DVec3::ZERO, DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
        if let Light::Environment(l) = self {
            // On a surface that faces all of it a quarter arrives.
            return 0.25 * f64::from(l.power().luminance()) * std::f64::consts::PI * radius * radius;
        }
        let arrives = |d: DVec3| {
            let lit = self.illuminate_at(center + 0.7 * radius * d, [0.5, 0.5]);
            lit.map_or(0.0, |l| f64::from(l.intensity.luminance()))
        };
        let mut values = DIRECTIONS.map(arrives);
        // One place may be next to the light.
        values.sort_by(f64::total_cmp);
        let trimmed: f64 = values[..6].iter().sum();
        trimmed / 6.0 * std::f64::consts::PI * radius * radius
    }
}

impl Scene {
    fn to_world(&self, primitive: &Primitive) -> DAffine3 {
        match primitive.transform {
            NO_TRANSFORM => DAffine3::IDENTITY,
            i => self.transforms[i as usize].to_world,
        }
    }
}
