//! The mirror test: one point of one patient, written in every format, along either axes and in
//! either unit, is read as one; and a file whose axes are not those that it says is off by the mirror.

use exchange::fcsv::{self, Fiducials};
use exchange::itk;
use exchange::markups::{self, Markup, MarkupKind, Markups};
use exchange::mesh::{self, Mesh, MeshFormat};
use exchange::{ControlPoint, LengthUnit, PatientAxes, Said};
use geometry::{Ct, Model, Point, Rigid, Vector};

/// On the patient's right, in front, well off every axis.
const PLACE: Point<Ct> = Point::new(-61.25, -38.5, 912.125);
/// How exactly a file brings it back, mm.
const EXACT_MM: f64 = 1e-9;

fn point() -> ControlPoint {
    ControlPoint::new("node", PLACE)
}

/// A way of writing points, and of reading them.
type Format = (&'static str, fn(PatientAxes) -> String, fn(&str, Said) -> ControlPoint);

const FORMATS: [Format; 2] = [
    (
        "mrk.json",
        |axes| {
            let markup = Markup::new(MarkupKind::Fiducial, "", vec![point()]);
            let file = Markups {
                markups: vec![markup],
                left_out_keys: Vec::new(),
            };
            markups::write(&file, axes)
        },
        |text, said| markups::read(text.as_bytes(), said).unwrap().markups[0].points[0].clone(),
    ),
    (
        "fcsv",
        |axes| {
            fcsv::write(
                &Fiducials {
                    points: vec![point()],
                    left_out: Vec::new(),
                },
                axes,
            )
            .unwrap()
        },
        |text, said| fcsv::read(text.as_bytes(), said).unwrap().points[0].clone(),
    ),
];

/// The words by which a file says its axes.
fn word(format: &str, axes: PatientAxes) -> String {
    match (format, axes) {
        ("fcsv", PatientAxes::Ras) => "CoordinateSystem = 0".to_owned(),
        ("fcsv", PatientAxes::Lps) => "CoordinateSystem = 1".to_owned(),
        (_, axes) => format!("\"coordinateSystem\": \"{}\"", axes.name()),
    }
}

#[test]
fn one_patient_is_one_in_every_format_and_along_either_axes() {
    for (name, write, read) in FORMATS {
        for axes in PatientAxes::ALL {
            let found = read(&write(axes), Said::default());
            assert!(found.position.distance(PLACE) < EXACT_MM, "{name} {axes:?}");
        }
    }
}

#[test]
fn a_file_that_says_the_other_axes_is_off_by_the_mirror() {
    for (name, write, read) in FORMATS {
        for axes in PatientAxes::ALL {
            let other = if axes == PatientAxes::Lps {
                PatientAxes::Ras
            } else {
                PatientAxes::Lps
            };
            let text = write(axes);
            let lied = text.replace(&word(name, axes), &word(name, other));
            assert_ne!(text, lied, "{name}");
            let [x, y, z] = PLACE.mm();
            let found = read(&lied, Said::default()).position;
            assert!(found.distance(Point::new(-x, -y, z)) < EXACT_MM, "{name} {axes:?}");
            assert!(found.distance(PLACE) > 100.0, "{name} {axes:?}");
        }
    }
}

#[test]
fn what_a_person_says_stands_for_the_word_that_is_missing_and_for_the_unit() {
    for (name, write, read) in FORMATS {
        for axes in PatientAxes::ALL {
            let text = write(axes);
            let unsaid = match name {
                "fcsv" => text.replace(&format!("# {}\n", word(name, axes)), ""),
                _ => text.replace(&format!("{},", word(name, axes)), ""),
            };
            assert_ne!(text, unsaid, "{name}");
            for (unit, mm) in [(LengthUnit::Millimetre, 1.0), (LengthUnit::Metre, 1000.0)] {
                let mut in_unit = unsaid.replace("\"coordinateUnits\": \"mm\",", "");
                for component in axes.turned(PLACE.mm()) {
                    in_unit = in_unit.replace(&component.to_string(), &(component / mm).to_string());
                }
                let said = Said {
                    axes: Some(axes),
                    unit: Some(unit),
                };
                let found = read(&in_unit, said).position;
                assert!(found.distance(PLACE) < EXACT_MM, "{name} {axes:?} {unit:?}: {found:?}");
            }
        }
    }
}

/// One point of the patient in a file of bytes: of points, as a corner of a surface, or as where a transform puts the origin.
type Writer = Box<dyn Fn(Point<Ct>, PatientAxes) -> Vec<u8>>;
type Reader = Box<dyn Fn(&[u8]) -> Point<Ct>>;

fn all_formats() -> Vec<(String, Writer, Reader)> {
    let named = |place: Point<Ct>| vec![ControlPoint::new("node", place)];
    let mut all: Vec<(String, Writer, Reader)> = vec![
        (
            "mrk.json".to_owned(),
            Box::new(move |place, axes| {
                let markups = vec![Markup::new(MarkupKind::Fiducial, "", named(place))];
                let left_out_keys = Vec::new();
                markups::write(&Markups { markups, left_out_keys }, axes).into_bytes()
            }),
            Box::new(|bytes| markups::read(bytes, Said::default()).unwrap().markups[0].points[0].position),
        ),
        (
            "fcsv".to_owned(),
            Box::new(move |place, axes| {
                let (points, left_out) = (named(place), Vec::new());
                fcsv::write(&Fiducials { points, left_out }, axes).unwrap().into_bytes()
            }),
            Box::new(|bytes| fcsv::read(bytes, Said::default()).unwrap().points[0].position),
        ),
        (
            // LPS by definition, whichever axes are asked for.
            "tfm".to_owned(),
            Box::new(|place, _| {
                let turn = Vector::new(0.3, -0.2, 0.9);
                let moved = Rigid::<Ct, Model>::from_rotation_vector(turn, place - Point::new(0.0, 0.0, 0.0)).unwrap();
                itk::write(&moved).into_bytes()
            }),
            Box::new(|bytes| {
                let read = itk::read::<Ct, Model>(bytes).unwrap();
                read.to_from_from * Point::new(0.0, 0.0, 0.0)
            }),
        ),
    ];
    all.extend(MeshFormat::ALL.map(|format| {
        let write: Writer = Box::new(move |place, axes| {
            let beside = |x: f64, y: f64| place + Vector::new(x, y, 0.0);
            let points = vec![place, beside(64.0, 0.0), beside(0.0, 64.0)];
            let triangles = vec![[0, 1, 2]];
            mesh::write(&Mesh { points, triangles }, format, axes).unwrap()
        });
        let read: Reader = Box::new(move |bytes| mesh::read(bytes, format, Said::default()).unwrap().points[0]);
        (format.ending().to_owned(), write, read)
    }));
    all
}

/// From each format along either axes into each other one: 196 ways, and the patient is the same. The place has digits that the single
/// precision of STL holds.
#[test]
fn from_any_file_into_any_other_the_patient_is_the_same() {
    let (formats, mut ways) = (all_formats(), 0);
    for (from, write, read) in &formats {
        for axes in PatientAxes::ALL {
            let between = read(&write(PLACE, axes));
            for (to, write_on, read_on) in &formats {
                for axes_on in PatientAxes::ALL {
                    let found = read_on(&write_on(between, axes_on));
                    assert!(
                        found.distance(PLACE) < EXACT_MM,
                        "{from} {axes:?} -> {to} {axes_on:?}: {found:?}"
                    );
                    ways += 1;
                }
            }
        }
    }
    assert_eq!(ways, 196);
}
