//! What glTF cannot hold, counted.

use std::collections::BTreeMap;

use turner::schema::{Warning, WarningKind};

/// Remarks, equal ones once.
#[derive(Debug, Default)]
pub(super) struct Remarks(BTreeMap<(WarningKind, &'static str), u64>);

impl Remarks {
    /// Something that is not written.
    pub(super) fn ignored(&mut self, what: &'static str) {
        *self.0.entry((WarningKind::Ignored, what)).or_default() += 1;
    }

    /// Something that is written in another way.
    pub(super) fn approximated(&mut self, what: &'static str) {
        *self.0.entry((WarningKind::Approximated, what)).or_default() += 1;
    }

    /// As warnings.
    pub(super) fn warnings(self) -> Vec<Warning> {
        let warning = |((kind, what), count): ((WarningKind, &str), u64)| Warning {
            count,
            ..Warning::new(kind, format!("glTF has no words for: {what}"))
        };
        self.0.into_iter().map(warning).collect()
    }
}
