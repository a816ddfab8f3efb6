//! Text of an element (DICOM PS3.5 section 6.2).

pub(crate) mod charset;

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
