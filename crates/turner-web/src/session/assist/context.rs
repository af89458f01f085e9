//! Where in a scene's text the cursor stands: in which table, at a key or at a value.
//!
//! The text is being written, so it may be no valid TOML. One pass from its start keeps the open brackets and skips
//! strings and comments.

use std::ops::Range;

/// What is written at the cursor.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Side {
    /// A header, such as `[film]`.
    Section,
    /// A key.
    Key,
    /// The value of a key.
    Value(String),
}

/// See the module.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Context {
    /// The keys that lead to the table: `object`, `material`. Names of parts follow their kinds: `material`, `gold`.
    pub(super) path: Vec<String>,
    /// The value of `type` in the same table, if it is written.
    pub(super) kind: Option<String>,
    /// The keys that the table has.
    pub(super) written: Vec<String>,
    pub(super) side: Side,
    /// The word at the cursor, in bytes.
    pub(super) word: Range<usize>,
}

/// An open table.
#[derive(Clone, Debug)]
struct Open {
    path: Vec<String>,
    /// The key whose value follows.
    key: Option<String>,
    is_list: bool,
    /// Where its contents begin.
    start: usize,
}

/// A piece of the text that is no blank.
#[derive(Clone, Debug, PartialEq)]
enum Token<'a> {
    Word(&'a str),
    Mark(char),
    NewLine,
}

/// The tokens with their ranges; comments are left out.
fn tokens(text: &str) -> Vec<(Token<'_>, Range<usize>)> {
    let bytes = text.as_bytes();
    let (mut out, mut at) = (Vec::new(), 0);
    while at < bytes.len() {
        let start = at;
        match bytes[at] {
            b'\n' => {
                out.push((Token::NewLine, at..at + 1));
                at += 1;
            }
            b'#' => at = text[at..].find('\n').map_or(text.len(), |end| at + end),
            quote @ (b'"' | b'\'') => {
                let triple = text[at..].starts_with("\"\"\"") || text[at..].starts_with("\'\'\'");
                at = string_end(bytes, at, quote, triple);
                out.push((Token::Word(&text[start..at]), start..at));
            }
            mark @ (b'[' | b']' | b'{' | b'}' | b',' | b'=') => {
                out.push((Token::Mark(char::from(mark)), at..at + 1));
                at += 1;
            }
            byte if byte.is_ascii_whitespace() => at += 1,
            _ => {
                let ends = |byte: &u8| byte.is_ascii_whitespace() || b"[]{},=#\"'".contains(byte);
                at = bytes[at..].iter().position(ends).map_or(bytes.len(), |end| at + end);
                out.push((Token::Word(&text[start..at]), start..at));
            }
        }
    }
    out
}

/// The end of a string that begins at `at`; one without an end ends with its line.
fn string_end(bytes: &[u8], at: usize, quote: u8, triple: bool) -> usize {
    let mut i = at + if triple { 3 } else { 1 };
    while i < bytes.len() {
        match bytes[i] {
            b'\\' if quote == b'"' => i += 1,
            b'\n' if !triple => return i,
            byte if byte == quote && !triple => return i + 1,
            byte if byte == quote && bytes[i..].starts_with(&[quote; 3]) => return i + 3,
            _ => {}
        }
        i += 1;
    }
    // A backslash at the end steps beyond it.
    bytes.len()
}

fn parts(key: &str) -> Vec<String> {
    turner::schema::KeyPart::split(key).into_iter().map(|part| part.key).collect()
}

impl Context {
    /// The context of a byte of the text.
    pub(super) fn at(text: &str, at: usize) -> Context {
        let tokens = tokens(text);
        // The word that the cursor touches belongs to what is being written.
        let touched = tokens
            .iter()
            .find(|(token, range)| matches!(token, Token::Word(_)) && range.start <= at && at <= range.end);
        let word = touched.map_or(at..at, |(_, range)| range.clone());
        let mut open = vec![Open { path: Vec::new(), key: None, is_list: false, start: 0 }];
        let mut header: Option<usize> = None;
        let mut line_is_empty = true;
        for (i, (token, range)) in tokens.iter().enumerate() {
            if range.start >= word.start {
                break;
            }
            match token {
                Token::Mark('[') if open.len() == 1 && line_is_empty => header = Some(range.end),
                Token::Mark('[') if header.is_some() => header = Some(range.end),
                Token::Mark(']') if let Some(start) = header => {
                    if text[start..range.start].trim().is_empty() {
                        continue;
                    }
                    let name = text[start..range.start].trim().trim_start_matches('[');
                    open = vec![Open { path: parts(name), key: None, is_list: false, start: range.end }];
                    header = None;
                    // The second bracket of `[[object]]` follows.
                    if let Some((Token::Mark(']'), second)) = tokens.get(i + 1) {
                        open[0].start = second.end;
                    }
                }
                Token::Mark(mark @ ('[' | '{')) => {
                    let of = open.last().map(|own| (own.path.clone(), own.key.clone()));
                    let (mut path, key) = of.unwrap_or_default();
                    path.extend(key.iter().flat_map(|key| parts(key)));
                    open.push(Open { path, key: None, is_list: *mark == '[', start: range.end });
                }
                Token::Mark(']' | '}') if open.len() > 1 => {
                    open.pop();
                }
                Token::Mark(',') => {
                    if let Some(own) = open.last_mut() {
                        own.key = None;
                    }
                }
                Token::Mark('=') => {
                    let before = i.checked_sub(1).and_then(|i| tokens.get(i));
                    if let (Some(own), Some((Token::Word(key), _))) = (open.last_mut(), before) {
                        own.key = Some((*key).to_owned());
                    }
                }
                Token::NewLine => {
                    header = None;
                    if open.len() == 1 {
                        open[0].key = None;
                    }
                }
                Token::Word(_) | Token::Mark(_) => {}
            }
            line_is_empty = *token == Token::NewLine;
        }
        let own =
            open.last().cloned().unwrap_or(Open { path: Vec::new(), key: None, is_list: false, start: 0 });
        let side = match (&own.key, header) {
            (_, Some(_)) => Side::Section,
            (Some(key), _) => Side::Value(key.trim_matches('"').to_owned()),
            // A value of a list is one of the list's key.
            (None, _) if own.is_list => Side::Value(own.path.last().cloned().unwrap_or_default()),
            (None, _) if open.len() == 1 && text[..word.start].ends_with('[') => Side::Section,
            (None, _) => Side::Key,
        };
        let (kind, written) = contents(&tokens, own.start, open.len() == 1);
        let mut path = own.path;
        if own.is_list && matches!(side, Side::Value(_)) {
            path.pop();
        }
        Context { path, kind, written, side, word }
    }
}

/// The type and the keys of the table whose contents begin at `start`.
fn contents(
    tokens: &[(Token<'_>, Range<usize>)],
    start: usize,
    is_section: bool,
) -> (Option<String>, Vec<String>) {
    let (mut kind, mut written, mut depth) = (None, Vec::new(), 0_usize);
    let mut line_is_empty = false;
    for window in tokens.windows(3).skip_while(|window| window[0].1.start < start) {
        let [(first, _), (second, _), (third, _)] = window else { break };
        match (first, second) {
            (Token::Mark('['), _) if depth == 0 && is_section && line_is_empty => break,
            (Token::Mark('[' | '{'), _) => depth += 1,
            (Token::Mark(']' | '}'), _) if depth == 0 => break,
            (Token::Mark(']' | '}'), _) => depth -= 1,
            (Token::Word(key), Token::Mark('=')) if depth == 0 => {
                let key = key.trim_matches('"').to_owned();
                if key == "type"
                    && let Token::Word(value) = third
                {
                    kind = Some(value.trim_matches(['"', '\'']).to_owned());
                }
                written.push(key);
            }
            _ => {}
        }
        line_is_empty = *first == Token::NewLine;
    }
    (kind, written)
}
