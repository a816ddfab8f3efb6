//! What a recording holds over its time: for the bar that a replay is steered by.

use iceoryx2::prelude::ZeroCopySend;

use super::{Command, field_text, text_field};

/// Most bytes of a mark's words: as many as a person may say.
const WORDS: usize = Command::TEXT;
/// Stands for what was cut off.
const ELLIPSIS: &str = "\u{2026}";

/// Published by the replayer while it reads the recording, and again when it is through. Moments are ns on the clock of the run that was
/// recorded: states begin when a sample was published, errors stand at its capture. What lies behind the last column was not read yet, or is not there: [`Timeline::is_read`] tells which.
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[repr(C)]
#[type_name("trocar/Timeline/1")]
pub struct Timeline {
    /// Where the first column begins.
    pub from_ns: i64,
    /// How wide each column is.
    pub column_ns: i64,
    /// How much of the file was read.
    pub read_bytes: u64,
    /// And how much there is.
    pub bytes: u64,
    /// How many of `columns` there are.
    pub columns_count: u32,
    /// How many of `marks` there are.
    pub marks_count: u32,
    /// Marks of the recording that have no room here.
    pub marks_left_out: u32,
    /// How many messages or places of the file could not be read.
    pub unreadable: u32,
    /// Why there is no more than this although not all was read; empty where there is no such reason.
    pub why: [u8; Self::WHY],
    /// What was in each column.
    pub columns: [TimelineColumn; Self::COLUMNS],
    /// Moments that a person marked, in the order of the file.
    pub marks: [TimelineMark; Self::MARKS],
}

/// All that fell into a piece of time: no short moment and no peak is left out.
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[repr(C)]
pub struct TimelineColumn {
    /// Bits: [`TimelineColumn::LIVE`] and those after it.
    pub states: u32,
    /// The least 95 % error at the tip that a pose came with, mm; NaN where none has one.
    pub least_mm: f32,
    /// The largest, mm.
    pub most_mm: f32,
}

/// A moment that a person marked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ZeroCopySend)]
#[repr(C)]
pub struct TimelineMark {
    /// When.
    pub t_ns: i64,
    /// Her words.
    pub words: [u8; WORDS],
}

const _: () = assert!(
    size_of::<Timeline>()
        == 48
            + Timeline::WHY
            + Timeline::COLUMNS * size_of::<TimelineColumn>()
            + Timeline::MARKS * size_of::<TimelineMark>()
);
const _: () = assert!(size_of::<TimelineColumn>() == 12 && size_of::<TimelineMark>() == 8 + WORDS);

impl TimelineColumn {
    /// There was a pose, young enough.
    pub const LIVE: u32 = 1;
    /// There was an old one.
    pub const STALE: u32 = 2;
    /// There was none, for a reason or because samples are missing.
    pub const LOST: u32 = 4;
    /// The file is damaged there.
    pub const NOT_READABLE: u32 = 8;
    /// The run was being ended.
    pub const ENDING: u32 = 16;
    /// There was no sample yet.
    pub const NOT_YET: u32 = 32;
    /// A pose came without an error.
    pub const ERROR_UNKNOWN: u32 = 64;

    /// Nothing.
    pub const EMPTY: Self = Self {
        states: 0,
        least_mm: f32::NAN,
        most_mm: f32::NAN,
    };

    /// Whether this was so at any moment of it.
    pub const fn has(&self, state: u32) -> bool {
        self.states & state != 0
    }

    /// A pose came with this 95 % error at the tip, mm.
    pub fn error(&mut self, mm: f64) {
        // Rounded away from what is in between, so that the band holds every pose's error.
        let (mut least, mut most) = (mm as f32, mm as f32);
        if f64::from(least) > mm {
            least = least.next_down();
        }
        if f64::from(most) < mm {
            most = most.next_up();
        }
        // `min` and `max` leave out what is no number.
        (self.least_mm, self.most_mm) = (self.least_mm.min(least), self.most_mm.max(most));
    }
}

impl TimelineMark {
    /// Nothing.
    const EMPTY: Self = Self {
        t_ns: 0,
        words: [0; WORDS],
    };

    /// A mark in one line; words that have no room end in an ellipsis.
    pub fn new(t_ns: i64, words: &str) -> Self {
        let line: String = words.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        let words = match line.len() <= WORDS {
            true => line,
            false => field_text(&text_field::<{ WORDS - ELLIPSIS.len() }>(&line)) + ELLIPSIS,
        };
        Self {
            t_ns,
            words: text_field(&words),
        }
    }

    /// Her words.
    pub fn words(&self) -> String {
        field_text(&self.words)
    }
}

impl Default for Timeline {
    fn default() -> Self {
        Self {
            from_ns: 0,
            column_ns: 1,
            read_bytes: 0,
            bytes: 0,
            columns_count: 0,
            marks_count: 0,
            marks_left_out: 0,
            unreadable: 0,
            why: [0; Self::WHY],
            columns: [TimelineColumn::EMPTY; Self::COLUMNS],
            marks: [TimelineMark::EMPTY; Self::MARKS],
        }
    }
}

impl Timeline {
    /// Most columns.
    pub const COLUMNS: usize = 1024;
    /// Most marks.
    pub const MARKS: usize = 64;
    /// Most bytes of the reason.
    pub const WHY: usize = 136;

    /// The columns there are, each with its first and its last moment.
    pub fn columns(&self) -> impl Iterator<Item = ([i64; 2], &TimelineColumn)> {
        let count = (self.columns_count as usize).min(Self::COLUMNS);
        let at = |k: usize| self.from_ns.saturating_add(self.column_ns.saturating_mul(k as i64));
        let columns = self.columns[..count].iter().enumerate();
        columns.map(move |(k, column)| ([at(k), at(k + 1)], column))
    }

    /// The marks there are.
    pub fn marks(&self) -> &[TimelineMark] {
        &self.marks[..(self.marks_count as usize).min(Self::MARKS)]
    }

    /// Whether all of the file was read.
    pub const fn is_read(&self) -> bool {
        self.bytes > 0 && self.read_bytes >= self.bytes && self.why[0] == 0
    }

    /// Why there is no more than this.
    pub fn why(&self) -> String {
        field_text(&self.why)
    }

    /// The same, of which there will be no more because of this.
    #[must_use]
    pub fn because(self, why: &str) -> Self {
        Self {
            why: text_field(why),
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_band_holds_every_error() {
        let mut column = TimelineColumn::EMPTY;
        assert!(column.least_mm.is_nan() && column.most_mm.is_nan());
        for mm in [0.1, 1.3, 0.7] {
            column.error(mm);
            assert!(f64::from(column.least_mm) <= mm && f64::from(column.most_mm) >= mm);
        }
        assert!((column.least_mm - 0.1).abs() < 1e-7 && (column.most_mm - 1.3).abs() < 1e-6);
    }

    #[test]
    fn words_of_a_mark_are_one_line_and_say_that_they_go_on() {
        let words = |said: &str| TimelineMark::new(0, said).words();
        assert_eq!(words("one\ntwo\u{1b}[1m"), "one two [1m");
        let long = "\u{436}".repeat(60);
        assert!(words(&long).ends_with("\u{436}\u{2026}") && words(&long).len() <= WORDS);
        assert_eq!(words(&"x".repeat(WORDS)), "x".repeat(WORDS));
    }

    #[test]
    fn counts_from_outside_reach_no_further_than_what_is_there() {
        let timeline = Timeline {
            columns_count: u32::MAX,
            marks_count: u32::MAX,
            column_ns: i64::MAX,
            ..Timeline::default()
        };
        assert_eq!(timeline.columns().count(), Timeline::COLUMNS);
        assert_eq!(timeline.marks().len(), Timeline::MARKS);
        assert!(!timeline.is_read() && !timeline.because("x").is_read());
    }
}
