//! Radiance HDR (RGBE): three 8-bit mantissas with a shared exponent, run-length encoded (Ward 1991, "Real Pixels",
//! Graphics Gems II; run-length encoding as in Radiance's `color.c`).
//!
//! `value = mantissa * 2^(exponent - 136)`; a written value is accurate to 2^-8 of the brightest channel of its
//! pixel. The decoder is implemented here so that memory grows with the data in the file, not with the size that the
//! header claims. EXPOSURE and COLORCORR lines are not applied: values are as stored, as in other programs.

use super::limits::{Source, reserve};
use super::strips::refused;
use super::{DecodeLimits, ImageError, ImageFormat, OutputImage, StripImage, WriteSeek};
use std::io;
use turner::image::{Image, Pixels};

const FORMAT: ImageFormat = ImageFormat::Hdr;

/// Widths that scan-line run-length encoding supports.
const RLE_WIDTHS: std::ops::RangeInclusive<usize> = 8..=32767;

/// Longest header, in bytes.
const MAX_HEADER: usize = 1 << 16;

type Rgbe = [u8; 4];

/// Reads a Radiance HDR file as RGB floats.
pub fn decode(bytes: &[u8], name: &str, limits: &DecodeLimits) -> Result<Image, ImageError> {
    let damaged = |problem: &str| ImageError::damaged(name, FORMAT, problem);
    let mut lines = Lines { rest: &bytes[..bytes.len().min(MAX_HEADER)] };
    loop {
        let line = lines.next().ok_or_else(|| damaged("the header does not end"))?;
        if line.is_empty() {
            break;
        }
        if line.starts_with(b"FORMAT=") && line.trim_ascii_end() != b"FORMAT=32-bit_rle_rgbe" {
            let found = String::from_utf8_lossy(line).into_owned();
            return Err(ImageError::unsupported(name, FORMAT, found, "FORMAT=32-bit_rle_rgbe"));
        }
    }
    let line = lines.next().ok_or_else(|| damaged("the line with the size is missing"))?;
    let line = String::from_utf8_lossy(line).into_owned();
    let (width, height, up, left) = parse_size(&line, name)?;
    let data_at = bytes.len().min(MAX_HEADER) - lines.rest.len();
    let mut data = bytes.get(data_at..).unwrap_or_default();

    // A scan line has at least four bytes, which can represent any number of pixels. Therefore the sample buffer
    // grows with the rows actually present.
    let source = Source { name, format: FORMAT, bytes: bytes.len() };
    let size = limits.check(source, width, height, 12, u64::MAX)?;
    let (w, h) = (size.width as usize, size.height as usize);
    if h > data.len() / 4 {
        return Err(damaged(&format!("{} bytes cannot hold {h} rows", data.len())));
    }
    let mut line = vec![[0; 4]; w];
    let mut samples: Vec<f32> = Vec::new();
    for y in 0..h {
        data = read_line(data, &mut line)
            .ok_or_else(|| damaged(&format!("row {y} of {h} is truncated or does not match the width")))?;
        if samples.capacity() - samples.len() < w * 3 {
            // Double the buffer, but not beyond the size of the image.
            let more = samples.len().max(w * 48).min((h - y) * w * 3);
            reserve(&mut samples, more, name)?;
        }
        samples.extend(line.iter().flat_map(|&p| to_linear(p)));
    }
    if up {
        let row = w * 3;
        for y in 0..h / 2 {
            let (top, bottom) = samples.split_at_mut((h - 1 - y) * row);
            top[y * row..(y + 1) * row].swap_with_slice(&mut bottom[..row]);
        }
    }
    if left {
        for row in samples.chunks_exact_mut(w * 3) {
            row.reverse();
            row.chunks_exact_mut(3).for_each(<[f32]>::reverse);
        }
    }
    Ok(Image { width: size.width, height: size.height, channels: 3, pixels: Pixels::F32(samples) })
}

/// Header lines, without line ends.
struct Lines<'a> {
    rest: &'a [u8],
}

impl<'a> Iterator for Lines<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let end = self.rest.iter().position(|&b| b == b'\n')?;
        let line = &self.rest[..end];
        self.rest = &self.rest[end + 1..];
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }
}

/// Parses the size, such as `-Y height +X width`: rows from the top, columns from the left. Returns width, height,
/// whether rows go from the bottom up, and whether columns go from right to left.
fn parse_size(line: &str, name: &str) -> Result<(u64, u64, bool, bool), ImageError> {
    let words: Vec<&str> = line.split_ascii_whitespace().take(5).collect();
    let [y, height, x, width] = words[..] else {
        let problem = format!("found \"{line}\", expected a size such as \"-Y 512 +X 1024\"");
        return Err(ImageError::damaged(name, FORMAT, problem));
    };
    if !matches!(y, "-Y" | "+Y") || !matches!(x, "-X" | "+X") {
        let found = format!("the orientation \"{line}\"");
        return Err(ImageError::unsupported(name, FORMAT, found, "rows before columns: -Y height +X width"));
    }
    match (width.parse(), height.parse()) {
        (Ok(w), Ok(h)) => Ok((w, h, y == "+Y", x == "-X")),
        _ => {
            let problem = format!("found \"{line}\", expected a size such as \"-Y 512 +X 1024\"");
            Err(ImageError::damaged(name, FORMAT, problem))
        }
    }
}

/// Reads one scan line, in the run-length encoding by channel or the older encodings; `None` if the bytes are
/// invalid.
fn read_line<'a>(data: &'a [u8], line: &mut [Rgbe]) -> Option<&'a [u8]> {
    match data {
        [2, 2, high, low, rest @ ..] if *high < 128 && RLE_WIDTHS.contains(&line.len()) => {
            if usize::from(*high) << 8 | usize::from(*low) != line.len() {
                return None;
            }
            (0..4).try_fold(rest, |data, channel| read_channel(data, line, channel))
        }
        _ => read_pixels(data, line),
    }
}

fn read_channel<'a>(mut data: &'a [u8], line: &mut [Rgbe], channel: usize) -> Option<&'a [u8]> {
    let mut x = 0;
    while x < line.len() {
        let (&code, rest) = data.split_first()?;
        if code > 128 {
            let (&value, rest) = rest.split_first()?;
            let run = line.get_mut(x..x + usize::from(code - 128))?;
            run.iter_mut().for_each(|p| p[channel] = value);
            x += run.len();
            data = rest;
        } else {
            let (values, rest) = rest.split_at_checked(usize::from(code))?;
            let run = line.get_mut(x..x + values.len())?;
            run.iter_mut().zip(values).for_each(|(p, &v)| p[channel] = v);
            x += run.len();
            data = rest;
        }
    }
    Some(data)
}

/// Uncompressed pixels, in which `1 1 1 n` repeats the previous pixel n times; consecutive markers supply higher
/// bytes of the count.
fn read_pixels<'a>(mut data: &'a [u8], line: &mut [Rgbe]) -> Option<&'a [u8]> {
    let (mut x, mut shift) = (0, 0);
    while x < line.len() {
        let (&pixel, rest) = data.split_first_chunk::<4>()?;
        data = rest;
        if pixel[..3] == [1, 1, 1] {
            // A width has at most 15 bits, so the higher bytes of a valid count are zero.
            let count = usize::from(pixel[3]).checked_shl(shift).filter(|_| shift <= 24)?;
            let previous = *line.get(x.checked_sub(1)?)?;
            line.get_mut(x..x.checked_add(count)?)?.fill(previous);
            x += count;
            shift += 8;
        } else {
            line[x] = pixel;
            x += 1;
            shift = 0;
        }
    }
    Some(data)
}

fn to_linear([r, g, b, e]: Rgbe) -> [f32; 3] {
    if e == 0 {
        return [0.0; 3];
    }
    let scale = power_of_two(i32::from(e) - 136);
    [r, g, b].map(|m| (f64::from(m) * scale) as f32)
}

/// The nearest RGBE value. Negative and NaN become 0; larger values are clamped to 255 * 2^119.
fn to_rgbe(rgb: [f32; 3]) -> Rgbe {
    // 255 * 2^119 = 1.69e38.
    let most = (255.0 * power_of_two(119)) as f32;
    let rgb = rgb.map(|v| if v > 0.0 { v.min(most) } else { 0.0 });
    let max = rgb[0].max(rgb[1]).max(rgb[2]);
    if max == 0.0 {
        return [0; 4];
    }
    // floor(log2(max)). For subnormals it is -127, and some bits are lost.
    let mut exponent = (max.to_bits() >> 23) as i32 - 127;
    if (f64::from(max) * power_of_two(7 - exponent)).round() >= 256.0 {
        exponent += 1;
    }
    let e = exponent + 129;
    if e < 1 {
        return [0; 4];
    }
    let scale = power_of_two(7 - exponent);
    let m = rgb.map(|v| (f64::from(v) * scale).round().min(255.0) as u8);
    [m[0], m[1], m[2], e.min(255) as u8]
}

/// `2^n` for n in -1022..=1023.
fn power_of_two(n: i32) -> f64 {
    f64::from_bits(((1023 + i64::from(n.clamp(-1022, 1023))) as u64) << 52)
}

/// Encodes the linear samples; alpha and metadata are dropped.
pub fn encode(image: &OutputImage<'_>) -> Result<Vec<u8>, ImageError> {
    super::encode(image, FORMAT)
}

/// Writes the linear samples strip by strip.
pub(super) fn write(image: &StripImage<'_>, out: &mut dyn WriteSeek) -> io::Result<()> {
    let OutputImage { width, height, threads, .. } = *image.image;
    image.image.pixels(FORMAT).map_err(refused)?;
    let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    let width = width as usize;
    let mut channel = Vec::with_capacity(width);
    for rows in image.strips(STRIP) {
        for row in image.linear(rows, threads)?.chunks_exact(width) {
            let line: Vec<Rgbe> = row.iter().map(|p| to_rgbe([p[0], p[1], p[2]])).collect();
            if !RLE_WIDTHS.contains(&width) {
                bytes.extend_from_slice(line.as_flattened());
                continue;
            }
            bytes.extend_from_slice(&[2, 2, (width >> 8) as u8, (width & 255) as u8]);
            for c in 0..4 {
                channel.clear();
                channel.extend(line.iter().map(|p| p[c]));
                write_channel(&channel, &mut bytes);
            }
        }
        out.write_all(&bytes)?;
        bytes.clear();
    }
    Ok(())
}

/// Pixels of a strip.
const STRIP: u32 = 1 << 20;

/// Encodes runs of four or more as `128 + n, value`, everything else as `n, values…` with n at most 128.
fn write_channel(values: &[u8], out: &mut Vec<u8>) {
    let run_at = |i: usize| values[i..].iter().take(127).take_while(|&&v| v == values[i]).count();
    let (mut start, mut i) = (0, 0);
    let literal = |from: usize, to: usize, out: &mut Vec<u8>| {
        for part in values[from..to].chunks(128) {
            out.push(part.len() as u8);
            out.extend_from_slice(part);
        }
    };
    while i < values.len() {
        let run = run_at(i);
        if run >= 4 {
            literal(start, i, out);
            out.extend_from_slice(&[128 + run as u8, values[i]]);
            start = i + run;
        }
        i += run;
    }
    literal(start, values.len(), out);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rgbe_is_within_its_step_at_all_scales() {
        for exponent in -120..127 {
            for mantissa in [1.0_f64, 1.0039, 1.5, 1.995, 1.9999999] {
                let v = (mantissa * power_of_two(exponent)) as f32;
                let back = to_linear(to_rgbe([v, v / 3.0, 0.0]));
                for (b, want) in back.iter().zip([v, v / 3.0, 0.0]) {
                    // The step is 2^-8 relative to a power of two not above the largest channel;
                    // allow half of it.
                    assert!((b - want).abs() <= v / 255.0, "{v:e} {b:e} {want:e}");
                }
            }
        }
        assert_eq!(to_rgbe([-1.0, f32::NAN, 0.0]), [0; 4]);
        assert_eq!(to_rgbe([f32::INFINITY, 0.0, 0.0]), [255, 0, 0, 255]);
        assert_eq!(to_linear(to_rgbe([1.0, 0.5, 0.25])), [1.0, 0.5, 0.25]);
    }

    #[test]
    fn channels_survive_run_length_encoding() {
        let cases = [vec![7; 1000], (0..=255).cycle().take(700).collect(), vec![1, 1, 1, 2, 2, 2, 2, 2, 3]];
        for values in cases {
            let mut coded = Vec::new();
            write_channel(&values, &mut coded);
            let mut line = vec![[0; 4]; values.len()];
            assert_eq!(read_channel(&coded, &mut line, 2), Some(&[][..]));
            assert!(line.iter().map(|p| p[2]).eq(values.iter().copied()));
        }
    }
}
