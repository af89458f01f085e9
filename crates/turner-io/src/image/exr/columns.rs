//! The channels of an EXR file to be written, as functions from pixels to bytes.

use crate::image::{ChannelValues, ExtraChannel, SampleKind};
use exr::meta::attribute::{ChannelDescription, SampleType};
use exr::prelude::f16;

/// A channel of the file: its name, how it is stored, and where its samples are.
pub(super) struct Column<'a> {
    pub(super) name: &'a str,
    pub(super) kind: SampleKind,
    pub(super) source: Source<'a>,
}

/// Where the samples of a channel are.
pub(super) enum Source<'a> {
    /// One channel of the RGBA pixels that are computed for each block.
    Strip(usize),
    /// One channel of `stride` interleaved channels, times alpha, the last channel, if `times_alpha`.
    Interleaved { samples: &'a [f32], stride: usize, channel: usize, times_alpha: bool },
    /// Floats of its own.
    Floats(&'a [f32]),
    /// Integers of its own.
    Integers(&'a [u32]),
}

impl<'a> Column<'a> {
    /// The column of an additional channel.
    pub(super) fn extra(channel: &'a ExtraChannel<'_>) -> Column<'a> {
        let source = match &channel.values {
            ChannelValues::Float(v) => Source::Floats(v),
            ChannelValues::Uint(v) => Source::Integers(v),
        };
        Column { name: &channel.name, kind: channel.kind, source }
    }

    /// Its entry in the header.
    pub(super) fn description(&self) -> ChannelDescription {
        let kind = match self.kind {
            SampleKind::Half => SampleType::F16,
            SampleKind::Float => SampleType::F32,
            SampleKind::Uint => SampleType::U32,
        };
        let name = exr::meta::attribute::Text::from_slice_unchecked(self.name.as_bytes());
        ChannelDescription::new(name, kind, false)
    }

    /// Bytes per sample.
    pub(super) fn bytes(&self) -> usize {
        if self.kind == SampleKind::Half { 2 } else { 4 }
    }

    /// Appends the samples of `count` pixels from `first`, little-endian; `strip` are their RGBA values.
    pub(super) fn append(&self, strip: &[[f32; 4]], first: usize, count: usize, data: &mut Vec<u8>) {
        let pixels = first..first + count;
        match &self.source {
            Source::Strip(channel) => self.floats(strip.iter().map(|p| p[*channel]), data),
            Source::Interleaved { samples, stride, channel, times_alpha } => {
                let row = samples.get(first * stride..(first + count) * stride).unwrap_or_default();
                let factor = |p: &[f32]| if *times_alpha { p[stride - 1] } else { 1.0 };
                self.floats(row.chunks_exact(*stride).map(|p| p[*channel] * factor(p)), data);
            }
            Source::Floats(all) => {
                self.floats(all.get(pixels).unwrap_or_default().iter().copied(), data);
            }
            Source::Integers(all) => {
                let row = all.get(pixels).unwrap_or_default().iter();
                match self.kind {
                    SampleKind::Uint => data.extend(row.flat_map(|v| v.to_le_bytes())),
                    SampleKind::Half | SampleKind::Float => self.floats(row.map(|v| *v as f32), data),
                }
            }
        }
    }

    fn floats(&self, values: impl Iterator<Item = f32>, data: &mut Vec<u8>) {
        match self.kind {
            SampleKind::Half => data.extend(values.flat_map(|v| half(v).to_le_bytes())),
            SampleKind::Float => data.extend(values.flat_map(f32::to_le_bytes)),
            // The cast saturates; NaN becomes 0.
            SampleKind::Uint => data.extend(values.flat_map(|v| (v.round() as u32).to_le_bytes())),
        }
    }
}

/// The nearest half; finite values stay finite.
fn half(v: f32) -> f16 {
    const MOST: f32 = 65504.0;
    f16::from_f32(if v.is_finite() { v.clamp(-MOST, MOST) } else { v })
}
