//! Undo and redo: descriptions before and after steps.

use std::collections::VecDeque;
use std::sync::Arc;

use turner::SceneDesc;

/// Steps that are kept.
const MOST: usize = 500;

struct Step {
    label: String,
    merge: Option<String>,
    /// The description on the other side of the step.
    desc: Arc<SceneDesc>,
}

#[derive(Default)]
pub(super) struct History {
    undo: VecDeque<Step>,
    redo: Vec<Step>,
    /// Whether the next change may join the last step.
    is_open: bool,
}

impl History {
    /// A change was made to `before`.
    pub(super) fn push(&mut self, label: &str, merge: Option<&str>, before: Arc<SceneDesc>) {
        self.redo.clear();
        let last = self.undo.back().and_then(|step| step.merge.as_deref());
        if self.is_open && merge.is_some() && last == merge {
            return;
        }
        self.is_open = true;
        if self.undo.len() == MOST {
            self.undo.pop_front();
        }
        self.undo.push_back(Step { label: label.to_owned(), merge: merge.map(str::to_owned), desc: before });
    }

    pub(super) fn end_gesture(&mut self) {
        self.is_open = false;
    }

    pub(super) fn undo(&mut self, now: &Arc<SceneDesc>) -> Option<(String, Arc<SceneDesc>)> {
        self.is_open = false;
        let Step { label, merge, desc } = self.undo.pop_back()?;
        self.redo.push(Step { label: label.clone(), merge, desc: Arc::clone(now) });
        Some((label, desc))
    }

    pub(super) fn redo(&mut self, now: &Arc<SceneDesc>) -> Option<(String, Arc<SceneDesc>)> {
        self.is_open = false;
        let Step { label, merge, desc } = self.redo.pop()?;
        self.undo.push_back(Step { label: label.clone(), merge, desc: Arc::clone(now) });
        Some((label, desc))
    }

    pub(super) fn labels(&self) -> (Vec<&str>, Vec<&str>) {
        let undo = self.undo.iter().map(|step| step.label.as_str()).collect();
        (undo, self.redo.iter().rev().map(|step| step.label.as_str()).collect())
    }
}
