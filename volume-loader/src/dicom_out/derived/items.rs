//! Elements, items and codes, as objects are put together of them.

use dicom_core::value::{DataSetSequence, PrimitiveValue};
use dicom_core::{DataElement, Tag, VR};
use dicom_dictionary_std::{tags, uids};
use dicom_object::InMemDicomObject;
use dicom_object::meta::FileMetaTableBuilder;

use super::error::{DerivedError, MOST_CHARACTERS};

pub(super) type Object = InMemDicomObject;

/// Puts a text; an empty one stands as an element without a value.
pub(super) fn put(object: &mut Object, tag: Tag, vr: VR, text: &str) {
    let value = match text {
        "" => PrimitiveValue::Empty,
        text => PrimitiveValue::from(text),
    };
    object.put(DataElement::new(tag, vr, value));
}

/// Puts a number of 16 bits.
pub(super) fn put_u16(object: &mut Object, tag: Tag, number: u16) {
    object.put(DataElement::new(tag, VR::US, PrimitiveValue::from(number)));
}

/// Puts a sequence of these items.
pub(super) fn put_items(object: &mut Object, tag: Tag, items: Vec<Object>) {
    object.put(DataElement::new(tag, VR::SQ, DataSetSequence::from(items)));
}

/// An item that is made by `fill`.
pub(super) fn item(fill: impl FnOnce(&mut Object)) -> Object {
    let mut object = Object::new_empty();
    fill(&mut object);
    object
}

/// A coded concept: value, scheme and meaning (PS3.3 section 8.8).
pub(super) fn code([value, scheme, meaning]: [&str; 3]) -> Vec<Object> {
    vec![item(|object| {
        put(object, tags::CODE_VALUE, VR::SH, value);
        put(object, tags::CODING_SCHEME_DESIGNATOR, VR::SH, scheme);
        put(object, tags::CODE_MEANING, VR::LO, meaning);
    })]
}

/// A name as LO holds it.
///
/// # Errors
/// [`DerivedError::Name`].
pub(super) fn name(text: &str) -> Result<&str, DerivedError> {
    let refused = |found: String| {
        Err(DerivedError::Name {
            name: text.to_owned(),
            found,
        })
    };
    let characters = text.chars().count();
    if text.chars().any(|c| c == '\\' || c.is_control()) {
        return refused("a backslash or a control character".to_owned());
    }
    // Readers take blanks at the ends for padding, and so would not find the name again.
    if text.trim() != text {
        return refused("a blank at its end".to_owned());
    }
    match (1..=MOST_CHARACTERS).contains(&characters) {
        true => Ok(text),
        false => refused(format!("{characters} characters")),
    }
}

/// Day and time of now, UTC, as DA and TM.
pub(super) fn now() -> [String; 2] {
    let date = bus::clock::date::now();
    let digits = |part: &str| part.chars().filter(char::is_ascii_digit).collect();
    let (day, time) = date.split_once('T').unwrap_or((&date, ""));
    [digits(day), digits(time)]
}

/// The whole file, Explicit VR Little Endian.
///
/// # Errors
/// [`DerivedError::Encode`].
pub(super) fn encoded(object: Object) -> Result<Vec<u8>, DerivedError> {
    let meta = FileMetaTableBuilder::new().transfer_syntax(uids::EXPLICIT_VR_LITTLE_ENDIAN);
    let file = object
        .with_meta(meta)
        .map_err(|source| DerivedError::Encode(source.into()))?;
    let mut bytes = Vec::new();
    file.write_all(&mut bytes)
        .map_err(|source| DerivedError::Encode(source.into()))?;
    Ok(bytes)
}
