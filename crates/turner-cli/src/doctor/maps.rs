//! Writes the maps of the doctor as PNG files.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use turner::color::{heat, srgb_encode};
use turner::description::SceneDesc;
use turner::doctor::PathKind;
use turner::doctor::maps::Map;
use turner::schema::{ErrorCode, SceneError};
use turner_io::image::{Display, ImageFormat, Metadata, OutputFile, OutputImage, Transfer, encode};

use crate::failure::{Failure, two_lines};

/// The output of maps.
pub(super) enum Target {
    /// One file per map.
    Folder(PathBuf),
    /// All maps side by side.
    File(PathBuf),
}

/// A written file.
pub(super) struct Written {
    pub(super) path: String,
    /// Its content as text.
    pub(super) shows: String,
    pub(super) names: Vec<&'static str>,
    pub(super) ranges: Value,
}

fn output(e: &turner_io::image::OutputError) -> Failure {
    Failure::new(two_lines(ErrorCode::Output, &e.to_string()))
}

impl Target {
    /// Checks the path before any work is done.
    pub(super) fn new(path: &Path) -> Result<Target, Failure> {
        let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        if path.is_dir() || extension.is_none() {
            return Ok(Target::Folder(path.to_owned()));
        }
        if extension.as_deref() != Some("png") {
            let shown = turner::schema::error::escape(&path.to_string_lossy());
            let message = format!("{shown}: maps are written as PNG files");
            let help = "name a folder or a file that ends with .png";
            return Err(Failure::usage(SceneError::new(ErrorCode::Output, message).help(help)));
        }
        OutputFile::create(path).map_err(|e| output(&e))?;
        Ok(Target::File(path.to_owned()))
    }

    /// Checks that the output does not overwrite a file that the scene reads.
    pub(super) fn check_against(&self, scene: &Path, desc: &SceneDesc) -> Result<(), Failure> {
        let Target::File(path) = self else { return Ok(()) };
        let own = path.canonicalize().ok();
        let folder = scene.parent().unwrap_or(Path::new(""));
        let mut read = desc.images.iter().map(|i| folder.join(&i.uri)).chain([scene.to_owned()]);
        if own.is_some() && read.any(|p| p.canonicalize().ok() == own) {
            let message = format!("{}: the scene reads this file", path.display());
            return Err(Failure::new(
                SceneError::new(ErrorCode::Output, message).help("choose another file with `-o`"),
            ));
        }
        Ok(())
    }

    /// Writes the maps.
    pub(super) fn write(&self, maps: &[Map]) -> Result<Vec<Written>, Failure> {
        match self {
            Target::Folder(folder) => {
                std::fs::create_dir_all(folder).map_err(|e| {
                    let message = format!("{}: the folder cannot be created: {e}", folder.display());
                    Failure::new(SceneError::new(ErrorCode::Output, message))
                })?;
                maps.iter()
                    .map(|map| write(&folder.join(format!("{}.png", map.name)), std::slice::from_ref(map)))
                    .collect()
            }
            Target::File(path) if !maps.is_empty() => Ok(vec![write(path, maps)?]),
            Target::File(_) => Ok(Vec::new()),
        }
    }
}

/// Pixels between maps, and the height in pixels of the scale below them.
const GAP: usize = 6;
const SCALE: usize = 10;

/// Writes maps side by side, each with its scale below.
fn write(path: &Path, maps: &[Map]) -> Result<Written, Failure> {
    let height = maps.iter().map(|m| m.height as usize).max().unwrap_or(0) + GAP + SCALE;
    let width = maps.iter().map(|m| m.width as usize + GAP).sum::<usize>().saturating_sub(GAP);
    let mut display = vec![[255u8; 4]; width * height];
    let mut left = 0;
    for map in maps {
        let columns = map.width as usize;
        let mut set = |x: usize, y: usize, [r, g, b]: [u8; 3]| {
            if let Some(p) = display.get_mut(y * width + left + x) {
                *p = [r, g, b, 255];
            }
        };
        for (i, color) in map.pixels.iter().enumerate() {
            set(i % columns, i / columns, *color);
        }
        for y in height - SCALE..height {
            for x in 0..columns {
                set(x, y, scale(map, x, columns));
            }
        }
        left += columns + GAP;
    }
    let image = OutputImage {
        width: width as u32,
        height: height as u32,
        alpha: false,
        display: Some(Display::U8(&display)),
        transfer: Transfer::Srgb,
        metadata: &Metadata::new(),
        threads: 1,
        ..OutputImage::default()
    };
    let bytes = encode(&image, ImageFormat::Png)
        .map_err(|e| Failure::new(two_lines(ErrorCode::Output, &e.to_string())))?;
    OutputFile::create(path).and_then(|file| file.commit(&bytes)).map_err(|e| output(&e))?;
    let shows: Vec<String> = maps
        .iter()
        .map(|m| match m.range {
            Some(([low, high], unit)) => format!("{}, {low:.3} to {high:.3} {unit}", m.name),
            None => m.name.to_owned(),
        })
        .collect();
    let ranges = maps.iter().filter_map(|m| {
        m.range.map(|(range, unit)| (m.name.to_owned(), json!({ "range": range, "unit": unit })))
    });
    Ok(Written {
        path: path.display().to_string(),
        shows: shows.join("; "),
        names: maps.iter().map(|m| m.name).collect(),
        ranges: Value::Object(ranges.collect()),
    })
}

/// The colour scale below a map: heat colours from low to high, or the colours of all kinds of path in order.
fn scale(map: &Map, x: usize, columns: usize) -> [u8; 3] {
    if map.range.is_none() {
        let i = x * PathKind::ALL.len() / columns.max(1);
        return PathKind::ALL.get(i).map_or([0; 3], |k| k.color());
    }
    let position = (x as f32 + 0.5) / columns.max(1) as f32;
    heat(position).to_array().map(|v| (f64::from(srgb_encode(v)) * 255.0 + 0.5) as u8)
}
