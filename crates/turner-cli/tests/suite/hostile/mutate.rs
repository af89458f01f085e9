//! Mutations of files, the same on every run.

/// A random number generator (SplitMix64).
pub(super) struct Random(pub(super) u64);

impl Random {
    pub(super) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub(super) fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }
}

const LIES: [&str; 20] = [
    "0",
    "-1",
    "1",
    "255",
    "65536",
    "2147483647",
    "2147483648",
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "1e308",
    "-1e308",
    "1e39",
    "1e-320",
    "1e999",
    "nan",
    "inf",
    "-inf",
    "\"\"",
    "[]",
];

/// Extreme numbers in the encodings of binary files.
const BINARY: [u32; 10] = [
    0,
    1,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    0xffff_fffe,
    0x7f80_0000,
    0x7fc0_0000,
    0x0001_0000,
    0x7f7f_ffff,
];

/// Mutated copies of a file: a description and the bytes of each.
pub(super) fn mutations(original: &[u8], count: usize) -> Vec<(String, Vec<u8>)> {
    let mut random = Random(original.len() as u64);
    (0..count)
        .map(|i| {
            let mut bytes = original.to_vec();
            let mut how = Vec::new();
            for _ in 0..1 + random.below(2) {
                how.push(one(&mut bytes, i, &mut random));
            }
            (format!("#{i} {}", how.join(", ")), bytes)
        })
        .collect()
}

fn one(bytes: &mut Vec<u8>, number: usize, random: &mut Random) -> String {
    if bytes.is_empty() {
        return "nothing left".to_owned();
    }
    let at = random.below(bytes.len());
    let end = (at + 1 + random.below(24)).min(bytes.len());
    match (number + random.below(2)) % 8 {
        0 => {
            let bit = random.below(8);
            bytes[at] ^= 1 << bit;
            format!("bit {bit} of byte {at}")
        }
        1 => {
            bytes.truncate(at);
            format!("cut at {at}")
        }
        2 => {
            let lie = BINARY[random.below(BINARY.len())];
            let lie = if random.below(2) == 0 { lie.to_le_bytes() } else { lie.to_be_bytes() };
            for (byte, lie) in bytes[at..].iter_mut().zip(lie) {
                *byte = lie;
            }
            format!("{lie:?} at {at}")
        }
        3 | 4 => {
            let Some((start, end)) = number_after(bytes, at) else { return one(bytes, 0, random) };
            let lie = LIES[random.below(LIES.len())];
            bytes.splice(start..end, lie.bytes());
            format!("{lie} at {start}")
        }
        5 => {
            bytes.drain(at..end);
            format!("without {at}..{end}")
        }
        6 => {
            let part = bytes[at..end].to_vec();
            let times = [1, 2, 1000][random.below(3)];
            bytes.splice(at..at, part.repeat(times));
            format!("{at}..{end} {times} times more")
        }
        _ => {
            let junk: Vec<u8> = (0..random.below(40)).map(|_| random.next() as u8).collect();
            let said = format!("{} random bytes at {at}", junk.len());
            bytes.splice(at..at, junk);
            said
        }
    }
}

/// The first decimal number at or after a position.
fn number_after(bytes: &[u8], at: usize) -> Option<(usize, usize)> {
    let start = at + bytes[at..].iter().position(u8::is_ascii_digit)?;
    let rest = &bytes[start..];
    let len = rest.iter().position(|b| !(b.is_ascii_digit() || b".eE+-".contains(b))).unwrap_or(rest.len());
    Some((start, start + len))
}
