//! The accessibility tree says what stands on the screen, all of it and nothing else.

use egui::Role;

use super::samples::all;
use super::stage::{Told, stage, told};
use super::{SCREENS, monitor};
use crate::screen::{Look, Outcome};

/// What the tree says word for word: labels and states, and on each button its word and its key.
fn said(told: &[Told]) -> Vec<&str> {
    let words = told.iter().filter_map(|node| match node.role {
        Role::Label | Role::Status | Role::Alert | Role::Button => Some(node.name.as_str()),
        _ => None,
    });
    let mut all: Vec<&str> = words
        .chain(told.iter().filter_map(|node| node.key.as_deref()))
        .collect();
    all.sort_unstable();
    all
}

/// What stands on the screen, in full where it was shortened.
fn painted(outcome: &Outcome) -> Vec<&str> {
    let mut all: Vec<&str> = outcome.words.0.iter().map(|placed| placed.text.as_str()).collect();
    all.sort_unstable();
    all
}

fn looks() -> [Look; 3] {
    let enlarged = Look {
        enlarged: Some(0),
        ..Look::default()
    };
    let only_sight = Look {
        only_sight: true,
        ..Look::default()
    };
    let noted = Look {
        note: "no answer within 150 ms".to_owned(),
        ..enlarged
    };
    [Look::default(), noted, only_sight]
}

#[test]
fn the_tree_says_every_word_of_the_screen_and_no_other() {
    let mut words = 0;
    for (name, sample) in all() {
        for (pixels, look) in SCREENS
            .into_iter()
            .flat_map(|pixels| looks().map(|look| (pixels, look)))
        {
            let harness = stage(sample.model(), monitor(pixels), look);
            let told = told(&harness);
            assert_eq!(said(&told), painted(&harness.state().outcome), "{name}, {pixels:?}");
            words += harness.state().outcome.words.0.len();
        }
    }
    println!("{words} words");
    assert!(words > 5000);
}

#[test]
fn each_node_lies_where_its_word_is_painted() {
    for (name, sample) in all() {
        let harness = stage(sample.model(), monitor([1920, 1080]), Look::default());
        let told = told(&harness);
        for placed in &harness.state().outcome.words.0 {
            let covers = |node: &Told| {
                let is_it = node.name == placed.text || node.key.as_deref() == Some(&placed.text);
                is_it
                    && node
                        .bounds
                        .is_some_and(|at| at.expand(1.0).contains_rect(placed.covers))
            };
            assert!(told.iter().any(covers), "{name}: {placed:?}");
        }
    }
}

#[test]
fn images_are_named_by_their_view_and_what_stands_on_them() {
    for (name, sample) in all() {
        let model = sample.model();
        let harness = stage(model.clone(), monitor([1920, 1080]), Look::default());
        let told = told(&harness);
        let images: Vec<&Told> = told.iter().filter(|node| node.role == Role::Image).collect();
        assert_eq!(images.len(), model.cells.len(), "{name}");
        for (image, cell) in images.into_iter().zip(&model.cells) {
            let mut on_it = vec![&cell.title];
            on_it.extend(cell.letters.iter().flatten());
            on_it.extend(cell.over.iter().map(|(_, why)| why));
            assert!(on_it.iter().all(|text| image.name.contains(*text)), "{name}: {image:?}");
            assert!(image.description.is_some());
        }
    }
}

#[test]
fn alarms_interrupt_and_all_other_states_wait() {
    for (name, sample) in all() {
        let model = sample.model();
        let harness = stage(model.clone(), monitor([1920, 1080]), Look::default());
        let told = told(&harness);
        let is_state = |node: &&Told| matches!(node.role, Role::Status | Role::Alert) && node.name == model.state.word;
        let state = told.iter().find(is_state).unwrap();
        let is_alarm = model.state.tone == crate::model::Tone::Alarm;
        assert_eq!(state.role == Role::Alert, is_alarm, "{name}");
    }
}

#[test]
fn the_sight_is_a_group_that_says_what_its_drawing_says() {
    let (_, sample) = all().swap_remove(4);
    let harness = stage(sample.model(), monitor([1920, 1080]), Look::default());
    let told = told(&harness);
    let drawing = told
        .iter()
        .find(|node| node.role == Role::Group && node.name.starts_with("the sight"));
    let name = &drawing.unwrap().name;
    assert!(name.contains("target 1.3 mm to the left"), "{name}");
    assert!(name.contains("error in 95 of 100 cases"), "{name}");
    for word in ["24.9", "1.3", "mm to 12.5 before"] {
        assert!(
            told.iter().any(|node| node.role == Role::Label && node.name == word),
            "{word}"
        );
    }
    let angle = told.iter().find(|node| node.name.starts_with("mm off  ")).unwrap();
    assert!(angle.name.ends_with('\u{b0}'), "{angle:?}");
}

#[test]
fn a_screen_that_is_too_small_says_so_in_the_tree() {
    let (_, sample) = all().swap_remove(0);
    let harness = stage(sample.model(), monitor([640, 480]), Look::default());
    let told = told(&harness);
    assert_eq!(
        said(&told),
        ["SCREEN TOO SMALL: 640 x 480", "at least 1024 x 640 are needed"]
    );
    assert!(told.iter().any(|node| node.role == Role::Alert));
}

/// Nobody pays for a tree that nobody asked for: there is none, and the screen is the same.
#[test]
fn without_a_reader_there_is_no_tree_and_the_screen_is_the_same() {
    for (name, sample) in all() {
        let model = sample.model();
        let alone = super::shown(&model, monitor([1920, 1080]), &Look::default(), Vec::new());
        let harness = stage(model, monitor([1920, 1080]), Look::default());
        assert_eq!(alone.words, harness.state().outcome.words, "{name}");
    }
}
