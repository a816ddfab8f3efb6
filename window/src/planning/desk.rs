//! What a person has in hand on the planning screen: where she looks, which target she has chosen, what she is about to do. Nothing of it
//! is the plan's.

use bus::message::PlanWish;
use egui::Pos2;
use geometry::{Ct, Point, VolumeGrid};
use guidance::plan::{Edit, Measure, Plan, Target, Trajectory};

use super::camera::{Camera, Cut};
use super::typing::Typing;

/// The diameter of a new target, mm.
const DIAMETER_MM: f64 = 5.0;
/// One press of a key changes a diameter or a stop distance by so much, mm.
const STEP_MM: f64 = 0.5;

/// What the pointer does on an image.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) enum Mode {
    /// Moves the point that the slices go through, or what it takes hold of.
    #[default]
    Point,
    /// Changes the window.
    Level,
    /// Collects points of a distance (2) or an angle (3).
    Measure(Vec<Point<Ct>>, usize),
}

/// A point of the plan that the pointer has taken hold of.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Held {
    /// The target's name.
    pub(crate) name: String,
    /// Its entry, and not its centre.
    pub(crate) is_entry: bool,
    /// Where it is now.
    pub(crate) at: Point<Ct>,
}

/// What a person has in hand.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Desk {
    pub(crate) camera: Camera,
    /// The name of the target that keys work on.
    pub(crate) selected: Option<String>,
    /// The one before a change that made another: it is that again where the change is refused.
    selected_before: Option<String>,
    /// A plan has come.
    has_plan: bool,
    pub(crate) mode: Mode,
    /// The image that fills the room of all four.
    pub(crate) enlarged: Option<Cut>,
    pub(crate) held: Option<Held>,
    /// The image that a drag began on: it goes on there, wherever the pointer is.
    pub(crate) dragged: Option<Cut>,
    /// Where the pointer was pressed last, and whether that was where it was pressed before.
    pub(crate) pressed: Option<Pos2>,
    pub(crate) is_same_place: bool,
    /// The drag that goes on changes the window.
    pub(crate) is_leveled: bool,
    /// Words that are being typed.
    pub(crate) typing: Option<Typing>,
    /// What is to be said to the person: why something was refused, what is to be done next.
    pub(crate) note: String,
}

impl Desk {
    pub(crate) fn new(grid: &VolumeGrid) -> Self {
        Self {
            camera: Camera::home(grid),
            selected: None,
            selected_before: None,
            has_plan: false,
            mode: Mode::Point,
            enlarged: None,
            held: None,
            dragged: None,
            pressed: None,
            is_same_place: false,
            is_leveled: false,
            typing: None,
            note: String::new(),
        }
    }

    /// The plan as it is while a point of it is being dragged.
    pub(crate) fn shown(&self, plan: &Plan) -> Plan {
        let mut plan = plan.clone();
        let Some(held) = &self.held else { return plan };
        if let Some(target) = plan.targets.iter_mut().find(|target| target.name == held.name) {
            *target = moved(target, held);
        }
        plan
    }

    /// The target that keys work on.
    pub(crate) fn target<'a>(&self, plan: &'a Plan) -> Option<&'a Target> {
        plan.target(self.selected.as_deref()?)
    }

    /// The way of the selected target.
    pub(crate) fn way(&self, plan: &Plan) -> Option<Trajectory> {
        Trajectory::of(self.target(plan)?)
    }

    /// The plan has changed: what was selected may be gone. Nothing is then selected that nobody chose: the next key would change it.
    pub(crate) fn follow(&mut self, plan: &Plan) {
        let is_first = !std::mem::replace(&mut self.has_plan, true);
        if let Some(target) = self.target(plan) {
            if is_first {
                self.camera.fit(&target.clone());
            }
            return;
        }
        self.selected = self.selected_before.take().filter(|name| plan.target(name).is_some());
        if let (true, None, Some(first)) = (is_first, &self.selected, plan.targets.first()) {
            self.select(first);
        }
    }

    /// What a change makes of the selection, if it is made.
    fn select_made(&mut self, name: String) {
        if self.selected.as_ref() != Some(&name) {
            self.selected_before = self.selected.replace(name);
        }
    }

    /// Selects a target, and looks at it.
    pub(crate) fn select(&mut self, target: &Target) {
        self.selected = Some(target.name.clone());
        self.camera.look_at(target.centre);
        self.camera.fit(target);
    }

    /// The target after the selected one, or before it.
    pub(crate) fn select_next(&mut self, plan: &Plan, is_forward: bool) {
        let count = plan.targets.len();
        let place = plan
            .targets
            .iter()
            .position(|target| Some(&target.name) == self.selected.as_ref());
        let next = match (place, is_forward) {
            (None, _) => 0,
            (Some(place), true) => (place + 1) % count,
            (Some(place), false) => (place + count - 1) % count,
        };
        if let Some(target) = plan.targets.get(next) {
            self.select(target);
        }
    }

    /// A new target at `p`, under a name that no other has; it becomes the selected one.
    pub(crate) fn add(&mut self, plan: &Plan, p: Point<Ct>) -> PlanWish {
        let names = (plan.targets.len() + 1..).map(|n| format!("target {n}"));
        let mut free = names.filter(|name| plan.target(name).is_none());
        let name = free.next().unwrap_or_default();
        self.select_made(name.clone());
        PlanWish::Edit(Edit::Add(Target {
            name,
            centre: p,
            diameter_mm: DIAMETER_MM,
            entry: None,
            stop_mm: 0.0,
        }))
    }

    /// Changes the selected target; `None` where none is, which is then said.
    pub(crate) fn change(&mut self, plan: &Plan, how: impl FnOnce(&mut Target)) -> Option<PlanWish> {
        let Some(target) = self.target(plan) else {
            self.note = "no target is selected: T makes one, Tab selects one".to_owned();
            return None;
        };
        let mut changed = target.clone();
        how(&mut changed);
        let name = target.name.clone();
        // A name that another has is refused, and selects nobody.
        if plan.target(&changed.name).is_none() {
            self.select_made(changed.name.clone());
        }
        Some(PlanWish::Edit(Edit::Change(name, changed)))
    }

    /// Larger or smaller by a step, or deeper.
    pub(crate) fn step_diameter(target: &mut Target, steps: f64) {
        target.diameter_mm += steps * STEP_MM;
    }

    pub(crate) fn step_stop(target: &mut Target, steps: f64) {
        target.stop_mm += steps * STEP_MM;
    }

    /// One more point of what is being measured; the measure where that was the last.
    pub(crate) fn measure(&mut self, p: Point<Ct>) -> Option<PlanWish> {
        let Mode::Measure(points, count) = &mut self.mode else {
            return None;
        };
        points.push(p);
        let done = match (points[..].try_into(), points[..].try_into(), count) {
            (Ok(two), _, 2) => Measure::Distance(two),
            (_, Ok(three), 3) => Measure::Angle(three),
            _ => return None,
        };
        self.mode = Mode::Point;
        Some(PlanWish::Edit(Edit::Measure(done)))
    }

    /// What was taken hold of is let go of: the change that comes of it.
    pub(crate) fn release(&mut self, plan: &Plan) -> Option<PlanWish> {
        let held = self.held.take()?;
        let target = plan.target(&held.name)?;
        let changed = moved(target, &held);
        (changed != *target).then_some(PlanWish::Edit(Edit::Change(held.name, changed)))
    }
}

fn moved(target: &Target, held: &Held) -> Target {
    let mut target = target.clone();
    match held.is_entry {
        true => target.entry = Some(held.at),
        false => target.centre = held.at,
    }
    target
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Affine;
    use guidance::plan::Editor;
    use guidance::workflow::VolumeId;

    fn grid() -> VolumeGrid {
        let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        VolumeGrid::checked([100; 3], Affine::from_rows(rows)).unwrap()
    }

    fn edit(editor: &mut Editor, wish: Option<PlanWish>) {
        let Some(PlanWish::Edit(edit)) = wish else {
            panic!("{wish:?}")
        };
        editor.edit(edit).unwrap();
    }

    #[test]
    fn a_plan_is_made_by_keys_and_the_pointer() {
        let (mut desk, mut editor) = (Desk::new(&grid()), Editor::new(Plan::new(VolumeId([0; 32]))));
        desk.follow(editor.plan());
        assert_eq!(desk.change(editor.plan(), |_| ()), None);
        assert!(desk.note.contains("T makes one"), "{}", desk.note);
        let wish = desk.add(editor.plan(), Point::new(50.0, 50.0, 50.0));
        edit(&mut editor, Some(wish));
        let entry = desk.change(editor.plan(), |target| {
            target.entry = Some(Point::new(90.0, 50.0, 50.0))
        });
        edit(&mut editor, entry);
        assert_eq!(desk.way(editor.plan()).unwrap().depth_mm, 40.0);
        // A name that somebody gave to the second is not given again.
        let wish = desk.add(editor.plan(), Point::new(1.0, 1.0, 1.0));
        edit(&mut editor, Some(wish));
        let wish = desk.change(editor.plan(), |target| target.name = "target 3".to_owned());
        edit(&mut editor, wish);
        let wish = desk.add(editor.plan(), Point::new(2.0, 2.0, 2.0));
        edit(&mut editor, Some(wish));
        let names: Vec<&str> = editor
            .plan()
            .targets
            .iter()
            .map(|target| target.name.as_str())
            .collect();
        assert_eq!(names, ["target 1", "target 3", "target 4"]);
        // Dragged: seen at once, changed when it is let go of.
        let at = Point::new(80.0, 20.0, 50.0);
        desk.held = Some(Held {
            name: "target 1".to_owned(),
            is_entry: true,
            at,
        });
        assert_eq!(desk.shown(editor.plan()).targets[0].entry, Some(at));
        let wish = desk.release(editor.plan());
        edit(&mut editor, wish);
        assert_eq!(editor.plan().targets[0].entry, Some(at));
        assert_eq!(desk.release(editor.plan()), None);
        desk.select_next(editor.plan(), true);
        desk.select_next(editor.plan(), true);
        assert_eq!(desk.selected.as_deref(), Some("target 3"));
        edit(&mut editor, Some(PlanWish::Edit(Edit::Remove("target 3".to_owned()))));
        desk.follow(editor.plan());
        assert_eq!(desk.selected, None);
    }

    /// The next key changed or removed another target than the one that was looked at.
    #[test]
    fn a_refused_change_leaves_the_selection_where_it_was() {
        let (mut desk, mut editor) = (Desk::new(&grid()), Editor::new(Plan::new(VolumeId([0; 32]))));
        desk.follow(editor.plan());
        for x in [10.0, 20.0, 30.0] {
            let wish = desk.add(editor.plan(), Point::new(x, 50.0, 50.0));
            edit(&mut editor, Some(wish));
            desk.follow(editor.plan());
        }
        assert_eq!(desk.selected.as_deref(), Some("target 3"));
        let taken = desk.change(editor.plan(), |target| target.name = "target 1".to_owned());
        let Some(PlanWish::Edit(taken)) = taken else { panic!() };
        editor.edit(taken).unwrap_err();
        desk.follow(editor.plan());
        assert_eq!(desk.selected.as_deref(), Some("target 3"));
        // A new one that is refused, as of the sixty-fifth; and another name that cannot be written.
        desk.add(editor.plan(), Point::new(1.0, 1.0, 1.0));
        desk.follow(editor.plan());
        assert_eq!(desk.selected.as_deref(), Some("target 3"));
        desk.change(editor.plan(), |target| target.name = "new".to_owned());
        desk.follow(editor.plan());
        assert_eq!(desk.selected.as_deref(), Some("target 3"));
    }

    #[test]
    fn a_measure_is_there_with_its_last_point() {
        let mut desk = Desk::new(&grid());
        let p = |x: f64| Point::new(x, 0.0, 0.0);
        for count in [2, 3] {
            desk.mode = Mode::Measure(Vec::new(), count);
            for k in 1..count {
                assert_eq!(desk.measure(p(k as f64)), None);
            }
            let made = desk.measure(p(9.0)).unwrap();
            let PlanWish::Edit(Edit::Measure(measure)) = made else {
                panic!()
            };
            assert_eq!((measure.points().len(), &desk.mode), (count, &Mode::Point));
        }
        assert_eq!(desk.measure(p(0.0)), None);
    }
}
