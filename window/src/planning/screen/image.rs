//! One image of the planning screen with what lies over it.

use egui::{Align2, Color32, Pos2, Rect, Stroke, StrokeKind, Ui, pos2};
use geometry::{Ct, Point, letters};
use guidance::plan::{Target, Trajectory};
use picture::palette;

use super::super::camera::Cut;
use super::super::desk::Desk;
use super::super::placed::Placed;
use super::{Known, marks, placed};
use crate::colours;
use crate::model::Tone;
use crate::screen::texture;
use crate::screen::words::{Type, Words, colour, on_band};
use crate::sizes::Sizes;

/// What is left of the light of an image that is not the one that is wanted.
const DIMMED: u8 = 110;

/// An image where it stands.
pub(super) struct Cell {
    pub(super) cut: Cut,
    /// All of it, with its title.
    pub(super) rect: Rect,
    /// The image's own part.
    pub(super) image: Rect,
    /// The plane that is shown, where there is one.
    pub(super) placed: Option<Placed>,
    /// Whether it is the plane that is wanted.
    is_wanted: bool,
    has_image: bool,
}

impl Cell {
    pub(super) fn of(known: &Known<'_>, cut: Cut, rect: Rect, sizes: &Sizes) -> Self {
        let strip = 1.2 * sizes.plain;
        let side = (rect.width().min(rect.height() - strip)).floor();
        let left = (rect.center().x - side / 2.0).floor();
        let image = Rect::from_min_size(pos2(left, rect.top() + strip), egui::Vec2::splat(side));
        let shown = known.images[cut.place()];
        Self {
            cut,
            rect,
            image,
            placed: shown.and_then(|(header, _)| placed(&header, image)),
            is_wanted: shown.is_some_and(|(_, is_wanted)| is_wanted),
            has_image: shown.is_some(),
        }
    }
}

pub(super) fn show(ui: &Ui, known: &Known<'_>, desk: &Desk, cell: &Cell, (sizes, words): (&Sizes, &mut Words)) {
    let painter = ui.painter();
    painter.rect_filled(cell.rect, 0.0, colours::CELL);
    if cell.has_image {
        let light = if cell.is_wanted { 255 } else { DIMMED };
        let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
        painter.image(texture(cell.cut.place()), cell.image, whole, Color32::from_gray(light));
    }
    if let Some(placed) = &cell.placed {
        over(ui, known, desk, cell, placed, (sizes, words));
    }
    painter.rect_stroke(
        cell.rect,
        0.0,
        Stroke::new(sizes.line, colours::LINE),
        StrokeKind::Inside,
    );
    title(ui, desk, cell, (sizes, words));
    if !cell.has_image {
        missing(ui, known, desk, cell, (sizes, words));
    }
}

/// Targets, ways and measures, within the image alone.
fn over(ui: &Ui, known: &Known<'_>, desk: &Desk, cell: &Cell, placed: &Placed, (sizes, words): (&Sizes, &mut Words)) {
    let painter = ui.painter().with_clip_rect(cell.image);
    let pen = marks::Pen {
        painter: &painter,
        placed,
        width: sizes.line,
    };
    let plan = desk.shown(known.plan);
    if cell.cut != Cut::Along {
        pen.cross(desk.camera.cursor);
    }
    for target in &plan.targets {
        let is_selected = desk.selected.as_ref() == Some(&target.name);
        if let Some(way) = Trajectory::of(target) {
            pen.way(&way, is_selected.then_some(known.tube_mm / 2.0));
        }
        pen.target(target, is_selected);
        name(ui, target, placed, cell, (sizes, words));
    }
    for measure in &plan.measures {
        pen.measure(measure.points());
        value(ui, measure, placed, cell, (sizes, words));
    }
    if let super::super::desk::Mode::Measure(points, _) = &desk.mode {
        pen.measure(points);
    }
    sides(ui, placed, cell, (sizes, words));
}

/// A target's name beside its ring, where the plane meets it.
fn name(ui: &Ui, target: &Target, placed: &Placed, cell: &Cell, with: (&Sizes, &mut Words)) {
    let (at, depth_mm) = placed.on_screen(target.centre);
    if depth_mm.abs() <= target.diameter_mm / 2.0 {
        // Above: the way may leave at either side.
        let reach = placed.px(target.diameter_mm / 2.0) + 6.0 * with.0.line;
        beside(
            ui,
            at - egui::vec2(0.0, reach + 0.7 * with.0.plain),
            -with.0.gap,
            &target.name,
            cell,
            with,
        );
    }
}

/// What was measured, beside its last point, where the plane is near all of its points.
fn value(ui: &Ui, measure: &guidance::plan::Measure, placed: &Placed, cell: &Cell, with: (&Sizes, &mut Words)) {
    let is_near = |p: &Point<Ct>| placed.on_screen(*p).1.abs() <= marks::NEAR_MM;
    let Some(last) = measure.points().last() else { return };
    if !measure.points().iter().all(is_near) {
        return;
    }
    let text = match (measure.distance_mm(), measure.angle_rad()) {
        (Some(mm), _) => format!("{mm:.1} mm"),
        (None, Some(rad)) => format!("{:.1}\u{b0}", rad.to_degrees()),
        (None, None) => return,
    };
    beside(ui, placed.on_screen(*last).0, 4.0, &text, cell, with);
}

/// Words at the right of a place, or at its left where there is no room; none where the place is not on the image.
fn beside(ui: &Ui, at: Pos2, reach: f32, text: &str, cell: &Cell, (sizes, words): (&Sizes, &mut Words)) {
    if !cell.image.contains(at) {
        return;
    }
    let (wide, high) = (
        crate::sizes::ADVANCE * sizes.plain * (text.chars().count() as f32 + 0.5),
        1.2 * sizes.plain,
    );
    let right = at.x + reach + sizes.gap;
    let left = if right + wide <= cell.image.right() {
        right
    } else {
        at.x - reach - sizes.gap - wide
    };
    let top = (at.y - high / 2.0).clamp(cell.image.top(), cell.image.bottom() - high);
    let room = Rect::from_min_size(pos2(left, top), egui::vec2(wide, high)).intersect(cell.image);
    // Names that would cover one another are told in the panel.
    if words.0.iter().any(|other| other.covers.intersects(room)) || room.width() < wide - 1.0 {
        return;
    }
    ui.painter().rect_filled(room, 2.0, Color32::from_black_alpha(170));
    let how = Type {
        size: sizes.plain,
        colour: colours::of(palette::WORDS),
        ground: Color32::BLACK,
        align: Align2::CENTER_CENTER,
    };
    words.put(ui, room, text, how);
}

/// The patient's sides at the left, the right and the bottom: from the plane itself. That at the top stands in the title.
fn sides(ui: &Ui, placed: &Placed, cell: &Cell, (sizes, words): (&Sizes, &mut Words)) {
    let (right, down) = (placed.plane.right(), placed.plane.down());
    let (wide, high) = (2.4 * sizes.plain, 1.2 * sizes.plain);
    let inner = cell.image.shrink(2.0);
    let middle = inner.top() + 0.72 * inner.height();
    let rooms = [
        (letters(-right), pos2(inner.left(), middle)),
        (letters(right), pos2(inner.right() - wide, middle)),
        (
            letters(down),
            pos2(inner.center().x - wide / 2.0, inner.bottom() - high),
        ),
    ];
    for (text, at) in rooms {
        let room = Rect::from_min_size(at, egui::vec2(wide, high));
        ui.painter().rect_filled(room, 2.0, Color32::BLACK);
        let how = Type {
            size: sizes.plain,
            colour: colours::of(palette::WORDS),
            ground: Color32::BLACK,
            align: Align2::CENTER_CENTER,
        };
        words.put(ui, room, &text, how);
    }
}

/// The cut and where it lies, and the letter of its upper side.
fn title(ui: &Ui, desk: &Desk, cell: &Cell, (sizes, words): (&Sizes, &mut Words)) {
    let strip = Rect::from_min_max(cell.rect.min, pos2(cell.rect.right(), cell.image.top()));
    let (left, right) = strip
        .shrink2(egui::vec2(sizes.gap, 0.0))
        .split_left_right_at_fraction(0.8);
    let how = |align| Type {
        size: sizes.plain,
        colour: colours::of(palette::WORDS),
        ground: colours::CELL,
        align,
    };
    let place = cell.placed.as_ref().and_then(|placed| position(cell.cut, placed));
    let text = match (place, cell.cut) {
        (Some(place), _) => format!("{}  {place}", cell.cut.title()),
        (None, Cut::Along) => match &desk.selected {
            Some(name) => format!("{}  {name}", cell.cut.title()),
            None => cell.cut.title().to_owned(),
        },
        (None, _) => cell.cut.title().to_owned(),
    };
    words.put(ui, left, &text, how(Align2::LEFT_CENTER));
    if let Some(placed) = &cell.placed {
        let up = letters(-placed.plane.down());
        words.put(ui, right, &up, how(Align2::CENTER_CENTER));
    }
}

/// Where a slice lies along the axis across it, by the letter of its side: the plane that is shown, not the one that is wanted.
fn position(cut: Cut, placed: &Placed) -> Option<String> {
    let [x, y, z] = placed.plane.origin().mm();
    let (value, sides) = match cut {
        Cut::Axial => (z, ["S", "I"]),
        Cut::Frontal => (y, ["P", "A"]),
        Cut::Sagittal => (x, ["L", "R"]),
        Cut::Along => return None,
    };
    let side = if value < 0.0 { sides[1] } else { sides[0] };
    Some(format!("{side} {:.1} mm", value.abs()))
}

/// Why there is no image.
fn missing(ui: &Ui, known: &Known<'_>, desk: &Desk, cell: &Cell, (sizes, words): (&Sizes, &mut Words)) {
    let (tone, text) = match (cell.cut, desk.target(known.plan)) {
        (Cut::Along, None) => (Tone::Quiet, "no target"),
        (Cut::Along, Some(target)) if target.entry.is_none() => (Tone::Quiet, "no entry: E sets it"),
        _ => (Tone::Alarm, "NO IMAGE"),
    };
    let band = Rect::from_center_size(
        cell.image.center(),
        egui::vec2(cell.image.width() * 0.8, 1.4 * sizes.plain),
    );
    let ground = if tone == Tone::Alarm {
        colour(tone)
    } else {
        colours::CELL
    };
    ui.painter().rect_filled(band, 3.0, ground);
    let ink = if tone == Tone::Alarm {
        on_band(tone)
    } else {
        colour(Tone::Quiet)
    };
    let how = Type {
        size: sizes.plain,
        colour: ink,
        ground,
        align: Align2::CENTER_CENTER,
    };
    words.put(ui, band, text, how);
}
