//! `turner-studio bench`: a scripted session without a window. It drives the document and the engine as the window does
//! and measures what a user would see.
//!
//! ```text
//! run ── scenes     what is shown: files, the gallery, two large scenes
//!     ├─ session    an engine with a clock: from an order to its frame
//!     ├─ motion     camera moves, frames per second, edits, opening a model
//!     ├─ quality    FLIP against the converged picture, moments after a move
//!     ├─ interface  frames of the window's interface while the picture is rendered
//!     └─ table      percentiles beside their targets, as text or JSON
//! ```

mod interface;
mod motion;
mod quality;
mod scenes;
mod session;
mod table;

use std::path::PathBuf;

use table::Table;

/// The text of `turner-studio bench --help`.
pub const HELP: &str = "\
Measure Turner Studio with a scripted session, without a window

Usage: turner-studio bench [OPTIONS] [SCENE…]

Arguments:
  [SCENE…]  Scenes to measure [default: scenes of the gallery and two large ones]

Options:
      --references FOLDER  Keep the converged pictures there, and use those that it has. They are found by the scene's
                           name and the size: remove them after a change of a scene
      --sizes WxH[,WxH]    Sizes of the picture [default: 1280x720,640x360]
      --json               Print one JSON object per line
";

/// What is measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    scenes: Vec<PathBuf>,
    references: Option<PathBuf>,
    sizes: Vec<[u32; 2]>,
    json: bool,
}

impl Options {
    /// From the arguments after `bench`. The error is for the user.
    pub fn parse(args: impl IntoIterator<Item = std::ffi::OsString>) -> Result<Options, String> {
        let sizes = vec![[1280, 720], [640, 360]];
        let mut options = Options { scenes: Vec::new(), references: None, sizes, json: false };
        let mut args = args.into_iter();
        while let Some(arg) = args.next() {
            match arg.to_str() {
                Some("--json") => options.json = true,
                Some("--references") => {
                    let folder = args.next().ok_or("--references needs a folder")?;
                    options.references = Some(folder.into());
                }
                Some("--sizes") => {
                    let text = args.next().ok_or("--sizes needs sizes such as 1280x720")?;
                    let text = text.to_string_lossy();
                    let read = |size: &str| {
                        parse_size(size).ok_or(format!("\"{size}\" is no size such as 1280x720"))
                    };
                    options.sizes = text.split(',').map(read).collect::<Result<_, _>>()?;
                }
                Some(option) if option.starts_with('-') => return Err(format!("unknown option {option}")),
                _ => options.scenes.push(arg.into()),
            }
        }
        Ok(options)
    }
}

fn parse_size(text: &str) -> Option<[u32; 2]> {
    let (width, height) = text.split_once('x')?;
    let side = |text: &str| text.parse().ok().filter(|side| (16..=16384).contains(side));
    Some([side(width)?, side(height)?])
}

/// Runs all measurements and prints them. The error is for the user.
pub fn run(options: &Options) -> Result<(), String> {
    let mut table = Table::new(options.json);
    let list = scenes::list(&options.scenes)?;
    for &size in &options.sizes {
        for scene in &list {
            motion::measure(scene, size, &mut table)?;
        }
    }
    let mut flip = quality::Total::default();
    if let Some(&size) = options.sizes.first() {
        for scene in list.iter().filter(|scene| scene.converges) {
            quality::measure(scene, size, options.references.as_deref(), &mut table, &mut flip)?;
        }
        flip.print(size, &mut table);
    }
    if options.scenes.is_empty() {
        motion::opening(&mut table)?;
    }
    if let Some(scene) = list.first() {
        interface::measure(scene, &mut table)?;
    }
    table.end();
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_read() {
        let of = |text: &str| Options::parse(text.split_whitespace().map(Into::into));
        let options = of("--json a.toml --references kept --sizes 64x36,32x18 b.toml").unwrap();
        assert_eq!(options.scenes, [PathBuf::from("a.toml"), "b.toml".into()]);
        assert_eq!((options.sizes.clone(), options.json), (vec![[64, 36], [32, 18]], true));
        assert_eq!(options.references, Some("kept".into()));
        for wrong in ["--jsn", "--references", "--sizes", "--sizes 64", "--sizes 1x1"] {
            assert!(of(wrong).is_err(), "{wrong}");
        }
    }
}
