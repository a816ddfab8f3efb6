//! Each action is found by its name in the accessibility tree, and what it is clicked for is what its key does; keys and touches without a
//! tree as well.

use std::collections::BTreeSet;

use bus::message::Images;
use egui::{Event, Key, Modifiers, PointerButton, Role};
use egui_kittest::kittest::Queryable as _;

use super::samples::{held, replay};
use super::stage::{stage, told};
use super::{monitor, sample, shown};
use crate::model::Model;
use crate::screen::images::KEYS;
use crate::screen::{ImagesKey, Look, Views, Wish};
use crate::sizes::Sizes;

/// An action: its name, its key, and what it is for.
type Action = (&'static str, Key, Wish);

fn always() -> Vec<Action> {
    vec![
        ("Screenshot", Key::F9, Wish::Shot),
        ("Views", Key::V, Wish::Views(Views::Local)),
    ]
}

fn of_a_run() -> Vec<Action> {
    vec![
        ("Target before", Key::PageUp, Wish::NextTarget { is_forward: false }),
        ("Next target", Key::PageDown, Wish::NextTarget { is_forward: true }),
        ("Mark", Key::Space, Wish::Mark),
        ("Hold", Key::F6, Wish::Hold),
    ]
}

fn of_a_replay() -> Vec<Action> {
    vec![
        ("Mark before", Key::PageUp, Wish::NextMark { is_forward: false }),
        ("Next mark", Key::PageDown, Wish::NextMark { is_forward: true }),
        ("Back 5 s", Key::ArrowLeft, Wish::Skip(-5)),
        ("Pose before", Key::A, Wish::PoseBefore),
        ("Slower", Key::Comma, Wish::Speed { is_faster: false }),
        ("Faster", Key::Period, Wish::Speed { is_faster: true }),
        ("Moment", Key::M, Wish::Moment),
        ("Pause", Key::P, Wish::Pause),
        ("Step", Key::S, Wish::OnePose),
        ("On 5 s", Key::ArrowRight, Wish::Skip(5)),
    ]
}

fn enlarged() -> Look {
    Look {
        enlarged: Some(1),
        ..Look::default()
    }
}

/// What is wished by a click of the pointer, by a click of whoever reads the tree, and by the key.
fn wished(model: &Model, look: &Look, (name, key, _): &Action) -> [Vec<Wish>; 3] {
    let new = || stage(model.clone(), monitor([1920, 1080]), look.clone());
    let mut pointer = new();
    pointer.get_by_role_and_label(Role::Button, name).click();
    pointer.run();
    let mut reader = new();
    reader.get_by_label(name).click_accesskit();
    reader.run();
    let mut pressed = new();
    pressed.key_press(*key);
    pressed.run();
    [pointer, reader, pressed].map(|harness| harness.into_state().wishes)
}

#[test]
fn a_click_on_a_name_does_what_its_key_does() {
    let navigation = sample(37.4, 1.3).model();
    let mut cases: Vec<(Model, Look, Action)> = Vec::new();
    cases.extend(
        always()
            .into_iter()
            .chain(of_a_run())
            .map(|action| (navigation.clone(), Look::default(), action)),
    );
    let all = always().into_iter().chain(of_a_replay());
    cases.extend(all.map(|action| (replay().model(), Look::default(), action)));
    cases.push((held().model(), Look::default(), ("Follow", Key::F6, Wish::Hold)));
    let show_all = ("All views", Key::Escape, Wish::Enlarge(None));
    cases.push((navigation, enlarged(), show_all));
    for (model, look, action) in cases {
        let [pointer, reader, key] = wished(&model, &look, &action);
        let wish = [action.2.clone()];
        assert_eq!(
            (&pointer[..], &reader[..], &key[..]),
            (&wish[..], &wish[..], &wish[..]),
            "{action:?}"
        );
    }
}

/// The keys for a replay's speed did nothing on a display.
#[test]
fn every_key_is_on_a_keyboard() {
    let buttons = always().into_iter().chain(of_a_run()).chain(of_a_replay());
    let keys = buttons.map(|(_, key, _)| key).chain(KEYS.map(|(_, key, ..)| key));
    for key in keys.chain([Key::Escape, Key::F2]) {
        assert!(crate::display::is_reached(key), "{key:?}");
    }
}

#[test]
fn an_image_is_enlarged_by_its_name() {
    let model = sample(37.4, 1.3).model();
    for cell in &model.cells {
        let mut harness = stage(model.clone(), monitor([1920, 1080]), Look::default());
        let [left, ..] = cell.letters.as_ref().unwrap();
        let name = format!("{}, {left} at the left", cell.title);
        let image = harness.get_by_label_contains(&name);
        image.click();
        harness.run();
        assert_eq!(harness.state().wishes, [Wish::Enlarge(Some(cell.view))]);
    }
}

#[test]
fn what_cannot_be_done_is_not_there() {
    let mut navigation = stage(sample(37.4, 1.3).model(), monitor([1920, 1080]), Look::default());
    let absent = of_a_replay()
        .into_iter()
        .filter(|(_, key, _)| !matches!(key, Key::PageUp | Key::PageDown));
    let absent = absent.chain([
        ("Follow", Key::Enter, Wish::Hold),
        ("All views", Key::Escape, Wish::Enlarge(None)),
    ]);
    for (name, key, _) in absent {
        assert!(navigation.query_by_label(name).is_none(), "{name}");
        navigation.key_press(key);
    }
    navigation.run();
    assert_eq!(navigation.state().wishes, []);
    let alone = Look {
        only_sight: true,
        ..Look::default()
    };
    let sight = stage(sample(37.4, 1.3).model(), monitor([1024, 768]), alone);
    assert_eq!(sight.query_all_by_role(Role::Image).count(), 0);
}

/// Each key of the guide is a button's, and each button's key is in the guide.
#[test]
fn the_guide_names_every_key_and_no_other() {
    let guide = include_str!("../../../../docs/window.md");
    let keys = guide.split("## Keys").nth(1).unwrap().split("\n## ").next().unwrap();
    let first_column = keys
        .lines()
        .filter_map(|line| line.strip_prefix("| ")?.split(" |").next());
    let mut named: BTreeSet<&str> = first_column
        .filter(|cell| *cell != "key" && !cell.contains("click") && !cell.contains("drag"))
        .flat_map(|cell| cell.split(", "))
        .collect();
    // It stands in the row of the click that it undoes.
    assert!(keys.contains("; Esc shows all again"));
    named.insert("Esc");
    let mut found = BTreeSet::new();
    let navigation = sample(37.4, 1.3).model();
    let all = [
        (&navigation, Look::default()),
        (&navigation, enlarged()),
        (&replay().model(), enlarged()),
    ];
    let mut changed = sample(37.4, 1.3);
    changed.guide = changed.guide.map(|guide| guide.showing(&narrow()));
    changed.may_restart_localizer = true;
    let changed = changed.model();
    for (model, look) in all.into_iter().chain([(&changed, Look::default())]) {
        found.extend(
            told(&stage(model.clone(), monitor([1920, 1080]), look))
                .into_iter()
                .filter_map(|node| node.key),
        );
    }
    // These have no button: what they change stands on the images.
    found.extend(KEYS.iter().map(|(printed, ..)| (*printed).to_owned()));
    assert_eq!(named, found.iter().map(String::as_str).collect());
}

fn narrow() -> Images {
    Images {
        field_mm: Some(60.0),
        window: None,
        at_rest: false,
    }
}

#[test]
fn keys_change_how_images_look_and_a_button_leads_back() {
    let model = sample(37.4, 1.3).model();
    for (printed, key, is_shifted, asked) in KEYS {
        let modifiers = if is_shifted { Modifiers::SHIFT } else { Modifiers::NONE };
        let mut harness = stage(model.clone(), monitor([1920, 1080]), Look::default());
        harness.key_press_modifiers(modifiers, key);
        harness.run();
        assert_eq!(harness.state().wishes, [Wish::Images(asked)], "{printed}");
    }
    let name = "Scene's images";
    let plain = stage(model, monitor([1920, 1080]), Look::default());
    assert!(plain.query_by_label(name).is_none());
    let mut changed = sample(37.4, 1.3);
    changed.guide = changed.guide.map(|guide| guide.showing(&narrow()));
    let action = (name, Key::Num0, Wish::Images(ImagesKey::Scene));
    for found in wished(&changed.model(), &Look::default(), &action) {
        assert_eq!(found, std::slice::from_ref(&action.2));
    }
}

/// A clock that was set back counts as a queue until the localizer dials anew: that took a terminal.
#[test]
fn where_a_localizer_asks_for_it_it_can_be_started_anew() {
    let action = ("Restart localizer", Key::L, Wish::RestartLocalizer);
    let mut asking = sample(37.4, 1.3);
    let plain = stage(asking.model(), monitor([1920, 1080]), Look::default());
    assert!(plain.query_by_label(action.0).is_none());
    asking.may_restart_localizer = true;
    for found in wished(&asking.model(), &Look::default(), &action) {
        assert_eq!(found, std::slice::from_ref(&action.2));
    }
}

#[test]
fn every_button_has_its_key_and_its_name() {
    let model = sample(30.0, 1.0).model();
    let key = |key| Event::Key {
        key,
        physical_key: None,
        pressed: true,
        repeat: false,
        modifiers: Modifiers::NONE,
    };
    for (pressed, wish) in [
        (Key::Space, Wish::Mark),
        (Key::F9, Wish::Shot),
        (Key::F6, Wish::Hold),
        (Key::PageUp, Wish::NextTarget { is_forward: false }),
        (Key::PageDown, Wish::NextTarget { is_forward: true }),
    ] {
        let outcome = shown(&model, monitor([1920, 1080]), &Look::default(), vec![key(pressed)]);
        assert_eq!(outcome.wishes, [wish]);
    }
    // What steers a replay does nothing in a navigation.
    let outcome = shown(
        &model,
        monitor([1920, 1080]),
        &Look::default(),
        vec![key(Key::S), key(Key::P)],
    );
    assert_eq!(outcome.wishes, []);
}

#[test]
fn a_touch_on_an_image_enlarges_it() {
    let model = sample(30.0, 1.0).model();
    let screen = monitor([1920, 1080]);
    let at = Sizes::of(screen, 7).unwrap().cells[1].center();
    let button = |pressed| Event::PointerButton {
        pos: at,
        button: egui::PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    let touch = vec![Event::PointerMoved(at), button(true), button(false)];
    let outcome = shown(&model, screen, &Look::default(), touch);
    assert_eq!(outcome.wishes, [Wish::Enlarge(Some(model.cells[1].view))]);
}

/// The drag of the planning screen: with Ctrl, so that no finger that slips changes what all images show.
#[test]
fn a_drag_with_ctrl_changes_the_window_and_nothing_else_does() {
    let model = sample(37.4, 1.3).model();
    let screen = monitor([1920, 1080]);
    let middle = Sizes::of(screen, model.cells.len()).unwrap().cells[0].center();
    let button = |pos, pressed| Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::default(),
    };
    let away = middle + egui::vec2(30.0, -20.0);
    let by = Wish::Level {
        wider_hu: 60,
        up_hu: 40,
    };
    for (held, to, wished) in [
        (Modifiers::CTRL, away, vec![by]),
        (Modifiers::NONE, away, vec![]),
        (Modifiers::SHIFT, away, vec![]),
        (Modifiers::NONE, middle, vec![Wish::Enlarge(Some(model.cells[0].view))]),
    ] {
        let mut harness = stage(model.clone(), screen, Look::default());
        let events = [
            Event::ModifiersChanged(held),
            Event::PointerMoved(middle),
            button(middle, true),
            Event::PointerMoved(to),
            button(to, false),
        ];
        for event in events {
            harness.event(event);
            harness.step();
        }
        assert_eq!(harness.state().wishes, wished, "{held:?}");
    }
}

/// The overview is no plane that anybody follows: a drag turns it, and on the slices nothing happens.
#[test]
fn a_drag_turns_the_overview_and_a_double_click_turns_it_back() {
    let mut model = sample(37.4, 1.3).model();
    model.cells[0].is_surface = true;
    let screen = monitor([1920, 1080]);
    let cells = Sizes::of(screen, model.cells.len()).unwrap().cells;
    let (overview, slice) = (model.cells[0].view, model.cells[1].view);
    let button = |pos, pressed| Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::default(),
    };
    let wishes = |events: [Event; 4]| {
        let mut harness = stage(model.clone(), screen, Look::default());
        for event in events {
            harness.event(event);
            harness.step();
        }
        harness.state().wishes.clone()
    };
    let drag = |from: egui::Pos2| {
        let to = from + egui::vec2(30.0, -20.0);
        [
            Event::PointerMoved(from),
            button(from, true),
            Event::PointerMoved(to),
            button(to, false),
        ]
    };
    let turned = Wish::Turn {
        view: overview,
        right_px: 30,
        down_px: -20,
    };
    assert_eq!(wishes(drag(cells[0].center())), [turned]);
    assert_eq!(wishes(drag(cells[1].center())), []);
    // In one frame, as frames of the harness are longer than a double click.
    let twice = |at: egui::Pos2| {
        let [press, release] = [button(at, true), button(at, false)];
        let events = vec![Event::PointerMoved(at), press.clone(), release.clone(), press, release];
        shown(&model, screen, &Look::default(), events).wishes
    };
    assert!(twice(cells[0].center()).contains(&Wish::TurnBack(overview)));
    assert!(!twice(cells[1].center()).contains(&Wish::TurnBack(slice)));
}
