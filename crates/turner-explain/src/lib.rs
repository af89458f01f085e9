//! Explanations of pixels, written: as text, JSON, drawings and pages.
//!
//! ```text
//! turner::render::pixel ── samples ── record ─┬─ json
//!  (the pixel as rendered) (replays)          └─ trees (turner::explain) ── prune ─┬─ text
//!                                                                                 ├─ svg ── views
//!                                                                                 └─ html
//! ```
#![forbid(unsafe_code)]

mod draw;
mod html;
mod record;
mod rows;
mod samples;
mod shade;
mod style;
mod svg;
mod text;
mod views;

use turner::explain::Names;
use turner::render::pixel;
use turner::schema::{ErrorCode, SceneError};

/// How an explanation is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// A tree for terminals, with 24-bit colours or without.
    Text {
        /// Whether colours are shown.
        colors: bool,
    },
    /// All values, for programs.
    Json,
    /// A drawing of the tree and of the rays in the scene.
    Svg,
    /// The drawing as an interactive page.
    Html,
    /// The body of such a page, without its style sheet and its script.
    Fragment,
}

/// What of a pixel is explained.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wanted {
    /// Column and row, from 0 at the top left.
    pub pixel: (u32, u32),
    /// Sample index, from 0. `None`: those with the largest contribution.
    pub sample: Option<usize>,
    /// All rays and samples, not only those with the largest contributions.
    pub all: bool,
}

/// The style sheet of explanations in pages.
pub fn page_style() -> String {
    style::of_page()
}

/// The explanation of a pixel, and whether its contributions add up to the pixel. `scene` is the scene's name and hash.
///
/// Errors: a pixel outside the picture, a sample that it does not have.
pub fn written(
    names: &Names<'_>,
    scene: (String, String),
    wanted: &Wanted,
    format: Format,
) -> Result<(String, bool), SceneError> {
    let prepared = names.prepared;
    prepared.choose(0);
    let (x, y) = wanted.pixel;
    let pixel = pixel(prepared, x, y)?;
    let many = matches!(format, Format::Json | Format::Html | Format::Fragment);
    let samples = samples::Wanted { sample: wanted.sample, all: wanted.all, many };
    let record = samples::explain(names, scene, pixel, &samples)?;
    let text = match format {
        Format::Json => record.json().map_err(|e| {
            SceneError::new(ErrorCode::Internal, format!("the explanation cannot be written: {e}"))
        })?,
        Format::Text { colors } => {
            let budget = if wanted.all { usize::MAX } else { 40 };
            let display = shade::Display::new(&prepared.view.film);
            text::of(&record, &record.trees(names), &text::Style { colors, display, budget })
        }
        Format::Svg | Format::Html | Format::Fragment => {
            let trees = record.trees(names);
            let views = draw::Views::new(names, &trees);
            let display = shade::Display::new(&prepared.view.film);
            // The budget of a page is divided among its samples.
            let most = match (wanted.all, format) {
                (true, _) => usize::MAX,
                (false, Format::Svg) => 24,
                (false, _) => 1200 / trees.len().max(1),
            };
            match format {
                Format::Svg => svg::of(&record, &trees, &views, &display, most),
                Format::Fragment => html::body(&record, &trees, &views, &display, most),
                _ => html::of(&record, &trees, &views, &display, most),
            }
        }
    };
    Ok((text, record.exact))
}
