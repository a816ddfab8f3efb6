//! The planning screen without a display: no number is cut or covered on any screen, keys do what the page says.

mod pictures;

use std::rc::Rc;

use bus::message::{FrameHeader, FrameStamp, ImagePlane, PlanWish};
use egui::{Event, Key, Modifiers, PointerButton, Pos2, RawInput, Rect, Role, vec2};
use geometry::{Affine, Point, VolumeGrid};
use guidance::plan::{Concern, Edit, MAX_MEASURES, Measure, Plan, Target, concerns};
use guidance::safety::{GridMatch, LabelNames, Structures};
use guidance::workflow::VolumeId;

use super::super::camera::CUTS;
use super::super::desk::{Desk, Mode};
use super::super::labels::{Beside, Found, WITHIN_MM};
use super::{Known, Outcome, show};
use crate::model::sample::Sample;
use crate::model::{Model, Tone};
use crate::screen::context;
use crate::screen::words::Placed as Word;
use crate::sizes::Screen;

const SCREENS: [[u32; 2]; 4] = [[1024, 640], [1280, 800], [1920, 1080], [3840, 2160]];

fn grid() -> VolumeGrid {
    let rows = [
        [4.0, 0.0, 0.0, -400.0],
        [0.0, 4.0, 0.0, -400.0],
        [0.0, 0.0, 5.0, -1000.0],
    ];
    VolumeGrid::checked([200, 200, 400], Affine::from_rows(rows)).unwrap()
}

/// Names as long as they may be, places as wide.
fn plan() -> Plan {
    let target = |k: usize| Target {
        name: format!("{k:02} {}", "n".repeat(37)),
        centre: Point::new(-111.1, -188.8 + k as f64, -777.7),
        diameter_mm: 188.8,
        entry: Some(Point::new(-188.8, 188.8, -888.8)),
        stop_mm: 188.8,
    };
    let p = |x: f64| Point::new(x, -188.8, -777.7);
    let plan = Plan {
        targets: (0..20).map(target).collect(),
        measures: (0..MAX_MEASURES)
            .map(|k| Measure::Distance([p(-180.0), p(180.0 + k as f64)]))
            .collect(),
        ..Plan::new(VolumeId([7; 32]))
    };
    plan.checked().unwrap()
}

fn model() -> Model {
    let state = Sample::new(geometry::Rigid::identity(), Point::new(0.0, 0.0, 50.0))
        .model()
        .state;
    let sample = Sample::new(geometry::Rigid::identity(), Point::new(0.0, 0.0, 50.0));
    Model {
        state: crate::model::ScreenState {
            word: "CONFIRMED PLAN".to_owned(),
            detail: "by somebody with a name".to_owned(),
            tone: Tone::Quiet,
            ..state
        },
        ..sample.model()
    }
}

/// As long as names may be, with blanks and without.
fn names() -> LabelNames {
    let long = ["vena cava ".repeat(9), "v".repeat(96)];
    let lines = long.iter().zip([30_010, 30_060]);
    let text: String = lines
        .map(|(name, label)| format!("{label} 0 0 0 1 1 1 \"{name}\"\n"))
        .collect();
    LabelNames::of_itk_snap(&text).unwrap()
}

/// A label map of three slabs across the way.
fn found(desk: &Desk, plan: &Plan) -> Beside {
    let grid = grid();
    let structures = Structures::build(&grid, |z, slice| {
        slice.fill(if z % 50 == 10 { 30_000 + z as i16 } else { 0 })
    })
    .unwrap();
    let way = desk.way(plan).unwrap();
    let tube = guidance::safety::Tube::new(way.entry, way.stop, 6.0).unwrap();
    Beside::Found(Box::new(Found {
        clearances: structures.clearance(&tube, WITHIN_MM).unwrap(),
        sections: structures.profile(&tube, 150, WITHIN_MM).unwrap(),
        grid: GridMatch::Other,
        doubts: Rc::new([]),
        names: Rc::new(names()),
    }))
}

struct Stage {
    plan: Plan,
    concerns: Vec<Concern>,
    beside: Beside,
    desk: Desk,
    context: egui::Context,
    screen: Screen,
    /// What the accessibility tree says: labels, states, and of buttons the word and the key.
    told: Vec<String>,
}

impl Stage {
    fn new(plan: Plan, pixels: [u32; 2]) -> Self {
        let mut desk = Desk::new(&grid());
        desk.follow(&plan);
        let beside = if plan.targets.is_empty() {
            Beside::NotGiven
        } else {
            found(&desk, &plan)
        };
        let screen = Screen {
            pixels,
            pixel_mm: 531.0 / pixels[0] as f32,
        };
        Self {
            concerns: concerns(&plan, &grid(), &|_| Some(3000)),
            plan,
            beside,
            desk,
            context: context(),
            screen,
            told: Vec::new(),
        }
    }

    fn frame(&mut self, events: Vec<Event>) -> Outcome {
        let (outcome, mut output) = self.laid_out(events);
        output.textures_delta.clear();
        self.told = told(output.platform_output.accesskit_update.take());
        outcome
    }

    /// The same with the shapes that it is painted of.
    fn laid_out(&mut self, events: Vec<Event>) -> (Outcome, egui::FullOutput) {
        let (grid, model) = (grid(), model());
        let way = self.desk.way(&self.plan);
        let images = CUTS.map(|cut| {
            let plane = self.desk.camera.plane(cut, way.as_ref(), [512, 512])?;
            let header = FrameHeader {
                stamp: FrameStamp::default(),
                plane: ImagePlane::of(Some(&plane), self.desk.camera.window),
                width: 512,
                height: 512,
            };
            Some((header, true))
        });
        let [width, height] = self.screen.pixels.map(|n| n as f32);
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, vec2(width, height))),
            events,
            focused: true,
            ..RawInput::default()
        };
        let mut outcome = Outcome::default();
        let (plan, concerns, beside, desk, screen) =
            (&self.plan, &self.concerns, &self.beside, &mut self.desk, self.screen);
        let output = self.context.run_ui(input, |ui| {
            let known = Known {
                model: &model,
                plan,
                is_writing: false,
                file_id: u64::MAX,
                depth: [256, 256],
                concerns,
                grid: &grid,
                hu: &|_| Some(-1024),
                images,
                tube_mm: 12.0,
                beside,
                error_mm: Some(99.9),
            };
            outcome = show(ui, &known, desk, screen);
        });
        (outcome, output)
    }
}

/// What a tree says word for word.
fn told(tree: Option<egui::accesskit::TreeUpdate>) -> Vec<String> {
    let nodes = tree.into_iter().flat_map(|tree| tree.nodes).map(|(_, node)| node);
    let said = nodes.flat_map(|node| match node.role() {
        Role::Label => vec![node.value().map(str::to_owned)],
        Role::Status | Role::Alert | Role::Button => {
            let key = node.keyboard_shortcut().map(str::to_owned);
            vec![node.label().map(str::to_owned), key]
        }
        _ => Vec::new(),
    });
    said.flatten().collect()
}

fn key(key: Key) -> Event {
    with(key, Modifiers::default())
}

fn with(key: Key, modifiers: Modifiers) -> Event {
    Event::Key {
        key,
        physical_key: None,
        pressed: true,
        repeat: false,
        modifiers,
    }
}

/// What the letters cover: a line is higher than they are.
fn ink(placed: &Word) -> Rect {
    placed.covers.shrink2(vec2(0.0, 0.12 * placed.size))
}

/// H4: a digit that was dropped. Names may end in an ellipsis, numbers never; nothing lies over anything else.
#[test]
fn no_number_of_a_plan_is_cut_or_covered_on_any_screen() {
    for pixels in SCREENS {
        for count in [0, 1, 8, 20] {
            let mut some = plan();
            some.targets.truncate(count);
            let mut stage = Stage::new(some, pixels);
            stage.frame(vec![Event::PointerMoved(Pos2::new(120.0, 200.0))]);
            let outcome = stage.frame(Vec::new());
            let words = &outcome.words.0;
            assert!(words.len() > 20 && outcome.code.is_some());
            // What the tube cuts is said, or how much could not be said.
            let cuts = words.iter().filter(|placed| placed.text.starts_with("CUTS ")).count();
            let more = words.iter().any(|placed| placed.text.contains("MORE LINES"));
            assert!(count == 0 || cuts == 5 || more, "{pixels:?} {count}: {cuts}");
            let screen = Rect::from_min_size(Pos2::ZERO, vec2(pixels[0] as f32, pixels[1] as f32));
            for (k, placed) in words.iter().enumerate() {
                let is_name = placed.text.contains("nnn");
                assert!(
                    is_name || placed.painted == placed.text,
                    "{pixels:?} {count}: {placed:?}"
                );
                assert!(screen.contains_rect(ink(placed)), "{pixels:?}: {placed:?}");
                for other in &words[k + 1..] {
                    let common = ink(placed).intersect(ink(other));
                    let is_apart = common.width() <= 0.5 || common.height() <= 0.5;
                    assert!(is_apart, "{pixels:?} {count}: {placed:?} {other:?}");
                }
            }
        }
    }
}

#[test]
fn keys_change_the_plan_where_the_pointer_is() {
    let mut some = plan();
    some.targets.truncate(1);
    let mut stage = Stage::new(some, [1920, 1080]);
    let at = Pos2::new(200.0, 300.0);
    stage.frame(vec![Event::PointerMoved(at)]);
    // What comes in one frame is made one after the other.
    let outcome = stage.frame(vec![key(Key::Minus), key(Key::Minus), key(Key::T), key(Key::E)]);
    let wishes: Vec<&PlanWish> = outcome.wishes.iter().collect();
    let [
        PlanWish::Edit(Edit::Change(_, first)),
        PlanWish::Edit(Edit::Change(_, second)),
        PlanWish::Edit(Edit::Add(added)),
        PlanWish::Edit(Edit::Change(name, entered)),
    ] = wishes[..]
    else {
        panic!("{wishes:?}")
    };
    assert_eq!((first.diameter_mm, second.diameter_mm), (188.3, 187.8));
    assert_eq!(
        (&added.name, &entered.name, entered.entry),
        (name, name, Some(added.centre))
    );
    let undo = with(Key::Z, Modifiers::CTRL);
    assert_eq!(stage.frame(vec![undo]).wishes, [PlanWish::Undo]);
    // While words are typed letters are letters.
    stage.desk.selected = Some(stage.plan.targets[0].name.clone());
    stage.frame(vec![key(Key::N)]);
    assert!(stage.desk.typing.is_some());
    assert!(
        stage
            .frame(vec![key(Key::T), Event::Text("t".to_owned())])
            .wishes
            .is_empty()
    );
    stage.frame(vec![key(Key::Escape)]);
    assert_eq!(stage.desk.typing, None);
    stage.frame(vec![key(Key::M)]);
    assert_eq!(stage.desk.mode, Mode::Measure(Vec::new(), 2));
}

/// A press that lies on no image, and a drag that ends elsewhere, change nothing but what they took hold of.
#[test]
fn what_is_dragged_is_changed_when_it_is_let_go_of_wherever_that_is() {
    let mut some = plan();
    some.targets.truncate(1);
    some.targets[0].diameter_mm = 5.0;
    let mut stage = Stage::new(some, [1920, 1080]);
    let outcome = stage.frame(Vec::new());
    drop(outcome);
    // The selected target is in the middle of its image.
    let cell = super::image::Cell::of(
        &Known {
            model: &model(),
            plan: &stage.plan,
            is_writing: false,
            file_id: 0,
            depth: [0; 2],
            concerns: &[],
            grid: &grid(),
            hu: &|_| None,
            images: [None; 4],
            tube_mm: 12.0,
            beside: &Beside::NotGiven,
            error_mm: None,
        },
        CUTS[0],
        super::rooms(&crate::sizes::Sizes::of(stage.screen, 4).unwrap(), None).images[0].unwrap(),
        &crate::sizes::Sizes::of(stage.screen, 4).unwrap(),
    );
    let middle = cell.image.center();
    let button = |pos, pressed| Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::default(),
    };
    stage.frame(vec![Event::PointerMoved(middle)]);
    stage.frame(vec![button(middle, true)]);
    assert!(stage.desk.held.is_some());
    let away = Pos2::new(1500.0, 900.0);
    stage.frame(vec![Event::PointerMoved(middle + vec2(30.0, 0.0))]);
    assert!(stage.frame(vec![Event::PointerMoved(away)]).wishes.is_empty());
    let outcome = stage.frame(vec![button(away, false)]);
    let [PlanWish::Edit(Edit::Change(_, moved))] = &outcome.wishes[..] else {
        panic!("{:?}", outcome.wishes)
    };
    // To the right of an axial image is the patient's left, downwards her back; across it nothing moved.
    let [before, after] = [stage.plan.targets[0].centre, moved.centre].map(Point::mm);
    assert!(after[0] > before[0] + 10.0 && after[1] > before[1] + 10.0 && (after[2] - before[2]).abs() < 1e-9);
    assert_eq!((stage.desk.held.as_ref(), stage.desk.dragged), (None, None));
}

#[test]
fn a_drag_with_ctrl_changes_the_window_and_moves_no_point() {
    let mut some = plan();
    some.targets.truncate(1);
    let mut stage = Stage::new(some, [1920, 1080]);
    stage.frame(Vec::new());
    let sizes = crate::sizes::Sizes::of(stage.screen, 4).unwrap();
    let middle = super::rooms(&sizes, None).images[0].unwrap().center();
    let button = |pos, pressed| Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::CTRL,
    };
    let (cursor, window) = (stage.desk.camera.cursor, stage.desk.camera.window);
    stage.frame(vec![
        Event::ModifiersChanged(Modifiers::CTRL),
        Event::PointerMoved(middle),
    ]);
    stage.frame(vec![button(middle, true)]);
    let away = middle + vec2(30.0, -20.0);
    stage.frame(vec![Event::PointerMoved(away)]);
    let outcome = stage.frame(vec![button(away, false)]);
    assert_eq!(
        (outcome.wishes.len(), stage.desk.camera.cursor, stage.desk.is_leveled),
        (0, cursor, false)
    );
    let found = stage.desk.camera.window;
    assert_eq!(
        (found.width_hu, found.centre_hu),
        (window.width_hu + 60.0, window.centre_hu + 40.0)
    );
}

/// A segmentation that nobody approved was like any other on the screen.
#[test]
fn what_is_doubtful_about_a_label_map_stands_on_the_screen() {
    let mut stage = Stage::new(plan(), SCREENS[0]);
    let Beside::Found(found) = &mut stage.beside else {
        panic!("a label map was found");
    };
    found.doubts = Rc::new(["nobody said that it is right".to_owned()]);
    let words = stage.frame(Vec::new()).words.0;
    let text: String = words
        .iter()
        .map(|placed| placed.text.as_str())
        .collect::<Vec<_>>()
        .join(" ");
    assert!(text.contains("The label map: nobody said that it is right"), "{text}");
}

/// What stands on the planning screen is in its accessibility tree, word for word, and nothing else is.
#[test]
fn the_tree_says_every_word_of_the_planning_screen_and_no_other() {
    let mut words = 0;
    for pixels in SCREENS {
        for count in [0, 1, 8] {
            let mut some = plan();
            some.targets.truncate(count);
            some.measures.truncate(2);
            some.notes = "the patient is allergic to latex".to_owned();
            let mut stage = Stage::new(some, pixels);
            stage.context.enable_accesskit();
            stage.frame(Vec::new());
            let outcome = stage.frame(Vec::new());
            let mut painted: Vec<&str> = outcome.words.0.iter().map(|placed| placed.text.as_str()).collect();
            painted.sort_unstable();
            let mut told: Vec<&str> = stage.told.iter().map(String::as_str).collect();
            told.sort_unstable();
            assert_eq!(told, painted, "{pixels:?} {count}");
            words += painted.len();
            // With all that is to be said of a way the notes find no room.
            assert!(
                count > 0 || painted.iter().any(|text| text.starts_with("notes: ")),
                "{painted:?}"
            );
        }
    }
    assert!(words > 500, "{words}");
}
