//! Samples and phantoms as comma-separated values.

use std::fmt::Write;
use std::path::Path;

use calib::f2554::{Phantom, Sample, Test};
use geometry::Point;

use crate::input_files::columns::{Layout, Table, TableError};
use crate::input_files::source::Source;

/// The most places of the working volume, and divots of a phantom.
const MAX_PLACES: usize = 1000;
const MAX_DIVOTS: usize = 1000;

const SAMPLES: Layout = Layout {
    needed: &["test", "divot", "x", "y", "z"],
    optional: &[&["place"], &["angle_deg"]],
    hint: "test (single, roll, pitch, yaw or distance), divot, x, y, z and, optionally, place and angle_deg, in any order",
};
const DIVOTS: Layout = Layout {
    needed: &["divot", "x", "y", "z"],
    optional: &[],
    hint: "divot,x,y,z in any order",
};

/// The divots of a phantom; they are numbered from 0 without a gap.
pub(super) fn phantom(path: &Path) -> Result<(Vec<Point<Phantom>>, Source), TableError> {
    let source = Source::read(path)?;
    let table = Table::new(&source, &DIVOTS)?;
    let mut divots = Vec::new();
    for row in table.rows(&DIVOTS)? {
        if row.index("divot", MAX_DIVOTS - 1)? != divots.len() {
            return Err(row.bad(
                "divot",
                format!("{}: divots are numbered from 0 in order", divots.len()),
            ));
        }
        let [x, y, z] = row.point(["x", "y", "z"])?;
        divots.push(Point::new(x, y, z));
    }
    Ok((divots, source))
}

/// The samples of the tests.
pub(super) fn samples(path: &Path) -> Result<(Vec<Sample>, Source), TableError> {
    let source = Source::read(path)?;
    let list = from_source(&source)?;
    Ok((list, source))
}

fn from_source(source: &Source) -> Result<Vec<Sample>, TableError> {
    let table = Table::new(source, &SAMPLES)?;
    let (placed, turned) = (table.has("place"), table.has("angle_deg"));
    let mut list = Vec::new();
    for row in table.rows(&SAMPLES)? {
        let name = row.text("test").to_lowercase();
        let test = Test::ALL.into_iter().find(|test| test.name() == name);
        let test = test.ok_or_else(|| row.bad("test", "single, roll, pitch, yaw or distance"))?;
        let [x, y, z] = row.point(["x", "y", "z"])?;
        list.push(Sample {
            place: if placed { row.index("place", MAX_PLACES)? } else { 0 },
            test,
            divot: row.index("divot", MAX_DIVOTS - 1)?,
            angle_rad: if turned {
                row.number("angle_deg")?.to_radians()
            } else {
                0.0
            },
            at: Point::new(x, y, z),
        });
    }
    Ok(list)
}

/// Samples as such a file: every digit.
pub(super) fn text(samples: &[Sample]) -> String {
    let mut text = "place,test,divot,angle_deg,x,y,z\n".to_owned();
    for s in samples {
        let [x, y, z] = s.at.mm();
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "{},{},{},{},{x},{y},{z}",
            s.place,
            s.test.name(),
            s.divot,
            s.angle_rad.to_degrees()
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use calib::f2554::Simulation;
    use proptest::prelude::*;

    fn parse(text: &str) -> Result<Vec<Sample>, String> {
        let source = Source::from_bytes(Path::new("d.csv"), text.into()).map_err(|e| e.to_string())?;
        from_source(&source).map_err(|e| e.to_string())
    }

    #[test]
    fn what_is_written_is_read() {
        let (list, _) = Simulation::default().samples().unwrap();
        let back = parse(&text(&list)).unwrap();
        assert_eq!(back.len(), list.len());
        for (a, b) in back.iter().zip(&list) {
            // Degrees and back: two roundings of up to pi.
            assert!((a.angle_rad - b.angle_rad).abs() < 1e-15, "{a:?} {b:?}");
            assert_eq!((a.place, a.test, a.divot, a.at), (b.place, b.test, b.divot, b.at));
        }
    }

    #[test]
    fn what_is_wrong_is_told() {
        for (text, words) in [
            ("test,divot,x,y,z\nspin,0,1,2,3\n", "(test): found \"spin\""),
            ("test,divot,x,y,z\nroll,-1,1,2,3\n", "(divot): found \"-1\""),
            ("test,divot,x,y\n", "no column z"),
            ("test,divot,x,y,z,place\nroll,0,1,2,3,x\n", "(place): found \"x\""),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.contains(words), "{text}: {error}");
        }
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "[a-z0-9.,\n-]{0,120}") {
            let _ = parse(&format!("test,divot,x,y,z\n{text}"));
        }
    }
}
