//! The instruction set that an environment variable selects.

use turner_bvh::InstructionSet;

/// The environment variables that name an instruction set; the second is an older name.
const NAMES: [&str; 2] = ["TURNER_INSTRUCTION_SET", "TURNER_KERNEL"];

/// The instruction set named by `TURNER_INSTRUCTION_SET`: `scalar`, `neon`, `avx2` or `avx512`; the fastest one if the
/// variable is not set or names none that is available. Pictures do not depend on it.
pub fn instruction_set() -> InstructionSet {
    chosen(NAMES.iter().find_map(|name| std::env::var(name).ok()).as_deref())
}

fn chosen(name: Option<&str>) -> InstructionSet {
    name.and_then(InstructionSet::named).unwrap_or_else(InstructionSet::best)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_select_and_others_do_not() {
        for set in InstructionSet::available() {
            assert_eq!(chosen(Some(set.name())), set);
            assert_eq!(chosen(Some(&set.name().to_uppercase())), set);
        }
        for none in [None, Some(""), Some("abacus")] {
            assert_eq!(chosen(none), InstructionSet::best());
        }
    }
}
