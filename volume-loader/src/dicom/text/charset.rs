//! Text in the character set that its file names (DICOM PS3.5 section 6.1.2, PS3.3 C.12.1.1.2).
//!
//! The sets are those of dicom-rs. What it does not do is done here: several sets in one value, each begun by an escape sequence
//! (ISO 2022), as Japanese and Korean names have them.

use dicom_encoding::text::{SpecificCharacterSet, TextCodec};

const ESCAPE: u8 = 0x1B;
/// Back to the first 94 characters of ASCII: ends what the decoder of ISO 2022 JP was in.
const TO_ASCII: &[u8] = b"\x1B(B";

/// Escape sequences without their first byte, and the set that they begin (PS3.3 tables C.12-3 and C.12-4).
const ESCAPES: [(&[u8], Begins); 18] = [
    (b"(B", Begins::Ascii),
    (b"(J", Begins::Ascii),
    (b")I", Begins::Upper("ISO_IR 13")),
    (b"-A", Begins::Upper("ISO_IR 100")),
    (b"-B", Begins::Upper("ISO_IR 101")),
    (b"-C", Begins::Upper("ISO_IR 109")),
    (b"-D", Begins::Upper("ISO_IR 110")),
    (b"-F", Begins::Upper("ISO_IR 126")),
    (b"-G", Begins::Upper("ISO_IR 127")),
    (b"-H", Begins::Upper("ISO_IR 138")),
    (b"-L", Begins::Upper("ISO_IR 144")),
    (b"-M", Begins::Upper("ISO_IR 148")),
    (b"-T", Begins::Upper("ISO_IR 166")),
    (b"$)C", Begins::Upper("ISO_IR 149")),
    (b"$)A", Begins::Upper("GB2312")),
    (b"$B", Begins::Pairs),
    (b"$@", Begins::Pairs),
    (b"$(D", Begins::Pairs),
];

/// What an escape sequence begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Begins {
    /// Bytes below 128 are ASCII again; those above stay what they were.
    Ascii,
    /// Bytes from 128 on are of this set.
    Upper(&'static str),
    /// Two bytes below 128 for each character: JIS X 0208 and 0212, whose decoder reads the sequence itself.
    Pairs,
}

/// The character sets of a file.
#[derive(Debug, Clone, Default)]
pub(crate) struct Charset {
    /// That in which each value begins; `None` for a set that is not known.
    first: Option<SpecificCharacterSet>,
    /// Whether escape sequences begin others.
    is_extended: bool,
}

impl Charset {
    /// Of the value of SpecificCharacterSet; without one it is ASCII, and Latin 1 beyond, as dicom-rs takes it.
    pub(crate) fn of(value: Option<&[u8]>) -> Self {
        let value = String::from_utf8_lossy(value.unwrap_or_default()).into_owned();
        let sets: Vec<&str> = value.split('\\').map(|set| set.trim_matches(['\0', ' '])).collect();
        let first = match sets[..] {
            ["", ..] => Some(SpecificCharacterSet::ISO_IR_6),
            [set, ..] => SpecificCharacterSet::from_code(set),
            [] => None,
        };
        Self {
            first,
            is_extended: sets.len() > 1 || sets.iter().any(|set| set.starts_with("ISO 2022")),
        }
    }

    /// The text of a value without the padding around it. Whatever is no character of its set becomes U+FFFD, or stands as dicom-rs
    /// writes it, `\` and three octal digits.
    pub(crate) fn text(&self, bytes: &[u8]) -> String {
        let text = match self.is_extended {
            true => self.extended(bytes),
            false => decoded(self.first.as_ref(), bytes),
        };
        text.trim_matches(['\0', ' ', '\t', '\r', '\n']).to_owned()
    }

    /// Piece by piece, from one escape sequence to the next. Delimiters and ends of lines lead back to the first set.
    fn extended(&self, bytes: &[u8]) -> String {
        let (mut text, mut rest) = (String::new(), bytes);
        let (mut upper, mut pairs) = (self.first.clone(), None);
        while !rest.is_empty() {
            if let Some((sequence, begins)) = escape(rest) {
                match begins {
                    Begins::Ascii => pairs = None,
                    Begins::Upper(set) => upper = SpecificCharacterSet::from_code(set),
                    Begins::Pairs => pairs = Some(sequence),
                }
                rest = &rest[sequence.len()..];
                continue;
            }
            // At least one byte: an escape that begins nothing known is decoded with what follows it.
            let ends = |byte: &u8| *byte == ESCAPE || pairs.is_none() && is_delimiter(*byte);
            let length = 1 + rest[1..].iter().position(ends).unwrap_or(rest.len() - 1);
            let (piece, behind) = rest.split_at(length);
            if pairs.is_none() && piece.first().is_some_and(|byte| is_delimiter(*byte)) {
                upper = self.first.clone();
            }
            text += &match pairs {
                Some(sequence) => in_pairs(sequence, piece),
                None => decoded(upper.as_ref(), piece),
            };
            rest = behind;
        }
        text
    }
}

/// The escape sequence with which the bytes begin, and what it begins.
fn escape(bytes: &[u8]) -> Option<(&[u8], Begins)> {
    let behind = bytes.strip_prefix(&[ESCAPE])?;
    let known = ESCAPES.iter().find(|(sequence, _)| behind.starts_with(sequence))?;
    Some((&bytes[..1 + known.0.len()], known.1))
}

/// What parts the components of a name, values and lines (PS3.5 section 6.1.2.5.3).
fn is_delimiter(byte: u8) -> bool {
    matches!(byte, b'^' | b'=' | b'\\' | b'\t' | b'\n' | b'\r' | 0x0C)
}

fn in_pairs(sequence: &[u8], piece: &[u8]) -> String {
    let japanese = SpecificCharacterSet::from_code("ISO_IR 87");
    decoded(japanese.as_ref(), &[sequence, piece, TO_ASCII].concat())
}

fn decoded(set: Option<&SpecificCharacterSet>, bytes: &[u8]) -> String {
    let text = set.and_then(|set| set.decode(bytes).ok());
    text.unwrap_or_else(|| {
        let ascii = |&byte: &u8| {
            if byte.is_ascii() {
                char::from(byte)
            } else {
                char::REPLACEMENT_CHARACTER
            }
        };
        bytes.iter().map(ascii).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn text(set: &str, bytes: &[u8]) -> String {
        Charset::of(Some(set.as_bytes())).text(bytes)
    }

    /// The examples of PS3.5 annexes H, I, J and K, byte by byte as they stand there.
    #[test]
    fn names_of_the_standard_are_read() {
        let japanese = b"Yamada^Tarou=\x1B$B;3ED\x1B(B^\x1B$BB@O:\x1B(B=\x1B$B$d$^$@\x1B(B^\x1B$B$?$m$&\x1B(B";
        assert_eq!(
            text("\\ISO 2022 IR 87", japanese),
            "Yamada^Tarou=山田^太郎=やまだ^たろう"
        );
        let half_width =
            b"\xD4\xCF\xC0\xDE^\xC0\xDB\xB3=\x1B$B;3ED\x1B(J^\x1B$BB@O:\x1B(J=\x1B$B$d$^$@\x1B(J^\x1B$B$?$m$&\x1B(J";
        assert_eq!(
            text("ISO 2022 IR 13\\ISO 2022 IR 87", half_width),
            "ﾔﾏﾀﾞ^ﾀﾛｳ=山田^太郎=やまだ^たろう"
        );
        let korean = b"Hong^Gildong=\x1B$)C\xFB\xF3^\x1B$)C\xD1\xCE\xD4\xD7=\x1B$)C\xC8\xAB^\x1B$)C\xB1\xE6\xB5\xBF";
        assert_eq!(text("\\ISO 2022 IR 149", korean), "Hong^Gildong=洪^吉洞=홍^길동");
        let chinese = "Wang^XiaoDong=王^小东";
        assert_eq!(text("ISO_IR 192", chinese.as_bytes()), chinese);
        let gb = b"Wang^XiaoDong=\xCD\xF5^\xD0\xA1\xB6\xAB=";
        assert_eq!(text("GB18030", gb), "Wang^XiaoDong=王^小东=");
    }

    #[test]
    fn sets_of_one_byte_and_of_none_are_read() {
        assert_eq!(text("ISO_IR 100", b"Buc^J\xE9r\xF4me "), "Buc^Jérôme");
        assert_eq!(
            text("ISO_IR 126 ", b"\xC4\xE9\xEF\xED\xF5\xF3\xE9\xEF\xF2"),
            "Διονυσιος"
        );
        assert_eq!(text("ISO_IR 144", b"\xBB\xEEce"), "Люce");
        assert_eq!(Charset::of(None).text(b"M\xFCller\0"), "Müller");
        // Latin 1 first and Greek behind an escape; a delimiter leads back.
        assert_eq!(text("ISO 2022 IR 100\\ISO 2022 IR 126", b"\xE9\x1B-F\xE9^\xE9"), "éι^é");
        // Known to nobody here: the ASCII of it stays.
        assert_eq!(text("ISO_IR 148", b"\xFEa"), "\u{fffd}a");
        assert_eq!(text("nonsense", b"a^b"), "a^b");
    }

    proptest! {
        #[test]
        fn any_bytes_give_some_text(set in "(\\\\|ISO 2022 IR (6|13|87|149|58)|ISO_IR 192|GB18030|x){0,4}",
            bytes in prop::collection::vec(prop_oneof![any::<u8>(), Just(ESCAPE), Just(b'$'), Just(b'B')], 0..200)) {
            let said = text(&set, &bytes);
            // At most four characters a byte, where an octal code stands for it.
            prop_assert!(said.chars().count() <= 4 * bytes.len());
        }

        #[test]
        fn ascii_is_ascii_in_every_set(words in "[ -\\[\\]-}]{0,60}") {
            for set in ["", "\\ISO 2022 IR 87", "\\ISO 2022 IR 149", "ISO_IR 192", "GB18030", "ISO_IR 100", "no"] {
                prop_assert_eq!(text(set, words.as_bytes()), words.trim_matches(' '), "{}", set);
            }
        }
    }
}
