//! One image with its letters and title, and what lies over it where it is not to be followed.

use egui::{Align2, Color32, Id, Rect, Role, Sense, Stroke, StrokeKind, Ui, WidgetInfo, pos2, vec2};

use super::words::{Type, colour};
use super::{Outcome, Wish, texture};
use crate::colours;
use crate::model::Cell;
use crate::sizes::Sizes;

/// What is left of the light of an image that is not to be followed.
const DIMMED: u8 = 90;

/// Shows the image in the largest part of `rect` that has its shape.
pub(super) fn show(ui: &mut Ui, cell: &Cell, rect: Rect, sizes: &Sizes, outcome: &mut Outcome) {
    ui.painter().rect_filled(rect, 0.0, colours::CELL);
    let image = image_rect(cell, rect);
    if cell.size.is_some() {
        let light = if cell.over.is_some() { DIMMED } else { 255 };
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        ui.painter()
            .image(texture(cell.view), image, whole, Color32::from_gray(light));
    }
    ui.painter()
        .rect_stroke(rect, 0.0, Stroke::new(1.0, colours::LINE), StrokeKind::Inside);
    let on_image = |align| Type {
        size: sizes.plain,
        colour: colours::of(picture::palette::WORDS),
        ground: Color32::BLACK,
        align,
    };
    let inner = rect.shrink(sizes.gap);
    let row = 1.25 * sizes.plain;
    let title = Rect::from_min_size(inner.min, vec2(0.72 * inner.width(), row));
    plate(ui, title, &cell.title, sizes);
    outcome.words.put(ui, title, &cell.title, on_image(Align2::LEFT_TOP));
    if let Some(letters) = &cell.letters {
        let rooms = letter_rooms(inner, row, sizes.plain);
        for (letter, (room, align)) in letters.iter().zip(rooms) {
            plate_at(ui, align, room, letter, sizes);
            outcome.words.put(ui, room, letter, on_image(align));
        }
    }
    over(ui, cell, inner, sizes, outcome);
    touch(ui, cell, rect, outcome);
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

/// Where the letters of left, right, top and bottom stand: the middle of each side, a little off where the title is.
fn letter_rooms(inner: Rect, row: f32, size: f32) -> [(Rect, Align2); 4] {
    let wide = 2.2 * size;
    let beside = |x: f32| Rect::from_min_size(pos2(x, inner.center().y - row / 2.0), vec2(wide, row));
    let middle = |y: f32| Rect::from_min_size(pos2(inner.center().x - wide / 2.0, y), vec2(wide, row));
    [
        (beside(inner.left()), Align2::LEFT_CENTER),
        (beside(inner.right() - wide), Align2::RIGHT_CENTER),
        (middle(inner.top() + row), Align2::CENTER_CENTER),
        (middle(inner.bottom() - row), Align2::CENTER_CENTER),
    ]
}

/// Letters on an image stand on black, so that they are read on bone as well.
fn plate(ui: &Ui, room: Rect, text: &str, sizes: &Sizes) {
    plate_at(ui, Align2::LEFT_TOP, room, text, sizes);
}

fn plate_at(ui: &Ui, align: Align2, room: Rect, text: &str, sizes: &Sizes) {
    let width = (text.chars().count() as f32 * crate::sizes::ADVANCE * sizes.plain).min(room.width());
    let covered = align.align_size_within_rect(vec2(width, room.height()), room);
    ui.painter().rect_filled(covered, 0.0, Color32::BLACK);
}

/// Why the image is not to be followed, across its middle.
fn over(ui: &Ui, cell: &Cell, inner: Rect, sizes: &Sizes, outcome: &mut Outcome) {
    let Some((tone, text)) = &cell.over else { return };
    let height = 1.3 * sizes.critical;
    // Below the middle, where the letters of left and right stand.
    let top = inner.center().y + 1.25 * sizes.plain;
    let band = Rect::from_min_size(pos2(inner.left(), top), vec2(inner.width(), height));
    ui.painter().rect_filled(band, 0.0, colour(*tone));
    let how = Type {
        size: sizes.critical,
        colour: colours::ON_BAND,
        ground: colour(*tone),
        align: Align2::CENTER_CENTER,
    };
    outcome.words.put(ui, band.shrink2(vec2(sizes.gap, 0.0)), text, how);
}

/// A touch enlarges the image, or brings the others back.
fn touch(ui: &Ui, cell: &Cell, rect: Rect, outcome: &mut Outcome) {
    let response = ui.interact(rect, Id::unique(("view", cell.view)), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, format!("{}: enlarge", cell.title)));
    if response.clicked() {
        outcome.wishes.push(Wish::Enlarge(Some(cell.view)));
    }
}
