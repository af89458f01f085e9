//! A picture to show.

use std::sync::Arc;

use turner::color::ColorScale;
use turner::film::DisplayTransform;
use turner::integrator::Prepared;
use turner::{Picture, SceneDesc};

/// Which kind of picture a frame is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stage {
    /// An approximate picture for the first moments.
    Preview,
    /// The film. All its pixels have `samples` samples.
    Film {
        /// Samples per pixel so far; of a partial pass the whole ones.
        samples: u32,
        /// Whether a denoiser removed its noise because the picture is not finished yet.
        denoised: bool,
    },
    /// The finished film: the picture of `turner render`.
    Settled,
}

/// The prepared scene of a frame and its description.
#[derive(Clone, Debug)]
pub struct Stand {
    /// Scene, view and integrator.
    pub prepared: Prepared,
    /// The description in the order.
    pub desc: Arc<SceneDesc>,
}

/// A picture with what it shows.
#[derive(Clone, Debug)]
pub struct Frame {
    /// The number of the order that it answers.
    pub order: u64,
    /// Its kind.
    pub stage: Stage,
    /// Scene values and display values.
    pub picture: Arc<Picture>,
    /// The transform from scene values to display values. Debug views show something else.
    pub transform: DisplayTransform,
    /// What it shows.
    pub stand: Arc<Stand>,
    /// The noise of the film: the relative error that 95 % of the pixels do not exceed, estimated from its samples.
    pub noise: Option<f64>,
    /// What the colours of the picture stand for, if they stand for numbers.
    pub scale: Option<ColorScale>,
    /// Milliseconds from the order to this frame.
    pub after_ms: f64,
}
