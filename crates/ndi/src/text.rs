//! Fields of fixed length in texts: hexadecimal numbers, and decimal ones whose point is not written.

use crate::fault::{Fault, shown};
use crate::malformed::Refusal;
use crate::wire::long;

/// Reads characters one after the other and knows where it is.
#[derive(Debug, Clone)]
pub(crate) struct Text<'a> {
    rest: &'a [u8],
    end: u64,
}

impl<'a> Text<'a> {
    pub(crate) fn new(text: &'a str) -> Self {
        Self {
            rest: text.as_bytes(),
            end: long(text.len()),
        }
    }

    pub(crate) const fn rest(&self) -> &'a [u8] {
        self.rest
    }

    pub(crate) fn refuse(&self, fault: Fault) -> Refusal {
        let at = self.end - long(self.rest.len());
        Refusal { fault, at }
    }

    pub(crate) fn take(&mut self, count: usize, field: &'static str) -> Result<&'a [u8], Refusal> {
        let Some((taken, rest)) = self.rest.split_at_checked(count) else {
            return Err(self.refuse(Fault::Ends {
                field,
                needed: long(count),
                found: long(self.rest.len()),
            }));
        };
        self.rest = rest;
        Ok(taken)
    }

    /// Takes this word where it stands next.
    pub(crate) fn has(&mut self, word: &str) -> bool {
        match self.rest.strip_prefix(word.as_bytes()) {
            Some(rest) => {
                self.rest = rest;
                true
            }
            None => false,
        }
    }

    /// This word must stand next.
    pub(crate) fn word(&mut self, word: &'static str, field: &'static str) -> Result<(), Refusal> {
        if self.has(word) {
            return Ok(());
        }
        Err(self.refuse(Fault::Word {
            field,
            found: shown(self.rest),
            allowed: if word == "\n" { "a line feed" } else { word },
        }))
    }

    /// A hexadecimal number of `digits` digits, at most 8.
    pub(crate) fn hex(&mut self, digits: usize, field: &'static str) -> Result<u32, Refusal> {
        let before = self.clone();
        self.take(digits, field)?.iter().try_fold(0_u32, |number, byte| {
            let digit = char::from(*byte).to_digit(16);
            let digit = digit.ok_or_else(|| before.refuse(Fault::NotHex { field, byte: *byte }))?;
            Ok(number << 4 | digit)
        })
    }

    pub(crate) fn hex8(&mut self, field: &'static str) -> Result<u8, Refusal> {
        self.hex(2, field).map(|number| u8::try_from(number).unwrap_or(u8::MAX))
    }

    pub(crate) fn hex16(&mut self, field: &'static str) -> Result<u16, Refusal> {
        self.hex(4, field)
            .map(|number| u16::try_from(number).unwrap_or(u16::MAX))
    }

    /// A sign and `digits` digits, the last `decimals` of which stand behind the point.
    pub(crate) fn decimal(&mut self, digits: usize, decimals: i32, field: &'static str) -> Result<f64, Refusal> {
        let before = self.clone();
        let refuse = |byte: u8| before.refuse(Fault::NotDecimal { field, byte });
        let (sign, number) = match self.take(digits + 1, field)? {
            [b'+', number @ ..] => (1.0, number),
            [b'-', number @ ..] => (-1.0, number),
            other => return Err(refuse(other.first().copied().unwrap_or_default())),
        };
        let whole = number.iter().try_fold(0_u32, |whole, byte| {
            let digit = char::from(*byte).to_digit(10).ok_or_else(|| refuse(*byte))?;
            Ok(whole * 10 + digit)
        })?;
        // A zero with a minus is a zero.
        Ok(sign * f64::from(whole) / 10_f64.powi(decimals) + 0.0)
    }

    pub(crate) fn done(&self, field: &'static str) -> Result<(), Refusal> {
        match long(self.rest.len()) {
            0 => Ok(()),
            found => Err(self.refuse(Fault::Trailing { field, found })),
        }
    }
}

/// A number as TX writes it: a sign and `digits` digits; what does not fit is cut to the largest that does.
pub(crate) fn decimal(number: f64, digits: usize, decimals: i32) -> String {
    let most = 10_f64.powi(i32::try_from(digits).unwrap_or(0)) - 1.0;
    let whole = (number * 10_f64.powi(decimals)).round().clamp(-most, most);
    let sign = if whole < 0.0 { '-' } else { '+' };
    format!("{sign}{:0digits$.0}", whole.abs())
}
