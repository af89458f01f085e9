//! Colours of eight rays.

use turner_bvh::lanes::Block32;

use crate::color::Spectrum;

/// Eight colours, channel by channel.
#[derive(Clone, Copy, Debug, Default)]
pub struct SpectrumBlock(pub [Block32; 3]);

impl SpectrumBlock {
    /// Sets the colour of a lane.
    #[inline]
    pub fn set(&mut self, lane: usize, color: Spectrum) {
        for (block, v) in self.0.iter_mut().zip(color.to_array()) {
            block.0[lane] = v;
        }
    }

    /// The colour of a lane.
    #[inline]
    pub fn get(&self, lane: usize) -> Spectrum {
        let [r, g, b] = &self.0;
        Spectrum::new(r.0[lane], g.0[lane], b.0[lane])
    }
}
