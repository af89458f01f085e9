//! The oracle for the renderer: slow, literal transcriptions of the classic documents' pseudocode in double
//! precision. They are recursive, use brute force and share only the scene description with the renderer.

use turner::camera::{CameraDesc, Handedness, Viewport};
use turner::description::{ObjectContent, SceneDesc};
use turner::light::LightDesc;
use turner::material::MaterialDesc;
use turner::math::DVec3 as V;
use turner::schema::ColorSource;
use turner::shape::ShapeDesc;

pub(crate) const INF: f64 = f64::INFINITY;

#[derive(Clone, Copy)]
pub(crate) enum Form {
    Sphere { center: V, radius: f64 },
    Plane { point: V, normal: V },
}

#[derive(Clone, Copy)]
pub(crate) struct Object {
    pub(crate) form: Form,
    pub(crate) color: V,
    pub(crate) ka: f64,
    pub(crate) kd: f64,
    pub(crate) ks: f64,
    pub(crate) n: f64,
    pub(crate) kr: f64,
    pub(crate) kt: f64,
    pub(crate) ior: f64,
}

#[derive(Clone, Copy)]
pub(crate) enum Light {
    Point {
        position: V,
        color: V,
    },
    /// `from` as written, not normalised, as in document 004.
    Directional {
        from: V,
        color: V,
    },
}

pub(crate) struct World {
    pub(crate) objects: Vec<Object>,
    pub(crate) lights: Vec<Light>,
    pub(crate) ambient: V,
    pub(crate) background: V,
    pub(crate) eye: V,
    pub(crate) look: V,
    pub(crate) up: V,
    pub(crate) left_handed: bool,
    pub(crate) screen: (f64, f64),
    pub(crate) distance: f64,
    pub(crate) corner: bool,
    pub(crate) width: u32,
    pub(crate) height: u32,
}

fn rgb(c: turner::color::Spectrum) -> V {
    V::new(f64::from(c.r), f64::from(c.g), f64::from(c.b))
}

impl World {
    /// Reads a description with spheres, planes, point and directional lights.
    pub(crate) fn of(desc: &SceneDesc) -> World {
        let objects = desc
            .objects
            .iter()
            .map(|o| {
                let ObjectContent::Shape(shape) = &o.content else { panic!("no instances here") };
                let form = match shape {
                    ShapeDesc::Sphere(s) => Form::Sphere { center: s.center, radius: s.radius },
                    ShapeDesc::Plane(p) => Form::Plane { point: p.point, normal: p.normal.normalize() },
                    other => panic!("{other:?}"),
                };
                let MaterialDesc::Classic(m) = &desc.materials[o.material.unwrap().index()].value else {
                    panic!("a classic scene has classic materials");
                };
                let ColorSource::Constant(color) = m.color else { panic!("no textures here") };
                let n = m.shininess;
                Object {
                    form,
                    color: rgb(color),
                    ka: m.ka,
                    kd: m.kd,
                    ks: m.ks,
                    n,
                    kr: m.k_reflect,
                    kt: m.k_refract,
                    ior: m.ior,
                }
            })
            .collect();
        let (mut lights, mut ambient) = (Vec::new(), V::ZERO);
        for light in &desc.lights {
            match &light.value {
                LightDesc::Ambient(l) => ambient += rgb(l.color) * l.intensity,
                LightDesc::Point(l) => {
                    lights.push(Light::Point { position: l.position, color: rgb(l.color) * l.intensity })
                }
                LightDesc::Directional(l) => {
                    lights.push(Light::Directional {
                        from: l.from.unwrap(),
                        color: rgb(l.color) * l.intensity,
                    });
                }
                other => panic!("{other:?}"),
            }
        }
        let CameraDesc::Pinhole(c) = &desc.camera.as_ref().unwrap().value else { panic!("pinhole") };
        let Some(Viewport::Size(size)) = c.viewport else { panic!("viewport") };
        World {
            objects,
            lights,
            ambient,
            background: rgb(desc.background.color),
            eye: c.position,
            look: c.look_at,
            up: c.up,
            left_handed: c.handedness == Handedness::Left,
            screen: (size.x, size.y),
            distance: c.distance.unwrap_or((c.look_at - c.position).length()),
            corner: desc.film.pixel_sample == turner::film::PixelSample::Corner,
            width: desc.film.width,
            height: desc.film.height,
        }
    }

    /// The direction from the camera to the sample position on the screen (not normalised).
    pub(crate) fn direction(&self, x: u32, y: u32) -> V {
        let forward = (self.look - self.eye).normalize();
        let right =
            if self.left_handed { self.up.cross(forward) } else { forward.cross(self.up) }.normalize();
        let up = if self.left_handed { forward.cross(right) } else { right.cross(forward) };
        let (w, h) = (f64::from(self.width), f64::from(self.height));
        let (px, py) = if self.corner { (0.0, 1.0) } else { (0.5, 0.5) };
        let sx = ((f64::from(x) + px) - w / 2.0) * self.screen.0 / w;
        let sy = (h / 2.0 - (f64::from(y) + py)) * self.screen.1 / h;
        forward * self.distance + right * sx + up * sy
    }
}

impl Object {
    /// All intersections t of the line, by the textbook formulas.
    pub(crate) fn roots(&self, o: V, d: V) -> Vec<f64> {
        match self.form {
            Form::Sphere { center, radius } => {
                let oc = o - center;
                let (a, b, c) = (d.dot(d), 2.0 * oc.dot(d), oc.dot(oc) - radius * radius);
                let q = b * b - 4.0 * a * c;
                if q < 0.0 { vec![] } else { vec![(-b - q.sqrt()) / (2.0 * a), (-b + q.sqrt()) / (2.0 * a)] }
            }
            Form::Plane { point, normal } => {
                let along = d.dot(normal);
                if along == 0.0 { vec![] } else { vec![(point - o).dot(normal) / along] }
            }
        }
    }

    pub(crate) fn normal(&self, p: V) -> V {
        match self.form {
            Form::Sphere { center, .. } => (p - center).normalize(),
            Form::Plane { normal, .. } => normal,
        }
    }
}

/// The closest object with t in `min..max`.
pub(crate) fn closest(w: &World, o: V, d: V, min: f64, max: f64) -> Option<(f64, &Object)> {
    let mut best: Option<(f64, &Object)> = None;
    for object in &w.objects {
        for t in object.roots(o, d) {
            if t > min && t < max && best.is_none_or(|(b, _)| t < b) {
                best = Some((t, object));
            }
        }
    }
    best
}

fn shadowed(w: &World, p: V, to_light: V, max: f64) -> bool {
    closest(w, p, to_light, 1e-6 / to_light.length().min(1.0), max).is_some()
}

fn light_at(light: &Light, p: V) -> (V, V, f64) {
    match *light {
        Light::Point { position, color } => (position - p, color, 1.0),
        Light::Directional { from, color } => (from, color, INF),
    }
}

fn mirror(d: V, n: V) -> V {
    d - 2.0 * d.dot(n) * n
}

/// Refraction by the paper's formula: T = [r(N·I) − (1 − r²(1 − (N·I)²))^½] N − r·I, with I towards the viewer;
/// `None` beyond the critical angle.
fn bend(d: V, outward: V, ior: f64) -> Option<V> {
    let i = -d;
    let (n, r) = if outward.dot(i) > 0.0 { (outward, 1.0 / ior) } else { (-outward, ior) };
    let c = n.dot(i);
    let k = 1.0 - r * r * (1.0 - c * c);
    if k < 0.0 { None } else { Some((r * c - k.sqrt()) * n - r * i) }
}

/// The origin of a secondary ray: slightly off the surface, on the side of its direction.
fn off(p: V, n: V, d: V) -> V {
    p + n * (1e-9 * d.dot(n).signum())
}

/// Document 000, `intensity`.
pub(crate) fn document_000(w: &World, o: V, d: V, depth: u32) -> V {
    let depth = depth + 1;
    if depth > 5 {
        return w.background;
    }
    let Some((t, object)) = closest(w, o, d, 0.0, INF) else {
        for light in &w.lights {
            if let Light::Directional { from, color } = *light
                && d.normalize().dot(from.normalize()) >= (0.25f64).to_radians().cos()
            {
                return color;
            }
        }
        return w.background;
    };
    let p = o + t * d;
    let outward = object.normal(p);
    let n = if outward.dot(d) > 0.0 { -outward } else { outward };
    let mut spec = V::ZERO;
    if object.kr > 0.0 {
        let flec = mirror(d, n);
        spec = object.kr * document_000(w, off(p, n, flec), flec, depth);
    }
    let mut refr = V::ZERO;
    if object.kt > 0.0 {
        let frac = bend(d, outward, object.ior).unwrap_or_else(|| mirror(d, n));
        refr = object.kt * document_000(w, off(p, n, frac), frac, depth);
    }
    let mut dull = object.kd * w.ambient * object.color;
    for light in &w.lights {
        let (to, color, max) = light_at(light, p);
        if !shadowed(w, off(p, n, to), to, max) {
            dull += object.kd * color * n.dot(to.normalize()).max(0.0) * object.color;
        }
    }
    spec + refr + dull
}

/// Ambient, diffuse and highlight of documents 001 to 003 ("the equation from the previous page").
fn phong(w: &World, object: &Object, p: V, n: V, d: V) -> V {
    let mut local = object.ka * w.ambient * object.color;
    for light in &w.lights {
        let (to, color, max) = light_at(light, p);
        if shadowed(w, off(p, n, to), to, max) {
            continue;
        }
        let l = to.normalize();
        local += object.kd * color * object.color * n.dot(l).max(0.0);
        if object.ks > 0.0 {
            let r = 2.0 * n.dot(l) * n - l;
            local += object.ks * color * r.dot(-d).max(0.0).powf(object.n);
        }
    }
    local
}

/// Documents 001 (`beyond` and `miss` are black or the sky colour) and 002 (k1, k2, k3 = 1 − r − τ, r, τ).
pub(crate) fn document_001(w: &World, o: V, d: V, left: u32) -> V {
    let Some((t, object)) = closest(w, o, d, 0.0, INF) else { return w.background };
    let p = o + t * d;
    let outward = object.normal(p);
    let n = if outward.dot(d) > 0.0 { -outward } else { outward };
    let local = phong(w, object, p, n, d);
    let (mut r, mut tau) = (object.kr, object.kt);
    let mut refracted = V::ZERO;
    if tau > 0.0 {
        match bend(d, outward, object.ior) {
            Some(direction) if left > 0 => {
                refracted = document_001(w, off(p, n, direction), direction, left - 1)
            }
            Some(_) => {}
            None => {
                r += tau;
                tau = 0.0;
            }
        }
    }
    let mut reflected = V::ZERO;
    if r > 0.0 && left > 0 {
        let direction = mirror(d, n);
        reflected = document_001(w, off(p, n, direction), direction, left - 1);
    }
    (1.0 - r - tau) * local + r * reflected + tau * refracted
}

/// Document 003, `Raytrace`. The document does not limit the recursion; here it returns black after `left` more rays.
pub(crate) fn document_003(w: &World, o: V, d: V, left: u32) -> V {
    let mut colour = V::ZERO;
    let Some((t, object)) = closest(w, o, d, 0.0, INF) else { return colour };
    let p = o + t * d;
    let outward = object.normal(p);
    let n = if outward.dot(d) > 0.0 { -outward } else { outward };
    if object.kr > 0.0 && left > 0 {
        let direction = mirror(d, n);
        colour += object.kr * document_003(w, off(p, n, direction), direction, left - 1);
    }
    if object.kt > 0.0 && left > 0 {
        let direction = bend(d, outward, object.ior).unwrap_or_else(|| mirror(d, n));
        colour += object.kt * document_003(w, off(p, n, direction), direction, left - 1);
    }
    colour + phong(w, object, p, n, d)
}

/// Document 004, `TraceRay`: spheres only. D is not normalised; t starts at 1 for camera rays and at 0.001 for
/// others.
pub(crate) fn document_004(w: &World, o: V, d: V, t_min: f64, depth: u32) -> V {
    let Some((t, object)) = closest(w, o, d, t_min, INF) else { return w.background };
    let p = o + t * d;
    let n = object.normal(p);
    let v = -d;
    let mut i = w.ambient;
    for light in &w.lights {
        let (l, color, max) = light_at(light, p);
        if closest(w, p, l, 0.001, max).is_some() {
            continue;
        }
        let n_dot_l = n.dot(l);
        if n_dot_l > 0.0 {
            i += color * n_dot_l / (n.length() * l.length());
        }
        if object.ks > 0.0 {
            let r = 2.0 * n * n.dot(l) - l;
            let r_dot_v = r.dot(v);
            if r_dot_v > 0.0 {
                i += color * (r_dot_v / (r.length() * v.length())).powf(object.n);
            }
        }
    }
    let local = object.color * i;
    let r = object.kr;
    if depth == 0 || r <= 0.0 {
        return local;
    }
    let reflected = document_004(w, p, 2.0 * n * n.dot(v) - v, 0.001, depth - 1);
    local * (1.0 - r) + reflected * r
}
