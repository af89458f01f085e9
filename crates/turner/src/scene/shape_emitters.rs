//! Emissive shapes, prepared for sampling.
//!
//! | shape | sampling |
//! |---|---|
//! | sphere, points of a cloud | cone of directions; under a transform, the cone in object space |
//! | rectangle, sides of a box | solid angle if near and right-angled, else area |
//! | disk, ring | area |
//! | cylinder, cone, torus | area in object space |
//! | triangles of a mesh | triangle by area × mean emission; then solid angle if near, else area |
//! | solids | cone of directions of the bounding sphere; a ray finds the point |
//! | plane, unbounded solids | not sampled; BSDF sampling only |

mod leaves;

use crate::light::emission::{
    Curved, CurvedEmitter, DiskEmitter, EllipsoidEmitter, EmitterSample, RectangleEmitter, SphereEmitter,
    TriangleEmitter,
};
use crate::math::{DAffine3, DVec3};
use crate::sampler::AliasTable;
use crate::scene::emitters::NONE;
use crate::scene::light_sample::{LightSample, NO_LIGHT};
use crate::scene::scene::{NO_TRANSFORM, Primitive};
use crate::scene::similarity::similarity;
use crate::scene::traced_emitter::{TracedEmitter, mean_of_parts};
use crate::scene::{Scene, SurfaceInteraction};
use crate::schema::MaterialId;
use crate::shape::{Points, ROUNDING, Shape, ShapeHit, Sphere, SurfacePoint, TriangleMesh};
use crate::texture::TexturePoint;

/// An emissive primitive, or one side of an emissive box.
#[derive(Clone, Debug)]
pub(crate) struct ShapeEmitter {
    primitive: u32,
    /// The side of a box.
    part: u32,
    form: Form,
    /// The largest absolute coordinate: rounding errors are proportional to it.
    reach: f64,
}

/// A shape that can be sampled in blocks of eight.
pub(crate) enum BlockShape<'a> {
    Rectangle(&'a RectangleEmitter),
    Sphere(&'a SphereEmitter),
    Triangle(OneTriangle),
}

/// A triangle of a mesh in world space, with the probability of choosing it once the mesh is chosen.
pub(crate) struct OneTriangle {
    pub(crate) corners: [DVec3; 3],
    /// 1, or −1 where a transform mirrors it.
    pub(crate) side: f64,
    pub(crate) part: u32,
    pub(crate) probability: f64,
}

#[derive(Clone, Debug)]
enum Form {
    Sphere(SphereEmitter),
    Ellipsoid(Box<EllipsoidEmitter>),
    Curved(Box<CurvedEmitter>),
    Traced(Box<TracedEmitter>),
    Rectangle(RectangleEmitter),
    Disk(DiskEmitter),
    /// Indices of the emissive triangles and the choice among them; `position` maps a triangle to its position in the
    /// choice.
    Mesh {
        triangles: Vec<u32>,
        position: Vec<u32>,
        choice: AliasTable,
    },
    /// The choice among the points of a cloud, by index; `one` is any of them, with the cloud's transform.
    Points {
        choice: AliasTable,
        one: Box<EllipsoidEmitter>,
    },
}

/// The emitters of a primitive, with their power divided by π.
pub(crate) fn shape_emitters(scene: &Scene, index: u32, primitive: &Primitive) -> Vec<(ShapeEmitter, f64)> {
    let to_world = scene.to_world(primitive);
    // Moving shapes are found by BSDF sampling only.
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
    // A mirroring transform reverses the orientation of edges, but not the outside.
    let mirrored = to_world.matrix3.determinant() < 0.0;
    let material = scene.material_of(primitive, &ShapeHit { t: 0.0, part: 0, u: 0.0, v: 0.0 });
    let brightness = match &primitive.shape {
        Shape::Solid(solid) => mean_of_parts(solid, |own| mean_emission(scene, own.unwrap_or(material))),
        _ => mean_emission(scene, material),
    };
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
    let single = |form: Form, area: f64| vec![(emitter(0, form), area * brightness)];
    let curved = |shape: Curved| match CurvedEmitter::new(shape, to_world) {
        Some(form) => single(Form::Curved(Box::new(form)), form.area()),
        None => Vec::new(),
    };
    if brightness <= 0.0 {
        return Vec::new();
    }
    match &primitive.shape {
        Shape::Sphere(s) => {
            if let Some(scale) = similarity(&to_world) {
                let form = SphereEmitter { center: point(s.center), radius: s.radius * scale };
                return single(Form::Sphere(form), form.area());
            }
            let sphere = SphereEmitter { center: s.center, radius: s.radius };
            match EllipsoidEmitter::new(sphere, to_world) {
                Some(form) => single(Form::Ellipsoid(Box::new(form)), form.area()),
                None => Vec::new(),
            }
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
            // All six or none: a hit finds its emitter by the index of the side.
            faces.unwrap_or_default()
        }
        Shape::Cylinder(s) => curved(Curved::Cylinder(**s)),
        Shape::Cone(s) => curved(Curved::Cone(**s)),
        Shape::Torus(s) => curved(Curved::Torus(**s)),
        Shape::Points(points) => {
            let form = points_form(scene, &primitive.shape, points, material, &to_world);
            form.map(|(form, power)| (emitter(0, form), power)).into_iter().collect()
        }
        Shape::Solid(_) => match TracedEmitter::new(&bounds, &to_world) {
            Some(form) => {
                let area = form.area();
                single(Form::Traced(Box::new(form)), area)
            }
            None => Vec::new(),
        },
        Shape::Plane(_) | Shape::Mesh(_) | Shape::Curves(_) => Vec::new(),
    }
}

/// Mean emission of a material, both sides summed. Textures are replaced by an estimate.
fn mean_emission(scene: &Scene, material: MaterialId) -> f64 {
    scene.materials.get(material.index()).map_or(0.0, |m| m.emission_estimate(scene))
}

/// The points of a cloud, weighted by area and emission.
fn points_form(
    scene: &Scene,
    shape: &Shape,
    points: &Points,
    material: MaterialId,
    to_world: &DAffine3,
) -> Option<(Form, f64)> {
    let material = scene.materials.get(material.index())?;
    let estimate = material.emission_estimate(scene);
    let emitter = |s: &Sphere| SphereEmitter { center: s.center, radius: s.radius };
    let one = EllipsoidEmitter::new(emitter(&points.spheres().next()?.1), *to_world)?;
    let mut weights = vec![0.0; points.spheres().map(|(i, _)| i as usize + 1).max()?];
    for (part, sphere) in points.spheres() {
        let mut brightness = estimate;
        if material.has_emission_texture() {
            // Two points of the texture. Never 0: it may be bright between them.
            brightness *= 0.1;
            let hit = ShapeHit { t: 0.0, part, u: 0.0, v: 0.0 };
            for n in [DVec3::Y, DVec3::Z] {
                let at = SurfacePoint { p: sphere.center + sphere.radius * n, error: 0.0, ng: n, ns: n };
                for outside in [true, false] {
                    let emitted =
                        material.emitted(scene, || TexturePoint::of_shape(shape, &hit, &at), outside);
                    brightness += 0.5 * f64::from(emitted.luminance());
                }
            }
        }
        weights[part as usize] = brightness * one.with(emitter(&sphere)).area();
    }
    let power = weights.iter().sum();
    Some((Form::Points { choice: AliasTable::new(&weights)?, one: Box::new(one) }, power))
}

/// The emissive triangles of a mesh.
fn mesh_form(scene: &Scene, index: u32, primitive: &Primitive, mesh: &TriangleMesh) -> Option<(Form, f64)> {
    if !scene.materials.iter().any(|m| m.is_emissive(scene)) {
        return None;
    }
    let (mut triangles, mut weights, mut position) = (Vec::new(), Vec::new(), Vec::new());
    for part in 0..mesh.data().triangles.len() as u32 {
        let hit = |u, v| ShapeHit { t: 0.0, part, u, v };
        let id = scene.material_of(primitive, &hit(0.3, 0.3));
        let material = &scene.materials[id.index()];
        if !material.is_emissive(scene) {
            continue;
        }
        let Some(form) = triangle(scene, index, mesh, part) else { continue };
        // Some points of the texture. Never 0: it may be bright between them.
        let mut brightness = 0.1 * material.emission_estimate(scene);
        if material.has_emission_texture() {
            const UV_POINTS: [(f64, f64); 4] = [(0.33, 0.33), (0.6, 0.2), (0.2, 0.6), (0.2, 0.2)];
            for (u, v) in UV_POINTS {
                let hit = hit(u, v);
                let at = TexturePoint::of_shape(&primitive.shape, &hit, &mesh.surface(&hit));
                for outside in [true, false] {
                    let emitted = material.emitted(scene, || at, outside);
                    brightness += 0.25 * f64::from(emitted.luminance());
                }
            }
        } else {
            brightness = material.emission_estimate(scene);
        }
        triangles.push(part);
        weights.push(brightness * form.area());
    }
    let choice = AliasTable::new(&weights)?;
    if triangles.len() != mesh.data().triangles.len() {
        position.resize(mesh.data().triangles.len(), NONE);
        for (i, part) in triangles.iter().enumerate() {
            position[*part as usize] = i as u32;
        }
    }
    let power = weights.iter().sum();
    Some((Form::Mesh { triangles, position, choice }, power))
}

/// A triangle of a mesh, in world space.
fn triangle(scene: &Scene, primitive: u32, mesh: &TriangleMesh, part: u32) -> Option<TriangleEmitter> {
    let (corners, side) = scene.corners(primitive, mesh, part)?;
    TriangleEmitter::new(corners, side)
}

/// The position of texture look-ups at a sample.
fn texture_point<'a>(
    scene: &'a Scene,
    primitive: &'a Primitive,
    s: &EmitterSample,
    hit: &ShapeHit,
) -> TexturePoint<'a> {
    let point = match &primitive.shape {
        Shape::Mesh(mesh) => mesh.surface(hit),
        _ => {
            let (p, n) = match primitive.transform {
                NO_TRANSFORM => (s.q, s.n),
                i => {
                    let t = &scene.transforms[i as usize];
                    (t.to_object.transform_point3(s.q), (t.to_world.matrix3.transpose() * s.n).normalize())
                }
            };
            SurfacePoint { p, error: 0.0, ng: n, ns: n }
        }
    };
    let mut at = TexturePoint::of_shape(&primitive.shape, hit, &point);
    at.to_world = scene.transforms.get(primitive.transform as usize).map(|placed| &placed.to_world);
    at
}

impl ShapeEmitter {
    /// Light that arrives at `p` from a point that `u` chooses: on the complete shape if `part` is [`NONE`], else on
    /// that triangle or point.
    pub(crate) fn sample(&self, scene: &Scene, p: DVec3, u: [f64; 3], part: u32) -> Option<LightSample> {
        let uv = [u[0], u[1]];
        let primitive = &scene.primitives[self.primitive as usize];
        let (s, part): (EmitterSample, u32) = match &self.form {
            Form::Sphere(f) => (f.sample(p, uv)?, 0),
            Form::Ellipsoid(f) => (f.sample(p, uv)?, 0),
            Form::Curved(f) => f.sample(p, uv)?,
            Form::Traced(f) => {
                let Shape::Solid(solid) = &primitive.shape else { return None };
                f.sample(solid, p, uv)?
            }
            Form::Points { choice, one } => {
                let Shape::Points(points) = &primitive.shape else { return None };
                let (part, probability) = match part {
                    NONE => choose(choice, u[2])?,
                    part => (part, 1.0),
                };
                let Sphere { center, radius } = points.sphere(part);
                let s = one.with(SphereEmitter { center, radius }).sample(p, uv)?;
                (EmitterSample { pdf: s.pdf * probability, ..s }, part)
            }
            Form::Rectangle(f) => (f.sample(p, uv)?, self.part),
            Form::Disk(f) => (f.sample(p, uv)?, 0),
            Form::Mesh { .. } => {
                let OneTriangle { corners, side, part, probability } = self.triangle(scene, part, u[2])?;
                let s = TriangleEmitter::new(corners, side)?.sample(p, uv)?;
                (EmitterSample { pdf: s.pdf * probability, ..s }, part)
            }
        };
        self.emit(scene, p, s, part)
    }

    /// Light that arrives at `p` from a sampled point.
    #[inline]
    pub(crate) fn emit(&self, scene: &Scene, p: DVec3, s: EmitterSample, part: u32) -> Option<LightSample> {
        let primitive = &scene.primitives[self.primitive as usize];
        let side = (p - s.q).dot(s.n);
        let hit = ShapeHit { t: 0.0, part, u: s.u, v: s.v };
        let material = &scene.materials[scene.material_of(primitive, &hit).index()];
        let radiance = material.emitted(scene, || texture_point(scene, primitive, &s, &hit), side >= 0.0);
        if radiance.is_black() {
            return None;
        }
        // The shadow ray ends just before the light.
        let end = s.q + s.n * (4.0 * ROUNDING * (self.reach + s.q.abs().max_element())).copysign(side);
        let (to_light, pdf, primitive) = (end - p, s.pdf, self.primitive);
        Some(LightSample {
            to_light,
            finite: true,
            radiance,
            pdf,
            is_delta: false,
            light: NO_LIGHT,
            primitive,
            part,
        })
    }

    /// The triangle of a mesh: `part`, or the one that `u` chooses if `part` is [`NONE`].
    #[inline]
    fn triangle(&self, scene: &Scene, part: u32, u: f64) -> Option<OneTriangle> {
        let Form::Mesh { triangles, choice, .. } = &self.form else { return None };
        let Shape::Mesh(mesh) = &scene.primitives[self.primitive as usize].shape else { return None };
        let (part, probability) = match part {
            NONE => {
                let (i, probability) = choose(choice, u)?;
                (*triangles.get(i as usize)?, probability)
            }
            part => (part, 1.0),
        };
        let (corners, side) = scene.corners(self.primitive, mesh, part)?;
        Some(OneTriangle { corners, side, part, probability })
    }

    /// The shape, if it can be sampled in blocks of eight; `part` and `u` choose the triangle of a mesh.
    #[inline]
    pub(crate) fn block_shape(&self, scene: &Scene, part: u32, u: f64) -> Option<BlockShape<'_>> {
        match &self.form {
            Form::Mesh { .. } => self.triangle(scene, part, u).map(BlockShape::Triangle),
            Form::Rectangle(f) => Some(BlockShape::Rectangle(f)),
            Form::Sphere(f) => Some(BlockShape::Sphere(f)),
            _ => None,
        }
    }

    /// The index of its primitive.
    pub(crate) fn primitive(&self) -> u32 {
        self.primitive
    }

    /// The side of a box; else 0.
    #[inline]
    pub(crate) fn part(&self) -> u32 {
        self.part
    }

    /// The pdf with which `sample` over the complete shape gives the direction from `p` to a hit of it.
    pub(crate) fn pdf(&self, scene: &Scene, p: DVec3, surface: &SurfaceInteraction) -> f64 {
        let chosen = match &self.form {
            Form::Points { choice, .. } | Form::Mesh { choice, .. } => {
                choice.probability(self.position(surface))
            }
            _ => 1.0,
        };
        if chosen > 0.0 { chosen * self.pdf_of_part(scene, p, surface) } else { 0.0 }
    }

    /// The pdf with which sampling the part that was hit gives the direction from `p`, once the part is chosen.
    pub(crate) fn pdf_of_part(&self, scene: &Scene, p: DVec3, surface: &SurfaceInteraction) -> f64 {
        let q = surface.p;
        match &self.form {
            Form::Sphere(f) => f.pdf(p, q, surface.ng),
            Form::Ellipsoid(f) => f.pdf(p, q, surface.ng),
            Form::Curved(f) => f.pdf(p, q, surface.ng),
            Form::Traced(f) => f.pdf(p),
            Form::Points { one, .. } => {
                let Shape::Points(points) = &scene.primitives[self.primitive as usize].shape else {
                    return 0.0;
                };
                let Sphere { center, radius } = points.sphere(surface.hit.shape.part);
                one.with(SphereEmitter { center, radius }).pdf(p, q, surface.ng)
            }
            Form::Rectangle(f) => f.pdf(p, q),
            Form::Disk(f) => f.pdf(p, q),
            Form::Mesh { .. } => {
                let primitive = &scene.primitives[self.primitive as usize];
                let Shape::Mesh(mesh) = &primitive.shape else { return 0.0 };
                let form = triangle(scene, self.primitive, mesh, surface.hit.shape.part);
                form.map_or(0.0, |form| form.pdf(p, q))
            }
        }
    }
}

/// The index that `u` chooses, and its probability.
fn choose(choice: &AliasTable, u: f64) -> Option<(u32, f64)> {
    if choice.is_empty() {
        return None;
    }
    let (i, probability, _) = choice.sample(u);
    Some((i, probability))
}
