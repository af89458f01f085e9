#![allow(
    clippy::disallowed_methods,
    reason = "expected values are independent of the renderer's own functions"
)]

use super::{LightTree, Receiver};
use crate::light::LightBound;
use crate::material::GlossyLobe;
use crate::math::DVec3;
use crate::testing::{Random, chi_square_tail};

/// Lights of all types in a cube of this size around a point.
fn lights(n: u32, seed: u64, size: f64, center: DVec3) -> Vec<LightBound> {
    let mut random = Random::new(seed);
    let light = |i: u32| {
        let center = center + size * random.in_cube();
        let power = 0.1 + random.unit();
        let axis = random.direction();
        let radius = 0.05 * size * random.unit();
        match i % 5 {
            0 => LightBound::everywhere(center, 0.0, power),
            1 => LightBound::everywhere(center, radius, power),
            2 => LightBound::flat(center, radius, axis, false, power),
            3 => LightBound::flat(center, radius, axis, true, power),
            _ => LightBound::cone(center, axis, 0.95, 0.8, power),
        }
    };
    (0..n).map(light).collect()
}

fn tree(lights: &[LightBound]) -> LightTree {
    LightTree::new(lights.len() as u32, |i| lights[i as usize]).unwrap()
}

fn receivers(size: f64, center: DVec3) -> Vec<Receiver> {
    let mut random = Random::new(9);
    let mut out = Vec::new();
    for reach in [0.1, 1.0, 1.0, 3.0, 100.0] {
        let p = center + reach * size * random.in_cube();
        out.push(Receiver::from(p));
        let facing = Receiver::facing(p, random.direction());
        out.push(facing);
        let axis = random.direction().as_vec3().to_array();
        out.push(facing.with_lobe(GlossyLobe { axis, tightness: 20.0, peak: 5.0 }));
    }
    out
}

#[test]
fn probabilities_add_up_to_one() {
    for (n, size, center) in [
        (1, 1.0, DVec3::ZERO),
        (2, 1.0, DVec3::ZERO),
        (5, 1.0, DVec3::ZERO),
        (1000, 1.0, DVec3::ZERO),
        (1000, 1e-6, DVec3::ZERO),
        (1000, 1e7, DVec3::ZERO),
        (1000, 1.0, DVec3::new(1e6, 0.0, -3e5)),
    ] {
        let lights = lights(n, 3, size, center);
        let tree = tree(&lights);
        for at in receivers(size, center) {
            let sum: f64 = (0..n).map(|i| tree.probability(&at, i)).sum();
            // Children may not keep what the importance of their node promises: then no light is chosen.
            let m = 4000;
            let none = (0..m).filter(|i| tree.sample(&at, (f64::from(*i) + 0.5) / f64::from(m)).is_none());
            let none = none.count() as f64 / f64::from(m);
            assert!((sum + none - 1.0).abs() < 0.02, "{n} {size} {at:?}: {sum} and {none}");
            // Lights that emit in all directions keep it.
            let round = |i: u32| LightBound { cos_o: -1.0, ..lights[i as usize] };
            let round = LightTree::new(n, round).unwrap();
            let everywhere = Receiver::from(at.p);
            let sum: f64 = (0..n).map(|i| round.probability(&everywhere, i)).sum();
            assert!((sum - 1.0).abs() < 1e-9, "{n} {size} {at:?}: {sum}");
        }
        assert_eq!(tree.probability(&Receiver::from(DVec3::ZERO), n), 0.0);
    }
}

#[test]
fn lights_are_chosen_as_often_as_their_probability_says() {
    let lights = lights(200, 4, 1.0, DVec3::ZERO);
    let tree = tree(&lights);
    let mut random = Random::new(1);
    for at in receivers(1.0, DVec3::ZERO) {
        let n = 50_000;
        let mut counts = vec![0.0; lights.len()];
        let (mut left_sum, mut none) = (0.0, 0.0);
        for _ in 0..n {
            let Some((light, probability, left)) = tree.sample(&at, random.unit()) else {
                none += 1.0;
                continue;
            };
            assert_eq!(probability, tree.probability(&at, light));
            assert!((0.0..1.0).contains(&left));
            counts[light as usize] += 1.0;
            left_sum += left;
        }
        // Choosing no light is an outcome of its own.
        let promised: f64 = (0..200).map(|i| tree.probability(&at, i)).sum();
        if promised == 0.0 {
            assert_eq!(none, f64::from(n));
            continue;
        }
        let (mut chi2, mut cells) = (0.0, 0.0);
        let (mut rest, mut rest_found) = ((1.0 - promised).max(0.0) * f64::from(n), none);
        for (i, found) in counts.iter().enumerate() {
            let expected = tree.probability(&at, i as u32) * f64::from(n);
            if expected > 8.0 {
                chi2 += (found - expected) * (found - expected) / expected;
                cells += 1.0;
            } else {
                rest += expected;
                rest_found += found;
            }
        }
        if rest > 8.0 {
            chi2 += (rest_found - rest) * (rest_found - rest) / rest;
            cells += 1.0;
        }
        assert!(cells > 3.0 && chi_square_tail(chi2, cells - 1.0) > 1e-5, "{at:?}: {chi2} of {cells}");
        // The rescaled number is uniform: its mean is within five standard errors of a half.
        let chosen = f64::from(n) - none;
        let mean = left_sum / chosen;
        assert!((mean - 0.5).abs() < 5.0 * (1.0 / 12.0 / chosen).sqrt(), "{mean}");
    }
}

/// Light from a point of the bound in a direction within its cone must have a positive probability.
#[test]
fn no_light_that_arrives_has_probability_zero() {
    let lights = lights(1000, 5, 1.0, DVec3::ZERO);
    let tree = tree(&lights);
    let mut random = Random::new(2);
    let mut tested = 0;
    for _ in 0..200_000 {
        let i = (random.unit() * lights.len() as f64) as usize;
        let light = &lights[i];
        let q = light.center + light.radius * random.direction();
        let p = 1.2 * random.in_cube();
        let w = (p - q).normalize();
        let cos = light.axis.dot(w);
        let cos = if light.two_sided { cos.abs() } else { cos };
        // The angle from the nearest normal, by the platform's functions.
        let beyond = (cos.clamp(-1.0, 1.0).acos() - light.cos_o.acos()).max(0.0);
        if beyond > light.cos_e.acos() {
            continue;
        }
        // A normal on the light's side.
        let n = random.direction();
        let n = if n.dot(w) < 0.0 { n } else { -n };
        tested += 1;
        assert!(tree.probability(&Receiver::facing(p, n), i as u32) > 0.0, "{light:?} {p} {n}");
    }
    assert!(tested > 50_000);
}

#[test]
fn lights_are_chosen_by_their_contribution() {
    // Lights over a floor: one sample has next to no variance relative to the square of the mean.
    let mut random = Random::new(8);
    let mut light =
        || LightBound::everywhere(DVec3::new(10.0, 1.0, 10.0) * random.in_cube() + 3.0 * DVec3::Y, 0.02, 1.0);
    let lights: Vec<_> = (0..2000).map(|_| light()).collect();
    let tree = tree(&lights);
    let (mut by_tree, mut by_table) = (0.0, 0.0);
    for _ in 0..20 {
        let p = DVec3::new(8.0, 0.0, 8.0) * random.in_cube();
        let at = Receiver::facing(p, DVec3::Y);
        let contribution = |b: &LightBound| {
            let d = b.center - p;
            d.y / (d.length() * d.length_squared())
        };
        let sum: f64 = lights.iter().map(contribution).sum();
        let second = |probability: &dyn Fn(u32) -> f64| {
            let squares =
                lights.iter().zip(0..).map(|(b, i)| contribution(b) * contribution(b) / probability(i));
            squares.sum::<f64>() / (sum * sum) - 1.0
        };
        by_tree += second(&|i| tree.probability(&at, i)) / 20.0;
        by_table += second(&|_| 1.0 / 2000.0) / 20.0;
    }
    assert!(by_tree < 0.05 && by_table > 1.0, "{by_tree} and {by_table}");
    // Lights that face away or lie behind the surface are never chosen.
    let mut pair = vec![
        LightBound::flat(DVec3::Y, 0.1, DVec3::Y, false, 1.0),
        LightBound::flat(DVec3::Y, 0.1, DVec3::NEG_Y, false, 1.0),
        LightBound::everywhere(DVec3::NEG_Y, 0.1, 100.0),
    ];
    let at = Receiver::facing(DVec3::ZERO, DVec3::Y);
    let probabilities = |lights: &[LightBound]| {
        let tree = LightTree::new(3, |i| lights[i as usize]).unwrap();
        [0, 1, 2].map(|i| tree.probability(&at, i))
    };
    assert_eq!(probabilities(&pair), [0.0, 1.0, 0.0]);
    pair[0].two_sided = true;
    let [back, front, behind] = probabilities(&pair);
    assert!((back - 0.5).abs() < 1e-6 && (front - 0.5).abs() < 1e-6 && behind == 0.0);
}

#[test]
fn spots_with_wide_rims_keep_their_light() {
    for (full, rim) in
        [(180.0, 180.0), (0.0, 180.0), (120.0, 180.0), (0.0, 90.0), (30.0, 30.0), (5.0, 120.0f64)]
    {
        let cos = |degrees: f64| degrees.to_radians().cos();
        let b = LightBound::cone(DVec3::ZERO, DVec3::Y, cos(full), cos(rim), 1.0);
        let whole = b.cos_o.acos() + b.cos_e.acos();
        assert!(b.cos_e >= 0.0 && whole >= rim.to_radians() - 1e-7, "{full} {rim}: {b:?}");
    }
}

#[test]
fn degenerate_lights_do_no_harm() {
    let nan = f64::NAN;
    let all = |center: DVec3, radius: f64, power: f64| LightBound::everywhere(center, radius, power);
    let mut cases: Vec<Vec<LightBound>> = vec![
        // All at one point.
        vec![all(DVec3::ONE, 0.0, 1.0); 5000],
        // Without power.
        vec![all(DVec3::ONE, 0.0, 0.0); 50],
        // Non-finite or huge values.
        vec![
            all(DVec3::NAN, 1.0, 1.0),
            all(DVec3::INFINITY, 1.0, 1.0),
            all(DVec3::ZERO, nan, 1.0),
            all(DVec3::ZERO, f64::INFINITY, 1.0),
            all(DVec3::ZERO, -1.0, 1.0),
            all(DVec3::ZERO, 1.0, nan),
            all(DVec3::ZERO, 1.0, f64::INFINITY),
            all(DVec3::ZERO, 1.0, -1.0),
            LightBound::flat(DVec3::ZERO, 0.0, DVec3::NAN, false, 1.0),
            LightBound { cos_o: nan, ..all(DVec3::ZERO, 0.0, 1.0) },
            LightBound { cos_e: nan, ..all(DVec3::ZERO, 0.0, 1.0) },
            all(DVec3::splat(1e300), 1.0, 1e300),
            all(DVec3::splat(-1e300), 1.0, 1e-300),
        ],
    ];
    // Closer and closer together, so that splits by position separate one light at a time.
    cases.push((0..900).map(|i| all(DVec3::X * 0.5f64.powi(i), 0.0, 1.0)).collect());
    for lights in cases {
        let tree = tree(&lights);
        for p in [DVec3::ZERO, DVec3::ONE, DVec3::new(3.0, -2.0, 1.0), DVec3::splat(1e9)] {
            let at = Receiver::from(p);
            let sum: f64 = (0..lights.len() as u32).map(|i| tree.probability(&at, i)).sum();
            assert!((sum - 1.0).abs() < 1e-9, "{} at {p}: {sum}", lights.len());
            for u in [0.0, 0.3, 1.0 - f64::EPSILON, 1.0] {
                let (light, probability, left) = tree.sample(&at, u).unwrap();
                assert!((light as usize) < lights.len() && probability > 0.0 && (0.0..1.0).contains(&left));
            }
        }
        for p in [DVec3::NAN, DVec3::INFINITY] {
            let found = tree.sample(&Receiver::from(p), 0.5);
            assert!(found.is_none_or(|(light, ..)| (light as usize) < lights.len()));
            assert!((0.0..=1.0).contains(&tree.probability(&Receiver::from(p), 0)));
        }
    }
    assert!(LightTree::new(0, |_| all(DVec3::ZERO, 0.0, 1.0)).is_none());
    assert!(LightTree::new(LightTree::MOST + 1, |_| all(DVec3::ZERO, 0.0, 1.0)).is_none());
}

#[test]
fn memory_is_as_documented() {
    let lights = lights(20_000, 6, 1.0, DVec3::ZERO);
    let each = tree(&lights).bytes() / lights.len();
    assert!(each < 8 + 192 / 2, "{each} bytes a light");
}

#[test]
fn glossy_surfaces_choose_lights_in_their_lobe() {
    // Two equal lights, one in the mirrored direction and one just as far away at its side.
    let lights = [DVec3::new(0.0, 3.0, 3.0), DVec3::new(3.0, 3.0, 0.0)];
    let tree = tree(&lights.map(|p| LightBound::everywhere(p, 0.1, 1.0)));
    let plain = Receiver::facing(DVec3::ZERO, DVec3::Y);
    assert!((tree.probability(&plain, 0) - 0.5).abs() < 1e-6);
    let axis = lights[0].normalize().as_vec3().to_array();
    let glossy = plain.with_lobe(GlossyLobe { axis, tightness: 100.0, peak: 100.0 });
    // 60 degrees away the microfacet normals are rotated by 30, less what the light fills.
    let away = (30.0 - (0.1 / 18f64.sqrt()).asin().to_degrees() / 2.0).to_radians().tan().powi(2);
    let other = 1.0 + 100.0 / (1.0 + 100.0 * away).powi(2);
    let expected = 101.0 / (101.0 + other);
    assert!(
        (tree.probability(&glossy, 0) - expected).abs() < 1e-4,
        "{} {expected}",
        tree.probability(&glossy, 0)
    );
}
