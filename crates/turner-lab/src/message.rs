//! What other programs say, in messages.

use turner::schema::error::escape;

/// Longer texts are shortened to this number of characters.
const LONGEST: usize = 480;
/// `escape` shortens longer texts.
const PIECE: usize = 80;

/// In one line, without characters that control a terminal.
pub(crate) fn one_line(text: &str) -> String {
    let words: Vec<&str> = text.split_whitespace().collect();
    let characters: Vec<char> = words.join(" ").chars().collect();
    let shown = characters.get(..LONGEST).unwrap_or(&characters);
    let mut out: String =
        shown.chunks(PIECE).map(|piece| escape(&piece.iter().collect::<String>())).collect();
    if characters.len() > LONGEST {
        out.push('…');
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_are_one_line() {
        let text = format!("line 1:\n  - {}\u{1b}[2J", "ä".repeat(200));
        let shown = one_line(&text);
        assert_eq!(shown, format!("line 1: - {}\\u{{1b}}[2J", "ä".repeat(200)));
        let long = one_line(&"word ".repeat(1_000));
        assert_eq!(long.chars().count(), LONGEST + 1);
        assert!(long.ends_with('…'));
    }
}
