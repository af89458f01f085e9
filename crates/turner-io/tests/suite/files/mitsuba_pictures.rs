//! Compares Mitsuba scenes with renderings by Mitsuba 3.9.1 (variant scalar_rgb), and the Cornell box with Tungsten.

use std::path::Path;

use turner::film::PixelRect;
use turner::testing::{Estimate, render_runs};
use turner_io::scene::{LoadOptions, Override, load};

/// Means of 4 × 4 blocks of a picture, row by row.
type Blocks = [[f64; 3]; 16];

/// Shapes and textures (`shapes.xml`) by Mitsuba, 1024 samples.
const SHAPES: Blocks = [
    [0.14156, 0.17695, 0.21234],
    [0.20000, 0.25000, 0.30000],
    [0.20000, 0.25000, 0.30000],
    [0.20000, 0.25000, 0.30000],
    [0.12286, 0.12092, 0.20095],
    [0.26765, 0.28180, 0.31337],
    [0.21890, 0.20686, 0.24621],
    [0.14797, 0.20346, 0.20928],
    [0.06828, 0.03812, 0.12998],
    [0.17724, 0.09594, 0.12850],
    [0.12600, 0.08961, 0.12640],
    [0.18012, 0.09787, 0.12424],
    [0.06785, 0.17484, 0.41676],
    [0.19734, 0.15866, 0.30419],
    [0.47441, 0.12048, 0.06197],
    [0.22890, 0.15170, 0.26992],
];

/// BSDFs (`bsdfs.xml`) by Mitsuba, 1024 samples.
const BSDFS: Blocks = [
    [0.53929, 0.40194, 0.34893],
    [0.54650, 0.46514, 0.27428],
    [0.57663, 0.44300, 0.39304],
    [0.24637, 0.29433, 0.45175],
    [0.40412, 0.30895, 0.25782],
    [0.26552, 0.32496, 0.24331],
    [0.36688, 0.36174, 0.34949],
    [0.39734, 0.39695, 0.39441],
    [0.39877, 0.31320, 0.26781],
    [0.29663, 0.34728, 0.27431],
    [0.34015, 0.34547, 0.32478],
    [0.39547, 0.39430, 0.37810],
    [0.40318, 0.39586, 0.39177],
    [0.50600, 0.27324, 0.26619],
    [0.26084, 0.43604, 0.25061],
    [0.52055, 0.48520, 0.26807],
];

/// Lights and a medium (`lights.xml`) by Mitsuba, 1024 samples.
const LIGHTS: Blocks = [
    [0.21727, 0.19995, 0.26645],
    [0.20185, 0.19995, 0.26583],
    [0.18377, 0.19995, 0.26583],
    [0.16515, 0.19995, 0.26645],
    [0.30950, 0.31962, 0.42471],
    [0.33331, 0.35199, 0.45083],
    [0.34864, 0.34470, 0.38346],
    [0.31834, 0.32813, 0.37390],
    [0.33002, 0.34864, 0.46946],
    [0.43096, 0.45757, 0.56378],
    [0.48378, 0.48688, 0.54323],
    [0.42200, 0.46416, 0.55138],
    [0.41866, 0.42553, 0.53210],
    [0.46782, 0.46598, 0.56155],
    [0.46349, 0.47036, 0.57633],
    [0.40864, 0.42845, 0.54957],
];

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

/// Renders a file with its own sensor and compares the means of 4 × 4 blocks and of the picture. `within` is the
/// allowed difference of each block beyond its noise, `whole` that of the picture.
fn compare(name: &str, samples: u32, expected: &Blocks, whole: f64, within: impl Fn(usize) -> f64) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/assets/mitsuba").join(name);
    let set = |key: &str, value: u32| Override::parse(&format!("{key}={value}")).unwrap();
    let overrides = vec![set("film.width", 64), set("film.height", 64), set("film.samples", samples)];
    let options = LoadOptions { overrides, ..LoadOptions::default() };
    let loaded = load(&path, &options).unwrap();
    assert!(loaded.desc.warnings.is_empty(), "{:?}", loaded.desc.warnings);
    let scene = loaded.desc.prepare(&Default::default()).unwrap();
    let runs = render_runs(&scene, 8, 5, 2).unwrap();
    let mut total = [0.0; 3];
    let mut wrong = Vec::new();
    for (i, block) in expected.iter().enumerate() {
        let (x, y) = (i as u32 % 4 * 16, i as u32 / 4 * 16);
        let rect = PixelRect { x, y, width: 16, height: 16 };
        for (band, expected) in block.iter().enumerate() {
            let found = runs.moments(&rect, band);
            total[band] += expected / 16.0;
            let (mean, error) = (found.mean, found.error());
            if error > 0.05 * expected || (mean - expected).abs() > 5.0 * error + within(i) * expected {
                wrong.push(format!("{i} {band}: {mean} ± {error}, expected {expected}"));
            }
        }
    }
    for (band, expected) in total.iter().enumerate() {
        let (mean, error) = (runs.mean(band).mean, runs.mean(band).error());
        println!("{name} {band}: {:.5} ± {:.5}", mean / expected, error / expected);
        if error > 0.005 * expected || (mean / expected - 1.0).abs() > whole + 3.0 * error / expected {
            wrong.push(format!("all, {band}: {} ± {}", mean / expected, error / expected));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_cornell_box_is_tungstens_in_mitsubas_words() {
    compare("cornell-box/scene_v3.xml", 24, &CORNELL, 0.005, |_| 0.01);
}

#[test]
fn shapes_and_textures_are_mitsubas() {
    // The normals of the tent in block 6 deviate up to 50 degrees from its faces; Mitsuba leaks light through the
    // faces there. With `face_normals` everything agrees within 0.001.
    compare("shapes.xml", 64, &SHAPES, 0.003, |part| if part == 6 { 0.04 } else { 0.01 });
}

#[test]
fn bsdfs_are_mitsubas() {
    // Measured sphere by sphere. Mitsuba's rough plastic (9) differs by 1.4 %. Its blend of diffuse and mirror
    // (13) reflects 0.27 of 0.37 in a white furnace, ours 0.37. Its "principled" (15) is another model: 2 to 3 %.
    let within = |part| match part {
        9 => 0.015,
        13 => 0.14,
        15 => 0.025,
        _ => 0.01,
    };
    compare("bsdfs.xml", 64, &BSDFS, 0.025, within);
}

#[test]
fn lights_and_media_are_mitsubas() {
    compare("lights.xml", 64, &LIGHTS, 0.003, |_| 0.01);
}
