//! `.fcsv`: versions, names with commas, what is refused and with which words.

use exchange::fcsv::{self, Fiducials};
use exchange::{ControlPoint, LengthUnit, PatientAxes, Said};
use geometry::Point;
use proptest::prelude::*;

const COLUMNS: &str = "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID";

/// A file of this version and these axes.
fn file(version: &str, axes: &str, rows: &str) -> String {
    format!("# Markups fiducial file version = {version}\n# CoordinateSystem = {axes}\n{COLUMNS}\n{rows}")
}

fn read(text: &str) -> Fiducials {
    fcsv::read(text.as_bytes(), Said::default()).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn refused(text: &str) -> String {
    fcsv::read(text.as_bytes(), Said::default()).unwrap_err().to_string()
}

#[test]
fn each_version_and_word_for_the_axes_is_read() {
    let old = "vtkMRMLMarkupsFiducialNode_0,-33.5,-4.25,50.5,0,0,0,1,1,1,0,LM-1,,\n";
    let new = "1,-33.5,-4.25,50.5,0,0,0,1,1,1,0,\"a, \"\"b\"\"\",d,vtkMRMLScalarVolumeNode1\r,2,0\r\n";
    for (version, axes, row, label) in [
        ("4.6", "0", old, "LM-1"),
        ("4.11", "RAS", old, "LM-1"),
        ("5.0", "RAS", new, "a, \"b\""),
        ("5.8", "0", new, "a, \"b\""),
    ] {
        let found = read(&file(version, axes, row));
        assert_eq!(found.points[0].position, Point::new(33.5, 4.25, 50.5), "{version}");
        assert_eq!(found.points[0].label, label);
        assert_eq!(found.points[0].orientation, None);
    }
    for axes in ["1", "LPS"] {
        let found = read(&file("4.11", axes, old));
        assert_eq!(found.points[0].position, Point::new(-33.5, -4.25, 50.5), "{axes}");
    }
    assert_eq!(
        read(&file("5.0", "1", &new.replace(",2,0", ",3,0"))).left_out[0].status,
        "missing"
    );
}

#[test]
fn what_cannot_be_right_is_refused_by_line() {
    let row = "1,10,20,30,0,0,0,1,1,1,0,a,,\n";
    let good = file("5.0", "LPS", row);
    let with = |from: &str, to: &str| good.replacen(from, to, 1);
    for (text, words) in [
        (
            with("# CoordinateSystem = LPS\n", ""),
            "does not say whether its coordinates are LPS or RAS",
        ),
        (with("= LPS", "= 2"), "line 2: CoordinateSystem is \"2\""),
        (
            with("= LPS", "= LPS\n# CoordinateSystem = RAS"),
            "line 3: CoordinateSystem is \"RAS\"; expected it once",
        ),
        (with("= 5.0", "= 3.6"), "versions 4 and 5"),
        (with("# Markups fiducial file version = 5.0\n", ""), "found none"),
        (with("id,x,y,z", "id,z,y,x"), "line 3: columns"),
        (with(",10,", ",nan,"), "line 4: x is \"nan\"; expected a finite number"),
        (with(",30,", ",,"), "line 4: z is \"\""),
        (with(",10,", ",1e999,"), "expected a finite number"),
        (with(",1,1,0,", ",1,2,0,"), "line 4: sel is \"2\""),
        (with("0,0,0,1,", "0,0,0,2,"), "ow"),
        (with(",a,", ",a,b,"), "line 4: 15 columns"),
        (with(",a,,", ",\"a,,"), "line 4: a quotation mark begins"),
        (with(",10,20,30,", ",0.01,0.02,0.03,"), "looks like metres"),
        (with(",10,", ",1e6,"), "the unit cannot be right"),
    ] {
        let said = refused(&text);
        assert!(said.contains(words), "{text}: {said}");
    }
    let bytes = [good.as_bytes(), b"\xff\xfe"].concat();
    assert!(
        fcsv::read(&bytes, Said::default())
            .unwrap_err()
            .to_string()
            .contains("line 5: not UTF-8")
    );
    let long = vec![b'\n'; fcsv::MAX_BYTES + 1];
    assert!(
        fcsv::read(&long, Said::default())
            .unwrap_err()
            .to_string()
            .contains("at most")
    );
}

#[test]
fn a_name_that_no_line_holds_is_not_written() {
    for (label, good) in [("a,b \"c\"", true), ("a\nb", false), (" a", false)] {
        let file = Fiducials {
            points: vec![ControlPoint::new(label, Point::new(10.0, 0.0, 0.0))],
            left_out: Vec::new(),
        };
        let text = fcsv::write(&file, PatientAxes::Lps);
        assert_eq!(text.is_ok(), good, "{label:?}");
        assert!(!good || read(&text.unwrap()).points[0].label == label);
    }
}

proptest! {
    #[test]
    fn every_number_comes_back_to_the_bit(
        places in prop::collection::vec(prop::array::uniform3(-1e4..1e4f64), 1..20), label in "[a-z\",#]{0,9}",
    ) {
        let points = places.iter().map(|[x, y, z]| ControlPoint::new(&label, Point::new(*x, *y, *z)));
        let file = Fiducials { points: points.collect(), left_out: Vec::new() };
        let said = Said { axes: None, unit: Some(LengthUnit::Millimetre) };
        for axes in PatientAxes::ALL {
            let text = fcsv::write(&file, axes).unwrap();
            prop_assert_eq!(&fcsv::read(text.as_bytes(), said).unwrap(), &file);
        }
    }
}
