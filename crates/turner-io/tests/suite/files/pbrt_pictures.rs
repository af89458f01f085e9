//! Compares pbrt scenes with renderings by other renderers: Tungsten (by the author of the scenes) and pbrt-v4.

use std::path::Path;

use turner::film::PixelRect;
use turner::testing::{Estimate, render_runs};
use turner_io::scene::{LoadOptions, Override, load};

/// Means of 4 × 4 blocks of a picture, row by row.
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

/// The Veach scene by pbrt-v4, 64 × 36, 8192 samples, path depth 65. (Tungsten's picture shows plates of albedo 0.3,
/// which the file does not specify.)
const VEACH: Blocks = [
    [0.09539, 0.09467, 0.09447],
    [3.49188, 3.48581, 3.46571],
    [2.97360, 2.97249, 2.97259],
    [0.09709, 0.09639, 0.09622],
    [0.09934, 0.09806, 0.09768],
    [2.86859, 1.89998, 1.62221],
    [2.94832, 2.09980, 1.84699],
    [0.10198, 0.10035, 0.09991],
    [0.08845, 0.08133, 0.07912],
    [2.21598, 1.49220, 1.29316],
    [2.00060, 1.34663, 1.16734],
    [0.09300, 0.08488, 0.08323],
    [0.06267, 0.05498, 0.05288],
    [0.24240, 0.17332, 0.15523],
    [0.25171, 0.17705, 0.15777],
    [0.06513, 0.05646, 0.05418],
];

/// How a file is rendered, and the expected noise of the blocks and the picture.
struct Shot {
    size: [u32; 2],
    samples: u32,
    noise: [f64; 2],
}

/// Renders a file with its own camera and compares the means of 4 × 4 blocks and of the picture. `within` is the
/// allowed difference of each block beyond its noise.
fn compare(name: &str, shot: &Shot, expected: &Blocks, within: impl Fn(usize) -> f64) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/assets/pbrt").join(name);
    let set = |key: &str, value: u32| Override::parse(&format!("{key}={value}")).unwrap();
    let overrides = vec![
        set("film.width", shot.size[0]),
        set("film.height", shot.size[1]),
        set("film.samples", shot.samples),
        // Fewer samples than the files specify, for speed.
        set("integrator.max_depth", 65),
    ];
    let options = LoadOptions { overrides, ..LoadOptions::default() };
    let loaded = load(&path, &options).unwrap();
    assert!(loaded.desc.warnings.is_empty(), "{:?}", loaded.desc.warnings);
    let scene = loaded.desc.prepare(&Default::default()).unwrap();
    let runs = render_runs(&scene, 8, 5, 2).unwrap();
    let [width, height] = shot.size.map(|v| v / 4);
    let mut total = [0.0; 3];
    for (i, block) in expected.iter().enumerate() {
        let (x, y) = (i as u32 % 4 * width, i as u32 / 4 * height);
        let rect = PixelRect { x, y, width, height };
        for (band, expected) in block.iter().enumerate() {
            let found = runs.moments(&rect, band);
            total[band] += expected / 16.0;
            let (mean, error) = (found.mean, found.error());
            assert!(error < shot.noise[0] * expected, "too noisy: {i} {band}: {mean} ± {error}");
            let off = (mean - expected).abs();
            assert!(
                off < 5.0 * error + within(i) * expected,
                "{i} {band}: {mean} ± {error}, expected {expected}"
            );
        }
    }
    for (band, expected) in total.iter().enumerate() {
        let (mean, error) = (runs.mean(band).mean, runs.mean(band).error());
        assert!(error < shot.noise[1] * expected, "too noisy: {mean} ± {error}");
        assert!(
            (mean / expected - 1.0).abs() < 0.01 + 2.0 * error / expected,
            "{band}: {mean} ± {error}, expected {expected}"
        );
    }
}

#[test]
fn the_cornell_box_is_tungstens() {
    let shot = Shot { size: [64, 64], samples: 24, noise: [0.05, 0.005] };
    compare("cornell-box/scene-v4.pbrt", &shot, &CORNELL, |_| 0.01);
}

#[test]
fn the_veach_scene_is_pbrts() {
    // The light that the plates reflect to walls and floor arrives by few bright paths.
    let shot = Shot { size: [64, 36], samples: 96, noise: [0.1, 0.02] };
    compare("veach-mis/scene-v4.pbrt", &shot, &VEACH, |_| 0.03);
}

#[test]
fn what_the_file_says_of_the_picture_counts() {
    let text = "Film \"rgb\" \"integer xresolution\" 40 \"integer yresolution\" 30 \"float maxcomponentvalue\" 12.5\n\
                \"integer pixelbounds\" [ 4 20 6 16 ] Sampler \"zsobol\" \"integer pixelsamples\" 9 PixelFilter \"box\"\n\
                Integrator \"volpath\" \"integer maxdepth\" 7 WorldBegin Shape \"sphere\"";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.pbrt");
    std::fs::write(&path, text).unwrap();
    let loaded = load(&path, &LoadOptions::default()).unwrap();
    let film = &loaded.desc.film;
    assert_eq!((film.width, film.height, film.crop), (40, 30, Some([4, 6, 16, 10])));
    assert_eq!((film.samples, film.clamp_sample, film.filter), (9, 12.5, turner::filter::FilterKind::Box));
    let turner::integrator::IntegratorDesc::Path(path) = &loaded.desc.integrator else { panic!("paths") };
    assert_eq!(path.max_depth, 7);
}
