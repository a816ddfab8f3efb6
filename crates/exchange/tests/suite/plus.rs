//! Device sets of PLUS: the published one with its calibrations, what is refused and with which words.

use exchange::plus::{self, Definition, DeviceSet};
use geometry::rotation::Rotation;
use geometry::{Marker, Point, Rigid, Tool, Vector};

/// The definitions of a device set.
fn set(transforms: &str) -> String {
    format!(
        "<PlusConfiguration version=\"2.1\"><CoordinateDefinitions>\n{transforms}\n</CoordinateDefinitions></PlusConfiguration>"
    )
}

/// The stylus of PLUS's published example.
const STYLUS: &str = r#"<Transform From="StylusTip" To="Stylus"
      Matrix="
        0.997221  0.0675365  0.0314631  194.844
        -0.06757  0.997715  0  -13.2023
        -0.0313912  -0.00212596  0.999505  -6.13342
        0  0  0  1"
       Error="0.450335" Date="091112_150057"/>"#;

fn refused(text: &str, from: &str, to: &str) -> String {
    let found = plus::read(text.as_bytes()).and_then(|set| set.find::<Marker, Tool>(from, to));
    found.unwrap_err().to_string()
}

#[test]
fn a_stylus_is_found_by_its_names_forwards_and_backwards() {
    let read = plus::read(set(STYLUS).as_bytes()).unwrap();
    let there = read.find::<Marker, Tool>("StylusTip", "Stylus").unwrap();
    let tip = there.to_from_from * Point::<Tool>::new(0.0, 0.0, 0.0);
    assert_eq!(tip.mm(), [194.844, -13.2023, -6.13342]);
    assert_eq!(
        (there.is_inverse, there.error, there.date.as_deref()),
        (false, Some(0.450335), Some("091112_150057"))
    );
    assert!(there.off > 1e-8 && there.off < 1e-5, "{}", there.off);
    let back = read.find::<Tool, Marker>("Stylus", "StylusTip").unwrap();
    assert!(back.is_inverse);
    assert!((back.to_from_from * tip).distance(Point::new(0.0, 0.0, 0.0)) < 1e-12);
}

/// Metres were read as mm, and any axes as the tool's.
#[test]
fn a_unit_or_axes_that_an_attribute_says_are_not_overruled() {
    let with = |attribute: &str| set(&STYLUS.replace("Error=", &format!("{attribute} Error=")));
    let find = |text: &str| plus::read(text.as_bytes()).and_then(|set| set.find::<Marker, Tool>("StylusTip", "Stylus"));
    for (attribute, words) in [
        ("Units=\"m\"", "line 2: the attribute Units is \"m\""),
        ("unit=\"cm\"", "expected mm, which PLUS is in"),
        (
            "CoordinateSystem=\"RAS\"",
            "line 2: the attribute CoordinateSystem is \"RAS\"",
        ),
        ("CoordinateUnits=\"inch\"", "is \"inch\""),
        ("Frame=\"LPS\"", "the frames of a transform are From and To"),
    ] {
        let said = find(&with(attribute)).unwrap_err().to_string();
        assert!(said.contains(words), "{said}");
    }
    for text in [
        set(STYLUS).replace("<CoordinateDefinitions>", "<CoordinateDefinitions Units=\"m\">"),
        set(STYLUS).replace("version=", "LengthUnit=\"m\" version="),
    ] {
        let said = find(&text).unwrap_err().to_string();
        assert!(said.contains("line 1: the attribute"), "{said}");
    }
    assert!(find(&with("Units=\"mm\" Persistent=\"TRUE\"")).is_ok());
}

/// The first that was asked for was taken, whatever the way back said.
#[test]
fn both_ways_between_two_frames_must_agree() {
    let given = plus::read(set(STYLUS).as_bytes())
        .unwrap()
        .find::<Marker, Tool>("StylusTip", "Stylus")
        .unwrap();
    let back = |x: f64, q: [f64; 4]| {
        let turn = Rotation::from_quaternion(q).unwrap();
        let miss = Rigid::<Tool, Tool>::from_parts(turn, Vector::new(x, 0.0, 0.0));
        let definition = Definition::new("Stylus", "StylusTip", &(miss * given.to_from_from.inverse()));
        let mut set = plus::read(set(STYLUS).as_bytes()).unwrap();
        set.definitions.push(definition);
        set
    };
    let still = [1.0, 0.0, 0.0, 0.0];
    for (set, good) in [
        (back(0.0, still), true),
        (back(0.02, still), true),
        (back(1.0, still), false),
        (back(-500.0, still), false),
        (back(0.0, [1.0, 0.0, 0.0, 5e-4]), false),
    ] {
        let both = [
            set.find::<Marker, Tool>("StylusTip", "Stylus")
                .map(|found| found.is_inverse),
            set.find::<Marker, Tool>("Stylus", "StylusTip")
                .map(|found| found.is_inverse),
        ];
        for one in both {
            match good {
                true => assert_eq!(one, Ok(false)),
                false => assert!(one.unwrap_err().to_string().contains("contradict one another")),
            }
        }
    }
}

#[test]
fn from_a_frame_to_itself_there_is_nothing() {
    let same = STYLUS.replace("StylusTip", "Stylus");
    let said = refused(&set(&same), "Stylus", "Stylus");
    assert!(said.contains("the tool's frame and the marker's are two"), "{said}");
}

/// A date went into reports as it was, with lines of its own.
#[test]
fn a_date_adds_no_line() {
    let dated = STYLUS.replace("091112_150057", "2020&#10;verdict accepted\u{202e}&#x9b;31m");
    let read = plus::read(set(&dated).as_bytes()).unwrap();
    assert_eq!(read.definitions[0].date.as_deref(), Some("2020?verdict accepted??31m"));
}

/// The way back is a matrix as far off as the way there, at an arm's length.
#[test]
fn what_putting_right_moves_is_told() {
    let long = "<Transform From=\"A\" To=\"B\" Matrix=\"1.0001 0 0 0 0 1.0001 0 0 0 0 1.0001 1000 0 0 0 1\"/>";
    let read = plus::read(set(long).as_bytes()).unwrap();
    let origin = Point::new(0.0, 0.0, 0.0);
    let there = read.find::<Marker, Tool>("A", "B").unwrap().moved(origin);
    assert!(there < 1e-12, "{there}");
    let back = read.find::<Marker, Tool>("B", "A").unwrap().moved(origin);
    assert!((back - (1000.0 - 1000.0 / 1.0001)).abs() < 1e-9, "{back}");
}

#[test]
fn what_was_not_asked_for_by_name_is_never_taken() {
    let scale = STYLUS.replace("0.997221", "0.0997221");
    let hand = "<Transform From=\"A\" To=\"B\" Matrix=\"1 0 0 0 0 1 0 0 0 0 -1 0 0 0 0 1\"/>";
    for (transforms, words) in [
        (
            STYLUS.replace("StylusTip", "stylustip"),
            "no transform from \"StylusTip\" to \"Stylus\", nor back; there are stylustipToStylus",
        ),
        (String::new(), "there are none"),
        (
            format!("{STYLUS}{STYLUS}"),
            "StylusTipToStylus is in the file more than once",
        ),
        (scale, "StylusTipToStylus is not rigid: its matrix is"),
        (STYLUS.replace("194.844", "nan"), "line 2: Matrix of a Transform is"),
        (STYLUS.replace("194.844", "1e300"), "16 finite numbers"),
        (STYLUS.replace("194.844", ""), "16 finite numbers"),
        (STYLUS.replace("0  0  0  1\"", "0  0  0  1 0\""), "16 finite numbers"),
        (
            STYLUS.replace("0  0  0  1\"", "0  0  1  1\""),
            "the last of them 0 0 0 1",
        ),
        (STYLUS.replace("0.450335", "small"), "Error of a Transform is \"small\""),
        (STYLUS.replace("From=\"StylusTip\" ", ""), "From of a Transform is \"\""),
        (STYLUS.replace("To=\"Stylus\"", "To=\"Stylus\" To=\"A\""), "not XML"),
    ] {
        let said = refused(&set(&transforms), "StylusTip", "Stylus");
        assert!(said.contains(words), "{words}: {said}");
    }
    assert!(
        refused(&set(hand), "A", "B").contains("AToB: matrix: a reflection"),
        "{}",
        refused(&set(hand), "A", "B")
    );
}

#[test]
fn other_xml_and_what_is_none_is_refused() {
    let entities = "<!DOCTYPE a [<!ENTITY b \"cc\">]><PlusConfiguration/>";
    for (text, words) in [
        ("<PlusConfiguration/>", "found 0 CoordinateDefinitions"),
        ("<Other><CoordinateDefinitions/></Other>", "in a <Other>"),
        (
            "<PlusConfiguration><CoordinateDefinitions/><CoordinateDefinitions/></PlusConfiguration>",
            "found 2 CoordinateDefinitions",
        ),
        (entities, "not XML"),
        ("<a><b></a>", "not XML"),
        ("", "not XML"),
    ] {
        let said = plus::read(text.as_bytes()).unwrap_err().to_string();
        assert!(said.contains(words), "{text}: {said}");
    }
    let deep = "<a>".repeat(200_000);
    assert!(plus::read(deep.as_bytes()).is_err());
    let many = set(&STYLUS.repeat(plus::MAX_TRANSFORMS + 1));
    assert!(
        plus::read(many.as_bytes())
            .unwrap_err()
            .to_string()
            .contains("at most 1024")
    );
    assert!(
        plus::read(&[b'<', 0xff])
            .unwrap_err()
            .to_string()
            .contains("byte 1 is not UTF-8")
    );
}

#[test]
fn what_is_written_is_read_to_the_bit() {
    let rotation = Rotation::from_quaternion([0.5, 0.1, -0.7, 0.5]).unwrap();
    let given = Rigid::<Marker, Tool>::from_parts(rotation, Vector::new(1.0 / 3.0, -200.125, 1e-7));
    let set = DeviceSet {
        definitions: vec![Definition {
            error: Some(0.25),
            date: Some("2026 \"a\" & <b>".to_owned()),
            ..Definition::new("Tool&Tip", "Marker", &given)
        }],
    };
    let text = plus::write(&set);
    assert_eq!(plus::read(text.as_bytes()).unwrap(), set, "{text}");
    let back = set.find::<Marker, Tool>("Tool&Tip", "Marker").unwrap().to_from_from;
    let p = Point::new(100.0, -50.0, 20.0);
    assert!((back * p).distance(given * p) < 1e-12);
}
