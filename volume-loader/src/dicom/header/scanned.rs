//! Of which scan a slice is: what slices of one volume say alike, and may say differently with reason.

use std::sync::Arc;

use crate::dicom::element::Elements;
use crate::dicom::tag::{self as el, Tag};
use crate::dicom::text::Label;

/// Values of [`el::SCAN`], which tell slices apart; those that may name somebody are never shown. The frames of a file share them.
#[derive(Debug, Clone)]
pub(crate) struct Scan {
    values: Arc<[Option<Label>; el::SCAN.len()]>,
    /// When it was acquired, by date and time and by both in one element, seconds from a beginning that slices share: never shown but
    /// as a difference.
    pub acquired_s: [Option<f64>; 2],
    /// SliceLocation, mm.
    pub location_mm: Option<f64>,
}

impl Scan {
    pub(crate) fn of(e: &Elements) -> Self {
        let value = |tag: Tag| match tag {
            // One number may be written in several ways, and what is none is not shown.
            el::KVP | el::ACQUISITION_NUMBER | el::SERIES_NUMBER => e.reported(tag).and_then(number),
            _ => e.label(tag),
        };
        let text = |tag: Tag| e.text(tag).unwrap_or_default();
        let (date, time) = (text(el::ACQUISITION_DATE), text(el::ACQUISITION_TIME));
        let both = text(el::ACQUISITION_DATETIME);
        Self {
            values: Arc::new(el::SCAN.map(value)),
            acquired_s: [
                seconds(&date, &time),
                both.split_at_checked(8).and_then(|(date, time)| seconds(date, time)),
            ],
            location_mm: e.reported(el::SLICE_LOCATION),
        }
    }

    /// The value of one of [`el::SCAN`]; `None` where the file does not say it.
    pub(crate) fn get(&self, tag: Tag) -> Option<&Label> {
        let at = el::SCAN.iter().position(|known| *known == tag)?;
        self.values.get(at)?.as_ref()
    }
}

/// A number as what tells slices apart.
pub(crate) fn number(number: f64) -> Option<Label> {
    Label::of(number.to_string().as_bytes())
}

/// Of a date (YYYYMMDD, which may be missing) and a time of the day (HHMMSS.F, where a zone may follow); days count from 1 March of the
/// year 0.
fn seconds(date: &str, time: &str) -> Option<f64> {
    let time = time.split(['+', '-']).next()?;
    let part = |at: std::ops::Range<usize>| digits(time.get(at)?).map(f64::from);
    let [hours, minutes, whole] = [part(0..2)?, part(2..4)?, part(4..6)?];
    let fraction: f64 = match time.get(6..)? {
        "" => 0.0,
        fraction => {
            digits(fraction.strip_prefix('.')?)?;
            format!("0{fraction}").parse().ok()?
        }
    };
    let days = match date.len() {
        0 => 0,
        8 => days(
            digits(date.get(..4)?)?,
            digits(date.get(4..6)?)?,
            digits(date.get(6..)?)?,
        ),
        _ => return None,
    };
    Some(f64::from(days) * 86_400.0 + hours * 3600.0 + minutes * 60.0 + whole + fraction)
}

/// A number of nothing but digits.
fn digits(text: &str) -> Option<u32> {
    let is_number = text.bytes().all(|b| b.is_ascii_digit());
    text.parse().ok().filter(|_| is_number)
}

/// Days of the calendar from 1 March of the year 0 on.
fn days(year: u32, month: u32, day: u32) -> u32 {
    // A year begins with March, so that its last day is the leap day.
    let months = (year * 12 + month).saturating_sub(3);
    let (year, month) = (months / 12, months % 12);
    365 * year + year / 4 - year / 100 + year / 400 + (153 * month + 2) / 5 + day
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_go_on_over_days_months_and_leap_days() {
        let from = |date: &str, time: &str| seconds(date, time).unwrap();
        for (before, behind) in [
            ("20231231", "20240101"),
            ("20240131", "20240201"),
            ("20240228", "20240229"),
            ("20240229", "20240301"),
            ("20230228", "20230301"),
            ("20000229", "20000301"),
            ("19000228", "19000301"),
            ("20240430", "20240501"),
        ] {
            assert_eq!(from(behind, "000001.5") - from(before, "235959"), 2.5, "{behind}");
        }
        assert_eq!(from("", "010203.25+0100"), 3723.25);
        for (date, time) in [
            ("2024", "120000"),
            ("", ""),
            ("", "1200"),
            ("", "12000x"),
            ("", "120000.x"),
            ("", "120000,5"),
            ("\u{e9}024010", "120000"),
            ("", "12\u{e9}000"),
        ] {
            assert_eq!(seconds(date, time), None, "{date} {time}");
        }
    }
}
