//! Changes of a plan as options of the command line, made in the order: removed, renamed, imported, targets, the rest
//! of each, measures, notes.

use clap::Args;
use geometry::{Ct, Point};
use guidance::plan::{Edit, Editor, Measure, PlanError, Target};

use super::points::{FileError, PointsArgs, ReadStructureSet};
use crate::planning::DIAMETER_MM;

#[derive(Debug, Args)]
pub(crate) struct EditArgs {
    /// A target's centre, LPS mm: a new target, or another place for one that there is.
    #[arg(long, value_name = "NAME=X,Y,Z", value_parser = named_point, allow_hyphen_values = true)]
    target: Vec<(String, Point<Ct>)>,
    /// Where the tube is to enter on its way to a target, LPS mm.
    #[arg(long, value_name = "NAME=X,Y,Z", value_parser = named_point, allow_hyphen_values = true)]
    entry: Vec<(String, Point<Ct>)>,
    /// A target's diameter, mm.
    #[arg(long, value_name = "NAME=MM", value_parser = named_number)]
    diameter: Vec<(String, f64)>,
    /// How far before a target's centre the tip is to stop, mm.
    #[arg(long, value_name = "NAME=MM", value_parser = named_number)]
    stop: Vec<(String, f64)>,
    /// Another name for a target.
    #[arg(long, value_name = "OLD=NEW", value_parser = renaming)]
    rename: Vec<(String, String)>,
    /// A target that is no more.
    #[arg(long, value_name = "NAME")]
    remove: Vec<String>,
    /// A distance between two points, or the angle at the second of three.
    #[arg(long, value_name = "X,Y,Z:X,Y,Z[:X,Y,Z]", value_parser = measure, allow_hyphen_values = true)]
    measure: Vec<Measure>,
    /// A distance or an angle that is no more, by its number.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    remove_measure: Vec<u32>,
    /// Notes, in the place of those that there are.
    #[arg(long, value_name = "WORDS")]
    notes: Option<String>,
    #[command(flatten)]
    pub(super) points: PointsArgs,
}

/// Why a change was not made.
#[derive(Debug, thiserror::Error)]
pub(crate) enum EditError {
    #[error("changing the plan: {0}. Nothing was written")]
    Plan(#[from] PlanError),
    #[error(transparent)]
    File(#[from] FileError),
}

/// Those that make a new plan of the targets of a scene.
pub(super) fn of_scene(targets: &[scene::Target]) -> impl Iterator<Item = Edit> {
    targets.iter().map(|target| {
        Edit::Add(Target {
            name: target.name.clone(),
            centre: target.centre,
            diameter_mm: target.diameter_mm,
            entry: target.entry,
            stop_mm: target.stop_mm,
        })
    })
}

impl EditArgs {
    /// Whether there is any.
    pub(super) fn is_some(&self) -> bool {
        let lists = [
            self.target.len(),
            self.entry.len(),
            self.diameter.len(),
            self.stop.len(),
            self.rename.len(),
            self.remove.len(),
            self.measure.len(),
            self.remove_measure.len(),
        ];
        self.notes.is_some() || self.points.is_import() || lists.iter().any(|count| *count > 0)
    }

    /// Makes them all.
    ///
    /// # Errors
    /// That of the first that is refused.
    pub(super) fn make(&self, editor: &mut Editor, structure_set: ReadStructureSet<'_>) -> Result<(), EditError> {
        for name in &self.remove {
            editor.edit(Edit::Remove(name.clone()))?;
        }
        for (name, to) in &self.rename {
            change(editor, name, |target| target.name = to.clone())?;
        }
        self.points.take(editor, structure_set)?;
        for (name, centre) in &self.target {
            match editor.plan().target(name) {
                Some(_) => change(editor, name, |target| target.centre = *centre)?,
                None => editor.edit(Edit::Add(new(name, *centre)))?,
            }
        }
        for (name, entry) in &self.entry {
            change(editor, name, |target| target.entry = Some(*entry))?;
        }
        for (name, mm) in &self.diameter {
            change(editor, name, |target| target.diameter_mm = *mm)?;
        }
        for (name, mm) in &self.stop {
            change(editor, name, |target| target.stop_mm = *mm)?;
        }
        // From the last, so that the numbers of the others stay.
        let mut places = self.remove_measure.clone();
        places.sort_unstable_by(|a, b| b.cmp(a));
        places.dedup();
        for number in places {
            editor.edit(Edit::RemoveMeasure(number as usize - 1))?;
        }
        for measure in &self.measure {
            editor.edit(Edit::Measure(*measure))?;
        }
        if let Some(notes) = &self.notes {
            editor.edit(Edit::Notes(notes.clone()))?;
        }
        Ok(())
    }
}

fn new(name: &str, centre: Point<Ct>) -> Target {
    Target {
        name: name.to_owned(),
        centre,
        diameter_mm: DIAMETER_MM,
        entry: None,
        stop_mm: 0.0,
    }
}

/// Changes the target of this name; one that there is not is refused by the editor.
fn change(editor: &mut Editor, name: &str, how: impl Fn(&mut Target)) -> Result<(), PlanError> {
    let there = editor.plan().target(name);
    let mut target = there.cloned().unwrap_or_else(|| new(name, Point::new(0.0, 0.0, 0.0)));
    how(&mut target);
    editor.edit(Edit::Change(name.to_owned(), target))
}

/// The name ends at the last `=`, as names may have one.
fn halves(text: &str) -> Result<(&str, &str), String> {
    let found = text.rsplit_once('=').filter(|(name, _)| !name.is_empty());
    found.ok_or_else(|| "expected NAME=...".to_owned())
}

fn number(text: &str) -> Result<f64, String> {
    let number: f64 = text.trim().parse().map_err(|_| format!("{text:?} is no number"))?;
    match number.is_finite() {
        true => Ok(number),
        false => Err(format!("{text:?} is no finite number")),
    }
}

fn point(text: &str) -> Result<Point<Ct>, String> {
    let numbers = text.split(',').map(number).collect::<Result<Vec<f64>, _>>()?;
    match numbers[..] {
        [x, y, z] => Ok(Point::new(x, y, z)),
        _ => Err(format!("{} numbers, expected X,Y,Z", numbers.len())),
    }
}

fn named_point(text: &str) -> Result<(String, Point<Ct>), String> {
    let (name, mm) = halves(text)?;
    Ok((name.to_owned(), point(mm)?))
}

fn named_number(text: &str) -> Result<(String, f64), String> {
    let (name, mm) = halves(text)?;
    Ok((name.to_owned(), number(mm)?))
}

fn renaming(text: &str) -> Result<(String, String), String> {
    let (old, new) = halves(text)?;
    Ok((old.to_owned(), new.to_owned()))
}

fn measure(text: &str) -> Result<Measure, String> {
    let points = text.split(':').map(point).collect::<Result<Vec<Point<Ct>>, _>>()?;
    match points[..] {
        [a, b] => Ok(Measure::Distance([a, b])),
        [a, b, c] => Ok(Measure::Angle([a, b, c])),
        _ => Err(format!("{} points, expected two or three", points.len())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_and_numbers_are_read_whole_or_refused() {
        assert_eq!(
            named_point("a=b=1,-2.5, 3"),
            Ok(("a=b".to_owned(), Point::new(1.0, -2.5, 3.0)))
        );
        for (text, said) in [
            ("a", "expected NAME="),
            ("=1,2,3", "expected NAME="),
            ("a=1,2", "2 numbers"),
            ("a=1,2,3,4", "4 numbers"),
            ("a=1,x,3", "\"x\" is no number"),
            ("a=1,nan,3", "no finite number"),
            ("a=1,,3", "\"\" is no number"),
        ] {
            let found = named_point(text).unwrap_err();
            assert!(found.contains(said), "{text}: {found}");
        }
        let zero = Point::new(0.0, 0.0, 0.0);
        assert_eq!(measure("0,0,0:0,0,0"), Ok(Measure::Distance([zero, zero])));
        assert_eq!(measure("0,0,0:0,0,0:0,0,0"), Ok(Measure::Angle([zero; 3])));
        assert!(measure("0,0,0").unwrap_err().contains("1 points"));
        assert!(named_number("a=inf").is_err());
    }
}
