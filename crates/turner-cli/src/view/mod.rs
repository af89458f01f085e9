//! `turner view`: what a picture file contains.
//!
//! ```text
//! file ── contents ──> parts, channels, statistics, metadata ── text or JSON
//!   └──── shown ─────> display values ── crate::preview ──> terminal
//! ```

mod contents;
mod json;
mod shown;
mod text;

use std::io::IsTerminal;
use std::path::PathBuf;

use clap::Args;

use crate::events::Events;
use crate::failure::Failure;
use crate::picture_file::PictureFile;
use crate::preview::{self, Protocol, Terminal};
use crate::report::Reporter;

/// Show the contents of a picture file: size, channels, range of values, metadata, and a preview
#[derive(Debug, Args)]
#[command(
    after_help = "Minimum, maximum and mean are those of the finite values as stored: colours of EXR files are\n\
                  premultiplied by alpha. The preview shows EXR files of Turner as they were rendered, other\n\
                  layers from their smallest to their largest value."
)]
pub(crate) struct ViewArgs {
    /// Picture file: EXR, HDR, PFM, PNG, JPEG, WebP, TGA, BMP or KTX2
    file: PathBuf,
    /// Show only this layer of an EXR file, such as `albedo`
    #[arg(long, value_name = "NAME")]
    layer: Option<String>,
    /// Print the values of all channels in this pixel; row 0 is at the top
    #[arg(long, value_name = "X,Y", value_parser = pixel)]
    pixel: Option<(u32, u32)>,
    /// Show a preview in this way, also if standard output is no terminal [default: what the terminal supports]
    #[arg(long, value_name = "MODE", conflicts_with_all = ["no_preview", "json"])]
    preview: Option<Protocol>,
    /// Show no preview
    #[arg(long)]
    no_preview: bool,
    /// Print JSON: see docs/reference/images.md
    #[arg(long)]
    json: bool,
}

fn pixel(text: &str) -> Result<(u32, u32), String> {
    let parse = |v: &str| v.trim().parse::<u32>().ok();
    text.split_once(',')
        .and_then(|(x, y)| parse(x).zip(parse(y)))
        .ok_or_else(|| "expected column and row; write `--pixel 320,240`".to_owned())
}

/// Runs the command.
pub(crate) fn run(args: &ViewArgs) -> u8 {
    let reporter = Reporter { quiet: false, events: args.json.then_some(Events::Stdout) };
    match view(args) {
        Ok(()) => 0,
        Err(failure) => {
            reporter.failure(&failure);
            failure.exit
        }
    }
}

fn view(args: &ViewArgs) -> Result<(), Failure> {
    let file = PictureFile::read(&args.file)?;
    let contents = contents::read(&file, args.layer.as_deref(), args.pixel)?;
    if args.json {
        crate::text::print(&format!("{}\n", json::of(&contents)));
        return Ok(());
    }
    crate::text::print(&text::of(&contents));
    let wanted = args.preview.is_some() || (!args.no_preview && std::io::stdout().is_terminal());
    if wanted
        && let Some(terminal) = Terminal::detect(args.preview)
        && let Some(shown) = shown::of(&file, args.layer.as_deref(), &contents)
    {
        // A closed pipe is no error.
        let _ = preview::show(&mut std::io::stdout().lock(), &shown.shot(), &terminal);
    }
    Ok(())
}
