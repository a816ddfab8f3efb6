//! A plan's targets and entries as points of other programs, and back.
//!
//! A point is a target, named by its label. One whose label ends in the word `entry`, behind the name of a target, is
//! that target's entry: `node` and `node entry`. Names are in labels, as 3D Slicer forgets those of whole markups. A
//! label that has the word in any other way is refused: an entry that became a target would be aimed at.
//! Diameter and stop distance stand in the target's description.

use exchange::ControlPoint;
use exchange::markups::{Markup, MarkupKind};
use guidance::plan::{Edit, Editor, Measure, PlanError, Target};

/// A target's diameter where nobody says another, mm.
pub(crate) const DIAMETER_MM: f64 = 5.0;
/// The word that makes a point an entry.
const ENTRY: &str = "entry";
/// What a description of sizes begins with.
const DIAMETER: &str = "diameter_mm=";
/// What stands between a target's name and that word.
const BETWEEN: [char; 3] = [' ', '-', '_'];

/// Most points that an error names.
const MOST_NAMED: usize = 8;

/// Why points are no targets, or targets no points.
#[derive(Debug, thiserror::Error)]
pub(crate) enum PointsError {
    #[error(
        "markup {markup} is a {}; targets and entries are read of a Fiducial and a Line, and a measure of an Angle. Save these alone",
        .kind.name()
    )]
    Kind { markup: usize, kind: MarkupKind },
    #[error(
        "markup {markup} is a Line with the points {labels}; of a way, one of two points is named as the target and the other with `entry` \
         behind that name, for instance `node` and `node entry`: which end of a line is the entry is not guessed"
    )]
    Line { markup: usize, labels: String },
    #[error("markup {markup} is an Angle of {found} points; three are needed")]
    Angle { markup: usize, found: usize },
    #[error("point {label:?}: by its name it is an entry, and {source}")]
    Entry { label: String, source: PlanError },
    #[error(
        "point {label:?} has `entry` in its name and is not named as one is: an entry is a target's name, then one of blank, - and _, then \
         `entry` and nothing more, for instance `node entry`. Name it so, or without that word if it is a target"
    )]
    EntryWord { label: String },
    #[error(
        "point {label:?}: target {name:?} has an entry already, and which of two holds is not guessed; keep one of them in what is imported, \
         or take the target out of the plan in the same command (--remove) and import it with its entry"
    )]
    SecondEntry { label: String, name: String },
    #[error(
        "point {label:?}: its description is {found:?}, and sizes are read as `diameter_mm=8.1 stop_mm=4.3`, with points and nothing else; a \
         target of another size would be shown"
    )]
    Sizes { label: String, found: String },
    #[error("there is no point with a place in it{}", empty_ones(.left_out))]
    Empty { left_out: Vec<String> },
    #[error("target {name:?} has `entry` in its name and would not be read again as a target; rename it (--rename)")]
    Name { name: String },
    #[error(transparent)]
    Plan(#[from] PlanError),
}

fn empty_ones(left_out: &[String]) -> String {
    match left_out.is_empty() {
        true => String::new(),
        false => format!("; without one are {}", left_out.join(", ")),
    }
}

/// What was taken of a file.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Taken {
    pub(crate) targets: usize,
    pub(crate) entries: usize,
    pub(crate) measures: usize,
    /// Labels of points whose description is not kept: a plan has none.
    pub(crate) descriptions: Vec<String>,
}

/// Takes the markups of a file into a plan: targets first, so that an entry may stand before its target.
pub(crate) fn take(editor: &mut Editor, markups: &[Markup]) -> Result<Taken, PointsError> {
    let mut taken = Taken::default();
    let mut points = Vec::new();
    for (markup, number) in markups.iter().zip(1..) {
        match markup.kind {
            MarkupKind::Fiducial => points.extend(&markup.points),
            MarkupKind::Line => points.extend(way(number, markup)?),
            MarkupKind::Angle => {
                editor.edit(Edit::Measure(angle(number, markup)?))?;
                taken.measures += 1;
            }
            kind @ (MarkupKind::Curve | MarkupKind::ClosedCurve) => {
                return Err(PointsError::Kind { markup: number, kind });
            }
        }
    }
    if let Some(point) = points.iter().find(|point| is_unclear(&point.label)) {
        let label = point.label.clone();
        return Err(PointsError::EntryWord { label });
    }
    let (entries, targets): (Vec<&ControlPoint>, Vec<_>) =
        points.into_iter().partition(|p| target_of(&p.label).is_some());
    for point in targets {
        editor.edit(Edit::Add(target(point, &mut taken)?))?;
        taken.targets += 1;
    }
    for point in entries {
        if !point.description.is_empty() {
            taken.descriptions.push(point.label.clone());
        }
        enter(editor, point)?;
        taken.entries += 1;
    }
    if taken.targets + taken.entries + taken.measures == 0 {
        let empty = markups.iter().flat_map(|markup| &markup.left_out);
        let left_out = empty
            .take(MOST_NAMED)
            .map(|left| format!("{:?} ({})", left.label, left.status));
        return Err(PointsError::Empty {
            left_out: left_out.collect(),
        });
    }
    Ok(taken)
}

/// The name of the target that a point of this label is the entry of.
fn target_of(label: &str) -> Option<&str> {
    let at = label
        .len()
        .checked_sub(ENTRY.len())
        .filter(|at| label.is_char_boundary(*at))?;
    let (name, word) = label.split_at(at);
    let name = name.strip_suffix(BETWEEN)?;
    (word.eq_ignore_ascii_case(ENTRY) && !name.is_empty()).then_some(name)
}

/// Whether a label has the word in it and is not that of an entry: `entry-1`, `nodeEntry`, one with another blank. What nobody sees of it,
/// hyphens that are not shown and blanks without a width, does not hide the word.
fn is_unclear(label: &str) -> bool {
    let is_seen = |c: &char| !matches!(c, '\u{ad}' | '\u{200b}'..='\u{200f}' | '\u{2060}'..='\u{2064}' | '\u{feff}');
    let seen: String = label.chars().filter(is_seen).collect();
    seen.to_lowercase().contains(ENTRY)
        && target_of(label).is_none_or(|name| is_unclear(name) || target_of(name).is_some())
}

/// The two points of a line, which must be a target and its entry.
fn way(markup: usize, line: &Markup) -> Result<&[ControlPoint], PointsError> {
    let is_way = match &line.points[..] {
        [a, b] => target_of(&a.label) == Some(&b.label) || target_of(&b.label) == Some(&a.label),
        _ => false,
    };
    if is_way {
        return Ok(&line.points);
    }
    let labels: Vec<String> = line
        .points
        .iter()
        .take(4)
        .map(|point| format!("{:?}", point.label))
        .collect();
    let labels = if labels.is_empty() {
        "none".to_owned()
    } else {
        labels.join(", ")
    };
    Err(PointsError::Line { markup, labels })
}

fn angle(markup: usize, angle: &Markup) -> Result<Measure, PointsError> {
    match &angle.points[..] {
        [a, b, c] => Ok(Measure::Angle([a.position, b.position, c.position])),
        points => Err(PointsError::Angle {
            markup,
            found: points.len(),
        }),
    }
}

fn target(point: &ControlPoint, taken: &mut Taken) -> Result<Target, PointsError> {
    let sizes = sizes(&point.description);
    if sizes.is_none() && has_size(&point.description) {
        let (label, found) = (point.label.clone(), point.description.chars().take(64).collect());
        return Err(PointsError::Sizes { label, found });
    }
    if sizes.is_none() && !point.description.is_empty() {
        taken.descriptions.push(point.label.clone());
    }
    let (diameter_mm, stop_mm) = sizes.unwrap_or((DIAMETER_MM, 0.0));
    Ok(Target {
        name: point.label.clone(),
        centre: point.position,
        diameter_mm,
        entry: None,
        stop_mm,
    })
}

fn enter(editor: &mut Editor, point: &ControlPoint) -> Result<(), PointsError> {
    let name = target_of(&point.label).unwrap_or_default();
    let refused = |source| PointsError::Entry {
        label: point.label.clone(),
        source,
    };
    let Some(target) = editor.plan().target(name).cloned() else {
        let names = editor.plan().targets.iter().map(|target| target.name.clone()).collect();
        let name = name.to_owned();
        return Err(refused(PlanError::NoTarget { name, names }));
    };
    // A second one must not take the place of the first unasked: nobody would see which of two ways is planned.
    if target.entry.is_some() {
        return Err(PointsError::SecondEntry {
            label: point.label.clone(),
            name: target.name,
        });
    }
    let entered = Target {
        entry: Some(point.position),
        ..target
    };
    editor.edit(Edit::Change(name.to_owned(), entered)).map_err(refused)
}

/// Whether a description says a size in some way: it has a number and a word of one, `diameter: 8 mm`.
fn has_size(description: &str) -> bool {
    let lower = description.to_lowercase();
    let has_number = lower.contains(|c: char| c.is_numeric());
    let mut words = lower.split(|c: char| !c.is_alphabetic());
    let has_word = ["diameter", "diametre", "radius", "\u{f8}", "\u{2300}", "\u{2205}"]
        .iter()
        .any(|word| lower.contains(word));
    (has_number && (has_word || words.any(|word| word == "stop"))) || lower.contains(DIAMETER)
}

/// Diameter and stop distance, mm, of a description that is nothing else.
fn sizes(description: &str) -> Option<(f64, f64)> {
    let (diameter, stop) = description.strip_prefix(DIAMETER)?.split_once(" stop_mm=")?;
    Some((diameter.parse().ok()?, stop.parse().ok()?))
}

/// The targets as markups: those with an entry a line each, all others a list.
pub(crate) fn markups(targets: &[Target]) -> Result<Vec<Markup>, PointsError> {
    // Whatever has the word in it is no target to those who read it, here too.
    let is_entry = |name: &str| is_unclear(name) || target_of(name).is_some();
    if let Some(target) = targets.iter().find(|target| is_entry(&target.name)) {
        let name = target.name.clone();
        return Err(PointsError::Name { name });
    }
    let (ways, alone): (Vec<&Target>, Vec<_>) = targets.iter().partition(|target| target.entry.is_some());
    let line = |target: &&Target| Markup::new(MarkupKind::Line, &target.name, of(target));
    let mut markups: Vec<Markup> = ways.iter().map(line).collect();
    if !alone.is_empty() {
        let points = alone.iter().flat_map(|target| of(target)).collect();
        markups.push(Markup::new(MarkupKind::Fiducial, "targets", points));
    }
    Ok(markups)
}

/// The entry, where there is one, and the target: in the order of the way.
fn of(target: &Target) -> Vec<ControlPoint> {
    let label = format!("{} {ENTRY}", target.name);
    let entry = target.entry.map(|entry| ControlPoint::new(&label, entry));
    let centre = ControlPoint {
        description: format!("{DIAMETER}{} stop_mm={}", target.diameter_mm, target.stop_mm),
        ..ControlPoint::new(&target.name, target.centre)
    };
    entry.into_iter().chain([centre]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Point;
    use guidance::plan::Plan;
    use guidance::workflow::VolumeId;

    fn editor() -> Editor {
        Editor::new(Plan::new(VolumeId([1; 32])))
    }

    fn point(label: &str, x: f64) -> ControlPoint {
        ControlPoint::new(label, Point::new(x, 0.0, 0.0))
    }

    fn taken(kind: MarkupKind, points: Vec<ControlPoint>) -> Result<(Plan, Taken), String> {
        let mut editor = editor();
        let taken = take(&mut editor, &[Markup::new(kind, "", points)]).map_err(|error| error.to_string())?;
        Ok((editor.plan().clone(), taken))
    }

    #[test]
    fn a_plan_goes_out_and_comes_back_whole() {
        let mut made = editor();
        for (name, entry) in [("node", Some(Point::new(90.0, 0.0, 0.0))), ("hilus", None)] {
            let target = Target {
                name: name.to_owned(),
                centre: Point::new(1.25, -3.0, 40.5),
                diameter_mm: 8.1,
                entry,
                stop_mm: 4.3,
            };
            made.edit(Edit::Add(target)).unwrap();
        }
        let mut back = editor();
        let markups = markups(&made.plan().targets).unwrap();
        assert_eq!(
            markups.iter().map(|m| m.kind).collect::<Vec<_>>(),
            [MarkupKind::Line, MarkupKind::Fiducial]
        );
        let taken = take(&mut back, &markups).unwrap();
        assert_eq!((taken.targets, taken.entries, taken.descriptions.len()), (2, 1, 0));
        assert_eq!(back.plan().targets, made.plan().targets);
    }

    #[test]
    fn an_entry_is_known_by_its_name_wherever_it_stands() {
        for word in [" entry", "-Entry", "_ENTRY"] {
            let points = vec![point(&format!("a{word}"), 50.0), point("a", 1.0)];
            let (plan, _) = taken(MarkupKind::Fiducial, points).unwrap();
            assert_eq!(plan.targets[0].entry, Some(Point::new(50.0, 0.0, 0.0)), "{word}");
        }
        for label in ["entry", " entry", "reentry", "entry a", "\u{e9}ntry"] {
            assert_eq!(target_of(label), None, "{label}");
        }
    }

    /// The second one won, and nothing was said: a fiducial's, a line's, that of another file, and one over the plan's.
    #[test]
    fn a_second_entry_for_a_target_never_takes_the_place_of_the_first() {
        let first = Markup::new(
            MarkupKind::Line,
            "",
            vec![point("node", 1.0), point("node entry", 50.0)],
        );
        for label in ["node entry", "node_entry", "node-ENTRY"] {
            let second = Markup::new(MarkupKind::Fiducial, "", vec![point(label, -50.0)]);
            let at_once = take(&mut editor(), &[first.clone(), second.clone()]);
            let mut editor = editor();
            take(&mut editor, std::slice::from_ref(&first)).unwrap();
            let one_by_one = take(&mut editor, &[second]);
            for refused in [at_once, one_by_one] {
                let said = refused.unwrap_err().to_string();
                assert!(said.contains("target \"node\" has an entry already"), "{said}");
            }
            assert_eq!(editor.plan().targets[0].entry, Some(Point::new(50.0, 0.0, 0.0)));
        }
    }

    /// They became targets, which are aimed at.
    #[test]
    fn what_has_the_word_entry_and_is_not_named_as_one_is_no_target() {
        for label in [
            "node\u{a0}entry",
            "node entry-1",
            "node entry 1",
            "entry node",
            "node entry point",
            "Entry",
            "nodeEntry",
            "node entry\u{200b}",
            "node en\u{ad}try",
            "node entry ",
            "node entry entry",
        ] {
            let said = taken(MarkupKind::Fiducial, vec![point("node", 1.0), point(label, 50.0)]).unwrap_err();
            assert!(said.contains("has `entry` in its name"), "{label}: {said}");
        }
        for label in ["center", "Eintritt", "ent ry"] {
            let (plan, _) = taken(MarkupKind::Fiducial, vec![point(label, 50.0)]).unwrap();
            assert_eq!(plan.targets[0].name, label);
        }
    }

    #[test]
    fn a_file_without_a_point_that_has_a_place_is_refused() {
        assert!(
            taken(MarkupKind::Fiducial, Vec::new())
                .unwrap_err()
                .contains("there is no point with a place")
        );
        let mut markup = Markup::new(MarkupKind::Fiducial, "", Vec::new());
        markup.left_out.push(exchange::LeftOut {
            label: "node".to_owned(),
            status: "undefined".to_owned(),
        });
        let said = take(&mut editor(), &[markup]).unwrap_err().to_string();
        assert!(said.contains("without one are \"node\" (undefined)"), "{said}");
    }

    #[test]
    fn what_is_no_target_is_refused_by_name() {
        let two = |a: &str, b: &str| vec![point(a, 1.0), point(b, 50.0)];
        for (kind, points, words) in [
            (
                MarkupKind::Line,
                two("L-1", "L-2"),
                "a Line with the points \"L-1\", \"L-2\"",
            ),
            (
                MarkupKind::Line,
                two("a", "b entry"),
                "which end of a line is the entry is not guessed",
            ),
            (MarkupKind::Line, Vec::new(), "with the points none"),
            (MarkupKind::Curve, two("a", "b"), "markup 1 is a Curve"),
            (MarkupKind::Angle, two("a", "b"), "an Angle of 2 points"),
            (MarkupKind::Fiducial, two("a", "a"), "there is a target \"a\" already"),
            (
                MarkupKind::Fiducial,
                two("a", "b entry"),
                "\"b entry\": by its name it is an entry, and there is no target \"b\"",
            ),
            (MarkupKind::Fiducial, two("a", ""), "the target's name: found \"\""),
            (
                MarkupKind::Fiducial,
                vec![point("a", 1.0), point("a entry", 1.5)],
                "its entry is 0.50 mm from its centre",
            ),
        ] {
            let said = taken(kind, points).unwrap_err();
            assert!(said.contains(words), "{said}");
        }
        let target = Target {
            entry: None,
            ..target(&point("a entry", 1.0), &mut Taken::default()).unwrap()
        };
        assert!(markups(&[target]).unwrap_err().to_string().contains("rename it"));
    }

    /// They were told as descriptions that are not kept, and the target had the default's size.
    #[test]
    fn a_size_in_other_words_is_refused_and_no_target_of_another_size_is_made() {
        let of = |description: &str| {
            let point = ControlPoint {
                description: description.to_owned(),
                ..point("a", 1.0)
            };
            taken(MarkupKind::Fiducial, vec![point])
        };
        for description in [
            "diameter 8 mm, stop 5 mm",
            "diameter: 8 mm",
            "Diameter 8mm",
            "8 mm in diameter",
            "radius 4",
            "\u{d8} 8 mm",
            "stop 5 mm",
            "diameter_mm=8",
            "diameter_mm=8 stop_mm=x",
        ] {
            let said = of(description).unwrap_err();
            assert!(
                said.contains(description) && said.contains("diameter_mm=8.1 stop_mm=4.3"),
                "{said}"
            );
        }
        for description in [
            "at the 12th rib",
            "unstoppable 3",
            "stop before the vein",
            "diameter unknown",
        ] {
            let (plan, told) = of(description).unwrap();
            assert_eq!(
                (plan.targets[0].diameter_mm, told.descriptions.len()),
                (DIAMETER_MM, 1),
                "{description}"
            );
        }
    }

    #[test]
    fn a_description_that_is_not_ours_is_told_and_an_angle_is_a_measure() {
        let noted = ControlPoint {
            description: "left of the vein".to_owned(),
            ..point("a", 1.0)
        };
        // With commas as numbers have them elsewhere, the target would have the size of one that has none.
        let sized = ControlPoint {
            description: "diameter_mm=8,1 stop_mm=4,3".to_owned(),
            ..point("a", 1.0)
        };
        let said = taken(MarkupKind::Fiducial, vec![sized]).unwrap_err();
        assert!(said.contains("a target of another size would be shown"), "{said}");
        let entry = ControlPoint {
            description: "beside the rib".to_owned(),
            ..point("a entry", 50.0)
        };
        let (plan, told) = taken(MarkupKind::Fiducial, vec![noted, entry]).unwrap();
        assert_eq!(told.descriptions, ["a", "a entry"]);
        assert_eq!(plan.targets[0].diameter_mm, DIAMETER_MM);
        let (plan, _) = taken(MarkupKind::Angle, vec![point("", 1.0), point("", 2.0), point("", 3.0)]).unwrap();
        assert!(matches!(plan.measures[..], [Measure::Angle(_)]));
    }
}
