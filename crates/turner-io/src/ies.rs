//! IES light profiles: ANSI/IESNA LM-63 (1986, 1991, 1995, 2002), with photometry of type C (most luminaires) and of
//! types A and B (floodlights).
//!
//! A file has header lines `[KEYWORD] text`, a line `TILT=…`, and then numbers. Line breaks between numbers have no
//! meaning:
//!
//! | count | meaning |
//! |---|---|
//! | 10 | number of lamps, lumens per lamp, multiplier, number of vertical and horizontal angles, type (1 is C, 2 is B, 3 is A), units, width, length, height |
//! | 3 | ballast factor, one reserved value, watts |
//! | as given above | vertical angles; horizontal angles; candela: for each horizontal angle, all vertical ones |
//!
//! Angles that the file omits because of symmetry are filled in: horizontal ranges that end at 0, 90 or 180, or run
//! from 90 to 270; in types A and B, negative angles when the range starts at 0.

use std::io::{self, Write};

use turner::schema::{LightProfile, Warning, WarningKind};

use crate::assets::printable;
use crate::ies_floodlight::{Floodlight, Measured};

/// Why an IES file could not be read: file, problem and remedy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum IesError {
    /// The file is not valid.
    #[error("{name}: damaged IES file: line {line}: {problem}\n  export or download it again")]
    Damaged {
        /// The file.
        name: String,
        /// The line, from 1.
        line: usize,
        /// What was found and what was expected.
        problem: String,
    },
    /// Valid, but not supported.
    #[error("{name}: line {line}: {what} cannot be read\n  convert it to photometry of type C")]
    Unsupported {
        /// The file.
        name: String,
        /// The line, from 1.
        line: usize,
        /// The unsupported feature.
        what: String,
    },
}

/// Largest accepted file, in bytes.
pub const MAX_IES: u64 = 64 << 20;

/// Most vertical or horizontal angles.
const MAX_ANGLES: usize = 100_000;

/// Reads the numbers of a file and keeps track of the line.
struct Numbers<'a> {
    name: &'a str,
    lines: std::iter::Enumerate<std::str::Lines<'a>>,
    words: std::vec::IntoIter<&'a str>,
    line: usize,
    /// Length of the text, an upper bound of the count of numbers.
    bytes: usize,
}

impl<'a> Numbers<'a> {
    fn damaged(&self, problem: String) -> IesError {
        IesError::Damaged { name: printable(self.name), line: self.line, problem }
    }

    fn next(&mut self, what: &str) -> Result<f64, IesError> {
        let word = loop {
            if let Some(word) = self.words.next() {
                break word;
            }
            let Some((i, line)) = self.lines.next() else {
                return Err(self.damaged(format!("the file ends; expected {what}")));
            };
            self.line = i + 1;
            let separates = |c: char| c.is_ascii_whitespace() || c == ',';
            let words: Vec<&str> = line.split(separates).filter(|w| !w.is_empty()).collect();
            self.words = words.into_iter();
        };
        match word.parse::<f64>() {
            Ok(v) if v.is_finite() => Ok(v),
            _ => {
                let word: String = word.chars().take(40).collect();
                Err(self.damaged(format!("expected a number ({what}), found \"{}\"", printable(&word))))
            }
        }
    }

    /// A count of values, each of which takes at least two bytes of the file.
    fn count(&mut self, what: &str) -> Result<usize, IesError> {
        let v = self.next(what)?;
        if v < 0.0 || v != v.floor() || v > (self.bytes / 2 + 1).min(MAX_ANGLES) as f64 {
            return Err(self.damaged(format!("{v} is not a possible number of {what}")));
        }
        Ok(v as usize)
    }

    fn list(&mut self, count: usize, what: &str) -> Result<Vec<f64>, IesError> {
        (0..count).map(|_| self.next(what)).collect()
    }
}

/// Reads a file. `name` appears in messages. The warnings say what was ignored or is doubtful.
pub fn decode(bytes: &[u8], name: &str) -> Result<(LightProfile, Vec<Warning>), IesError> {
    let text = String::from_utf8_lossy(bytes);
    let mut warnings = Vec::new();
    let mut warn =
        |kind, text: &str| warnings.push(Warning::new(kind, format!("{}: {text}", printable(name))));
    let mut lines = text.lines().enumerate();
    let tilt = lines.find_map(|(i, line)| {
        let line = line.trim();
        let is_tilt = line.get(..4).is_some_and(|start| start.eq_ignore_ascii_case("TILT"));
        let (_, value) = line.split_once('=').filter(|_| is_tilt)?;
        Some((i, value.trim()))
    });
    let Some((i, tilt)) = tilt else {
        let problem = "the line TILT=… is missing: is this an IES file?".to_owned();
        return Err(IesError::Damaged { name: printable(name), line: text.lines().count().max(1), problem });
    };
    let mut numbers = Numbers { name, lines, words: Vec::new().into_iter(), line: i + 1, bytes: text.len() };
    if tilt.eq_ignore_ascii_case("INCLUDE") {
        numbers.next("the lamp's orientation (TILT)")?;
        let pairs = numbers.count("tilt angles and factors")?;
        numbers.list(2 * pairs, "tilt")?;
    }
    if !tilt.eq_ignore_ascii_case("NONE") {
        warn(WarningKind::Ignored, "TILT: the change of intensity when the lamp is tilted");
    }
    numbers.list(2, "number of lamps and lumens per lamp")?;
    let factor = numbers.next("the candela multiplier")?;
    let rows = numbers.count("vertical angles")?;
    let columns = numbers.count("horizontal angles")?;
    let kind = numbers.next("the type of photometry")?;
    let floodlight = match kind {
        1.0 => None,
        2.0 => Some(Floodlight::B),
        3.0 => Some(Floodlight::A),
        other => {
            let what = format!("photometry of type {other}");
            return Err(IesError::Unsupported { name: printable(name), line: numbers.line, what });
        }
    };
    numbers.list(4, "the units and size of the luminous opening")?;
    let ballast = numbers.next("the ballast factor")?;
    numbers.list(2, "watts")?;
    if rows == 0 || columns == 0 || rows.saturating_mul(columns) > text.len() {
        let problem = format!("{rows} by {columns} angles is not a possible number");
        return Err(numbers.damaged(problem));
    }
    let vertical = numbers.list(rows, "vertical angles")?;
    let horizontal = numbers.list(columns, "horizontal angles")?;
    let factor = factor * ballast;
    let mut planes = Vec::with_capacity(columns);
    let mut negative = false;
    for _ in 0..columns {
        let plane = numbers.list(rows, "candela")?;
        negative |= plane.iter().any(|v| v * factor < 0.0);
        let brightness = |v: f64| (v * factor).clamp(0.0, f64::from(f32::MAX)) as f32;
        planes.push(plane.into_iter().map(brightness).collect::<Vec<f32>>());
    }
    if negative {
        warn(WarningKind::Doubtful, "negative intensities are read as 0");
    }
    let profile = match floodlight {
        Some(kind) => kind.profile(&Measured { horizontal, vertical, candela: planes }),
        None => type_c(vertical, &horizontal, &planes),
    };
    let profile = profile.map_err(|e| numbers.damaged(e.into()))?;
    if profile.peak() == 0.0 {
        warn(WarningKind::Doubtful, "all intensities are 0: the light emits nothing");
    }
    Ok((profile, warnings))
}

/// A profile of type C, with symmetric angles filled in.
fn type_c(vertical: Vec<f64>, horizontal: &[f64], planes: &[Vec<f32>]) -> Result<LightProfile, &'static str> {
    let circle = full_circle(horizontal).ok_or(
        "horizontal angles must increase from 0 to 0, 90, 180 or 360, or from 90 through 180 to 270",
    )?;
    let candela = circle.iter().flat_map(|(_, plane)| planes[*plane].iter().copied()).collect();
    let angles = circle.iter().map(|(angle, _)| *angle).collect();
    LightProfile::new(vertical, angles, candela)
}

/// Writes a profile as a file that [`decode`] reads back unchanged.
pub fn write(profile: &LightProfile, out: &mut dyn Write) -> io::Result<()> {
    let (vertical, horizontal) = (profile.vertical(), profile.horizontal());
    writeln!(out, "IESNA:LM-63-2002\n[OTHER] written by Turner\nTILT=NONE")?;
    writeln!(out, "1 -1 1 {} {} 1 2 0 0 0\n1 1 0", vertical.len(), horizontal.len())?;
    let mut line = |numbers: &mut dyn Iterator<Item = f64>| {
        let words: Vec<String> = numbers.map(|v| v.to_string()).collect();
        words.chunks(12).try_for_each(|words| writeln!(out, "{}", words.join(" ")))
    };
    line(&mut vertical.iter().copied())?;
    line(&mut horizontal.iter().copied())?;
    let rows = profile.intensities().chunks(vertical.len().max(1));
    rows.into_iter().try_for_each(|row| line(&mut row.iter().map(|v| f64::from(*v))))
}

/// Completes the horizontal angles to the full circle: each angle with the index of the measured plane that it
/// repeats. `None` if the measured range is not one that the format allows.
fn full_circle(given: &[f64]) -> Option<Vec<(f64, usize)>> {
    let (first, last) = (*given.first()?, *given.last()?);
    if !given.windows(2).all(|w| w[0] < w[1]) {
        return None;
    }
    let mut circle: Vec<(f64, usize)> = given.iter().copied().zip(0..).collect();
    // Adds the planes mirrored at an angle.
    let mirrored = |circle: &mut Vec<(f64, usize)>, at: f64| {
        circle.extend(circle.clone().into_iter().map(|(angle, i)| ((2.0 * at - angle).rem_euclid(360.0), i)));
    };
    match (first, last) {
        // Rotationally symmetric.
        (0.0, 0.0) => return Some(vec![(0.0, 0)]),
        (0.0, 360.0) => return Some(circle),
        (0.0, 180.0) => mirrored(&mut circle, 180.0),
        (0.0, 90.0) => {
            mirrored(&mut circle, 90.0);
            mirrored(&mut circle, 180.0);
        }
        (90.0, 270.0) => mirrored(&mut circle, 90.0),
        _ => return None,
    }
    circle.sort_by(|a, b| a.0.total_cmp(&b.0));
    circle.dedup_by(|a, b| a.0 == b.0);
    let (_, zero) = *circle.first()?;
    // The circle must begin at 0. After mirroring at 90 that requires a measured plane at 180.
    if circle.first()?.0 != 0.0 {
        return None;
    }
    circle.push((360.0, zero));
    Some(circle)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file with these horizontal angles and one value per plane.
    fn file(horizontal: &[f64], candela: &[f64]) -> Vec<u8> {
        let list = |v: &[f64]| v.iter().map(|v| v.to_string()).collect::<Vec<_>>().join(" ");
        let n = horizontal.len();
        let planes: Vec<f64> = candela.iter().flat_map(|v| [*v, *v]).collect();
        format!(
            "IESNA:LM-63-1995\n[TEST] none\nTILT=NONE\n1 -1 2 2 {n} 1 2 0 0 0\n0.5 1 60\n0 90\n{}\n{}\n",
            list(horizontal),
            list(&planes)
        )
        .into_bytes()
    }

    #[test]
    fn symmetries_are_filled_in() {
        let at = |file: &[u8], horizontal: f64| decode(file, "a.ies").unwrap().0.candela(30.0, horizontal);
        let round = file(&[0.0], &[7.0]);
        let quadrant = file(&[0.0, 45.0, 90.0], &[1.0, 2.0, 4.0]);
        let half = file(&[0.0, 90.0, 180.0], &[1.0, 2.0, 4.0]);
        let sideways = file(&[90.0, 180.0, 270.0], &[1.0, 2.0, 4.0]);
        let full = file(&[0.0, 90.0, 180.0, 270.0, 360.0], &[1.0, 2.0, 3.0, 4.0, 1.0]);
        for (file, expected) in [
            (&round, [7.0; 8]),
            (&quadrant, [1.0, 2.0, 4.0, 2.0, 1.0, 2.0, 4.0, 2.0]),
            (&half, [1.0, 1.5, 2.0, 3.0, 4.0, 3.0, 2.0, 1.5]),
            (&sideways, [2.0, 1.5, 1.0, 1.5, 2.0, 3.0, 4.0, 3.0]),
            (&full, [1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 2.5]),
        ] {
            for (i, expected) in expected.into_iter().enumerate() {
                let found = at(file, 45.0 * i as f64);
                assert!((found - expected).abs() < 1e-5, "{expected:?} {i}: {found}");
            }
        }
    }

    #[test]
    fn floodlights_are_aimed_along_the_axis() {
        let good = String::from_utf8(file(&[0.0, 45.0, 90.0], &[6.0, 3.0, 0.0])).unwrap();
        for kind in ["2", "3"] {
            let text = good.replace("3 1 2 0 0 0", &format!("3 {kind} 2 0 0 0"));
            let (profile, _) = decode(text.as_bytes(), "a.ies").unwrap();
            assert!((profile.candela(0.0, 0.0) - 6.0).abs() < 1e-3, "{kind}");
            for side in [0.0, 180.0] {
                assert!((profile.candela(45.0, side) - 3.0).abs() < 0.05, "{kind} {side}");
            }
        }
    }

    #[test]
    fn numbers_may_stand_anywhere_and_factors_count() {
        let text = "IESNA91\r\n[X]\r\ntilt = INCLUDE\r\n1\r\n2\r\n0 90\r\n1 0.5\r\n1,1000 \t3\r\n2\r\n1 1 1 0,0,0\r\n\
                    0.5 1 9 0 45 0 10\r\n 4e1";
        let (profile, warnings) = decode(text.as_bytes(), "a.ies").unwrap();
        assert_eq!((profile.peak(), profile.candela(0.0, 12.0)), (60.0, 15.0));
        assert_eq!(profile.candela(46.0, 0.0), 0.0);
        assert_eq!(warnings.len(), 1);
        assert_eq!(warnings[0].kind, WarningKind::Ignored);
    }

    #[test]
    fn what_is_wrong_is_said() {
        let good = String::from_utf8(file(&[0.0], &[7.0])).unwrap();
        let says = |text: &str, words: &str| {
            let message = decode(text.as_bytes(), "a.ies").unwrap_err().to_string();
            assert!(message.starts_with("a.ies: ") && message.contains(words), "{message}");
        };
        says("", "TILT");
        says("hello\nworld", "line 2");
        says(&good.replace("TILT=NONE\n", "TILT=NONE "), "not a possible number");
        says(&good.replace("1 -1", "1 x\u{7}y"), "expected a number");
        says(&good.replace("2 2 1", "2 99999 1"), "not a possible number of vertical angles");
        says(&good.replace("2 2 1", "2 2.5 1"), "not a possible number");
        says(&good.replace("2 2 1", "2 0 1"), "not a possible number");
        says(&good.replace("1 1 2 0 0 0", "1 4 2 0 0 0"), "photometry of type 4");
        says(&good.replace("1 1 2 0 0 0", "1 2 2 0 0 0").replace("0 90", "0 91"), "types A and B");
        says(&good.replace("0 90\n", "90 0\n"), "vertical angles must increase");
        says(&good.replace("7 7", "7"), "the file ends; expected candela");
        says(&good.replace("7 7", "7 inf"), "expected a number");
        says(&String::from_utf8(file(&[0.0, 100.0], &[1.0, 2.0])).unwrap(), "horizontal angles");
        says(&String::from_utf8(file(&[90.0, 91.0, 270.0], &[1.0; 3])).unwrap(), "horizontal angles");
        let (dark, warnings) = decode(good.replace("7 7", "-1 0").as_bytes(), "a.ies").unwrap();
        assert_eq!((dark.peak(), warnings.len()), (0.0, 2));
    }

    #[test]
    fn no_file_breaks_it() {
        let good = file(&[0.0, 45.0, 90.0], &[1.0, 2.0, 4.0]);
        for end in 0..good.len() {
            let _ = decode(&good[..end], "a.ies");
        }
        for i in 0..good.len() {
            for byte in [0, b'9', b'-', b'e', b' ', 255] {
                let mut bad = good.clone();
                bad[i] = byte;
                let _ = decode(&bad, "a.ies");
            }
        }
        let huge = b"TILT=NONE 1 1 1 1e9 1e9 1 1 0 0 0 1 1 1";
        assert!(decode(huge, "a.ies").is_err());
    }
}
