//! Canonical Huffman codes (KTX 2.0, appendix BasisLZ/ETC1S: compressed Huffman tables; RFC 1951 §3.2.2).

use super::super::fault::{Fault, Outcome, list};
use super::bits::Bits;

/// Longest code, in bits.
const LONGEST: usize = 16;
/// Codes of at most this many bits are found with one lookup.
const SHORT: u32 = 10;
/// The order in which the code lengths of the code length alphabet are stored.
const ORDER: [u8; 21] = [17, 18, 19, 20, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15, 16];

/// A Huffman code.
pub(super) struct Huffman {
    /// For each value of the next [`SHORT`] bits: symbol << 8 | length, or 0 if the code is longer.
    short: Vec<u32>,
    /// The symbols in the order of their codes.
    symbols: Vec<u16>,
    /// Number of codes of each length.
    counts: [u32; LONGEST + 1],
}

impl Huffman {
    /// The code in which symbol i has length `lengths[i]`; 0 means that it does not occur.
    fn of_lengths(lengths: &[u8]) -> Outcome<Huffman> {
        let mut counts = [0u32; LONGEST + 1];
        for &length in lengths {
            if length > 0 {
                counts[usize::from(length).min(LONGEST)] += 1;
            }
        }
        let mut first = [0u32; LONGEST + 2];
        let mut start = [0usize; LONGEST + 2];
        for length in 1..=LONGEST {
            let end = first[length] + counts[length];
            if end > 1 << length {
                return Err(Fault::damaged("a Huffman table has too many short codes"));
            }
            first[length + 1] = end << 1;
            start[length + 1] = start[length] + counts[length] as usize;
        }
        let mut symbols = list::<u16>(start[LONGEST + 1])?;
        let mut short = list::<u32>(1 << SHORT)?;
        let mut next = start;
        for (symbol, &length) in lengths.iter().enumerate().filter(|(_, length)| **length > 0) {
            let length = usize::from(length).min(LONGEST);
            let code = first[length] + (next[length] - start[length]) as u32;
            symbols[next[length]] = symbol as u16;
            next[length] += 1;
            if length as u32 <= SHORT {
                // Codes are stored with their most significant bit first.
                let reversed = code.reverse_bits() >> (32 - length);
                let entry = (symbol as u32) << 8 | length as u32;
                short.iter_mut().skip(reversed as usize).step_by(1 << length).for_each(|e| *e = entry);
            }
        }
        Ok(Huffman { short, symbols, counts })
    }

    /// Reads a table: the lengths of its codes, themselves run-length and Huffman coded.
    pub(super) fn read(bits: &mut Bits<'_>) -> Outcome<Huffman> {
        let total = bits.take(14) as usize;
        if total == 0 {
            return Huffman::of_lengths(&[]);
        }
        let stored = bits.take(5) as usize;
        if stored == 0 || stored > ORDER.len() {
            let problem = format!("a Huffman table has {stored} code length codes; expected 1 to 21");
            return Err(Fault::damaged(problem));
        }
        let mut of_lengths = [0u8; ORDER.len()];
        for &symbol in &ORDER[..stored] {
            of_lengths[usize::from(symbol)] = bits.take(3) as u8;
        }
        let code = Huffman::of_lengths(&of_lengths)?;
        let mut lengths: Vec<u8> = Vec::new();
        while lengths.len() < total {
            let previous = lengths.last().copied().filter(|length| *length > 0);
            let repeated =
                || previous.ok_or_else(|| Fault::damaged("a Huffman table repeats no code length"));
            let (length, run) = match code.decode(bits)? {
                17 => (0, bits.take(3) + 3),
                18 => (0, bits.take(7) + 11),
                19 => (repeated()?, bits.take(2) + 3),
                20 => (repeated()?, bits.take(7) + 7),
                length => (length as u8, 1),
            };
            if lengths.len() + run as usize > total {
                return Err(Fault::damaged(format!("a Huffman table has more than {total} code lengths")));
            }
            lengths.extend(std::iter::repeat_n(length, run as usize));
        }
        bits.check("Huffman tables")?;
        Huffman::of_lengths(&lengths)
    }

    /// The next symbol.
    #[inline]
    pub(super) fn decode(&self, bits: &mut Bits<'_>) -> Outcome<u32> {
        let next = bits.peek16();
        let entry = self.short.get((next & ((1 << SHORT) - 1)) as usize).copied().unwrap_or(0);
        if entry != 0 {
            bits.skip(entry & 255);
            return Ok(entry >> 8);
        }
        self.long(next, bits)
    }

    /// Decodes bit by bit: the codes of each length are consecutive numbers.
    fn long(&self, next: u32, bits: &mut Bits<'_>) -> Outcome<u32> {
        let (mut code, mut first, mut index) = (0u32, 0u32, 0u32);
        for (length, &count) in self.counts.iter().enumerate().skip(1) {
            code |= next >> (length - 1) & 1;
            if code < first + count {
                bits.skip(length as u32);
                let symbol = self.symbols.get((index + code - first) as usize);
                return symbol.map(|s| u32::from(*s)).ok_or_else(unknown);
            }
            index += count;
            first = (first + count) << 1;
            code <<= 1;
        }
        Err(unknown())
    }
}

fn unknown() -> Fault {
    Fault::damaged("a Huffman code has no symbol")
}
