//! The named channels of a film.

use crate::schema::{ErrorCode, SceneError};

/// The channels of every film: colour times coverage, and coverage.
pub const COLOR_CHANNELS: [&str; 4] = ["R", "G", "B", "A"];

/// The maximum number of additional channels.
pub const MAX_CHANNELS: usize = 256;

/// The maximum length of a channel name in bytes.
pub const MAX_NAME: usize = 255;

/// An additional channel: one value per sample; a pixel shows the weighted mean.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Its name, as in EXR files: `Z`, `N.X`, `albedo.R`.
    pub name: String,
}

impl Channel {
    /// A channel with this name.
    pub fn new(name: impl Into<String>) -> Channel {
        Channel { name: name.into() }
    }

    /// Errors: empty, too long or duplicate names; too many channels.
    pub(super) fn check(channels: &[Channel]) -> Result<(), SceneError> {
        let error = |message: String| Err(SceneError::new(ErrorCode::Conflict, message));
        if channels.len() > MAX_CHANNELS {
            return error(format!(
                "the film has {} channels; expected at most {MAX_CHANNELS}",
                channels.len()
            ));
        }
        for (i, Channel { name }) in channels.iter().enumerate() {
            if name.is_empty() || name.len() > MAX_NAME {
                let bytes = name.len();
                return error(format!(
                    "the name of a film's channel has {bytes} bytes; expected 1 to {MAX_NAME}"
                ));
            }
            let earlier = || channels[..i].iter().any(|c| c.name == *name);
            if COLOR_CHANNELS.contains(&name.as_str()) || earlier() {
                return error(format!(
                    "the film has two channels \"{}\"",
                    crate::schema::error::escape(name)
                ));
            }
        }
        Ok(())
    }
}
