//! What an import has to say: remarks summed by kind.

use std::collections::BTreeMap;

use turner::schema::{Warning, WarningKind};

/// Remarks and how often each was made.
#[derive(Debug, Default)]
pub(super) struct Report {
    remarks: BTreeMap<(WarningKind, String), u64>,
}

impl Report {
    /// One more remark of this text.
    pub(super) fn add(&mut self, kind: WarningKind, message: impl Into<String>) {
        self.add_many(kind, message, 1);
    }

    /// `count` more remarks of this text; none if it is 0.
    pub(super) fn add_many(&mut self, kind: WarningKind, message: impl Into<String>, count: u64) {
        if count > 0 {
            let sum = self.remarks.entry((kind, message.into())).or_default();
            *sum = sum.saturating_add(count);
        }
    }

    /// Something that has no effect on the picture.
    pub(super) fn ignored(&mut self, message: impl Into<String>) {
        self.add(WarningKind::Ignored, message);
    }

    /// Something that is shown in another way than asked for.
    pub(super) fn approximated(&mut self, message: impl Into<String>) {
        self.add(WarningKind::Approximated, message);
    }

    /// Something that is unlikely to be meant.
    pub(super) fn doubtful(&mut self, message: impl Into<String>) {
        self.add(WarningKind::Doubtful, message);
    }

    /// All remarks, sorted by kind and text.
    pub(super) fn into_warnings(self) -> Vec<Warning> {
        let warning = |((kind, message), count)| Warning { count, ..Warning::new(kind, message) };
        self.remarks.into_iter().map(warning).collect()
    }
}
