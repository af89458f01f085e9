//! The import report: warnings counted by kind and text.

use std::collections::BTreeMap;

use turner::schema::{Warning, WarningKind};

/// Warnings and how often each occurred.
#[derive(Debug, Default)]
pub(super) struct Report {
    remarks: BTreeMap<(WarningKind, String), u64>,
}

impl Report {
    /// Adds a warning.
    pub(super) fn add(&mut self, kind: WarningKind, message: impl Into<String>) {
        self.add_many(kind, message, 1);
    }

    /// Adds a warning `count` times; nothing if 0.
    pub(super) fn add_many(&mut self, kind: WarningKind, message: impl Into<String>, count: u64) {
        if count > 0 {
            let sum = self.remarks.entry((kind, message.into())).or_default();
            *sum = sum.saturating_add(count);
        }
    }

    /// Something without effect on the picture.
    pub(super) fn ignored(&mut self, message: impl Into<String>) {
        self.add(WarningKind::Ignored, message);
    }

    /// Something rendered differently from what the file specifies.
    pub(super) fn approximated(&mut self, message: impl Into<String>) {
        self.add(WarningKind::Approximated, message);
    }

    /// Something that is probably a mistake in the file.
    pub(super) fn doubtful(&mut self, message: impl Into<String>) {
        self.add(WarningKind::Doubtful, message);
    }

    /// All warnings, sorted by kind and text.
    pub(super) fn into_warnings(self) -> Vec<Warning> {
        let warning = |((kind, message), count)| Warning { count, ..Warning::new(kind, message) };
        self.remarks.into_iter().map(warning).collect()
    }
}
