//! Tokens in addresses.

/// 32 letters and digits that are not mistaken for one another.
const DIGITS: &[u8; 32] = b"abcdefghijkmnpqrstuvwxyz23456789";

/// Digits of a token: 130 bits.
const LENGTH: usize = 26;

/// A word that only those have to whom it was given.
#[derive(Clone)]
pub(crate) struct Token(String);

impl Token {
    /// A new one, from the random numbers of the system.
    ///
    /// Errors: the system gives none.
    pub(crate) fn new() -> std::io::Result<Token> {
        let mut bytes = [0; LENGTH];
        getrandom::fill(&mut bytes).map_err(|error| std::io::Error::other(error.to_string()))?;
        // 256 is a multiple of 32: all digits are equally likely.
        Ok(Token(bytes.iter().map(|b| char::from(DIGITS[usize::from(b % 32)])).collect()))
    }

    pub(crate) fn text(&self) -> &str {
        &self.0
    }

    /// Whether a word is this token. The time does not depend on how much of it is right.
    pub(crate) fn is(&self, word: &str) -> bool {
        let (own, word) = (self.0.as_bytes(), word.as_bytes());
        let differing = own.iter().zip(word).fold(0, |sum, (a, b)| std::hint::black_box(sum | (a ^ b)));
        own.len() == word.len() && differing == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_differ_and_only_the_whole_word_is_one() {
        let [a, b] = [Token::new().unwrap(), Token::new().unwrap()];
        assert_eq!(a.text().len(), LENGTH);
        assert!(a.is(a.text()) && !a.is(b.text()));
        assert!(!a.is("") && !a.is(&a.text()[1..]) && !a.is(&format!("{}a", a.text())));
    }
}
