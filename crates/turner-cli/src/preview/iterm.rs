//! Inline images of iTerm2: a PNG in base64.

use std::io::{self, Write};

use turner_web::base64;

use super::{Shot, png};

/// Writes the picture.
pub(super) fn write(out: &mut impl Write, shot: &Shot<'_>) -> io::Result<()> {
    let png = png(shot)?;
    let (size, width, height) = (png.len(), shot.width, shot.height);
    write!(out, "\x1b]1337;File=inline=1;size={size};width={width}px;height={height}px:")?;
    out.write_all(base64::encode(&png).as_bytes())?;
    writeln!(out, "\x07")
}
