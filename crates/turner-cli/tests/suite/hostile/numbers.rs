//! Scenes with numbers at the limits of their ranges and beyond: the behaviour is defined, and no pixel is NaN.

use super::run::{Case, Expected};
use super::scenes::around;

/// Lines with a `$` for each of the numbers.
const LINES: [&str; 38] = [
    "[film]\nwidth = $",
    "[film]\ncrop = [0, 0, $, 1]",
    "[film]\nsamples = $\nantialias = \"grid\"",
    "[film]\nexposure = $",
    "[film]\nmax_sample = $",
    "[camera]\nshift = [$, $]",
    "[film]\nfilter_radius = $\nantialias = \"monte-carlo\"",
    "[camera]\nposition = [$, 0, 5]",
    "[camera]\nposition = [0, 0, 5]\nfov = $",
    "[camera]\nposition = [0, 0, 5]\nlook_at = [0, $, 0]",
    "[camera]\nposition = [0, 0, 5]\nup = [0, $, 0]",
    "[camera]\ntype = \"thin-lens\"\nposition = [0, 0, 5]\naperture_radius = $",
    "[camera]\ntype = \"realistic\"\nposition = [0, 0, 5]\naperture_diameter = $\nelements = [[0, 5, 0, 9], [80, 4, 1.5, 20], [-80, 0, 1, 20]]",
    "[camera]\ntype = \"realistic\"\nposition = [0, 0, 5]\nfilm_diagonal = $\nelements = [[80, 4, 1.5, $], [-80, 0, 1, 20]]",
    "[integrator]\nmax_depth = $",
    "[integrator]\ntype = \"path\"\nclamp_indirect = $",
    "[background]\ncolor = [$, 0, 1]",
    "[[object]]\ntype = \"sphere\"\nradius = $",
    "[[object]]\ntype = \"sphere\"\ncenter = [$, $, 0]",
    "[[object]]\ntype = \"box\"\nmin = [0, 0, 0]\nmax = [$, 1, 1]",
    "[[object]]\ntype = \"torus\"\nradius = $\ntube = 0.2",
    "[[object]]\ntype = \"cylinder\"\nradius = $",
    "[[object]]\ntype = \"cone\"\nheight = $",
    "[[object]]\ntype = \"disk\"\nradius = $",
    "[[object]]\ntype = \"sphere\"\ntransform = [{ scale = $ }]",
    "[[object]]\ntype = \"sphere\"\ntransform = [{ translate = [$, 0, 0] }]",
    "[[object]]\ntype = \"sphere\"\ntransform = [{ rotate = { axis = [0, $, 0], angle = 30 } }]",
    "[[object]]\ntype = \"mesh\"\npositions = [[0, 0, 0], [$, 0, 0], [0, $, 0]]\ntriangles = [[0, 1, 2]]",
    "[[object]]\ntype = \"mesh\"\npositions = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\ntriangles = [[0, 1, $]]",
    "[[object]]\ntype = \"sphere\"\nmaterial = { type = \"dielectric\", ior = $ }",
    "[[object]]\ntype = \"sphere\"\nmaterial = { type = \"metal\", roughness = $ }",
    "[[object]]\ntype = \"sphere\"\nmaterial = { shininess = $ }",
    "[[light]]\ntype = \"point\"\nposition = [0, 0, $]\nintensity = $",
    "[[light]]\ntype = \"directional\"\nfrom = [0, $, 0]",
    "[[light]]\ntype = \"spot\"\nposition = [0, 3, 0]\nlook_at = [0, $, 0]\nangle = $",
    "[[light]]\ntype = \"sky\"\nturbidity = $",
    "[texture.t]\ntype = \"marble\"\nscale = $\n[[object]]\ntype = \"sphere\"\nmaterial = { color = \"t\" }",
    "[medium.m]\nextinction = $\n[[object]]\ntype = \"sphere\"\nmedium = \"m\"\n[integrator]\ntype = \"path\"",
];

const NUMBERS: [&str; 9] =
    ["0", "-1", "180", "1e308", "-1e308", "1e-320", "nan", "inf", "99999999999999999999"];

pub(super) fn cases() -> Vec<Case> {
    let mut all: Vec<Case> = LINES
        .iter()
        .enumerate()
        .flat_map(|(i, line)| {
            // All pairs take long: each line gets a third of the numbers.
            let some = NUMBERS.iter().enumerate().filter(move |(n, _)| (n + i).is_multiple_of(3));
            some.map(move |(_, number)| {
                Case::one(format!("{line:?} with {number}"), "s.toml", around(&line.replace('$', number)))
            })
        })
        .collect();
    for integrator in ["path", "whitted-1980", "classic", "ambient-occlusion"] {
        let lines = format!(
            "[integrator]\ntype = \"{integrator}\"\n[[object]]\ntype = \"mesh\"\nsmooth = true\n\
             positions = [[0, 0, 0], [1e30, 0, 0], [0, 1e-30, 0], [nan, inf, 0]]\ntriangles = [[0, 1, 2], [1, 2, 3], [0, 0, 0]]"
        );
        all.push(Case::one(format!("degenerate triangles, {integrator}"), "s.toml", around(&lines)));
    }
    let size = |w: u64, h: u64| {
        let text = around(&format!("[film]\nwidth = {w}\nheight = {h}"));
        Case::one(format!("a film of {w}x{h}"), "s.toml", text)
    };
    all.extend([size(0, 10), size(1 << 31, 1 << 31), size(65536, 65536).must(Expected::Either)]);
    all
}
