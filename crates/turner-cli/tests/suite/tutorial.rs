//! Follows docs/tutorial/first-scene.md from an empty file: each step gives the file in scenes/tutorial/first.

use crate::sh_blocks::root;

/// The sections of a scene: from a line that begins with a bracket to the next one.
fn sections(text: &str) -> Vec<String> {
    let mut out: Vec<String> = vec![String::new()];
    for line in text.lines() {
        if line.starts_with('[') && out.last().is_some_and(|s| !is_comment(s)) {
            out.push(String::new());
        }
        let last = out.last_mut().unwrap();
        if !(last.is_empty() && line.is_empty()) {
            *last += line;
            *last += "\n";
        }
    }
    out.iter().map(|s| s.trim_matches('\n').to_owned()).filter(|s| !s.is_empty()).collect()
}

/// Whether there are only comments.
fn is_comment(section: &str) -> bool {
    section.lines().all(|line| line.is_empty() || line.starts_with('#'))
}

/// The section that the page names: "the `[film]` section", "the object `ball`", "the light `bulb`".
fn find(sections: &[String], what: &str) -> usize {
    let quoted = what.split('`').nth(1).unwrap_or_else(|| panic!("what is {what}?"));
    let is = |s: &&String| {
        if what.ends_with("section") {
            return s.lines().any(|line| line == quoted);
        }
        let head = if what.starts_with("the light") { "[[light]]" } else { "[[object]]" };
        s.starts_with(head) && s.lines().any(|line| line == format!("name = \"{quoted}\""))
    };
    let found: Vec<usize> = (0..sections.len()).filter(|i| is(&&sections[*i])).collect();
    assert_eq!(found.len(), 1, "{what}");
    found[0]
}

/// Carries out one instruction in bold print, with the block that follows it.
fn follow(text: &str, instruction: &str, block: Option<&str>) -> String {
    let mut all = sections(text);
    let target = |words: &str| instruction.strip_prefix(words).map(|rest| rest.trim_end_matches(['.', ':']));
    if let Some(list) = target("Remove ") {
        for what in list.split(", ").flat_map(|part| part.split(" and ")) {
            all.remove(find(&all, what));
        }
    } else if let Some(what) = target("Replace ") {
        let index = find(&all, what);
        all[index] = block.unwrap().to_owned();
    } else {
        assert!(target("Add at the end").is_some(), "an instruction that nobody can follow: {instruction}");
        all.push(block.unwrap().to_owned());
    }
    all.join("\n\n") + "\n"
}

#[test]
fn who_follows_the_first_tutorial_gets_its_files() {
    let page = std::fs::read_to_string(root().join("docs/tutorial/first-scene.md")).unwrap();
    let mut text = String::new();
    let (mut step, mut steps) = (0, 0);
    let mut waiting: Option<String> = None;
    let mut block: Option<String> = None;
    let check = |step: usize, text: &str| {
        let file = root().join(format!("scenes/tutorial/first/step-{step}.toml"));
        let kept = std::fs::read_to_string(file).unwrap().replace("\r\n", "\n");
        assert_eq!(sections(text), sections(&kept), "step {step}");
    };
    for line in page.lines().map(str::trim_end) {
        if let Some(heading) = line.strip_prefix("## ") {
            if step > 0 {
                check(step, &text);
                steps += 1;
            }
            step = heading.split('.').next().and_then(|n| n.parse().ok()).unwrap_or(0);
        } else if step == 0 {
        } else if line == "```toml" {
            block = Some(String::new());
        } else if line == "```"
            && let Some(block) = block.take()
        {
            let instruction = waiting.take().unwrap_or_else(|| panic!("where does this go?\n{block}"));
            text = follow(&text, &instruction, Some(block.trim_end()));
        } else if let Some(block) = &mut block {
            *block += line;
            *block += "\n";
        } else if let Some(bold) = line.strip_prefix("**").and_then(|l| l.strip_suffix("**")) {
            if bold.starts_with("Remove ") {
                text = follow(&text, bold, None);
            } else {
                assert!(waiting.replace(bold.to_owned()).is_none(), "nothing follows this instruction");
            }
        }
    }
    assert_eq!(steps, 8);
}
