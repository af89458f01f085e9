//! Pictures in a terminal.
//!
//! ```text
//! Terminal::detect ──> protocol and size ──┐
//! 8-bit display values ── Shot ────────────┴─ show ──> escape sequences
//! ```
//!
//! | protocol | terminals | how it is recognised |
//! |---|---|---|
//! | kitty | kitty, Ghostty | `KITTY_WINDOW_ID`, `TERM`, `TERM_PROGRAM` |
//! | iTerm2 | iTerm2, WezTerm | `TERM_PROGRAM`, `LC_TERMINAL` |
//! | sixel | foot, xterm, Konsole, Windows Terminal | the answer to a question about its attributes (`ask`) |
//! | blocks | every terminal with 24-bit colour | otherwise; two pixels per character |
//!
//! A command that has a picture shows it with
//!
//! ```ignore
//! if let Some(terminal) = Terminal::detect(None) {
//!     let shot = Shot { width: picture.width, height: picture.height, pixels: &picture.display };
//!     preview::show(&mut std::io::stdout().lock(), &shot, &terminal)?;
//! }
//! ```
//!
//! Inside tmux and screen, which do not pass pictures through, it is always blocks. A terminal that calls itself `dumb`
//! shows nothing.

mod ask;
mod blocks;
mod iterm;
mod kitty;
mod scale;
mod sixel;

use std::io::{self, Write};

use clap::ValueEnum;

/// How a terminal shows pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Protocol {
    /// Half blocks in 24-bit colour, two pixels per character
    Blocks,
    /// The graphics protocol of kitty
    Kitty,
    /// Inline images of iTerm2
    Iterm,
    /// Sixel graphics of the VT340
    Sixel,
}

/// A terminal: how it shows pictures, and its size in characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Terminal {
    pub(crate) protocol: Protocol,
    pub(crate) columns: u32,
    pub(crate) rows: u32,
}

/// A picture: 8-bit display values with straight alpha, row 0 at the top. `pixels` has `width` · `height` entries.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shot<'a> {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) pixels: &'a [[u8; 4]],
}

impl Terminal {
    /// Whether it shows pictures, or says that it has 24-bit colour.
    pub(crate) fn has_colors(&self) -> bool {
        let said = std::env::var("COLORTERM").is_ok_and(|v| v == "truecolor" || v == "24bit");
        self.protocol != Protocol::Blocks || said
    }

    /// The terminal that standard output is connected to, with `protocol` or the best that it has. `None`: it shows no
    /// pictures. May take a fifth of a second, if the terminal does not answer a question.
    pub(crate) fn detect(protocol: Option<Protocol>) -> Option<Terminal> {
        let variable = |name: &str| std::env::var(name).ok().filter(|v| !v.is_empty());
        let protocol = match protocol {
            Some(protocol) => protocol,
            None => match by_environment(&variable) {
                Guess::Nothing => return None,
                Guess::Is(protocol) => protocol,
                Guess::Ask if ask::speaks_sixel() => Protocol::Sixel,
                Guess::Ask => Protocol::Blocks,
            },
        };
        let (columns, rows) = ask::size().unwrap_or((80, 24));
        Some(Terminal { protocol, columns, rows })
    }
}

/// What the environment says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Guess {
    Nothing,
    Is(Protocol),
    Ask,
}

fn by_environment(variable: &dyn Fn(&str) -> Option<String>) -> Guess {
    let term = variable("TERM").unwrap_or_default();
    let program = variable("TERM_PROGRAM").unwrap_or_default();
    if term == "dumb" {
        return Guess::Nothing;
    }
    if variable("TMUX").is_some() || term.starts_with("screen") || term.starts_with("tmux") {
        return Guess::Is(Protocol::Blocks);
    }
    if variable("KITTY_WINDOW_ID").is_some()
        || term.contains("kitty")
        || term.contains("ghostty")
        || program == "ghostty"
    {
        return Guess::Is(Protocol::Kitty);
    }
    let is_iterm = variable("LC_TERMINAL").is_some_and(|v| v == "iTerm2");
    if is_iterm || program == "iTerm.app" || program == "WezTerm" {
        return Guess::Is(Protocol::Iterm);
    }
    Guess::Ask
}

/// Rows of text that stay visible above the picture and below it.
const MARGIN: u32 = 4;

/// Pixels of a character cell, where a terminal does not say: pictures are never larger than the terminal.
const CELL: (u32, u32) = (8, 16);

/// Shows a picture, scaled down to the terminal. The cursor is left at the beginning of the next line.
pub(crate) fn show(out: &mut impl Write, shot: &Shot<'_>, terminal: &Terminal) -> io::Result<()> {
    let (columns, rows) = (terminal.columns.max(1), terminal.rows.saturating_sub(MARGIN).max(4));
    let cell = if terminal.protocol == Protocol::Blocks { (1, 2) } else { CELL };
    let small = scale::to_fit(shot, columns.saturating_mul(cell.0), rows.saturating_mul(cell.1));
    let shot = Shot { width: small.width, height: small.height, pixels: &small.pixels };
    match terminal.protocol {
        Protocol::Blocks => blocks::write(out, &shot)?,
        Protocol::Kitty => kitty::write(out, &shot)?,
        Protocol::Iterm => iterm::write(out, &shot)?,
        Protocol::Sixel => sixel::write(out, &shot)?,
    }
    out.flush()
}

/// A pixel over black, which most terminals show around it.
fn over_black([r, g, b, a]: [u8; 4]) -> [u8; 3] {
    [r, g, b].map(|v| ((u32::from(v) * u32::from(a) + 127) / 255) as u8)
}

/// The picture as PNG, for protocols that carry files.
fn png(shot: &Shot<'_>) -> io::Result<Vec<u8>> {
    use turner_io::image::{Display, ImageFormat, OutputImage, Transfer, encode};
    let image = OutputImage {
        width: shot.width,
        height: shot.height,
        alpha: true,
        display: Some(Display::U8(shot.pixels)),
        transfer: Transfer::Srgb,
        threads: 1,
        ..OutputImage::default()
    };
    encode(&image, ImageFormat::Png).map_err(io::Error::other)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terminals_are_recognised() {
        let guess = |entries: &[(&str, &str)]| {
            by_environment(&|name| entries.iter().find(|(n, _)| *n == name).map(|(_, v)| (*v).to_owned()))
        };
        for (environment, expected) in [
            (&[("TERM", "xterm-256color")][..], Guess::Ask),
            (&[("TERM", "dumb")], Guess::Nothing),
            (&[("TERM", "xterm-kitty")], Guess::Is(Protocol::Kitty)),
            (&[("TERM", "xterm-256color"), ("KITTY_WINDOW_ID", "1")], Guess::Is(Protocol::Kitty)),
            (&[("TERM", "xterm-ghostty")], Guess::Is(Protocol::Kitty)),
            (&[("TERM_PROGRAM", "iTerm.app"), ("TERM", "xterm")], Guess::Is(Protocol::Iterm)),
            (&[("TERM_PROGRAM", "WezTerm")], Guess::Is(Protocol::Iterm)),
            (&[("TERM", "tmux-256color"), ("KITTY_WINDOW_ID", "1")], Guess::Is(Protocol::Blocks)),
            (&[("TMUX", "/tmp/x"), ("TERM_PROGRAM", "iTerm.app")], Guess::Is(Protocol::Blocks)),
        ] {
            assert_eq!(guess(environment), expected, "{environment:?}");
        }
    }

    #[test]
    fn every_protocol_writes_one_picture_that_fits() {
        let pixels = vec![[200, 100, 50, 255]; 300 * 200];
        let shot = Shot { width: 300, height: 200, pixels: &pixels };
        for protocol in Protocol::value_variants() {
            let mut out = Vec::new();
            let terminal = Terminal { protocol: *protocol, columns: 20, rows: 12 };
            show(&mut out, &shot, &terminal).unwrap();
            assert_eq!(out.last(), Some(&b'\n'), "{protocol:?}");
            if *protocol == Protocol::Blocks {
                // 300 x 200 fits 12 x 8 character cells of two pixels.
                let text = String::from_utf8(out).unwrap();
                assert_eq!(text.lines().count(), 7);
                assert!(text.lines().all(|line| line.matches('▀').count() == 20), "{text:?}");
            }
        }
    }
}
