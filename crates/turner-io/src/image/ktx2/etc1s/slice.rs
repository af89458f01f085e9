//! Slices: for each block of 4 x 4 pixels an index into each codebook (KTX 2.0, appendix BasisLZ/ETC1S).

use super::super::fault::{Fault, Outcome, list};
use super::bits::Bits;
use super::huffman::Huffman;

/// The prediction symbol that repeats the one before.
const REPEAT_PREDICTION: u32 = 256;
/// Fewest repetitions of a prediction symbol.
const LEAST_PREDICTIONS: u64 = 3;
/// Fewest repetitions of the selector before.
const LEAST_SELECTORS: u64 = 3;
/// The run symbol that is followed by a number.
const LONG_RUN: u32 = 63;

/// The Huffman codes of slices.
pub(super) struct Tables {
    predictions: Huffman,
    endpoint_differences: Huffman,
    selectors: Huffman,
    selector_runs: Huffman,
    /// Number of recently used selectors that have symbols of their own.
    history: usize,
}

impl Tables {
    pub(super) fn read(bytes: &[u8]) -> Outcome<Tables> {
        let mut bits = Bits::new(bytes);
        let tables = Tables {
            predictions: Huffman::read(&mut bits)?,
            endpoint_differences: Huffman::read(&mut bits)?,
            selectors: Huffman::read(&mut bits)?,
            selector_runs: Huffman::read(&mut bits)?,
            history: bits.take(13) as usize,
        };
        bits.check("Huffman tables of the slices")?;
        Ok(tables)
    }
}

/// The endpoint indices of a slice: predicted from the neighbours, or stored as differences.
struct Endpoints<'t> {
    tables: &'t Tables,
    /// Entries of the codebook.
    count: u32,
    /// The indices of the row above; those left of the current block are already of its own row.
    row: Vec<u32>,
    /// The index of the block to the left, or of the last block of the row above.
    left: u32,
    /// The index of the block above and to the left.
    above_left: u32,
    /// For each pair of columns, the predictions of an odd row, which the even row above it stores.
    odd_row: Vec<u8>,
    /// The predictions of the current group of 2 x 2 blocks, two bits a block, the next one lowest.
    current: u32,
    /// The last symbol, and how often it is still repeated.
    symbol: u32,
    repeats: u64,
}

impl Endpoints<'_> {
    /// Reads the predictions of the four blocks whose upper left one is at column `x`.
    fn group(&mut self, bits: &mut Bits<'_>) -> Outcome<u32> {
        if self.repeats > 0 {
            self.repeats -= 1;
            return Ok(self.symbol);
        }
        let symbol = self.tables.predictions.decode(bits)?;
        if symbol == REPEAT_PREDICTION {
            self.repeats = u64::from(bits.groups(4)?) + LEAST_PREDICTIONS - 1;
        } else if symbol < REPEAT_PREDICTION {
            self.symbol = symbol;
        } else {
            return Err(Fault::damaged(format!("the prediction {symbol}; expected at most 256")));
        }
        Ok(self.symbol)
    }

    /// The endpoint index of the block at (`x`, `y`); blocks are asked for row by row.
    fn next(&mut self, x: usize, y: usize, bits: &mut Bits<'_>) -> Outcome<u32> {
        if x.is_multiple_of(2) {
            self.current = if y.is_multiple_of(2) {
                let group = self.group(bits)?;
                if let Some(stored) = self.odd_row.get_mut(x / 2) {
                    *stored = (group >> 4) as u8;
                }
                group
            } else {
                u32::from(self.odd_row.get(x / 2).copied().unwrap_or(0))
            };
        }
        let prediction = self.current & 3;
        self.current >>= 2;
        let above = self.row.get(x).copied().unwrap_or(0);
        let index = match prediction {
            0 if x > 0 => self.left,
            1 if y > 0 => above,
            2 if x > 0 && y > 0 => self.above_left,
            3 => {
                let sum = self.left + self.tables.endpoint_differences.decode(bits)?;
                if sum >= self.count { sum - self.count } else { sum }
            }
            _ => return Err(Fault::damaged("a block is predicted from one outside the image")),
        };
        if index >= self.count {
            return Err(Fault::damaged(format!("endpoint {index} of {}", self.count)));
        }
        self.above_left = above;
        self.left = index;
        if let Some(entry) = self.row.get_mut(x) {
            *entry = index;
        }
        Ok(index)
    }
}

/// The selector indices of a slice: stored, or one of the recently used ones.
struct Selectors<'t> {
    tables: &'t Tables,
    /// Entries of the codebook.
    count: u32,
    /// The recently used indices, roughly in the order of use.
    recent: Vec<u32>,
    /// Where the next new index is inserted, in the second half of the list.
    insert: usize,
    /// How often the most recent index is still repeated.
    repeats: u64,
}

impl Selectors<'_> {
    /// The index at a place of the history, which moves to half its distance from the front.
    fn recent(&mut self, place: usize) -> Outcome<u32> {
        let Some(&index) = self.recent.get(place) else {
            return Err(Fault::damaged(format!("selector symbol {}", self.count as usize + place)));
        };
        self.recent.swap(place / 2, place);
        Ok(index)
    }

    fn next(&mut self, bits: &mut Bits<'_>) -> Outcome<u32> {
        if self.repeats > 0 {
            self.repeats -= 1;
            return self.recent(0);
        }
        let symbol = self.tables.selectors.decode(bits)?;
        if symbol < self.count {
            if let Some(entry) = self.recent.get_mut(self.insert) {
                *entry = symbol;
                self.insert += 1;
                if self.insert == self.recent.len() {
                    self.insert /= 2;
                }
            }
            return Ok(symbol);
        }
        let place = (symbol - self.count) as usize;
        if place != self.recent.len() {
            return self.recent(place);
        }
        let run = self.tables.selector_runs.decode(bits)?;
        let run = if run == LONG_RUN { bits.groups(7)? } else { run };
        self.repeats = u64::from(run) + LEAST_SELECTORS - 1;
        self.recent(0)
    }
}

/// Decodes a slice of `columns` x `rows` blocks. `paint` gets the column and row of each block, its endpoint index and
/// its selector index; both indices are below `counts`.
pub(super) fn decode(
    bytes: &[u8],
    tables: &Tables,
    counts: (usize, usize),
    (columns, rows): (usize, usize),
    mut paint: impl FnMut(usize, usize, usize, usize),
) -> Outcome<()> {
    let mut endpoints = Endpoints {
        tables,
        count: counts.0 as u32,
        row: list(columns)?,
        left: 0,
        above_left: 0,
        odd_row: list(columns.div_ceil(2))?,
        current: 0,
        symbol: 0,
        repeats: 0,
    };
    let mut selectors = Selectors {
        tables,
        count: counts.1 as u32,
        recent: list(tables.history)?,
        insert: tables.history / 2,
        repeats: 0,
    };
    let mut bits = Bits::new(bytes);
    for y in 0..rows {
        for x in 0..columns {
            let endpoint = endpoints.next(x, y, &mut bits)?;
            let selector = selectors.next(&mut bits)?;
            if selector >= selectors.count {
                return Err(Fault::damaged(format!("selector {selector} of {}", selectors.count)));
            }
            paint(x, y, endpoint as usize, selector as usize);
        }
        bits.check("blocks of a slice")?;
    }
    Ok(())
}
