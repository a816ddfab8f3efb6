//! One image with its letters and title, and what lies over it where it is not to be followed.

use egui::{Align2, Color32, Id, PointerButton, Rect, Sense, Stroke, StrokeKind, Ui, Vec2, pos2, vec2};

use super::words::{Type, colour, on_band};
use super::{Outcome, Wish, texture, tree};
use crate::colours;
use crate::model::Cell;
use crate::sizes::Sizes;

/// A drag changes the window by so many HU a pixel.
pub(crate) const HU_PX: f32 = 2.0;
/// What is left of the light of an image that is not to be followed.
const DIMMED: u8 = 90;

/// Shows the image in the largest part of `rect` that has its shape, below a strip with its title and the letter of its upper side: the
/// alarms that renderers draw stand in the upper two thirds of an image, where nothing may cover them.
pub(super) fn show(ui: &mut Ui, cell: &Cell, rect: Rect, sizes: &Sizes, outcome: &mut Outcome) {
    let name = || format!("view {}", cell.view + 1);
    tree::group(ui, Id::unique(("cell", cell.view)), name, |ui| {
        touch(ui, cell, rect, outcome);
        draw(ui, cell, rect, sizes, outcome);
    });
}

fn draw(ui: &Ui, cell: &Cell, rect: Rect, sizes: &Sizes, outcome: &mut Outcome) {
    ui.painter().rect_filled(rect, 0.0, colours::CELL);
    let row = 1.2 * sizes.plain;
    let (strip, below) = rect.split_top_bottom_at_y(rect.top() + row);
    let image = image_rect(cell, below);
    if cell.size.is_some() {
        let light = if cell.over.is_some() { DIMMED } else { 255 };
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        ui.painter()
            .image(texture(cell.view), image, whole, Color32::from_gray(light));
    }
    ui.painter()
        .rect_stroke(rect, 0.0, Stroke::new(sizes.line, colours::LINE), StrokeKind::Inside);
    let how = |align, ground| Type {
        size: sizes.plain,
        colour: colours::of(picture::palette::WORDS),
        ground,
        align,
    };
    let strip = strip.shrink2(vec2(sizes.gap, 0.0));
    let (title, beside) = strip.split_left_right_at_fraction(0.76);
    outcome
        .words
        .put(ui, title, &cell.title, how(Align2::LEFT_CENTER, colours::CELL));
    if let Some([left, right, top, bottom]) = &cell.letters {
        outcome
            .words
            .put(ui, beside, top, how(Align2::CENTER_CENTER, colours::CELL));
        let rooms = letter_rooms(image, row, sizes);
        for (letter, (room, align)) in [left, right, bottom].into_iter().zip(rooms) {
            plate(ui, align, room, letter, sizes);
            outcome.words.put(ui, room, letter, how(align, Color32::BLACK));
        }
    }
    over(ui, cell, below.shrink(sizes.gap), sizes, outcome);
}

/// The largest part of the cell with the image's shape; an image of the cell's own size is not scaled at all.
fn image_rect(cell: &Cell, rect: Rect) -> Rect {
    let Some([width, height]) = cell.size.map(|size| size.map(|n| n as f32)) else {
        return rect;
    };
    let scale = (rect.width() / width).min(rect.height() / height);
    let size = (scale * vec2(width, height)).floor();
    let corner = (rect.center() - size / 2.0).floor();
    Rect::from_min_size(corner, size)
}

/// Where the letters of left, right and bottom stand: at the sides, below where renderers put alarms, and in the middle of the bottom.
fn letter_rooms(image: Rect, row: f32, sizes: &Sizes) -> [(Rect, Align2); 3] {
    let wide = 2.2 * sizes.plain;
    let inner = image.shrink(sizes.gap);
    let height = inner.top() + 0.8 * inner.height();
    let beside = |x: f32| Rect::from_min_size(pos2(x, height - row / 2.0), vec2(wide, row));
    let below = pos2(inner.center().x - wide / 2.0, inner.bottom() - row);
    [
        (beside(inner.left()), Align2::LEFT_CENTER),
        (beside(inner.right() - wide), Align2::RIGHT_CENTER),
        (Rect::from_min_size(below, vec2(wide, row)), Align2::CENTER_CENTER),
    ]
}

/// Letters on an image stand on black, so that they are read on bone as well.
fn plate(ui: &Ui, align: Align2, room: Rect, text: &str, sizes: &Sizes) {
    let width = (text.chars().count() as f32 * crate::sizes::ADVANCE * sizes.plain).min(room.width());
    let covered = align.align_size_within_rect(vec2(width, room.height()), room);
    ui.painter().rect_filled(covered, 0.0, Color32::BLACK);
}

/// Why the image is not to be followed, across its middle.
fn over(ui: &Ui, cell: &Cell, inner: Rect, sizes: &Sizes, outcome: &mut Outcome) {
    let Some((tone, text)) = &cell.over else { return };
    let height = 1.3 * sizes.critical;
    // In the middle, above the letters of left and right.
    let top = inner.center().y - height / 2.0;
    let band = Rect::from_min_size(pos2(inner.left(), top), vec2(inner.width(), height));
    ui.painter().rect_filled(band, 0.0, colour(*tone));
    let how = Type {
        size: sizes.critical,
        colour: on_band(*tone),
        ground: colour(*tone),
        align: Align2::CENTER_CENTER,
    };
    outcome.words.put(ui, band.shrink2(vec2(sizes.gap, 0.0)), text, how);
}

/// A touch enlarges the image, or brings the others back; a drag with Ctrl changes the window, and one on the overview turns it.
fn touch(ui: &Ui, cell: &Cell, rect: Rect, outcome: &mut Outcome) {
    let response = ui.interact(rect, Id::unique(("view", cell.view)), Sense::click_and_drag());
    let (moved, is_ctrl) = ui.input(|input| (input.pointer.delta(), input.modifiers.ctrl));
    // Without Ctrl a finger that slips would change what all images show.
    if is_ctrl && response.dragged_by(PointerButton::Primary) && moved != Vec2::ZERO {
        let [wider_hu, up_hu] = [moved.x, -moved.y].map(|pixels| (HU_PX * pixels).round() as i32);
        outcome.wishes.push(Wish::Level { wider_hu, up_hu });
    }
    if cell.is_surface && !is_ctrl && response.dragged_by(PointerButton::Primary) && moved != Vec2::ZERO {
        let [right_px, down_px] = [moved.x, moved.y].map(|pixels| pixels.round() as i32);
        outcome.wishes.push(Wish::Turn {
            view: cell.view,
            right_px,
            down_px,
        });
    }
    if cell.is_surface && response.double_clicked() {
        outcome.wishes.push(Wish::TurnBack(cell.view));
    }
    tree::image(&response, cell);
    if response.clicked() {
        outcome.wishes.push(Wish::Enlarge(Some(cell.view)));
    }
}
