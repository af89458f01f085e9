//! Why a pixel has its colour, ray by ray.
//!
//! ```text
//! explain ── samples ── Replay ── SampleTree ── prune
//!           (rendered)  (traced again  (rays, hits, named values)
//!                        and recorded)
//! ```
//!
//! A sample is traced again by the code that renders, with a recorder ([`Replay`]). [`SampleTree`] has its rays as plain
//! data: for "classic" a tree, for "path" and "direct" a chain with shadow rays, for other integrators the camera ray. The
//! contributions of the rays sum to the sample to the last bit. Numbers stay numbers ([`Term`]); front ends write them,
//! and [`number`](mod@number) writes them as the command line does.
//!
//! Rays are in a list in which parents come before children, because trees may be a hundred thousand levels deep.

mod classic;
mod first_hit;
mod model;
mod names;
pub mod number;
mod path;
mod probe;
pub mod prune;
mod replay;
mod term;
#[cfg(test)]
mod tests;

pub use classic::list;
pub use model::{Kind, RayNode, SampleTree, over};
pub use names::Names;
pub use path::end as end_of_path;
pub use probe::{Probe, SurfaceValues, probe};
pub use replay::{FirstHit, FirstSurface, Replay};
pub use term::{Piece, Term};

use crate::color::Spectrum;
use crate::description::SceneDesc;
use crate::film::Antialias;
use crate::integrator::Prepared;
use crate::render::{SampleRecord, pixel, pixel_samples};
use crate::schema::{ErrorCode, SceneError};

/// Which sample of a pixel is explained.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Which {
    /// The one with this index, from 0.
    Index(u32),
    /// The one with the largest contribution among the first so many.
    Largest(u32),
}

/// A pixel, explained by one of its samples.
#[derive(Clone, Debug)]
pub struct Explanation {
    /// Column, from 0 at the left.
    pub x: u32,
    /// Row, from 0 at the top.
    pub y: u32,
    /// The number of samples that were compared.
    pub compared: usize,
    /// Their mean, weighted as in the picture: linear scene values times coverage. It is the pixel's colour if all samples
    /// were compared.
    pub color: Spectrum,
    /// The sample and its rays. The first ray is the camera ray; there is none outside the image of the camera.
    pub tree: SampleTree,
}

impl Explanation {
    /// The camera ray.
    pub fn root(&self) -> Option<&RayNode> {
        self.tree.nodes.first()
    }
}

/// The contribution of a sample to the pixel: its largest channel times its weight.
pub fn contribution(s: &SampleRecord) -> f64 {
    let most = s.radiance.color.map(f32::abs).max_component();
    if most.is_finite() { s.weight * f64::from(most) } else { f64::MAX }
}

/// Explains the pixel in column `x`, row `y` (from 0, top left) of a scene. `desc` is the description that it was prepared
/// from. Only the samples that `which` asks for are traced; adaptive anti-aliasing and "mean", where neighbours share
/// samples, trace all of the pixel.
///
/// Errors ([`ErrorCode::OutOfRange`]): a pixel outside the picture, a sample that the pixel does not have.
pub fn explain(
    prepared: &Prepared,
    desc: &SceneDesc,
    x: u32,
    y: u32,
    which: Which,
) -> Result<Explanation, SceneError> {
    let shared = matches!(prepared.view.film.antialias, Antialias::Adaptive | Antialias::Mean);
    let (samples, first) = match which {
        _ if shared => (pixel(prepared, x, y)?.samples, 0),
        Which::Index(n) => (pixel_samples(prepared, x, y, n..n.saturating_add(1))?, n as usize),
        Which::Largest(n) => (pixel_samples(prepared, x, y, 0..n.max(1))?, 0),
    };
    let wanted = match which {
        Which::Index(n) => (n as usize).checked_sub(first),
        Which::Largest(n) => {
            let by = |a: &(usize, &SampleRecord), b: &(usize, &SampleRecord)| {
                contribution(a.1).total_cmp(&contribution(b.1)).then(b.0.cmp(&a.0))
            };
            samples.iter().enumerate().take(n.max(1) as usize).max_by(by).map(|(i, _)| i)
        }
    };
    let Some((i, sample)) = wanted.and_then(|i| Some((i, samples.get(i)?))) else {
        let message = format!("this pixel has {} samples, numbered from 0", first + samples.len());
        return Err(SceneError::new(ErrorCode::OutOfRange, message).help("take more samples: film.samples"));
    };
    let names = Names { prepared, desc, path_of: None };
    let tree = SampleTree::new(&names, first + i, sample)?;
    let color = samples.iter().fold(Spectrum::BLACK, |sum, s| sum + s.radiance.color * s.weight as f32);
    Ok(Explanation { x, y, compared: samples.len(), color, tree })
}
