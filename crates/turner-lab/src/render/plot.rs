//! Error over time as SVG: logarithmic axes, a panel per scene, a line per renderer, colours for light and dark themes.

use std::fmt::Write;

use turner::math::elementary::ln;

use super::Series;

/// Size of a panel with its labels.
const PANEL: (f64, f64) = (440.0, 320.0);
/// The plot area in a panel: left, top, right, bottom.
const INNER: [f64; 4] = [62.0, 36.0, 424.0, 274.0];
/// Height of the legend below the panels.
const LEGEND: f64 = 34.0;
/// A palette for all types of colour vision (Okabe and Ito 2008), darker and lighter for the two backgrounds.
const COLORS: [(&str, &str); 6] = [
    ("#0072b2", "#56b4e9"),
    ("#d55e00", "#ff8c42"),
    ("#00795a", "#2bc79a"),
    ("#b0508a", "#e79ac6"),
    ("#8a6d00", "#f0e442"),
    ("#555555", "#bbbbbb"),
];
const STYLE: &str = "text{font:12px system-ui,sans-serif;fill:#24292f}.t{font-weight:600;font-size:14px}.bg{fill:#fff}\
                     .g{stroke:#d8dee4;stroke-width:1}.f{fill:none;stroke:#8c959f}";
const DARK: &str = "text{fill:#e6edf3}.bg{fill:#0d1117}.g{stroke:#30363d}.f{stroke:#6e7681}";

/// The complete plot.
pub(super) fn svg(all: &[Series]) -> String {
    let mut panels: Vec<(String, Vec<&Series>)> = Vec::new();
    let mut renderers: Vec<&str> = Vec::new();
    let several = all.iter().any(|s| s.threads != all[0].threads);
    for s in all {
        let threads = if several {
            format!(", {}", turner_cli::text::plural(s.threads as u64, "thread"))
        } else {
            String::new()
        };
        let title = format!("{}{threads}", s.scene);
        match panels.iter_mut().find(|p| p.0 == title) {
            Some(panel) => panel.1.push(s),
            None => panels.push((title, vec![s])),
        }
        if !renderers.contains(&s.renderer.as_str()) {
            renderers.push(&s.renderer);
        }
    }
    let columns = panels.len().clamp(1, 2);
    let rows = panels.len().div_ceil(columns).max(1);
    let (width, height) = (columns as f64 * PANEL.0, rows as f64 * PANEL.1 + LEGEND);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
         role=\"img\" aria-label=\"Relative mean square error over seconds of rendering\">\n<style>{STYLE}"
    );
    let colors = |pick: fn(&(&'static str, &'static str)) -> &'static str| {
        let mut out = String::new();
        for (i, color) in COLORS.iter().enumerate() {
            let _ = write!(out, ".c{i}{{stroke:{0};fill:{0}}}", pick(color));
        }
        out
    };
    let _ = write!(out, "{}@media(prefers-color-scheme:dark){{{DARK}{}}}", colors(|c| c.0), colors(|c| c.1));
    let _ = writeln!(out, "polyline{{fill:none!important;stroke-width:2}}</style>");
    let _ = writeln!(out, "<rect class=\"bg\" width=\"{width}\" height=\"{height}\"/>");
    for (i, (title, series)) in panels.iter().enumerate() {
        let (x, y) = ((i % columns) as f64 * PANEL.0, (i / columns) as f64 * PANEL.1);
        let _ = writeln!(out, "<g transform=\"translate({x} {y})\">");
        panel(&mut out, title, series, &renderers);
        out.push_str("</g>\n");
    }
    legend(&mut out, &renderers, width, height - LEGEND / 2.0);
    out.push_str("</svg>\n");
    out
}

fn log10(value: f64) -> f64 {
    ln(value) / std::f64::consts::LN_10
}

/// A logarithmic axis: the exponents at its ends, and their positions.
struct Axis {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Axis {
    /// Covers all values, and at least a decade.
    fn around(values: impl Iterator<Item = f64> + Clone, from: f64, to: f64) -> Axis {
        let low = log10(values.clone().fold(f64::INFINITY, f64::min));
        let high = log10(values.fold(0.0, f64::max));
        let (low, high) = if low.is_finite() && high.is_finite() { (low, high) } else { (-2.0, 0.0) };
        let room = (0.04 * (high - low)).max(0.02);
        let (low, high) = (low - room, high + room);
        let widen = (0.5 * (1.0 - (high - low))).max(0.0);
        Axis { low: low - widen, high: high + widen, from, to }
    }

    fn at(&self, value: f64) -> f64 {
        self.from + (self.to - self.from) * (log10(value) - self.low) / (self.high - self.low)
    }

    /// 1, 2 and 5 of each decade, and whether they have a label.
    fn ticks(&self) -> Vec<(f64, bool)> {
        let mut out = Vec::new();
        let dense = self.high - self.low < 2.2;
        for decade in self.low.floor() as i32..=self.high.ceil() as i32 {
            for digit in [1, 2, 5] {
                // Parsing gives the nearest float, which a product might not.
                let value = format!("{digit}e{decade}").parse().unwrap_or(f64::NAN);
                if (self.low..=self.high).contains(&log10(value)) {
                    out.push((value, digit == 1 || dense));
                }
            }
        }
        out
    }
}

fn panel(out: &mut String, title: &str, series: &[&Series], renderers: &[&str]) {
    let [left, top, right, bottom] = INNER;
    let points = || series.iter().flat_map(|s| s.points());
    let x = Axis::around(points().map(|p| p.seconds).collect::<Vec<_>>().into_iter(), left, right);
    let y = Axis::around(points().map(|p| p.error).collect::<Vec<_>>().into_iter(), bottom, top);
    let center = 0.5 * (left + right);
    let _ = writeln!(out, "<text class=\"t\" x=\"{left}\" y=\"22\">{}</text>", escaped(title));
    for (value, labelled) in x.ticks() {
        let at = x.at(value);
        let _ = write!(out, "<path class=\"g\" d=\"M{at:.1} {top}V{bottom}\"/>");
        if labelled {
            let _ = write!(
                out,
                "<text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{value}</text>",
                bottom + 16.0
            );
        }
    }
    for (value, labelled) in y.ticks() {
        let at = y.at(value);
        let _ = write!(out, "<path class=\"g\" d=\"M{left} {at:.1}H{right}\"/>");
        if labelled {
            let _ = write!(
                out,
                "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{value}</text>",
                left - 6.0,
                at + 4.0
            );
        }
    }
    let _ = writeln!(
        out,
        "\n<rect class=\"f\" x=\"{left}\" y=\"{top}\" width=\"{}\" height=\"{}\"/>\
         <text x=\"{center}\" y=\"{}\" text-anchor=\"middle\">seconds of rendering</text>\
         <text transform=\"translate(14 {}) rotate(-90)\" text-anchor=\"middle\">relMSE</text>",
        right - left,
        bottom - top,
        bottom + 34.0,
        0.5 * (top + bottom)
    );
    if points().next().is_none() {
        let _ = writeln!(
            out,
            "<text x=\"{center}\" y=\"150\" text-anchor=\"middle\">no errors: no reference</text>"
        );
    }
    for s in series {
        let class = renderers.iter().position(|r| *r == s.renderer).unwrap_or(0) % COLORS.len();
        let positions: Vec<(f64, f64)> =
            s.points().iter().map(|p| (x.at(p.seconds), y.at(p.error))).collect();
        let line: Vec<String> = positions.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        let _ = write!(out, "<polyline class=\"c{class}\" points=\"{}\"/>", line.join(" "));
        for (x, y) in positions {
            let _ = write!(out, "<circle class=\"c{class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.5\"/>");
        }
        out.push('\n');
    }
}

fn legend(out: &mut String, renderers: &[&str], width: f64, y: f64) {
    let length = |name: &str| 44.0 + 7.0 * name.chars().count() as f64;
    let mut x = 0.5 * (width - renderers.iter().map(|r| length(r)).sum::<f64>()).max(20.0);
    for (i, name) in renderers.iter().enumerate() {
        let class = i % COLORS.len();
        let _ = writeln!(
            out,
            "<polyline class=\"c{class}\" points=\"{x:.0},{y} {:.0},{y}\"/><text x=\"{:.0}\" y=\"{}\">{}</text>",
            x + 20.0,
            x + 26.0,
            y + 4.0,
            escaped(name)
        );
        x += length(name);
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::super::table::tests::series;
    use super::*;

    #[test]
    fn a_line_for_each_renderer_and_a_panel_for_each_scene() {
        let mut all = vec![series("turner", 0.02), series("cycles", 0.08), series("turner", 0.5)];
        all[2].scene = "<b>".into();
        let picture = svg(&all);
        assert_eq!(picture.matches("<g transform").count(), 2);
        // Two panels with three lines, and two in the legend.
        assert_eq!(picture.matches("<polyline").count(), 5);
        assert_eq!(picture.matches("<circle").count(), 12);
        assert!(picture.contains("&lt;b&gt;") && picture.contains("prefers-color-scheme:dark"));
        assert!(!picture.contains("NaN") && !picture.contains("inf"), "{picture}");
    }

    #[test]
    fn axes_are_logarithmic() {
        let axis = Axis { low: -2.0, high: 0.0, from: 100.0, to: 300.0 };
        for (value, place) in [(0.01, 100.0), (0.1, 200.0), (1.0, 300.0)] {
            assert!((axis.at(value) - place).abs() < 1e-9, "{value}");
        }
        let wide = Axis { low: -2.1, high: 0.1, ..axis };
        assert_eq!(wide.ticks().len(), 7);
        let one = Axis::around(std::iter::once(0.5), 0.0, 1.0);
        assert!((one.at(0.5) - 0.5).abs() < 1e-9 && one.high - one.low > 0.9);
    }

    #[test]
    fn empty_plots_are_valid() {
        assert!(svg(&[]).contains("</svg>"));
        let mut s = series("turner", 1.0);
        s.measured.clear();
        assert!(svg(&[s]).contains("no reference"));
    }
}
