//! The number of shapes of a scene, with instances flattened.

use crate::description::{ObjectContent, ObjectDesc, SceneDesc};
use crate::schema::error::escape;
use crate::schema::{ErrorCode, GroupId, SceneError};

/// The maximum number of shapes of a scene, with instances flattened.
const MAX_PRIMITIVES: u64 = 1 << 24;

impl SceneDesc {
    /// Number of shapes with instances flattened, computed without flattening.
    ///
    /// Errors: groups that contain themselves; more than [`MAX_PRIMITIVES`].
    pub(super) fn count_primitives(&self) -> Result<u64, SceneError> {
        #[derive(Clone, Copy, PartialEq)]
        enum State {
            New,
            Open,
            Done(u64),
        }
        let mut states = vec![State::New; self.groups.len()];
        let placed = |objects: &[ObjectDesc], states: &[State]| {
            objects.iter().filter(|o| !o.hidden).fold(0u64, |sum, o| {
                sum.saturating_add(match o.content {
                    ObjectContent::Shape(_) => 1,
                    ObjectContent::Instance(g) => match states[g.index()] {
                        // An empty group still takes time to place.
                        State::Done(n) => n.saturating_add(1),
                        _ => 0,
                    },
                })
            })
        };
        let children = |objects: &[ObjectDesc]| {
            objects
                .iter()
                .filter_map(|o| match o.content {
                    ObjectContent::Instance(g) => Some((g, o.span)),
                    ObjectContent::Shape(_) => None,
                })
                .collect::<Vec<_>>()
        };
        // Depth-first with an explicit stack: groups may be nested a hundred thousand deep.
        for start in 0..self.groups.len() {
            let mut stack = vec![(GroupId(start as u32), None)];
            while let Some((g, span)) = stack.pop() {
                match states[g.index()] {
                    State::Done(_) => {}
                    State::Open => {
                        states[g.index()] =
                            State::Done(placed(&self.groups[g.index()].value.objects, &states));
                    }
                    State::New => {
                        states[g.index()] = State::Open;
                        stack.push((g, span));
                        for (child, child_span) in children(&self.groups[g.index()].value.objects) {
                            if states[child.index()] == State::Open {
                                let name = self.groups[child.index()].name.as_deref().unwrap_or("?");
                                let message = format!("the group \"{}\" contains itself", escape(name));
                                return Err(SceneError::new(ErrorCode::Cycle, message).or_at(child_span));
                            }
                            stack.push((child, child_span));
                        }
                    }
                }
            }
        }
        let total = placed(&self.objects, &states);
        if total > MAX_PRIMITIVES {
            let message = format!("the scene has {total} objects and instances, more than {MAX_PRIMITIVES}");
            return Err(SceneError::new(ErrorCode::TooLarge, message));
        }
        Ok(total)
    }
}
