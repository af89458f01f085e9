//! Parses one chunk of an OBJ file without knowledge of the others: statements become lists; references that need
//! other chunks stay unresolved.

use super::text::{Found, Text};
use crate::assets::printable;
use crate::mesh::bad_index;
use crate::mesh::number::quick_int;

/// Index of a missing (u, v) or normal.
pub(super) const NONE: u32 = u32::MAX;
/// Flag of a corner whose index is relative to the first element of its chunk, offset by [`HALF`].
pub(super) const RELATIVE: u32 = 1 << 31;
/// More elements than a file can contain: eight bytes each in 4 GiB.
pub(super) const HALF: i64 = 1 << 30;
const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// An error and its line.
#[derive(Debug)]
pub(super) struct Fail {
    pub(super) line: u64,
    pub(super) problem: String,
}

/// Totals of the chunks before this one. Only known on the second parse, which produces the error message.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Before {
    pub(super) lines: u64,
    pub(super) faces: u64,
    /// Numbers of positions, (u, v) and normals.
    pub(super) counts: [usize; 3],
    /// An index that is too large: its kind, its value, and how many elements the file has.
    pub(super) too_large: Option<(usize, i64, usize)>,
}

/// A state change for the following polygons.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Change {
    Material,
    Object,
    Group,
    /// A smoothing group; 0 is off.
    Smoothing(u32),
}

/// A state change before a polygon, with the name after its keyword.
#[derive(Clone, Copy, Debug)]
pub(super) struct Event<'a> {
    pub(super) polygon: u32,
    pub(super) change: Change,
    pub(super) name: &'a [u8],
}

/// Counts of statements that are not rendered.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Others {
    pub(super) points: u64,
    pub(super) lines: u64,
    /// Faces with one or two corners.
    pub(super) thin: u64,
    /// Free-form curves and surfaces.
    pub(super) free_form: u64,
    pub(super) unknown: u64,
}

/// The statements of one chunk.
#[derive(Debug, Default)]
pub(super) struct Chunk<'a> {
    pub(super) lines: u64,
    /// `f` statements.
    pub(super) faces: u64,
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) uvs: Vec<[f32; 2]>,
    pub(super) normals: Vec<[f32; 3]>,
    /// Colours of the first positions; the rest are white.
    pub(super) colors: Vec<[f32; 4]>,
    /// Polygon corners: position indices; those of (u, v) and normals are as many, or empty.
    pub(super) corners: [Vec<u32>; 3],
    pub(super) polygons: u32,
    /// Polygons other than triangles, with their number of corners.
    pub(super) sizes: Vec<(u32, u32)>,
    pub(super) events: Vec<Event<'a>>,
    pub(super) libraries: Vec<&'a [u8]>,
    pub(super) others: Others,
    /// By kind, the largest positive index, and the lowest position that a negative index refers to.
    pub(super) reach: [(i64, i64); 3],
    pub(super) fail: Option<Fail>,
}

struct Reader<'a, 'b> {
    text: Text<'a>,
    chunk: Chunk<'a>,
    before: Option<&'b Before>,
}

/// Parses a chunk up to its first error. With `before`, the error message counts lines and faces of the entire file.
pub(super) fn read<'a>(text: &'a [u8], before: Option<&Before>) -> Chunk<'a> {
    let mut reader = Reader { text: Text::new(text), chunk: Chunk::default(), before };
    while reader.text.next_statement() {
        if let Err(problem) = reader.statement() {
            let line = before.map_or(0, |b| b.lines) + reader.text.lines + 1;
            reader.chunk.fail = Some(Fail { line, problem });
            break;
        }
        reader.text.skip_statement();
    }
    reader.chunk.lines = reader.text.lines;
    reader.chunk
}

impl<'a> Reader<'a, '_> {
    #[inline]
    fn statement(&mut self) -> Result<(), String> {
        let blank = |b: u8| b == b' ' || b == b'\t';
        match (self.text.peek(0), self.text.peek(1), self.text.peek(2)) {
            (b'v', b, _) if blank(b) => {
                self.text.advance(2);
                self.vertex()
            }
            (b'f', b, _) if blank(b) => {
                self.text.advance(2);
                self.face()
            }
            (b'v', b't', b) if blank(b) => {
                self.text.advance(3);
                let uv = self.numbers::<2>("vt u v", 1)?;
                self.chunk.uvs.push(uv);
                Ok(())
            }
            (b'v', b'n', b) if blank(b) => {
                self.text.advance(3);
                let n = self.numbers::<3>("vn x y z", 3)?;
                self.chunk.normals.push(n);
                Ok(())
            }
            (b'#', ..) => Ok(()),
            _ => self.other(),
        }
    }

    fn other(&mut self) -> Result<(), String> {
        let keyword = self.text.word();
        match keyword {
            b"v" => return self.vertex(),
            b"f" => return self.face(),
            b"vt" => {
                let uv = self.numbers::<2>("vt u v", 1)?;
                self.chunk.uvs.push(uv);
                return Ok(());
            }
            b"vn" => {
                let n = self.numbers::<3>("vn x y z", 3)?;
                self.chunk.normals.push(n);
                return Ok(());
            }
            _ => {}
        }
        let rest = self.text.skip_statement();
        let others = &mut self.chunk.others;
        match keyword {
            b"usemtl" => self.event(Change::Material, rest),
            b"o" => self.event(Change::Object, rest),
            b"g" => self.event(Change::Group, rest),
            b"s" => {
                let word = super::text::words(rest).next().unwrap_or(b"off");
                let number = std::str::from_utf8(word).ok().and_then(|w| w.parse::<u32>().ok());
                let group = number.unwrap_or(u32::from(!matches!(word, b"off" | b"OFF" | b"null")));
                self.event(Change::Smoothing(group), b"");
            }
            b"mtllib" => self.chunk.libraries.push(rest),
            b"p" => others.points += 1,
            b"l" => others.lines += 1,
            b"curv" | b"curv2" | b"surf" => others.free_form += 1,
            // Parts of curves and surfaces, and statements that do not affect the picture.
            b"vp" | b"cstype" | b"deg" | b"bmat" | b"step" | b"parm" | b"trim" | b"hole" | b"scrv"
            | b"sp" | b"end" | b"con" | b"mg" | b"ctech" | b"stech" | b"bevel" | b"c_interp"
            | b"d_interp" | b"lod" | b"shadow_obj" | b"trace_obj" | b"maplib" | b"usemap" => {}
            _ => others.unknown += 1,
        }
        Ok(())
    }

    /// Records a change. A later change of the same kind replaces it if there is no polygon in between.
    fn event(&mut self, change: Change, name: &'a [u8]) {
        let polygon = self.chunk.polygons;
        let event = Event { polygon, change, name };
        let same = |e: &&mut Event<'_>| std::mem::discriminant(&e.change) == std::mem::discriminant(&change);
        let recent = self.chunk.events.iter_mut().rev().take_while(|e| e.polygon == polygon);
        match { recent }.find(same) {
            Some(e) => *e = event,
            None => self.chunk.events.push(event),
        }
    }

    /// `v x y z`, optionally followed by: a weight; a colour; a weight and a colour; a colour and an opacity.
    #[inline]
    fn vertex(&mut self) -> Result<(), String> {
        let mut p = self.numbers::<3>("v x y z", 3)?;
        self.text.skip_blanks();
        if !self.text.ends_statement() {
            self.more_of_vertex(&mut p)?;
        }
        self.chunk.positions.push(p);
        Ok(())
    }

    fn more_of_vertex(&mut self, p: &mut [f32; 3]) -> Result<(), String> {
        let (mut more, mut count) = ([0.0; 4], 0);
        let mut numbers = true;
        loop {
            match self.text.number() {
                Found::End => break,
                Found::Number(v) if count < 4 => more[count] = v,
                Found::Number(_) => {}
                Found::Word(_) => numbers = false,
            }
            count += 1;
        }
        let [a, b, c, d] = more;
        match count {
            1 if !numbers => return Err("the weight of a vertex is not a number".into()),
            1 => *p = p.map(|v| v / a),
            _ if !numbers => {}
            3 => self.color([a, b, c, 1.0]),
            // Four values are ambiguous. A weight is nearly always 1, and so is an opacity.
            4 if a == 1.0 || d != 1.0 => {
                *p = p.map(|v| v / a);
                self.color([b, c, d, 1.0]);
            }
            4 => self.color([a, b, c, d]),
            _ => {}
        }
        Ok(())
    }

    /// Sets the colour of the next vertex.
    fn color(&mut self, color: [f32; 4]) {
        let chunk = &mut self.chunk;
        chunk.colors.resize(chunk.positions.len(), [1.0; 4]);
        chunk.colors.push(color);
    }

    /// Reads `N` numbers, of which the first `least` are required.
    #[inline]
    fn numbers<const N: usize>(&mut self, expected: &str, least: usize) -> Result<[f32; N], String> {
        let mut out = [0.0; N];
        for (i, slot) in out.iter_mut().enumerate() {
            match self.text.number() {
                Found::Number(v) => *slot = v,
                Found::Word(word) => return Err(format!("expected `{expected}`, found \"{}\"", show(word))),
                Found::End if i >= least => break,
                Found::End => return Err(format!("expected `{expected}`, found {i} numbers")),
            }
        }
        Ok(out)
    }

    #[inline]
    fn face(&mut self) -> Result<(), String> {
        self.chunk.faces += 1;
        let start = self.chunk.corners[0].len();
        loop {
            self.text.skip_blanks();
            if self.text.ends_statement() {
                break;
            }
            let corner = self.corner()?;
            let corners = &mut self.chunk.corners;
            corners[0].push(corner[0]);
            for i in 1..3 {
                let before = corners[0].len() - 1;
                if corner[i] != NONE && corners[i].is_empty() {
                    corners[i].resize(before, NONE);
                    corners[i].push(corner[i]);
                } else if !corners[i].is_empty() {
                    corners[i].push(corner[i]);
                }
            }
        }
        let size = self.chunk.corners[0].len() - start;
        if size == 3 {
            self.chunk.polygons += 1;
        } else if size > 3 {
            self.chunk.sizes.push((self.chunk.polygons, size as u32));
            self.chunk.polygons += 1;
        } else if size == 0 {
            return Err("a face without vertices; expected `f 1 2 3`".into());
        } else {
            self.chunk.corners.iter_mut().for_each(|c| c.truncate(start));
            self.chunk.others.thin += 1;
        }
        Ok(())
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    #[inline]
    fn corner(&mut self) -> Result<[u32; 3], String> {
        let rest = self.text.rest();
        let mut index = [0_i32; 3];
        let (i, mut at) = quick_int(rest);
        index[0] = i;
        let mut quick = at > 0;
        for slot in &mut index[1..] {
            if rest.get(at) != Some(&b'/') || !quick {
                break;
            }
            at += 1;
            if !matches!(rest.get(at), Some(b'0'..=b'9' | b'-')) {
                continue;
            }
            let (i, len) = quick_int(&rest[at..]);
            *slot = i;
            quick &= len > 0 && i != 0;
            at += len;
        }
        self.text.advance(at);
        if quick && index[0] != 0 && self.text.ends_word() {
            let mut corner = [NONE; 3];
            for i in 0..3 {
                if index[i] != 0 {
                    corner[i] = self.place(i, i64::from(index[i]))?;
                }
            }
            return Ok(corner);
        }
        // Reparse the word the slow way.
        self.text.back(at);
        let word = self.text.word();
        self.unusual_corner(word)
    }

    fn unusual_corner(&mut self, word: &[u8]) -> Result<[u32; 3], String> {
        let bad = |face: u64| format!("face {face}: expected a vertex `v/vt/vn`, found \"{}\"", show(word));
        let mut corner = [NONE; 3];
        let mut parts = word.split(|&b| b == b'/');
        for (i, slot) in corner.iter_mut().enumerate() {
            let Some(part) = parts.next() else { break };
            if part.is_empty() && i > 0 {
                continue;
            }
            let index = std::str::from_utf8(part).ok().and_then(|s| s.parse::<i64>().ok());
            let Some(index) = index else { return Err(bad(self.face_number())) };
            *slot = self.place(i, index)?;
        }
        if parts.next().is_some() { Err(bad(self.face_number())) } else { Ok(corner) }
    }

    fn face_number(&self) -> u64 {
        self.before.map_or(0, |b| b.faces) + self.chunk.faces
    }

    /// Converts an index (from 1, or negative from the end) to a position: from the start of the file, or
    /// [`RELATIVE`].
    #[inline]
    fn place(&mut self, kind: usize, index: i64) -> Result<u32, String> {
        let count = match kind {
            0 => self.chunk.positions.len(),
            1 => self.chunk.uvs.len(),
            _ => self.chunk.normals.len(),
        };
        if let Some(before) = self.before {
            let count = before.counts[kind] + count;
            let too_large = before.too_large.filter(|&(k, i, _)| (k, i) == (kind, index));
            if index == 0 || count as i64 + index < 0 || index > HALF || too_large.is_some() {
                let count = too_large.map_or(count, |(.., total)| total);
                return Err(bad_index(KINDS[kind], self.face_number(), index, count, 1));
            }
        } else if index == 0 || index.unsigned_abs() > HALF.unsigned_abs() {
            // The empty message is replaced on the second parse.
            return Err(String::new());
        }
        let reach = &mut self.chunk.reach[kind];
        if index > 0 {
            reach.0 = reach.0.max(index);
            return Ok((index - 1) as u32);
        }
        let place = count as i64 + index;
        reach.1 = reach.1.min(place);
        Ok(RELATIVE | (place + HALF) as u32)
    }
}

fn show(word: &[u8]) -> String {
    printable(&String::from_utf8_lossy(&word[..word.len().min(40)]))
}
