//! Measured BRDFs: tables of a known BRDF against its formula, samples and densities, symmetries.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

use crate::bsdf::{Bsdf, Measured};
use crate::math::DVec3;
use crate::math::elementary::sin_cos;
use crate::schema::{MeasuredBrdf, MeasuredFields, MeasuredTable};
use crate::testing::{
    ChiSquareOptions, direction, samples_agree_with_eval, samples_follow_density, sidak_level,
};

/// GGX facets of a perfect conductor, with α along x and y.
#[derive(Clone, Copy)]
struct Ggx([f64; 2]);

impl Ggx {
    fn density(self, m: DVec3) -> f64 {
        let [ax, ay] = self.0;
        let s = square(m.x / ax) + square(m.y / ay) + m.z * m.z;
        1.0 / (PI * ax * ay * s * s)
    }
    /// Projected area of the visible facets.
    fn area(self, w: DVec3) -> f64 {
        let [ax, ay] = self.0;
        0.5 * (w.z + (square(w.x * ax) + square(w.y * ay) + w.z * w.z).sqrt())
    }
    /// Λ of the height-correlated masking and shadowing.
    fn lambda(self, w: DVec3) -> f64 {
        self.area(w) / w.z - 1.0
    }
    /// The BRDF of a colour.
    fn brdf(self, wo: DVec3, wi: DVec3) -> f64 {
        let m = (wo + wi).normalize();
        self.density(m) / (1.0 + self.lambda(wo) + self.lambda(wi)) / (4.0 * wo.z * wi.z)
    }
}

fn square(v: f64) -> f64 {
    v * v
}

fn unit([theta, phi]: [f64; 2]) -> DVec3 {
    let ((sin, cos), (sin_phi, cos_phi)) = (sin_cos(theta), sin_cos(phi));
    DVec3::new(sin * cos_phi, sin * sin_phi, cos)
}

fn theta_of(u: f64) -> f64 {
    u * u * FRAC_PI_2
}

fn phi_of(u: f64) -> f64 {
    (2.0 * u - 1.0) * PI
}

const COLOR: [f64; 3] = [0.9, 0.6, 0.2];

/// A table over the unit square.
fn table(size: [usize; 2], f: impl Fn([f64; 2]) -> f64) -> Vec<f32> {
    let at = |i: usize, n: usize| i as f64 / (n - 1) as f64;
    (0..size[0] * size[1]).map(|i| f([at(i % size[0], size[0]), at(i / size[0], size[1])]) as f32).collect()
}

/// The tables that a measurement of the facets gives: seen from `thetas` angles and the azimuths `phi_i`.
fn tables(facets: Ggx, thetas: usize, phi_i: Vec<f32>, side: usize) -> MeasuredBrdf {
    let theta_i: Vec<f32> =
        (0..thetas).map(|i| (theta_of(i as f64 / (thetas - 1) as f64) * 0.98) as f32).collect();
    let turned = |phi: f64| if phi_i.len() == 1 { phi } else { 0.0 };
    let views: Vec<(f64, f64)> = phi_i
        .iter()
        .flat_map(|p| theta_i.iter().map(|t| (f64::from(*t), f64::from(*p).clamp(-PI, PI))))
        .collect();
    let visible = |&(theta, phi): &(f64, f64)| {
        let wo = unit([theta, phi]);
        table([side; 2], |u| {
            let angles = [theta_of(u[0]), phi_of(u[1]) + turned(phi)];
            let m = unit(angles);
            facets.density(m) * wo.dot(m).max(0.0) * u[0] * sin_cos(angles[0]).0
        })
    };
    let all = |f: &dyn Fn(&(f64, f64)) -> Vec<f32>| views.iter().flat_map(f).collect();
    let mut fields = MeasuredFields {
        ndf: MeasuredTable {
            size: [side; 2],
            values: table([side; 2], |u| facets.density(unit([theta_of(u[0]), phi_of(u[1])]))),
        },
        sigma: MeasuredTable {
            size: [side; 2],
            values: table([side; 2], |u| facets.area(unit([theta_of(u[0]), phi_of(u[1])]))),
        },
        vndf: MeasuredTable { size: [side; 2], values: all(&visible) },
        luminance: MeasuredTable { size: [side; 2], values: vec![1.0; side * side * views.len()] },
        rgb: MeasuredTable { size: [side; 2], values: vec![0.0; 3 * side * side * views.len()] },
        theta_i,
        phi_i,
        jacobian: true,
    };
    // Which normal each number stands for follows from the tables so far.
    let first = MeasuredBrdf::new(fields.clone()).unwrap();
    let light = |&(theta, phi): &(f64, f64)| {
        let wo = unit([theta, phi]);
        let view = first.seen_from(wo);
        table([side; 2], |s| {
            let (normal, ..) = first.sample(s, &view);
            let m = view.mirrored(unit(first.angles_of_numbers(normal, &view)));
            let wi = m * (2.0 * wo.dot(m)) - wo;
            let area = facets.area(wo);
            if wi.z > 1e-3 { facets.brdf(wo, wi) * wi.z * 4.0 * area / facets.density(m) } else { 0.0 }
        })
    };
    let colored = |view: &(f64, f64)| {
        let one = light(view);
        COLOR.iter().flat_map(|c| one.iter().map(|v| v * *c as f32).collect::<Vec<f32>>()).collect()
    };
    fields.luminance.values = all(&light);
    fields.rgb.values = all(&colored);
    MeasuredBrdf::new(fields).unwrap()
}

fn azimuths(from: f64, to: f64, count: usize) -> Vec<f32> {
    (0..count).map(|i| (from + (to - from) * i as f64 / (count - 1) as f64) as f32).collect()
}

fn isotropic() -> Measured {
    Measured::new(&Arc::new(tables(Ggx([0.4; 2]), 12, vec![0.0], 48)))
}

fn anisotropic() -> Measured {
    Measured::new(&Arc::new(tables(Ggx([0.25, 0.6]), 8, azimuths(-PI, PI, 25), 41)))
}

#[test]
fn tables_of_facets_have_their_brdf() {
    for (facets, measured) in [(Ggx([0.4; 2]), isotropic()), (Ggx([0.25, 0.6]), anisotropic())] {
        let bsdf = Bsdf::measured(&measured);
        let mut worst: f64 = 0.0;
        for i in 0..400 {
            let t = f64::from(i);
            let wo = direction(0.35 + 0.6 * (t * 0.618).fract(), TAU * (t * 0.414).fract());
            let wi = direction(0.35 + 0.6 * (t * 0.732).fract(), TAU * (t * 0.236).fract());
            let (f, _) = bsdf.eval_pdf(wo, wi);
            let exact = facets.brdf(wo, wi);
            let error = (f64::from(f.r) / (COLOR[0] * exact) - 1.0).abs();
            worst = worst.max(error * exact.min(1.0));
            let blue = f64::from(f.b) / f64::from(f.r) * COLOR[0] / COLOR[2];
            assert!((blue - 1.0).abs() < 1e-4, "{f:?}");
        }
        assert!(worst < 0.03, "{worst}");
    }
}

#[test]
fn samples_follow_the_density() {
    let cosines = [0.95, 0.5, 0.15];
    let level = sidak_level(0.01, 2 * cosines.len());
    let mut bad = String::new();
    for (name, measured) in [("isotropic", isotropic()), ("anisotropic", anisotropic())] {
        let bsdf = Bsdf::measured(&measured);
        for (n, mu) in cosines.into_iter().enumerate() {
            let wo = direction(mu, 0.7 + n as f64);
            let test = samples_follow_density(&bsdf, wo, 31 + n as u64, &ChiSquareOptions::default());
            if test.p_value < level {
                bad += &format!("{name}, µ {mu}: {test:?}\n");
            }
            samples_agree_with_eval(&bsdf, wo, 400).unwrap();
        }
    }
    assert!(bad.is_empty(), "\n{bad}");
}

/// A perfect conductor loses what its facets shadow.
#[test]
fn the_albedo_and_the_roughness_are_those_of_the_facets() {
    let measured = isotropic();
    let bsdf = Bsdf::measured(&measured);
    let albedo = bsdf.albedo_hint();
    // The formula's albedo from above, which depends on the angle alone.
    let count = 2000;
    let angle = |i: usize| (i as f64 + 0.5) / count as f64 * FRAC_PI_2;
    let ring = |t: f64| {
        let (sin, cos) = sin_cos(t);
        Ggx([0.4; 2]).brdf(DVec3::Z, unit([t, 0.3])) * sin * cos * TAU * FRAC_PI_2 / count as f64
    };
    let exact: f64 = (0..count).map(|i| ring(angle(i))).sum();
    assert!((f64::from(albedo.r) / COLOR[0] - exact).abs() < 0.02, "{albedo:?} {exact}");
    assert!((bsdf.roughness_hint() - 0.4f64.sqrt()).abs() < 0.02, "{}", bsdf.roughness_hint());
    assert!(!measured.is_anisotropic() && anisotropic().is_anisotropic());
}

/// Half or a quarter of the azimuths is enough for a material that is the same when turned or mirrored.
#[test]
fn symmetric_materials_need_fewer_azimuths() {
    let facets = Ggx([0.25, 0.6]);
    let whole = anisotropic();
    for (name, phi) in [("half", azimuths(-PI, 0.0, 13)), ("quarter", azimuths(-PI, -FRAC_PI_2, 7))] {
        let part = Measured::new(&Arc::new(tables(facets, 8, phi, 41)));
        let (a, b) = (Bsdf::measured(&whole), Bsdf::measured(&part));
        // A view along x lies at an end of the range of azimuths: −π and π are the same.
        let (along, toward) = (direction(0.6, PI), direction(0.7, 2.5));
        let [f, g] = [&a, &b].map(|bsdf| bsdf.eval(DVec3::new(along.x, 0.0, along.z), toward));
        assert!((f.r - g.r).abs() < 0.03 * (f.r + g.r) + 5e-3, "{name}: {f:?} {g:?}");
        let (mut difference, mut sum) = (0.0, 0.0);
        for i in 1..200 {
            let t = f64::from(i);
            let wo = direction(0.3 + 0.65 * (t * 0.618).fract(), TAU * (t * 0.414).fract());
            let wi = direction(0.3 + 0.65 * (t * 0.732).fract(), TAU * (t * 0.236).fract());
            let (f, (g, p)) = (a.eval(wo, wi), b.eval_pdf(wo, wi));
            difference += (f.r - g.r).abs();
            sum += f.r + g.r;
            // Turned by half a circle, the part is exactly the same.
            let turned = |w: DVec3| DVec3::new(-w.x, -w.y, w.z);
            let (h, q) = b.eval_pdf(turned(wo), turned(wi));
            assert!((h.r - g.r).abs() <= 1e-5 * g.r && (p - q).abs() <= 1e-6 * p, "{name}: {g:?} {h:?}");
        }
        // The mirrored cells of a part are not those of the whole, so that interpolation differs in the tails of the lobe.
        assert!(difference < 0.01 * sum, "{name}: {difference} of {sum}");
        for mu in [0.9, 0.4] {
            samples_agree_with_eval(&b, direction(mu, 2.5), 400).unwrap();
        }
    }
}

#[test]
fn fields_that_disagree_are_refused() {
    let fields = || tables(Ggx([0.4; 2]), 3, vec![0.0], 4).fields();
    let refused = |change: &dyn Fn(&mut MeasuredFields)| {
        let mut made = fields();
        change(&mut made);
        MeasuredBrdf::new(made).unwrap_err()
    };
    assert_eq!(MeasuredBrdf::new(fields()).unwrap(), MeasuredBrdf::new(fields()).unwrap());
    for (change, message) in [
        (
            &(|f: &mut MeasuredFields| f.theta_i = vec![0.5, 0.2, 0.9]) as &dyn Fn(&mut MeasuredFields),
            "do not increase",
        ),
        (&|f| f.phi_i = vec![9.0], "not within"),
        (&|f| f.theta_i.clear(), "not within"),
        (&|f| f.vndf.values[5] = f32::NAN, "vndf holds NaN"),
        (&|f| f.luminance.values[5] = -1.0, "luminance holds -1"),
        (&|f| f.rgb.values.truncate(7), "rgb has 7 values: expected 144"),
        (&|f| f.ndf.size = [16, 1], "16 × 1 values"),
        (&|f| f.sigma.size = [usize::MAX; 2], "sigma has 16 values"),
        (&|f| f.phi_i = vec![0.0, 0.5, 1.0], "expected 144"),
    ] {
        let problem = refused(change);
        assert!(problem.contains(message), "{problem}");
    }
}
