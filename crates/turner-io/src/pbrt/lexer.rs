//! Tokens of pbrt's format: words, strings, brackets and numbers.

use turner::schema::ErrorCode;

use super::report::Fault;
use super::source::{Place, Source};
use crate::mesh::{parse_number, quick_number, quick_whole};
use crate::scene_import::push;

/// Most bytes of a word or a string.
const MAX_WORD: usize = 1 << 12;

/// The kind of the next token.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// A string in quotes.
    Quote,
    Open,
    Close,
    /// A directive, a number, `true` or `false`.
    Word,
    /// The end of the file.
    End,
}

/// Whether a byte ends a number or a word.
#[inline]
fn is_end(b: u8) -> bool {
    b.is_ascii_whitespace() || matches!(b, b'"' | b'[' | b']' | b'#')
}

/// One file as tokens.
pub(super) struct Lexer<'a> {
    source: Source<'a>,
}

impl<'a> Lexer<'a> {
    pub(super) fn new(source: Source<'a>) -> Lexer<'a> {
        Lexer { source }
    }

    /// Position of the next token, after [`Lexer::next`].
    pub(super) fn place(&mut self) -> Place {
        self.source.place()
    }

    fn fault(&mut self, problem: impl Into<String>) -> Fault {
        Fault::at(self.source.place(), ErrorCode::Syntax, problem)
    }

    fn rest(&mut self) -> Result<&[u8], Fault> {
        // Two calls: the borrow of a single one would extend over the error branch.
        if let Err(error) = self.source.rest() {
            return Err(self.fault(format!("the file cannot be read: {error}")).code(ErrorCode::File));
        }
        self.source.rest().map_err(|_| Fault::new(ErrorCode::File, "the file cannot be read"))
    }

    /// Skips whitespace and comments; returns the kind of the next token.
    #[inline]
    pub(super) fn next(&mut self) -> Result<Next, Fault> {
        let mut in_comment = false;
        loop {
            let rest = self.rest()?;
            if rest.is_empty() {
                return Ok(Next::End);
            }
            let mut skipped = 0;
            let mut found = None;
            for &b in rest {
                if in_comment {
                    in_comment = b != b'\n';
                } else if b == b'#' {
                    in_comment = true;
                } else if !b.is_ascii_whitespace() {
                    found = Some(b);
                    break;
                }
                skipped += 1;
            }
            self.source.skip(skipped);
            if let Some(b) = found {
                return Ok(match b {
                    b'"' => Next::Quote,
                    b'[' => Next::Open,
                    b']' => Next::Close,
                    _ => Next::Word,
                });
            }
        }
    }

    /// Skips a bracket.
    pub(super) fn bracket(&mut self) {
        self.source.skip(1);
    }

    /// A word, after [`Next::Word`].
    pub(super) fn word(&mut self) -> Result<String, Fault> {
        let mut word = Vec::new();
        loop {
            let rest = self.rest()?;
            let len = rest.iter().position(|b| is_end(*b)).unwrap_or(rest.len());
            let done = len < rest.len() || rest.is_empty();
            word.extend_from_slice(rest.get(..len).unwrap_or_default());
            self.source.skip(len);
            if word.len() > MAX_WORD {
                return Err(self.fault("a word of more than 4096 bytes"));
            }
            if done {
                return Ok(String::from_utf8_lossy(&word).into_owned());
            }
        }
    }

    /// The text between quotes, after [`Next::Quote`].
    pub(super) fn string(&mut self) -> Result<String, Fault> {
        self.source.place();
        self.source.skip(1);
        let mut text = Vec::new();
        let mut escaped = false;
        loop {
            let rest = self.rest()?;
            if rest.is_empty() {
                return Err(self.fault("a string is not closed: expected \"").help("close it with \""));
            }
            let (mut used, mut closed) = (0, false);
            for &b in rest {
                used += 1;
                match b {
                    _ if escaped => {
                        text.push(match b {
                            b'n' => b'\n',
                            b't' => b'\t',
                            b'r' => b'\r',
                            other => other,
                        });
                        escaped = false;
                    }
                    b'\\' => escaped = true,
                    b'"' => {
                        closed = true;
                        break;
                    }
                    _ => text.push(b),
                }
                if text.len() > MAX_WORD {
                    break;
                }
            }
            self.source.skip(used);
            if text.len() > MAX_WORD {
                return Err(self.fault("a string of more than 4096 bytes").help("is a \" missing?"));
            }
            if closed {
                return Ok(String::from_utf8_lossy(&text).into_owned());
            }
        }
    }

    /// A number, after [`Next::Word`].
    #[inline]
    pub(super) fn number(&mut self) -> Result<f64, Fault> {
        let rest = self.rest()?;
        if let Some((value, len)) = quick_number(rest)
            && rest.get(len).is_none_or(|b| is_end(*b))
        {
            self.source.skip(len);
            return Ok(value);
        }
        self.slow_number()
    }

    #[cold]
    fn slow_number(&mut self) -> Result<f64, Fault> {
        let place = self.source.place();
        let word = self.word()?;
        match parse_number(word.as_bytes()) {
            Some(value) if value.is_finite() => Ok(value),
            _ => Err(Fault::at(
                place,
                ErrorCode::Syntax,
                format!("expected a finite number, found {}", crate::assets::printable(&word)),
            )),
        }
    }

    /// An integer, after [`Next::Word`].
    #[inline]
    pub(super) fn integer(&mut self) -> Result<i32, Fault> {
        let rest = self.rest()?;
        let (value, len) = quick_whole(rest);
        if len > 0 && rest.get(len).is_none_or(|b| is_end(*b)) {
            self.source.skip(len);
            return Ok(value);
        }
        let place = self.source.place();
        let value = self.slow_number()?;
        if value.fract() == 0.0 && value.abs() <= f64::from(i32::MAX) {
            return Ok(value as i32);
        }
        Err(Fault::at(place, ErrorCode::Syntax, format!("expected an integer, found {value}")))
    }

    /// Parses consecutive numbers in the window, up to a token that needs the slow path.
    #[inline]
    fn run<T>(
        &mut self,
        parse: impl Fn(&[u8]) -> Option<(T, usize)>,
        mut take: impl FnMut(T) -> Result<(), &'static str>,
    ) -> Result<(), Fault> {
        let (mut at, mut problem) = (0, None);
        // The slow path reports errors of reading.
        if let Ok(rest) = self.source.rest() {
            while let Some(left) = rest.get(at..) {
                match left.first() {
                    Some(b' ' | b'\n' | b'\r' | b'\t') => at += 1,
                    Some(_) => {
                        let Some((value, len)) = parse(left) else { break };
                        if !left.get(len).is_some_and(|b| is_end(*b)) {
                            break;
                        }
                        at += len;
                        if let Err(p) = take(value) {
                            problem = Some(p);
                            break;
                        }
                    }
                    None => break,
                }
            }
        }
        self.source.skip(at);
        match problem {
            Some(p) => Err(self.fault(p).code(ErrorCode::TooLarge)),
            None => Ok(()),
        }
    }

    /// Appends numbers up to the first token that is not one.
    pub(super) fn numbers(&mut self, list: &mut Vec<f64>, limit: usize) -> Result<(), Fault> {
        self.run(quick_number, |v| push(list, v, limit))
    }

    /// Appends integers up to the first token that is not one.
    pub(super) fn integers(&mut self, list: &mut Vec<i32>, limit: usize) -> Result<(), Fault> {
        let parse = |text: &[u8]| Some(quick_whole(text)).filter(|(_, len)| *len > 0);
        self.run(parse, |v| push(list, v, limit))
    }

    /// Numbers up to a closing bracket in groups of `N`, in single precision; at most `limit` groups.
    pub(super) fn groups<const N: usize>(&mut self, limit: usize) -> Result<Vec<[f32; N]>, Fault> {
        let mut list: Vec<[f32; N]> = Vec::new();
        let (mut group, mut filled) = ([0.0; N], 0);
        let mut add = |list: &mut Vec<[f32; N]>, filled: &mut usize, v: f64| {
            if let Some(slot) = group.get_mut(*filled) {
                *slot = v as f32;
            }
            *filled += 1;
            if *filled < N {
                return Ok(());
            }
            *filled = 0;
            push(list, group, limit)
        };
        loop {
            self.run(quick_number, |v| add(&mut list, &mut filled, v))?;
            match self.next()? {
                Next::Word => {
                    let v = self.number()?;
                    add(&mut list, &mut filled, v).map_err(|p| self.fault(p).code(ErrorCode::TooLarge))?;
                }
                Next::Close if filled == 0 => {
                    self.bracket();
                    list.shrink_to_fit();
                    return Ok(list);
                }
                Next::Close => {
                    let count = list.len() * N + filled;
                    return Err(self.fault(format!("expected groups of {N} numbers, found {count} numbers")));
                }
                _ => return Err(self.fault("expected a number or ]")),
            }
        }
    }
}
