//! pbrt scenes against pictures of other renderers: Tungsten's by the author of the scenes, Mitsuba's of the same numbers.

use std::path::Path;
use turner::film::PixelRect;
use turner::testing::{Estimate, render_runs};
use turner_io::scene::{LoadOptions, Override, load};

/// Means of 4 × 4 parts of a picture, row by row.
type Blocks = [[f64; 3]; 16];

/// The Cornell box by Tungsten, 1024 × 1024.
const CORNELL: Blocks = [
    [0.12086, 0.03428, 0.00900],
    [0.79146, 0.53945, 0.17484],
    [0.73961, 0.52049, 0.16660],
    [0.05605, 0.05862, 0.00873],
    [0.19486, 0.05025, 0.01436],
    [0.22939, 0.14246, 0.04168],
    [0.24749, 0.17579, 0.04909],
    [0.09571, 0.10622, 0.01713],
    [0.11757, 0.02433, 0.00680],
    [0.07383, 0.04289, 0.01124],
    [0.14538, 0.10697, 0.02859],
    [0.07479, 0.08632, 0.01348],
    [0.08122, 0.02545, 0.00727],
    [0.10382, 0.05959, 0.01740],
    [0.01678, 0.00804, 0.00214],
    [0.05120, 0.05936, 0.00924],
];

/// Renders a file with its own camera, and compares the means of 4 × 4 parts and of all. `within` is what the pictures may differ beside their noise.
fn compare(name: &str, size: u32, samples: u32, expected: &Blocks, within: f64) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/assets/pbrt").join(name);
    let set = |key: &str, value: u32| Override::parse(&format!("{key}={value}")).unwrap();
    let overrides = vec![
        set("film.width", size),
        set("film.height", size),
        set("film.samples", samples),
        // The files say less, to be fast.
        set("integrator.max_depth", 65),
    ];
    let options = LoadOptions { overrides, ..LoadOptions::default() };
    let loaded = load(&path, &options).unwrap();
    assert!(loaded.desc.warnings.is_empty(), "{:?}", loaded.desc.warnings);
    let mut scene = loaded.desc.prepare(&Default::default()).unwrap();
    let runs = render_runs(&mut scene, 8, 5, 2).unwrap();
    let side = size / 4;
    let mut total = [0.0; 3];
    for (i, block) in expected.iter().enumerate() {
        let (x, y) = (i as u32 % 4 * side, i as u32 / 4 * side);
        let rect = PixelRect { x, y, width: side, height: side };
        for (band, expected) in block.iter().enumerate() {
            let found = runs.moments(&rect, band);
            total[band] += expected / 16.0;
            let off = (found.mean - expected).abs();
            assert!(
                found.error() < 0.05 * expected,
                "too noisy: {i} {band}: {} ± {}",
                found.mean,
                found.error()
            );
            assert!(
                off < 5.0 * found.error() + within * expected,
                "{i} {band}: {} ± {}, expected {expected}",
                found.mean,
                found.error()
            );
        }
    }
    for (band, expected) in total.iter().enumerate() {
        let found = runs.mean(band);
        assert!(found.error() < 0.005 * expected, "too noisy: {} ± {}", found.mean, found.error());
        assert!(
            (found.mean / expected - 1.0).abs() < 0.01,
            "{band}: {} ± {}, expected {expected}",
            found.mean,
            found.error()
        );
    }
}

#[test]
fn the_cornell_box_is_tungstens() {
    compare("cornell-box/scene-v4.pbrt", 64, 24, &CORNELL, 0.01);
}
