//! How large things are on the screen: words by the angle under which they are seen, buttons by the finger.
//!
//! A letter of height h seen from a distance d takes the angle `2 atan(h / 2 d)`. What is critical (state, verdict, distances) is to be
//! read from two metres under 20 minutes of arc, the rest from one metre under 16 (ISO 9241-303, NUREG-0700 1.3.1). How many pixels
//! that takes depends on the monitor's millimetres, which the display or the scene says.

use egui::{Pos2, Rect, vec2};

/// Height of a capital letter, parts of the type's size: Hack.
pub const CAPITAL: f32 = 0.729;
/// Width of a letter, parts of the type's size: all are equally wide.
pub const ADVANCE: f32 = 0.602;
/// Height of a line, parts of the type's size.
pub const LINE: f32 = 1.17;
/// The least angle of what is critical, minutes of arc, and from how far, mm.
pub const CRITICAL: (f32, f32) = (20.0, 2000.0);
/// The same of all other words.
pub const PLAIN: (f32, f32) = (16.0, 1000.0);
/// The least side of what is touched with a gloved finger, mm.
pub const TOUCH_MM: f32 = 20.0;
/// The type of a piece of text becomes no smaller than this part of what is asked.
pub const SMALLEST_PART: f32 = 0.6;
/// What a distance is of, under it: so many letters.
const LONGEST_CAPTION: f32 = 17.0;
/// The longest verdict is so many letters: the sight's cell must hold it in one line.
const LONGEST_VERDICT: f32 = 13.0;
/// The height of a replay's bar, parts of the type's size: three lines.
const BAR_LINES: f32 = 3.7;
/// A screen with fewer pixels has no room for eight cells with words in them.
pub const SMALLEST: [u32; 2] = [1024, 640];
/// The same for the sight alone: numbers would be cut.
pub const SMALLEST_SIGHT: [u32; 2] = [640, 480];

/// A screen, and what it is seen by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Screen {
    /// Columns and rows.
    pub pixels: [u32; 2],
    /// Side of a pixel, mm.
    pub pixel_mm: f32,
}

/// Where everything is, pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct Sizes {
    /// Of the type of what is critical.
    pub critical: f32,
    /// Of the type of all else.
    pub plain: f32,
    /// Between things.
    pub gap: f32,
    /// Of a thin line: on every screen as wide to the eye.
    pub line: f32,
    /// The band at the top.
    pub top: Rect,
    /// What a replay is steered by, above the buttons.
    pub bar: Option<Rect>,
    /// The buttons at the bottom.
    pub foot: Rect,
    /// Of each cell, row by row.
    pub cells: Vec<Rect>,
    /// Which of them is the sight's.
    pub sight: usize,
    /// From how far what is critical can be read under 20 minutes of arc, mm: less than two metres where the screen is too small.
    pub critical_from_mm: f32,
}

/// The height of a capital that is seen under `minutes` of arc from `distance_mm`, mm.
pub fn capital_mm((minutes, distance_mm): (f32, f32)) -> f32 {
    2.0 * distance_mm * (minutes / 60.0 / 2.0).to_radians().tan()
}

impl Screen {
    /// The type whose capitals are seen so, pixels.
    pub fn type_px(&self, seen: (f32, f32)) -> f32 {
        capital_mm(seen) / self.pixel_mm / CAPITAL
    }
}

impl Sizes {
    /// For so many images and the sight, or for the sight alone; `None` where the screen is too small for words.
    pub fn of(screen: Screen, images: usize) -> Option<Self> {
        let least = smallest(images);
        if screen.pixels[0] < least[0] || screen.pixels[1] < least[1] {
            return None;
        }
        let [width, height] = screen.pixels.map(|n| n as f32);
        // No larger than that the bands hold it: at the top left stand 44 letters of birth date, number and examination.
        let most = (height / 24.0).min(width / 60.0).floor().max(10.0);
        let mut plain = screen.type_px(PLAIN).ceil().clamp(10.0, most);
        let wanted = screen.type_px(CRITICAL).ceil();
        // First as large as it should be; where the cells are too small for that, as large as they hold.
        let side = |critical: f32, plain: f32| {
            let top = top_height(critical, plain);
            let foot = foot_height(screen, height, plain);
            best_grid(images + 1, [width, height - top - foot])
        };
        let mut critical = wanted;
        for _ in 0..4 {
            let (cell, _) = side(critical, plain);
            while plain > 10.0 && !holds_captions(cell, plain) {
                plain -= 1.0;
            }
            critical = wanted.min(0.99 * cell / (LONGEST_VERDICT * ADVANCE));
        }
        let critical = critical.floor().max(plain);
        let (cell, columns) = side(critical, plain);
        let (top, foot) = (top_height(critical, plain), foot_height(screen, height, plain));
        let cells = grid(images + 1, columns, cell, [width, height - top - foot], top);
        Some(Self {
            critical,
            plain,
            gap: gap(plain),
            line: (plain / 16.0).max(1.0),
            top: Rect::from_min_size(Pos2::ZERO, vec2(width, top)),
            bar: None,
            foot: Rect::from_min_size(Pos2::new(0.0, height - foot), vec2(width, foot)),
            cells,
            sight: columns.min(images + 1) - 1,
            critical_from_mm: CRITICAL.1 * (critical / wanted).min(1.0),
        })
    }
}

impl Sizes {
    /// The same with a bar for a replay above the buttons where that is wanted and there is room for it.
    pub fn with_bar(screen: Screen, images: usize, is_wanted: bool) -> Option<Self> {
        let plain = Self::of(screen, images)?;
        if !is_wanted {
            return Some(plain);
        }
        let bar = (BAR_LINES * plain.plain).ceil();
        let [width, height] = screen.pixels;
        let shorter = Screen {
            pixels: [width, height.saturating_sub(bar as u32)],
            ..screen
        };
        let Some(sizes) = Self::of(shorter, images) else {
            return Some(plain);
        };
        let room = Rect::from_min_size(sizes.foot.left_top(), vec2(width as f32, bar));
        Some(Self {
            bar: Some(room),
            foot: sizes.foot.translate(vec2(0.0, bar)),
            ..sizes
        })
    }
}

/// The fewest pixels for so many images.
pub const fn smallest(images: usize) -> [u32; 2] {
    if images == 0 { SMALLEST_SIGHT } else { SMALLEST }
}

/// Whether the sight's cell has room for what its two distances are of, side by side, in the smallest type.
fn holds_captions(cell: f32, plain: f32) -> bool {
    let caption = LONGEST_CAPTION * ADVANCE * (SMALLEST_PART * plain).floor();
    2.0 * (caption + gap(plain) + 1.0) <= cell
}

fn gap(plain: f32) -> f32 {
    (0.3 * plain).round()
}

/// The state above and a plain line below; beside them three plain lines.
fn top_height(critical: f32, plain: f32) -> f32 {
    (critical.max(2.0 * LINE * plain) + LINE * plain + 4.0).round()
}

/// A button has two plain lines, however coarse the pixels are.
fn foot_height(screen: Screen, height: f32, plain: f32) -> f32 {
    (TOUCH_MM / screen.pixel_mm)
        .min(height / 8.0)
        .max(2.0 * LINE * plain + 8.0)
        .round()
}

/// The largest square cells, and how many columns of them.
fn best_grid(count: usize, [width, height]: [f32; 2]) -> (f32, usize) {
    let side = |columns: usize| {
        (width / columns as f32)
            .min(height / count.div_ceil(columns) as f32)
            .floor()
    };
    let all = (1..=count).map(|columns| (side(columns), columns));
    all.fold((0.0, 1), |best, next| if next.0 > best.0 { next } else { best })
}

fn grid(count: usize, columns: usize, side: f32, [width, height]: [f32; 2], top: f32) -> Vec<Rect> {
    let rows = count.div_ceil(columns);
    let left = ((width - side * columns as f32) / 2.0).floor();
    let above = top + ((height - side * rows as f32) / 2.0).floor();
    let at = |k: usize| Pos2::new(left + side * (k % columns) as f32, above + side * (k / columns) as f32);
    (0..count)
        .map(|k| Rect::from_min_size(at(k), vec2(side, side)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A monitor of 24 inches, 531 mm wide.
    fn monitor(width: u32, height: u32) -> Screen {
        Screen {
            pixels: [width, height],
            pixel_mm: 531.0 / width as f32,
        }
    }

    #[test]
    fn what_is_critical_is_read_from_two_metres_on_a_monitor_of_24_inches() {
        for (width, height) in [(1280, 800), (1920, 1080), (3840, 2160)] {
            let screen = monitor(width, height);
            let sizes = Sizes::of(screen, 7).unwrap();
            let seen = |size: f32, from: f32| {
                let capital_mm = f64::from(size * CAPITAL * screen.pixel_mm);
                2.0 * (capital_mm / 2.0 / f64::from(from)).atan().to_degrees() * 60.0
            };
            let (critical, plain) = (seen(sizes.critical, 2000.0), seen(sizes.plain, 1000.0));
            println!(
                "{width} x {height}: critical {critical:.1}' at 2 m, plain {plain:.1}' at 1 m, cells {}",
                sizes.cells[0].width()
            );
            assert!(critical >= 20.0 && plain >= 16.0, "{critical} {plain}");
        }
    }

    proptest! {
        #[test]
        fn nothing_lies_over_anything_else(
            width in 1024_u32..4000, height in 640_u32..2400, images in 0_usize..17, pixel_mm in 0.05_f32..0.6, has_bar: bool
        ) {
            let sizes = Sizes::with_bar(Screen { pixels: [width, height], pixel_mm }, images, has_bar).unwrap();
            let screen = Rect::from_min_size(Pos2::ZERO, vec2(width as f32, height as f32));
            let mut all = sizes.cells.clone();
            prop_assert_eq!(all.len(), images + 1);
            prop_assert!(sizes.sight < all.len());
            all.extend([sizes.top, sizes.foot]);
            all.extend(sizes.bar);
            for (i, a) in all.iter().enumerate() {
                prop_assert!(screen.contains_rect(*a), "{a:?} leaves {screen:?}");
                for b in &all[i + 1..] {
                    let common = a.intersect(*b);
                    prop_assert!(!(common.width() > 0.0 && common.height() > 0.0), "{a:?} {b:?}");
                }
            }
        }
    }
}
