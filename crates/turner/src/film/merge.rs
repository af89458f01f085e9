//! Merging films that hold different samples of one picture.

use super::{Film, Half};
use crate::schema::{ErrorCode, SceneError};

/// The remedy for films of different pictures.
pub(super) const SAME_PICTURE: &str = "render all parts from the same scene with the same settings; only crops and ranges of samples may differ";

/// The remedy for films of different channels.
pub(super) const SAME_CHANNELS: &str = "render all parts with the same `aovs` and `denoise`";

/// The remedy for bytes of another version.
pub(super) const OWN_VERSION: &str = "read it with the version of Turner that wrote it, or render it again";

/// The remedy for films that hold the same samples.
const OWN_SAMPLES: &str = "merge each film once, and give each part a range of samples of its own";

/// An error of films that do not belong together, with its remedy.
pub(super) fn conflict(message: impl Into<String>, help: &str) -> SceneError {
    SceneError::new(ErrorCode::Conflict, message).help(help)
}

impl Film {
    /// Adds the samples of another film of the same picture. For any split of a picture's samples and tiles among
    /// films, merged in any order, the result equals the film of an uninterrupted render bit for bit.
    ///
    /// Errors, which leave the film unchanged: the films belong to different pictures or have different channels;
    /// both hold the same sample of a tile, or the same light path ([`ErrorCode::Conflict`]).
    pub fn merge(&mut self, other: &Film) -> Result<(), SceneError> {
        let error = |message: String, help: &str| Err(conflict(message, help));
        if let Some(difference) = self.identity.difference(&other.identity) {
            return error(format!("the films are of different pictures; {difference}"), SAME_PICTURE);
        }
        if self.channels() != other.channels() || self.labels() != other.labels() {
            let names = |film: &Film| {
                let labels = film.labels().iter().map(|l| l.name.as_str());
                let names: Vec<&str> =
                    film.channels().iter().map(|c| c.name.as_str()).chain(labels).collect();
                if names.is_empty() { "none".to_owned() } else { names.join(", ") }
            };
            let message = format!(
                "the films have different channels in addition to colour: {} and {}",
                names(self),
                names(other)
            );
            return error(message, SAME_CHANNELS);
        }
        let goals = |film: &Film| {
            film.bands.iter().flat_map(|b| &b.adaptive).map(|tile| tile.goals).collect::<Vec<_>>()
        };
        if self.step != other.step || goals(self) != goals(other) {
            return error(
                "the films have allotted their samples differently (`film.adaptive_sampling`)".to_owned(),
                "render such a picture in one piece, or its parts without `film.adaptive_sampling`",
            );
        }
        let grid = self.tiles();
        for tile in 0..grid.count() {
            let overlap = |half| self.held_half(tile, half).overlap(other.held_half(tile, half));
            if let Some(both) = Half::BOTH.into_iter().find_map(overlap) {
                let (rect, last) = (grid.rect(tile), both.end - 1);
                let message = format!(
                    "both films hold samples {} to {last} of tile {tile}, {}x{} pixels at ({}, {})",
                    both.start, rect.width, rect.height, rect.x, rect.y
                );
                return error(message, OWN_SAMPLES);
            }
        }
        if let (Some(own), Some(theirs)) = (&self.splats, &other.splats)
            && let Some(both) = own.held.overlap(&theirs.held)
        {
            let message = format!("both films hold light paths {} to {}", both.start, both.end - 1);
            return error(message, OWN_SAMPLES);
        }
        for (own, theirs) in self.bands.iter_mut().zip(&other.bands) {
            (0..grid.columns()).for_each(|column| own.merge_tile(theirs, column));
            own.non_finite.merge(&theirs.non_finite);
        }
        if let (Some(own), Some(theirs)) = (&mut self.splats, &other.splats) {
            own.merge(theirs);
        }
        self.merge_labels(other);
        self.count_non_finite();
        Ok(())
    }
}
