//! The mirror test: one point of one patient, written in every format, along either axes and in
//! either unit, is read as one; and a file whose axes are not those that it says is off by the mirror.

use exchange::fcsv::{self, Fiducials};
use exchange::markups::{self, Markup, MarkupKind, Markups};
use exchange::{ControlPoint, LengthUnit, PatientAxes, Said};
use geometry::{Ct, Point};

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
