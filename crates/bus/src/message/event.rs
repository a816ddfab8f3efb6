//! What a process did or was asked to do, in words, for whoever reads the recording later.

use iceoryx2::prelude::ZeroCopySend;

use super::{field_text, text_field};

/// One line of a run's log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ZeroCopySend, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
#[type_name("trocar/Event/1")]
pub struct Event {
    /// Counts the events of a process from 0.
    pub seq: u64,
    /// When, ns on the run's clock.
    pub t_ns: i64,
    /// Code of a [`Level`].
    pub level: u32,
    /// Room for alignment; zero.
    pub reserved: u32,
    /// What happened, in words.
    pub text: [u8; Event::TEXT],
}

const _: () = assert!(size_of::<Event>() == 24 + Event::TEXT && align_of::<Event>() == 8);

/// How much an event matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// As it should be.
    Info,
    /// Something that the run goes on with.
    Warning,
    /// Something that failed.
    Error,
}

impl Level {
    const fn code(self) -> u32 {
        match self {
            Self::Info => 0,
            Self::Warning => 1,
            Self::Error => 2,
        }
    }
}

impl Event {
    /// Most bytes of its words.
    pub const TEXT: usize = 232;

    /// An event in words; what does not fit is cut off.
    pub fn new(seq: u64, t_ns: i64, level: Level, text: &str) -> Self {
        Self {
            seq,
            t_ns,
            level: level.code(),
            reserved: 0,
            text: text_field(text),
        }
    }

    /// How much it matters; an unknown code counts as an error.
    pub fn level(&self) -> Level {
        match self.level {
            0 => Level::Info,
            1 => Level::Warning,
            _ => Level::Error,
        }
    }

    /// What happened, in words.
    pub fn words(&self) -> String {
        field_text(&self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_and_levels_come_back() {
        for level in [Level::Info, Level::Warning, Level::Error] {
            let event = Event::new(3, -5, level, "stop: asked for");
            assert_eq!((event.level(), event.words().as_str()), (level, "stop: asked for"));
        }
        let long = Event::new(0, 0, Level::Info, &"é".repeat(Event::TEXT));
        assert_eq!(long.words().len(), Event::TEXT);
        assert_eq!(Event { level: 77, ..long }.level(), Level::Error);
    }
}
