//! The file of a gesture: a header, then one pose a line; blank lines and lines that begin with `#` are passed over.

use std::path::Path;

use geometry::checked;

use super::{MAX_POSES, PlayedError, Timed};

/// The first line.
const HEADER: &str = "t_s,qw,qx,qy,qz,tx_mm,ty_mm,tz_mm";
/// A quaternion written with six digits is this far from unit.
const UNIT_TOLERANCE: f64 = 1e-5;
/// The last time, s: a week.
const MAX_S: f64 = 604_800.0;
/// The largest coordinate, mm.
const MAX_MM: f64 = 100_000.0;

/// One field of a line.
struct Field<'a> {
    text: &'a str,
    column: usize,
}

/// A line with its number.
struct Line<'a> {
    path: &'a Path,
    number: usize,
    text: &'a str,
}

pub(super) fn poses(text: &str, path: &Path) -> Result<Vec<Timed>, PlayedError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut lines = text
        .lines()
        .zip(1..)
        .map(|(text, number)| Line { path, number, text })
        .filter(|line| !line.text.trim().is_empty() && !line.text.trim_start().starts_with('#'));
    let empty = || PlayedError::Empty {
        path: path.to_owned(),
        header: HEADER,
    };
    let header = lines.next().ok_or_else(empty)?;
    if header.fields().map(|field| field.text).ne(HEADER.split(',')) {
        return Err(header.error(1, header.text, format!("the header {HEADER}")));
    }
    let mut poses: Vec<Timed> = Vec::new();
    for line in lines {
        if poses.len() == MAX_POSES {
            return Err(PlayedError::TooLong {
                path: path.to_owned(),
                most: MAX_POSES as u64,
                what: "poses",
            });
        }
        poses.push(line.pose(poses.last())?);
    }
    if poses.is_empty() {
        return Err(empty());
    }
    Ok(poses)
}

impl<'a> Line<'a> {
    fn fields(&self) -> impl Iterator<Item = Field<'a>> {
        let mut column = 1;
        self.text.split(',').map(move |text| {
            let blanks = text.chars().take_while(|c| c.is_whitespace()).count();
            let at = column + blanks;
            column += text.chars().count() + 1;
            Field {
                text: text.trim(),
                column: at,
            }
        })
    }

    fn pose(&self, last: Option<&Timed>) -> Result<Timed, PlayedError> {
        let mut numbers = [0.0; 8];
        let mut count = 0;
        for field in self.fields() {
            let limit = match count {
                0 => MAX_S,
                1..=4 => 1.5,
                5..=7 => MAX_MM,
                _ => return Err(self.error(field.column, field.text, "8 fields in a line".to_owned())),
            };
            numbers[count] = self.number(&field, limit)?;
            count += 1;
        }
        if count < numbers.len() {
            let end = self.text.chars().count() + 1;
            let allowed = format!("8 fields: {HEADER}");
            return Err(self.error(end, &format!("{count} fields"), allowed));
        }
        let [t_s, w, x, y, z, tx, ty, tz] = numbers;
        self.check_time(t_s, last)?;
        let ct_from_tool = checked::rigid([w, x, y, z], [tx, ty, tz], UNIT_TOLERANCE).map_err(|why| {
            let column = self.fields().nth(1).map_or(1, |field| field.column);
            self.error(column, &format!("{w}, {x}, {y}, {z}"), why.to_string())
        })?;
        Ok(Timed { t_s, ct_from_tool })
    }

    fn check_time(&self, t_s: f64, last: Option<&Timed>) -> Result<(), PlayedError> {
        let least = last.map_or(0.0, |last| last.t_s);
        if t_s < least || (last.is_some() && t_s == least) {
            let allowed = match last {
                Some(_) => format!("a time after the one before it, {least} s"),
                None => "0 s or later".to_owned(),
            };
            return Err(self.error(1, &format!("{t_s}"), allowed));
        }
        Ok(())
    }

    fn number(&self, field: &Field<'_>, limit: f64) -> Result<f64, PlayedError> {
        let number = field.text.parse().ok().filter(|x: &f64| x.abs() <= limit);
        number.ok_or_else(|| {
            let allowed = format!("a number from -{limit} to {limit}");
            self.error(field.column, &format!("{:?}", shortened(field.text)), allowed)
        })
    }

    fn error(&self, column: usize, found: &str, allowed: String) -> PlayedError {
        PlayedError::Field {
            path: self.path.to_owned(),
            line: self.number,
            column,
            found: shortened(found),
            allowed,
        }
    }
}

/// What fits into a message.
fn shortened(text: &str) -> String {
    text.chars().take(80).collect()
}
