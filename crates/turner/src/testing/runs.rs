//! Pictures with known errors: independent renders of one scene, or a reference of known noise.

use std::sync::atomic::AtomicBool;

use super::moments::Moments;
use crate::film::{NonFinite, PixelRect};
use crate::integrator::Prepared;
use crate::render::{PassOptions, Renderer};
use crate::schema::SceneError;

/// A picture whose error is known for rectangles of pixels.
pub trait Estimate {
    /// Columns and rows.
    fn size(&self) -> (u32, u32);
    /// The mean over pixels inside the picture, in one of the three channels.
    fn moments(&self, pixels: &PixelRect, band: usize) -> Moments;
}

/// Independent renders of one scene with different seeds. Their spread is the error, whatever the sampler and
/// however pixels are correlated.
#[derive(Clone, Debug)]
pub struct Runs {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The pictures: linear colours, row by row from the top.
    pub pictures: Vec<Vec<[f32; 3]>>,
    /// Coverage, averaged over all pixels and runs.
    pub alpha: f64,
    /// Non-finite samples of all runs.
    pub non_finite: NonFinite,
}

/// Renders a scene `runs` times with seeds derived from `seed`, each with the film's number of samples.
pub fn render_runs(prepared: &Prepared, runs: u32, seed: u64, threads: usize) -> Result<Runs, SceneError> {
    let mut random = super::Random::new(seed);
    let mut out =
        Runs { width: 0, height: 0, pictures: Vec::new(), alpha: 0.0, non_finite: NonFinite::default() };
    let never = AtomicBool::new(false);
    for _ in 0..runs {
        let mut prepared = prepared.clone();
        prepared.view.film.seed = random.bits() as u32;
        let mut renderer = Renderer::new(prepared)?;
        renderer.pass(u32::MAX, &PassOptions { threads, cancel: &never, progress: None })?;
        let picture = renderer.film.develop(&renderer.prepared().view.film, 1);
        (out.width, out.height) = (picture.width, picture.height);
        let alpha: f64 = picture.linear.iter().map(|p| f64::from(p[3])).sum();
        out.alpha += alpha / picture.linear.len() as f64 / f64::from(runs);
        out.pictures.push(picture.linear.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect());
        out.non_finite.merge(&renderer.film.non_finite);
    }
    Ok(out)
}

impl Runs {
    /// The mean over the entire picture, in one channel.
    pub fn mean(&self, band: usize) -> Moments {
        self.moments(&PixelRect { x: 0, y: 0, width: self.width, height: self.height }, band)
    }

    /// The differences to other runs, pair by pair, for scenes that should give equal pictures for equal seeds.
    /// The mean of the differences should be 0. Runs without a partner are omitted.
    pub fn minus(&self, other: &Runs) -> Runs {
        let sub = |(a, b): (&[f32; 3], &[f32; 3])| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
        let pairs = self.pictures.iter().zip(&other.pictures);
        let pictures = pairs.map(|(a, b)| a.iter().zip(b).map(sub).collect()).collect();
        Runs { pictures, ..self.clone() }
    }

    /// The mean of all runs, pixel by pixel.
    pub fn picture(&self) -> Vec<[f64; 3]> {
        let n = self.pictures.len() as f64;
        (0..self.width as usize * self.height as usize)
            .map(|i| [0, 1, 2].map(|c| self.pictures.iter().map(|p| f64::from(p[i][c])).sum::<f64>() / n))
            .collect()
    }
}

impl Estimate for Runs {
    fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }
    fn moments(&self, pixels: &PixelRect, band: usize) -> Moments {
        let area = pixels.area() as f64;
        let of_run = |picture: &Vec<[f32; 3]>| {
            let mut sum = 0.0;
            for y in pixels.y..pixels.y + pixels.height {
                let row = (y * self.width + pixels.x) as usize;
                let row = &picture[row..row + pixels.width as usize];
                sum += row.iter().map(|p| f64::from(p[band])).sum::<f64>();
            }
            sum / area
        };
        let values: Vec<f64> = self.pictures.iter().map(of_run).collect();
        Moments::of(values.into_iter())
    }
}

/// A picture with the variance of each value; the values are independent. It is a formula's (without variance)
/// or another renderer's.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Colours, row by row from the top.
    pub mean: Vec<[f64; 3]>,
    /// Variances.
    pub variance: Vec<[f64; 3]>,
}

impl Reference {
    /// A constant colour, exactly.
    pub fn constant(width: u32, height: u32, color: [f64; 3]) -> Reference {
        let n = width as usize * height as usize;
        Reference { width, height, mean: vec![color; n], variance: vec![[0.0; 3]; n] }
    }

    /// A picture with the same relative mean square error ([`relative_mse`](super::relative_mse)) in all pixels.
    pub fn with_noise(width: u32, height: u32, mean: Vec<[f64; 3]>, noise: f64) -> Reference {
        let variance = mean.iter().map(|p| p.map(|v| noise * (v * v + 0.01))).collect();
        Reference { width, height, mean, variance }
    }

    /// The means of blocks of `by` x `by` pixels; pixels beyond the last complete block are omitted.
    pub fn reduced(&self, by: u32) -> Reference {
        let by = by.max(1);
        let (width, height) = (self.width / by, self.height / by);
        let mut out = Reference { width, height, mean: Vec::new(), variance: Vec::new() };
        for y in 0..height {
            for x in 0..width {
                let block = PixelRect { x: x * by, y: y * by, width: by, height: by };
                let m = [0, 1, 2].map(|band| self.moments(&block, band));
                out.mean.push(m.map(|m| m.mean));
                out.variance.push(m.map(|m| m.variance));
            }
        }
        out
    }
}

impl Estimate for Reference {
    fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }
    fn moments(&self, pixels: &PixelRect, band: usize) -> Moments {
        let (mut mean, mut variance, area) = (0.0, 0.0, pixels.area() as f64);
        for y in pixels.y..pixels.y + pixels.height {
            for x in pixels.x..pixels.x + pixels.width {
                let i = (y * self.width + x) as usize;
                mean += self.mean[i][band];
                variance += self.variance[i][band];
            }
        }
        Moments { mean: mean / area, variance: variance / (area * area), freedom: f64::INFINITY }
    }
}
