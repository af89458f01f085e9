//! Solids as cases of the tests that all shapes share.

use std::sync::Arc;

use super::*;
use crate::math::DVec2;
use crate::schema::{GridData, GridFile};
use crate::shape::testing::{Case, sheet, solid};
use crate::shape::{BoxDesc, MeshCache, PlaneDesc, ShapeDesc, SphereDesc};

pub(in crate::shape) fn prepare(desc: ShapeDesc) -> crate::shape::Shape {
    desc.prepare(&mut MeshCache::new(&[])).unwrap()
}

/// A part without material.
pub(in crate::shape) fn part(shape: ShapeDesc) -> CsgPart {
    CsgPart { shape, ..CsgPart::default() }
}

pub(in crate::shape) fn sphere(center: DVec3, radius: f64) -> ShapeDesc {
    ShapeDesc::Sphere(SphereDesc { center, radius })
}

pub(in crate::shape) fn cuboid(min: DVec3, max: DVec3) -> ShapeDesc {
    ShapeDesc::Box(BoxDesc { min: Some(min), max: Some(max), center: None, size: None })
}

fn csg() -> Vec<Case> {
    let (a, b) = (DVec3::new(0.3, -0.2, 0.1), DVec3::new(-0.2, 0.3, 0.3));
    let (low, high) = (DVec3::new(-0.7, -0.6, -0.5), DVec3::new(0.5, 0.6, 0.7));
    let ball = move |p: DVec3| p.distance(a) - 0.8;
    let other = move |p: DVec3| p.distance(b) - 0.6;
    let block = move |p: DVec3| (low - p).max(p - high).max_element();
    let parts = || vec![part(cuboid(low, high)), part(sphere(a, 0.8)), part(sphere(b, 0.6))];
    let n = DVec3::new(1.0, 2.0, -1.0);
    let half = ShapeDesc::Plane(PlaneDesc { point: a, normal: n });
    vec![
        Case {
            name: "union",
            shape: prepare(ShapeDesc::Union(UnionDesc { parts: parts() })),
            sheets: solid(move |p| block(p).min(ball(p)).min(other(p))),
        },
        Case {
            name: "intersection",
            shape: prepare(ShapeDesc::Intersection(IntersectionDesc { parts: parts() })),
            sheets: solid(move |p| block(p).max(ball(p)).max(other(p))),
        },
        Case {
            name: "difference",
            shape: prepare(ShapeDesc::Difference(DifferenceDesc { parts: parts() })),
            sheets: solid(move |p| block(p).max(-ball(p)).max(-other(p))),
        },
        Case {
            name: "clipped",
            shape: prepare(ShapeDesc::Clipped(ClippedDesc { parts: vec![part(sphere(a, 0.8)), part(half)] })),
            sheets: sheet(ball, move |p| (p - a).dot(n) < 0.0),
        },
    ]
}

/// A function divided by the length of its gradient: near its zeros, the distance from them.
fn distance_like(f: impl Fn(DVec3) -> f64 + Clone + 'static) -> impl Fn(DVec3) -> f64 + Clone + 'static {
    move |p| {
        let h = 1e-5;
        let slope = |e: DVec3| (f(p + h * e) - f(p - h * e)) / (2.0 * h);
        f(p) / DVec3::from(DVec3::AXES.map(slope)).length()
    }
}

/// A bent egg that leaves the box. The oracle interpolates in its own way.
fn distance_grid(min: DVec3, max: DVec3) -> Case {
    const N: usize = 8;
    let at = |i: usize| {
        min + (max - min) * DVec3::new((i % N) as f64, (i / N % N) as f64, (i / N / N) as f64) / 7.0
    };
    let bent = |p: DVec3| p.distance(DVec3::new(0.4, 0.1, 0.0)) - 0.7 + 0.3 * p.x * p.y - 0.2 * p.z * p.z;
    let values: Vec<f32> = (0..N * N * N).map(|i| bent(at(i)) as f32).collect();
    let data = GridData::of_distances([N as u32; 3], values.clone()).unwrap();
    let interpolated = move |p: DVec3| {
        let q = 7.0 * (p.clamp(min, max) - min) / (max - min);
        let first = q.floor().min(DVec3::splat(6.0));
        let corner = |i: usize| {
            let offset = DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64);
            let weight = (DVec3::ONE - (q - first - offset).abs()).to_array().iter().product::<f64>();
            let [x, y, z] = (first + offset).to_array().map(|v| v as usize);
            weight * f64::from(values[x + N * (y + N * z)])
        };
        (0..8).map(corner).sum()
    };
    let value = distance_like(interpolated);
    let cube = move |p: DVec3| (min - p).max(p - max).max_element();
    Case {
        name: "distance_grid",
        shape: prepare(ShapeDesc::DistanceGrid(DistanceGridDesc {
            file: GridFile { uri: String::new(), data: Arc::new(data) },
            min: Some(min),
            max: Some(max),
            smooth: false,
            ..DistanceGridDesc::default()
        })),
        sheets: solid(move |p| value(p).max(cube(p))),
    }
}

fn curved() -> Vec<Case> {
    use crate::math::elementary::pow;
    let (squared, products) = (DVec3::new(1.0, 1.5, 0.7), DVec3::new(0.2, 0.1, -0.3));
    let linear = DVec3::new(0.1, -0.2, 0.3);
    let quadric = move |p: DVec3| {
        let xy = DVec3::new(p.x * p.y, p.x * p.z, p.y * p.z);
        squared.dot(p * p) + products.dot(xy) + linear.dot(p) - 0.6
    };
    let superellipsoid = |p: DVec3| {
        let a = p.abs();
        pow(pow(a.x, 5.0) + pow(a.z, 5.0), 0.8) + pow(a.y, 4.0) - 1.0
    };
    let quartic = |p: DVec3| p.x * p.x * p.x * p.x + p.y * p.y * p.y * p.y - p.z * p.x + p.z * p.z - 0.4;
    let cube = |p: DVec3| p.abs().max_element() - 0.9;
    let gyroid = |p: DVec3| {
        let wave =
            |a: f64, b: f64| crate::math::elementary::sin(4.0 * a) * crate::math::elementary::cos(4.0 * b);
        wave(p.x, p.y) + wave(p.y, p.z) + wave(p.z, p.x) - 0.2
    };
    let blob = |p: DVec3| {
        let part = |c: DVec3, r: f64, s: f64| {
            let rest = (1.0 - p.distance_squared(c) / (r * r)).max(0.0);
            s * rest * rest
        };
        let z = p.z.clamp(-0.3, 0.5);
        let capsule = part(DVec3::new(-0.3, -0.2, z), 0.5, -0.8);
        0.4 - part(DVec3::ZERO, 0.9, 1.0) - part(DVec3::new(0.6, 0.3, 0.0), 0.7, 0.9) - capsule
    };
    let (low, high) = (DVec3::splat(-0.9), DVec3::splat(0.9));
    vec![
        Case {
            name: "quadric",
            shape: prepare(ShapeDesc::Quadric(QuadricDesc { squared, products, linear, constant: -0.6 })),
            sheets: solid(distance_like(quadric)),
        },
        Case {
            name: "superellipsoid",
            shape: prepare(ShapeDesc::Superellipsoid(SuperellipsoidDesc {
                east_west: 0.4,
                north_south: 0.5,
            })),
            sheets: solid(distance_like(superellipsoid)),
        },
        Case {
            name: "polynomial",
            shape: prepare(ShapeDesc::Polynomial(PolynomialDesc {
                terms: vec![
                    [1.0, 4.0, 0.0, 0.0],
                    [1.0, 0.0, 4.0, 0.0],
                    [-1.0, 1.0, 0.0, 1.0],
                    [1.0, 0.0, 0.0, 2.0],
                    [-0.4, 0.0, 0.0, 0.0],
                ],
                min: low,
                max: high,
                capped: true,
            })),
            sheets: solid(move |p| distance_like(quartic)(p).max(cube(p))),
        },
        Case {
            name: "isosurface",
            shape: prepare(ShapeDesc::Isosurface(IsosurfaceDesc {
                function: "sin(4*x)*cos(4*y) + sin(4*y)*cos(4*z) + sin(4*z)*cos(4*x) - 0.2".to_owned(),
                min: low,
                max: high,
                capped: true,
            })),
            sheets: solid(move |p| distance_like(gyroid)(p).max(cube(p))),
        },
        distance_grid(low, high),
        Case {
            name: "blob",
            shape: prepare(ShapeDesc::Blob(BlobDesc {
                spheres: vec![[0.0, 0.0, 0.0, 0.9, 1.0], [0.6, 0.3, 0.0, 0.7, 0.9]],
                capsules: vec![[-0.3, -0.2, -0.3, -0.3, -0.2, 0.5, 0.5, -0.8]],
                threshold: 0.4,
            })),
            sheets: solid(distance_like(blob)),
        },
    ]
}

fn outlined() -> Vec<Case> {
    let v = DVec2::new;
    let rectangle = |p: DVec2, low: DVec2, high: DVec2| (low - p).max(p - high).max_element();
    let prism = move |p: DVec3| {
        let q = v(p.x, p.z);
        let corner = rectangle(q, v(-0.8, -0.7), v(0.9, 0.0)).min(rectangle(q, v(-0.8, -0.7), v(-0.1, 0.8)));
        let hole = rectangle(q, v(-0.6, -0.5), v(-0.3, -0.2));
        corner.max(-hole).max(p.y - 0.5).max(-0.4 - p.y)
    };
    let outline = [v(0.5, -0.6), v(0.9, 0.0), v(0.4, 0.7)];
    let lathe = move |p: DVec3| {
        let q = v((p.x * p.x + p.z * p.z).sqrt(), p.y);
        let beside = |a: DVec2, b: DVec2| {
            let n = v((b - a).y, -(b - a).x).normalize();
            n.dot(q - a)
        };
        beside(outline[0], outline[1]).max(beside(outline[1], outline[2])).max(-0.6 - p.y).max(p.y - 0.7)
    };
    let spheres = [[-0.8, 0.1, 0.0, 0.15], [0.1, 0.5, 0.2, 0.4], [0.6, -0.4, -0.1, 0.2]];
    let sweep = move |p: DVec3| {
        let between = |a: [f64; 4], b: [f64; 4]| {
            let at = |x: f64| {
                let c: [f64; 4] = std::array::from_fn(|k| a[k] + x * (b[k] - a[k]));
                p.distance(DVec3::new(c[0], c[1], c[2])) - c[3]
            };
            // A convex function of x.
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..100 {
                let (x, y) = ((2.0 * low + high) / 3.0, (low + 2.0 * high) / 3.0);
                if at(x) < at(y) { high = y } else { low = x }
            }
            at(low).min(at(0.0)).min(at(1.0))
        };
        between(spheres[0], spheres[1]).min(between(spheres[1], spheres[2]))
    };
    vec![
        Case {
            name: "prism",
            shape: prepare(ShapeDesc::Prism(PrismDesc {
                points: vec![
                    v(-0.8, -0.7),
                    v(0.9, -0.7),
                    v(0.9, 0.0),
                    v(-0.1, 0.0),
                    v(-0.1, 0.8),
                    v(-0.8, 0.8),
                ],
                holes: vec![vec![v(-0.6, -0.5), v(-0.6, -0.2), v(-0.3, -0.2), v(-0.3, -0.5)]],
                bottom: -0.4,
                top: 0.5,
                ..PrismDesc::default()
            })),
            sheets: solid(prism),
        },
        Case {
            name: "lathe",
            shape: prepare(ShapeDesc::Lathe(LatheDesc {
                points: outline.to_vec(),
                spline: LatheSpline::Linear,
            })),
            sheets: solid(lathe),
        },
        Case {
            name: "sphere_sweep",
            shape: prepare(ShapeDesc::SphereSweep(SphereSweepDesc {
                spheres: spheres.to_vec(),
                path: SweepPath::Linear,
            })),
            sheets: solid(sweep),
        },
    ]
}

/// All solids.
pub(in crate::shape) fn cases() -> Vec<Case> {
    csg().into_iter().chain(curved()).chain(outlined()).collect()
}
