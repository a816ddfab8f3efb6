//! Frames of a localizer as comma-separated values: an emitter of a frame a line.

use std::collections::BTreeMap;
use std::path::Path;

use calib::bundle::{Localizer, View};
use calib::pose::MAX_EMITTERS;
use geometry::Point;
use nalgebra::Matrix3;

use crate::input_files::columns::{Layout, Row, Table, TableError};
use crate::input_files::points_text::COVARIANCE;
use crate::input_files::source::Source;

/// The most frames: the adjustment takes all at once.
const MAX_FRAMES: usize = 10_000;

const LAYOUT: Layout = Layout {
    needed: &["frame", "emitter", "x", "y", "z"],
    optional: &[&COVARIANCE],
    hint: "frame,emitter,x,y,z and, optionally, cxx,cxy,cxz,cyy,cyz,czz, in any order",
};

/// What the localizer saw.
pub(crate) struct Frames {
    pub(crate) views: Vec<View>,
    /// The number that each view has in the file.
    pub(crate) numbers: Vec<usize>,
    /// Covariances of the sightings, where the file has them.
    pub(crate) noise: Option<Localizer>,
    /// The largest number of an emitter, and 1.
    pub(crate) emitters: usize,
    pub(crate) sightings: usize,
    pub(crate) source: Source,
}

impl Frames {
    pub(crate) fn read(path: &Path) -> Result<Self, TableError> {
        Self::from_source(Source::read(path)?)
    }

    fn from_source(source: Source) -> Result<Self, TableError> {
        let table = Table::new(&source, &LAYOUT)?;
        let with_noise = table.has(COVARIANCE[0]);
        let mut index = BTreeMap::new();
        let (mut views, mut numbers, mut each) = (Vec::<View>::new(), Vec::new(), Vec::new());
        let (mut emitters, mut sightings) = (0, 0);
        let rows = table.rows(&LAYOUT)?;
        for row in &rows {
            let frame = row.index("frame", 1_000_000_000)?;
            let emitter = row.index("emitter", MAX_EMITTERS - 1)?;
            let [x, y, z] = row.point(["x", "y", "z"])?;
            let view = *index.entry(frame).or_insert(views.len());
            if view == MAX_FRAMES {
                let (path, line) = (source.path.clone(), row.line);
                let (most, what) = (MAX_FRAMES, "frames");
                return Err(TableError::TooMany { path, line, most, what });
            }
            if view == views.len() {
                views.push(View::new());
                numbers.push(frame);
                each.push(Vec::new());
            }
            views[view].push((emitter, Point::new(x, y, z)));
            if with_noise {
                each[view].push(covariance(row)?);
            }
            emitters = emitters.max(emitter + 1);
            sightings += 1;
        }
        let noise = with_noise.then_some(Localizer::Each(each));
        Ok(Self {
            views,
            numbers,
            noise,
            emitters,
            sightings,
            source,
        })
    }
}

/// The covariance in a row.
pub(crate) fn covariance(row: &Row<'_>) -> Result<Matrix3<f64>, TableError> {
    let [xx, xy, xz] = row.point(["cxx", "cxy", "cxz"])?;
    let [yy, yz, zz] = row.point(["cyy", "cyz", "czz"])?;
    Ok(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn parse(text: &str) -> Result<Frames, String> {
        let source = Source::from_bytes(Path::new("f.csv"), text.into()).map_err(|e| e.to_string())?;
        Frames::from_source(source).map_err(|e| e.to_string())
    }

    #[test]
    fn rows_of_a_frame_come_together() {
        let found = parse("emitter,frame,x,y,z\n0,7,1,2,3\n0,5,4,5,6\n2,7,7,8,9\n").unwrap();
        assert_eq!((found.numbers, found.emitters, found.sightings), (vec![7, 5], 3, 3));
        assert_eq!(found.views[0][1], (2, Point::new(7.0, 8.0, 9.0)));
        let noisy = parse("frame,emitter,x,y,z,cxx,cxy,cxz,cyy,cyz,czz\n0,0,1,2,3,1,2,3,4,5,6\n").unwrap();
        let Some(Localizer::Each(list)) = noisy.noise else {
            panic!("no noise")
        };
        assert_eq!(list[0][0], Matrix3::new(1.0, 2.0, 3.0, 2.0, 4.0, 5.0, 3.0, 5.0, 6.0));
    }

    #[test]
    fn what_is_wrong_is_told() {
        for (text, words) in [
            ("frame,emitter,x,y\n", "no column z"),
            (
                "frame,emitter,x,y,z\n0,32,1,2,3\n",
                "column 3 (emitter): found \"32\", expected a whole number from 0 to 31",
            ),
            ("frame,emitter,x,y,z\n0,1.5,1,2,3\n", "found \"1.5\""),
            (
                "frame,emitter,x,y,z\n0,1,1,NaN,3\n",
                "line 2, column 7 (y): found \"NaN\"",
            ),
            ("frame,emitter,x,y,z,cxx\n0,1,1,2,3,1\n", "no column cxy"),
        ] {
            let error = parse(text).err().unwrap();
            assert!(error.contains(words), "{text}: {error}");
        }
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "[0-9.,\n-]{0,120}") {
            let _ = parse(&format!("frame,emitter,x,y,z\n{text}"));
        }
    }
}
