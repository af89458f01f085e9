//! Scenes rendered by other renderers: `scenes/peers` has them and their images, reduced to 64 × 64 pixels.

use std::path::Path;

use turner::schema::{ErrorCode, SceneError};
use turner::testing::{CompareOptions, Comparison, Estimate, Reference, compare, relative_mse};
use turner_cli::verify::check::{Check, Context, Finding, fault};
use turner_io::assets::MemoryAssets;
use turner_io::image::{DecodeLimits, decode};
use turner_io::testing::{noisy_sphere_ply, sky_exr};

/// A scene and its reference.
struct Peer {
    name: &'static str,
    text: &'static str,
    small: &'static [u8],
    /// The relative mean square error of the full-size reference, 512 × 512 pixels.
    noise: f64,
    /// Samples per pixel and run at 64 × 64 pixels.
    samples: u32,
}

macro_rules! peer {
    ($name:literal, $noise:literal, $samples:literal) => {
        Peer {
            name: $name,
            text: include_str!(concat!("../../../../scenes/peers/", $name, ".toml")),
            small: include_bytes!(concat!("../../../../scenes/peers/", $name, ".exr")),
            noise: $noise,
            samples: $samples,
        }
    };
}

/// The noise is that of `refs.json` next to the references.
const PEERS: [Peer; 4] = [
    peer!("s1", 9.0775e-5, 64),
    peer!("s2", 4.4249e-4, 256),
    peer!("s3", 4.5370e-5, 512),
    peer!("s4", 6.4211e-5, 64),
];

/// Edge length of the full-size references, and of the block of their pixels that became one small pixel.
const FULL: u32 = 512;
const BLOCK: u32 = 8;
/// Tolerance of the ratio of the means.
const RATIO: f64 = 0.003;
/// Tolerance of a pixel apart from noise: single-precision sums, pixel edges, half-precision files.
const PIXEL: f64 = 0.003;

pub(super) fn checks(references: Option<&Path>) -> Vec<Check> {
    let mut out = Vec::new();
    for peer in &PEERS {
        out.push(Check::limit(format!("peers/{}", peer.name), move |cx| small(cx, peer)));
        if let Some(folder) = references {
            let path = folder.join(format!("{}.exr", peer.name.to_uppercase()));
            out.push(Check::limit(format!("peers/{}-full", peer.name), move |cx| full(cx, peer, &path)));
        }
    }
    out
}

fn picture(bytes: &[u8], name: &str) -> Result<(u32, u32, Vec<[f64; 3]>), SceneError> {
    let image = decode(bytes, name, &DecodeLimits::default())
        .map_err(|e| SceneError::new(ErrorCode::Image, e.to_string()))?;
    let row = |y: u32| (0..image.width).map(move |x| (x, y));
    let mean = (0..image.height).flat_map(row).map(|(x, y)| image.rgb(x, y).map(f64::from)).collect();
    Ok((image.width, image.height, mean))
}

fn render(cx: &Context, peer: &Peer, size: u32, samples: u32) -> Result<turner::testing::Runs, SceneError> {
    let mut assets = MemoryAssets::default();
    if peer.name == "s4" {
        assets.files.insert("s4-blob.ply".into(), noisy_sphere_ply(200));
        assets.files.insert("s4-sky.exr".into(), sky_exr(1024).map_err(fault)?);
    }
    // Replace the scene's own film.
    let text: Vec<&str> = peer.text.split("[film]").collect();
    let rest = text.get(1).and_then(|film| film.split_once("\n\n")).map_or("", |(_, rest)| rest);
    let text = format!("{}\n{rest}", text[0]);
    let scene = cx.scene_with([size, size], samples, &text, &assets)?;
    cx.runs(&scene, 8, peer.name)
}

fn small(cx: &Context, peer: &Peer) -> Result<Finding, SceneError> {
    let (width, height, mean) = picture(peer.small, peer.name)?;
    // The noise of pixels is independent: the mean of a block has a smaller error by the number of pixels.
    let reference = Reference::with_noise(width, height, mean, peer.noise / f64::from(BLOCK * BLOCK));
    let runs = render(cx, peer, FULL / BLOCK, cx.times(peer.samples))?;
    let found = judge(&runs, &reference, relative_mse(&runs.picture(), &reference.mean));
    Ok(found)
}

fn full(cx: &Context, peer: &Peer, path: &Path) -> Result<Finding, SceneError> {
    let bytes = std::fs::read(path)
        .map_err(|e| SceneError::new(ErrorCode::File, format!("{}: {e}", path.display())))?;
    let (width, height, mean) = picture(&bytes, peer.name)?;
    if (width, height) != (FULL, FULL) {
        let message = format!("{}: {width}x{height} pixels, expected {FULL}x{FULL}", path.display());
        return Err(SceneError::new(ErrorCode::Image, message));
    }
    let reference = Reference::with_noise(width, height, mean, peer.noise);
    let runs = render(cx, peer, FULL, cx.times(8))?;
    let found = judge(&runs, &reference, relative_mse(&runs.picture(), &reference.mean) - peer.noise);
    Ok(found)
}

/// Passes if the means agree within 0.3 %, as far as they are known, and pixels agree within the noise of both images.
fn judge(runs: &dyn Estimate, reference: &Reference, error: f64) -> Finding {
    let options = CompareOptions { tolerance: PIXEL, absolute: 1e-4, ..CompareOptions::default() };
    let c: Comparison = compare(runs, reference, &options);
    let off = ((c.ratio - 1.0).abs() - 2.0 * c.ratio_error).max(0.0);
    let used = (off / RATIO).max(c.beyond / options.share).max(c.ratio_error / RATIO);
    let found = format!(
        "ratio {:.5} ± {:.5}, {:.2} % of pixels beyond, relMSE {error:.2e}",
        c.ratio,
        c.ratio_error,
        100.0 * c.beyond
    );
    Finding::limit(used, 1.0, found)
}
