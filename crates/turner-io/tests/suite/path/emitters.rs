//! Shapes that shine: the directions that sampling them gives follow the density that a hit of them has.

use std::f64::consts::{PI, TAU};

use turner::math::{DVec3, Ray};
use turner::scene::Scene;

use crate::classic::common::describe;
use crate::path::statistics::mean;

const LAMP: &str = "material = { type = \"emissive\", color = [1, 0.5, 0.25], strength = 2 }";

const SLANTED: &str =
    "transform = [{ scale = [1.6, 0.5, 0.8] }, { rotate = [20, 30, 40] }, { translate = [0.2, 0.1, 0] }]";

/// Every shape with an end, as it is and under a transform that scales unevenly.
fn shapes() -> Vec<String> {
    let plain = [
        "type = \"sphere\", radius = 0.8",
        "type = \"box\", min = [-0.7, -0.5, -0.4], max = [0.6, 0.5, 0.5]",
        "type = \"rectangle\", edge_u = [1.5, 0, 0.2], edge_v = [0, 1, 0.3]",
        "type = \"disk\", radius = 0.9, normal = [0.3, 1, 0.4]",
        "type = \"cylinder\", from = [0, -0.6, 0.1], to = [0.2, 0.7, 0], radius = 0.5",
        "type = \"cylinder\", radius = 0.5, capped = false",
        "type = \"cone\", from = [0, -0.6, 0.1], to = [0.2, 0.7, 0], radius = 0.7",
        "type = \"cone\", radius = 0.4, tip_radius = 0.7",
        "type = \"torus\", radius = 0.6, tube_radius = 0.3, axis = [0.3, 1, 0.1]",
        "type = \"points\", positions = [[-0.6, 0, 0], [0.5, 0.3, 0], [0, -0.4, 0.5]], radii = [0.4, 0.3, 0.2]",
        "type = \"mesh\", positions = [[-0.6, -0.5, 0], [0.7, -0.4, 0.3], [0, 0.6, -0.2], [0.1, 0.1, 0.9]], triangles = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]",
    ];
    let slanted = plain.iter().map(|s| format!("{s}, {SLANTED}"));
    plain.iter().map(|s| s.to_string()).chain(slanted).collect()
}

fn scene(shape: &str) -> std::sync::Arc<Scene> {
    let text = format!("integrator.type = \"path\"\nobject = [{{ {shape}, {LAMP} }}]");
    describe(&text).prepare(&Default::default()).unwrap().scene
}

/// Pseudo-random numbers (PCG).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let x = ((self.0 >> 22) ^ self.0) >> (22 + (self.0 >> 61));
        f64::from(x as u32) / 4_294_967_296.0
    }
}

/// The densities at all hits of a ray, added up: the density of its direction. Of spheres only fronts are sampled.
fn density(scene: &Scene, p: DVec3, w: DVec3, fronts: bool) -> f64 {
    let mut ray = Ray::new(p, w);
    let mut sum = 0.0;
    for _ in 0..12 {
        let Some(hit) = scene.intersect(&ray) else { break };
        let surface = scene.surface(&ray, &hit);
        if !fronts || surface.ng.dot(w) < 0.0 {
            sum += scene.emitters.pdf_hit(scene, p, &surface);
        }
        ray.t_min = hit.shape.t + 1e-7;
    }
    sum
}

/// Rows of equal height around the axis to the shape, and columns of equal angle.
const ROWS: usize = 12;
const COLUMNS: usize = 12;
const SAMPLES: u32 = 20_000;

#[test]
fn samples_follow_the_density_and_the_density_covers_the_shape_once() {
    let p = DVec3::new(1.2, 1.6, 2.2);
    let axis = -p.normalize();
    let side = axis.any_orthonormal_vector();
    let up = axis.cross(side);
    // All of each shape is within that angle.
    let least = 0.72;
    for shape in shapes() {
        let scene = scene(&shape);
        let cell = |w: DVec3| {
            let row = ((1.0 - w.dot(axis)) / (1.0 - least) * ROWS as f64) as usize;
            let turn = (w.dot(up).atan2(w.dot(side)) / TAU).rem_euclid(1.0);
            assert!(row < ROWS, "{shape}: {w}");
            row * COLUMNS + ((turn * COLUMNS as f64) as usize).min(COLUMNS - 1)
        };
        let mut found = vec![0u32; ROWS * COLUMNS];
        let mut random = Random(7);
        let (mut outside, mut front) = (0u32, 0u32);
        for _ in 0..SAMPLES {
            let u = [random.next(), random.next(), random.next()];
            let Some(s) = scene.emitters.sample(&scene, p, u) else { continue };
            let w = s.to_light.normalize();
            found[cell(w)] += 1;
            // The first hit is the sample, unless something of the shape is before it.
            let ray = Ray::new(p, w);
            let Some(hit) = scene.intersect(&ray) else {
                outside += 1;
                continue;
            };
            if (hit.shape.t - s.to_light.length()).abs() < 1e-6 {
                front += 1;
                let pdf = scene.emitters.pdf_hit(&scene, p, &scene.surface(&ray, &hit));
                // Alias tables keep probabilities in single precision, and silhouettes are steep.
                assert!((pdf / s.pdf - 1.0).abs() < 1e-3, "{shape}: {pdf} and {}", s.pdf);
            }
            assert!((s.radiance.r - 2.0).abs() < 1e-6 && (s.radiance.b - 0.5).abs() < 1e-6);
        }
        assert!(outside < SAMPLES / 500 && front > SAMPLES / 4, "{shape}: {outside} {front}");
        let fronts = shape.contains("\"sphere\"") || shape.contains("\"points\"");
        let (mut chi2, mut cells, mut whole) = (0.0, 0, 0.0);
        let n = 64;
        for (i, &count) in found.iter().enumerate() {
            let (row, column) = ((i / COLUMNS) as f64, (i % COLUMNS) as f64);
            let mut mean = 0.0;
            for k in 0..n * n {
                let at = |k: i32| (f64::from(k) + 0.5) / f64::from(n);
                let c = 1.0 - (row + at(k % n)) / ROWS as f64 * (1.0 - least);
                let phi = (column + at(k / n)) / COLUMNS as f64 * TAU;
                let s = (1.0 - c * c).sqrt();
                mean += density(&scene, p, c * axis + s * (phi.cos() * side + phi.sin() * up), fronts);
            }
            let size = TAU * (1.0 - least) / (ROWS * COLUMNS) as f64;
            let share = mean / f64::from(n * n) * size;
            whole += share;
            let expected = share * f64::from(SAMPLES);
            if expected > 8.0 {
                // What the sum over the cell misses of edges and silhouettes is no deviation.
                let off = ((f64::from(count) - expected).abs() - 0.02 * expected).max(0.0);
                chi2 += off * off / expected;
                cells += 1;
            }
        }
        assert!((whole - 1.0).abs() < 0.03, "{shape}: {whole}");
        let limit = f64::from(cells) + 5.0 * f64::from(2 * cells).sqrt();
        assert!(cells > 5 && chi2 < limit, "{shape}: {chi2} in {cells} cells");
    }
}

/// The light of each shape on a matte floor, found by sampling it and by chance.
#[test]
fn shapes_light_a_floor_as_much_by_sampling_as_by_chance() {
    let floor = "{ type = \"plane\", point = [0, -1.5, 0], material = { type = \"matte\", color = 0.5 } }";
    let camera =
        "camera = { position = [0, -1.4, 0], look_at = [0, -1.5, 0], up = [0, 0, -1], fov = 0.001 }\n";
    for shape in shapes() {
        let lit = |samples: u32, how: &str| {
            mean(
                samples,
                &format!(
                    "integrator = {{ type = \"path\", max_depth = 1, light_sampling = \"{how}\" }}\n{camera}\
                     object = [{floor}, {{ {shape}, {LAMP} }}]"
                ),
            )
        };
        let (chance, both, sampled) = (lit(1024, "bsdf"), lit(64, "both"), lit(128, "light"));
        both.agrees(&chance, 0.03);
        sampled.agrees(&chance, 0.05);
    }
}

/// A texture's light comes from where the texture is bright.
#[test]
fn textured_emission_of_curved_shapes() {
    let glow = "material = { type = \"emissive\", strength = 3, color = { type = \"chessboard\", even = [1, 0.2, 0.1], odd = 0.05, density = 4 } }";
    let floor = "{ type = \"plane\", point = [0, -1.5, 0], material = { type = \"matte\", color = 0.5 } }";
    for shape in ["type = \"torus\", radius = 0.6, tube_radius = 0.3", "type = \"cone\", radius = 0.7"] {
        let lit = |samples: u32, how: &str| {
            mean(
                samples,
                &format!(
                    "integrator = {{ type = \"path\", max_depth = 1, light_sampling = \"{how}\" }}\n\
                     camera = {{ position = [0, -1.4, 0], look_at = [0, -1.5, 0], up = [0, 0, -1], fov = 0.001 }}\n\
                     object = [{floor}, {{ {shape}, {SLANTED}, {glow} }}]"
                ),
            )
        };
        lit(128, "both").agrees(&lit(1024, "bsdf"), 0.04);
    }
}

/// Form factors of shapes without a transform that have one.
#[test]
fn a_tube_around_the_point_gives_what_the_formula_says() {
    // Inside a tube without caps, half as high as wide above the floor: the sky seen through its upper end is dark.
    let text = |how: &str| {
        format!(
            "integrator = {{ type = \"path\", max_depth = 1, light_sampling = \"{how}\" }}\n\
             camera = {{ position = [0, 0.2, 0], look_at = [0, 0, 0], up = [0, 0, -1], fov = 0.001 }}\n\
             object = [{{ type = \"plane\", material = {{ type = \"matte\", color = 0.5 }} }}, \
             {{ type = \"cylinder\", from = [0, 0, 0], to = [0, 2, 0], radius = 1.5, capped = false, material = {{ type = \"emissive\", strength = {PI} }} }}]"
        )
    };
    // The disk of radius r at height h has the form factor r² / (r² + h²).
    let factor = 1.0 - 2.25 / (2.25 + 4.0);
    mean(256, &text("both")).is_grey(0.5 * PI * factor, 0.01);
    mean(256, &text("light")).is_grey(0.5 * PI * factor, 0.05);
}
