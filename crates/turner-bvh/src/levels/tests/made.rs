//! Groups made at random, and the search without any tree.

use std::sync::{Arc, Mutex, PoisonError};

use super::super::matrix::{Affine, between, inverse64, rounded, scaled};
use super::super::*;
use crate::generate::Random;
use crate::motion::{MovingBvh, MovingTriangles, clamped};
use crate::oracle;
use crate::simd::Portable;
use crate::traverse::SearchRay;
use crate::{Aabb, BuildOptions, Bvh, Hit, Kernel, Ray, Triangles};

/// Runs a test on every kernel of this machine, one test at a time.
pub(crate) fn kernels(test: impl Fn(Kernel)) {
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let _guard = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    let before = Kernel::current();
    for kernel in Kernel::available() {
        assert!(kernel.force());
        test(kernel);
    }
    before.force();
}

/// A group and what it is made of.
pub(super) struct Made {
    pub(super) group: Arc<Group>,
    pub(super) inner: Vec<Thing>,
    pub(super) instances: Vec<Instance>,
    pub(super) ends: Vec<Affine>,
    pub(super) spheres: usize,
}

pub(super) enum Thing {
    Mesh(Arc<Bvh>),
    Moving(Arc<MovingBvh>, MovingMesh),
    Group(Box<Made>),
}

pub(super) struct MovingMesh {
    pub(super) start: Vec<[f32; 3]>,
    pub(super) end: Vec<[f32; 3]>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl MovingMesh {
    pub(super) fn triangles(&self) -> MovingTriangles<'_> {
        MovingTriangles { start: &self.start, end: &self.end, triangles: &self.triangles }
    }
}

impl Thing {
    pub(super) fn object(&self) -> Object {
        match self {
            Thing::Mesh(mesh) => Object::Mesh(Arc::clone(mesh)),
            Thing::Moving(mesh, _) => Object::Moving(Arc::clone(mesh)),
            Thing::Group(made) => Object::Group(Arc::clone(&made.group)),
        }
    }
}

impl Made {
    pub(super) fn new(
        inner: Vec<Thing>,
        instances: Vec<Instance>,
        ends: Vec<Affine>,
        spheres: usize,
    ) -> Made {
        let objects = inner.iter().map(Thing::object).collect();
        let boxes: Vec<Aabb> = (0..spheres).map(|i| Spheres::bounds(i as u32)).collect();
        let parts = GroupParts { instances: &instances, ends: &ends, boxes: &boxes };
        let group = Arc::new(Group::build(objects, &parts, &BuildOptions::default()).unwrap());
        Made { group, inner, instances, ends, spheres }
    }

    pub(super) fn numbers(&self) -> u32 {
        let of = |thing: &Thing| match thing {
            Thing::Group(made) => made.numbers() + u32::from(made.spheres > 0),
            _ => 1,
        };
        self.instances.iter().map(|i| of(&self.inner[i.object as usize])).sum()
    }

    /// The nearest hit, by looking at everything. t in the units of the ray.
    pub(super) fn brute(&self, ray: &Ray, base: u32, own: u32, outer: f32, visit: &impl Visit) -> Hit {
        let space = &self.group.space;
        let Some(search) = SearchRay::new(Portable, ray, space) else { return Hit::MISS };
        let mut best = Hit { t: search.t_max, ..Hit::MISS };
        let mut take = |hit: Hit| {
            let nearer = hit.t < best.t
                || hit.t == best.t && (hit.instance, hit.primitive) < (best.instance, best.primitive);
            if hit.is_hit() && nearer {
                best = hit;
            }
        };
        let to_caller = search.t_scale * outer;
        let mut number = base;
        for (i, instance) in self.instances.iter().enumerate() {
            let thing = &self.inner[instance.object as usize];
            let first = number;
            number += match thing {
                Thing::Group(made) => made.numbers() + u32::from(made.spheres > 0),
                _ => 1,
            };
            let matrix = match self.ends.get(i) {
                Some(end) => between(&instance.transform, end, clamped(ray.time)),
                None => instance.transform.map(|row| row.map(f64::from)),
            };
            let matrix = scaled(&matrix, f64::from(space.scale));
            let Some(m) = inverse64(&matrix).and_then(|m| rounded(&m)) else { continue };
            let ([x, y, z], [u, v, w]) = (search.origin, search.direction);
            let inside = Ray {
                origin: m.map(|r| r[0] * x + r[1] * y + r[2] * z + r[3]),
                direction: m.map(|r| r[0] * u + r[1] * v + r[2] * w),
                t_min: search.t_min,
                t_max: search.t_max,
                time: ray.time,
            };
            match thing {
                Thing::Mesh(mesh) => {
                    let all: Vec<_> = mesh
                        .blocks
                        .iter()
                        .flat_map(|b| (0..8).map(|lane| (b.ids[lane], b.lane(lane))))
                        .filter(|(id, _)| *id != u32::MAX)
                        .collect();
                    take(Hit { instance: first, ..oracle::closest(&all, &inside, &mesh.space) });
                }
                Thing::Moving(mesh, source) => {
                    let hit = crate::motion::tests::brute(&source.triangles(), mesh, &inside);
                    take(Hit { instance: first, ..hit });
                }
                Thing::Group(made) => {
                    take(made.brute(&inside, first, first + made.numbers(), to_caller, visit));
                }
            }
        }
        for sphere in 0..self.spheres as u32 {
            let back = space.unscale / to_caller;
            let outside = Ray {
                origin: search.origin.map(|x| x * space.unscale),
                direction: search.direction.map(|x| x * back),
                t_min: search.t_min * to_caller,
                t_max: search.t_max * to_caller,
                time: ray.time,
            };
            if let Some([t, u, v]) = visit.primitive(0, &outside, own, sphere) {
                take(Hit { t: t / to_caller, u, v, primitive: sphere, instance: own });
            }
        }
        search.finish(best)
    }
}

/// Own primitives, the same in all groups.
pub(super) struct Spheres;

impl Spheres {
    pub(super) fn get(i: u32) -> ([f32; 3], f32) {
        let mut random = Random::new(u64::from(i) + 77);
        (random.in_cube(), random.between(0.05, 0.4))
    }

    pub(super) fn bounds(i: u32) -> Aabb {
        let (center, radius) = Spheres::get(i);
        Aabb::new(center.map(|x| x - radius * 1.0001), center.map(|x| x + radius * 1.0001))
    }
}

impl Visit for Spheres {
    fn primitive(&self, _: u32, within: &Ray, _: u32, primitive: u32) -> Option<[f32; 3]> {
        let (center, radius) = Spheres::get(primitive);
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let o: [f64; 3] = std::array::from_fn(|i| f64::from(within.origin[i]) - f64::from(center[i]));
        let d = within.direction.map(f64::from);
        let (a, b) = (dot(d, d), -dot(o, d));
        let c = dot(o, o) - f64::from(radius) * f64::from(radius);
        let root = b * b - a * c;
        if root < 0.0 {
            return None;
        }
        let t = [(b - root.sqrt()) / a, (b + root.sqrt()) / a].map(|t| t as f32);
        let t = t.into_iter().find(|&t| within.t_min <= t && t <= within.t_max)?;
        Some([t, 0.25, 0.5])
    }
}

pub(super) fn mesh(random: &mut Random, count: usize) -> Thing {
    let mut positions = Vec::new();
    for _ in 0..count {
        let c = random.in_cube();
        for _ in 0..3 {
            let p = random.in_cube();
            positions.push([0, 1, 2].map(|i| c[i] + 0.3 * p[i]));
        }
    }
    let triangles: Vec<[u32; 3]> = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mesh = Triangles { positions: &positions, triangles: &triangles };
    Thing::Mesh(Arc::new(Bvh::build(&mesh, &BuildOptions::default()).unwrap()))
}

pub(super) fn moving_mesh(random: &mut Random, count: usize) -> Thing {
    let place = |random: &mut Random| (0..3 * count).map(|_| random.in_cube()).collect::<Vec<_>>();
    let source = MovingMesh {
        start: place(random),
        end: place(random),
        triangles: (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
    };
    let bvh = MovingBvh::build(&source.triangles(), &BuildOptions::default()).unwrap();
    Thing::Moving(Arc::new(bvh), source)
}

/// Turned, stretched, sheared, mirrored.
pub(super) fn transform(random: &mut Random, spread: f32) -> Affine {
    let x = random.direction();
    let y = random.direction();
    let z = random.direction();
    let size = [1.0, 0.1, 10.0, 1e-3, 1e3][(random.bits() % 5) as usize];
    let stretch = [random.between(0.3, 2.0), random.between(0.3, 2.0), random.between(-2.0, 2.0)];
    let center = random.in_cube();
    std::array::from_fn(|i| {
        [size * stretch[0] * x[i], size * stretch[1] * y[i], size * stretch[2] * z[i], spread * center[i]]
    })
}

pub(super) fn identity() -> Affine {
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]
}

pub(super) fn instances(random: &mut Random, count: usize, objects: usize, spread: f32) -> Vec<Instance> {
    let one = |random: &mut Random| Instance {
        object: (random.bits() % objects as u64) as u32,
        transform: transform(random, spread),
    };
    (0..count).map(|_| one(random)).collect()
}

/// Towards a point of an instance, from near and far; some are nonsense.
pub(super) fn rays(random: &mut Random, made: &Made, count: usize) -> Vec<Ray> {
    let targets: Vec<&Instance> = made.instances.iter().collect();
    (0..count)
        .map(|i| {
            let time = [0.0, 1.0, 0.5, random.unit(), -2.0, 9.0, f32::NAN][i % 7];
            let mut target = random.in_cube();
            if !targets.is_empty() && i % 4 != 0 {
                let p = random.in_cube().map(|x| 0.8 * x);
                let m = targets[i % targets.len()].transform;
                target = m.map(|r| r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3]);
            }
            let away = [0.0, 2.0, 30.0, 3000.0, 1e6][(random.bits() % 5) as usize];
            let from = random.in_cube();
            let origin: [f32; 3] = std::array::from_fn(|i| target[i] + (away + 1e-3) * from[i]);
            let length = [1.0, 1e-4, 0.1, 1e5][i / 3 % 4];
            let direction = std::array::from_fn(|i| (target[i] - origin[i]) * length);
            let mut ray = Ray { time, ..Ray::new(origin, direction) };
            match i % 23 {
                3 => ray.t_max = random.unit() / length,
                5 => ray.t_min = random.unit() / length,
                7 => ray.direction[i % 3] = 0.0,
                11 => ray.origin[i % 3] = f32::NAN,
                13 => ray.direction = [0.0; 3],
                17 => ray.direction[1] = f32::INFINITY,
                _ => {}
            }
            ray
        })
        .collect()
}

/// All four searches on all kernels; returns how many rays hit.
pub(super) fn check(made: &Made, rays: &[Ray]) -> usize {
    let group = &made.group;
    let expected: Vec<Hit> = rays.iter().map(|ray| made.brute(ray, 0, Hit::NONE, 1.0, &Spheres)).collect();
    kernels(|kernel| {
        let mut hits = vec![Hit::MISS; rays.len()];
        let mut any = vec![false; rays.len()];
        group.intersect_batch_with(rays, &mut hits, &Spheres);
        group.occluded_batch_with(rays, &mut any, &Spheres);
        for (i, ray) in rays.iter().enumerate() {
            let one = group.intersect_with(ray, &Spheres).unwrap_or(Hit::MISS);
            assert_eq!(one, expected[i], "{kernel} {i} {ray:?}");
            assert_eq!(hits[i], expected[i], "{kernel} {i} {ray:?}");
            assert_eq!(any[i], expected[i].is_hit(), "{kernel} {i} {ray:?}");
            assert_eq!(group.occluded_with(ray, &Spheres), any[i], "{kernel} {i} {ray:?}");
        }
    });
    expected.iter().filter(|h| h.is_hit()).count()
}

/// Groups in groups, with meshes, moving meshes, spheres and motion at every level.
pub(super) fn nested(random: &mut Random, levels: usize, moving: bool) -> Made {
    let mut things = vec![mesh(random, 12), moving_mesh(random, 6)];
    if levels > 1 {
        things.push(Thing::Group(Box::new(nested(random, levels - 1, !moving))));
        things.push(Thing::Group(Box::new(Made::new(Vec::new(), Vec::new(), Vec::new(), 1))));
    }
    let count = things.len();
    let instances: Vec<Instance> =
        (0..4 + levels).map(|i| Instance { object: (i % count) as u32, transform: gentle(random) }).collect();
    let ends = if moving {
        let mut ends: Vec<Affine> = instances.iter().map(|_| gentle(random)).collect();
        ends[0] = instances[0].transform;
        // Inside out on the way.
        ends[1] = instances[1].transform.map(|row| row.map(|x| -x));
        ends
    } else {
        Vec::new()
    };
    Made::new(things, instances, ends, levels % 3)
}

pub(super) fn gentle(random: &mut Random) -> Affine {
    let mut t = transform(random, 1.0);
    let size = t.iter().flat_map(|r| &r[..3]).fold(0.0_f32, |a, x| a.max(x.abs()));
    let to = random.between(0.3, 1.5) / size;
    t.iter_mut().flat_map(|r| &mut r[..3]).for_each(|x| *x *= to);
    t
}
