//! Where words may stand: wholly in the image, and never over one another.
//!
//! A distance whose last digits are cut off by the border, or run into another number, is another distance. So each caption
//! brings the spots where it may stand, the first one that is free is taken, and what finds none is left out and counted.

use picture::{Anchor, PixelBox, Rgb, text_box, text_width};

/// Words with the spots where they may stand, best first.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Caption {
    pub(super) text: String,
    /// Of the type, pixels.
    pub(super) size: f32,
    pub(super) colour: Rgb,
    pub(super) spots: Vec<([f64; 2], Anchor)>,
}

/// A caption in its place.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Placed {
    pub(super) text: String,
    pub(super) size: f32,
    pub(super) colour: Rgb,
    pub(super) at: [f64; 2],
    pub(super) anchor: Anchor,
}

/// The words of one image.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    image: PixelBox,
    /// What no caption may cover.
    taken: Vec<PixelBox>,
    pub(super) placed: Vec<Placed>,
    /// How many captions found no spot.
    pub(super) left_out: usize,
}

impl Layout {
    /// Of an image of `width` x `height` pixels with nothing on it.
    pub(super) fn new(width: u32, height: u32) -> Self {
        Self {
            image: PixelBox {
                left: 0,
                top: 0,
                right: width as i32,
                bottom: height as i32,
            },
            taken: Vec::new(),
            placed: Vec::new(),
            left_out: 0,
        }
    }

    /// Keeps captions off the rectangle from `low` to `high`, pixels.
    pub(super) fn keep_free(&mut self, low: [f64; 2], high: [f64; 2]) {
        self.taken.push(PixelBox {
            left: low[0].floor() as i32,
            top: low[1].floor() as i32,
            right: high[0].ceil() as i32 + 1,
            bottom: high[1].ceil() as i32 + 1,
        });
    }

    /// Puts the caption on the first of its spots that is free; returns whether there was one. Words without ink take no room.
    pub(super) fn place(&mut self, caption: Caption) -> bool {
        for &(at, anchor) in &caption.spots {
            let Some(covered) = text_box(at, &caption.text, caption.size, anchor) else {
                return true;
            };
            if self.image.holds(&covered) && !self.taken.iter().any(|other| other.overlaps(&covered)) {
                self.stand(caption, at, anchor, covered);
                return true;
            }
        }
        self.left_out += 1;
        false
    }

    /// The same for a caption that may be missing: it is not counted.
    pub(super) fn place_if_room(&mut self, caption: Caption) {
        let left_out = self.left_out;
        self.place(caption);
        self.left_out = left_out;
    }

    /// Writes `text` where `room` was placed, or removes that where `text` is empty.
    pub(super) fn fill(&mut self, room: &str, text: &str) {
        if text.is_empty() {
            self.placed.retain(|placed| placed.text != room);
        }
        for placed in self.placed.iter_mut().filter(|placed| placed.text == room) {
            text.clone_into(&mut placed.text);
        }
    }

    fn stand(&mut self, caption: Caption, at: [f64; 2], anchor: Anchor, covered: PixelBox) {
        self.taken.push(covered);
        self.placed.push(Placed {
            text: caption.text,
            size: caption.size,
            colour: caption.colour,
            at,
            anchor,
        });
    }
}

/// `text` in lines of at most `width` pixels, broken at spaces (and not at those that do not break, U+00A0, which keep a number
/// with its unit); what is longer between two spaces stands alone.
pub(super) fn wrapped(text: &str, size: f32, width: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ').filter(|word| !word.is_empty()) {
        let longer = lines.last().map(|line| format!("{line} {word}"));
        match (longer, lines.last_mut()) {
            (Some(longer), Some(line)) if f64::from(text_width(&longer, size)) <= width => *line = longer,
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn caption(text: &str, at: &[[f64; 2]]) -> Caption {
        Caption {
            text: text.to_owned(),
            size: 12.0,
            colour: Rgb(255, 255, 255),
            spots: at.iter().map(|at| (*at, Anchor::Left)).collect(),
        }
    }

    #[test]
    fn what_has_no_room_is_left_out_and_counted() {
        let mut layout = Layout::new(100, 40);
        assert!(layout.place(caption("12.5 mm", &[[2.0, 10.0]])));
        // Over the first; over the border; free.
        assert!(layout.place(caption("+1 mm", &[[20.0, 12.0], [70.0, 30.0], [2.0, 30.0]])));
        assert_eq!(layout.placed[1].at, [2.0, 30.0]);
        layout.keep_free([50.0, 20.0], [100.0, 40.0]);
        assert!(!layout.place(caption("+1 mm", &[[50.0, 30.0]])));
        assert_eq!((layout.placed.len(), layout.left_out), (2, 1));
    }

    #[test]
    fn lines_break_between_words() {
        let lines = wrapped("NO POSE: emitters do not hold the tip, image 320 ms old", 18.0, 300.0);
        assert_eq!(
            lines.join(" "),
            "NO POSE: emitters do not hold the tip, image 320 ms old"
        );
        assert!(
            lines.len() > 1 && lines.iter().all(|line| text_width(line, 18.0) <= 300.0),
            "{lines:?}"
        );
        assert_eq!(wrapped("", 18.0, 300.0), Vec::<String>::new());
        // `3.2` on one line and `s old` on the next was read as neither.
        let kept = wrapped("lost, image\u{a0}3.2\u{a0}s\u{a0}old", 18.0, 170.0);
        assert_eq!(kept, ["lost,", "image\u{a0}3.2\u{a0}s\u{a0}old"]);
    }
}
