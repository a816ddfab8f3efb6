//! From what was drawn of each organ to what lies at each pixel.

use std::ops::Range;

use super::image::{Organ, Pixel, Warped};
use super::kinds::{FIRST, OUTSIDE, TWICE, VACATED, decode, eight};
use super::raster::{Canvas, FOLDED, PART};
use super::region::Region;
use super::sweep::{alike, sweep};
use super::view::View;

/// What lies at each pixel while an image is drawn.
#[derive(Debug, Clone, Default)]
pub(super) struct Kinds {
    width: usize,
    of: Vec<u8>,
    /// Runs of pixels that are to be seen, and those that no organ covers.
    runs: Vec<Range<usize>>,
    free: Vec<Range<usize>>,
}

impl Kinds {
    pub(super) fn begin(&mut self, [width, height]: [usize; 2]) {
        self.width = width;
        self.of.clear();
        self.of.resize(width * height, OUTSIDE);
    }

    /// Takes over what was drawn of organ `number`, and leaves the canvas empty. Where the canvas is not what stays, `places` are: the
    /// organ's pixels have theirs copied there.
    #[inline(always)]
    pub(super) fn take(
        &mut self,
        canvas: &mut Canvas,
        region: &Region,
        number: u8,
        mut places: Option<&mut [[f32; 3]]>,
    ) {
        let inside = FIRST + number;
        for (row, [low, high]) in canvas.touched.iter().copied().enumerate() {
            if low >= high {
                continue;
            }
            let pixels = row * self.width + low..row * self.width + high;
            let (covered, marks) = (&mut canvas.covered[pixels.clone()], &mut canvas.marks[pixels.clone()]);
            take(
                &mut self.of[pixels.clone()],
                covered,
                marks,
                inside,
                (pixels.start, &mut self.runs),
            );
            if let Some(places) = &mut places {
                for (k, at) in pixels.enumerate() {
                    if (covered[k] != 0 || marks[k] & FOLDED != 0) && marks[k] != OPEN {
                        places[at] = canvas.rest[at];
                    }
                }
            }
            covered.fill(0);
            marks.fill(0);
        }
        let (kinds, rest) = (&mut self.of, &canvas.rest);
        let look = |at: usize| {
            let [x, y, z] = rest[at];
            region.clear([f64::from(x), f64::from(y), f64::from(z)])
        };
        sweep(&mut self.runs, look, |at, end, (is_inside, clear)| {
            let own = &rest[at..end];
            let length = 1 + alike(own, (clear * clear) as f32);
            if is_inside {
                for kind in &mut kinds[at..at + length] {
                    *kind = if *kind == OUTSIDE { inside } else { TWICE };
                }
                if let Some(places) = &mut places {
                    places[at..at + length].copy_from_slice(&own[..length]);
                }
            }
            at + length
        });
    }
}

/// Of a pixel that an organ's surface may leave out, to be seen.
const OPEN: u8 = 0x80;

/// Takes over a row from pixel `first` on; what is to be seen is marked [`OPEN`] and nothing else, its runs are noted, and all else is not.
#[inline(always)]
fn take(
    kinds: &mut [u8],
    covered: &[u8],
    marks: &mut [u8],
    inside: u8,
    (first, runs): (usize, &mut Vec<Range<usize>>),
) {
    let mut note = |at: usize, length: usize| match runs.last_mut() {
        Some(run) if run.end == first + at => run.end += length,
        _ => runs.push(first + at..first + at + length),
    };
    let mut one = |at: usize, kind: &mut u8, covered: u8, marks: &mut u8| {
        let folded = *marks & FOLDED != 0;
        let once = covered == 1 && !folded;
        if once && *marks & PART != 0 {
            *marks = OPEN;
            note(at, 1);
        } else if covered != 0 || folded {
            *kind = if once && *kind == OUTSIDE { inside } else { TWICE };
        }
    };
    let (eights, last) = kinds.as_chunks_mut::<8>();
    let (counts, last_counts) = covered.as_chunks::<8>();
    let (marked, last_marked) = marks.as_chunks_mut::<8>();
    for (k, ((kinds, counts), marks)) in eights.iter_mut().zip(counts).zip(marked).enumerate() {
        let [kind, count, mark] = [*kinds, *counts, *marks].map(u64::from_ne_bytes);
        if mark == 0 && count == eight(1) && kind == eight(OUTSIDE) {
            *kinds = [inside; 8];
        } else if count != 0 || mark != 0 {
            for j in 0..8 {
                one(8 * k + j, &mut kinds[j], counts[j], &mut marks[j]);
            }
        }
    }
    let begin = covered.len() - last.len();
    for (j, kind) in last.iter_mut().enumerate() {
        one(begin + j, kind, last_counts[j], &mut last_marked[j]);
    }
}

impl Warped {
    /// What no organ covers: vacated, or the CT as it is; then all that was found.
    #[inline(always)]
    pub(super) fn finish(&mut self, kinds: &mut Kinds, view: &View, organs: &[Organ<'_>]) {
        let width = kinds.width.max(1);
        self.pixels.resize(kinds.of.len(), Pixel::Outside);
        self.twice = 0;
        kinds.free.clear();
        for (row, own) in kinds.of.chunks_exact(width).enumerate() {
            outside(
                own,
                row,
                view,
                &mut kinds.free,
                &mut self.rest[row * width..(row + 1) * width],
            );
        }
        for organ in organs {
            vacated(kinds, view, &organ.shape.region);
        }
        for (row, own) in kinds.of.chunks_exact(width).enumerate() {
            self.twice += decode(own, &mut self.pixels[row * width..(row + 1) * width]);
        }
    }
}

/// The pixels of a row that no organ covers have their own places.
#[inline(always)]
fn outside(kinds: &[u8], row: usize, view: &View, free: &mut Vec<Range<usize>>, rest: &mut [[f32; 3]]) {
    let mut begin = 0;
    loop {
        begin = next(kinds, begin, true);
        if begin == kinds.len() {
            return;
        }
        let end = next(kinds, begin, false);
        view.fill(begin, row, &mut rest[begin..end]);
        free.push(row * kinds.len() + begin..row * kinds.len() + end);
        begin = end;
    }
}

/// Marks where an organ has been at rest.
#[inline(always)]
fn vacated(kinds: &mut Kinds, view: &View, region: &Region) {
    let (ends, width) = (region.ends(), kinds.width);
    for run in &kinds.free {
        let row = run.start / width;
        let [low, high] = view.within(ends, row);
        let own = run.start.max(row * width + low)..run.end.min(row * width + high);
        if !own.is_empty() {
            kinds.runs.push(own);
        }
    }
    let (of, per_mm) = (&mut kinds.of, 1.0 / view.pixel_mm);
    let look = |at: usize| {
        let row = at as u32 / width as u32;
        let (inside, clear) = region.clear(view.place(at - row as usize * width, row as usize));
        // As many more are the same.
        (inside, (clear * per_mm).min(1e6) as usize)
    };
    sweep(&mut kinds.runs, look, |at, end, (inside, more)| {
        let next = (at + 1 + more).min(end);
        if inside {
            of[at..next].fill(VACATED);
        }
        next
    });
}

/// Where from `begin` on the first pixel lies that is outside, or is not.
#[inline(always)]
fn next(kinds: &[u8], begin: usize, outside: bool) -> usize {
    let kinds = &kinds[begin..];
    let like = |word: u64| {
        // Whether some byte is 0.
        let some = word.wrapping_sub(eight(1)) & !word & eight(0x80) != 0;
        if outside { !some } else { word == 0 }
    };
    let (eights, _) = kinds.as_chunks::<8>();
    let whole = 8 * eights.iter().take_while(|own| like(u64::from_ne_bytes(**own))).count();
    let more = kinds[whole..].iter().take_while(|kind| (**kind == OUTSIDE) != outside);
    begin + whole + more.count()
}
