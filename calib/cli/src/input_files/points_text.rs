//! Points as plain text: three numbers a line, with blanks or commas between them.

use crate::input_files::fields;
use crate::input_files::source::Source;
use crate::register::input_error::{InputError, MAX_PAIRS, Place};

use nalgebra::Matrix3;

/// A point and the line it stands in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Point {
    pub(crate) line: usize,
    pub(crate) mm: [f64; 3],
    /// Of a file of touches that has it.
    pub(crate) error: Option<StatedError>,
}

/// What a file of touches states of a point's error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StatedError {
    /// `cxx` to `czz`, mm^2.
    pub(crate) covariance: Matrix3<f64>,
    /// `u1x` to `u3z`, mm: the part of it that all touches share; `None` where the file does not tell.
    pub(crate) shared: Option<Matrix3<f64>>,
}

impl StatedError {
    /// Of the numbers of the columns.
    pub(crate) fn of([xx, xy, xz, yy, yz, zz]: [f64; 6], shared: Option<[f64; 9]>) -> Self {
        Self {
            covariance: Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
            // By columns, as the names go and as the matrix stores them.
            shared: shared.map(|numbers| Matrix3::from_column_slice(&numbers)),
        }
    }

    /// Whether the touch's own part is a covariance, but for what the seven digits of a file may leave below zero.
    pub(crate) fn is_good(&self) -> bool {
        let own = self.own();
        let finite = self.covariance.iter().chain(own.iter()).all(|x| x.is_finite());
        finite && own.symmetric_eigenvalues().min() >= -1e-6 * self.covariance.amax()
    }

    /// What is the touch's own: the covariance without what is shared.
    pub(crate) fn own(&self) -> Matrix3<f64> {
        let shared = self.shared.unwrap_or_default();
        self.covariance - shared * shared.transpose()
    }
}

/// Columns of a covariance, mm^2.
pub(crate) const COVARIANCE: [&str; 6] = ["cxx", "cxy", "cxz", "cyy", "cyz", "czz"];
/// Columns that say what all touches of a file share, the error of the tip's calibration: what three normal numbers of deviation 1,
/// the same for all, move the place by, mm. It is in the covariance `cxx` to `czz` too.
pub(crate) const SHARED: [&str; 9] = ["u1x", "u1y", "u1z", "u2x", "u2y", "u2z", "u3x", "u3y", "u3z"];

/// Reads the points of a file.
pub(crate) fn read(source: &Source) -> Result<Vec<Point>, InputError> {
    let mut points = Vec::new();
    let mut rows = source.rows().peekable();
    let columns = rows
        .next_if(|(_, text)| is_header(text))
        .map(|(line, text)| columns(source, line, text));
    let columns = columns.transpose()?;
    for (line, text) in rows {
        if points.len() == MAX_PAIRS {
            return Err(InputError::too_many(&source.path, line));
        }
        points.push(point(source, line, text, columns.as_ref())?);
    }
    if points.is_empty() {
        return Err(InputError::NoRows {
            path: source.path.clone(),
            what: "points",
            only: "blank lines and comments",
        });
    }
    Ok(points)
}

/// The columns of a file of touches.
struct Columns {
    at: [usize; 3],
    covariance: Option<[usize; 6]>,
    shared: Option<[usize; 9]>,
    count: usize,
}

/// Whether a first line names columns, as that of `calib touch` does.
fn is_header(text: &str) -> bool {
    text.split(',').any(|field| field.trim() == "x")
}

fn columns(source: &Source, line: usize, text: &str) -> Result<Columns, InputError> {
    let found = fields::plain(text);
    let names: Vec<_> = found.iter().map(|field| field.text.clone()).collect();
    if let Some(i) = (1..names.len()).find(|i| names[..*i].contains(&names[*i])) {
        let place = Place {
            path: source.path.clone(),
            line,
            column: found[i].column,
            name: names[i].chars().take(40).collect(),
        };
        return Err(InputError::RepeatedColumn { place });
    }
    let incomplete = |expected, names_expected: &str| InputError::Ragged {
        path: source.path.clone(),
        line,
        column: 1,
        found: names.len(),
        expected,
        names: names_expected.to_owned(),
    };
    let at = all(&names, ["x", "y", "z"]).ok_or_else(|| incomplete(3, "the columns x, y and z among others"))?;
    let (covariance, shared) = (all(&names, COVARIANCE), all(&names, SHARED));
    // A part of a covariance is none, and to pass it over would make the point as exact as if it had none.
    let begun = |group: &[&str]| group.iter().any(|name| names.iter().any(|found| found == name));
    if covariance.is_none() && (begun(&COVARIANCE) || begun(&SHARED)) {
        return Err(incomplete(10, "all of cxx,cxy,cxz,cyy,cyz,czz, or none"));
    }
    if shared.is_none() && begun(&SHARED) {
        return Err(incomplete(19, "all of u1x,u1y,u1z,u2x,u2y,u2z,u3x,u3y,u3z, or none"));
    }
    Ok(Columns {
        at,
        covariance,
        shared,
        count: names.len(),
    })
}

/// Where these columns are, where all are there.
fn all<T: AsRef<str>, const N: usize>(names: &[T], wanted: [&str; N]) -> Option<[usize; N]> {
    let mut at = [0; N];
    for (place, name) in at.iter_mut().zip(wanted) {
        *place = names.iter().position(|found| found.as_ref() == name)?;
    }
    Some(at)
}

fn point(source: &Source, line: usize, text: &str, columns: Option<&Columns>) -> Result<Point, InputError> {
    let fields = fields::plain(text);
    let expected = columns.map_or(3, |columns| columns.count);
    if fields.len() != expected {
        return Err(InputError::Ragged {
            path: source.path.clone(),
            line,
            column: fields
                .get(expected)
                .map_or(text.chars().count() + 1, |field| field.column),
            found: fields.len(),
            expected,
            names: "x y z, with blanks or commas between them, or the columns of calib touch".to_owned(),
        });
    }
    let at = columns.map_or([0, 1, 2], |columns| columns.at);
    let number = |i: usize, name: &str| {
        let field = &fields[i];
        fields::coordinate(&field.text).map_err(|bad| {
            let place = Place {
                path: source.path.clone(),
                line,
                column: field.column,
                name: name.to_owned(),
            };
            InputError::number(bad, place, &field.text)
        })
    };
    let mut mm = [0.0; 3];
    for ((value, i), name) in mm.iter_mut().zip(at).zip(["x", "y", "z"]) {
        *value = number(i, name)?;
    }
    let error = columns.map(|columns| error(columns, number)).transpose()?.flatten();
    Ok(Point { line, mm, error })
}

/// The columns of the error.
fn error(
    columns: &Columns,
    number: impl Fn(usize, &str) -> Result<f64, InputError>,
) -> Result<Option<StatedError>, InputError> {
    let Some(at) = columns.covariance else { return Ok(None) };
    let mut c = [0.0; 6];
    for ((value, i), name) in c.iter_mut().zip(at).zip(COVARIANCE) {
        *value = number(i, name)?;
    }
    let mut shared = columns.shared.map(|_| [0.0; 9]);
    if let (Some(numbers), Some(at)) = (&mut shared, columns.shared) {
        for ((value, i), name) in numbers.iter_mut().zip(at).zip(SHARED) {
            *value = number(i, name)?;
        }
    }
    Ok(Some(StatedError::of(c, shared)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn parse(text: &str) -> Result<Vec<[f64; 3]>, String> {
        let source = Source::from_bytes(Path::new("p.txt"), text.into()).unwrap();
        let points = read(&source).map_err(|error| error.to_string())?;
        Ok(points.iter().map(|point| point.mm).collect())
    }

    #[test]
    fn blanks_and_commas_separate() {
        let expected = vec![[1.0, -2.0, 0.5]; 3];
        assert_eq!(parse("1 -2 0.5\n# x\n1,-2,.5\n 1\t-2  5e-1\r\n"), Ok(expected));
    }

    #[test]
    fn the_columns_of_touches_are_read_by_their_names() {
        let text = "# of a pointer\non,x,y,z,other\nbead-1,1,-2,0.5,0.1\nbead-2,4,5,6,0.1\n";
        assert_eq!(parse(text), Ok(vec![[1.0, -2.0, 0.5], [4.0, 5.0, 6.0]]));
        for (text, words) in [
            ("on,x,y,z,cxx,cxy\n", "all of cxx,cxy,cxz,cyy,cyz,czz, or none"),
            ("on,x,y,z,cxx,cxy,cxz,cyy,cyz,czz,u1x\n", "all of u1x,u1y"),
            (
                "on,x,y\na,1,2\n",
                "line 1, column 1: 3 fields, expected 3 (the columns x, y and z",
            ),
            ("on,x,y,z\na,1,2\n", "line 2, column 6: 3 fields, expected 4"),
            ("on,x,y,z\na,1,b,3\n", "line 2, column 5 (y): found \"b\""),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.contains(words), "{error}");
        }
    }

    /// The first of two columns of a name was read, and the other passed over.
    #[test]
    fn a_column_of_touches_that_is_there_twice_is_refused() {
        for (text, column) in [
            ("on,x,y,z,x\na,1,2,3,9\n", "10 (x)"),
            ("on,x,y,z,on\na,1,2,3,b\n", "10 (on)"),
        ] {
            let error = parse(text).unwrap_err();
            let words = format!("p.txt, line 1, column {column}: this column is there a second time");
            assert!(error.contains(&words), "{error}");
        }
    }

    #[test]
    fn the_error_of_a_touch_is_read() {
        let text = "on,x,y,z,cxx,cxy,cxz,cyy,cyz,czz,u1x,u1y,u1z,u2x,u2y,u2z,u3x,u3y,u3z\n\
                    a,1,2,3,4,5,6,7,8,9,11,12,13,21,22,23,31,32,33\n";
        let read = |text: &str| super::read(&Source::from_bytes(Path::new("p.txt"), text.into()).unwrap()).unwrap()[0];
        let error = read(text).error.unwrap();
        assert_eq!(
            error.covariance,
            Matrix3::new(4.0, 5.0, 6.0, 5.0, 7.0, 8.0, 6.0, 8.0, 9.0)
        );
        let by_columns = Matrix3::new(11.0, 21.0, 31.0, 12.0, 22.0, 32.0, 13.0, 23.0, 33.0);
        assert_eq!(error.shared, Some(by_columns));
        let old = read("on,x,y,z,cxx,cxy,cxz,cyy,cyz,czz\na,1,2,3,4,5,6,7,8,9\n");
        assert_eq!(old.error.map(|error| error.shared), Some(None));
        assert_eq!(read("1 2 3\n").error, None);
    }

    #[test]
    fn what_is_wrong_is_said_with_line_and_column() {
        for (text, words) in [
            ("1 2 3\n1 2\n", "p.txt: line 2, column 4: 2 fields, expected 3 (x y z"),
            ("1 2 3 4", "line 1, column 7: 4 fields, expected 3"),
            (
                "1 2 3\n\n1 b 3",
                "p.txt, line 3, column 3 (y): found \"b\", expected a number in mm",
            ),
            ("1 2 inf", "line 1, column 5 (z): found \"inf\", which is not finite"),
            ("# only\n", "there are no points in it"),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.contains(words), "{error}");
        }
    }
}
