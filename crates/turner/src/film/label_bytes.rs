//! The labels of a film as bytes: part of [`super::bytes`].
//!
//! ```text
//! label channels   number (u32); for each: length (u16) and name in UTF-8, rule (u8): 0 nearest, 1 coverage
//! labels of a tile with a channel "nearest": for each pixel its nearness (u64), then for each pixel the labels (u32)
//!                  for each channel "coverage": number of entries (u32); for each the pixel (u16), the label (u32) and
//!                  its weight (i64)
//! ```

use super::bytes::{Reader, Writer, damaged};
use super::labels::{HeldLabels, LabelRule};
use super::{Film, LabelChannel, MAX_CHANNELS, MAX_NAME};
use crate::schema::SceneError;

impl Writer {
    pub(super) fn label_channels(&mut self, channels: &[LabelChannel]) {
        self.u32(channels.len() as u32);
        for channel in channels {
            self.bytes.extend((channel.name.len() as u16).to_le_bytes());
            self.bytes.extend(channel.name.as_bytes());
            self.bytes.push(u8::from(channel.rule == LabelRule::Coverage));
        }
    }

    pub(super) fn labels_of_tile(&mut self, held: &HeldLabels) {
        held.nearness.iter().for_each(|near| self.u64(*near));
        self.words(&held.nearest);
        for entries in &held.covers {
            self.u32(entries.len() as u32);
            for ((pixel, label), weight) in entries {
                self.bytes.extend(pixel.to_le_bytes());
                self.u32(*label);
                self.u64(*weight as u64);
            }
        }
    }
}

/// Size of an entry in bytes.
const ENTRY: u64 = 14;

impl Reader<'_> {
    pub(super) fn label_channels(&mut self) -> Result<Vec<LabelChannel>, SceneError> {
        let count = self.u32()?;
        self.expect(u64::from(count), 3)?;
        if count as usize > MAX_CHANNELS {
            return Err(damaged("there are too many channels of labels"));
        }
        let mut channels: Vec<LabelChannel> = Vec::new();
        for _ in 0..count {
            let length = usize::from(u16::from_le_bytes(self.array()?));
            let name =
                std::str::from_utf8(self.take(length)?).ok().filter(|_| (1..=MAX_NAME).contains(&length));
            let name = name.ok_or_else(|| damaged("a channel of labels has no valid name"))?.to_owned();
            if channels.iter().any(|c| c.name == name) {
                return Err(damaged("two channels of labels have the same name"));
            }
            let rule = if self.flag()? { LabelRule::Coverage } else { LabelRule::Nearest };
            channels.push(LabelChannel { name, rule });
        }
        Ok(channels)
    }

    pub(super) fn labels(&mut self, film: &mut Film) -> Result<(), SceneError> {
        for held in film.bands.iter_mut().flat_map(|band| {
            let areas: Vec<u64> = (0..band.held.len()).map(|column| band.tile(column).area()).collect();
            band.labels.iter_mut().zip(areas)
        }) {
            self.labels_of_tile(held.0, held.1)?;
        }
        Ok(())
    }

    fn labels_of_tile(&mut self, held: &mut HeldLabels, pixels: u64) -> Result<(), SceneError> {
        self.expect(held.nearness.len() as u64, 8)?;
        for near in &mut held.nearness {
            *near = self.u64()?;
        }
        self.expect(held.nearest.len() as u64, 4)?;
        for label in &mut held.nearest {
            *label = self.u32()?;
        }
        for entries in &mut held.covers {
            let count = self.u32()?;
            self.expect(u64::from(count), ENTRY)?;
            for _ in 0..count {
                let key = (u16::from_le_bytes(self.array()?), self.u32()?);
                if entries.last().is_some_and(|(last, _)| *last >= key) || u64::from(key.0) >= pixels {
                    return Err(damaged("labels are out of order"));
                }
                entries.push((key, self.u64()? as i64));
            }
        }
        Ok(())
    }
}
