//! What the link's threads hand over to the process, which alone may touch the bus.

use std::collections::VecDeque;
use std::io::{self, Read, Write};
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use bus::clock::far::Exchange;
use bus::topic::TISSUE;
use zenoh::query::Reply;
use zenoh::sample::Sample;

use crate::protocol::{Channel, Envelope};
use crate::session::Opened;

/// Messages that wait; where more come, the oldest give way, as they would on the bus.
const MOST: usize = 4096;
/// States of tissue that wait, which are long.
const MOST_STATES: usize = TISSUE.buffer;

/// A question for the clock, and its answer.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Asked {
    /// When it left and came.
    pub(crate) exchange: Exchange,
    /// Whose clock it is.
    pub(crate) run: u64,
    pub(crate) sender: u64,
    /// For how long this machine had slept when it left, ns.
    pub(crate) slept_ns: i64,
}

/// What came over the link.
pub(super) enum Incoming {
    /// A session that was dialled, or why there is none.
    Opened(Result<Box<Opened>, String>),
    /// Why the sender does not answer, as far as a look tells.
    Looked(Option<String>),
    /// What the sender says of its run.
    Facts(Result<Vec<u8>, String>),
    /// The sender's clock.
    Clock(Asked),
    /// A piece of the voxels.
    Piece(u32, Result<Vec<u8>, String>),
    /// A piece of the organs of this id, as it came.
    Mesh([u8; 32], u32, Result<Vec<u8>, String>),
    /// A message, of as many bytes as its channel allows.
    Message(Channel, Envelope, Vec<u8>),
    /// Something that is none of these, in words.
    Odd(String),
}

impl Incoming {
    pub(super) fn is_clock(&self) -> bool {
        matches!(self, Self::Clock(_))
    }
}

/// The queue, and what wakes who empties it.
#[derive(Clone)]
pub(super) struct Inbox(Arc<Inner>);

struct Inner {
    queue: Mutex<VecDeque<Incoming>>,
    wake: UnixStream,
}

impl Inbox {
    /// The queue, and the end that becomes readable when something came.
    pub(super) fn open() -> io::Result<(Self, UnixStream)> {
        let (wake, woken) = UnixStream::pair()?;
        wake.set_nonblocking(true)?;
        woken.set_nonblocking(true)?;
        let queue = Mutex::new(VecDeque::new());
        Ok((Self(Arc::new(Inner { queue, wake })), woken))
    }

    pub(super) fn put(&self, incoming: Incoming) {
        let mut queue = self.0.queue.lock().unwrap_or_else(PoisonError::into_inner);
        let is_state = |one: &Incoming| matches!(one, Incoming::Message(Channel::Tissue, ..));
        // What answers a question is bounded by the questions.
        let may_go = |one: &Incoming| matches!(one, Incoming::Message(..) | Incoming::Odd(_));
        let oldest = if is_state(&incoming) && queue.iter().filter(|one| is_state(one)).count() >= MOST_STATES {
            queue.iter().position(is_state)
        } else if queue.len() >= MOST {
            queue.iter().position(may_go)
        } else {
            None
        };
        oldest.map(|place| queue.remove(place));
        queue.push_back(incoming);
        drop(queue);
        // A full pipe wakes as well as one more byte.
        let _ = (&self.0.wake).write(&[1]);
    }

    /// A message of a channel.
    pub(super) fn sample(&self, channel: Channel, sample: &Sample) {
        let bytes = sample.payload().to_bytes();
        self.put(match Envelope::open(&bytes, channel.key(), channel.allowed()) {
            Ok((envelope, body)) => Incoming::Message(channel, envelope, body.to_vec()),
            Err(error) => Incoming::Odd(error.to_string()),
        });
    }

    /// All that came since the last call.
    pub(super) fn take(&self) -> VecDeque<Incoming> {
        std::mem::take(&mut *self.0.queue.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// What comes of a question: its answer, or that there was none. A question that nobody is there for yet ends without a word.
pub(super) struct Promise {
    to: Inbox,
    is_kept: AtomicBool,
    none: Mutex<Option<Incoming>>,
}

impl Promise {
    /// `none` is put into the inbox where the question ends without an answer.
    pub(super) fn of(to: &Inbox, none: Incoming) -> Self {
        Self {
            to: to.clone(),
            is_kept: AtomicBool::new(false),
            none: Mutex::new(Some(none)),
        }
    }

    /// The answer.
    pub(super) fn keep(&self, answer: Incoming) {
        // One question has one answer, whatever else a sender says.
        if !self.is_kept.swap(true, Ordering::Relaxed) {
            self.to.put(answer);
        }
    }
}

impl Drop for Promise {
    fn drop(&mut self) {
        let none = self.none.get_mut().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(none) = none.filter(|_| !self.is_kept.load(Ordering::Relaxed)) {
            self.to.put(none);
        }
    }
}

/// What a reply holds, or the sender's words.
pub(super) fn answer(reply: Reply) -> Result<Vec<u8>, String> {
    match reply.into_result() {
        Ok(sample) => Ok(sample.payload().to_bytes().into_owned()),
        Err(why) => Err(words(&why.payload().to_bytes())),
    }
}

/// A sender's words, as many as a line has room for.
pub(crate) fn words(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    text.chars().filter(|c| !c.is_control()).take(200).collect()
}

/// Empties what wakes, before the queue is looked at.
pub(super) fn drain(mut wakes: &UnixStream) {
    let mut bytes = [0; 256];
    while matches!(wakes.read(&mut bytes), Ok(1..)) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_question_without_an_answer_is_told_of() {
        let (inbox, _wakes) = Inbox::open().unwrap();
        drop(Promise::of(&inbox, Incoming::Facts(Err("none".to_owned()))));
        let kept = Promise::of(&inbox, Incoming::Facts(Err("none".to_owned())));
        kept.keep(Incoming::Facts(Ok(vec![1])));
        drop(kept);
        let all = inbox.take();
        assert!(matches!(&all[0], Incoming::Facts(Err(_))));
        assert!(matches!(&all[1], Incoming::Facts(Ok(bytes)) if bytes == &[1]) && all.len() == 2);
    }

    #[test]
    fn the_oldest_messages_give_way_and_answers_never() {
        let (inbox, wakes) = Inbox::open().unwrap();
        inbox.put(Incoming::Facts(Ok(Vec::new())));
        let envelope = |count| Envelope {
            run: 1,
            sender: 2,
            count,
        };
        for count in 0..MOST as u64 + 5 {
            inbox.put(Incoming::Message(Channel::Pose, envelope(count), Vec::new()));
        }
        let all = inbox.take();
        assert_eq!(all.len(), MOST);
        assert!(matches!(all[0], Incoming::Facts(_)));
        assert!(matches!(&all[1], Incoming::Message(_, Envelope { count: 6, .. }, _)));
        for count in 0..MOST_STATES as u64 + 3 {
            inbox.put(Incoming::Message(Channel::Tissue, envelope(count), Vec::new()));
        }
        let all = inbox.take();
        assert_eq!(all.len(), MOST_STATES);
        assert!(matches!(&all[0], Incoming::Message(_, Envelope { count: 3, .. }, _)));
        drain(&wakes);
        assert_eq!((&wakes).read(&mut [0]).unwrap_err().kind(), io::ErrorKind::WouldBlock);
    }
}
