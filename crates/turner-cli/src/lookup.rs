//! `turner help WORD`: everything with this name: types, keys, values, sections, options, error codes, colours, and
//! words of other programs.

use std::collections::BTreeSet;

use clap::{Arg, Command};
use turner::color::NAMES;
use turner::schema::{ErrorCode, foreign};

use crate::reference::{self, Chapter, Key, Page};
use crate::text::wrap;
use crate::{error_pages, flags};

/// The help on a word; `None` if it is unknown.
pub(crate) fn explain(word: &str, cli: &Command) -> Option<String> {
    let name = word.trim_start_matches('-');
    let mut parts = Vec::new();
    parts.extend(error_pages::page(word).map(error_pages::text));
    if !word.starts_with('-') {
        parts.extend(reference::explain(name));
        parts.extend(keys(name));
        parts.extend(values(name));
        parts.extend(color(name));
    }
    parts.extend(option(word, cli));
    parts.extend(foreign_word(word));
    (!parts.is_empty()).then(|| parts.join("\n\n"))
}

/// Every word that [`explain`] knows, without those of other programs.
pub(crate) fn words(cli: &Command) -> BTreeSet<String> {
    let mut words: BTreeSet<String> = reference::names().into_iter().map(str::to_owned).collect();
    for key in reference::chapters().into_iter().flat_map(pages).flat_map(|(_, page)| page.keys) {
        words.extend(key.words.iter().map(|(word, _)| (*word).to_owned()));
        words.insert(key.name);
    }
    words.extend(ErrorCode::ALL.iter().map(|code| code.as_str().to_owned()));
    let options = cli.get_subcommands().flat_map(crate::usage::options);
    words.extend(options.map(|option| format!("--{option}")));
    words
}

/// The pages of a chapter, each with the lines that precede its keys in a scene.
fn pages(chapter: Chapter) -> Vec<(String, Page)> {
    let section = match chapter.heading {
        "Camera" => "[camera]",
        "Integrator" => "[integrator]",
        "Shapes" | "Models" => "[[object]]",
        "Materials" => "[material.NAME]",
        "Textures" => "[texture.NAME]",
        "Media" => "[medium.NAME]",
        "Lights" => "[[light]]",
        _ => "",
    };
    let head = |page: &Page| match section {
        "" if page.title.contains("[[") => format!("[[{}]]\n", page.name),
        "" if page.title.contains('[') => format!("[{}]\n", page.name),
        "" => String::new(),
        section => format!("{section}\ntype = \"{}\"\n", page.name),
    };
    std::iter::once(chapter.intro).chain(chapter.pages).map(|page| (head(&page), page)).collect()
}

/// A key with the same meaning on several pages.
struct Same {
    key: Key,
    titles: Vec<String>,
    example: String,
    option: Option<&'static str>,
}

fn keys(name: &str) -> Option<String> {
    let mut found: Vec<Same> = Vec::new();
    for (head, page) in reference::chapters().into_iter().flat_map(pages) {
        let Some(key) = page.keys.iter().find(|k| k.name == name) else { continue };
        let is_same = |s: &&mut Same| {
            s.key.kind == key.kind
                && s.key.doc == key.doc
                && s.key.default == key.default
                && s.key.range == key.range
        };
        match found.iter_mut().find(is_same) {
            Some(same) => same.titles.push(page.title.clone()),
            None => found.push(Same {
                key: key.clone(),
                titles: vec![page.title.clone()],
                example: example(&head, key, &page),
                option: flags::option(&path(&head, name)),
            }),
        }
    }
    if found.is_empty() {
        return None;
    }
    let mut out = format!("The key \"{name}\"\n");
    for same in &found {
        out += &format!("\n  {name}  {}\n", facts(&same.key));
        wrap(&mut out, &same.key.doc.replace('`', ""), 6);
        for (word, meaning) in same.key.words {
            wrap(&mut out, &format!("\"{word}\": {meaning}"), 10);
        }
        wrap(&mut out, &format!("Belongs to: {}.", same.titles.join(", ")), 6);
        if let Some(option) = same.option {
            wrap(&mut out, &format!("Option: {option}."), 6);
        }
        out.push('\n');
        for line in same.example.lines() {
            out += &format!("    {line}\n");
        }
    }
    Some(out)
}

/// `camera.fov` for a key after `[camera]`.
fn path(head: &str, key: &str) -> String {
    let section = head.lines().next().unwrap_or_default().trim_matches(['[', ']']);
    format!("{}.{key}", section.trim_end_matches(".NAME"))
}

/// Type, range, default and unit.
fn facts(key: &Key) -> String {
    let mut out = key.kind.clone();
    if let Some(range) = &key.range {
        out += &format!(", {range}");
    }
    out += &match key.default.as_deref() {
        None => "; required".to_owned(),
        Some("none") => "; optional".to_owned(),
        Some(default) => format!("; default {default}"),
    };
    const UNITS: &[&str] = &["degrees", "seconds", "pixels", "stops", "scene units", "nanometres"];
    let doc = key.doc.to_lowercase();
    if let Some(unit) = UNITS.iter().find(|u| doc.contains(*u)) {
        out += &format!("; unit: {unit}");
    }
    out
}

/// The key in its section: with the value of the page's example, otherwise with its default.
fn example(head: &str, key: &Key, page: &Page) -> String {
    let start = format!("{} = ", key.name);
    let lines = page.example.as_deref().unwrap_or_default().lines();
    let line = lines.map(str::trim).find(|l| l.starts_with(&start) && !l.ends_with(['[', '{']));
    let line = match (line, key.default.as_deref()) {
        (Some(line), _) => line.to_owned(),
        (None, None | Some("none")) => format!("{start}{}", key.kind),
        (None, Some(default)) => format!("{start}{default}"),
    };
    // The key `type` is part of the head.
    if key.name == "type" {
        format!("{}\n{line}", head.lines().next().unwrap_or_default())
    } else {
        head.to_owned() + &line
    }
}

fn values(word: &str) -> Option<String> {
    let mut rows: Vec<(String, &str, Vec<String>)> = Vec::new();
    for (_, page) in reference::chapters().into_iter().flat_map(pages) {
        for key in &page.keys {
            let Some((_, meaning)) = key.words.iter().find(|(w, _)| *w == word) else { continue };
            match rows.iter_mut().find(|(name, m, _)| *name == key.name && m == meaning) {
                Some((.., titles)) => titles.push(page.title.clone()),
                None => rows.push((key.name.clone(), meaning, vec![page.title.clone()])),
            }
        }
    }
    if rows.is_empty() {
        return None;
    }
    let mut out = format!("The value \"{word}\"\n");
    for (key, meaning, titles) in rows {
        out += &format!("\n  {key} = \"{word}\"  {}\n", titles.join(", "));
        wrap(&mut out, &meaning.replace('`', ""), 6);
    }
    Some(out)
}

fn color(word: &str) -> Option<String> {
    let (name, rgb) = NAMES.iter().find(|(name, _)| name.eq_ignore_ascii_case(word))?;
    Some(format!("The colour \"{name}\"\n\n  #{rgb:06x}  e.g. material = {{ color = \"{name}\" }}\n"))
}

/// The option, with the commands that have it. Options with the same name and different meanings are listed separately.
fn option(word: &str, cli: &Command) -> Option<String> {
    let mut found: Vec<(&Arg, Vec<&str>)> = Vec::new();
    for command in cli.get_subcommands() {
        let is = |arg: &&Arg| match word.strip_prefix("--") {
            Some(long) => arg.get_long_and_visible_aliases().is_some_and(|all| all.contains(&long)),
            None if word.starts_with('-') => arg.get_short().is_some_and(|s| word[1..] == s.to_string()),
            None => arg.get_long() == Some(word),
        };
        let Some(arg) = command.get_arguments().filter(|a| !a.is_hide_set()).find(is) else { continue };
        let help = |arg: &Arg| arg.get_help().map(ToString::to_string);
        match found.iter_mut().find(|(other, _)| help(other) == help(arg)) {
            Some((_, commands)) => commands.push(command.get_name()),
            None => found.push((arg, vec![command.get_name()])),
        }
    }
    let (first, _) = found.first()?;
    let long = first.get_long().unwrap_or_default();
    let mut out = format!("The option --{long}\n");
    for (arg, commands) in &found {
        let short = arg.get_short().map(|s| format!("-{s}, ")).unwrap_or_default();
        let value = arg.get_value_names().filter(|_| arg.get_action().takes_values());
        let value = value.map_or(String::new(), |names| format!(" {}", names.join(" ")));
        out += &format!("\n  {short}--{long}{value}  of {}\n", commands.join(", "));
        wrap(&mut out, &arg.get_help().map(ToString::to_string).unwrap_or_default().replace('`', ""), 6);
        let values = arg.get_possible_values();
        if !values.is_empty() && arg.get_action().takes_values() {
            let names: Vec<&str> = values.iter().map(|v| v.get_name()).collect();
            wrap(&mut out, &format!("Values: {}.", names.join(", ")), 6);
        }
        if let Some(key) = flags::key(&format!("--{long}")) {
            wrap(&mut out, &format!("Key of the scene: {key}."), 6);
        }
    }
    Some(out)
}

/// The remedies for a word of other programs.
fn foreign_word(word: &str) -> Option<String> {
    let mut out = String::new();
    for foreign in foreign::everywhere(word) {
        let within = foreign
            .within
            .first()
            .map_or("anywhere", |w| w.trim_matches(['[', ']']))
            .replace("a model", "model");
        out += &format!("\n  {within}  {}\n", foreign.remedy.replace('`', ""));
    }
    if let Some(remedy) = crate::foreign::option(word) {
        out += &format!("\n  option  {}\n", remedy.replace('`', ""));
    }
    (!out.is_empty()).then(|| format!("\"{}\" of other programs\n{out}", turner::schema::error::escape(word)))
}
