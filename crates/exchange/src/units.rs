//! Units of length, and what a text says of units and axes beside the words that are read: a unit that it names, a key that is about places.

use std::str::FromStr;

/// A unit of length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LengthUnit {
    /// 1 mm.
    Millimetre,
    /// 1000 mm.
    Metre,
}

impl LengthUnit {
    /// Millimetres in one.
    pub const fn mm(self) -> f64 {
        match self {
            Self::Millimetre => 1.0,
            Self::Metre => 1000.0,
        }
    }

    /// The word in files and on command lines.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Millimetre => "mm",
            Self::Metre => "m",
        }
    }
}

impl FromStr for LengthUnit {
    type Err = String;

    /// From the word of a command line.
    fn from_str(word: &str) -> Result<Self, String> {
        let found = [Self::Millimetre, Self::Metre]
            .into_iter()
            .find(|unit| unit.name() == word);
        found.ok_or_else(|| "expected mm or m".to_owned())
    }
}

/// A unit of length that a text has the word of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedUnit {
    /// The word.
    pub word: String,
    /// Which it is, where it is one that is read.
    pub unit: Option<LengthUnit>,
}

/// Words that are a unit wherever they stand.
const WORDS: [&str; 21] = [
    "mm",
    "millimeter",
    "millimeters",
    "millimetre",
    "millimetres",
    "meter",
    "meters",
    "metre",
    "metres",
    "cm",
    "centimeter",
    "centimeters",
    "centimetre",
    "centimetres",
    "inch",
    "inches",
    "micron",
    "microns",
    "micrometer",
    "micrometers",
    "micrometres",
];
/// Words that are one behind a number, behind `in`, `unit` and `units`, and alone in brackets.
const SHORT: [&str; 6] = ["m", "dm", "km", "um", "\u{b5}m", "nm"];
/// What a key of units or axes has in it.
const KEYS: [&str; 4] = ["unit", "space", "frame", "coordinate"];

/// The unit of a word, in whatever case, where it is one that is read.
pub(crate) fn unit_of(word: &str) -> Option<LengthUnit> {
    match word.to_ascii_lowercase().as_str() {
        "mm" | "millimeter" | "millimeters" | "millimetre" | "millimetres" => Some(LengthUnit::Millimetre),
        "m" | "meter" | "meters" | "metre" | "metres" => Some(LengthUnit::Metre),
        _ => None,
    }
}

/// The units that a text has the words of: `all in cm`, `1 unit = 2.54 cm`, `(m)`, `10mm`.
pub(crate) fn units_in(text: &str) -> Vec<NamedUnit> {
    let is_between = |c: char| !c.is_alphanumeric();
    let mut found: Vec<NamedUnit> = Vec::new();
    let mut before = "";
    let mut end = 0;
    for token in text.split(is_between) {
        let (start, stop) = (end, end + token.len());
        // Each piece but the last is ended by one character.
        end = stop + text[stop..].chars().next().map_or(0, char::len_utf8);
        let word = token.trim_start_matches(|c: char| c.is_ascii_digit());
        if word.is_empty() {
            before = if token.is_empty() { before } else { token };
            continue;
        }
        let lower = word.to_lowercase();
        let is_behind = word.len() < token.len() || is_before_unit(before);
        let is_in_brackets = text[..start].ends_with(['(', '[']) && text[stop..].starts_with([')', ']']);
        let is_short = SHORT.contains(&lower.as_str()) && (is_behind || is_in_brackets);
        let is_inch = lower == "in" && is_in_brackets;
        if (WORDS.contains(&lower.as_str()) || is_short || is_inch) && found.iter().all(|unit| unit.word != lower) {
            found.push(NamedUnit {
                unit: unit_of(&lower),
                word: lower,
            });
        }
        before = token;
    }
    found
}

/// Whether a short word behind this one is a unit.
fn is_before_unit(word: &str) -> bool {
    let words = ["in", "unit", "units"];
    words.iter().any(|one| one.eq_ignore_ascii_case(word))
        || word.bytes().all(|b| b.is_ascii_digit()) && !word.is_empty()
}

/// The letters of a key, without blanks, signs and case: `# coordinate system` is `CoordinateSystem`.
pub(crate) fn letters(text: &str) -> String {
    let letters = text.chars().filter(char::is_ascii_alphabetic);
    letters.map(|c| c.to_ascii_lowercase()).collect()
}

/// What a key, by its [`letters`], is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum About {
    /// A unit.
    Unit,
    /// Axes.
    Axes,
}

/// What a key is about; `None` of one that says nothing of places.
pub(crate) fn about(key: &str) -> Option<About> {
    let letters = letters(key);
    let found = KEYS.iter().find(|word| letters.contains(**word));
    found.map(|word| if *word == "unit" { About::Unit } else { About::Axes })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_found_where_they_are_said_and_not_in_other_words() {
        for (text, words) in [
            ("all in cm", &["cm"][..]),
            ("unit cm", &["cm"]),
            ("scale: 10 mm", &["mm"]),
            ("(cm)", &["cm"]),
            ("1 unit = 2.54 cm or 25.4mm", &["cm", "mm"]),
            ("in metres", &["metres"]),
            ("units m", &["m"]),
            ("0.5 m", &["m"]),
            ("[m]", &["m"]),
            ("(in)", &["in"]),
            ("size in \u{b5}m, 3", &["\u{b5}m"]),
            ("Inches", &["inches"]),
            ("made by M. Um in Cmd", &[]),
            ("unit normals, a community mesh", &[]),
            ("", &[]),
            ("\u{2014}cm\u{2014}", &["cm"]),
        ] {
            let found: Vec<String> = units_in(text).into_iter().map(|unit| unit.word).collect();
            assert_eq!(found, words, "{text:?}");
        }
        assert_eq!(about("coordinateUnits"), Some(About::Unit));
        assert_eq!(about("reference_frame"), Some(About::Axes));
        assert_eq!(about("colour"), None);
    }
}
