//! All clients: who is there, what was said last, and what is counted.

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::letter::{Claim, Letter};
use crate::mailbox::{Mailbox, Slot};

/// At most so many clients at a time.
pub(crate) const MOST_CLIENTS: usize = 16;
/// Lines about clients on stderr, at most; further ones are counted.
const MOST_LINES: u64 = 20;

/// Words that a client who comes late is told too.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kept {
    /// How the tool is.
    State,
    /// How far the run has come.
    Workflow,
    /// The targets.
    Points,
}

/// What is counted over the whole run of the process.
#[derive(Debug, Default)]
pub(crate) struct Counted {
    /// Messages sent.
    pub(crate) sent: AtomicU64,
    /// Clients that were closed as they took nothing.
    pub(crate) slow: AtomicU64,
    /// Clients that were closed for what they sent.
    pub(crate) hostile: AtomicU64,
    /// Connections beyond the sixteenth.
    pub(crate) crowded: AtomicU64,
    /// Messages that gave way to newer ones, of clients that have gone.
    pub(crate) overtaken: AtomicU64,
    lines: AtomicU64,
}

#[derive(Debug, Default)]
struct Board {
    newest: Vec<Option<Arc<Letter>>>,
    kept: [Option<Arc<Letter>>; 3],
    /// How the tool is, in words.
    state: String,
    /// Why the examination may not be sent.
    withheld: Option<&'static str>,
}

/// Shared by all threads.
#[derive(Debug)]
pub(crate) struct Hall {
    clients: Mutex<Vec<Arc<Mailbox>>>,
    board: Mutex<Board>,
    /// Those that were accepted, also where their thread has not begun.
    present: AtomicUsize,
    /// Counters.
    pub(crate) counted: Counted,
    /// Whether there is a pose.
    pub(crate) claim: Claim,
    /// All has been said: the run ends.
    is_over: AtomicBool,
    views: usize,
    pushes_images: bool,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Hall {
    /// Empty, for a scene of so many views; `pushes_images` says whether images are sent to who does not ask.
    pub(crate) fn new(views: usize, pushes_images: bool) -> Self {
        Self {
            clients: Mutex::default(),
            board: Mutex::new(Board {
                newest: vec![None; Slot::count(views)],
                ..Board::default()
            }),
            present: AtomicUsize::new(0),
            counted: Counted::default(),
            claim: Claim::default(),
            is_over: AtomicBool::new(false),
            views,
            pushes_images,
        }
    }

    /// How many clients there are.
    pub(crate) fn present(&self) -> usize {
        self.present.load(Ordering::Relaxed)
    }

    /// A place for one more client; `None` where all are taken. It is left when what is given is dropped.
    pub(crate) fn enter(self: &Arc<Self>) -> Option<std::io::Result<Place>> {
        let taken = self.present.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |n| {
            (n < MOST_CLIENTS).then_some(n + 1)
        });
        taken.ok()?;
        let mailbox = match Mailbox::new(self.views, self.pushes_images) {
            Ok(mailbox) => Arc::new(mailbox),
            Err(error) => {
                self.present.fetch_sub(1, Ordering::Relaxed);
                return Some(Err(error));
            }
        };
        // Under both locks, so that nothing is told in between that this client would miss.
        let mut clients = lock(&self.clients);
        let board = lock(&self.board);
        for slot in Slot::PUSHED {
            if let Some(Some(letter)) = board.newest.get(slot.place()) {
                mailbox.put(slot, letter);
            }
        }
        board.kept.iter().flatten().for_each(|letter| mailbox.say(letter));
        clients.push(Arc::clone(&mailbox));
        Some(Ok(Place {
            hall: Arc::clone(self),
            mailbox,
        }))
    }

    /// Tells every client the newest of a device.
    pub(crate) fn put(&self, slot: Slot, letter: Letter) {
        let letter = Arc::new(letter);
        let clients = lock(&self.clients);
        if let Some(place) = lock(&self.board).newest.get_mut(slot.place()) {
            *place = Some(Arc::clone(&letter));
        }
        for client in clients.iter() {
            client.put(slot, &letter);
        }
    }

    /// Tells every client the newest of a device and wakes its thread. `at_once`, the time on CLOCK_MONOTONIC: those are not woken whose
    /// system takes it here and now. With a real-time priority that saves a wake-up; without one a thread that does both its work and its
    /// clients' is soon behind its share of the processor, and its slowest poses come later (docs/slicer.md has the figures).
    pub(crate) fn post(&self, slot: Slot, letter: Letter, at_once: Option<i64>) {
        let letter = Arc::new(letter);
        let clients = lock(&self.clients);
        if let Some(place) = lock(&self.board).newest.get_mut(slot.place()) {
            *place = Some(Arc::clone(&letter));
        }
        for client in clients.iter() {
            match at_once {
                Some(now_ns) => client.post(slot, &letter, now_ns, &self.counted.sent),
                None => client.put(slot, &letter),
            }
        }
        if at_once.is_none() {
            clients.iter().for_each(|client| client.ring());
        }
    }

    /// Puts all that holds for everybody into one client's box once more. Under the lock of those who tell: what is newer comes behind.
    pub(crate) fn tell_again(&self, mailbox: &Mailbox) {
        let _clients = lock(&self.clients);
        let board = lock(&self.board);
        for slot in Slot::PUSHED {
            if let Some(Some(letter)) = board.newest.get(slot.place()) {
                mailbox.put(slot, letter);
            }
        }
    }

    /// Says words to every client, and to those who come later where they are kept.
    pub(crate) fn say(&self, kept: Option<Kept>, letter: Letter) {
        let letter = Arc::new(letter);
        let clients = lock(&self.clients);
        if let Some(kept) = kept {
            lock(&self.board).kept[kept as usize] = Some(Arc::clone(&letter));
        }
        for client in clients.iter() {
            client.say(&letter);
        }
    }

    /// Wakes every client's thread.
    pub(crate) fn ring(&self) {
        lock(&self.clients).iter().for_each(|client| client.ring());
    }

    /// Wakes those that have begun a stream of tools.
    pub(crate) fn ring_streams(&self) {
        let clients = lock(&self.clients);
        let streaming = clients
            .iter()
            .filter(|client| client.streams_tools.load(Ordering::Relaxed));
        streaming.for_each(|client| client.ring());
    }

    /// The newest of a device.
    pub(crate) fn newest(&self, slot: Slot) -> Option<Arc<Letter>> {
        lock(&self.board).newest.get(slot.place())?.clone()
    }

    /// What was said last.
    pub(crate) fn kept(&self, kept: Kept) -> Option<Arc<Letter>> {
        lock(&self.board).kept[kept as usize].clone()
    }

    /// Messages that gave way to newer ones, of all clients that there ever were.
    pub(crate) fn overtaken(&self) -> u64 {
        let gone = self.counted.overtaken.load(Ordering::Relaxed);
        let there = lock(&self.clients).iter().map(|client| client.overtaken()).sum::<u64>();
        gone.saturating_add(there)
    }

    /// How the tool is, in words.
    pub(crate) fn state(&self) -> String {
        lock(&self.board).state.clone()
    }

    /// The tool is so from now on.
    pub(crate) fn set_state(&self, words: &str) {
        words.clone_into(&mut lock(&self.board).state);
    }

    /// Whether the examination may be sent from now on, and why not.
    pub(crate) fn withhold(&self, why: Option<&'static str>) {
        lock(&self.board).withheld = why;
    }

    /// Why the examination may not be sent.
    pub(crate) fn withheld(&self) -> Option<&'static str> {
        lock(&self.board).withheld
    }

    /// The last has been said: clients are sent what waits for them, and no more.
    pub(crate) fn end(&self) {
        self.is_over.store(true, Ordering::Release);
        self.ring();
    }

    /// Whether nothing more will be said.
    pub(crate) fn is_over(&self) -> bool {
        self.is_over.load(Ordering::Acquire)
    }

    /// Every client that is there.
    pub(crate) fn all(&self) -> Vec<Arc<Mailbox>> {
        lock(&self.clients).clone()
    }

    /// A line on stderr about a client. What a flood of them has to say is cut off, and counted elsewhere.
    pub(crate) fn tell(&self, words: &str) {
        match self.counted.lines.fetch_add(1, Ordering::Relaxed) {
            before if before < MOST_LINES => bus::stderr_line!("gateway-proc: {words}"),
            MOST_LINES => bus::stderr_line!("gateway-proc: what more is to be said of clients is only counted"),
            _ => {}
        }
    }
}

/// A client's place.
#[derive(Debug)]
pub(crate) struct Place {
    /// All others.
    pub(crate) hall: Arc<Hall>,
    /// What waits for this one.
    pub(crate) mailbox: Arc<Mailbox>,
}

impl Drop for Place {
    fn drop(&mut self) {
        lock(&self.hall.clients).retain(|other| !Arc::ptr_eq(other, &self.mailbox));
        let overtaken = self.mailbox.overtaken();
        self.hall.counted.overtaken.fetch_add(overtaken, Ordering::Relaxed);
        self.hall.present.fetch_sub(1, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tell::{refusal, string};
    use igtl::Stamp;

    #[test]
    fn sixteen_clients_have_a_place_and_the_next_one_has_when_one_leaves() {
        let hall = Arc::new(Hall::new(1, false));
        let mut places: Vec<Place> = (0..MOST_CLIENTS).map(|_| hall.enter().unwrap().unwrap()).collect();
        assert!(hall.enter().is_none() && hall.present() == 16);
        places.pop();
        assert!(hall.present() == 15 && hall.all().len() == 15);
        assert!(hall.enter().is_some());
    }

    #[test]
    fn who_comes_late_is_told_what_holds() {
        let hall = Arc::new(Hall::new(1, true));
        hall.put(Slot::Tool, refusal(1, "the old one"));
        hall.put(Slot::Tool, refusal(1, "the newest"));
        hall.put(Slot::Tdata, refusal(1, "asked for only"));
        hall.say(Some(Kept::State), string("State", "LIVE", Stamp::NONE));
        hall.say(None, string("Alarm", "over", Stamp::NONE));
        let late = hall.enter().unwrap().unwrap();
        let tool = late.mailbox.take(Slot::Tool).unwrap();
        assert!(Arc::ptr_eq(&tool, &hall.newest(Slot::Tool).unwrap()));
        assert!(late.mailbox.take(Slot::Tdata).is_none());
        assert!(late.mailbox.hear().is_some() && late.mailbox.hear().is_none());
        assert!(late.mailbox.wished(0).stream);
    }
}
