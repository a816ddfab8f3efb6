//! From an element's bytes to text and numbers (DICOM PS3.5 section 6.2).

use super::element::Elements;
use super::error::{FileError, Tag};
use super::syntax::Coding;

/// No number's text is longer: DS has 16 characters by the standard, and some writers' doubles have more.
const MAX_NUMBER: usize = 64;

/// The text without the padding around it; what is not ASCII becomes question marks.
pub(crate) fn text(bytes: &[u8]) -> String {
    let ascii: String = bytes
        .iter()
        .map(|&b| if b.is_ascii() { char::from(b) } else { '?' })
        .collect();
    ascii.trim_matches(['\0', ' ', '\t', '\r', '\n']).to_owned()
}

/// A code (CS, or a short SH) that may be shown: anything but capitals, digits and the like is not told.
pub(crate) fn code(bytes: &[u8]) -> String {
    let text = text(bytes);
    let plain = |b: u8| b.is_ascii_alphanumeric() || b" _-.+/".contains(&b);
    if !text.is_empty() && text.len() <= 16 && text.bytes().all(plain) {
        return text;
    }
    "unknown".to_owned()
}

impl Elements {
    /// The text of an element; `None` where it is absent or empty.
    pub(crate) fn text(&self, tag: Tag) -> Option<String> {
        self.get(tag).map(text).filter(|text| !text.is_empty())
    }

    /// A code that may be shown.
    pub(crate) fn code(&self, tag: Tag) -> Option<String> {
        self.get(tag).map(code)
    }

    /// A 16-bit number.
    ///
    /// # Errors
    /// [`FileError::Missing`], [`FileError::Value`].
    pub(crate) fn u16(&self, tag: Tag) -> Result<u16, FileError> {
        let bytes = self.get(tag).ok_or(FileError::Missing { tag })?;
        let &[a, b] = bytes else {
            let found = format!("{} bytes long", bytes.len());
            let expected = "one number of 16 bits";
            return Err(FileError::Value { tag, found, expected });
        };
        Ok(match self.syntax.elements {
            Coding::ExplicitBig => u16::from_be_bytes([a, b]),
            Coding::ExplicitLittle | Coding::ImplicitLittle => u16::from_le_bytes([a, b]),
        })
    }

    /// `N` decimal numbers (DS or IS), finite; `None` where the element is absent or empty.
    ///
    /// # Errors
    /// [`FileError::Value`].
    pub(crate) fn numbers<const N: usize>(&self, tag: Tag) -> Result<Option<[f64; N]>, FileError> {
        let Some(text) = self.text(tag) else { return Ok(None) };
        let refused = || FileError::Value {
            tag,
            found: shown(&text),
            expected: "as many finite numbers, with backslashes between, as the standard asks for",
        };
        let mut numbers = [0.0; N];
        let mut parts = text.split('\\');
        for number in &mut numbers {
            *number = parts.next().and_then(number_of).ok_or_else(refused)?;
        }
        match parts.next() {
            None => Ok(Some(numbers)),
            Some(_) => Err(refused()),
        }
    }

    /// One decimal number that is only reported: whatever is wrong with it makes it absent.
    pub(crate) fn reported(&self, tag: Tag) -> Option<f64> {
        self.numbers::<1>(tag).ok().flatten().map(|[number]| number)
    }
}

fn number_of(text: &str) -> Option<f64> {
    let text = text.trim_matches([' ', '\0']);
    if text.len() > MAX_NUMBER {
        return None;
    }
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

/// A text that is shown only where it can be nothing but numbers.
fn shown(text: &str) -> String {
    let number = |b: u8| b.is_ascii_digit() || b"+-.eE \\".contains(&b);
    if text.len() <= 128 && text.bytes().all(number) {
        return format!("\"{text}\"");
    }
    format!("{} bytes that are not numbers", text.len())
}
