//! Tests of all integrators.

use super::*;

#[test]
fn integrators_go_by_their_names_in_a_scene() {
    for entry in IntegratorDesc::DOC.entries {
        let desc = IntegratorDesc::of_type(entry.name).unwrap_or_default();
        assert_eq!(desc.integrator().name(), entry.name);
    }
}
