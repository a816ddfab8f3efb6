//! What a person marked, and the pictures nearest to it in time.

use std::collections::BTreeMap;
use std::rc::Rc;

use prost::Message as _;
use serde::Serialize;

use crate::wire::proto::CompressedImage;

/// More marks are counted and not listed.
const MOST: usize = 500;
/// More marks have no pictures.
const MOST_PICTURED: usize = 40;
/// More views have none.
const MOST_VIEWS: usize = 8;
/// A small image of ours has at most 256 x 256 pixels of 4 bytes, and a little around it.
const MOST_BYTES: usize = 288 << 10;
/// A picture has no longer side, pixels: a small file may unpack to a large image.
const MOST_PIXELS: u32 = 1024;
/// A picture that was shown at another time shows something else.
const NEAR_NS: u64 = 10_000_000_000;
/// The last images of a view that are kept: the log may be written a little later than what it tells of.
const KEPT: usize = 4;

/// A mark.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Mark {
    /// ns since the run's epoch.
    pub(super) t_ns: i64,
    /// What she said.
    pub(super) words: String,
    /// The nearest picture of each view.
    pub(super) pictures: Vec<Near>,
}

/// A picture near a mark.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Near {
    /// Of which view.
    pub(super) view: String,
    /// How much later than the mark it was shown, ns; earlier below 0.
    pub(super) later_ns: i64,
    /// The PNG.
    #[serde(skip)]
    pub(super) png: Rc<[u8]>,
}

/// A PNG and when it was shown, ns.
type Shown = (i64, Rc<[u8]>);

/// All of them.
#[derive(Debug, Default)]
pub(super) struct Marks {
    /// In the order of the file.
    pub(super) all: Vec<Mark>,
    /// How many there were.
    pub(super) count: u64,
    /// How many pictures the recording holds.
    pub(super) pictures: u64,
    /// How many of them are none, or too large.
    pub(super) refused: u64,
    /// By view, the oldest first.
    recent: BTreeMap<String, Vec<Shown>>,
}

impl Marks {
    /// Somebody marked this moment.
    pub(super) fn mark(&mut self, t_ns: i64, words: &str) {
        self.count += 1;
        if self.all.len() == MOST {
            return;
        }
        let mut mark = Mark {
            t_ns,
            words: words.to_owned(),
            pictures: Vec::new(),
        };
        if self.all.len() < MOST_PICTURED {
            for (view, images) in &self.recent {
                images
                    .iter()
                    .for_each(|(shown_ns, png)| mark.offer(view, *shown_ns, png));
            }
        }
        self.all.push(mark);
    }

    /// A picture of a view, shown at `t_ns`.
    pub(super) fn picture(&mut self, t_ns: i64, view: &str, message: &[u8]) {
        self.pictures += 1;
        let image = CompressedImage::decode(message);
        let Some(png) = image.ok().filter(is_usable).map(|image| Rc::from(image.data)) else {
            self.refused += 1;
            return;
        };
        for mark in self.all.iter_mut().take(MOST_PICTURED) {
            mark.offer(view, t_ns, &png);
        }
        if self.recent.len() == MOST_VIEWS && !self.recent.contains_key(view) {
            return;
        }
        let images = self.recent.entry(view.to_owned()).or_default();
        if images.len() == KEPT {
            images.remove(0);
        }
        images.push((t_ns, png));
    }

    /// Why a mark has no picture, in words.
    pub(super) fn why_none(&self, place: usize) -> String {
        match self.pictures {
            0 => "no picture: the recording holds none".to_owned(),
            _ if place >= MOST_PICTURED => format!("no picture: only the first {MOST_PICTURED} marks have one"),
            _ => "no picture within 10 s".to_owned(),
        }
    }
}

impl Mark {
    /// Takes a picture that is nearer than the one before.
    fn offer(&mut self, view: &str, shown_ns: i64, png: &Rc<[u8]>) {
        let later_ns = shown_ns.saturating_sub(self.t_ns);
        if later_ns.unsigned_abs() > NEAR_NS {
            return;
        }
        let png = png.clone();
        match self.pictures.iter().position(|near| near.view == view) {
            Some(place) => {
                let near = &mut self.pictures[place];
                if later_ns.unsigned_abs() < near.later_ns.unsigned_abs() {
                    (near.later_ns, near.png) = (later_ns, png);
                }
            }
            None if self.pictures.len() < MOST_VIEWS => self.pictures.push(Near {
                view: view.to_owned(),
                later_ns,
                png,
            }),
            None => {}
        }
    }
}

/// A PNG of sizes that do no harm to who shows it; its head says them.
fn is_usable(image: &CompressedImage) -> bool {
    let side = |at: usize| {
        let bytes = image.data.get(at..at + 4)?;
        Some(u32::from_be_bytes(bytes.try_into().ok()?))
    };
    let fits = |side: Option<u32>| side.is_some_and(|side| (1..=MOST_PIXELS).contains(&side));
    let head = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR";
    image.format == "png"
        && image.data.len() <= MOST_BYTES
        && image.data.starts_with(head)
        && fits(side(16))
        && fits(side(20))
}

#[cfg(test)]
mod tests {
    use super::*;
    use picture::{Canvas, encode_png};

    fn image(shade: u8, side: u32) -> Vec<u8> {
        let mut canvas = Canvas::new(side, side);
        canvas.rgba_mut().fill(shade);
        let png = encode_png(&canvas, &[]).unwrap();
        CompressedImage::png(0, "axial", png).encode_to_vec()
    }

    const S: i64 = 1_000_000_000;

    #[test]
    fn the_nearest_picture_counts_whether_it_came_before_or_behind() {
        let mut marks = Marks::default();
        for (t, shade) in [(1, 1), (2, 2), (3, 3)] {
            marks.picture(t * S, "axial", &image(shade, 4));
        }
        marks.mark(2 * S + S / 4, "between");
        marks.mark(4 * S, "before the next");
        marks.mark(40 * S, "far away");
        marks.picture(4 * S + S / 4, "axial", &image(4, 4));
        let near = |place: usize| {
            marks.all[place]
                .pictures
                .iter()
                .map(|near| near.later_ns)
                .collect::<Vec<_>>()
        };
        assert_eq!((near(0), near(1), near(2)), (vec![-S / 4], vec![S / 4], vec![]));
        assert!(marks.why_none(2).contains("within 10 s"));
    }

    #[test]
    fn what_is_no_small_png_is_no_picture() {
        let mut marks = Marks::default();
        marks.mark(0, "here");
        let mut huge = image(1, 4);
        let at = huge.windows(4).position(|four| four == b"IHDR").unwrap() + 4;
        huge[at] = 0x7f;
        let other = CompressedImage {
            format: "jpeg".to_owned(),
            ..CompressedImage::decode(image(1, 4).as_slice()).unwrap()
        };
        let script = CompressedImage::png(0, "axial", b"<svg onload=alert(1)>".to_vec());
        for bad in [
            huge,
            other.encode_to_vec(),
            script.encode_to_vec(),
            b"\xff\xff".to_vec(),
        ] {
            marks.picture(0, "axial", &bad);
        }
        assert_eq!((marks.pictures, marks.refused, marks.all[0].pictures.len()), (4, 4, 0));
    }

    #[test]
    fn what_is_kept_is_bounded() {
        let mut marks = Marks::default();
        for i in 0..2000_i64 {
            marks.mark(i, "again");
            marks.picture(i, &format!("view {}", i % 100), &image(1, 4));
        }
        assert_eq!((marks.all.len(), marks.count), (MOST, 2000));
        assert!(marks.all.iter().all(|mark| mark.pictures.len() <= MOST_VIEWS));
        assert!(marks.recent.values().all(|images| images.len() <= KEPT) && marks.recent.len() <= MOST_VIEWS);
    }
}
