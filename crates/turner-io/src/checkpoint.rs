//! Checkpoints: a film in a file, with what is needed to load its scene again.
//!
//! ```text
//! turner-checkpoint 2          magic word and version
//! header 812 bytes             length of the header
//! { "turner": "0.1.0", … }     the header: JSON, see Header
//! film 431223 bytes            length of the film
//! …                            the film: Film::to_bytes, which ends with its own hash
//! …                            hash of the bytes before the film and of the film's hash (turner::film::checksum, u64,
//!                              little endian)
//! ```
//!
//! The lines end with a line feed, also the last one of the header. So `head -n 20 FILE` shows what a checkpoint is of.

use std::io::{self, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};
use turner::film::{Checksum, Film, checksum};
use turner::schema::{ErrorCode, Limits, SceneError};

use crate::assets::printable;
use crate::image::{OutputError, OutputFile};

/// The extension of checkpoints, without the dot.
pub const EXTENSION: &str = "turner-checkpoint";

const MAGIC: &str = "turner-checkpoint ";

/// The version that is written and read.
const VERSION: u32 = 2;

/// The largest header in bytes.
const MAX_HEADER: u64 = 1 << 20;

/// The longest line before the header.
const MAX_LINE: usize = 80;

/// Size of the hash in bytes.
const HASH: usize = 8;

/// What a checkpoint is of. Keys that a reader does not know are ignored.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// The version of Turner that traced the samples.
    pub turner: String,
    /// The scene as given.
    pub scene: String,
    /// The folder that relative paths refer to, absolute.
    pub folder: String,
    /// Hash of the scene's files and options, without `--samples` and `--crop`: 32 hexadecimal digits.
    pub scene_hash: String,
    /// The options that the picture depends on, as arguments of `turner render`.
    pub arguments: Vec<String>,
    /// The index of the picture in a sequence.
    pub step: Option<u32>,
    /// The picture that is rendered; none for a part that is to be merged.
    pub output: Option<Output>,
    /// Whether the user named the file: then it stays when the picture is done.
    pub keep: bool,
    /// Width and height of the full picture in pixels, for readers.
    pub size: [u32; 2],
    /// First column, first row, columns and rows of the part that is rendered, for readers.
    pub crop: [u32; 4],
    /// Samples per pixel of the finished picture, for readers.
    pub samples: u32,
    /// Samples per pixel that the film holds, as a mean over the pixels, for readers.
    pub held: f64,
    /// Seconds of tracing.
    pub seconds: f64,
}

/// The picture that a checkpoint is for.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Output {
    /// Its path as given.
    pub path: String,
    /// The extension of its format, such as "png".
    pub format: String,
}

/// A film with its header.
#[derive(Clone, Debug)]
pub struct Checkpoint {
    /// What it is of.
    pub header: Header,
    /// The samples.
    pub film: Film,
}

/// The number that a film has as fingerprint of its scene: the first half of the scene's hash.
pub fn fingerprint(scene_hash: &str) -> u64 {
    scene_hash.get(..16).and_then(|digits| u64::from_str_radix(digits, 16).ok()).unwrap_or(0)
}

/// A checkpoint as bytes.
///
/// Errors: a header that is too large; not enough memory.
pub fn to_bytes(header: &Header, film: &Film) -> Result<Vec<u8>, SceneError> {
    let (start, length) = start(header, film)?;
    let mut out = Vec::new();
    if out.try_reserve_exact(start.len() + length as usize + HASH).is_err() {
        return Err(SceneError::new(ErrorCode::TooLarge, "not enough memory for a checkpoint"));
    }
    // A vector takes all bytes.
    let _ = put(&start, film, &mut out);
    Ok(out)
}

/// The lines before the film, and the film's length in bytes.
fn start(header: &Header, film: &Film) -> Result<(String, u64), SceneError> {
    let text = serde_json::to_string_pretty(header).unwrap_or_default() + "\n";
    if text.len() as u64 > MAX_HEADER {
        let message =
            format!("the options are too long for a checkpoint; expected at most {MAX_HEADER} bytes");
        return Err(SceneError::new(ErrorCode::TooLarge, message));
    }
    let length = film.bytes_length();
    Ok((format!("{MAGIC}{VERSION}\nheader {} bytes\n{text}film {length} bytes\n", text.len()), length))
}

fn put(start: &str, film: &Film, out: &mut dyn Write) -> io::Result<()> {
    out.write_all(start.as_bytes())?;
    let mut film_hash = [0; HASH];
    film.write_to(&mut |part| {
        // The film's hash is its last piece.
        if let Ok(hash) = part.try_into() {
            film_hash = hash;
        }
        out.write_all(part)
    })?;
    out.write_all(&hash(start.as_bytes(), film_hash).to_le_bytes())
}

/// A checkpoint that was changed, with the right hashes of its film and of its own: for tests of readers. Bytes without
/// the lines of a checkpoint stay as they are.
pub fn resealed(bytes: &[u8]) -> Vec<u8> {
    let mut out = bytes.to_vec();
    let film = line(bytes)
        .and_then(|(_, rest)| sized(rest, "header "))
        .and_then(|(length, rest)| sized(rest.get(usize::try_from(length).ok()?..)?, "film "));
    let Some(length) = film.map(|(_, film)| film.len()).filter(|length| *length >= 2 * HASH) else {
        return out;
    };
    let start = out.len() - length;
    let ends = [out.len() - 2 * HASH, out.len() - HASH];
    let film_hash = checksum(&out[start..ends[0]]).to_le_bytes();
    out[ends[0]..ends[1]].copy_from_slice(&film_hash);
    let own = hash(&out[..start], film_hash).to_le_bytes();
    out[ends[1]..].copy_from_slice(&own);
    out
}

/// The hash at the end of a checkpoint.
fn hash(start: &[u8], film_hash: [u8; HASH]) -> u64 {
    let mut sum = Checksum::new((start.len() + HASH) as u64);
    sum.add(start);
    sum.add(&film_hash);
    sum.finish()
}

/// Writes a checkpoint to a file, atomically and without a copy of the film in memory.
///
/// Errors: a header that is too large; a file that cannot be written. Displayed as the problem, then the remedy on a
/// second line.
pub fn write_film(path: &Path, header: &Header, film: &Film) -> Result<(), String> {
    let (start, length) = start(header, film).map_err(|e| e.message)?;
    let file = OutputFile::create(path).map_err(|e| e.to_string())?;
    file.check_space(start.len() as u64 + length + HASH as u64).map_err(|e| e.to_string())?;
    file.commit_with(|out| put(&start, film, out)).map_err(|e| e.to_string())
}

/// Whether bytes begin like a checkpoint of any version.
pub fn is_checkpoint(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC.as_bytes())
}

/// Reads the bytes of [`to_bytes`]; `name` appears in messages. Memory is requested from `limits` before it is
/// allocated.
///
/// Errors: bytes that are no checkpoint, of another version, truncated or damaged ([`ErrorCode::Film`]); more pixels
/// or memory than allowed ([`ErrorCode::TooLarge`]).
pub fn from_bytes(bytes: &[u8], name: &str, limits: &Limits) -> Result<Checkpoint, SceneError> {
    let name = printable(name);
    let bad = |what: &str| {
        SceneError::new(ErrorCode::Film, format!("{name}: {what}"))
            .help("copy the file again, or render again")
    };
    let end = || bad("the checkpoint ends too early");
    if !is_checkpoint(bytes) {
        return Err(SceneError::new(ErrorCode::Film, format!("{name}: is not a checkpoint of Turner"))
            .help(format!("expected a file that `turner render` wrote, such as .picture.png.{EXTENSION}")));
    }
    let (first, rest) = line(bytes).ok_or_else(end)?;
    let version = first.strip_prefix(MAGIC).unwrap_or_default();
    if version != VERSION.to_string() {
        let found = printable(version);
        let message = format!("{name}: the checkpoint has version {found}; expected {VERSION}");
        return Err(SceneError::new(ErrorCode::Film, message)
            .help("continue it with the version of Turner that wrote it"));
    }
    let (content, check) = bytes.len().checked_sub(HASH).map(|at| bytes.split_at(at)).ok_or_else(end)?;
    let rest = rest.get(..rest.len().saturating_sub(HASH)).unwrap_or_default();
    let (length, rest) = sized(rest, "header ").ok_or_else(|| bad("the line `header N bytes` is missing"))?;
    if length > MAX_HEADER {
        return Err(bad(&format!("the header has {length} bytes; expected at most {MAX_HEADER}")));
    }
    let (text, rest) = rest.split_at_checked(length as usize).ok_or_else(end)?;
    let header: Header = serde_json::from_slice(text)
        .map_err(|e| bad(&format!("the header is invalid: {}", printable(&e.to_string()))))?;
    let (length, film) = sized(rest, "film ").ok_or_else(|| bad("the line `film N bytes` is missing"))?;
    let before = content.get(..content.len() - film.len()).unwrap_or_default();
    let own_hash = film.last_chunk().filter(|_| length == film.len() as u64);
    if own_hash.is_none_or(|own| hash(before, *own).to_le_bytes() != check) {
        return Err(bad("the checkpoint is damaged or incomplete: its checksum is wrong"));
    }
    let film = Film::from_bytes(film, limits).map_err(|mut error| {
        error.message = format!("{name}: {}", error.message);
        error
    })?;
    if film.identity().scene != Some(fingerprint(&header.scene_hash)) {
        return Err(bad("header and film are of different scenes"));
    }
    Ok(Checkpoint { header, film })
}

/// The first line, and what follows it.
fn line(bytes: &[u8]) -> Option<(&str, &[u8])> {
    let end = bytes.iter().take(MAX_LINE).position(|b| *b == b'\n')?;
    let (first, rest) = bytes.split_at(end);
    Some((std::str::from_utf8(first).ok()?, rest.get(1..)?))
}

/// A line such as `film 12 bytes`.
fn sized<'a>(bytes: &'a [u8], word: &str) -> Option<(u64, &'a [u8])> {
    let (first, rest) = line(bytes)?;
    let digits = first.strip_prefix(word)?.strip_suffix(" bytes")?;
    let plain = !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit());
    Some((digits.parse().ok().filter(|_| plain)?, rest))
}

/// Reads a checkpoint from a regular file.
///
/// Errors: the file cannot be read ([`ErrorCode::File`]); those of [`from_bytes`].
pub fn read(path: &Path, limits: &Limits) -> Result<Checkpoint, SceneError> {
    let name = path.to_string_lossy();
    let failed = |what: &str| {
        let message = format!("{}: {what}", printable(&name));
        SceneError::new(ErrorCode::File, message)
            .help("name a checkpoint: `.PICTURE.turner-checkpoint` beside the picture")
    };
    let meta = std::fs::metadata(path).map_err(|e| failed(&format!("cannot be read: {e}")))?;
    if !meta.is_file() {
        return Err(failed("is not a file"));
    }
    limits.memory.need(meta.len(), || format!("the checkpoint {}", printable(&name)))?;
    let bytes = std::fs::read(path).map_err(|e| failed(&format!("cannot be read: {e}")))?;
    from_bytes(&bytes, &name, limits)
}

/// Writes a file atomically: at any moment the path holds the old file or the new one.
///
/// Errors: those of [`OutputFile`].
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let file = OutputFile::create(path)?;
    file.check_space(bytes.len() as u64)?;
    file.commit(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use turner::description::SceneDesc;

    fn example() -> (Header, Film) {
        let mut desc = SceneDesc::default().film;
        (desc.width, desc.height) = (20, 3);
        let header = Header {
            turner: "0.1.0".into(),
            scene: "a b.toml".into(),
            scene_hash: "0123456789abcdef0000000000000000".into(),
            arguments: vec!["set film.width=4\n\u{1b}".into()],
            output: Some(Output { path: "x.png".into(), format: "png".into() }),
            ..Header::default()
        };
        let mut film = Film::new(&desc).unwrap();
        film.set_scene(fingerprint(&header.scene_hash));
        (header, film)
    }

    fn read(bytes: &[u8]) -> Result<Checkpoint, SceneError> {
        from_bytes(bytes, "c", &Limits::default())
    }

    #[test]
    fn checkpoints_round_trip_and_can_be_read_by_people() {
        let (header, film) = example();
        let bytes = to_bytes(&header, &film).unwrap();
        let back = read(&bytes).unwrap();
        assert_eq!(back.header, header);
        assert!(back.film.to_bytes() == film.to_bytes());
        let text = String::from_utf8_lossy(&bytes);
        assert!(text.starts_with("turner-checkpoint 2\nheader ") && text.contains("\"scene\": \"a b.toml\""));
        assert!(!text.split("\nfilm ").next().unwrap().contains('\u{1b}'));
    }

    #[test]
    fn every_truncation_and_every_flipped_bit_is_noticed() {
        let (header, film) = example();
        let bytes = to_bytes(&header, &film).unwrap();
        for length in 0..bytes.len() {
            assert!(read(&bytes[..length]).is_err(), "{length}");
            assert!(read(&resealed(&bytes[..length])).is_err(), "{length}");
        }
        for bit in 0..8 * bytes.len() {
            let mut bytes = bytes.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(read(&bytes).unwrap_err().code, ErrorCode::Film, "{bit}");
        }
    }

    /// Damage with a valid checksum: an error or a checkpoint, no panic and no large allocation.
    #[test]
    fn forged_checkpoints_are_refused() {
        let (header, film) = example();
        let bytes = to_bytes(&header, &film).unwrap();
        for at in 0..bytes.len() - 2 * HASH {
            for value in [0, 0xff, b'9', bytes[at] ^ 1] {
                let mut forged = bytes.clone();
                forged[at] = value;
                if let Err(error) = read(&resealed(&forged)) {
                    assert!(!error.message.is_empty() && !error.message.contains('\u{1b}'), "{at}");
                }
            }
        }
        let refused = |old: &str, new: &str, what: &str| {
            let at = bytes.windows(old.len()).position(|w| w == old.as_bytes()).unwrap();
            let forged = [&bytes[..at], new.as_bytes(), &bytes[at + old.len()..]].concat();
            let message = read(&resealed(&forged)).unwrap_err().message;
            assert!(message.contains(what), "{message}");
        };
        refused("turner-checkpoint 2", "turner-checkpoint 3", "has version 3; expected 2");
        refused("turner-checkpoint 2", "turner-picture", "is not a checkpoint");
        refused("header ", "header 9999999999", "expected at most");
        refused("header ", "header -", "`header N bytes` is missing");
        refused("\"turner\": \"0.1.0\",", "                  ", "missing field `turner`");
        refused("0123456789abcdef", "1123456789abcdef", "of different scenes");
        let mut deep = header.clone();
        deep.scene = "[".repeat(1 << 21);
        assert_eq!(to_bytes(&deep, &film).unwrap_err().code, ErrorCode::TooLarge);
    }
}
