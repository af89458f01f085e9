//! The graphics protocol of kitty: a PNG in base64, in pieces of at most 4096 characters.

use std::io::{self, Write};

use turner_web::base64;

use super::{Shot, png};

const PIECE: usize = 4096;

/// Writes the picture. `q=2`: the terminal answers nothing.
pub(super) fn write(out: &mut impl Write, shot: &Shot<'_>) -> io::Result<()> {
    let text = base64::encode(&png(shot)?);
    let pieces: Vec<&[u8]> = text.as_bytes().chunks(PIECE).collect();
    for (i, piece) in pieces.iter().enumerate() {
        let more = u8::from(i + 1 < pieces.len());
        let first = if i == 0 { "a=T,f=100,q=2," } else { "" };
        write!(out, "\x1b_G{first}m={more};")?;
        out.write_all(piece)?;
        write!(out, "\x1b\\")?;
    }
    writeln!(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_pictures_come_in_pieces() {
        let pixels: Vec<[u8; 4]> =
            (0..64 * 64u32).map(|i| i.wrapping_mul(2_654_435_769).to_be_bytes()).collect();
        let mut out = Vec::new();
        write(&mut out, &Shot { width: 64, height: 64, pixels: &pixels }).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert!(text.starts_with("\x1b_Ga=T,f=100,q=2,m=1;iVBORw0KGgo"), "{}", &text[..40]);
        let pieces: Vec<&str> = text.trim_end().split("\x1b\\").filter(|p| !p.is_empty()).collect();
        assert!(pieces.len() > 2);
        for (i, piece) in pieces.iter().enumerate() {
            let (control, data) = piece.split_once(';').unwrap();
            assert!(data.len() <= PIECE);
            assert!(control.ends_with(if i + 1 == pieces.len() { "m=0" } else { "m=1" }), "{control}");
        }
    }
}
