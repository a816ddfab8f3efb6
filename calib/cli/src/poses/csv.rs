//! Poses as comma-separated values, a frame a line.

use std::path::Path;

use geometry::Uncertain;

use super::matrix::At;
use super::{PosesError, Recording, Seen, quoted};
use crate::input_files::fields::{self, BadQuote, Field};
use crate::input_files::source::Source;

/// The columns, in this or any order.
const NEEDED: [&str; 8] = ["t_s", "qw", "qx", "qy", "qz", "tx_mm", "ty_mm", "tz_mm"];
const STATUS: &str = "status";
/// The covariance of a pose: of (rotation vector in rad, translation in mm) in the tracker, turning about its origin, the
/// upper triangle by rows. All or none.
const COVARIANCE: [&str; 21] = [
    "c0", "c1", "c2", "c3", "c4", "c5", "c6", "c7", "c8", "c9", "c10", "c11", "c12", "c13", "c14", "c15", "c16", "c17",
    "c18", "c19", "c20",
];
const HINT: &str = "t_s,qw,qx,qy,qz,tx_mm,ty_mm,tz_mm and, optionally, status and c0 to c20, in any order";

/// Reads a file of poses.
pub(super) fn read(path: &Path) -> Result<Recording, PosesError> {
    from_source(&Source::read(path)?)
}

fn from_source(source: &Source) -> Result<Recording, PosesError> {
    let mut rows = source.rows();
    let empty = || PosesError::NoPoses {
        path: source.path.clone(),
        expected: "expected a line of names and a line for each frame",
    };
    let (line, text) = rows.next().ok_or_else(empty)?;
    let columns = Columns::read(source, line, text)?;
    let mut recording = Recording::new(&source.path);
    (recording.bytes, recording.blake3) = (source.bytes, source.blake3.clone());
    for (line, text) in rows {
        let (time, seen) = columns.row(source, line, text)?;
        recording.add(Some(time), seen)?;
    }
    if recording.frames == 0 {
        return Err(empty());
    }
    Ok(recording)
}

/// Where each of [`NEEDED`] and the status stand.
struct Columns {
    at: [usize; 8],
    status: Option<usize>,
    covariance: Option<[usize; 21]>,
    count: usize,
}

fn split<'a>(source: &Source, line: usize, text: &'a str) -> Result<Vec<Field<'a>>, PosesError> {
    fields::csv(text).map_err(|BadQuote(column)| PosesError::BadQuote {
        path: source.path.clone(),
        line,
        column,
    })
}

impl Columns {
    fn read(source: &Source, line: usize, text: &str) -> Result<Self, PosesError> {
        let fields = split(source, line, text)?;
        for (i, field) in fields.iter().enumerate() {
            let name = field.text.as_ref();
            let known = name == STATUS || NEEDED.contains(&name) || COVARIANCE.contains(&name);
            if !known || fields[..i].iter().any(|earlier| earlier.text == field.text) {
                let place = At {
                    path: &source.path,
                    line,
                }
                .place(field.column, &field.text);
                return Err(PosesError::BadColumn { place, hint: HINT });
            }
        }
        let find = |name: &str| fields.iter().position(|field| field.text == name);
        let missing = |missing| PosesError::MissingColumn {
            path: source.path.clone(),
            line,
            missing,
            hint: HINT,
        };
        let mut at = [0; 8];
        for (at, name) in at.iter_mut().zip(NEEDED) {
            *at = find(name).ok_or_else(|| missing(name))?;
        }
        let mut covariance = [0; 21];
        let with = COVARIANCE.iter().any(|name| find(name).is_some());
        for (at, name) in covariance.iter_mut().zip(COVARIANCE).filter(|_| with) {
            *at = find(name).ok_or_else(|| missing(name))?;
        }
        Ok(Self {
            at,
            status: find(STATUS),
            covariance: with.then_some(covariance),
            count: fields.len(),
        })
    }

    /// The time, and the pose where the frame is valid: the numbers of one that is not may be anything.
    fn row(&self, source: &Source, line: usize, text: &str) -> Result<(f64, Option<Seen>), PosesError> {
        let fields = split(source, line, text)?;
        let at = At {
            path: &source.path,
            line,
        };
        if fields.len() != self.count {
            let (path, found) = (source.path.clone(), fields.len());
            let what = "fields in a row";
            return Err(PosesError::Count {
                path,
                line,
                found,
                what,
                expected: self.count,
            });
        }
        let number = |i: usize| at.number(&fields[self.at[i]], NEEDED[i]);
        let time = number(0)?;
        if let Some(status) = self.status {
            let field = &fields[status];
            let found = field.text.to_ascii_uppercase();
            if found.is_empty() {
                return Err(PosesError::Field {
                    place: at.place(field.column, STATUS),
                    found: quoted(&field.text),
                    expected: "OK, or another word for a frame to be left out",
                });
            }
            if found != "OK" {
                return Ok((time, None));
            }
        }
        let q = [number(1)?, number(2)?, number(3)?, number(4)?];
        let mut seen = at.quaternion(q, [number(5)?, number(6)?, number(7)?])?;
        if let Some(columns) = self.covariance {
            seen.covariance = Some(covariance(&at, columns, &fields, &seen)?);
        }
        Ok((time, Some(seen)))
    }
}

/// The covariance of a pose; refused where it is none.
fn covariance(at: &At<'_>, columns: [usize; 21], fields: &[Field<'_>], seen: &Seen) -> Result<[f64; 21], PosesError> {
    let mut upper = [0.0; 21];
    for ((value, column), name) in upper.iter_mut().zip(columns).zip(COVARIANCE) {
        *value = at.number(&fields[column], name)?;
    }
    match Uncertain::from_upper(seen.pose, upper) {
        Ok(_) => Ok(upper),
        Err(source) => Err(PosesError::Covariance {
            path: at.path.to_owned(),
            line: at.line,
            source,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const HEADER: &str = "t_s,qw,qx,qy,qz,tx_mm,ty_mm,tz_mm";

    fn parse(text: &str) -> Result<Recording, String> {
        let source = Source::from_bytes(Path::new("p.csv"), text.into()).map_err(|e| e.to_string())?;
        from_source(&source)
            .and_then(|r| r.checked(false))
            .map_err(|e| e.to_string())
    }

    #[test]
    fn poses_come_in_order_and_oddities_are_counted() {
        let found = parse(&format!(
            "# a comment\n{HEADER},status\n0,1,0,0,0,1,2,3,OK\n0.1,1,0,0,0,1,2,3,ok\n0.1,0,1,0,0,1,2,4,OK\n\
             0.05,1.001,0,0,0,5,5,5,OK\n0.3,nan,,,,,,,INVALID\n"
        ));
        let found = found.unwrap();
        assert_eq!((found.frames, found.poses.len(), found.invalid), (5, 3, 1));
        assert_eq!((found.repeated, found.backwards, found.same_time), (1, 1, 1));
        assert!((found.most_off - 1e-3).abs() < 1e-15, "{}", found.most_off);
        assert_eq!(found.poses[1].translation_mm(), [1.0, 2.0, 4.0]);
        assert_eq!(found.poses[2].quaternion(), [1.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn what_is_wrong_is_told_with_its_place() {
        for (text, words) in [
            ("# nothing\n", "no pose in it"),
            (HEADER, "no pose in it"),
            ("t_s,qw\n1,2\n", "no column qx"),
            (
                &format!("{HEADER},x\n"),
                "line 1, column 35 (x): this column is not known",
            ),
            (&format!("{HEADER},qw\n"), "a second time"),
            (
                &format!("{HEADER}\n0,1,0,0,0,1,2\n"),
                "line 2: 7 fields in a row, expected 8",
            ),
            (
                &format!("{HEADER}\n0,1,0,x,0,1,2,3\n"),
                "line 2, column 7 (qy): found \"x\"",
            ),
            (
                &format!("{HEADER}\n0,1,0,0,0,1,NaN,3\n"),
                "line 2, column 13 (ty_mm): found \"NaN\"",
            ),
            (
                &format!("{HEADER}\n0,0.9,0,0,0,1,2,3\n"),
                "line 2: the rotation is off by 1.00e-1",
            ),
            (
                &format!("{HEADER},status\n0,1,0,0,0,1,2,3,LOST\n"),
                "none of its 1 frames",
            ),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.contains(words), "{text}: {error}");
        }
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "[t_sqwxyz,0-9.\n\"e-]{0,200}") {
            let _ = parse(&text);
            let _ = parse(&format!("{HEADER}\n{text}"));
        }
    }
}
