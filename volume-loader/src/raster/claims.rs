//! What the texts of a header say of its numbers: that they are of another scanner than a CT, or in another unit than HU or mm. Read are keys
//! (`Modality = MR`, `units: cm`) and words that nobody writes of a CT; text that is anything else may name a patient, and is not repeated.

mod words;

use words::{HU, LENGTHS, META, MODALITIES, NO_CT, NUMBERS, PLACES, RESCALE};

const PASSED_OVER: &str = "a field about places that is none of the format's was passed over";

/// What was found in a header's texts.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Claims {
    doubts: Vec<String>,
    modality: Option<&'static str>,
}

/// Whether a text is the unit HU.
pub(crate) fn is_hu(text: &str) -> bool {
    let solid: String = text.chars().filter(|c| !c.is_whitespace()).collect();
    HU.contains(&solid.to_ascii_lowercase().as_str())
}

impl Claims {
    /// What is doubtful, a sentence each.
    pub(crate) fn doubts(&self) -> &[String] {
        &self.doubts
    }

    /// The kind of scanner by DICOM's word; another than a CT where the texts name both.
    pub(crate) fn modality(&self) -> Option<&'static str> {
        self.modality
    }

    /// A key with its value; `whose` is what is told of it.
    pub(crate) fn key(&mut self, whose: &str, key: &str, value: &str) {
        let letters: String = key.chars().filter(char::is_ascii_alphabetic).collect();
        let letters = letters.to_ascii_lowercase();
        let value = value.trim().trim_matches(['"', '\'']).trim();
        if letters.ends_with("modality") || key == "0008|0060" {
            self.of_modality(whose, value);
        } else if letters.ends_with("rescaletype") || key == "0028|1054" {
            self.of_rescale_type(whose, value);
        } else if letters.ends_with("unit") || letters.ends_with("units") {
            self.of_unit(whose, value);
        }
    }

    /// A text: its keys, and its words that nobody writes of a CT.
    pub(crate) fn text(&mut self, whose: &str, text: &str) {
        for (place, _) in text.match_indices([':', '=']) {
            let (key, value) = (key_before(&text[..place]), value_behind(&text[place + 1..]));
            self.key(whose, &key, &value);
            // An echo time: a magnet's.
            if key.eq_ignore_ascii_case("te") && echo_time(&value) > 0.0 {
                self.no_ct(whose, "TE", Some("MR"));
            }
        }
        let lower = text.to_ascii_lowercase();
        let words = lower.split(|c: char| !c.is_alphanumeric());
        let behind_in = words
            .clone()
            .zip(words.clone().skip(1))
            .filter(|(before, _)| *before == "in");
        for (_, unit) in behind_in.filter(|(_, unit)| unit.chars().count() > 1) {
            self.of_length(whose, unit);
        }
        let mut words = words;
        if let Some(found) = words.find_map(|word| NO_CT.into_iter().find(|no_ct| *no_ct == word)) {
            self.no_ct(whose, found, None);
        }
        if lower.contains("bq/ml") {
            self.no_ct(whose, "Bq/ml", None);
        }
    }

    fn no_ct(&mut self, whose: &str, word: &str, modality: Option<&'static str>) {
        self.modality = modality.or(self.modality);
        self.doubt(format!(
            "{whose} has the word {word}, as none of a CT has: its numbers are not HU"
        ));
    }

    fn of_modality(&mut self, whose: &str, value: &str) {
        let value = value.to_ascii_uppercase();
        let value = value.strip_prefix(META).unwrap_or(&value);
        if ["", "?", "UNKNOWN"].contains(&value) {
            return;
        }
        match MODALITIES.into_iter().find(|(word, _)| *word == value) {
            Some((_, "CT")) => self.modality = self.modality.or(Some("CT")),
            Some((_, modality)) => {
                self.modality = Some(modality);
                self.doubt(format!("not a CT ({modality}, by {whose}): its numbers are not HU"));
            }
            None => self.doubt(format!(
                "{whose} has a modality that is not CT: its numbers may not be HU"
            )),
        }
    }

    fn of_rescale_type(&mut self, whose: &str, value: &str) {
        if value.is_empty() || is_hu(value) {
            return;
        }
        let kind = RESCALE.into_iter().find(|kind| kind.eq_ignore_ascii_case(value));
        let kind = kind.unwrap_or("something else");
        self.doubt(format!("RescaleType is {kind}, not HU, by {whose}"));
    }

    fn of_unit(&mut self, whose: &str, value: &str) {
        let lower = value.to_lowercase();
        self.of_length(whose, &lower);
        if let Some(unit) = NUMBERS.iter().find(|known| **known == lower) {
            self.doubt(format!("{whose} has the unit {unit}: its numbers may not be HU"));
        }
    }

    fn of_length(&mut self, whose: &str, word: &str) {
        if let Some(unit) = LENGTHS.iter().find(|known| **known == word) {
            self.doubt(format!("{whose} has the unit {unit}: look whether lengths are right"));
        }
    }

    /// A key that no program reads; one about places is a doubt.
    pub(crate) fn passed_over(&mut self, line: usize, key: &str) {
        let key = key.to_ascii_lowercase();
        let is_place = PLACES.into_iter().any(|word| key.ends_with(word));
        // Of many one is enough.
        if is_place && !self.doubts.iter().any(|doubt| doubt.starts_with(PASSED_OVER)) {
            self.doubts.push(format!("{PASSED_OVER}: line {line}"));
        }
    }

    /// Each once, however long the header is.
    fn doubt(&mut self, doubt: String) {
        if !self.doubts.contains(&doubt) {
            self.doubts.push(doubt);
        }
    }
}

/// Keys and values are no longer; what is longer in a hostile text is not gone through again for each sign.
const LONGEST: usize = 64;

/// The word before a sign.
fn key_before(text: &str) -> String {
    let from_the_end = text.chars().rev().take(LONGEST).skip_while(|c| c.is_whitespace());
    let key: Vec<char> = from_the_end
        .take_while(|c| c.is_ascii_alphanumeric() || *c == '_')
        .collect();
    key.into_iter().rev().collect()
}

/// The word behind a sign.
fn value_behind(text: &str) -> String {
    let value = text.chars().take(LONGEST).skip_while(|c| " \t=\"'".contains(*c));
    value
        .take_while(|c| !c.is_whitespace() && !",;\"'".contains(*c))
        .collect()
}

/// The number at the beginning of a text, 0 where there is none.
fn echo_time(text: &str) -> f64 {
    let end = text
        .find(|c: char| !c.is_ascii_digit() && c != '.')
        .unwrap_or(text.len());
    text[..end].parse().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> (String, Option<&'static str>) {
        let mut claims = Claims::default();
        claims.text("a comment", text);
        (claims.doubts.join("; "), claims.modality)
    }

    #[test]
    fn what_is_no_ct_is_found_and_nothing_in_other_words() {
        for (text, words, modality) in [
            ("Modality: MR", "not a CT (MR, by a comment)", Some("MR")),
            ("a; modality = \"MET_MOD_US\", b", "not a CT (US", Some("US")),
            ("Modality=XYZ", "a modality that is not CT", None),
            ("units: cm", "the unit cm: look whether lengths", None),
            ("all lengths in cm, or so", "the unit cm: look whether lengths", None),
            ("DistanceUnits = inch", "the unit inch", None),
            ("intensity_units: SUV", "the unit suv: its numbers", None),
            ("RescaleType: US", "RescaleType is US, not HU", None),
            ("RescaleType=Doe^John", "RescaleType is something else", None),
            ("TE=2.5;Time=12.5", "the word TE", Some("MR")),
            ("3T 3D GR TR=1900ms/TE=2.3ms/FA=9deg", "the word TE", Some("MR")),
            ("brain MRI", "the word mri", None),
            ("in Bq/ml", "the word Bq/ml", None),
        ] {
            let (doubts, found) = of(text);
            assert!(doubts.contains(words) && !doubts.contains("Doe"), "{text}: {doubts}");
            assert_eq!(found, modality, "{text}");
        }
        for text in [
            "",
            "Modality: CT",
            "Modality = MET_MOD_UNKNOWN",
            "units: HU",
            "unit = mm",
            "units: Hounsfield",
            "RescaleType = HU",
            "TE=0;Time=1",
            "site: 1; mrs. Moritz, unit of care; te = x",
            "http://teem.sourceforge.net/nrrd/format.html",
            "FOV 24 cm",
            "=: = ::=\u{e9}=",
        ] {
            assert_eq!(of(text).0, "", "{text}");
        }
        // What is no CT is not made one by a second word.
        assert_eq!(of("Modality: MR, Modality: CT").1, Some("MR"));
        assert_eq!(of("Modality: CT").1, Some("CT"));
    }

    #[test]
    fn a_text_of_any_length_makes_few_doubts() {
        let text = "Modality: MR; units: cm; TE=3 mri ".repeat(10_000);
        let mut claims = Claims::default();
        claims.text("a comment", &text);
        assert!(claims.doubts.len() < 8, "{:?}", claims.doubts.len());
    }
}
