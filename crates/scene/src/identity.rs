//! Whose examination it is, where the scene says so: `[identity]`.
//!
//! These words are a person's. No error tells any of them: it says the key, and how long or of what kind the value is.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::values::{Checked, invalid};

/// The name of the table.
pub const TABLE: &str = "identity";
/// What stands in an error in the place of what the file says.
const WITHHELD: &str = "words that are not told";
/// Most bytes of the name, the patient's number and the description: those of the message on the bus.
const NAME_BYTES: usize = 256;
const SHORT_BYTES: usize = 64;

/// `[identity]`: each key replaces what the examination says of it.
#[derive(Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawIdentity {
    /// The patient's name, as DICOM's PN.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The patient's number in the hospital.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub patient_id: Option<String>,
    /// YYYY-MM-DD.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub birth_date: Option<String>,
    /// When the examination was made, YYYY-MM-DD.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub study_date: Option<String>,
    /// What was examined.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
}

/// Says how many keys there are, and none of their words: whoever prints a scene prints no patient.
impl fmt::Debug for RawIdentity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let given = self.words().iter().filter(|words| words.is_some()).count();
        write!(f, "RawIdentity({given} of 5)")
    }
}

impl RawIdentity {
    /// Name, patient's number, birth date, date of the examination, what was examined; `None` where the scene does not say.
    pub fn words(&self) -> [Option<&str>; 5] {
        [
            self.name.as_deref(),
            self.patient_id.as_deref(),
            self.birth_date.as_deref(),
            self.study_date.as_deref(),
            self.description.as_deref(),
        ]
    }
}

/// The table, each of its words usable as it stands.
///
/// # Errors
/// Words that are too long, that have control characters, dates that are none; without the words.
pub(super) fn checked(raw: Option<&RawIdentity>) -> Checked<Option<RawIdentity>> {
    let Some(raw) = raw else { return Ok(None) };
    let keys = ["name", "patient_id", "birth_date", "study_date", "description"];
    for (key, words) in keys.into_iter().zip(raw.words()) {
        let Some(words) = words else { continue };
        let place = format!("{TABLE}.{key}");
        match key {
            "birth_date" | "study_date" if !is_day(words) => {
                return Err(invalid(place, WITHHELD, "a day that there is, YYYY-MM-DD"));
            }
            "name" => check_words(place, words, NAME_BYTES)?,
            _ => check_words(place, words, SHORT_BYTES)?,
        }
    }
    Ok(Some(raw.clone()))
}

fn check_words(key: String, words: &str, most: usize) -> Checked<()> {
    if words.is_empty() || words.len() > most {
        let found = format!("{} bytes", words.len());
        return Err(invalid(key, found, format!("1 to {most} bytes of UTF-8")));
    }
    match words.contains(char::is_control) {
        true => Err(invalid(key, "a control character", "words without control characters")),
        false => Ok(()),
    }
}

/// Whether the text is a day of the calendar, YYYY-MM-DD, of the years 1 to 9999.
pub fn is_day(text: &str) -> bool {
    let parts: Vec<&str> = text.split('-').collect();
    let [year, month, day] = parts[..] else { return false };
    let number = |digits: &str, length: usize| {
        let plain = digits.len() == length && digits.bytes().all(|b| b.is_ascii_digit());
        plain.then(|| digits.parse::<u32>().ok()).flatten()
    };
    let (Some(year), Some(month), Some(day)) = (number(year, 4), number(month, 2), number(day, 2)) else {
        return false;
    };
    year > 0 && (1..=days_of(year, month)).contains(&day)
}

/// Days of a month; 0 where there is no such month.
fn days_of(year: u32, month: u32) -> u32 {
    let is_leap = year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    match month {
        1 | 3 | 5 | 7 | 8 | 10 | 12 => 31,
        4 | 6 | 9 | 11 => 30,
        2 => 28 + u32::from(is_leap),
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;
    use std::path::Path;

    fn parsed(table: &str) -> Result<Scene, String> {
        let text = format!("[identity]\n{table}");
        Scene::parse(&text, Path::new("s.toml")).map_err(|error| error.to_string())
    }

    #[test]
    fn words_of_the_table_are_those_of_the_scene() {
        assert_eq!(Scene::parse("", Path::new("")).unwrap().identity, None);
        let scene = parsed("name = \"山田^太郎\"\npatient_id = \"0042\"\nbirth_date = \"1952-02-29\"").unwrap();
        let words = scene.identity.as_ref().unwrap().words();
        assert_eq!(words, [Some("山田^太郎"), Some("0042"), Some("1952-02-29"), None, None]);
        // As long as the message has room for: 85 characters of three bytes and one of one.
        assert!(parsed(&format!("name = \"{}x\"", "文".repeat(85))).is_ok());
        assert!(!format!("{scene:?}").contains("太郎"));
    }

    #[test]
    fn what_cannot_be_used_is_refused_by_key_and_not_told() {
        let secret = "SECRET";
        for (table, words) in [
            (
                format!("name = \"{}\"", secret.repeat(43)),
                "line 2, column 8, key identity.name: found 258 bytes",
            ),
            (
                format!("patient_id = \"{}\"", secret.repeat(11)),
                "key identity.patient_id: found 66 bytes",
            ),
            (format!("description = \"{secret}\\u001b[2J\""), "a control character"),
            (format!("name = \"{secret}\\u0085\""), "a control character"),
            ("name = \"\"".to_owned(), "found 0 bytes"),
            (format!("birth_date = \"{secret}\""), "a day that there is"),
            (
                "study_date = \"19520230\"".to_owned(),
                "key identity.study_date: found words that are not told",
            ),
            // Of another type, or under another name.
            ("patient_id = 5243".to_owned(), "key identity.patient_id"),
            (format!("patient_id = [\"{secret}\"]"), "key identity.patient_id"),
            ("birth_date = 1952-03-04".to_owned(), "text in quotes"),
            (format!("nom = \"{secret}\""), "key identity.nom"),
        ] {
            let error = parsed(&table).unwrap_err();
            assert!(error.contains(words), "{table}: {error}");
            let told = ["SECRET", "5243", "19520230", "1952-03-04", "1952"];
            assert!(!told.iter().any(|told| error.contains(told)), "{table}: {error}");
        }
    }

    #[test]
    fn days_are_those_of_the_calendar() {
        for day in ["1952-02-29", "2000-02-29", "0001-01-01", "9999-12-31", "2026-11-30"] {
            assert!(is_day(day), "{day}");
        }
        for none in [
            "1900-02-29",
            "2026-11-31",
            "2026-00-10",
            "2026-13-01",
            "2026-01-00",
            "0000-01-01",
            "2026-1-01",
            "20260101",
            "",
            "2026-01-01 ",
            "+026-01-01",
            "2026-01-01-01",
            "٢٠٢٦-٠١-٠١",
        ] {
            assert!(!is_day(none), "{none}");
        }
        // Each month against the length that the Gregorian calendar gives a year.
        for (year, days) in [(2023, 365), (2024, 366), (1900, 365), (2000, 366)] {
            let all = (1..=12).flat_map(|month| (1..=31).map(move |day| format!("{year:04}-{month:02}-{day:02}")));
            assert_eq!(all.filter(|text| is_day(text)).count(), days, "{year}");
        }
    }
}
