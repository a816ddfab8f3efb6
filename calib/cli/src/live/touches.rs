//! The file of touched points: comma-separated values that `calib base`, `match` and `register` read, a touch a line.

use std::path::Path;

use geometry::{Tracker, UncertainPoint};

use super::LiveError;
use crate::source::Source;
use crate::store;

const HEADER: &str = "on,x,y,z,cxx,cxy,cxz,cyy,cyz,czz";

/// Adds a touch to a file, which is made where it is not there. The comment above the header says what all touches of it are
/// of; touches of something else are refused.
pub(super) fn add(path: &Path, name: &str, of: &str, place: &UncertainPoint<Tracker>) -> Result<usize, LiveError> {
    let comment = format!("# {of}");
    let (mut text, before) = match path.symlink_metadata() {
        Ok(_) => existing(path, &comment)?,
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
    let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
    text += &format!("{name},{}\n", numbers.join(","));
    store::write(path, Ok(text), std::iter::empty())?;
    Ok(before + 1)
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
    use geometry::Point;
    use nalgebra::Matrix3;

    #[test]
    fn touches_are_added_and_touches_of_something_else_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        let at = UncertainPoint::new(Point::new(1.5, -2.0, 1900.25), Matrix3::identity() * 0.25).unwrap();
        assert_eq!(add(&path, "a", "in the tracker", &at).unwrap(), 1);
        assert_eq!(add(&path, "b", "in the tracker", &at).unwrap(), 2);
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(
            text,
            format!(
                "# in the tracker\n{HEADER}\na,1.5,-2,1900.25,0.25,0,0,0.25,0,0.25\nb,1.5,-2,1900.25,0.25,0,0,0.25,0,0.25\n"
            )
        );
        let error = add(&path, "c", "in the reference", &at).unwrap_err().to_string();
        assert!(error.contains("its touches are of \"# in the tracker\""), "{error}");
        std::fs::write(&path, "# in the tracker\nx,y,z\n1,2,3\n").unwrap();
        let error = add(&path, "c", "in the tracker", &at).unwrap_err().to_string();
        assert!(error.contains("its columns are not on,x"), "{error}");
    }
}
