//! The same screen for those who do not see it, and for tests: the accessibility tree.
//!
//! Each piece of text is a node with its whole text, also where the screen had room for a part of it. What belongs together is a group: the
//! sight, each image with its letters. Where nobody has asked for the tree nothing is made of it: a frame then looks up once a word
//! whether there is one.

use egui::accesskit::Live;
use egui::{Id, Rect, Response, Role, Sense, Ui, UiBuilder, WidgetInfo};

use crate::model::{Cell, Tone};

/// Whether somebody wants the tree: only then has the [`Ui`] a node.
fn is_wanted(ui: &Ui) -> bool {
    ui.ctx().has_accesskit_node(ui.unique_id())
}

/// What a state of this tone is: an alarm interrupts whoever reads the screen aloud, everything else waits its turn.
pub(crate) const fn role(tone: Tone) -> Role {
    match tone {
        Tone::Alarm => Role::Alert,
        Tone::Live | Tone::Quiet | Tone::Warning | Tone::Replay => Role::Status,
    }
}

/// A piece of text that covers `covers` of its `room`. Rooms do not overlap and stay where they are, so that a word that changes is the
/// same node with another text.
pub(crate) fn word(ui: &Ui, room: Rect, covers: Rect, text: &str, role: Role) {
    if !is_wanted(ui) {
        return;
    }
    let place = [room.min.x, room.min.y, room.max.x, room.max.y].map(f32::to_bits);
    let response = ui.interact(covers, Id::unique(("word", place)), Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(role, true, text));
    let live = match role {
        Role::Alert => Live::Assertive,
        Role::Status => Live::Polite,
        _ => return,
    };
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_live(live));
}

/// Nodes that belong together, called `name`.
pub(crate) fn group<R>(ui: &mut Ui, id: Id, name: impl FnOnce() -> String, contents: impl FnOnce(&mut Ui) -> R) -> R {
    if !is_wanted(ui) {
        return contents(ui);
    }
    let builder = UiBuilder::new()
        .scope_id(id)
        .max_rect(ui.max_rect())
        .accessibility_role(Role::Group)
        .accessibility_label(name());
    contents(&mut ui.new_child(builder))
}

/// An image, which a touch enlarges.
pub(crate) fn image(response: &Response, cell: &Cell) {
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, name(cell)));
    response
        .ctx
        .accesskit_node_builder(response.id, |node| node.set_description("a touch enlarges it"));
}

/// The view, why its image is not to be followed, and which sides of the patient are at its sides.
fn name(cell: &Cell) -> String {
    let mut said = vec![cell.title.clone()];
    said.extend(cell.over.iter().map(|(_, why)| why.clone()));
    if let Some(letters) = &cell.letters {
        let sides = letters.iter().zip(["left", "right", "top", "bottom"]);
        said.extend(sides.map(|(letter, side)| format!("{letter} at the {side}")));
    }
    said.join(", ")
}

/// A button with its word and the key that does the same.
pub(crate) fn button(response: &Response, word: &str, key: &str) {
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, word));
    response
        .ctx
        .accesskit_node_builder(response.id, |node| node.set_keyboard_shortcut(key));
}

/// A button that does nothing now.
pub(crate) fn disabled(response: &Response, word: &str, key: &str) {
    response.widget_info(|| WidgetInfo::labeled(Role::Button, false, word));
    response
        .ctx
        .accesskit_node_builder(response.id, |node| node.set_keyboard_shortcut(key));
}

/// An image of the planning screen.
pub(crate) fn cut(response: &Response, title: &str) {
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, title));
    let what = "the wheel goes through slices, a click points, two enlarge it";
    response
        .ctx
        .accesskit_node_builder(response.id, |node| node.set_description(what));
}
