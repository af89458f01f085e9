//! Chi-square tests of samplers against their densities.

use std::sync::Arc;

use turner::image::{Image, Pixels};
use turner::light::EnvironmentDesc;
use turner::light::emission::{DiskEmitter, EmitterSample, RectangleEmitter, SphereEmitter, TriangleEmitter};
use turner::math::{DVec2, DVec3};
use turner::sampler::{AliasTable, OwenSobol, SampleId, concentric_disk, uniform_sphere};
use turner::schema::{Asset, ImageId};
use turner::testing::{
    ChiSquare, ChiSquareOptions, Random, chi_square_of_directions, chi_square_on_square, smallest_of,
};

use super::check::{Check, Context, Effort, Finding, fault};

pub(super) fn checks() -> Vec<Check> {
    let mut out = emitters();
    out.push(Check::chance("density/environment", |cx| environment(cx, false)));
    out.push(Check::chance("density/environment-compensated", |cx| environment(cx, true)));
    out.push(Check::chance("density/sobol", sobol));
    out.push(Check::chance("density/alias-table", alias));
    out.push(Check::chance("density/lens", lens));
    out.push(Check::chance("density/sphere", |cx| {
        let mut random = Random::new(cx.seed_for("sphere"));
        let sample = || Some(uniform_sphere(DVec2::from(random.units::<2>())));
        Ok(finding(&[chi_square_of_directions(&options(cx), |_| 0.25 / std::f64::consts::PI, sample)]))
    }));
    out
}

/// The options of a chi-square test, with its number of samples.
pub fn options(cx: &Context) -> ChiSquareOptions {
    ChiSquareOptions { samples: cx.times(20_000), ..ChiSquareOptions::default() }
}

/// Several tests as one finding: the smallest p-value, corrected for their number.
pub fn finding(tests: &[ChiSquare]) -> Finding {
    let worst = tests.iter().min_by(|a, b| a.p_value.total_cmp(&b.p_value));
    let Some(worst) = worst else { return Finding::chance(0.0, "nothing tested") };
    let mut found = format!("χ² {:.0} of {}, ∫ {:.4}", worst.statistic, worst.freedom, worst.covered);
    if worst.missing > 0.0 {
        found += &format!(" + {:.4} without density", worst.missing);
    }
    if worst.impossible > 0 {
        found += &format!(", {} samples of density 0", worst.impossible);
    }
    Finding::chance(smallest_of(worst.p_value, tests.len()), found)
}

type Sampler = Box<dyn Fn(DVec3, [f64; 2]) -> Option<EmitterSample>>;
type Density = Box<dyn Fn(DVec3, DVec3) -> f64>;

fn emitters() -> Vec<Check> {
    let mut out = Vec::new();
    let mut add = |name: &'static str, p: DVec3, sample: Sampler, density: Density| {
        out.push(Check::chance(format!("density/{name}"), move |cx| {
            let mut random = Random::new(cx.seed_for(name));
            let draw = || sample(p, random.units()).map(|s| (s.q - p).normalize());
            // The quadrature is inexact at the edges of lights; more samples would measure its error.
            Ok(finding(&[chi_square_of_directions(&ChiSquareOptions::default(), |w| density(p, w), draw)]))
        }));
    };
    let (near, far) = (DVec3::new(0.3, -0.4, 0.2), DVec3::new(3.0, -4.0, 1.0));
    let (corner, u, v) = (DVec3::new(-1.0, 0.0, -0.5), DVec3::X * 2.0, DVec3::Z);
    for (name, u, v, p) in [
        ("rectangle-near", u, v, near),
        ("rectangle-far", u * 2.0, v * 2.0, far),
        ("parallelogram", u, v + 0.4 * u, near),
    ] {
        let Some(r) = RectangleEmitter::new(corner, u, v, 1.0) else { continue };
        let hit = move |p: DVec3, w: DVec3| {
            let q = on_plane(p, w, corner, u.cross(v))?;
            let (a, b) = within(q - corner, u, v);
            ((0.0..=1.0).contains(&a) && (0.0..=1.0).contains(&b)).then_some(q)
        };
        let density = move |p, w| hit(p, w).map_or(0.0, |q| r.pdf(p, q));
        add(name, p, Box::new(move |p, u| r.sample(p, u)), Box::new(density));
    }
    let [a, b, c] = [DVec3::new(-1.0, 0.0, -0.5), DVec3::new(1.0, 0.1, 0.0), DVec3::new(0.2, 0.0, 1.0)];
    for (name, p) in [("triangle-near", near), ("triangle-far", DVec3::new(1.0, -2.5, 0.5))] {
        let Some(t) = TriangleEmitter::new([a, b, c], 1.0) else { continue };
        let hit = move |p: DVec3, w: DVec3| {
            let q = on_plane(p, w, a, (b - a).cross(c - a))?;
            let (s, t) = within(q - a, b - a, c - a);
            (s >= 0.0 && t >= 0.0 && s + t <= 1.0).then_some(q)
        };
        let density = move |p, w| hit(p, w).map_or(0.0, |q| t.pdf(p, q));
        add(name, p, Box::new(move |p, u| t.sample(p, u)), Box::new(density));
    }
    for (name, inner) in [("disk", 0.0), ("ring", 0.5)] {
        let Some(d) = DiskEmitter::new(DVec3::ZERO, DVec3::X, DVec3::Z, inner) else { continue };
        let hit = move |p: DVec3, w: DVec3| {
            let q = on_plane(p, w, DVec3::ZERO, DVec3::Y)?;
            (inner..=1.0).contains(&q.length()).then_some(q)
        };
        let density = move |p, w| hit(p, w).map_or(0.0, |q| d.pdf(p, q));
        add(name, near, Box::new(move |p, u| d.sample(p, u)), Box::new(density));
    }
    let s = SphereEmitter { center: DVec3::new(0.0, 1.0, 0.0), radius: 1.1 };
    for (name, p) in
        [("sphere-outside", DVec3::new(0.3, -1.0, 0.2)), ("sphere-inside", DVec3::new(0.2, 1.3, 0.1))]
    {
        let density = move |p: DVec3, w: DVec3| {
            let from = p - s.center;
            let b = from.dot(w);
            let root = b * b - from.length_squared() + s.radius * s.radius;
            let inside = from.length() < s.radius;
            if root < 0.0 || (!inside && b > 0.0) {
                return 0.0;
            }
            let t = if inside { -b + root.sqrt() } else { -b - root.sqrt() };
            let q = p + t * w;
            s.pdf(p, q, (q - s.center).normalize())
        };
        add(name, p, Box::new(move |p, u| s.sample(p, u)), Box::new(density));
    }
    out
}

fn on_plane(p: DVec3, w: DVec3, through: DVec3, normal: DVec3) -> Option<DVec3> {
    let t = (through - p).dot(normal) / w.dot(normal);
    (t > 0.0 && t.is_finite()).then(|| p + t * w)
}

/// Coordinates of a vector in the basis `u`, `v` of a plane.
fn within(d: DVec3, u: DVec3, v: DVec3) -> (f64, f64) {
    let n = u.cross(v);
    let scale = 1.0 / n.length_squared();
    (d.cross(v).dot(n) * scale, u.cross(d).dot(n) * scale)
}

fn environment(cx: &Context, compensated: bool) -> Result<Finding, turner::schema::SceneError> {
    let mut random = Random::new(cx.seed_for("environment"));
    let (width, height) = (16, 8);
    // A map with black parts and one bright pixel.
    let pixel = |i: u32| match i {
        37 => 20.0,
        i if i > 96 && !i.is_multiple_of(5) => 0.0,
        _ => 2.0 * random.unit() as f32,
    };
    let pixels = Pixels::F32((0..width * height).map(pixel).collect());
    let image = Arc::new(Image { width, height, channels: 1, pixels });
    let desc = EnvironmentDesc { file: Some(ImageId(0)), rotation: 77.0, ..EnvironmentDesc::default() };
    let light = desc.prepare(&[Asset { uri: "sky".into(), data: image }], compensated)?;
    let sample = || light.sample(random.units()).map(|s| s.direction);
    let options = ChiSquareOptions { samples: 20_000, ..ChiSquareOptions::default() };
    Ok(finding(&[chi_square_of_directions(&options, |w| light.pdf(w), sample)]))
}

/// Sobol points of pixels are uniform in each set of dimensions, and across pairs of sets.
fn sobol(cx: &Context) -> Result<Finding, turner::schema::SceneError> {
    let mut random = Random::new(cx.seed_for("sobol"));
    let options = ChiSquareOptions { samples: cx.times(20_000), rows: 16, columns: 16, ..Default::default() };
    let mut tests = Vec::new();
    for set in 0..6 {
        let (seed, index) = (random.bits(), (random.bits() % 100) as u32);
        let mut x = 0;
        let mut next = || {
            x += 1;
            OwenSobol::new(&SampleId { x: x % 256, y: x / 256, index, seed })
        };
        tests.push(chi_square_on_square(&options, |_| 1.0, || Some(next().two(set).into())));
        let across = || {
            let points = next();
            Some(DVec2::new(points.four(set)[1], points.four(set + 1)[2]))
        };
        tests.push(chi_square_on_square(&options, |_| 1.0, across));
    }
    Ok(finding(&tests))
}

fn alias(cx: &Context) -> Result<Finding, turner::schema::SceneError> {
    let mut random = Random::new(cx.seed_for("alias"));
    let n = 60;
    let weights: Vec<f64> =
        (0..n).map(|i| if i % 7 == 0 { 0.0 } else { random.unit() * random.unit() }).collect();
    let table = AliasTable::new(&weights).ok_or_else(|| fault("no table"))?;
    let options = ChiSquareOptions { samples: cx.times(20_000), rows: n, columns: 4, ..Default::default() };
    let density = |p: DVec2| f64::from(n) * table.probability((p.x * f64::from(n)) as u32);
    let sample = || {
        // The remaining randomness must be uniform as well.
        let (i, _, rest) = table.sample(random.unit());
        Some(DVec2::new((f64::from(i) + 0.5) / f64::from(n), rest))
    };
    Ok(finding(&[chi_square_on_square(&options, density, sample)]))
}

fn lens(cx: &Context) -> Result<Finding, turner::schema::SceneError> {
    let mut random = Random::new(cx.seed_for("lens"));
    let density = |p: DVec2| {
        let inside = (2.0 * p - 1.0).length_squared() <= 1.0;
        if inside { 4.0 / std::f64::consts::PI } else { 0.0 }
    };
    let sample = || Some(0.5 * (concentric_disk(DVec2::from(random.units::<2>())) + 1.0));
    let samples = if cx.effort == Effort::Short { 20_000 } else { 100_000 };
    let options = ChiSquareOptions { samples, rows: 16, columns: 16, ..Default::default() };
    Ok(finding(&[chi_square_on_square(&options, density, sample)]))
}
