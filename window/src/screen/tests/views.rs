//! Which images a person chose to see.

use egui::Role;
use egui_kittest::kittest::Queryable as _;

use super::samples::views;
use super::stage::stage;
use super::{monitor, sample};
use crate::model::Model;
use crate::screen::{Look, Views};

/// The titles of the images on the screen.
fn titles(model: &Model, chosen: Views) -> Vec<String> {
    let look = Look {
        views: chosen,
        ..Look::default()
    };
    let harness = stage(model.clone(), monitor([1920, 1080]), look);
    let cells = model.cells.iter().map(|cell| &cell.title);
    let on_screen = cells.filter(|title| harness.query_by_label(title).is_some());
    on_screen.cloned().collect()
}

#[test]
fn local_and_global_images_are_those_of_their_names() {
    let model = sample(37.4, 1.3).model();
    assert_eq!(titles(&model, Views::All).len(), 7);
    let local = titles(&model, Views::Local);
    assert!(
        local.len() == 4 && local.iter().all(|title| title.ends_with("local")),
        "{local:?}"
    );
    let global = titles(&model, Views::Global);
    assert!(
        global.len() == 3 && global.iter().all(|title| title.ends_with("global")),
        "{global:?}"
    );
    let mut seen = vec![Views::All];
    for _ in 0..3 {
        seen.extend(seen.last().and_then(|views| views.next(&model.cells)));
    }
    assert_eq!(seen, [Views::All, Views::Local, Views::Global, Views::All]);
}

/// What is not shown still counts: an image that is lost takes the sight from the others.
#[test]
fn the_state_is_that_of_all_images() {
    use bus::message::{FrameState, Lost};
    let mut sample = sample(37.4, 1.3);
    let hidden = sample
        .scene
        .views
        .iter()
        .position(|view| view.extent == scene::Extent::Global);
    let header = sample.headers[hidden.unwrap()].as_mut().unwrap();
    header.stamp.state = FrameState::Lost(Lost::NotSeen).code();
    let look = Look {
        views: Views::Local,
        ..Look::default()
    };
    let harness = stage(sample.model(), monitor([1920, 1080]), look);
    assert!(harness.query_by_label("NO SIGHT").is_some());
}

#[test]
fn where_all_images_are_of_one_kind_there_is_nothing_to_choose() {
    let model = views(1).model();
    assert_eq!(model.cells.len(), 1);
    for chosen in Views::ALL {
        assert_eq!((chosen.next(&model.cells), titles(&model, chosen).len()), (None, 1));
    }
    let harness = stage(model, monitor([1920, 1080]), Look::default());
    let names = harness.query_all_by_role_and_label(Role::Button, "Views");
    assert_eq!(names.count(), 0);
}
