use super::*;
use crate::medium::{Homogeneous, PhaseFunction};
use crate::sampler::{OwenSobol, SampleId};
use crate::schema::GridScattering;
use crate::testing::Random;

fn coefficients() -> Coefficients {
    Coefficients {
        extinction: [1.0, 2.0, 0.5],
        scattering: [0.8, 0.5, 0.5],
        emission: [0.1, 0.2, 0.3],
        phase: PhaseFunction::ISOTROPIC,
    }
}

fn grid(size: [u32; 3], density: impl Fn(usize) -> f32) -> Heterogeneous {
    let count: u32 = size.iter().product();
    let data = GridData::new(size, (0..count as usize).map(density).collect(), None).unwrap();
    let bounds = [DVec3::NEG_ONE, DVec3::new(2.0, 1.5, 1.0)];
    Heterogeneous::new(coefficients(), Arc::new(data), false, bounds).unwrap()
}

fn stream(i: u32) -> Stream {
    OwenSobol::new(&SampleId { x: i, y: 1, index: 0, seed: 3 }).stream(5)
}

/// Segments within the box.
fn segments() -> Vec<(Ray, f64)> {
    let mut random = Random::new(8);
    let point = |r: &mut Random| {
        let [x, y, z] = r.units::<3>();
        DVec3::new(3.0 * x - 1.0, 2.5 * y - 1.0, 2.0 * z - 1.0)
    };
    let mut out = Vec::new();
    for _ in 0..12 {
        let (a, b) = (point(&mut random), point(&mut random));
        out.push((Ray::new(a, (b - a).normalize()), (b - a).length()));
    }
    out.push((Ray::new(DVec3::new(-5.0, 0.1, 0.1), DVec3::X), 9.0));
    out
}

fn is(values: impl Iterator<Item = f64>, expected: f64, what: &str) {
    let (mut n, mut sum, mut square) = (0.0, 0.0, 0.0);
    for v in values {
        (n, sum, square) = (n + 1.0, sum + v, square + v * v);
    }
    let mean = sum / n;
    let error = ((square / n - mean * mean).max(0.0) / n).sqrt();
    assert!((mean - expected).abs() < 4.5 * error + 1e-9, "{what}: {mean} ± {error}, not {expected}");
}

#[test]
fn a_constant_grid_is_a_homogeneous_medium() {
    let heterogeneous = grid([9, 17, 3], |_| 1.0);
    let homogeneous = Homogeneous { coefficients: coefficients() };
    for (k, (ray, end)) in segments().into_iter().enumerate() {
        // The last segment starts 4 units before the box, which is 3 long, and ends 2 units behind it.
        let length = if k == 12 { 3.0 } else { end };
        let expected = homogeneous.transmittance(length).to_array().map(f64::from);
        let n = 20_000;
        let through: Vec<[f32; 3]> =
            (0..n).map(|i| heterogeneous.transmittance(&ray, 0.0, end, &mut stream(i)).to_array()).collect();
        for band in 0..3 {
            is(through.iter().map(|t| f64::from(t[band])), expected[band], "transmittance");
        }
        let shares = [0.2, 0.5, 0.3];
        let stretch = RaySegment { ray: &ray, end, shares, scatters: true };
        let walks: Vec<Walk> = (0..n)
            .map(|i| {
                let mut more = stream(i + n);
                let u = [more.unit(), more.unit(), more.unit()];
                heterogeneous.walk(&stretch, u, &mut more)
            })
            .collect();
        let stretch = RaySegment { ray: &ray, end: length, shares, scatters: false };
        let emission_scale = homogeneous.walk(&stretch, [0.0; 2]).emitted.to_array();
        for band in 0..3 {
            let of = |w: &Walk, scattered: bool| {
                let is = w.scattered.is_some() == scattered;
                if is { f64::from(w.weight.to_array()[band]) } else { 0.0 }
            };
            is(walks.iter().map(|w| of(w, false)), expected[band], "what goes through");
            let c = coefficients();
            let scattered = c.scattering[band] / c.extinction[band] * (1.0 - expected[band]);
            is(walks.iter().map(|w| of(w, true)), scattered, "what is scattered");
            let emitted = walks.iter().map(|w| f64::from(w.emitted.to_array()[band]));
            is(emitted, f64::from(emission_scale[band]), "what it emits");
        }
    }
}

/// A grid whose cells differ in colour, not in place, is a homogeneous medium with these colours.
#[test]
fn colors_of_cells_are_those_of_a_homogeneous_medium() {
    let ([e0, e1, e2], [a0, a1, a2]) = ([0.5f32, 2.0, 1.25], [0.9f32, 0.25, 0.6]);
    let own = coefficients();
    for by_albedo in [true, false] {
        let plain = GridData::new([4, 3, 5], vec![7.0; 60], None).unwrap();
        let scattering = if by_albedo {
            GridScattering::Albedo(vec![[a0, a1, a2]; 60])
        } else {
            GridScattering::Coefficient(vec![[a0 * e0, a1 * e1, a2 * e2]; 60])
        };
        let data = plain.with_extinction(vec![[e0, e1, e2]; 60]).unwrap();
        assert_eq!(data.density(), [2.0; 60]);
        let data = data.with_scattering(scattering).unwrap();
        let bounds = [DVec3::NEG_ONE, DVec3::new(2.0, 1.5, 1.0)];
        let colored = Heterogeneous::new(own, Arc::new(data), false, bounds).unwrap();
        let by = |v: [f64; 3], f: [f32; 3]| [0, 1, 2].map(|i| v[i] * f64::from(f[i]));
        let extinction = by(own.extinction, [e0, e1, e2]);
        let scattering = by(by(own.scattering, [e0, e1, e2]), [a0, a1, a2]);
        let (ray, end) = segments().remove(0);
        let shares = [0.2, 0.5, 0.3];
        let stretch = RaySegment { ray: &ray, end, shares, scatters: true };
        let walks: Vec<Walk> = (0..40_000)
            .map(|i| {
                let mut more = stream(i);
                let u = [more.unit(), more.unit(), more.unit()];
                colored.walk(&stretch, u, &mut more)
            })
            .collect();
        for band in 0..3 {
            let of = |w: &Walk, scattered: bool| {
                let is = w.scattered.is_some() == scattered;
                if is { f64::from(w.weight.to_array()[band]) } else { 0.0 }
            };
            let through = crate::math::elementary::exp(-extinction[band] * end);
            is(walks.iter().map(|w| of(w, false)), through, "what goes through");
            let albedo = scattering[band] / extinction[band];
            is(walks.iter().map(|w| of(w, true)), albedo * (1.0 - through), "what is scattered");
        }
    }
}

/// Between cells colours are interpolated: the albedo itself, or extinction and scattering.
#[test]
fn colors_are_interpolated() {
    let ext = vec![[1.0, 2.0, 4.0], [3.0, 0.0, 4.0]];
    let plain =
        || GridData::new([2, 1, 1], vec![1.0; 2], None).unwrap().with_extinction(ext.clone()).unwrap();
    let middle = |s| plain().with_scattering(s).unwrap().colors_at(DVec3::new(1.0, 0.5, 0.5));
    let albedo = middle(GridScattering::Albedo(vec![[0.5, 1.0, 0.0], [1.0, 1.0, 0.5]]));
    assert_eq!(albedo, [[2.0, 1.0, 4.0], [1.5, 1.0, 1.0]]);
    let parts = middle(GridScattering::Coefficient(vec![[0.5, 2.0, 0.0], [3.0, 0.0, 2.0]]));
    assert_eq!(parts, [[2.0, 1.0, 4.0], [1.75, 1.0, 1.0]]);
    for bad in [
        GridScattering::Albedo(vec![[0.5, 1.0, 0.0], [1.1, 1.0, 0.5]]),
        GridScattering::Coefficient(vec![[1.5, 0.0, 0.0]; 2]),
        GridScattering::Albedo(vec![[0.5; 3]]),
        GridScattering::Albedo(vec![[0.5, f32::NAN, 0.5]; 2]),
    ] {
        assert!(plain().with_scattering(bad).is_err());
    }
    assert!(plain().with_extinction(vec![[1.0, f32::NAN, 0.0]; 2]).is_err());
    assert!(plain().with_extinction(vec![[1.0, -1.0, 0.0]; 2]).is_err());
}

/// A fading border equals a grid with empty cells around it, cut off at the box.
#[test]
fn a_border_fades_as_if_empty_cells_followed() {
    for [nx, ny, nz] in [[1u32, 1, 1], [2, 3, 1], [3, 2, 4]] {
        let value = |x: u32, y: u32, z: u32| (1 + x + 3 * y + 7 * z) as f32;
        let cells = |n: [u32; 3]| {
            let [nx, ny, nz] = n;
            (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
        };
        let own = cells([nx, ny, nz]).map(|[x, y, z]| value(x, y, z)).collect();
        let around = cells([nx + 2, ny + 2, nz + 2]).map(|[x, y, z]| {
            let inside = (1..=nx).contains(&x) && (1..=ny).contains(&y) && (1..=nz).contains(&z);
            if inside { value(x - 1, y - 1, z - 1) } else { 0.0 }
        });
        let own = GridData::new([nx, ny, nz], own, None).unwrap();
        let around = GridData::new([nx + 2, ny + 2, nz + 2], around.collect(), None).unwrap();
        let max = DVec3::from([nx, ny, nz].map(f64::from));
        let fading = Heterogeneous::new(coefficients(), Arc::new(own), true, [DVec3::ZERO, max]).unwrap();
        let mut random = Random::new(5);
        for _ in 0..1000 {
            let p = DVec3::new(random.unit(), random.unit(), random.unit()) * max;
            let (found, expected) = (fading.at(p)[0], around.at(p + 1.0)[0]);
            assert!((found - expected).abs() < 1e-9, "{p}: {found}, {expected}");
        }
    }
}

/// Compared with ray marching in small steps, in a grid of very different densities.
#[test]
fn transmittance_equals_ray_marching() {
    let mut random = Random::new(4);
    let values: Vec<f32> = (0..21 * 13 * 18)
        .map(|_| if random.unit() < 0.7 { 0.0 } else { 4.0 * random.unit() as f32 })
        .collect();
    let heterogeneous = grid([21, 13, 18], |i| values[i]);
    for (ray, end) in segments() {
        let steps = 40_000;
        let step = end / f64::from(steps);
        let depth: f64 = (0..steps)
            .map(|i| {
                let p = (ray.at((f64::from(i) + 0.5) * step) - heterogeneous.min) * heterogeneous.scale;
                let size = DVec3::new(21.0, 13.0, 18.0);
                let inside = p.cmpge(DVec3::ZERO).all() && p.cmple(size).all();
                if inside { heterogeneous.grid.at(p)[0] * step } else { 0.0 }
            })
            .sum();
        let all: Vec<[f32; 3]> = (0..20_000)
            .map(|i| heterogeneous.transmittance(&ray, 0.0, end, &mut stream(i)).to_array())
            .collect();
        for band in 0..3 {
            let expected = crate::math::elementary::exp(-depth * coefficients().extinction[band]);
            is(all.iter().map(|t| f64::from(t[band])), expected, "transmittance");
        }
    }
}

/// The bound of a block holds everywhere in it.
#[test]
fn blocks_bound_their_density() {
    let mut random = Random::new(14);
    let values: Vec<f32> = (0..30 * 17 * 9).map(|_| random.unit() as f32).collect();
    let heterogeneous = grid([30, 17, 9], |i| values[i]);
    for (ray, end) in segments() {
        let mut last = 0.0;
        heterogeneous.visit(&ray, 0.0, end, |from, to, max_density| {
            assert!(from >= last && to > from, "{from} {to} {last}");
            last = to;
            for i in 0..50 {
                let t = from + (to - from) * (f64::from(i) + 0.5) / 50.0;
                let density = heterogeneous.grid.at((ray.at(t) - heterogeneous.min) * heterogeneous.scale)[0];
                assert!(density <= max_density * (1.0 + 1e-6), "{density} > {max_density}");
            }
            true
        });
    }
}

/// Gas of one temperature that absorbs nothing emits evenly along a segment.
#[test]
fn hot_gas_glows_in_the_colour_of_a_black_body() {
    let hot = GridData::new([2, 1, 1], vec![29.0; 2], None).unwrap();
    let bounds = [DVec3::NEG_ONE, DVec3::ONE];
    let none = Coefficients { extinction: [0.0; 3], scattering: [0.0; 3], ..coefficients() };
    let density = GridData::new([1; 3], vec![1.0], None).unwrap();
    let medium = Heterogeneous::new(none, Arc::new(density), false, bounds)
        .unwrap()
        .with_temperatures(Some(Temperatures::new(&Arc::new(hot), bounds, -1.0, 100.0)));
    let ray = Ray::new(DVec3::new(-1.0, 0.2, 0.3), DVec3::X);
    let count = 20_000;
    let mut sum = Spectrum::BLACK;
    for i in 0..count {
        let stretch = RaySegment { ray: &ray, end: 2.0, shares: [1.0 / 3.0; 3], scatters: true };
        let mut more = stream(i);
        let u = [more.unit(), more.unit(), more.unit()];
        sum += medium.walk(&stretch, u, &mut more).emitted * (1.0 / count as f32);
    }
    let glow = crate::color::cie::black_body(3000.0).to_array();
    for (band, seen) in sum.to_array().into_iter().enumerate() {
        let exact = 2.0 * coefficients().emission[band] * f64::from(glow[band]);
        assert!((f64::from(seen) / exact - 1.0).abs() < 0.02, "{band}: {seen} {exact}");
    }
}
