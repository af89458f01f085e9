//! Inconsistent images, compressed files, grids and spectra.

use super::run::{Case, Expected};
use turner_io::testing::seeds::{gzip, seeds};

fn shown(name: &str, file: &str, bytes: Vec<u8>) -> Case {
    let text = format!(
        "[integrator]\ntype = \"path\"\n[[object]]\ntype = \"rectangle\"\nmaterial = {{ color = {{ type = \"image\", file = \"{file}\" }} }}\n\
         [[light]]\ntype = \"environment\"\n"
    );
    Case::new(name, "s.toml", vec![("s.toml".to_owned(), text.into_bytes()), (file.to_owned(), bytes)])
}

/// A seed file.
fn seed(name: &str) -> Vec<u8> {
    seeds().into_iter().find(|s| s.name == name).unwrap().bytes
}

/// The bytes with a range replaced.
fn with(name: &str, at: usize, bytes: &[u8]) -> Vec<u8> {
    let mut out = seed(name);
    out[at..at + bytes.len()].copy_from_slice(bytes);
    out
}

fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |sum, b| {
        (0..8).fold(sum ^ u32::from(*b), |s, _| if s & 1 == 1 { s >> 1 ^ 0xedb8_8320 } else { s >> 1 })
    })
}

fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let body = [&kind[..], data].concat();
    [&(data.len() as u32).to_be_bytes()[..], &body, &crc(&body).to_be_bytes()].concat()
}

/// A PNG of black pixels, or with the given `data`.
fn png(width: u32, height: u32, color: u8, more: &[u8], data: &[u8]) -> Vec<u8> {
    let head = [&width.to_be_bytes()[..], &height.to_be_bytes(), &[8, color, 0, 0, 0]].concat();
    let packed = miniz_oxide::deflate::compress_to_vec_zlib(data, 1);
    [&b"\x89PNG\r\n\x1a\n"[..], &chunk(b"IHDR", &head), more, &chunk(b"IDAT", &packed), &chunk(b"IEND", &[])]
        .concat()
}

pub(super) fn cases() -> Vec<Case> {
    use Expected::{Error, Picture};
    let bomb_text =
        [b"k\0\0", &miniz_oxide::deflate::compress_to_vec_zlib(&vec![b'x'; 30_000_000], 1)[..]].concat();
    let profile =
        [b"p\0\0", &miniz_oxide::deflate::compress_to_vec_zlib(&vec![0; 30_000_000], 1)[..]].concat();
    let row = |w: usize| vec![0; w + 1];
    let mut all = vec![
        shown("PNG: what it says is there", "a.png", png(2, 1, 0, &[], &row(2))).must(Picture),
        shown("PNG: a size of nothing", "a.png", png(0, 7, 0, &[], &row(7))).must(Error),
        shown("PNG: 2^31 squared", "a.png", png(0x7fff_ffff, 0x7fff_ffff, 2, &[], &row(9))).must(Error),
        shown("PNG: 60000 squared", "a.png", png(60_000, 60_000, 6, &[], &row(9))).must(Error),
        shown("PNG: fewer rows than it says", "a.png", png(64, 64, 0, &[], &row(64).repeat(10))),
        // 225 MB of zeros compressed to 220 kB, and 900 MB.
        shown("PNG: a bomb", "a.png", png(15_000, 15_000, 0, &[], &row(15_000).repeat(15_000))),
        shown("PNG: a bomb of colours", "a.png", png(16_000, 16_000, 6, &[], &row(64_000).repeat(16_000)))
            .must(Error),
        shown("PNG: a bomb of text", "a.png", png(2, 1, 0, &chunk(b"zTXt", &bomb_text).repeat(40), &row(2))),
        shown("PNG: a bomb of a profile", "a.png", png(2, 1, 0, &chunk(b"iCCP", &profile), &row(2))),
        shown(
            "HDR: 10^9 squared",
            "a.hdr",
            b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1000000000 +X 1000000000\n".to_vec(),
        )
        .must(Error),
        shown(
            "HDR: rows of nothing",
            "a.hdr",
            b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 30000 +X 30000\n\x02\x02\x75\x30".to_vec(),
        )
        .must(Error),
        shown("BMP: 2^31 wide", "a.bmp", with("picture.bmp", 18, &[0xff, 0xff, 0xff, 0x7f])).must(Error),
        shown("BMP: negative", "a.bmp", with("picture.bmp", 22, &[0, 0, 0, 0x80])).must(Error),
        shown("TGA: 65535 squared", "a.tga", with("picture.tga", 12, &[0xff; 4])).must(Error),
        shown("an empty picture", "a.png", Vec::new()).must(Error),
        shown("a text for a picture", "a.png", b"<html>not found</html>".to_vec()).must(Error),
        Case::one("gzip: a bomb", "s.pbrt", gzip(&vec![b' '; 100_000_000]).repeat(60)),
        Case::one("gzip: in gzip", "s.pbrt", gzip(&gzip(&gzip(b"WorldBegin\n")))),
        Case::one("gzip: cut", "s.pbrt", gzip(b"WorldBegin\n")[..14].to_vec()).must(Error),
    ];
    let exr = seed("picture.exr");
    let window = exr.windows(10).position(|w| w == b"dataWindow").unwrap() + 10 + 1 + 6 + 4;
    for (name, numbers) in [
        ("EXR: a window of 2^31", [0, 0, i32::MAX, i32::MAX]),
        ("EXR: a negative window", [10, 10, -10, -10]),
        ("EXR: a window far away", [i32::MIN, i32::MIN, i32::MIN + 7, i32::MIN + 7]),
        ("EXR: 30000 squared", [0, 0, 29_999, 29_999]),
    ] {
        let bytes: Vec<u8> = numbers.iter().flat_map(|n: &i32| n.to_le_bytes()).collect();
        all.push(shown(name, "a.exr", with("picture.exr", window, &bytes)));
    }
    for (name, heading) in [
        (
            "a grid of 2^96 cells",
            "turner-grid 1\nsize 4294967295 4294967295 4294967295\nchannels density\ndata\n",
        ),
        ("a grid of no cells", "turner-grid 1\nsize 0 1 1\nchannels density\ndata\n"),
        ("a grid without an end", "turner-grid 1\nsize 2 2 2"),
        ("a grid in no box", "turner-grid 1\nsize 1 1 1\nchannels density\nbounds 0 0 0 0 NaN 1\ndata\n0000"),
        ("an OpenVDB file without an end", " BDV\0\0\0\0"),
    ] {
        let scene = seeds().into_iter().find(|s| s.name == "cloud.grid").unwrap().scene.unwrap().1;
        let files =
            vec![("s.toml".to_owned(), scene.into_bytes()), ("cloud.grid".to_owned(), heading.into())];
        all.push(Case::new(name, "s.toml", files).must(Error));
    }
    for (name, numbers) in [
        ("IES: 10^9 angles", "1 1000 1 1000000000 1000000000 1 2 0 0 0\n1 1 50\n0 45 90\n"),
        ("IES: negative", "1 1000 1 -3 -2 1 2 0 0 0\n1 1 50\n0 45 90\n"),
        ("IES: NaN and infinity", "1 1000 1 3 1 1 2 0 0 0\n1 1 50\n0 45 90\n0\nnan inf -1\n"),
        ("IES: angles in no order", "1 1000 1 3 1 1 2 0 0 0\n1 1 50\n90 45 0\n0\n1 1 1\n"),
    ] {
        let scene = seeds().into_iter().find(|s| s.name == "lamp.ies").unwrap().scene.unwrap().1;
        let text = format!("IESNA:LM-63-2002\nTILT=NONE\n{numbers}");
        let files =
            vec![("s.toml".to_owned(), scene.into_bytes()), ("lamp.ies".to_owned(), text.into_bytes())];
        all.push(Case::new(name, "s.toml", files).must(Error));
    }
    all
}
