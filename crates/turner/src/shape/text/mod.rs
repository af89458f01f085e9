//! Text in three dimensions: the outlines of a font's characters, filled and given depth.
//!
//! ```text
//! font ── outlines ──► edges on a grid ── cut where they cross ──► triangles ── walls ──► mesh
//!        (`outline`)                        (`planar`)            (`fill`, `delaunay`)
//! ```
//!
//! All characters of a text are filled together, so letters that overlap, as in joined scripts, are one closed body.

mod delaunay;
mod fill;
mod outline;
mod planar;
#[cfg(test)]
pub(crate) mod testing;
#[cfg(test)]
mod tests;

use std::collections::HashMap;

use fill::{Filled, Wall};
use outline::{Edge, flatten};
use planar::{REACH, Segment};

use crate::math::{DVec2, DVec3};
use crate::schema::error::escape;
use crate::schema::{ErrorCode, FontFile, Limits, MeshData, Range, SceneError, choice, params};

choice! {
    /// Where the lines of a text are along x.
    pub enum TextAlign {
        /// They begin at x = 0.
        Left = "left",
        /// Their middle is at x = 0.
        Center = "center",
        /// They end at x = 0.
        Right = "right",
    }
}

params! {
    /// Text from a font file, with depth. It runs along +x, its first line stands on the x axis, and its front faces +z;
    /// the back is at z = 0. It is closed: it may be glass, bound a medium, or be a part of `union` or `difference`. u and
    /// v are 0..1 over the rectangle around the text, u along +x and v along +y; sides have the (u, v) of their edge.
    pub struct TextDesc as "text" {
        /// The text; `\n` begins a new line. Each character is shown alone, from left to right: there are no ligatures,
        /// and no scripts that join or reorder letters.
        text: String, required, default "Text".to_owned();
        /// The font file (TrueType or OpenType: .ttf, .otf, .ttc).
        font: FontFile, required, default FontFile::default();
        /// The font of a collection (.ttc), from 0.
        face: u32 = 0;
        /// The size: the length of one em in scene units. Capitals are about 0.7 em high.
        size: f64 = 1.0, in Range::POSITIVE;
        /// The distance between front and back.
        depth: f64 = 0.2, in Range::POSITIVE;
        /// Where lines are along x.
        align: TextAlign = TextAlign::Left;
        /// The distance between lines, in units of `size`.
        line_spacing: f64 = 1.2, in Range::closed(0.0, 100.0);
        /// Additional distance between characters, in units of `size`.
        letter_spacing: f64 = 0.0, in Range::closed(-10.0, 100.0);
        /// The largest distance between a curve of an outline and its straight pieces, in units of `size`. Normals are
        /// those of the curve.
        tolerance: f64 = 2e-4, in Range::closed(1e-6, 0.1);
    }
    example r#"[[object]]
type = "text"
text = "Turner"
font = "DejaVuSans-Bold.ttf"
align = "center"
material = { type = "metal", color = "gold", roughness = 0.2 }
"#
}

/// Most characters of a text.
const MOST_CHARACTERS: usize = 1 << 16;
/// Largest coordinate of an outline, em.
const MOST_EM: f64 = 4096.0;
/// Grid points per em, if the text is not too large for the grid.
const FINEST: f64 = 1_048_576.0;
/// Bytes per edge of an outline while the mesh is made: the edge, its parts, points, triangles and their tables.
const EDGE_BYTES: u64 = 600;
/// Curves whose directions differ by less are joined smoothly: the cosine of 5°.
const SMOOTH: f64 = 0.996;

/// Most characters that a warning names.
const MOST_NAMED: usize = 20;

/// A mesh, and what is missing in it.
pub(super) struct SetText {
    pub(super) mesh: MeshData,
    /// Characters that the font lacks, each once.
    pub(super) missing: Vec<char>,
}

/// The warning for characters that a font lacks.
pub(super) fn missing_characters(missing: &[char]) -> String {
    // Control characters and those that change the direction of text must not reach a terminal.
    let shown = |c: &char| match c.is_control() || escape(&c.to_string()) != c.to_string() {
        true => format!("U+{:04X}", u32::from(*c)),
        false => format!("{c} (U+{:04X})", u32::from(*c)),
    };
    let list: Vec<String> = missing.iter().take(MOST_NAMED).map(shown).collect();
    let more = missing.len().saturating_sub(MOST_NAMED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    let noun = if missing.len() == 1 { "a character" } else { "characters" };
    format!("the font of a text lacks {noun}, left out: {}{more}", list.join(", "))
}

fn too_large(message: String) -> SceneError {
    SceneError::new(ErrorCode::TooLarge, message).help("divide the text among several objects")
}

impl TextDesc {
    /// The triangles.
    ///
    /// Errors: no font, or one that cannot be read; a text that is too long; more triangles than the limits allow.
    pub(super) fn mesh(&self, limits: &Limits) -> Result<SetText, SceneError> {
        let what = || "a text".to_owned();
        let (edges, missing) = self.edges(limits)?;
        limits.memory.need((edges.len() as u64).saturating_mul(EDGE_BYTES), what)?;
        let grid = Grid::around(&edges)?;
        let segment = |(i, e): (usize, &Edge)| Segment {
            from: grid.point(e.from),
            to: grid.point(e.to),
            weight: 1,
            source: i as u32,
        };
        let filled = fill::fill(edges.iter().enumerate().map(segment).collect()).map_err(|_| {
            let message = "the outlines of a text cross each other too often to be filled";
            SceneError::new(ErrorCode::Font, message).help("choose another font, or a shorter text")
        })?;
        limits.check_triangles(2 * (filled.triangles.len() + filled.walls.len()) as u64, what)?;
        let mesh = self.extruded(&filled, &edges, &grid);
        Ok(SetText { mesh, missing })
    }

    /// The edges of all outlines, em, and the characters that the font lacks.
    fn edges(&self, limits: &Limits) -> Result<(Vec<Edge>, Vec<char>), SceneError> {
        let count = self.text.chars().count();
        if count > MOST_CHARACTERS {
            return Err(too_large(format!("a text has {count} characters; {MOST_CHARACTERS} are the most")));
        }
        let (mut edges, mut missing) = (Vec::new(), Vec::new());
        for (number, line) in self.text.lines().enumerate() {
            let glyphs = self.font.font.set_line(self.face, line)?;
            let width: f64 = glyphs.iter().map(|g| g.advance + self.letter_spacing).sum();
            // The space after the last character belongs to none.
            let width = if glyphs.is_empty() { 0.0 } else { width - self.letter_spacing };
            let start = match self.align {
                TextAlign::Left => 0.0,
                TextAlign::Center => -0.5 * width,
                TextAlign::Right => -width,
            };
            let mut at = DVec2::new(start, -(number as f64) * self.line_spacing);
            for glyph in &glyphs {
                match &glyph.contours {
                    Some(contours) => {
                        for contour in contours.iter() {
                            flatten(contour, at, self.tolerance, &mut edges);
                        }
                    }
                    None if !missing.contains(&glyph.character) => missing.push(glyph.character),
                    None => {}
                }
                // Each edge becomes a wall of two triangles, and one triangle of the front and of the back.
                limits.check_triangles(4 * edges.len() as u64, || "a text".to_owned())?;
                at.x += glyph.advance + self.letter_spacing;
            }
        }
        Ok((edges, missing))
    }

    /// Front, back and walls.
    fn extruded(&self, filled: &Filled, edges: &[Edge], grid: &Grid) -> MeshData {
        let mut mesh = MeshData::default();
        let flat: Vec<DVec2> = filled.points.iter().map(|p| grid.place(*p)).collect();
        let used = || filled.triangles.iter().flatten().map(|i| flat[*i as usize]);
        let min = used().fold(DVec2::INFINITY, DVec2::min);
        let size = used().fold(DVec2::NEG_INFINITY, DVec2::max) - min;
        let mut add = |i: u32, z: f64, normal: DVec3| {
            let p = flat[i as usize];
            mesh.positions.push((self.size * p).extend(z).as_vec3().to_array());
            mesh.normals.push(normal.as_vec3().to_array());
            mesh.uvs.push(((p - min) / size).as_vec2().to_array());
            mesh.positions.len() as u32 - 1
        };
        let mut triangles = Vec::with_capacity(2 * (filled.triangles.len() + filled.walls.len()));
        for (z, normal) in [(self.depth, DVec3::Z), (0.0, DVec3::NEG_Z)] {
            // Points inside overlaps are corners as well; those of no triangle are left out.
            let mut number = vec![u32::MAX; flat.len()];
            for triangle in &filled.triangles {
                let [a, b, c] = triangle.map(|i| {
                    if number[i as usize] == u32::MAX {
                        number[i as usize] = add(i, z, normal);
                    }
                    number[i as usize]
                });
                triangles.push(if z > 0.0 { [a, b, c] } else { [a, c, b] });
            }
        }
        for (wall, normals) in filled.walls.iter().zip(normals(filled, edges, grid)) {
            let [n, m] = normals.map(|n| n.extend(0.0));
            let [a, b] = [(wall.from, n), (wall.to, m)].map(|(i, n)| add(i, 0.0, n));
            let [d, c] = [(wall.from, n), (wall.to, m)].map(|(i, n)| add(i, self.depth, n));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        mesh.triangles = triangles;
        mesh
    }
}

/// The outward unit normals at both ends of each wall.
fn normals(filled: &Filled, edges: &[Edge], grid: &Grid) -> Vec<[DVec2; 2]> {
    let at = |i: u32| grid.place(filled.points[i as usize]);
    let own = |wall: &Wall| {
        let (from, to) = (at(wall.from), at(wall.to));
        let chord = (to - from).normalize_or_zero();
        let directions = match edges.get(wall.source as usize) {
            Some(edge) => {
                // Of an edge that was cut, a part; of a hole that winds like its outline, turned.
                let whole = edge.to - edge.from;
                let sign = if whole.dot(chord) < 0.0 { -1.0 } else { 1.0 };
                let [first, last] = edge.directions;
                [from, to].map(|p| {
                    let t = ((p - edge.from).dot(whole) / whole.length_squared()).clamp(0.0, 1.0);
                    sign * first.lerp(last, t)
                })
            }
            None => [chord; 2],
        };
        // Rounding to the grid turns short edges; a normal must stay on its side.
        directions.map(|d| d.try_normalize().filter(|d| d.dot(chord) > 0.5).unwrap_or(chord))
    };
    let mut directions: Vec<[DVec2; 2]> = filled.walls.iter().map(own).collect();
    // Where curves are joined almost smoothly, as integer coordinates of fonts make them, walls share the mean.
    let mut ends: HashMap<u32, [Vec<usize>; 2]> = HashMap::new();
    for (i, wall) in filled.walls.iter().enumerate() {
        ends.entry(wall.from).or_default()[0].push(i);
        ends.entry(wall.to).or_default()[1].push(i);
    }
    for (out, into) in filled.walls.iter().filter_map(|w| {
        let [out, into] = ends.get(&w.from)?;
        Some((*out.first()?, *into.first()?)).filter(|_| out.len() == 1 && into.len() == 1)
    }) {
        let (a, b) = (directions[into][1], directions[out][0]);
        if a.dot(b) > SMOOTH {
            let mean = (a + b).normalize_or(a);
            (directions[into][1], directions[out][0]) = (mean, mean);
        }
    }
    directions.into_iter().map(|d| d.map(|d| DVec2::new(d.y, -d.x))).collect()
}

/// The grid of integers on which outlines are filled.
struct Grid {
    middle: DVec2,
    /// Grid points per em, a power of two.
    scale: f64,
}

impl Grid {
    /// The finest grid that outlines fit on.
    fn around(edges: &[Edge]) -> Result<Grid, SceneError> {
        let points = || edges.iter().flat_map(|e| [e.from, e.to]);
        if edges.is_empty() {
            return Ok(Grid { middle: DVec2::ZERO, scale: FINEST });
        }
        let min = points().fold(DVec2::INFINITY, DVec2::min);
        let max = points().fold(DVec2::NEG_INFINITY, DVec2::max);
        // A middle on the grid keeps coordinates that have few binary digits exact.
        let middle = (0.5 * (min + max)).round();
        let reach = points().map(|p| (p - middle).abs().max_element()).fold(0.0, f64::max);
        if !(points().all(|p| p.is_finite()) && reach <= MOST_EM) {
            let most = 2.0 * MOST_EM;
            return Err(too_large(format!("a text is more than {most} times as large as its `size`")));
        }
        let mut scale = FINEST;
        while reach * scale > (REACH - 2) as f64 {
            scale *= 0.5;
        }
        Ok(Grid { middle, scale })
    }

    fn point(&self, p: DVec2) -> planar::Point {
        let p = ((p - self.middle) * self.scale).round();
        [p.x as i64, p.y as i64]
    }

    fn place(&self, p: planar::Point) -> DVec2 {
        self.middle + DVec2::new(p[0] as f64, p[1] as f64) / self.scale
    }
}
