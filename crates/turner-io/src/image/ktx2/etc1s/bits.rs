//! Bits of a byte stream, the least significant bit of each byte first.

use super::super::fault::{Fault, Outcome};

/// Reads bits. Past the end it reads zeros, which [`Bits::check`] reports.
pub(super) struct Bits<'a> {
    bytes: &'a [u8],
    /// Index of the next byte to load.
    at: usize,
    /// Loaded bits, the next one lowest.
    loaded: u64,
    /// Number of loaded bits.
    count: u32,
}

impl<'a> Bits<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Bits<'a> {
        Bits { bytes, at: 0, loaded: 0, count: 0 }
    }

    /// Loads at least 32 bits.
    fn load(&mut self) {
        if self.count >= 32 {
            return;
        }
        let four = self.bytes.get(self.at..).and_then(|rest| rest.first_chunk::<4>());
        let word = match four {
            Some(four) => u32::from_le_bytes(*four),
            None => {
                let byte = |i: usize| u32::from(self.bytes.get(self.at + i).copied().unwrap_or(0)) << (8 * i);
                byte(0) | byte(1) | byte(2) | byte(3)
            }
        };
        self.loaded |= u64::from(word) << self.count;
        self.count += 32;
        self.at += 4;
    }

    /// The next 16 bits, without consuming them.
    pub(super) fn peek16(&mut self) -> u32 {
        self.load();
        self.loaded as u32 & 0xffff
    }

    /// Consumes `count` bits, at most 16.
    pub(super) fn skip(&mut self, count: u32) {
        self.load();
        self.loaded >>= count;
        self.count -= count;
    }

    /// The next `count` bits, at most 16.
    pub(super) fn take(&mut self, count: u32) -> u32 {
        let value = self.peek16() & ((1 << count) - 1);
        self.skip(count);
        value
    }

    /// A number in groups of `bits` bits, lowest group first; the bit after each group tells whether one follows.
    pub(super) fn groups(&mut self, bits: u32) -> Outcome<u32> {
        let mut value = 0;
        let mut shift = 0;
        while shift < 32 {
            let group = self.take(bits + 1);
            value |= (group & ((1 << bits) - 1)) << shift;
            if group >> bits == 0 {
                return Ok(value);
            }
            shift += bits;
        }
        Err(Fault::damaged("a run length has more than 32 bits"))
    }

    /// Fails if more bits were consumed than there are.
    pub(super) fn check(&self, what: &str) -> Outcome<()> {
        let consumed = (self.at as u64 * 8).saturating_sub(u64::from(self.count));
        if consumed > self.bytes.len() as u64 * 8 {
            return Err(Fault::damaged(format!("the {what} end after {} bytes", self.bytes.len())));
        }
        Ok(())
    }
}
