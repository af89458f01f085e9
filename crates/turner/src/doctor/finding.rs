//! What was found.

use crate::schema::Remedy;
use crate::schema::value::Data;

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The picture is not what anyone can have wanted.
    Error,
    /// Something in it is likely to be wrong, or to cost much.
    Warning,
    /// Worth knowing.
    Note,
}

impl Severity {
    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Note => "note",
        }
    }
}

/// What a finding is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Question {
    /// Why it is black, or nothing is in it.
    Black,
    /// Why it is noisy.
    Noisy,
    /// Why it is washed out.
    WashedOut,
    /// Why it takes long.
    Slow,
    /// What is broken in it.
    Broken,
}

impl Question {
    /// In a word.
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

/// A number that was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Measure {
    /// What, in kebab-case.
    pub name: &'static str,
    /// How much; finite.
    pub value: f64,
    /// Its unit: `share` (0 to 1), `count`, `stops`, `degrees`, `units` of the scene, `radiance`, `irradiance`, `pixels`, `ratio`, `relmse`.
    pub unit: &'static str,
}

/// Something found.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Its name, which stays the same from version to version.
    pub code: &'static str,
    /// How bad it is.
    pub severity: Severity,
    /// What it is about.
    pub question: Question,
    /// How much it matters among those of its severity: 0 to 1.
    pub weight: f64,
    /// What is wrong, in a sentence that names the thing.
    pub what: String,
    /// Why it has this effect.
    pub why: String,
    /// What to do about it.
    pub remedy: String,
    /// The same as data, where a program can do it: each of them alone.
    pub remedies: Vec<Remedy>,
    /// What it rests on.
    pub measured: Vec<Measure>,
    /// The thing's name, as the scene has it; of several the first.
    pub subject: Option<String>,
}

impl Finding {
    /// One without numbers so far.
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

    /// A remedy as data.
    pub(super) fn or(mut self, remedy: Remedy) -> Finding {
        self.remedies.push(remedy);
        self
    }

    /// The remedy of one value of the scene.
    pub(super) fn set(self, key: &str, value: impl Into<Data>) -> Finding {
        self.or(Remedy::set(key, value))
    }

    pub(super) fn about(mut self, subject: impl Into<String>) -> Finding {
        self.subject = Some(subject.into());
        self
    }

    /// A number; what is not finite is left out.
    pub(super) fn measure(mut self, name: &'static str, value: f64, unit: &'static str) -> Finding {
        if value.is_finite() {
            self.measured.push(Measure { name, value, unit });
        }
        self
    }
}

/// The worst first; among equals those that matter most, and then by code, so that the order is always the same.
pub(super) fn sort(findings: &mut [Finding]) {
    findings.sort_by(|a, b| {
        let order = a.severity.cmp(&b.severity).then(b.weight.total_cmp(&a.weight));
        order.then(a.code.cmp(b.code)).then(a.what.cmp(&b.what))
    });
}

/// A number with three digits.
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

/// A share as a percentage.
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
