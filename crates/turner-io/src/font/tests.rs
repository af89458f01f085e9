use turner::description::ObjectContent;
use turner::math::DVec3;
use turner::schema::{MeshData, PrepareOptions};
use turner::shape::MeshCache;
use turner::shape::{Shape, ShapeDesc, TextDesc};

use super::*;
use crate::assets::MemoryAssets;
use crate::scene::{LoadOptions, Loaded, load_text};

const TRUE_TYPE: &[u8] = include_bytes!("../testing/font.ttf");
const OPEN_TYPE: &[u8] = include_bytes!("../testing/font.otf");
const DEJAVU: &[u8] = include_bytes!("../../../../scenes/guides/DejaVuSans-Bold-subset.ttf");

fn glyphs(bytes: &[u8], line: &str) -> Vec<Glyph> {
    decode(bytes.to_vec(), "f.ttf").unwrap().set_line(0, line).unwrap()
}

fn advances(bytes: &[u8], line: &str) -> Vec<i64> {
    glyphs(bytes, line).iter().map(|g| (g.advance * 2048.0).round() as i64).collect()
}

/// A text in a font, prepared.
fn mesh(bytes: &[u8], text: &str) -> Arc<turner::shape::TriangleMesh> {
    let font = turner::schema::FontFile { uri: "f".into(), font: decode(bytes.to_vec(), "f").unwrap() };
    let desc = TextDesc { text: text.into(), font, depth: 1.0, tolerance: 1e-5, ..TextDesc::default() };
    let Shape::Mesh(mesh) = ShapeDesc::Text(desc).prepare(&mut MeshCache::new(&[])).unwrap() else {
        panic!()
    };
    mesh
}

fn volume(mesh: &MeshData) -> f64 {
    let corner = |i: u32| DVec3::from(mesh.positions[i as usize].map(f64::from));
    let of = |t: &[u32; 3]| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0;
    mesh.triangles.iter().map(of).sum()
}

/// Edges with a triangle on one side only, by position.
fn open_edges(mesh: &MeshData) -> usize {
    let key = |i: u32| mesh.positions[i as usize].map(|v| (v + 0.0).to_bits());
    let mut net: HashMap<_, i32> = HashMap::new();
    for [a, b, c] in &mesh.triangles {
        for (a, b) in [(a, b), (b, c), (c, a)] {
            let (a, b) = (key(*a), key(*b));
            *net.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
        }
    }
    net.values().filter(|n| **n != 0).count()
}

#[test]
fn widths_and_kerning_are_those_of_the_font() {
    // Widths by fontTools: T 1397, e 1389, A and V 1585, r 1010; GPOS kerns Te, AV and Va by classes.
    assert_eq!(advances(DEJAVU, "TeT"), [1397 - 272, 1389, 1397]);
    assert_eq!(advances(DEJAVU, "AVa"), [1585 - 139, 1585 - 112, 1382]);
    // I is .3 em wide and o .6; the table `kern` of one font and GPOS of the other move the pair by -.05.
    for font in [TRUE_TYPE, OPEN_TYPE] {
        let found: Vec<f64> = glyphs(font, "IoI ").iter().map(|g| (1000.0 * g.advance).round()).collect();
        assert_eq!(found, [250.0, 600.0, 300.0, 250.0]);
    }
    // GPOS kerns by classes: I before + as well.
    assert_eq!(glyphs(OPEN_TYPE, "I+")[0].advance, 0.25);
    assert_eq!(glyphs(TRUE_TYPE, "I+")[0].advance, 0.3);
}

#[test]
fn volumes_are_those_of_the_curves() {
    // Of a circle of four quadratic curves whose control points are the corners of its square: 10/3 r².
    let quadratic = 10.0 / 3.0 * (0.0625 - 0.0225);
    // Of four cubic curves whose control points are at f of the way to the corners: (10 + 12 f - 3 f²) r² / 5.
    let cubic = |r: f64, f: f64| (10.0 + 12.0 * f - 3.0 * f * f) * r * r / 5.0;
    let cubic = cubic(0.25, 138.0 / 250.0) - cubic(0.15, 83.0 / 150.0);
    for (font, ring) in [(TRUE_TYPE, quadratic), (OPEN_TYPE, cubic)] {
        // A rectangle, a ring, two rectangles that overlap, and two side by side, in one font of two components.
        for (text, exact) in [("I", 0.14), ("o", ring), ("+", 0.07), ("=", 0.08), ("Io+=", 0.29 + ring)] {
            let mesh = mesh(font, text);
            assert!((volume(mesh.data()) - exact).abs() < 2e-5, "{text} {} {exact}", volume(mesh.data()));
            assert_eq!(open_edges(mesh.data()), 0, "{text}");
        }
    }
}

#[test]
fn letters_of_a_real_font_are_closed_and_have_their_holes() {
    let mesh = mesh(DEJAVU, "TurnerABCDEIOVaeghilostx 0128&.,!");
    assert_eq!(open_edges(mesh.data()), 0);
    // Euler: V - E + F is twice the number of bodies less that of holes. The 32 letters have 34 bodies (i and ! have two)
    // and, as their contours that run the other way, 14 holes.
    let mut corners: Vec<_> = mesh.data().positions.iter().map(|p| p.map(|v| (v + 0.0).to_bits())).collect();
    corners.sort_unstable();
    corners.dedup();
    assert_eq!(corners.len() as i64 - mesh.data().triangles.len() as i64 / 2, 2 * (34 - 14));
}

#[test]
fn characters_without_a_glyph_and_fonts_without_a_face() {
    let found = glyphs(TRUE_TYPE, "Iß\u{1f600}");
    assert!(found[0].contours.is_some() && found[1].contours.is_none() && found[2].contours.is_none());
    let font = decode(TRUE_TYPE.to_vec(), "f.ttf").unwrap();
    let error = font.set_line(1, "I").unwrap_err();
    assert_eq!(error.message, "f.ttf: `face` is 1, but the file has 1 font");
    assert_eq!(error.help.as_deref(), Some("write `face = 0`"));
}

#[test]
fn a_collection_has_several_fonts() {
    // Two fonts after a header: their tables are found from the start of the file.
    let mut bytes = b"ttcf\0\x01\0\0\0\0\0\x02".to_vec();
    let starts = [20, 20 + TRUE_TYPE.len()];
    starts.iter().for_each(|s| bytes.extend((*s as u32).to_be_bytes()));
    for (font, start) in [TRUE_TYPE, OPEN_TYPE].into_iter().zip(starts) {
        let mut font = font.to_vec();
        for i in 0..usize::from(font[5]) {
            let at = 12 + 16 * i + 8;
            let offset = u32::from_be_bytes(font[at..at + 4].try_into().unwrap()) + start as u32;
            font[at..at + 4].copy_from_slice(&offset.to_be_bytes());
        }
        bytes.extend(font);
    }
    let font = decode(bytes, "f.ttc").unwrap();
    let pieces = |face: u32| font.set_line(face, "o").unwrap()[0].contours.clone().unwrap()[0].pieces[0];
    assert!(matches!(pieces(0), OutlinePiece::Quadratic(..)) && matches!(pieces(1), OutlinePiece::Cubic(..)));
    assert!(font.set_line(2, "o").unwrap_err().message.contains("the file has 2 fonts"));
}

#[test]
fn other_files_are_refused_with_a_remedy() {
    for (bytes, says) in [
        (&b"wOF2 and so on"[..], "WOFF"),
        (b"%!PS-AdobeFont-1.0", "Type 1"),
        (b"PK\x03\x04", "no font file"),
        (b"", "no font file"),
        (b"OTTO", "damaged font"),
        (b"ttcf\0\x01\0\0\xff\xff\xff\xff", "damaged font"),
    ] {
        let error = decode(bytes.to_vec(), "f.ttf").unwrap_err().to_string();
        assert!(error.contains(says) && error.contains("f.ttf: ") && error.contains('\n'), "{error}");
    }
}

/// Composite glyphs of four components each, nested on 14 levels, and subroutines that call others 40 times on nine.
#[test]
fn what_multiplies_is_bounded() {
    let begun = turner_host::time::Instant::now();
    for (bytes, says) in [
        (&include_bytes!("../../tests/data/components.ttf")[..], "components"),
        (include_bytes!("../../tests/data/subroutines.otf"), "subroutine"),
    ] {
        let error = decode(bytes.to_vec(), "f.ttf").unwrap().set_line(0, "A").unwrap_err();
        assert!(
            error.message.starts_with("f.ttf: the outlines of U+0041 cannot be read: "),
            "{}",
            error.message
        );
        assert!(error.message.contains(says), "{}", error.message);
    }
    assert!(begun.elapsed().as_secs() < 10);
    // A component that is its own: glyph 5 of two in `=` becomes 6.
    let mut font = TRUE_TYPE.to_vec();
    let at = (0..font.len() - 4)
        .find(|i| font[*i] == 0 && font[i + 2..i + 4] == [0, 5] && font[i + 1] & 0x22 == 0x22);
    font[at.unwrap() + 3] = 6;
    let error = decode(font, "f.ttf").unwrap().set_line(0, "=").unwrap_err();
    assert!(error.message.contains("nested deeper"), "{}", error.message);
}

/// Reads a damaged font as far as it goes.
fn survives(bytes: Vec<u8>) {
    let Ok(font) = decode(bytes, "f.ttf") else { return };
    let mut desc = TextDesc { text: "Te+o=A8".into(), tolerance: 1e-2, ..TextDesc::default() };
    desc.font.font = font;
    let options = PrepareOptions::default();
    let mut cache = MeshCache::with_options(&[], &options);
    if let Ok(Shape::Mesh(mesh)) = ShapeDesc::Text(desc).prepare(&mut cache) {
        mesh.data().check().unwrap();
        assert_eq!(open_edges(mesh.data()), 0);
    }
}

#[test]
fn damaged_fonts_are_errors() {
    for font in [TRUE_TYPE, OPEN_TYPE] {
        (0..font.len()).for_each(|n| survives(font[..n].to_vec()));
        for i in 0..font.len() {
            for flip in [0xff, 0x80, 0x01] {
                let mut bytes = font.to_vec();
                bytes[i] ^= flip;
                survives(bytes);
            }
        }
    }
    (0..DEJAVU.len()).step_by(97).for_each(|n| survives(DEJAVU[..n].to_vec()));
    for i in (0..DEJAVU.len()).step_by(97) {
        let mut bytes = DEJAVU.to_vec();
        bytes[i] ^= 0xff;
        survives(bytes);
    }
}

const SCENE: &str = "[[object]]\ntype = \"text\"\ntext = \"Ioß\"\nfont = \"f.ttf\"\n";

fn load(font: Option<&[u8]>) -> Result<Loaded, crate::scene::LoadError> {
    let mut assets = MemoryAssets::default();
    if let Some(font) = font {
        assets.files.insert("f.ttf".into(), font.to_vec());
    }
    load_text(SCENE.to_owned(), "s.toml", &assets, &LoadOptions::default())
}

#[test]
fn scenes_name_fonts() {
    let desc = load(Some(TRUE_TYPE)).unwrap().desc;
    let ObjectContent::Shape(ShapeDesc::Text(text)) = &desc.objects[0].content else { panic!() };
    assert_eq!((text.text.as_str(), text.font.uri.as_str()), ("Ioß", "f.ttf"));
    let prepared = desc.prepare(&PrepareOptions::default()).unwrap();
    assert!(prepared.warnings.iter().any(|w| w.message.contains("lacks a character, left out: ß (U+00DF)")));
    let error = load(None).unwrap_err();
    assert_eq!((error.code(), error.line()), ("E0201", Some(4)));
    let error = load(Some(&TRUE_TYPE[..100])).unwrap_err();
    assert_eq!((error.code(), error.line()), ("E0208", Some(4)));
}
