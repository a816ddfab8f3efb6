//! From an element's bytes to text and numbers (DICOM PS3.5 section 6.2).

use super::element::Elements;
use super::error::FileError;
use super::syntax::Coding;
use super::tag::Tag;
use super::text::{self, Label};

/// No number's text is longer: DS has 16 characters by the standard, and some writers' doubles have more.
const MAX_NUMBER: usize = 64;

impl Elements {
    /// The text of an element; `None` where it is absent or empty.
    pub(crate) fn text(&self, tag: Tag) -> Option<String> {
        self.get(tag).map(text::text).filter(|text| !text.is_empty())
    }

    /// A code that may be shown.
    pub(crate) fn code(&self, tag: Tag) -> Option<String> {
        self.get(tag).map(text::code)
    }

    /// What tells slices apart; `None` where the element is absent or empty.
    pub(crate) fn label(&self, tag: Tag) -> Option<Label> {
        self.get(tag).and_then(Label::of)
    }

    /// The fourth of the values of ImageType or FrameType, as a code that may be shown: what was made of the measured pixels.
    pub(crate) fn contrast(&self, tag: Tag) -> Option<String> {
        let fourth = self.get(tag)?.split(|&b| b == b'\\').nth(3)?;
        Label::of(fourth).map(|label| label.shown().to_owned())
    }

    /// Whether the ImageType or FrameType is of an overview to plan slices on, not of a slice (PS3.3, C.8.2.1.1.1).
    pub(crate) fn is_localizer(&self, tag: Tag) -> bool {
        self.text(tag)
            .is_some_and(|kind| kind.split('\\').any(|value| value.trim() == "LOCALIZER"))
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

    /// A 32-bit number; `None` where the element is absent or empty.
    ///
    /// # Errors
    /// [`FileError::Value`].
    pub(crate) fn u32(&self, tag: Tag) -> Result<Option<u32>, FileError> {
        let number = self.fixed(tag, "one number of 32 bits")?;
        Ok(number.map(|bytes| match self.syntax.elements {
            Coding::ExplicitBig => u32::from_be_bytes(bytes),
            Coding::ExplicitLittle | Coding::ImplicitLittle => u32::from_le_bytes(bytes),
        }))
    }

    /// A 32-bit number with a fraction (FL), finite; `None` where the element is absent or empty.
    ///
    /// # Errors
    /// [`FileError::Value`].
    pub(crate) fn f32(&self, tag: Tag) -> Result<Option<f32>, FileError> {
        let expected = "one finite number of 32 bits";
        let number = self.fixed(tag, expected)?.map(|bytes| match self.syntax.elements {
            Coding::ExplicitBig => f32::from_be_bytes(bytes),
            Coding::ExplicitLittle | Coding::ImplicitLittle => f32::from_le_bytes(bytes),
        });
        finite(tag, number.map(f64::from), expected)?;
        Ok(number)
    }

    /// A 64-bit number with a fraction (FD), finite; `None` where the element is absent or empty.
    ///
    /// # Errors
    /// [`FileError::Value`].
    pub(crate) fn f64(&self, tag: Tag) -> Result<Option<f64>, FileError> {
        let expected = "one finite number of 64 bits";
        let number = self.fixed(tag, expected)?.map(|bytes| match self.syntax.elements {
            Coding::ExplicitBig => f64::from_be_bytes(bytes),
            Coding::ExplicitLittle | Coding::ImplicitLittle => f64::from_le_bytes(bytes),
        });
        finite(tag, number, expected)?;
        Ok(number)
    }

    fn fixed<const N: usize>(&self, tag: Tag, expected: &'static str) -> Result<Option<[u8; N]>, FileError> {
        let Some(bytes) = self.get(tag).filter(|bytes| !bytes.is_empty()) else {
            return Ok(None);
        };
        let refused = |_| FileError::Value {
            tag,
            found: format!("{} bytes long", bytes.len()),
            expected,
        };
        bytes.try_into().map(Some).map_err(refused)
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

    /// One decimal number (DS or IS), finite; `None` where the element is absent or empty.
    ///
    /// # Errors
    /// [`FileError::Value`].
    pub(crate) fn number(&self, tag: Tag) -> Result<Option<f64>, FileError> {
        Ok(self.numbers::<1>(tag)?.map(|[number]| number))
    }

    /// One decimal number that is only reported: whatever is wrong with it makes it absent.
    pub(crate) fn reported(&self, tag: Tag) -> Option<f64> {
        self.number(tag).ok().flatten()
    }
}

fn finite(tag: Tag, number: Option<f64>, expected: &'static str) -> Result<(), FileError> {
    match number.filter(|number| !number.is_finite()) {
        None => Ok(()),
        Some(number) => Err(FileError::Value {
            tag,
            found: number.to_string(),
            expected,
        }),
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
