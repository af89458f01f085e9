//! Curves: hair, fur, grass and wires; many cubic curves in one shape with one BVH.

mod blocks;
mod cubic;
mod fibres;
#[cfg(test)]
mod tests;
mod tubes;

pub use fibres::Curves;
pub use tubes::MAX_TRIANGLES;

use super::mesh::vectors;
use crate::math::DVec3;
use crate::schema::value::{Data, Table};
use crate::schema::write::{list, single};
use crate::schema::{
    Asset, EntryDoc, ErrorCode, MeshData, MeshId, PrepareOptions, Range, ReadContext, Renumber, SceneError,
    TableReader, WriteContext, choice, params,
};

choice! {
    /// How the points define a curve.
    pub enum CurveBasis {
        /// Through all points, with smooth bends (uniform Catmull-Rom spline).
        CatmullRom = "catmull-rom",
        /// Near the points, with smoother bends (uniform cubic B-spline). It begins near the second point and ends near
        /// the last but one.
        BSpline = "b-spline",
        /// Cubic Bézier segments: each fourth point is on the curve, the two between are handles. 4, 7, 10, … points.
        Bezier = "bezier",
        /// Straight lines from point to point.
        Linear = "linear",
    }
}

choice! {
    /// The cross-section of curves.
    pub enum CurveKind {
        /// Round, closed at both ends. Seen from outside only.
        Tube = "tube",
        /// Flat, and turned towards every ray: for hair that is thinner than a pixel.
        Flat = "flat",
        /// Flat, perpendicular to the `normals`: blades of grass, ribbons.
        Ribbon = "ribbon",
    }
}

params! {
    /// Curves: hair, fur, grass, wires. From a .hair file, or given inline. Along a curve u grows from 0 to 1; v grows
    /// from 0 to 1 across it, seen from the ray. The texture "vertex-color" shows the points' colours. They emit light,
    /// but lights are not sampled on them.
    pub struct CurvesKeys as "curves" {
        /// Path of a .hair file.
        file: Option<String> = None;
        /// Points of all curves, one curve after the other, instead of `file`.
        points: Option<Vec<DVec3>> = None;
        /// Number of points of each curve. If not given, all points are one curve.
        strands: Option<Vec<u32>> = None;
        /// Width of all curves. If not given, the widths of the file, or 1/200 of the longest side of the bounding box.
        width: Option<f64> = None, in Range::POSITIVE;
        /// Width at each point; `width` takes precedence.
        widths: Option<Vec<f64>> = None, in Range::NON_NEGATIVE;
        /// Normal at each point, for ribbons.
        normals: Option<Vec<DVec3>> = None;
        /// Colours [r, g, b, opacity], linear, one per inline point.
        colors: Option<Vec<[f64; 4]>> = None;
        /// How the points define the curves.
        basis: CurveBasis = CurveBasis::CatmullRom;
        /// The cross-section.
        kind: CurveKind = CurveKind::Tube;
    }
    example r##"[[object]]
type = "curves"
points = [[-1, -1, 0], [-0.5, 0, 0.5], [0, 0.5, 0], [0.2, 1, 0], [1, -1, 0], [0.6, 0, 0], [0.8, 0.8, 0]]
strands = [4, 3]
widths = [0.2, 0.15, 0.1, 0, 0.2, 0.1, 0]
"##
}

/// Curves whose points, widths, normals and colours are in the scene's list of meshes; by default the first of them.
#[derive(Clone, Debug, PartialEq)]
pub struct CurvesDesc {
    /// The mesh whose vertices are the points.
    pub curves: MeshId,
    /// Width of all curves, greater than 0; otherwise that of the points.
    pub width: Option<f64>,
    /// How the points define the curves.
    pub basis: CurveBasis,
    /// The cross-section.
    pub kind: CurveKind,
}

impl Default for CurvesDesc {
    fn default() -> CurvesDesc {
        CurvesDesc {
            curves: MeshId::default(),
            width: None,
            basis: CurveBasis::CatmullRom,
            kind: CurveKind::Tube,
        }
    }
}

impl CurveBasis {
    /// Number of segments of a curve with that many points; `None` if the basis has no such curve.
    pub fn segments(self, points: u32) -> Option<u32> {
        match self {
            CurveBasis::CatmullRom | CurveBasis::Linear => points.checked_sub(1).filter(|n| *n > 0),
            CurveBasis::BSpline => points.checked_sub(3).filter(|n| *n > 0),
            CurveBasis::Bezier => {
                points.checked_sub(1).filter(|n| *n > 0 && n.is_multiple_of(3)).map(|n| n / 3)
            }
        }
    }

    /// The numbers of points that a curve may have.
    fn expected(self) -> &'static str {
        match self {
            CurveBasis::CatmullRom | CurveBasis::Linear => "2 or more",
            CurveBasis::BSpline => "4 or more",
            CurveBasis::Bezier => "4, 7, 10 or so on",
        }
    }
}

impl CurvesDesc {
    /// Its documentation.
    pub const DOC: EntryDoc = CurvesKeys::DOC;

    /// Renumbers the ids it refers to.
    pub fn renumber(&mut self, by: &Renumber) {
        self.curves = by.mesh(self.curves);
    }

    /// The keys that [`CurvesDesc::read`] reads.
    pub fn write(&self, cx: &mut dyn WriteContext) -> Result<Table, SceneError> {
        let mut table = Table::default();
        match cx.mesh(self.curves)? {
            (_, Some(file)) => table.push("file", Data::String(file)),
            (data, None) => {
                table.push("points", vectors(&data.positions));
                let strands = data.strands.iter().map(|n| Data::Integer(i64::from(*n)));
                table.push("strands", (!data.strands.is_empty()).then(|| list(strands)));
                let widths = data.widths.iter().map(|w| single(*w));
                table.push("widths", (!data.widths.is_empty()).then(|| list(widths)));
                table.push("normals", vectors(&data.normals));
                table.push("colors", vectors(&data.colors));
            }
        }
        table.push("width", self.width.map(Data::Number));
        if self.basis != CurveBasis::CatmullRom {
            table.push("basis", Data::String(self.basis.word().to_owned()));
        }
        if self.kind != CurveKind::Tube {
            table.push("kind", Data::String(self.kind.word().to_owned()));
        }
        Ok(table)
    }

    /// Reads its keys; adds inline points to the scene's list of meshes.
    pub fn read(table: &mut TableReader<'_>, cx: &mut dyn ReadContext) -> Result<CurvesDesc, SceneError> {
        let keys = CurvesKeys::read(table, cx)?;
        let inline = keys.strands.is_some()
            || keys.widths.is_some()
            || keys.normals.is_some()
            || keys.colors.is_some();
        let curves = match (keys.file, keys.points) {
            (Some(uri), None) if !inline => cx.mesh_file(&uri, table.span_of("file"))?,
            (None, Some(points)) => {
                let single = |v: DVec3| v.as_vec3().to_array();
                let data = MeshData {
                    positions: points.into_iter().map(single).collect(),
                    strands: keys.strands.unwrap_or_default(),
                    widths: keys.widths.unwrap_or_default().into_iter().map(|w| w as f32).collect(),
                    normals: keys.normals.unwrap_or_default().into_iter().map(single).collect(),
                    colors: keys
                        .colors
                        .unwrap_or_default()
                        .into_iter()
                        .map(|c| c.map(|x| x as f32))
                        .collect(),
                    ..MeshData::default()
                };
                data.check().map_err(|e| e.or_at(Some(table.span())))?;
                cx.inline_mesh(data)
            }
            (None, None) => {
                return Err(SceneError::at(
                    ErrorCode::MissingKey,
                    table.span(),
                    "curves need a `file`, or `points`",
                )
                .help("add `file = \"fur.hair\"`"));
            }
            _ => {
                let message = "curves have either a `file` or inline `points`, `strands`, `widths`, `normals` and `colors`";
                return Err(SceneError::at(ErrorCode::Conflict, table.span_of("file"), message)
                    .help("remove one of the two"));
            }
        };
        let desc = CurvesDesc { curves, width: keys.width, basis: keys.basis, kind: keys.kind };
        desc.check(&cx.mesh_data(curves)).map_err(|e| e.or_at(Some(table.span())))?;
        Ok(desc)
    }

    /// Checks that the basis has curves with these numbers of points, and that ribbons have normals.
    fn check(&self, data: &MeshData) -> Result<(), SceneError> {
        for (i, count) in data.curve_counts().enumerate() {
            if self.basis.segments(count).is_none() {
                let message = format!(
                    "curve {i} has {count} points; with the basis \"{}\" a curve has {}",
                    self.basis.word(),
                    self.basis.expected()
                );
                return Err(SceneError::new(ErrorCode::Mesh, message)
                    .help("give another `basis`, or other `strands`"));
            }
        }
        if self.kind == CurveKind::Ribbon && data.normals.is_empty() && !data.positions.is_empty() {
            let message = "ribbons need `normals`";
            return Err(SceneError::new(ErrorCode::MissingKey, message)
                .help("give one normal per point, or `kind = \"flat\"`"));
        }
        Ok(())
    }

    /// Converts them to the form that rays are intersected with. `meshes` are the scene's.
    pub fn prepare(
        &self,
        meshes: &[Asset<MeshData>],
        options: &PrepareOptions,
    ) -> Result<Curves, SceneError> {
        let Some(asset) = meshes.get(self.curves.index()) else {
            let message = format!("curves name mesh {}, but the scene has {}", self.curves.0, meshes.len());
            return Err(SceneError::new(ErrorCode::Mesh, message));
        };
        asset.data.check()?;
        self.check(&asset.data)?;
        Curves::build(&asset.data, self, options)
    }
}
