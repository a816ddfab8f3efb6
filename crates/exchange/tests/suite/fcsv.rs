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
        (with("0,0,0,1,", "0,x,0,1,"), "line 4: ox is \"x\""),
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

/// They were passed over as comments, and the mirror was taken when the other axes were said.
#[test]
fn axes_that_are_written_a_little_differently_are_not_overruled() {
    let row = "1,10,20,30,0,0,0,1,1,1,0,a,,\n";
    let ras = Said {
        axes: Some(PatientAxes::Ras),
        unit: None,
    };
    for head in [
        "# CoordinateSystem = LPS",
        "# coordinateSystem = LPS",
        "# COORDINATE SYSTEM=1",
        "## CoordinateSystem = LPS",
        "# Coordinate_System = LPS",
        "# CoordinateSystem: LPS",
        "# CoordinateSystem LPS",
        "# CoordinateSystem = lps",
        "# CoordinateSystem = 1.0",
        "# the coordinate system = LPS",
        "# exported along LPS",
        "# space: lps",
    ] {
        let text = format!("# Markups fiducial file version = 4.11\n{head}\n{COLUMNS}\n{row}");
        fcsv::read(text.as_bytes(), ras).expect_err(head);
    }
    let text = format!("# Markups fiducial file version = 4.11\n# coordinateSystem = 0\n{COLUMNS}\n{row}");
    assert_eq!(read(&text).points[0].position, Point::new(-10.0, -20.0, 30.0));
}

/// `exported along right-anterior-superior` beside LPS was passed over, and the mirror taken; written-out axes of the key were refused.
#[test]
fn axes_that_are_written_out_are_read_or_held_against_what_is_taken() {
    let row = "1,10,20,30,0,0,0,1,1,1,0,a,,\n";
    let left = |axes: &str| read(&file("4.11", axes, row)).points[0].position == Point::new(10.0, 20.0, 30.0);
    for axes in [
        "lps",
        "Left-Posterior-Superior",
        "left posterior superior",
        "L P S",
        "LeftPosteriorSuperior",
    ] {
        assert!(left(axes), "{axes}");
    }
    for axes in [
        "ras",
        "Right-Anterior-Superior",
        "RIGHT ANTERIOR SUPERIOR",
        "R A S",
        "r/a/s",
    ] {
        assert!(!left(axes), "{axes}");
    }
    for axes in [
        "LAS",
        "RAI",
        "left-anterior-superior",
        "R -A S",
        "superior-anterior-right",
        "right-anterior",
        "scanner",
    ] {
        let said = refused(&file("4.11", axes, row));
        assert!(said.contains("line 2: CoordinateSystem is"), "{axes}: {said}");
    }
    let beside = |comment: &str| {
        let text = file("4.11", "LPS", row).replacen(COLUMNS, &format!("# {comment}\n{COLUMNS}"), 1);
        fcsv::read(text.as_bytes(), Said::default())
            .map(drop)
            .map_err(|error| error.to_string())
    };
    for comment in [
        "exported along right-anterior-superior",
        "Right Anterior Superior coordinates",
        "axes: R A S",
        "in LAS",
        "space: left-anterior-superior",
        "reference frame = R A S",
    ] {
        let said = beside(comment).unwrap_err();
        assert!(said.contains("a comment"), "{comment}: {said}");
    }
    for comment in [
        "in left-posterior-superior",
        "from RAS to L P S",
        "the right anterior superior iliac spine",
        "frame: Left Posterior Superior",
    ] {
        assert_eq!(beside(comment), Ok(()), "{comment}");
    }
}

/// Centimetres were read as mm: no comment about units was looked at.
#[test]
fn a_unit_that_a_comment_says_is_not_overruled() {
    let row = "1,10,20,30,0,0,0,1,1,1,0,a,,\n";
    let said = |head: &str, unit| {
        let text =
            format!("# Markups fiducial file version = 4.11\n# CoordinateSystem = LPS\n{head}\n{COLUMNS}\n{row}");
        let found = fcsv::read(text.as_bytes(), Said { axes: None, unit });
        found
            .map(|file| file.points[0].position.mm()[0])
            .map_err(|error| error.to_string())
    };
    for head in [
        "# coordinateUnits = cm",
        "# Units = m",
        "# units: inch",
        "# unit = 10 mm",
        "# frame = scanner",
        "# space: LAS",
    ] {
        for unit in [None, Some(LengthUnit::Millimetre)] {
            let refused = said(head, unit).unwrap_err();
            assert!(refused.contains("line 3: a comment is"), "{refused}");
        }
    }
    let refused = said("# all in cm", None).unwrap_err();
    assert!(
        refused.contains("the word \"cm\" and its numbers would be taken in mm"),
        "{refused}"
    );
    for head in [
        "# coordinateUnits = mm",
        "# units: mm",
        "# in mm, along LPS",
        "# frame: LPS",
    ] {
        assert_eq!(said(head, None), Ok(10.0), "{head}");
    }
    // Believed, and 30 m are beyond any patient.
    let refused = said("# in m", Some(LengthUnit::Metre)).unwrap_err();
    assert!(refused.contains("30000 mm"), "{refused}");
}

/// Columns in another order were read in the usual one where the key had another case, and where there was none.
#[test]
fn columns_that_are_not_said_or_are_others_are_refused() {
    let good = file("4.11", "LPS", "1,10,20,30,0,0,0,1,1,1,0,a,,\n");
    for (to, words) in [
        ("# note".to_owned(), "there is no line `# columns"),
        (
            COLUMNS.replace("columns", "Columns").replace("x,y,z", "z,y,x"),
            "line 3: columns",
        ),
        ("# columns = label,x,y,z".to_owned(), "line 3: columns"),
        (format!("{COLUMNS}\n{COLUMNS}"), "expected them once"),
    ] {
        let said = refused(&good.replace(COLUMNS, &to));
        assert!(said.contains(words), "{to}: {said}");
    }
}

/// A file of lines that end with a carriage return alone was one comment, and had no points; a point whose id begins with `#` was one too.
#[test]
fn no_point_is_lost_among_comments() {
    let good = file(
        "4.11",
        "LPS",
        "1,10,20,30,0,0,0,1,1,1,0,a,,\n2,10,20,30,0,0,0,1,1,1,0,b,,\n",
    );
    let lps = Said {
        axes: Some(PatientAxes::Lps),
        unit: None,
    };
    for text in [
        good.replace('\n', "\r"),
        good.replace(",,\n2", ",,\r2"),
        good.replace("NodeID\n", "NodeID\r"),
    ] {
        let said = fcsv::read(text.as_bytes(), lps).unwrap_err().to_string();
        assert!(said.contains("a carriage return in the middle"), "{said}");
    }
    assert_eq!(read(&good.replace('\n', "\r\n")).points.len(), 2);
    assert_eq!(read(&format!("\u{feff}{good}")).points.len(), 2);
    let said = refused(&good.replace("\n2,", "\n#2,"));
    assert!(said.contains("line 5: a comment is \"2,10"), "{said}");
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
