//! An MTL texture map: a file name with options before or after it.

use crate::mesh::number::parse_f32;

/// A texture map. (u, v) becomes scale · (u, v) + offset; a value x becomes base + gain · x.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::mesh) struct MtlMap {
    /// The file name as written.
    pub(in crate::mesh) file: String,
    /// `-s`.
    pub(in crate::mesh) scale: [f32; 2],
    /// `-o`.
    pub(in crate::mesh) offset: [f32; 2],
    /// `-mm`.
    pub(in crate::mesh) base: f32,
    pub(in crate::mesh) gain: f32,
    /// `-bm`.
    pub(in crate::mesh) bump: f32,
    /// `-clamp`.
    pub(in crate::mesh) clamp: bool,
    /// `-imfchan`: one of r, g, b, m (matte), l (luminance), z.
    pub(in crate::mesh) channel: Option<u8>,
}

/// What follows an option: a count of numbers (least, most), or a word.
enum Argument {
    Numbers(usize, usize),
    Word,
}

fn arguments(option: &[u8]) -> Option<Argument> {
    Some(match option.to_ascii_lowercase().as_slice() {
        b"-s" | b"-o" | b"-t" => Argument::Numbers(1, 3),
        b"-mm" => Argument::Numbers(2, 2),
        b"-bm" | b"-boost" | b"-texres" => Argument::Numbers(1, 1),
        b"-clamp" | b"-blendu" | b"-blendv" | b"-cc" | b"-imfchan" | b"-type" | b"-colorspace" => {
            Argument::Word
        }
        _ => return None,
    })
}

/// The next word of a text, and the rest.
fn word(text: &[u8]) -> Option<(&[u8], &[u8])> {
    let text = text.trim_ascii_start();
    let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
    (end > 0).then(|| text.split_at(end))
}

impl MtlMap {
    /// Parses what follows the keyword; `None` without a file name. The second part lists options without effect.
    pub(super) fn parse(text: &[u8]) -> (Option<MtlMap>, Vec<String>) {
        let (scale, offset, file) = ([1.0; 2], [0.0; 2], String::new());
        let mut map =
            MtlMap { file, scale, offset, base: 0.0, gain: 1.0, bump: 1.0, clamp: false, channel: None };
        let mut ignored = Vec::new();
        let mut rest = text;
        let mut name: Vec<u8> = Vec::new();
        while let Some((option, after)) = word(rest).filter(|(word, _)| !word.starts_with(b"#")) {
            let Some(argument) = arguments(option) else {
                // Part of the file name, with the white space before it.
                let blanks = rest.len() - rest.trim_ascii_start().len();
                if !name.is_empty() {
                    name.extend_from_slice(&rest[..blanks]);
                }
                name.extend_from_slice(option);
                rest = after;
                continue;
            };
            rest = match argument {
                Argument::Numbers(least, most) => map.numbers(option, after, (least, most), &mut ignored),
                Argument::Word => map.word(option, after, &mut ignored),
            };
        }
        map.file = String::from_utf8_lossy(&name).into_owned();
        ((!map.file.is_empty()).then_some(map), ignored)
    }

    /// Reads the numbers of an option; returns the rest.
    fn numbers<'a>(
        &mut self,
        option: &[u8],
        text: &'a [u8],
        (least, most): (usize, usize),
        ignored: &mut Vec<String>,
    ) -> &'a [u8] {
        let (mut values, mut count, mut rest) = ([0.0_f32; 3], 0, text);
        while count < most
            && let Some((number, after)) = word(rest)
            && let Some(value) = parse_f32(number).filter(|v| v.is_finite())
        {
            (values[count], rest) = (value, after);
            count += 1;
        }
        let [a, b, _] = values;
        let low = option.to_ascii_lowercase();
        match low.as_slice() {
            _ if count < least => {}
            b"-s" => self.scale = [a, if count > 1 { b } else { 1.0 }],
            b"-o" => self.offset = [a, if count > 1 { b } else { 0.0 }],
            b"-mm" => (self.base, self.gain) = (a, b),
            b"-bm" => self.bump = a,
            _ => ignored.push(String::from_utf8_lossy(&low).into_owned()),
        }
        rest
    }

    fn word<'a>(&mut self, option: &[u8], text: &'a [u8], ignored: &mut Vec<String>) -> &'a [u8] {
        let Some((value, rest)) = word(text) else { return text };
        let low = option.to_ascii_lowercase();
        let value = value.to_ascii_lowercase();
        match low.as_slice() {
            b"-clamp" => self.clamp = value == b"on",
            b"-imfchan" => self.channel = value.first().copied().filter(|c| b"rgbmlz".contains(c)),
            // These values are the behaviour anyway.
            b"-blendu" | b"-blendv" if value == b"on" => {}
            b"-cc" if value == b"off" => {}
            _ => ignored.push(String::from_utf8_lossy(&low).into_owned()),
        }
        rest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_before_and_after_names_with_blanks() {
        let read = |text: &str| {
            let (map, ignored) = MtlMap::parse(text.as_bytes());
            (map.unwrap(), ignored)
        };
        let (map, ignored) = read("-o 0.1 -s 2 3 4 -mm 0.25 0.5 -clamp on my  file.png");
        assert_eq!((map.file.as_str(), map.offset, map.scale), ("my  file.png", [0.1, 0.0], [2.0, 3.0]));
        assert_eq!((map.base, map.gain, map.clamp), (0.25, 0.5, true));
        assert!(ignored.is_empty());
        let (map, ignored) = read("-imfchan r -blendu off -t 1 2 3 -type sphere a.jpg -bm 1.5");
        assert_eq!((map.file.as_str(), map.channel, map.bump), ("a.jpg", Some(b'r'), 1.5));
        assert_eq!(ignored, ["-blendu", "-t", "-type"]);
        assert_eq!(read("-s 2 7.png").0.file, "7.png");
        assert_eq!(read("C:\\a b\\-x.png").0.file, "C:\\a b\\-x.png");
        for text in ["", "  ", "-s", "-s 1 2 3", "-clamp", "-mm 1"] {
            assert!(MtlMap::parse(text.as_bytes()).0.is_none(), "{text}");
        }
    }
}
