//! Percentiles beside their targets.

use serde_json::json;

/// A measurement.
pub(super) struct Row<'a> {
    /// The scene.
    pub(super) scene: &'a str,
    /// The size of the picture; none for what has none.
    pub(super) size: Option<[u32; 2]>,
    /// What was measured.
    pub(super) what: &'a str,
    /// "ms", or nothing for FLIP.
    pub(super) unit: &'static str,
    /// The values in their order.
    pub(super) values: Vec<f64>,
    /// The value that the 95th percentile must not exceed.
    pub(super) target: Option<f64>,
    /// A remark, such as the size of the frames.
    pub(super) note: String,
}

/// The value that the fraction `p` of the values does not exceed: the nearest rank.
pub(super) fn percentile(values: &[f64], p: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rank = (p * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.clamp(1, sorted.len().max(1)) - 1).copied().unwrap_or(f64::NAN)
}

impl Row<'_> {
    fn is_met(&self) -> Option<bool> {
        self.target.map(|target| percentile(&self.values, 0.95) <= target)
    }

    fn json(&self) -> serde_json::Value {
        json!({
            "scene": self.scene,
            "width": self.size.map(|size| size[0]),
            "height": self.size.map(|size| size[1]),
            "measurement": self.what,
            "unit": self.unit,
            "p50": percentile(&self.values, 0.5),
            "p95": percentile(&self.values, 0.95),
            "max": percentile(&self.values, 1.0),
            "count": self.values.len(),
            "target": self.target,
            "met": self.is_met(),
            "note": self.note,
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    fn text(&self) -> String {
        let shown = |v: f64| match self.unit {
            "" => format!("{v:.3}"),
            _ if v < 10.0 => format!("{v:.1}"),
            _ => format!("{v:.0}"),
        };
        let [p50, p95, max] = [0.5, 0.95, 1.0].map(|p| shown(percentile(&self.values, p)));
        let target = self.target.map_or(String::new(), |target| format!("<= {}", shown(target)));
        let verdict = match self.is_met() {
            Some(true) => "met",
            Some(false) => "missed",
            None => "",
        };
        let size = self.size.map_or(String::new(), |[width, height]| format!("{width}x{height}"));
        let line = format!(
            "{:24}{size:>10}  {:38}{p50:>8}{p95:>8}{max:>8} {:2} {target:>8}  {verdict:7}{}",
            self.scene, self.what, self.unit, self.note
        );
        format!("{}\n", line.trim_end())
    }
}

/// Prints rows as they are measured.
pub(super) struct Table {
    json: bool,
    targets: u32,
    met: u32,
}

impl Table {
    pub(super) fn new(json: bool) -> Table {
        if !json {
            turner_cli::text::print(&format!(
                "{:24}{:>10}  {:38}{:>8}{:>8}{:>8}    {:>8}\n",
                "scene", "size", "measurement", "p50", "p95", "max", "target"
            ));
        }
        Table { json, targets: 0, met: 0 }
    }

    pub(super) fn add(&mut self, row: &Row<'_>) {
        if row.values.is_empty() {
            return;
        }
        self.targets += u32::from(row.target.is_some());
        self.met += u32::from(row.is_met() == Some(true));
        let line = if self.json { format!("{}\n", row.json()) } else { row.text() };
        turner_cli::text::print(&line);
    }

    pub(super) fn end(&self) {
        if !self.json {
            turner_cli::text::print(&format!(
                "\n{} of {} targets met by the 95th percentile\n",
                self.met, self.targets
            ));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_values_that_were_measured() {
        let values: Vec<f64> = (1..=60).map(f64::from).rev().collect();
        assert_eq!([0.5, 0.95, 1.0].map(|p| percentile(&values, p)), [30.0, 57.0, 60.0]);
        assert_eq!(percentile(&[7.0], 0.95), 7.0);
        assert!(percentile(&[], 0.5).is_nan());
    }

    #[test]
    fn the_95th_percentile_decides() {
        let row = |target| Row {
            scene: "a",
            size: Some([64, 36]),
            what: "edit",
            unit: "ms",
            values: vec![10.0, 20.0, 90.0],
            target: Some(target),
            note: String::new(),
        };
        assert_eq!((row(89.0).is_met(), row(90.0).is_met()), (Some(false), Some(true)));
        assert!(row(89.0).text().contains("missed") && row(90.0).json()["met"] == true);
    }
}
