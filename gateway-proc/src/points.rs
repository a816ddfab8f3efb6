//! The places that are aimed at, as a POINT. They go outward only.

use bus::message::Guide;
use igtl::{Body, DeviceName, Landmark, Message, Name, Stamp};
use scene::Target;

use crate::letter::Letter;
use crate::place::point_in_ras;
use crate::tell::named;

const TARGET: [u8; 4] = [255, 160, 0, 255];
const CHOSEN: [u8; 4] = [0, 255, 0, 255];
const ENTRY: [u8; 4] = [0, 160, 255, 255];

/// A label as long as its field; what is longer is cut where a character ends.
fn label<const N: usize>(text: &str) -> Name<N> {
    let mut clean: String = text.chars().filter(|c| !c.is_control()).collect();
    while clean.len() > N {
        clean.pop();
    }
    Name::label(&clean).unwrap_or_default()
}

fn landmark(name: &str, group: &str, colour: [u8; 4], (mm, diameter_mm): ([f64; 3], f64)) -> Landmark {
    Landmark {
        name: label(name),
        group: label(group),
        colour,
        place: point_in_ras(mm),
        diameter: diameter_mm as f32,
        owner: DeviceName::EMPTY,
    }
}

/// The targets of the scene, the one that a person chose with its entry, in RAS; and whether there are none. A guide that is none leaves
/// the scene's.
pub(crate) fn points(targets: &[Target], guide: Option<&Guide>) -> (Letter, bool) {
    let mut all = Vec::new();
    for target in targets {
        all.push(landmark(
            &target.name,
            "Target",
            TARGET,
            (target.centre.mm(), target.diameter_mm),
        ));
        if let Some(entry) = target.entry {
            all.push(landmark(&target.name, "Entry", ENTRY, (entry.mm(), 0.0)));
        }
    }
    if let Some(Ok(Some(chosen))) = guide.map(Guide::chosen) {
        let place = (chosen.centre.mm(), 2.0 * chosen.radius_mm);
        all.push(landmark(&chosen.name, "Chosen", CHOSEN, place));
        if let Some(entry) = chosen.entry {
            all.push(landmark(&chosen.name, "ChosenEntry", CHOSEN, (entry.mm(), 0.0)));
        }
    }
    let is_empty = all.is_empty();
    let letter = Letter::new(Message {
        stamp: Stamp::NONE,
        ..Message::new(named("Targets"), Body::Points(all))
    });
    (letter, is_empty)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bus::message::Chosen;
    use geometry::Point;
    use igtl::{Limits, Version, decode};

    fn sent(targets: &[Target], guide: Option<&Guide>) -> Vec<Landmark> {
        let wire = points(targets, guide).0.wire(Version::One).unwrap();
        let bytes: Vec<u8> = wire.rest(0).iter().flat_map(|piece| piece.to_vec()).collect();
        match decode(&bytes, &Limits::POSES).unwrap().0.body {
            Body::Points(points) => points,
            other => panic!("{other:?}"),
        }
    }

    fn target(name: &str) -> Target {
        Target {
            name: name.to_owned(),
            centre: Point::new(33.0, 4.0, -50.5),
            diameter_mm: 5.0,
            entry: None,
            stop_mm: 0.0,
        }
    }

    #[test]
    fn targets_lie_on_the_same_side_of_the_patient_in_ras() {
        let chosen = Chosen {
            name: "node".to_owned(),
            centre: Point::new(33.0, 4.0, -50.5),
            radius_mm: 2.5,
            entry: Some(Point::new(90.0, -1.0, 2.0)),
            stop_mm: 0.0,
        };
        let guide = Guide::default().choosing(Some(&chosen), 1);
        let points = sent(&[target("node")], Some(&guide));
        let places: Vec<_> = points
            .iter()
            .map(|p| (p.group.to_string(), p.place, p.diameter))
            .collect();
        assert_eq!(
            places,
            [
                ("Target".to_owned(), [-33.0, -4.0, -50.5], 5.0),
                ("Chosen".to_owned(), [-33.0, -4.0, -50.5], 5.0),
                ("ChosenEntry".to_owned(), [-90.0, 1.0, 2.0], 0.0),
            ]
        );
    }

    #[test]
    fn a_name_that_is_too_long_or_no_text_is_cut_and_no_target_is_left_out() {
        let long = "ä".repeat(60) + "\n";
        let points = sent(&[target(&long), target("")], None);
        assert_eq!(points.len(), 2);
        assert_eq!(points[0].name.as_str(), Some("ä".repeat(32).as_str()));
    }

    #[test]
    fn a_guide_with_impossible_numbers_adds_no_point() {
        let guide = Guide {
            flags: Guide::CHOSEN,
            radius_mm: f64::NAN,
            ..Guide::default()
        };
        assert_eq!(sent(&[target("a")], Some(&guide)).len(), 1);
    }
}
