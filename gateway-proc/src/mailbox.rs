//! What waits for one client: of poses, statuses and images the newest of each, of words a few. Nobody who puts something in ever waits.

use std::collections::VecDeque;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::atomic::{AtomicBool, AtomicU16, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use igtl::Version;
use rustix::event::{EventfdFlags, eventfd};

use crate::letter::Letter;
use crate::outlet::{Outlet, Went};

/// Words that wait for a client at most; the oldest give way.
const MOST_WORDS: usize = 64;

/// One device whose newest message is what a client gets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Slot {
    /// The tool in the patient.
    Tool,
    /// The tool's marker in the localizer's frame.
    ToolMarker,
    /// The marker on the patient.
    ReferenceMarker,
    /// The heart-beat.
    Status,
    /// All tools of a moment; sent to who asked for the stream.
    Tdata,
    /// The examination, for who asked.
    Volume,
    /// The image of this view.
    View(usize),
}

impl Slot {
    /// Those that are sent to everybody, in turn.
    pub(crate) const PUSHED: [Self; 4] = [Self::Tool, Self::ToolMarker, Self::ReferenceMarker, Self::Status];
    const FIXED: usize = 6;

    pub(crate) const fn place(self) -> usize {
        match self {
            Self::Tool => 0,
            Self::ToolMarker => 1,
            Self::ReferenceMarker => 2,
            Self::Status => 3,
            Self::Tdata => 4,
            Self::Volume => 5,
            Self::View(view) => Self::FIXED + view,
        }
    }

    /// How many there are in a scene of so many views.
    pub(crate) const fn count(views: usize) -> usize {
        Self::FIXED + views
    }
}

/// Which images a client wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Wish {
    /// As a stream.
    pub(crate) stream: bool,
    /// Once.
    pub(crate) once: bool,
    /// Whatever there is to be seen, and be it the same as before: a stream has just begun, or what was sent last had grown old on its way.
    pub(crate) owed: bool,
}

impl Wish {
    /// Whether anything is wanted.
    pub(crate) fn is_any(self) -> bool {
        self.stream || self.once || self.owed
    }

    /// Whether an image is wanted that was sent before.
    pub(crate) fn is_at_once(self) -> bool {
        self.once || self.owed
    }

    /// Something was sent.
    pub(crate) fn is_met(&mut self) {
        (self.once, self.owed) = (false, false);
    }
}

#[derive(Debug)]
struct Inner {
    slots: Vec<Option<Arc<Letter>>>,
    words: VecDeque<Arc<Letter>>,
    wishes: Vec<Wish>,
    overtaken: u64,
}

/// The box of one client, and what wakes its thread.
#[derive(Debug)]
pub(crate) struct Mailbox {
    inner: Mutex<Inner>,
    bell: OwnedFd,
    /// Where the client's thread sends; `None` before it has begun.
    outlet: OnceLock<Outlet>,
    /// It has begun a stream of tools.
    pub(crate) streams_tools: AtomicBool,
    /// The version in which it wants the volume; 0 where it does not.
    volume: AtomicU16,
}

impl Mailbox {
    /// Empty, for a scene of so many views; `streams` says whether all of them are wanted from the start.
    ///
    /// # Errors
    /// Where the system has no more descriptors.
    pub(crate) fn new(views: usize, streams: bool) -> std::io::Result<Self> {
        let wish = Wish {
            stream: streams,
            once: false,
            owed: streams,
        };
        Ok(Self {
            inner: Mutex::new(Inner {
                slots: vec![None; Slot::count(views)],
                words: VecDeque::new(),
                wishes: vec![wish; views],
                overtaken: 0,
            }),
            bell: eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?,
            outlet: OnceLock::new(),
            streams_tools: AtomicBool::new(false),
            volume: AtomicU16::new(0),
        })
    }

    fn inner(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts the newest message of a device in; one that waits gives way.
    pub(crate) fn put(&self, slot: Slot, letter: &Arc<Letter>) {
        let mut inner = self.inner();
        if let Some(place) = inner.slots.get_mut(slot.place()) {
            let before = place.replace(Arc::clone(letter));
            // The stream of tools waits in every box, also of who never asks for it.
            inner.overtaken += u64::from(before.is_some() && slot != Slot::Tdata);
        }
    }

    /// The way out to the client, from here on open to all.
    pub(crate) fn open(&self, outlet: Outlet) -> &Outlet {
        self.outlet.get_or_init(|| outlet)
    }

    #[cfg(test)]
    pub(crate) fn outlet(&self) -> Option<&Outlet> {
        self.outlet.get()
    }

    /// Sends the newest message of a device at once where nothing is on its way to this client, and puts it in and wakes the client's
    /// thread where something is. `sent` counts.
    pub(crate) fn post(&self, slot: Slot, letter: &Arc<Letter>, now_ns: i64, sent: &AtomicU64) {
        // One that waits still is older, and must not follow this one.
        let give_way = || {
            let before = self.take(slot).is_some();
            self.inner().overtaken += u64::from(before);
        };
        let went = self
            .outlet
            .get()
            .map_or(Went::No, |outlet| outlet.send_now(letter, now_ns, sent, give_way));
        match went {
            Went::Done => {}
            Went::Begun => self.ring(),
            Went::No => {
                self.put(slot, letter);
                self.ring();
            }
        }
    }

    /// Adds words; beyond what there is room for the oldest give way.
    pub(crate) fn say(&self, letter: &Arc<Letter>) {
        let mut inner = self.inner();
        if inner.words.len() == MOST_WORDS {
            inner.words.pop_front();
            inner.overtaken += 1;
        }
        inner.words.push_back(Arc::clone(letter));
    }

    /// Takes the message of a device.
    pub(crate) fn take(&self, slot: Slot) -> Option<Arc<Letter>> {
        self.inner().slots.get_mut(slot.place())?.take()
    }

    /// Whether a message of this device waits.
    pub(crate) fn has(&self, slot: Slot) -> bool {
        self.inner().slots.get(slot.place()).is_some_and(Option::is_some)
    }

    /// Takes the oldest words.
    pub(crate) fn hear(&self) -> Option<Arc<Letter>> {
        self.inner().words.pop_front()
    }

    /// Wakes the client's thread.
    pub(crate) fn ring(&self) {
        // It can only be full, and then the thread is woken all the same.
        let _ = rustix::io::write(&self.bell, &1_u64.to_ne_bytes());
    }

    /// The thread is awake.
    pub(crate) fn heard(&self) {
        let _ = rustix::io::read(&self.bell, &mut [0; 8]);
    }

    /// What becomes readable when the thread is to wake.
    pub(crate) fn bell(&self) -> BorrowedFd<'_> {
        self.bell.as_fd()
    }

    /// Changes which images are wanted: those of one view, or of all.
    pub(crate) fn wish(&self, view: Option<usize>, change: impl Fn(&mut Wish)) {
        for (at, wish) in self.inner().wishes.iter_mut().enumerate() {
            if view.is_none_or(|view| view == at) {
                change(wish);
            }
        }
    }

    /// What is wanted of a view.
    pub(crate) fn wished(&self, view: usize) -> Wish {
        self.inner().wishes.get(view).copied().unwrap_or_default()
    }

    /// Whether the images of this view, or of any, are sent as a stream.
    pub(crate) fn streams(&self, view: Option<usize>) -> bool {
        let inner = self.inner();
        let mut wishes = inner.wishes.iter().enumerate();
        wishes.any(|(at, wish)| wish.stream && view.is_none_or(|view| view == at))
    }

    /// Messages that were not sent, as newer ones came.
    pub(crate) fn overtaken(&self) -> u64 {
        self.inner().overtaken
    }

    /// The volume is wanted in this version.
    pub(crate) fn wish_volume(&self, version: Version) {
        self.volume.store(version.number(), Ordering::Relaxed);
    }

    /// In which version the volume is wanted, which it then is no more.
    pub(crate) fn take_volume_wish(&self) -> Option<Version> {
        match self.volume.swap(0, Ordering::Relaxed) {
            0 => None,
            1 => Some(Version::One),
            _ => Some(Version::Two),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tell::{refusal, string};
    use igtl::Stamp;

    fn letter() -> Arc<Letter> {
        Arc::new(refusal(1, "x"))
    }

    #[test]
    fn the_newest_of_a_device_waits_and_nothing_else_of_it() {
        let mailbox = Mailbox::new(2, false).unwrap();
        let all: Vec<_> = (0..1000).map(|_| letter()).collect();
        all.iter().for_each(|letter| mailbox.put(Slot::Tool, letter));
        assert!(Arc::ptr_eq(&mailbox.take(Slot::Tool).unwrap(), all.last().unwrap()));
        assert!(mailbox.take(Slot::Tool).is_none() && mailbox.take(Slot::View(1)).is_none());
        assert_eq!(mailbox.overtaken(), 999);
        // A slot that the scene has no view for takes nothing.
        mailbox.put(Slot::View(2), &letter());
        assert!(mailbox.take(Slot::View(2)).is_none());
    }

    #[test]
    fn words_that_nobody_takes_are_bounded_and_the_newest_stay() {
        let mailbox = Mailbox::new(0, false).unwrap();
        let all: Vec<_> = (0..100)
            .map(|n| Arc::new(string("State", &n.to_string(), Stamp::NONE)))
            .collect();
        all.iter().for_each(|letter| mailbox.say(letter));
        assert!(Arc::ptr_eq(&mailbox.hear().unwrap(), &all[36]));
        let rest = std::iter::from_fn(|| mailbox.hear()).count();
        assert_eq!((rest, mailbox.overtaken()), (63, 36));
    }

    #[test]
    fn a_stream_that_begins_is_owed_an_image_until_one_is_sent() {
        let mailbox = Mailbox::new(1, true).unwrap();
        assert!(mailbox.wished(0).is_at_once());
        mailbox.wish(Some(0), Wish::is_met);
        let wish = mailbox.wished(0);
        assert!(wish.is_any() && !wish.is_at_once());
        mailbox.wish(None, |wish| *wish = Wish::default());
        assert!(!mailbox.wished(0).is_any());
    }

    #[test]
    fn images_are_wanted_one_by_one_or_all() {
        let mailbox = Mailbox::new(2, false).unwrap();
        mailbox.wish(Some(1), |wish| wish.once = true);
        assert_eq!((mailbox.wished(0).once, mailbox.wished(1).once), (false, true));
        mailbox.wish(None, |wish| wish.stream = true);
        assert!(mailbox.wished(0).stream && mailbox.wished(1).stream && mailbox.wished(1).once);
        assert_eq!(mailbox.wished(7), Wish::default());
    }
}
