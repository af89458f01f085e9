//! A check before parsing: how deeply a text nests and how many tokens it has.
//!
//! The parser bounds brackets but not dotted keys, and merely dropping a table that is a million levels deep
//! overflows the stack. So the parser's lexer scans the text once and such files are refused.

use toml_parser::Source;
use toml_parser::lexer::TokenKind;
use turner::schema::value::{FileId, Span};
use turner::schema::{ErrorCode, SceneError};

use super::MAX_DEPTH;

/// Most tokens of one text, enough for about 2 million objects. A scene has one token per 3 to 5 bytes,
/// whitespace included; parsing takes some 100 bytes of memory per token.
const MAX_TOKENS: usize = 64_000_000;

/// Refuses a text that nests deeper than [`MAX_DEPTH`] or has too many tokens.
pub(super) fn check(text: &str, file: FileId) -> Result<(), SceneError> {
    check_with(text, file, MAX_TOKENS)
}

fn check_with(text: &str, file: FileId, max_tokens: usize) -> Result<(), SceneError> {
    // Dots of the last table header; then dots of the current key, for the line and for each open bracket.
    let mut header = 0;
    let mut open: Vec<usize> = vec![0];
    let (mut depth, mut is_header, mut line_is_blank) = (0, false, true);
    // Whether an `=` came since the last comma or line break, and whether a value came after it.
    let (mut has_equals, mut has_value) = (false, false);
    for (count, token) in Source::new(text).lex().enumerate() {
        let span = || Span { file, start: token.span().start() as u32, end: token.span().end() as u32 };
        if count >= max_tokens {
            let message = format!("the scene has more than {max_tokens} tokens");
            return Err(SceneError::at(ErrorCode::TooLarge, span(), message)
                .help("keep large data in mesh files, which are read faster"));
        }
        // Index of the innermost open bracket; 0 is the line itself.
        let top = open.len() - 1;
        match token.kind() {
            TokenKind::Dot => {
                open[top] += 1;
                depth += 1;
            }
            TokenKind::LeftSquareBracket | TokenKind::LeftCurlyBracket => {
                is_header |= line_is_blank && top == 0;
                // Brackets of a header do not nest; its dots count for the line.
                if !is_header {
                    open.push(0);
                    depth += 1;
                }
            }
            TokenKind::RightSquareBracket | TokenKind::RightCurlyBracket if !is_header && top > 0 => {
                depth -= 1 + open[top];
                open.pop();
            }
            TokenKind::Comma => {
                depth -= open[top];
                open[top] = 0;
            }
            // Inside brackets a key without its value continues over a line break.
            TokenKind::Newline if top > 0 && !(has_equals && has_value) => {}
            TokenKind::Newline => {
                depth -= open[top];
                if is_header {
                    header = open[0];
                }
                open[top] = 0;
                is_header = false;
            }
            _ => {}
        }
        (has_equals, has_value) = match token.kind() {
            TokenKind::Equals => (true, false),
            TokenKind::Comma | TokenKind::LeftCurlyBracket | TokenKind::LeftSquareBracket => (false, false),
            TokenKind::Whitespace | TokenKind::Comment | TokenKind::Newline => (has_equals, has_value),
            _ => (has_equals, true),
        };
        line_is_blank = match token.kind() {
            TokenKind::Newline => true,
            TokenKind::Whitespace => line_is_blank,
            _ => false,
        };
        if header + depth > MAX_DEPTH {
            let message = format!("tables and arrays nest deeper than {MAX_DEPTH}");
            return Err(SceneError::at(ErrorCode::TooLarge, span(), message)
                .help("a scene needs fewer than 10 levels; is a bracket not closed?"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ok(text: &str) -> bool {
        check(text, FileId(0)).is_ok()
    }

    #[test]
    fn deep_brackets_and_deep_keys_are_refused() {
        assert!(!ok(&format!("a = {}", "[".repeat(1_000_000))));
        assert!(!ok(&format!("a = {}", "{a=".repeat(1_000_000))));
        assert!(!ok(&format!("{}a = 1", "a.".repeat(1_000_000))));
        assert!(!ok(&format!("[{}a]", "\"a\" . ".repeat(1_000_000))));
        assert!(!ok(&format!("[[{}a]]", "a.".repeat(100))));
        let mixed = format!("[{}a]\n{}a = {{ {}a = 1 }}", "a.".repeat(30), "a.".repeat(30), "a.".repeat(30));
        assert!(!ok(&mixed));
    }

    #[test]
    fn dots_that_nest_nothing_are_free() {
        let row = "1.5, ".repeat(10_000);
        assert!(ok(&format!("a = [{row}]\nb = [{}]", "[1.5, 2.5],\n".repeat(10_000))));
        assert!(ok(&format!("a = \"{}\" # {}", "..[[".repeat(1000), "[.".repeat(1000))));
        assert!(ok(&"[a.b.c.d]\nx.y = 1.5\n".repeat(1000)));
        assert!(ok(&"[[object]]\n".repeat(1000)));
        assert!(ok("]]]]}}}}\n]"));
    }

    #[test]
    fn the_number_of_tokens_is_bounded() {
        let error = check_with("a = [1, 2, 3, 4, 5]", FileId(0), 10).unwrap_err();
        assert_eq!(error.code, ErrorCode::TooLarge);
    }
}
