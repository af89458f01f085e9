//! Entropy coding: range asymmetric numeral systems (rANS; Duda 2013). A stream is read from its last byte to its
//! first.

use super::reader::{Bits, Reader};
use super::{Read, Room, damaged};

/// The smallest state of a stream of binary decisions.
const BINARY_BASE: u32 = 4096;
/// Log₂ of the sum of the probabilities of tags.
const TAG_PRECISION: u32 = 12;
/// Most bits of a raw symbol.
const MAX_RAW_BITS: u32 = 18;

/// The state of a stream.
#[derive(Clone, Debug)]
struct State<'a> {
    /// What is still unread; the last byte is next.
    bytes: &'a [u8],
    value: u32,
    base: u32,
}

impl<'a> State<'a> {
    /// Begins a stream. The two highest bits of its last byte say how many bytes hold the first state: one to
    /// `most`.
    fn start(bytes: &'a [u8], base: u32, most: usize) -> Read<State<'a>> {
        let size = bytes.last().map_or(0, |last| usize::from(last >> 6) + 1);
        if size == 0 || size > most || size > bytes.len() {
            return damaged("has an entropy-coded part without a first state");
        }
        let (bytes, first) = bytes.split_at(bytes.len() - size);
        let first = first.iter().rev().fold(0u32, |v, byte| v << 8 | u32::from(*byte));
        let value = base + (first & ((1u32 << (8 * size - 2)) - 1));
        if value >= base << 8 {
            return damaged("has an entropy-coded part whose first state is too large");
        }
        Ok(State { bytes, value, base })
    }

    /// Renormalizes: appends bytes until the state is at least its base, or all are read.
    #[inline]
    fn refill(&mut self) {
        while self.value < self.base {
            let Some((last, rest)) = self.bytes.split_last() else { break };
            self.value = self.value << 8 | u32::from(*last);
            self.bytes = rest;
        }
    }
}

/// A stream of binary decisions with a constant probability.
#[derive(Clone, Debug)]
pub(super) struct Decisions<'a> {
    state: State<'a>,
    /// Probability of true, in 1/256.
    likely: u32,
}

impl<'a> Decisions<'a> {
    /// Reads the probability and begins the stream.
    pub(super) fn read(reader: &mut Reader<'a>) -> Read<Decisions<'a>> {
        let zero = u32::from(reader.byte()?);
        let size = reader.varint()?;
        let state = State::start(reader.take(size as usize)?, BINARY_BASE, 3)?;
        Ok(Decisions { state, likely: 256 - zero })
    }

    /// The next decision.
    #[inline]
    pub(super) fn decide(&mut self) -> bool {
        let state = &mut self.state;
        state.refill();
        let (quotient, rest) = (state.value >> 8, state.value & 255);
        let scaled = quotient * self.likely;
        let decided = rest < self.likely;
        state.value = if decided { scaled + rest } else { state.value - scaled - self.likely };
        decided
    }
}

/// The probabilities of a stream of symbols.
struct Table {
    /// Log₂ of their sum.
    precision: u32,
    /// For each symbol, its probability and the sum of those before it.
    symbols: Vec<[u32; 2]>,
    /// The symbol of each remainder.
    of_rest: Vec<u32>,
}

impl Table {
    fn read(reader: &mut Reader<'_>, precision: u32, room: Room<'_>) -> Read<Table> {
        let count = reader.varint()? as usize;
        // A byte describes at most 64 symbols.
        if count == 0 || count / 64 > reader.left() {
            return damaged(&format!("has a table of {count} symbols in {} bytes", reader.left()));
        }
        let mut symbols = room.list::<[u32; 2]>(count)?;
        let mut of_rest = room.passing::<u32>(1 << precision)?;
        let mut sum = 0u32;
        while symbols.len() < count {
            let first = reader.byte()?;
            let more = u32::from(first & 3);
            let mut probability = u32::from(first >> 2);
            if more == 3 {
                let end = symbols.len() + probability as usize + 1;
                if end > count {
                    return damaged(&format!("has a table of {count} symbols that names symbol {}", end - 1));
                }
                symbols.resize(end, [0, sum]);
                continue;
            }
            for k in 0..more {
                probability |= u32::from(reader.byte()?) << (8 * k + 6);
            }
            let symbol = symbols.len() as u32;
            symbols.push([probability, sum]);
            sum += probability;
            if sum > 1 << precision {
                break;
            }
            of_rest.resize(sum as usize, symbol);
        }
        if sum != 1 << precision {
            return damaged(&format!("has probabilities with the sum {sum}; expected {}", 1u32 << precision));
        }
        Ok(Table { precision, symbols, of_rest })
    }

    #[inline]
    fn next(&self, state: &mut State<'_>) -> u32 {
        state.refill();
        let rest = state.value & ((1 << self.precision) - 1);
        let symbol = self.of_rest.get(rest as usize).copied().unwrap_or(0);
        let [probability, before] = self.symbols.get(symbol as usize).copied().unwrap_or([0, 0]);
        state.value =
            (state.value >> self.precision).wrapping_mul(probability).wrapping_add(rest).wrapping_sub(before);
        symbol
    }
}

/// Reads `entries` groups of `width` symbols.
pub(super) fn symbols(
    reader: &mut Reader<'_>,
    entries: usize,
    width: usize,
    room: Room<'_>,
) -> Read<Vec<u32>> {
    let Some(count) = entries.checked_mul(width) else { return damaged("has too many values") };
    let mut out = room.list::<u32>(count)?;
    if count == 0 {
        return Ok(out);
    }
    match reader.byte()? {
        0 => {
            // Tags: the number of bits of each group. The bits follow.
            let table = Table::read(reader, TAG_PRECISION, room)?;
            let mut state = State::start(reader.sized()?, 4 << TAG_PRECISION, 4)?;
            let mut bits = Bits::new(*reader);
            for _ in 0..entries {
                let size = table.next(&mut state);
                if size > 32 {
                    return damaged(&format!("has values of {size} bits; expected at most 32"));
                }
                for _ in 0..width {
                    out.push(bits.take(size)?);
                }
            }
            *reader = bits.rest();
        }
        1 => {
            let bits = u32::from(reader.byte()?);
            if bits == 0 || bits > MAX_RAW_BITS {
                return damaged(&format!("has symbols of {bits} bits; expected 1 to {MAX_RAW_BITS}"));
            }
            let precision = (3 * bits / 2).clamp(12, 20);
            let table = Table::read(reader, precision, room)?;
            let mut state = State::start(reader.sized()?, 4 << precision, 4)?;
            out.extend((0..count).map(|_| table.next(&mut state)));
        }
        other => return damaged(&format!("has symbols in scheme {other}; expected 0 or 1")),
    }
    Ok(out)
}
