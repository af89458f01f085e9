//! Results as text or JSON.

use serde_json::json;
use turner_bvh::generate::SceneKind;
use turner_cli::text;

use super::builds::BuildRow;
use super::embree::Embree;
use super::kinds::Kind;
use super::tracer::Quality;
use super::{RaysArgs, Rival, show};
use crate::statistics::geometric_mean;

/// The contender that a figure belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Column {
    /// Turner, rays in batches.
    Turner(Quality),
    /// Turner, single rays.
    One,
    /// Embree.
    Embree(Rival),
}

impl Column {
    fn key(self) -> String {
        match self {
            Column::Turner(quality) => format!("turner-{}", quality.name()),
            Column::One => "turner-one".into(),
            Column::Embree(rival) => format!("embree-{}", rival.name()),
        }
    }

    fn head(self) -> String {
        match self {
            Column::Turner(quality) => quality.name().into(),
            Column::One => "one".into(),
            Column::Embree(rival) => format!("E.{}", rival.name()),
        }
    }
}

/// Rates for one kind of rays.
pub(super) struct RayRow {
    /// Rays of each run.
    pub(super) rays: usize,
    /// Contender, median, and each run, in million rays per second.
    pub(super) rates: Vec<(Column, f64, Vec<f64>)>,
    /// Rays whose result differs from Embree's, and rays compared.
    pub(super) compared: Option<(usize, usize)>,
}

impl RayRow {
    fn rate(&self, column: Column) -> Option<f64> {
        self.rates.iter().find(|r| r.0 == column).map(|r| r.1)
    }
}

/// Prints rows as they arrive and keeps them for the means.
pub(super) struct Table {
    json: bool,
    columns: Vec<Column>,
    /// Turner's column that is compared with Embree's.
    ours: Column,
    /// Columns of Embree.
    theirs: Vec<Column>,
    rows: Vec<(usize, Kind, RayRow)>,
}

const NAME: usize = 13;
const KIND: usize = 16;

impl Table {
    pub(super) fn new(args: &RaysArgs, embree: Option<&Embree>) -> Table {
        let mut columns: Vec<Column> = args.quality.iter().map(|&q| Column::Turner(q)).collect();
        let ours = columns.last().copied().unwrap_or(Column::One);
        columns.push(Column::One);
        let mut theirs = Vec::new();
        if let Some(embree) = embree {
            theirs.extend(args.embree_quality.iter().map(|&r| Column::Embree(r)));
            if !args.json {
                show(&format!("Embree {} (E.)\n", embree.version()));
            }
        }
        columns.extend(&theirs);
        Table { json: args.json, columns, ours, theirs, rows: Vec::new() }
    }

    /// Adds the build results of a scene.
    pub(super) fn builds(&self, scene: SceneKind, threads: usize, rows: &[BuildRow]) {
        if self.json {
            for row in rows {
                let line = json!({
                    "row": "build", "scene": scene.name(), "threads": threads, "builder": row.column.key(),
                    "seconds": row.seconds, "median_seconds": row.median, "items": row.items,
                    "items_per_second": row.items as f64 / row.median, "bytes": row.bytes,
                    "bytes_per_item": row.bytes as f64 / row.items as f64,
                });
                show(&format!("{line}\n"));
            }
            return;
        }
        let threads = text::plural(threads as u64, "thread");
        let mut out = format!("\n{}, {threads}: building\n", scene.name());
        out += &format!("  {:15} {:>10} {:>10} {:>10}\n", "", "median", "Mtri/s", "bytes/tri");
        for row in rows {
            let rate = row.items as f64 / 1e6 / row.median;
            let bytes = row.bytes as f64 / row.items as f64;
            let (who, time) = (row.column.key(), text::seconds(row.median));
            out += &format!("  {who:15} {time:>10} {rate:>10.3} {bytes:>10.1}\n");
        }
        out += &self.head();
        show(&out);
    }

    fn head(&self) -> String {
        let mut out = format!("{:NAME$} {:KIND$} {:>4} {:>7}", "scene", "rays", "thr", "M");
        for column in &self.columns {
            out += &format!(" {:>9}", column.head());
        }
        for column in &self.theirs {
            out += &format!(" {:>9}", column.head().replace("E.", "/"));
        }
        if !self.theirs.is_empty() {
            out += &format!(" {:>7}", "differ");
        }
        out + "\n"
    }

    /// Adds a row.
    pub(super) fn rays(
        &mut self,
        scene: SceneKind,
        threads: usize,
        triangles: usize,
        kind: Kind,
        row: RayRow,
    ) {
        if self.json {
            let rates: serde_json::Map<_, _> =
                row.rates.iter().map(|(c, median, _)| (c.key(), json!(median))).collect();
            let runs: serde_json::Map<_, _> =
                row.rates.iter().map(|(c, _, runs)| (c.key(), json!(runs))).collect();
            let line = json!({
                "row": "rays", "scene": scene.name(), "triangles": triangles, "threads": threads,
                "kind": kind.name(), "rays": row.rays, "mrays_per_second": rates, "runs": runs,
                "ratios": self.ratios_by_name(|c| self.ratio(&row, c)),
                "differ": row.compared.map(|c| c.0), "compared": row.compared.map(|c| c.1),
            });
            show(&format!("{line}\n"));
        } else {
            let rays = format!("{:.3}", row.rays as f64 / 1e6);
            let mut out = self.line(
                [scene.name(), kind.name(), &threads.to_string(), &rays],
                |c| row.rate(c),
                |c| self.ratio(&row, c),
            );
            if let Some((differ, _)) = row.compared {
                out += &format!(" {differ:>7}");
            }
            show(&(out + "\n"));
        }
        self.rows.push((threads, kind, row));
    }

    fn line(
        &self,
        [name, kind, threads, rays]: [&str; 4],
        rate: impl Fn(Column) -> Option<f64>,
        ratio: impl Fn(Column) -> Option<f64>,
    ) -> String {
        let mut out = format!("{name:NAME$} {kind:KIND$} {threads:>4} {rays:>7}");
        for &column in &self.columns {
            out += &format!(" {:>9}", rate(column).map_or("-".into(), |rate| format!("{rate:.2}")));
        }
        for &column in &self.theirs {
            out += &format!(" {:>9}", ratio(column).map_or("-".into(), |ratio| format!("{ratio:.2}x")));
        }
        out
    }

    /// Turner's rate divided by that of Embree's column.
    fn ratio(&self, row: &RayRow, theirs: Column) -> Option<f64> {
        Some(row.rate(self.ours)? / row.rate(theirs)?)
    }

    fn ratios_by_name(
        &self,
        ratio: impl Fn(Column) -> Option<f64>,
    ) -> serde_json::Map<String, serde_json::Value> {
        self.theirs.iter().filter_map(|&c| Some((c.key(), json!(ratio(c)?)))).collect()
    }

    /// Adds the geometric means over the scenes, one row per kind of rays.
    pub(super) fn means(&self, threads: &[usize]) {
        if !self.json {
            show(&format!("\n{}", self.head()));
        }
        for &threads in threads {
            for kind in Kind::ALL {
                let rows: Vec<&RayRow> =
                    self.rows.iter().filter(|r| r.0 == threads && r.1 == kind).map(|r| &r.2).collect();
                if rows.is_empty() {
                    continue;
                }
                let rate = |c: Column| geometric_mean(rows.iter().filter_map(|r| r.rate(c)));
                let ratio = |c: Column| geometric_mean(rows.iter().filter_map(|r| self.ratio(r, c)));
                if self.json {
                    let rates: serde_json::Map<_, _> =
                        self.columns.iter().filter_map(|&c| Some((c.key(), json!(rate(c)?)))).collect();
                    let line = json!({
                        "row": "mean", "threads": threads, "kind": kind.name(), "scenes": rows.len(),
                        "mrays_per_second": rates, "ratios": self.ratios_by_name(ratio),
                    });
                    show(&format!("{line}\n"));
                } else {
                    let words = ["mean", kind.name(), &threads.to_string(), ""];
                    show(&(self.line(words, rate, ratio) + "\n"));
                }
            }
        }
    }
}
