//! `.mrk.json`: what is read, what is kept, what is refused and with which words.

use exchange::markups::{self, Markup, MarkupKind, Markups};
use exchange::{ControlPoint, LengthUnit, PatientAxes, Said};
use geometry::Point;
use proptest::prelude::*;

const SCHEMA: &str = "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/markups-schema-v1.0.3.json#";

/// A file of one markup with these keys.
fn file(keys: &str) -> String {
    format!("{{\"@schema\": \"{SCHEMA}\", \"markups\": [{{{keys}}}]}}")
}

/// The keys of fiducials in LPS with these control points.
fn points(points: &str) -> String {
    file(&format!(
        "\"type\": \"Fiducial\", \"coordinateSystem\": \"LPS\", \"controlPoints\": [{points}]"
    ))
}

fn refused(text: &str) -> String {
    markups::read(text.as_bytes(), Said::default()).unwrap_err().to_string()
}

/// Every key that Slicer 5 writes of a line.
const LINE: &str = r#""type": "Line", "coordinateSystem": "RAS", "coordinateUnits": "mm", "locked": true, "fixedNumberOfControlPoints": true,
    "labelFormat": "%N-%d", "lastUsedControlPointNumber": 2, "roiType": "Box", "controlPoints": [
    {"id": "1", "label": "node", "description": "d, \"e\"", "associatedNodeID": "vtkMRMLScalarVolumeNode1", "position": [-33.5, -4.25, 50.5],
     "orientation": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], "selected": false, "locked": true, "visibility": false,
     "positionStatus": "defined"},
    {"id": "2", "label": "later", "position": "", "positionStatus": "undefined"}],
    "measurements": [{"name": "length", "enabled": true, "value": 12.5, "units": "mm"}],
    "display": {"visibility": true, "opacity": 0.5, "color": [0.4, 1.0, 1.0]}"#;

#[test]
fn what_slicer_writes_is_read_and_goes_back() {
    let read = markups::read(file(LINE).as_bytes(), Said::default()).unwrap();
    let [line] = &read.markups[..] else { panic!("{read:?}") };
    assert_eq!((line.kind, line.points.len()), (MarkupKind::Line, 1));
    let point = &line.points[0];
    assert_eq!(point.position, Point::new(33.5, 4.25, 50.5));
    assert_eq!((point.id.as_str(), point.label.as_str()), ("1", "node"));
    assert_eq!((point.selected, point.locked, point.visible), (false, true, false));
    assert_eq!(point.description, "d, \"e\"");
    assert_eq!(
        (line.left_out[0].label.as_str(), line.left_out[0].status.as_str()),
        ("later", "undefined")
    );
    assert_eq!(read.left_out_keys, ["roiType"]);
    let marked = format!("\u{feff}{}", file(LINE));
    assert_eq!(markups::read(marked.as_bytes(), Said::default()).unwrap(), read);
    for axes in PatientAxes::ALL {
        let text = markups::write(&read, axes);
        assert!(
            text.contains(&format!("\"coordinateSystem\": \"{}\"", axes.name())),
            "{text}"
        );
        let again = markups::read(text.as_bytes(), Said::default()).unwrap();
        assert_eq!(again.markups[0].points, read.markups[0].points, "{text}");
        assert!(
            text.find("markups-schema-v").unwrap() < 300,
            "Slicer looks for it there"
        );
    }
}

#[test]
fn each_version_of_the_schema_is_read_and_no_other() {
    for (from, to, good) in [
        ("v1.0.3", "v1.0.0", true),
        ("v1.0.3", "v1.0.4", true),
        ("slicer/slicer/master", "Slicer/Slicer/main", true),
        ("v1.0.3", "v1.0.5", false),
        ("v1.0.3", "v2.0.0", false),
        ("v1.0.3.json#", "", false),
    ] {
        let text = points("").replace(from, to);
        assert_eq!(markups::read(text.as_bytes(), Said::default()).is_ok(), good, "{to}");
        assert!(
            good || refused(&text).contains("v1.0.0 to v1.0.4"),
            "{}",
            refused(&text)
        );
    }
}

#[test]
fn what_cannot_be_right_is_refused_by_name() {
    let lps = |rest: &str| file(&format!("\"type\": \"Fiducial\", {rest}"));
    for (text, words) in [
        (
            lps("\"controlPoints\": [{\"position\": [1, 2, 30]}]"),
            "does not say whether its coordinates are LPS or RAS",
        ),
        (
            lps("\"coordinateSystem\": \"IJK\""),
            "coordinateSystem of markup 1 is \"IJK\"",
        ),
        (lps("\"coordinateSystem\": 2"), "coordinateSystem of markup 1 is 2"),
        (
            lps("\"coordinateSystem\": \"LPS\", \"coordinateSystem\": \"RAS\""),
            "duplicate field",
        ),
        (
            lps("\"coordinateSystem\": \"LPS\", \"coordinateUnits\": \"um\""),
            "coordinateUnits of markup 1 is \"um\"",
        ),
        (
            lps("\"coordinateSystem\": \"LPS\", \"coordinateUnits\": [\"m\", \"UCUM\", \"meter\"]"),
            "\"mm\" alone is read",
        ),
        (
            file("\"type\": \"Plane\", \"coordinateSystem\": \"LPS\""),
            "markup 1 is of type \"Plane\"",
        ),
        (
            file("\"type\": \"ROI\", \"coordinateSystem\": \"LPS\""),
            "read are Fiducial, Line",
        ),
        (
            points("{\"label\": \"a\", \"position\": [1, 2]}"),
            "point 1 (\"a\") of markup 1: position is [1,2]",
        ),
        (points("{\"label\": \"a\"}"), "position is null; expected three numbers"),
        (points("{\"position\": [1, 2, \"30\"]}"), "position"),
        (points("{\"position\": [1, 2, NaN]}"), "line 1, column"),
        (points("{\"position\": [1, 2, 1e999]}"), "line 1, column"),
        (
            points("{\"position\": [1, 2, 30], \"positionStatus\": \"Defined\"}"),
            "positionStatus is Defined",
        ),
        (
            lps("\"coordinatesystem\": \"LPS\""),
            "markup 1 has the key \"coordinatesystem\", which the schema writes \"coordinateSystem\"",
        ),
        (
            lps("\"coordinateSystem\": \"LPS\", \"CoordinateUnits\": \"cm\""),
            "which the schema writes \"coordinateUnits\"",
        ),
        (
            lps("\"coordinateSystem\": \"LPS\", \"controlpoints\": []"),
            "controlPoints",
        ),
        (
            points("{\"position\": [1, 2, 30], \"positionstatus\": \"undefined\"}"),
            "point 1 of markup 1 has the key \"positionstatus\"",
        ),
        (
            points("").replace("\"markups\"", "\"Markups\": [], \"markups\""),
            "the file has the key",
        ),
        (points("{\"position\": [0.033, 0.004, 0.05]}"), "looks like metres"),
        (
            points("{\"position\": [33000, 4000, 50000]}"),
            "the largest coordinate is 50000 mm",
        ),
        (points("")[..60].to_owned(), "EOF"),
        ("[]".to_owned(), "expected an object with @schema and markups"),
        (String::new(), "EOF"),
        (lps(&format!("\"display\": {}", "[".repeat(5000))), "recursion limit"),
    ] {
        let said = refused(&text);
        assert!(said.contains(words), "{text}: {said}");
        assert!(said.len() < 400, "{said}");
    }
}

#[test]
fn a_person_settles_what_a_file_does_not_say_and_nothing_else() {
    let unsaid = file("\"type\": \"Fiducial\", \"controlPoints\": [{\"position\": [0.1, 0.2, 0.3]}]");
    let said = Said {
        axes: Some(PatientAxes::Ras),
        unit: Some(LengthUnit::Metre),
    };
    let read = markups::read(unsaid.as_bytes(), said).unwrap();
    let at = read.markups[0].points[0].position;
    assert!(at.distance(Point::new(-100.0, -200.0, 300.0)) < 1e-9, "{at:?}");
    let other = points("{\"position\": [10, 20, 30]}");
    let wrong = markups::read(other.as_bytes(), said).unwrap_err().to_string();
    assert!(wrong.contains("the file says LPS and it was said to be RAS"), "{wrong}");
}

/// A head that promises more than there is makes nothing be held for it: JSON has no head, and its length bounds what
/// is made of it.
#[test]
fn what_is_longer_than_any_such_file_is_refused_before_it_is_read() {
    let long = vec![b' '; markups::MAX_BYTES + 1];
    let said = markups::read(&long, Said::default()).unwrap_err().to_string();
    assert!(said.contains("at most 16777216"), "{said}");
    // Each of three bytes, and held as 32: of 64 MiB came 3.3 GB.
    let display = format!(
        "\"type\": \"Fiducial\", \"coordinateSystem\": \"LPS\", \"display\": [{}0]",
        "0,".repeat(markups::MAX_VALUES)
    );
    assert!(refused(&file(&display)).contains("commas, brackets and braces; at most 2000000"));
    let many = points(&vec!["{}"; markups::MAX_POINTS + 1].join(","));
    assert!(refused(&many).contains("100001 control points"), "{}", refused(&many));
}

proptest! {
    #[test]
    fn every_number_comes_back_to_the_bit(
        places in prop::collection::vec(prop::array::uniform3(-1e4..1e4f64), 1..20), label in ".{0,20}",
    ) {
        let points = places.iter().map(|[x, y, z]| ControlPoint::new(&label, Point::new(*x, *y, *z)));
        let markup = Markup::new(MarkupKind::Fiducial, &label, points.collect());
        let file = Markups { markups: vec![markup], left_out_keys: Vec::new() };
        let said = Said { axes: None, unit: Some(LengthUnit::Millimetre) };
        for axes in PatientAxes::ALL {
            let text = markups::write(&file, axes);
            prop_assert_eq!(&markups::read(text.as_bytes(), said).unwrap(), &file);
        }
    }
}

/// At the top, in a point and in keys of other names they were passed over: the mirror, or a tenth of each place.
#[test]
fn axes_and_units_that_are_said_elsewhere_are_not_overruled() {
    let with = |top: &str, markup: &str, point: &str| {
        format!(
            "{{\"@schema\": \"{SCHEMA}\", {top}\"markups\": [{{\"type\": \"Fiducial\"{markup}, \"controlPoints\": [{{\"position\": [30, 4, 50]{point}}}]}}]}}"
        )
    };
    let lps = Said {
        axes: Some(PatientAxes::Lps),
        unit: None,
    };
    let read = |text: &str| markups::read(text.as_bytes(), lps).map_err(|error| error.to_string());
    for (top, markup, point, words) in [
        (
            "\"coordinateSystem\": \"RAS\", ",
            "",
            "",
            "the file has the key \"coordinateSystem\", which says \"RAS\"",
        ),
        (
            "\"coordinateUnits\": \"cm\", ",
            "",
            "",
            "the file has the key \"coordinateUnits\", which says \"cm\"",
        ),
        (
            "\"comment\": \"coordinate system is RAS\", ",
            "",
            "",
            "the file has the key \"comment\"",
        ),
        (
            "\"comment\": \"along Right-Anterior-Superior\", ",
            "",
            "",
            "the file has the key \"comment\"",
        ),
        (
            "\"meta\": {\"made\": [\"all in cm\"]}, ",
            "",
            "",
            "the file has the key \"made\"",
        ),
        (
            "\"meta\": {\"units\": \"cm\"}, ",
            "",
            "",
            "the file has the key \"units\"",
        ),
        ("", ", \"space\": \"RAS\"", "", "markup 1 has the key \"space\""),
        ("", ", \"space\": 0", "", "markup 1 has the key \"space\", which says 0"),
        (
            "",
            ", \"units\": \"cm\", \"units\": \"mm\"",
            "",
            "markup 1 has the key \"units\"",
        ),
        (
            "",
            "",
            ", \"coordinateSystem\": \"RAS\"",
            "point 1 of markup 1 has the key \"coordinateSystem\"",
        ),
        (
            "",
            "",
            ", \"coordinateUnits\": \"cm\"",
            "point 1 of markup 1 has the key \"coordinateUnits\"",
        ),
        (
            "",
            "",
            ", \"frame\": \"scanner\"",
            "point 1 of markup 1 has the key \"frame\"",
        ),
    ] {
        let said = read(&with(top, markup, point)).unwrap_err();
        assert!(
            said.contains(words) && said.contains("taken along LPS and in mm"),
            "{said}"
        );
    }
    for (top, markup, point) in [
        ("\"coordinateSystem\": \"LPS\", \"coordinateUnits\": \"mm\", ", "", ""),
        (
            "\"comment\": \"from RAS to LPS, cm to mm\", ",
            ", \"space\": \"lps\"",
            ", \"units\": \"mm\"",
        ),
        (
            "",
            ", \"space\": \"left-posterior-superior\", \"coordinateSystem\": \"Left-Posterior-Superior\"",
            "",
        ),
    ] {
        let found = read(&with(top, markup, point)).unwrap();
        assert_eq!(found.markups[0].points[0].position, Point::new(30.0, 4.0, 50.0));
    }
}
