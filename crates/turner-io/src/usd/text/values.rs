//! Values of text layers.

use std::collections::BTreeMap;

use super::types::{Base, Type};
use super::{MAX_DEPTH, Parser};
use crate::usd::paths::resolve;
use crate::usd::value::{Read, Reference, Value};

impl Parser<'_> {
    /// A value of a type.
    pub(super) fn value(&mut self, kind: Type) -> Read<Value> {
        if self.lexer.take_word("None") {
            return Ok(Value::Blocked);
        }
        match (kind.base, kind.is_array) {
            (Base::Bool | Base::Int, false) if kind.width == 1 => self.integer().map(|v| match kind.base {
                Base::Bool => Value::Bool(v != 0),
                _ => Value::Int(v),
            }),
            (Base::Bool | Base::Int, true) => {
                let mut list = Vec::new();
                self.flat(kind, |this| {
                    list.push(this.integer()?);
                    Ok(())
                })?;
                self.check_width(list.len(), kind.width)?;
                Ok(Value::Ints(list))
            }
            (Base::Single, false) if kind.width == 1 => self.single().map(|v| Value::Real(f64::from(v))),
            (Base::Double, false) if kind.width == 1 => self.real().map(Value::Real),
            (Base::Single, true) => {
                let mut list: Vec<f32> = Vec::new();
                self.flat(kind, |this| {
                    list.push(this.single()?);
                    Ok(())
                })?;
                self.check_width(list.len(), kind.width)?;
                Ok(Value::Floats(kind.width, list))
            }
            (Base::Double | Base::Single | Base::Int | Base::Bool, _) => {
                let mut list: Vec<f64> = Vec::new();
                // As single-precision numbers are stored in binary layers.
                self.flat(kind, |this| {
                    let value = match kind.base {
                        Base::Single => f64::from(this.single()?),
                        _ => this.real()?,
                    };
                    list.push(value);
                    Ok(())
                })?;
                self.check_width(list.len(), kind.width)?;
                if kind.is_array {
                    return Ok(Value::Doubles(kind.width, list));
                }
                if list.len() != kind.width {
                    return Err(self.lexer.broken(format!("expected {} numbers", kind.width)));
                }
                Ok(Value::Vector(list))
            }
            (Base::Text, false) => self.lexer.string().map(Value::Text),
            (Base::Asset, false) => self.lexer.asset().map(Value::Asset),
            (Base::Text, true) => self.texts().map(Value::Texts),
            (Base::Asset, true) => {
                self.lexer.expect(b'[')?;
                let mut list = Vec::new();
                while !self.lexer.take(b']') {
                    list.push(self.lexer.asset()?);
                    self.lexer.take(b',');
                }
                Ok(Value::Texts(list))
            }
            (Base::Dictionary, _) => self.dictionary(0).map(Value::Dictionary),
            (Base::Unknown, _) => {
                self.any(0)?;
                Ok(Value::Other)
            }
        }
    }

    /// Numbers in round and square brackets, without regard to their nesting.
    fn flat(&mut self, kind: Type, mut push: impl FnMut(&mut Self) -> Read<()>) -> Read<()> {
        let mut open = 0_u32;
        loop {
            match self.lexer.peek() {
                b'[' | b'(' => {
                    open += 1;
                    self.lexer.at += 1;
                    if open > MAX_DEPTH {
                        return Err(self.lexer.broken("too many brackets"));
                    }
                }
                b']' | b')' => {
                    if open == 0 {
                        return Err(self.lexer.unexpected("a value"));
                    }
                    open -= 1;
                    self.lexer.at += 1;
                    if open == 0 {
                        return Ok(());
                    }
                }
                b',' if open > 0 => self.lexer.at += 1,
                _ if open == 0 => {
                    let wanted = if kind.is_array { "\"[\"" } else { "\"(\"" };
                    return Err(self.lexer.unexpected(wanted));
                }
                _ => push(self)?,
            }
        }
    }

    fn check_width(&self, count: usize, width: usize) -> Read<()> {
        if count.is_multiple_of(width) {
            return Ok(());
        }
        Err(self.lexer.broken(format!("{count} numbers are not vectors of {width}")))
    }

    fn integer(&mut self) -> Read<i64> {
        let text = self.lexer.number()?;
        match text {
            "true" | "True" | "yes" => return Ok(1),
            "false" | "False" | "no" => return Ok(0),
            _ => {}
        }
        if let Ok(v) = text.parse::<i64>() {
            return Ok(v);
        }
        match text.parse::<f64>() {
            Ok(v) => Ok(v as i64),
            Err(_) => Err(self.lexer.broken(format!("{text:?} is not a number"))),
        }
    }

    fn real(&mut self) -> Read<f64> {
        let text = self.lexer.number()?;
        text.parse().map_err(|_| self.lexer.broken(format!("{text:?} is not a number")))
    }

    fn single(&mut self) -> Read<f32> {
        let text = self.lexer.number()?;
        text.parse().map_err(|_| self.lexer.broken(format!("{text:?} is not a number")))
    }

    /// Strings in square brackets, or one.
    pub(super) fn texts(&mut self) -> Read<Vec<String>> {
        if self.lexer.take_word("None") {
            return Ok(Vec::new());
        }
        if !self.lexer.take(b'[') {
            return Ok(vec![self.lexer.string()?]);
        }
        let mut list = Vec::new();
        while !self.lexer.take(b']') {
            list.push(self.lexer.string()?);
            self.lexer.take(b',');
        }
        Ok(list)
    }

    /// `{ 0: value, 1: value }`, sorted by time.
    pub(super) fn samples(&mut self, kind: Type) -> Read<Vec<(f64, Value)>> {
        self.lexer.expect(b'{')?;
        let mut samples = Vec::new();
        while !self.lexer.take(b'}') {
            let time = self.real()?;
            self.lexer.expect(b':')?;
            samples.push((time, self.value(kind)?));
            self.lexer.take(b',');
        }
        samples.retain(|(time, _)| time.is_finite());
        samples.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        Ok(samples)
    }

    /// `{ type name = value … }`.
    pub(super) fn dictionary(&mut self, depth: u32) -> Read<BTreeMap<String, Value>> {
        if depth > MAX_DEPTH {
            return Err(self.lexer.broken(format!("dictionaries nested more than {MAX_DEPTH} deep")));
        }
        self.lexer.expect(b'{')?;
        let mut entries = BTreeMap::new();
        while !self.lexer.take(b'}') {
            let kind = self.lexer.word();
            let is_array = self.lexer.take(b'[');
            if is_array {
                self.lexer.expect(b']')?;
            }
            let name = match self.lexer.peek() {
                b'"' | b'\'' => self.lexer.string()?,
                _ => self.lexer.word().to_owned(),
            };
            self.lexer.expect(b'=')?;
            let value = match kind {
                "dictionary" => Value::Dictionary(self.dictionary(depth + 1)?),
                _ => self.value(Type::of(kind, is_array))?,
            };
            entries.insert(name, value);
            self.lexer.take(b',');
        }
        Ok(entries)
    }

    /// A value whose type is unknown.
    pub(super) fn any(&mut self, depth: u32) -> Read<Value> {
        if depth > MAX_DEPTH {
            return Err(self.lexer.broken(format!("values nested more than {MAX_DEPTH} deep")));
        }
        match self.lexer.peek() {
            b'"' | b'\'' => self.lexer.string().map(Value::Text),
            b'@' => self.lexer.asset().map(Value::Asset),
            b'<' => self.lexer.path().map(Value::Text),
            b'{' => {
                self.braces(depth)?;
                Ok(Value::Other)
            }
            open @ (b'[' | b'(') => {
                let close = if open == b'[' { b']' } else { b')' };
                self.lexer.at += 1;
                let mut items = Vec::new();
                while !self.lexer.take(close) {
                    items.push(self.any(depth + 1)?);
                    self.lexer.take(b',');
                }
                let texts: Option<Vec<String>> = items.iter().map(|v| v.text().map(str::to_owned)).collect();
                Ok(texts.map_or(Value::Other, Value::Texts))
            }
            b'0'..=b'9' | b'-' | b'+' | b'.' => self.real().map(Value::Real),
            _ => match self.lexer.word() {
                "" => Err(self.lexer.unexpected("a value")),
                "None" => Ok(Value::Blocked),
                "true" => Ok(Value::Bool(true)),
                "false" => Ok(Value::Bool(false)),
                "inf" => Ok(Value::Real(f64::INFINITY)),
                word => Ok(Value::Text(word.to_owned())),
            },
        }
    }

    /// Skips `{ … }`.
    pub(super) fn braces(&mut self, depth: u32) -> Read<()> {
        if depth > MAX_DEPTH {
            return Err(self.lexer.broken(format!("values nested more than {MAX_DEPTH} deep")));
        }
        self.lexer.expect(b'{')?;
        while !self.lexer.take(b'}') {
            match self.lexer.peek() {
                b'{' => self.braces(depth + 1)?,
                b'=' | b':' | b',' => self.lexer.at += 1,
                _ => drop(self.any(depth + 1)?),
            }
        }
        Ok(())
    }

    /// `@file@</Prim> (offset = 1)`, several in brackets, or `None`.
    pub(super) fn references(&mut self, owner: &str) -> Read<Vec<Reference>> {
        if self.lexer.take_word("None") {
            return Ok(Vec::new());
        }
        if !self.lexer.take(b'[') {
            return Ok(vec![self.reference(owner)?]);
        }
        let mut items = Vec::new();
        while !self.lexer.take(b']') {
            items.push(self.reference(owner)?);
            self.lexer.take(b',');
        }
        Ok(items)
    }

    fn reference(&mut self, owner: &str) -> Read<Reference> {
        let asset = if self.lexer.peek() == b'@' { self.lexer.asset()? } else { String::new() };
        let prim = match self.lexer.peek() {
            b'<' => resolve(owner, &self.lexer.path()?),
            _ if asset.is_empty() => return Err(self.lexer.unexpected("a file in @ or a path in <>")),
            _ => String::new(),
        };
        // `<>` is the default prim.
        let prim = if prim == "/" { String::new() } else { prim };
        Ok(Reference { asset, prim, offset: self.offset()? })
    }
}
