//! Findings, with their severity, text, remedies and measurements.

use crate::schema::Remedy;
use crate::schema::value::{Data, Span};

/// The severity of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The picture is not what its author wants.
    Error,
    /// Something is probably wrong, or wastes much time.
    Warning,
    /// Good to know, but probably no fault.
    Note,
}

impl Severity {
    /// Its word in reports.
    pub fn word(self) -> &'static str {
        match self {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Note => "note",
        }
    }
}

/// The question that a finding answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Question {
    /// Why the picture is black or too dark, or shows nothing.
    Black,
    /// Why the picture is noisy.
    Noisy,
    /// Why the picture is washed out.
    WashedOut,
    /// Why rendering is slow.
    Slow,
    /// What is broken in the scene.
    Broken,
}

impl Question {
    /// Its word in reports.
    pub fn word(self) -> &'static str {
        match self {
            Question::Black => "black",
            Question::Noisy => "noisy",
            Question::WashedOut => "washed-out",
            Question::Slow => "slow",
            Question::Broken => "broken",
        }
    }
}

/// A measured value.
#[derive(Clone, Debug, PartialEq)]
pub struct Measure {
    /// Its name, in kebab-case.
    pub name: &'static str,
    /// The value. Finite.
    pub value: f64,
    /// Its unit: `share` (a fraction, 0 to 1), `count`, `stops`, `degrees`, `units` of the scene, `radiance`,
    /// `irradiance`, `pixels`, `ratio`, `relmse`, `seconds`.
    pub unit: &'static str,
}

/// One finding.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Its code, stable across versions.
    pub code: &'static str,
    /// Its severity.
    pub severity: Severity,
    /// The question that it answers.
    pub question: Question,
    /// Its importance among findings of the same severity, 0 to 1.
    pub weight: f64,
    /// What is wrong, with the name of the object, light or setting.
    pub what: String,
    /// Why it has this effect.
    pub why: String,
    /// What to do.
    pub remedy: String,
    /// Remedies as data that a program can apply. Any one of them is sufficient.
    pub remedies: Vec<Remedy>,
    /// The measurements that support it.
    pub measured: Vec<Measure>,
    /// The name of the object, material or light in the scene; the first one if there are several.
    pub subject: Option<String>,
    /// The position of its definition in the scene file.
    pub span: Option<Span>,
}

impl Finding {
    /// A finding without measurements.
    pub(super) fn new(
        question: Question,
        severity: Severity,
        code: &'static str,
        weight: f64,
        what: impl Into<String>,
    ) -> Finding {
        Finding {
            code,
            severity,
            question,
            weight,
            what: what.into(),
            why: String::new(),
            remedy: String::new(),
            remedies: Vec::new(),
            measured: Vec::new(),
            subject: None,
            span: None,
        }
    }

    pub(super) fn why(mut self, why: impl Into<String>) -> Finding {
        self.why = why.into();
        self
    }

    pub(super) fn remedy(mut self, remedy: impl Into<String>) -> Finding {
        self.remedy = remedy.into();
        self
    }

    /// Adds a remedy as data.
    pub(super) fn or(mut self, remedy: Remedy) -> Finding {
        self.remedies.push(remedy);
        self
    }

    /// Adds a remedy that sets one value of the scene.
    pub(super) fn set(self, key: &str, value: impl Into<Data>) -> Finding {
        self.or(Remedy::set(key, value))
    }

    pub(super) fn about(mut self, subject: impl Into<String>) -> Finding {
        self.subject = Some(subject.into());
        self
    }

    /// Sets the position in the scene file, if it is known.
    pub(super) fn at(mut self, span: Option<Span>) -> Finding {
        self.span = span;
        self
    }

    /// Adds a measurement. Non-finite values are omitted.
    pub(super) fn measure(mut self, name: &'static str, value: f64, unit: &'static str) -> Finding {
        if value.is_finite() {
            self.measured.push(Measure { name, value, unit });
        }
        self
    }
}

/// Sorts by severity, weight, code and text, so that the order is deterministic.
pub(super) fn sort(findings: &mut [Finding]) {
    findings.sort_by(|a, b| {
        let order = a.severity.cmp(&b.severity).then(b.weight.total_cmp(&a.weight));
        order.then(a.code.cmp(b.code)).then(a.what.cmp(&b.what))
    });
}

/// A number with about three significant digits.
pub(super) fn short(v: f64) -> String {
    let a = v.abs();
    if v == 0.0 || !v.is_finite() {
        return format!("{v}");
    }
    if !(1e-3..1e5).contains(&a) {
        return format!("{v:.2e}");
    }
    let digits = if a >= 100.0 {
        0
    } else if a >= 10.0 {
        1
    } else if a >= 1.0 {
        2
    } else {
        4
    };
    let text = format!("{v:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// The number that [`short`] shows.
pub(super) fn rounded(v: f64) -> f64 {
    short(v).parse().unwrap_or(v)
}

/// A fraction as a percentage.
pub(super) fn percent(v: f64) -> String {
    let p = 100.0 * v;
    if p > 0.0 && p < 0.1 {
        "under 0.1 %".to_owned()
    } else if p >= 10.0 || p == 0.0 {
        format!("{p:.0} %")
    } else {
        format!("{p:.1} %")
    }
}
