//! Counts what glTF cannot represent.

use std::collections::BTreeMap;

use turner::schema::{Warning, WarningKind};

/// Remarks with their counts.
#[derive(Debug, Default)]
pub(super) struct Remarks(BTreeMap<(WarningKind, &'static str), u64>);

impl Remarks {
    /// Something that is omitted.
    pub(super) fn ignored(&mut self, what: &'static str) {
        *self.0.entry((WarningKind::Ignored, what)).or_default() += 1;
    }

    /// Something that is approximated.
    pub(super) fn approximated(&mut self, what: &'static str) {
        *self.0.entry((WarningKind::Approximated, what)).or_default() += 1;
    }

    /// Converts to warnings.
    pub(super) fn warnings(self) -> Vec<Warning> {
        let warning = |((kind, what), count): ((WarningKind, &str), u64)| Warning {
            count,
            ..Warning::new(kind, format!("not representable in glTF: {what}"))
        };
        self.0.into_iter().map(warning).collect()
    }
}
