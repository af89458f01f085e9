//! The light BVH for many lights (Conty Estevez and Kulla 2018): the same picture as with a single table for all
//! points, and probabilities that sum to 1.

use std::fmt::Write;

use turner::light::{LightBound, LightTree, Receiver};
use turner::math::{DVec2, DVec3};
use turner::scene::LightChoice;
use turner::schema::SceneError;
use turner::testing::{ChiSquareOptions, CompareOptions, Random, chi_square_on_square, compare};

use super::check::{Check, Context, Finding, fault};

pub(super) fn checks() -> Vec<Check> {
    vec![
        Check::chance("estimators/light-tree-and-table", tree_and_table),
        Check::limit("density/light-tree-sums-to-1", sums),
        Check::chance("density/light-tree", choices),
    ]
}

/// A room with 200 lights of three types.
fn hall() -> String {
    let mut random = Random::new(7);
    let mut text = "integrator = { type = \"path\", max_depth = 2 }\n\
        camera = { position = [0, 3, 9], look_at = [0, 0.5, 0], fov = 60 }\n\
        [material]\nfloor = { type = \"matte\", color = 0.6 }\n\
        lamp = { type = \"principled\", base_weight = 0, specular_weight = 0, emission_luminance = 3 }\n\
        front = { type = \"principled\", base_weight = 0, specular_weight = 0, emission_luminance = 4, double_sided = false }\n\
        [[object]]\ntype = \"plane\"\nmaterial = \"floor\"\n\
        [[object]]\ntype = \"sphere\"\ncenter = [1.5, 1, 0]\nradius = 1\nmaterial = \"floor\"\n"
        .to_owned();
    let show = |v: DVec3| format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z);
    for i in 0..200 {
        let p = DVec3::new(12.0, 2.0, 8.0) * random.in_cube() + DVec3::new(0.0, 3.5, 0.0);
        let (a, b) = (0.3 * random.direction(), 0.3 * random.direction());
        let (p, a, b) = (show(p), show(a), show(b));
        let _ = match i % 3 {
            0 => writeln!(
                text,
                "[[object]]\ntype = \"sphere\"\ncenter = {p}\nradius = 0.15\nmaterial = \"lamp\""
            ),
            1 => writeln!(
                text,
                "[[object]]\ntype = \"rectangle\"\ncenter = {p}\nedge_u = {a}\nedge_v = {b}\nmaterial = \"front\""
            ),
            _ => writeln!(
                text,
                "[[light]]\ntype = \"point\"\nposition = {p}\nintensity = 0.05\nattenuation = \"inverse-square\""
            ),
        };
    }
    text
}

fn tree_and_table(cx: &Context) -> Result<Finding, SceneError> {
    let render = |how, samples: u32| {
        let mut scene = cx.scene([12, 12], cx.times(samples), &hall())?;
        std::sync::Arc::make_mut(&mut scene.scene).choose_lights(how);
        if (scene.scene.emitters.tree_bytes() > 0) != (how == LightChoice::Tree) {
            return Err(fault("the light sampler is not the requested one"));
        }
        cx.runs(&scene, 8, &format!("light-tree/{how:?}"))
    };
    let (tree, table) = (render(LightChoice::Tree, 32)?, render(LightChoice::Table, 192)?);
    // Lights near a point give heavy tails, which eight runs do not resolve: hence the tolerance.
    let options = CompareOptions { tolerance: 4e-6, absolute: 1e-9, ..CompareOptions::default() };
    Ok(Finding::comparison(&compare(&tree, &table, &options), 0.03))
}

/// A tree over spherical and flat bounds, or over spherical ones only if `round`.
fn tree(random: &mut Random, count: u32, round: bool) -> Option<LightTree> {
    let mut one = |i: u32| {
        let (center, power) = (4.0 * random.in_cube(), random.unit() + 0.05);
        match if round { 0 } else { i % 3 } {
            0 => LightBound::everywhere(center, 0.1 * random.unit(), power),
            1 => LightBound::flat(center, 0.2 * random.unit(), random.direction(), false, power),
            _ => LightBound::flat(center, 0.2 * random.unit(), random.direction(), true, power),
        }
    };
    let bounds: Vec<LightBound> = (0..count).map(&mut one).collect();
    LightTree::new(count, |i| {
        bounds.get(i as usize).copied().unwrap_or(LightBound::everywhere(DVec3::ZERO, 0.0, 0.0))
    })
}

/// At a point that all lights illuminate, the probabilities sum to 1. Elsewhere they sum to at most 1: a subtree with
/// importance 0 is not replaced by another.
fn sums(cx: &Context) -> Result<Finding, SceneError> {
    let mut random = Random::new(cx.seed_for("light-tree-sums"));
    let (mut worst, mut points) = (0.0f64, 0);
    for count in [1, 2, 7, 8, 9, 64, 65, 1000] {
        for round in [true, false] {
            let tree = tree(&mut random, count, round).ok_or_else(|| fault("no tree"))?;
            for _ in 0..100 {
                let p = 6.0 * random.in_cube();
                let at = if round { Receiver::from(p) } else { Receiver::facing(p, random.direction()) };
                let sum: f64 = (0..count).map(|i| tree.probability(&at, i)).sum();
                worst = worst.max(sum - 1.0).max(if round { 1.0 - sum } else { 0.0 });
                points += 1;
            }
        }
    }
    Ok(Finding::limit(
        worst,
        1e-9,
        format!("off by {worst:.1e} at {points} points, trees of 1 to 1000 lights"),
    ))
}

/// The frequencies of sampled lights agree with their probabilities (chi-square).
fn choices(cx: &Context) -> Result<Finding, SceneError> {
    let mut random = Random::new(cx.seed_for("light-tree-choices"));
    let count = 60;
    let tree = tree(&mut random, count, true).ok_or_else(|| fault("no tree"))?;
    let at = Receiver::from(6.0 * random.in_cube());
    let options = ChiSquareOptions {
        samples: cx.times(20_000),
        rows: count,
        columns: 4,
        ..ChiSquareOptions::default()
    };
    let rows = f64::from(count);
    let density = |p: DVec2| rows * tree.probability(&at, (p.x * rows) as u32);
    let sample = || {
        let (i, _, rest) = tree.sample(&at, random.unit())?;
        Some(DVec2::new((f64::from(i) + 0.5) / rows, rest))
    };
    let test = chi_square_on_square(&options, density, sample);
    Ok(Finding::chance(
        test.p_value,
        format!("χ² {:.0} of {}, ∫ {:.4}", test.statistic, test.freedom, test.covered),
    ))
}
