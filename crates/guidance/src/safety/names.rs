//! Names of a label map's structures, from the text of files that other software writes beside it or in its header.

use std::collections::BTreeMap;

/// Most bytes of a name.
pub const MAX_NAME: usize = 96;
/// Most names.
pub const MAX_NAMES: usize = 32_767;

/// Names by label.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LabelNames(BTreeMap<i16, String>);

/// Why names cannot be used. Lines count from 1.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NamesError {
    /// A line of another form.
    #[error("line {line}: expected {expected}")]
    Line {
        /// Which.
        line: usize,
        /// What a line has.
        expected: &'static str,
    },
    /// A number that is no label.
    #[error("line {line}: label {found}, 0 to 32767 are allowed")]
    Label {
        /// Which.
        line: usize,
        /// The number.
        found: i64,
    },
    /// Characters that would change how other words look, or that nobody sees.
    #[error("line {line}: the name of label {label} has the character U+{found:04X}, which is none to be read")]
    Character {
        /// Which.
        line: usize,
        /// Of which label.
        label: i16,
        /// The character's number.
        found: u32,
    },
    /// A name without a letter, or too long a one.
    #[error("line {line}: the name of label {label} has {found} bytes, 1 to {MAX_NAME} are allowed")]
    Length {
        /// Which.
        line: usize,
        /// Of which label.
        label: i16,
        /// Its bytes.
        found: usize,
    },
    /// A structure has one name or none.
    #[error("line {line}: label {label} is {second:?}, and was {first:?} before: which of the two it is, is not known")]
    Twice {
        /// Which.
        line: usize,
        /// The label.
        label: i16,
        /// Its name so far.
        first: String,
        /// The other one.
        second: String,
    },
}

impl LabelNames {
    /// The name of a label, where it has one.
    pub fn get(&self, label: i16) -> Option<&str> {
        self.0.get(&label).map(String::as_str)
    }

    /// A structure for people, by name and number: `liver (label 3)`, or `label 3`.
    pub fn words(&self, label: i16) -> String {
        self.get(label)
            .map_or_else(|| format!("label {label}"), |name| format!("{name} (label {label})"))
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Of an ITK-SNAP label description: `IDX R G B A VIS MSH "LABEL"` a line.
    ///
    /// # Errors
    /// [`NamesError`].
    pub fn of_itk_snap(text: &str) -> Result<Self, NamesError> {
        const EXPECTED: &str = "a label, six numbers and a name in quotes (ITK-SNAP's label description)";
        let mut names = Self::default();
        for (line, text) in lines(text) {
            let bad = NamesError::Line {
                line,
                expected: EXPECTED,
            };
            let (numbers, name) = text.split_once('"').ok_or(bad.clone())?;
            let name = name.strip_suffix('"').ok_or(bad.clone())?;
            let mut numbers = numbers.split_whitespace();
            let label = numbers.next().and_then(|label| label.parse().ok()).ok_or(bad.clone())?;
            let rest: Vec<_> = numbers.map(str::parse::<f64>).collect();
            if rest.len() != 6 || rest.iter().any(Result::is_err) {
                return Err(bad);
            }
            names.add(label, name, line)?;
        }
        Ok(names)
    }

    /// Of a color table of 3D Slicer: `LABEL NAME R G B A` a line, a name's blanks being `_`.
    ///
    /// # Errors
    /// [`NamesError`].
    pub fn of_color_table(text: &str) -> Result<Self, NamesError> {
        const EXPECTED: &str = "a label, a name without blanks and four numbers (3D Slicer's color table)";
        let mut names = Self::default();
        for (line, text) in lines(text) {
            let bad = NamesError::Line {
                line,
                expected: EXPECTED,
            };
            let words: Vec<&str> = text.split_whitespace().take(7).collect();
            let [label, name, colour @ ..] = &words[..] else {
                return Err(bad);
            };
            if colour.len() != 4 || colour.iter().any(|level| level.parse::<f64>().is_err()) {
                return Err(bad);
            }
            names.add(label.parse().map_err(|_| bad)?, name, line)?;
        }
        Ok(names)
    }

    /// Of the keys and values in the header of a segmentation of 3D Slicer (`.seg.nrrd`), each with its line: `Segment0_Name` is the name of
    /// the label `Segment0_LabelValue`. A segment without a label value has no name here.
    ///
    /// # Errors
    /// [`NamesError`].
    pub fn of_segments<'a>(keys: impl Iterator<Item = (usize, &'a str, &'a str)>) -> Result<Self, NamesError> {
        let mut segments: BTreeMap<u32, [Option<(usize, &str)>; 2]> = BTreeMap::new();
        for (line, key, value) in keys {
            let Some((number, what)) = key.strip_prefix("Segment").and_then(|rest| rest.split_once('_')) else {
                continue;
            };
            let place = match what {
                "Name" => 0,
                "LabelValue" => 1,
                _ => continue,
            };
            let expected = "each key of a segment once, and no more than 32767 segments";
            let bad = NamesError::Line { line, expected };
            let number = number.parse().map_err(|_| bad.clone())?;
            if segments.len() > MAX_NAMES {
                return Err(bad);
            }
            let slot = &mut segments.entry(number).or_default()[place];
            if slot.replace((line, value)).is_some() {
                return Err(bad);
            }
        }
        let mut names = Self::default();
        for [name, label] in segments.into_values() {
            let (Some((line, name)), Some((at, label))) = (name, label) else {
                continue;
            };
            let expected = "a whole number as the value of a segment's label";
            let label = label.trim().parse();
            let label = label.map_err(|_| NamesError::Line { line: at, expected })?;
            names.add(label, name, line)?;
        }
        Ok(names)
    }

    /// Of labels and their names, as a format holds them; the first counts as line 1.
    ///
    /// # Errors
    /// [`NamesError`].
    pub fn of_pairs<'a>(pairs: impl Iterator<Item = (i16, &'a str)>) -> Result<Self, NamesError> {
        let mut names = Self::default();
        for (line, (label, name)) in (1..).zip(pairs) {
            names.add(i64::from(label), name, line)?;
        }
        Ok(names)
    }

    /// With those of another file of the same label map.
    ///
    /// # Errors
    /// [`NamesError::Twice`], of no line.
    pub fn and(mut self, others: Self) -> Result<Self, NamesError> {
        others
            .0
            .into_iter()
            .try_for_each(|(label, name)| self.insert(label, name, 0))?;
        Ok(self)
    }

    fn add(&mut self, label: i64, name: &str, line: usize) -> Result<(), NamesError> {
        let number = i16::try_from(label).ok().filter(|label| *label >= 0);
        let label = number.ok_or(NamesError::Label { line, found: label })?;
        // The ground is no structure, and is called "Clear Label", "Background" and otherwise.
        if label == 0 {
            return Ok(());
        }
        let name = name.trim();
        if let Some(found) = name.chars().find(|c| !is_plain(*c)) {
            let found = u32::from(found);
            return Err(NamesError::Character { line, label, found });
        }
        if !(1..=MAX_NAME).contains(&name.len()) {
            let found = name.len();
            return Err(NamesError::Length { line, label, found });
        }
        self.insert(label, name.to_owned(), line)
    }

    fn insert(&mut self, label: i16, name: String, line: usize) -> Result<(), NamesError> {
        match self.0.get(&label) {
            Some(first) if *first != name => Err(NamesError::Twice {
                line,
                label,
                first: first.clone(),
                second: name,
            }),
            Some(_) => Ok(()),
            None => {
                self.0.insert(label, name);
                Ok(())
            }
        }
    }
}

/// Lines that say something, with their number.
fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let all = text.lines().map(str::trim).zip(1..).map(|(text, line)| (line, text));
    all.filter(|(_, text)| !text.is_empty() && !text.starts_with('#'))
}

/// Control characters, and those that turn the direction of what follows or take no room, would let one structure's words be read as
/// another's; U+FFFD stands for bytes that are no text.
fn is_plain(c: char) -> bool {
    let is_hidden = matches!(
        c,
        '\u{ad}' | '\u{61c}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}' | '\u{fffd}'
    );
    !c.is_control() && !is_hidden
}

#[cfg(test)]
mod tests {
    use super::*;

    const SNAP: &str = "################################################\n# ITK-SnAP Label Description File\n# IDX   -R-  -G-  -B-  -A--  VIS MSH  \
        LABEL\n    0     0    0    0        0  0  0    \"Clear Label\"\n    3   255    0    0        1  1  0    \"vena cava, inferior\"\n\
        7     0  255    0        0.5  1  1    \"Aorta\"\n";

    #[test]
    fn names_come_from_the_three_kinds_of_files() {
        let snap = LabelNames::of_itk_snap(SNAP).unwrap();
        assert_eq!(
            (snap.len(), snap.get(3), snap.get(0)),
            (2, Some("vena cava, inferior"), None)
        );
        assert_eq!(
            (snap.words(7), snap.words(8)),
            ("Aorta (label 7)".to_owned(), "label 8".to_owned())
        );
        let table = LabelNames::of_color_table(
            "# Color table file x\n# 3 values\n0 Background 0 0 0 0\r\n7 left_kidney 1 2 3 255\n",
        );
        assert_eq!(table.unwrap().get(7), Some("left_kidney"));
        let keys = [
            (9, "Segment1_LabelValue", "2"),
            (10, "Segment1_Name", "spleen"),
            (11, "Segment0_Name", "no value"),
            (12, "Segmentation_MasterRepresentation", "Binary labelmap"),
            (13, "Segment1_NameAutoGenerated", "0"),
        ];
        let segments = LabelNames::of_segments(keys.into_iter()).unwrap();
        assert_eq!((segments.len(), segments.get(2)), (1, Some("spleen")));
    }

    #[test]
    fn what_would_mislead_is_refused_by_line_and_label() {
        let snap = |line: &str| LabelNames::of_itk_snap(line).unwrap_err().to_string();
        for (line, expected) in [
            (
                "1 0 0 0 1 1 1 \"a\"\n1 0 0 0 1 1 1 \"b\"",
                "line 2: label 1 is \"b\", and was \"a\" before",
            ),
            ("-1 0 0 0 1 1 1 \"a\"", "label -1, 0 to 32767"),
            ("70000 0 0 0 1 1 1 \"a\"", "label 70000, 0 to 32767"),
            ("1 0 0 0 1 1 1 \"a\u{1b}[2J\"", "U+001B"),
            ("1 0 0 0 1 1 1 \"a\u{202e}b\"", "U+202E"),
            ("1 0 0 0 1 1 1 \"\"", "has 0 bytes, 1 to 96"),
            ("1 0 0 0 1 1 \"a\"", "line 1: expected a label, six numbers"),
            ("1 0 0 0 1 1 1 a", "line 1: expected a label, six numbers"),
            ("1 0 0 0 1 1 x \"a\"", "line 1: expected a label, six numbers"),
        ] {
            assert!(snap(line).contains(expected), "{line:?}: {}", snap(line));
        }
        let long = format!("1 0 0 0 1 1 1 \"{}\"", "a".repeat(MAX_NAME + 1));
        assert!(snap(&long).contains("has 97 bytes"));
        for line in [
            "1 liver 0 0 0",
            "1 my liver 0 0 0 0",
            "x liver 0 0 0 0",
            "1 liver 0 0 0 zero",
        ] {
            assert!(LabelNames::of_color_table(line).is_err(), "{line}");
        }
        for keys in [
            [(1, "Segment0_Name", "a"), (2, "Segment0_Name", "a")],
            [(1, "Segmentx_Name", "a"), (2, "Segment0_LabelValue", "1")],
            [(1, "Segment0_Name", "a"), (2, "Segment0_LabelValue", "1.5")],
            [(1, "Segment0_Name", "a\nb"), (2, "Segment0_LabelValue", "1")],
        ] {
            assert!(LabelNames::of_segments(keys.into_iter()).is_err(), "{keys:?}");
        }
    }

    #[test]
    fn two_files_agree_or_are_refused() {
        let of = |text| LabelNames::of_color_table(text).unwrap();
        let both = of("1 a 0 0 0 0").and(of("1 a 0 0 0 0\n2 b 0 0 0 0")).unwrap();
        assert_eq!(both.len(), 2);
        let refused = both.and(of("2 c 0 0 0 0")).unwrap_err();
        assert!(matches!(refused, NamesError::Twice { label: 2, .. }), "{refused}");
    }
}
