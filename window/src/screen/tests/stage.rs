//! The screen under `egui_kittest`: without a card or a display, read and touched by way of the accessibility tree.

use egui::{Rect, Role};
use egui_kittest::kittest::NodeT as _;
use egui_kittest::{Harness, Node};

use crate::model::Model;
use crate::screen::{Look, Outcome, Wish, set_up, show};
use crate::sizes::Screen;

/// What is on the stage.
#[derive(Debug)]
pub(super) struct Stage {
    model: Model,
    screen: Screen,
    look: Look,
    /// The last frame.
    pub(super) outcome: Outcome,
    /// Of all frames.
    pub(super) wishes: Vec<Wish>,
}

/// The screen of `model`, laid out and with its tree. What has no letter in the screen's type is a mistake of a test.
pub(super) fn stage(model: Model, screen: Screen, look: Look) -> Harness<'static, Stage> {
    let [width, height] = screen.pixels.map(|n| n as f32);
    let stage = Stage {
        model,
        screen,
        look,
        outcome: Outcome::default(),
        wishes: Vec::new(),
    };
    let lay_out = |ui: &mut egui::Ui, stage: &mut Stage| {
        stage.outcome = show(ui, &stage.model, stage.screen, &stage.look);
        stage.wishes.append(&mut stage.outcome.wishes);
    };
    Harness::builder()
        .with_size([width, height])
        .with_context_setup(set_up)
        .build_ui_state(lay_out, stage)
}

/// A node of the tree, as far as tests ask.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Told {
    pub(super) role: Role,
    /// Its name; of a label, what it says.
    pub(super) name: String,
    /// The key of a button.
    pub(super) key: Option<String>,
    pub(super) description: Option<String>,
    pub(super) bounds: Option<Rect>,
}

/// All nodes below the root.
pub(super) fn told(harness: &Harness<'_, Stage>) -> Vec<Told> {
    harness.root().children_recursive().map(|node| told_of(&node)).collect()
}

fn told_of(node: &Node<'_>) -> Told {
    let node = node.accesskit_node();
    let name = match node.role() {
        Role::Label => node.value(),
        _ => node.label(),
    };
    let bounds = node.bounding_box().map(|at| {
        let corner = |x: f64, y: f64| egui::pos2(x as f32, y as f32);
        Rect::from_min_max(corner(at.x0, at.y0), corner(at.x1, at.y1))
    });
    Told {
        role: node.role(),
        name: name.unwrap_or_default(),
        key: node.data().keyboard_shortcut().map(str::to_owned),
        description: node.description(),
        bounds,
    }
}
