//! The light of the pilot run's light paths that arrives at the camera, and the error of a picture that contains it.

use super::pilot::PilotRun;

/// Samples per pixel for which missing light is weighed against noise. A fixed number, so that a picture with more
/// samples continues one with fewer.
pub(super) const FEW: f64 = 32.0;

/// Contributions per pixel and sample that are too rare to count as noise: with few samples one pixel in a thousand has
/// such a firefly. Their light is missing in all others.
const RARE: f64 = 1e-3 / FEW;

/// The samples of a render are well distributed, those of the pilot run are not: the fraction of the variance that
/// remains, for camera paths and for light paths. Measured.
pub(super) const STRATIFIED: f64 = 0.25;
const STRATIFIED_LIGHT: f64 = 0.1;

/// Light of a light path.
pub(super) struct Arrival {
    /// Luminance before the MIS weight, and that weight.
    pub(super) light: f64,
    pub(super) weight: f64,
    /// Its cell of the image, and its caustic target.
    pub(super) cell: usize,
    pub(super) group: u32,
}

/// What arrives from the light paths of the pilot run.
#[derive(Default)]
pub(super) struct Arrivals {
    /// The number of light paths, and the number per sample of all pixels for which the weights hold.
    pub(super) paths: f64,
    pub(super) paths_of_strategy: f64,
    pub(super) list: Vec<Arrival>,
}

/// A camera path that finds the light of a light path.
struct CameraPath {
    /// Its contribution squared, relative to the light of its cell.
    square: f64,
    /// The number of camera paths, of one per pixel, that find this light.
    number: f64,
    /// Luminance of the light path, and its cell.
    light: f64,
    cell: usize,
}

/// The noise of light paths.
pub(super) struct Noise {
    /// Mean square of the contribution of a light path, relative to the light of its cell; and arrivals per light path.
    square: f64,
    arriving: f64,
}

impl Noise {
    /// Squared relative error of a sample with `paths` light paths per pixel.
    pub(super) fn error(&self, pixels: f64, paths: f64) -> f64 {
        // Where few arrive at a pixel they are as random as those of the pilot run.
        let arriving = FEW * paths * self.arriving;
        let stratified = (1.0 + STRATIFIED_LIGHT * arriving) / (1.0 + arriving);
        stratified * self.square / (pixels * pixels * paths)
    }
}

impl Arrival {
    /// The square of what it adds to the picture, relative to the light of its cell.
    fn square(&self, pilot: &PilotRun) -> f64 {
        self.weight * self.weight * self.light * self.light * pilot.weight(self.cell)
    }

    /// The number of camera paths, of one per pixel, that find this light; `None` if none can. From the power heuristic
    /// w = 1/(1 + a² + b²): the other strategies together have about √(a² + b²) times the density of all light paths.
    fn camera_paths(&self, paths_of_strategy: f64) -> Option<f64> {
        let others = (1.0 / self.weight - 1.0).max(0.0).sqrt();
        (others > 1e-12).then_some(others * paths_of_strategy)
    }
}

impl Arrivals {
    /// The mean light per pixel.
    pub(super) fn light(&self, pixels: f64) -> f64 {
        self.list.iter().fold(0.0, |sum, a| sum + a.light) / (self.paths * pixels)
    }

    /// The mean light per pixel without the greatest arrivals, which are too rare to say how bright the picture is.
    pub(super) fn usual_light(&self, pixels: f64) -> f64 {
        let mut light: Vec<f64> = self.list.iter().map(|a| a.light).collect();
        light.sort_by(|a, b| b.total_cmp(a));
        light.iter().skip(self.rare()).fold(0.0, |sum, v| sum + v) / (self.paths * pixels)
    }

    /// Effective number of arrivals, (Σ x)² / Σ x² (Kish 1965): so many equal ones are as certain about their mean.
    pub(super) fn effective(&self, pilot: &PilotRun) -> f64 {
        let (mut sum, mut squares) = (0.0, 0.0);
        for a in &self.list {
            let square = a.light * a.light * pilot.weight(a.cell);
            sum += square.sqrt();
            squares += square;
        }
        if squares > 0.0 { sum * sum / squares } else { 0.0 }
    }

    /// The number of arrivals that are too rare to count.
    fn rare(&self) -> usize {
        (RARE * self.paths).ceil() as usize
    }

    /// The mean light per pixel that camera paths never find.
    pub(super) fn light_paths_only(&self, pixels: f64) -> f64 {
        let only = self.list.iter().filter(|a| a.camera_paths(self.paths_of_strategy).is_none());
        only.fold(0.0, |sum, a| sum + a.light) / (self.paths * pixels)
    }

    /// Squared relative error that a sample has because of this light if camera paths alone must find it, without regard
    /// to what is rare.
    pub(super) fn noise_without(&self, pilot: &PilotRun, pixels: f64) -> f64 {
        let of = |a: &Arrival| {
            let number = a.camera_paths(self.paths_of_strategy)?;
            Some(a.light * a.light * pilot.weight(a.cell) / number)
        };
        self.list.iter().filter_map(of).sum::<f64>() / (self.paths * pixels)
    }

    /// The same as pictures with few samples show it: the variance of contributions that many pixels have, and the missing
    /// light of the others. `seen`: the part of the variance that the camera paths of the pilot run have. It limits
    /// frequent contributions, whose variance is below their mean square; those below the rate `unknown` were not seen.
    pub(super) fn error_without(
        &self,
        pilot: &PilotRun,
        pixels: f64,
        unknown: f64,
        seen: impl FnOnce() -> f64,
    ) -> f64 {
        let of = |a: &Arrival| {
            let number = a.camera_paths(self.paths_of_strategy)?;
            let value = a.light / number;
            Some(CameraPath {
                square: value * value * pilot.weight(a.cell),
                number,
                light: a.light,
                cell: a.cell,
            })
        };
        let mut paths: Vec<CameraPath> = self.list.iter().filter_map(of).collect();
        paths.sort_by(|a, b| b.square.total_cmp(&a.square));
        let scale = 1.0 / (self.paths * pixels);
        let (mut occasional, mut frequent) = (0.0, 0.0);
        // The number of contributions per camera path so far, the greatest first.
        let (mut rate, mut missing) = (0.0, 0);
        for path in &paths {
            match rate {
                r if r < RARE => missing += 1,
                r if r < unknown => occasional += path.square * path.number * scale,
                _ => frequent += path.square * path.number * scale,
            }
            rate += path.number * scale;
        }
        let variance = if frequent > 0.0 { occasional + frequent.min(seen()) } else { occasional };
        let missing = paths[..missing].iter().map(|path| (path.cell, path.light));
        STRATIFIED * variance + FEW * pilot.mean_square(missing, self.paths * pixels)
    }

    /// Squared relative error of a sample without this light.
    pub(super) fn error_if_missing(&self, pilot: &PilotRun, pixels: f64) -> f64 {
        FEW * pilot.mean_square(self.list.iter().map(|a| (a.cell, a.light)), self.paths * pixels)
    }

    /// The noise of the light paths, without what is rare.
    pub(super) fn noise(&self, pilot: &PilotRun) -> Noise {
        let mut squares: Vec<f64> = self.list.iter().map(|a| a.square(pilot)).collect();
        squares.sort_by(|a, b| b.total_cmp(a));
        Noise {
            square: squares.iter().skip(self.rare()).fold(0.0, |sum, v| sum + v) / self.paths,
            arriving: squares.len() as f64 / self.paths,
        }
    }

    /// Mean square of the noise of each of `groups` caustic targets, up to a factor.
    pub(super) fn noise_of_groups(&self, pilot: &PilotRun, groups: usize) -> Vec<f64> {
        let mut sums = vec![0.0; groups];
        for a in &self.list {
            if let Some(sum) = sums.get_mut(a.group as usize) {
                *sum += a.square(pilot);
            }
        }
        sums
    }
}
