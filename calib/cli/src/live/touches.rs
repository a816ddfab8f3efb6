//! The file of touched points: comma-separated values that `calib base`, `match` and `register` read, a touch a line.

use std::path::Path;

use geometry::{Marker, Point, Tracker, Uncertain, UncertainPoint};
use nalgebra::Matrix3;

use super::LiveError;
use crate::calibration::Gate;
use crate::input_files::columns::{Row, TableError};
use crate::input_files::source::{Source, comments};
use crate::store;
use crate::values::Name;

const HEADER: &str = "on,x,y,z,cxx,cxy,cxz,cyy,cyz,czz,u1x,u1y,u1z,u2x,u2y,u2z,u3x,u3y,u3z";

/// These of a row of a table that has them.
pub(crate) fn shared(row: &Row<'_>) -> Result<Matrix3<f64>, TableError> {
    let columns = [["u1x", "u1y", "u1z"], ["u2x", "u2y", "u2z"], ["u3x", "u3y", "u3z"]];
    let mut shared = Matrix3::zeros();
    for (k, names) in columns.into_iter().enumerate() {
        shared.set_column(k, &row.point(names)?.into());
    }
    Ok(shared)
}

/// What all touches of a file are of, which its first line, or another comment of it, says: the tool with its calibration, and the frame. Touches with another
/// calibration are places of another tip.
pub(crate) fn comment<F>(tool: &str, frame: &str, tip: &Uncertain<Marker, F>) -> String {
    format!("{PLACES}{tool}{IN}{frame}{MM}{CALIBRATION}{}", calibration_id(tip))
}

/// Which root of a covariance `u1x` to `u3z` are: files of before the symmetric one are of other numbers, and by that of another name.
const ROOT: f64 = 2.0;

/// The name of a calibration of a tip, made of its numbers: what is touched with the same one errs by the same numbers.
pub(crate) fn calibration_id<F>(tip: &Uncertain<Marker, F>) -> String {
    let rigid = tip.transform();
    let numbers = [&rigid.quaternion()[..], &rigid.translation_mm(), &tip.upper(), &[ROOT]].concat();
    format!("{:016x}", scene::registration_id(&numbers))
}

/// The calibration that a comment of a file of touches names; `None` also where [`touched_in`] refuses the file.
pub(crate) fn calibration_of(text: &str) -> Option<&str> {
    said(text).ok()??.calibration
}

const PLACES: &str = "# places of the tip of ";
/// What a comment that is meant to be that one begins with, behind its `#`.
const MEANT: &str = "places of the tip";
const IN: &str = " in the ";
const MM: &str = ", mm";
const CALIBRATION: &str = "; calibration ";

/// What a comment says of all touches of its file.
#[derive(Debug, PartialEq)]
struct Said<'a> {
    frame: &'a str,
    /// Files of before there was a calibration in them have none.
    calibration: Option<&'a str>,
}

/// What the comments of a file say of its touches, wherever in it they stand; or the number and text of the line that says it in
/// another way, or a second time: a guard that a changed letter turns off is none.
fn said(text: &str) -> Result<Option<Said<'_>>, (usize, &str)> {
    let mut meant = comments(text).filter(|(_, line)| line[1..].trim_start().starts_with(MEANT));
    let Some((number, line)) = meant.next() else {
        return Ok(None);
    };
    let said = parsed(line).ok_or((number, line))?;
    meant.next().map_or(Ok(Some(said)), Err)
}

/// Whether the comments of a file say what frame its touches are in.
pub(crate) fn says_frame(text: &str) -> bool {
    said(text).is_ok_and(|said| said.is_some())
}

fn parsed(line: &str) -> Option<Said<'_>> {
    let (of, behind) = line.strip_prefix(PLACES)?.rsplit_once(MM)?;
    let calibration = match behind {
        "" => None,
        _ => Some(behind.strip_prefix(CALIBRATION)?),
    };
    let is_id = |id: &str| id.len() == 16 && id.bytes().all(|byte| byte.is_ascii_hexdigit());
    let (_, frame) = of.rsplit_once(IN)?;
    (frame.parse::<Name>().is_ok() && calibration.is_none_or(is_id)).then_some(Said { frame, calibration })
}

/// The frame that touches are in: as their file says, which `given` must be where both are there.
pub(crate) fn touched_in(path: &Path, given: Option<&Name>) -> Result<Option<Name>, LiveError> {
    let source = Source::read(path)?;
    let said = said(&source.text).map_err(|(line, found)| LiveError::UnreadPlaces {
        path: path.to_owned(),
        line,
        found: found.chars().take(120).collect(),
    })?;
    match (said.map(|said| said.frame), given) {
        (Some(found), Some(given)) if given.as_str() != found => Err(LiveError::OtherFrame {
            path: path.to_owned(),
            found: found.to_owned(),
            given: given.as_str().to_owned(),
        }),
        (found, given) => Ok(given.cloned().or_else(|| found.map(Name::told))),
    }
}

/// The touches of a file: the name and place of each.
pub(crate) fn read_touches(path: &Path) -> Result<Vec<(String, UncertainPoint<Tracker>)>, LiveError> {
    let source = Source::read(path)?;
    let other = |what: &str| LiveError::OtherTouches {
        path: path.to_owned(),
        what: what.to_owned(),
    };
    let mut touches = Vec::new();
    for (_, row) in source.rows().skip(1) {
        let (name, numbers) = row.split_once(',').ok_or_else(|| other("a line has no columns"))?;
        let numbers: Result<Vec<f64>, _> = numbers.split(',').map(str::parse).collect();
        let numbers = numbers.unwrap_or_default();
        // With what all touches share, or without.
        let ([x, y, z, xx, xy, xz, yy, yz, zz, ..], 9 | 18) = (&numbers[..], numbers.len()) else {
            return Err(other("a line has neither 9 nor 18 numbers behind its name"));
        };
        let [x, y, z, xx, xy, xz, yy, yz, zz] = [*x, *y, *z, *xx, *xy, *xz, *yy, *yz, *zz];
        let covariance = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        touches.push((name.to_owned(), UncertainPoint::new(Point::new(x, y, z), covariance)?));
    }
    Ok(touches)
}

/// Adds a touch to a file, which is made where it is not there, below the gates that it kept. `comment`, the first line, says
/// what all touches of it are of; touches of something else are refused.
pub(super) fn add(
    path: &Path,
    name: &str,
    comment: &str,
    (place, shared): (&UncertainPoint<Tracker>, &Matrix3<f64>),
    gates: &[Gate],
) -> Result<usize, LiveError> {
    let (mut text, before) = match path.symlink_metadata() {
        Ok(_) => existing(path, comment)?,
        Err(_) => (format!("{comment}\n{HEADER}\n"), 0),
    };
    let ([x, y, z], c) = (place.point().mm(), place.covariance());
    let numbers = [
        x,
        y,
        z,
        c[(0, 0)],
        c[(0, 1)],
        c[(0, 2)],
        c[(1, 1)],
        c[(1, 2)],
        c[(2, 2)],
    ];
    // By columns, as they are stored.
    let numbers: Vec<String> = numbers.iter().chain(shared.iter()).map(f64::to_string).collect();
    for gate in gates {
        text += &format!("# {}: {}\n", gate.words(), gate.found_words());
    }
    text += &format!("{name},{}\n", numbers.join(","));
    store::write(path, Ok(text), std::iter::empty())?;
    Ok(before + 1)
}

/// The same without gates, of a tool in a frame.
pub(super) fn add_of<F>(
    path: &Path,
    (name, tool, frame): (&str, &str, &str),
    tip: &Uncertain<Marker, F>,
    place: (&UncertainPoint<Tracker>, &Matrix3<f64>),
) -> Result<usize, LiveError> {
    add(path, name, &comment(tool, frame, tip), place, &[])
}

/// The text of a file of touches of the same, and how many it has.
fn existing(path: &Path, comment: &str) -> Result<(String, usize), LiveError> {
    let source = Source::read(path)?;
    let other = |what: String| LiveError::OtherTouches {
        path: path.to_owned(),
        what,
    };
    let first = source.text.lines().next().unwrap_or_default();
    if first != comment {
        let found: String = first.chars().take(120).collect();
        return Err(other(format!(
            "its touches are of {found:?}, this one is of {comment:?}"
        )));
    }
    let mut rows = source.rows();
    if rows.next().map(|(_, row)| row.trim()) != Some(HEADER) {
        return Err(other(format!("its columns are not {HEADER}")));
    }
    let count = rows.count();
    let end = if source.text.ends_with('\n') { "" } else { "\n" };
    Ok((source.text.clone() + end, count))
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Tool;
    use geometry::{Rigid, Vector};

    /// A calibration of a tip so far along z.
    fn tip(z_mm: f64) -> Uncertain<Marker, Tool> {
        let along = Vector::new(0.0, 0.0, z_mm);
        Rigid::from_rotation_vector(Vector::new(0.0, 0.0, 0.0), along)
            .unwrap()
            .into()
    }

    fn comment(tool: &str, frame: &str) -> String {
        super::comment(tool, frame, &tip(100.0))
    }

    /// Three touches with one calibration and two with another were a registration that could be accepted.
    #[test]
    fn touches_with_another_calibration_are_of_something_else() {
        let of = |z_mm: f64| super::comment("scope", "tracker", &tip(z_mm));
        assert_eq!(of(100.0), of(100.0));
        assert_ne!(of(100.0), of(100.0 + 1e-9));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        let place = UncertainPoint::new(Point::new(1.5, -2.0, 1900.25), Matrix3::identity() * 0.25).unwrap();
        let shared = Matrix3::new(0.5, 0.0, 0.25, 0.0, 0.125, 0.0, 0.0, 0.0, 0.0);
        let at = (&place, &shared);
        add(&path, "a", &of(100.0), at, &[]).unwrap();
        let error = add(&path, "b", &of(102.0), at, &[]).unwrap_err().to_string();
        assert!(error.contains("its touches are of"), "{error}");
        assert_eq!(add(&path, "b", &of(100.0), at, &[]).unwrap(), 2);
    }

    #[test]
    fn touches_are_added_and_touches_of_something_else_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        let place = UncertainPoint::new(Point::new(1.5, -2.0, 1900.25), Matrix3::identity() * 0.25).unwrap();
        let shared = Matrix3::new(0.5, 0.0, 0.25, 0.0, 0.125, 0.0, 0.0, 0.0, 0.0);
        let at = (&place, &shared);
        let gate = Gate {
            name: "max-rms-mm".to_owned(),
            limit: 0.5,
            found: 0.25,
            kept: true,
            of: Some("tracker.calibration.gates of run or".to_owned()),
        };
        assert_eq!(add(&path, "a", &comment("scope", "tracker"), at, &[]).unwrap(), 1);
        assert_eq!(add(&path, "b", &comment("scope", "tracker"), at, &[gate]).unwrap(), 2);
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(
            text,
            format!(
                "{}\n{HEADER}\na,1.5,-2,1900.25,0.25,0,0,0.25,0,0.25,0.5,0,0,0,0.125,0,0.25,0,0\n\
                 # max_rms_mm 0.5 (tracker.calibration.gates of run or): found 0.2500\n\
                 b,1.5,-2,1900.25,0.25,0,0,0.25,0,0.25,0.5,0,0,0,0.125,0,0.25,0,0\n",
                comment("scope", "tracker")
            )
        );
        let error = add(&path, "c", &comment("scope", "reference"), at, &[])
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("its touches are of \"# places of the tip of scope in the tracker, mm; calibration "),
            "{error}"
        );
        std::fs::write(&path, "# in the tracker\nx,y,z\n1,2,3\n").unwrap();
        let error = add(&path, "c", "# in the tracker", at, &[]).unwrap_err().to_string();
        assert!(error.contains("its columns are not on,x"), "{error}");
    }

    #[test]
    fn touches_say_the_frame_that_they_are_in() {
        let frame_of = |text: &str| match said(text) {
            Ok(said) => Ok(said.map(|said| said.frame.to_owned())),
            Err((line, _)) => Err(line),
        };
        let reference = Ok(Some("reference".to_owned()));
        assert_eq!(frame_of(&comment("a scope in the box", "reference")), reference);
        assert_eq!(frame_of("# places of the tip of a in the reference, mm"), reference);
        assert_eq!(frame_of(""), Ok(None));
        assert_eq!(frame_of("x,y,z"), Ok(None));
        for line in [
            "# places of the tip of a in the b, mm and more",
            "# places of the tip of a in the b",
            "# places of the tip of a in the b c, mm",
        ] {
            assert_eq!(frame_of(line), Err(1), "{line}");
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        std::fs::write(&path, comment("scope", "reference") + "\nx,y,z\n1,2,3\n").unwrap();
        let told = |given: Option<&str>| touched_in(&path, given.map(Name::told).as_ref());
        for given in [None, Some("reference")] {
            assert_eq!(told(given).unwrap().unwrap().as_str(), "reference");
        }
        let error = told(Some("tracker")).unwrap_err().to_string();
        assert!(
            error.contains("its touches are in the reference, and tracker is said"),
            "{error}"
        );
    }

    /// A byte order mark, a note above, or metres in the place of millimetres turned the guards of frame and calibration off.
    #[test]
    fn what_touches_are_of_is_read_from_a_changed_file_or_refused() {
        let line = super::comment("scope", "tracker", &tip(100.0));
        let id = calibration_of(&line).unwrap().to_owned();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        let told = |text: &str| {
            std::fs::write(&path, text).unwrap();
            touched_in(&path, Some(&Name::told("reference"))).map_err(|error| error.to_string())
        };
        let rows = "x,y,z\n1,2,3\n";
        for read in [
            format!("\u{feff}{line}\n{rows}"),
            format!("# ward 4\n\n{line}\r\n{rows}"),
            format!("{rows}  {line}  \n"),
        ] {
            let error = told(&read).unwrap_err();
            assert!(
                error.contains("in the tracker, and reference is said"),
                "{read}: {error}"
            );
            assert_eq!(calibration_of(&read), Some(&*id));
        }
        for (number, other) in [
            (1, line.replace(", mm", ", m")),
            (1, line.replace("# places", "#places")),
            (1, line.replace(&id, "0")),
            (1, line.replace(" in the tracker", "")),
            (1, format!("{line},,,")),
            (2, format!("{line}\n{line}")),
        ] {
            let error = told(&format!("{other}\n{rows}")).unwrap_err();
            assert!(error.contains(&format!("line {number} is")), "{other}: {error}");
            assert!(
                error.contains("expected once \"# places of the tip of TOOL in the FRAME, mm"),
                "{error}"
            );
            assert_eq!(calibration_of(&other), None, "{other}");
        }
    }
}
