//! Sleeping until something happens: a message, a request, a missed deadline, a tick.

use std::marker::PhantomData;
use std::ops::ControlFlow;
use std::os::fd::{AsRawFd, BorrowedFd};
use std::time::Duration;

use iceoryx2::port::listener::Listener;
use iceoryx2::prelude::*;
use iceoryx2::waitset::WaitSetRunResult;

use crate::BusError;
use crate::node::Ipc;
use crate::port::{CommandServer, FrameSubscriber, HeadedSubscriber, Message, Subscriber, Value};

/// Something else that becomes readable, as a connection to a display does.
#[derive(Debug)]
struct Descriptor<'a>(FileDescriptor, PhantomData<BorrowedFd<'a>>);

impl FileDescriptorBased for Descriptor<'_> {
    fn file_descriptor(&self) -> &FileDescriptor {
        &self.0
    }
}

impl SynchronousMultiplexing for Descriptor<'_> {}

/// What a process waits for.
#[derive(Debug)]
pub struct Waits<'a> {
    listeners: Vec<(&'a Listener<Ipc>, Option<Duration>)>,
    descriptors: Vec<Descriptor<'a>>,
    tick: Duration,
}

impl<'a> Waits<'a> {
    /// Wakes at least every `tick`.
    pub fn every(tick: Duration) -> Self {
        Self {
            listeners: Vec::new(),
            descriptors: Vec::new(),
            tick,
        }
    }

    /// Also wakes for each message, and when none has come for `deadline`: the watchdog against stale poses.
    #[must_use]
    pub fn message<T>(mut self, subscriber: &'a Subscriber<T>, deadline: Option<Duration>) -> Self
    where
        T: Message,
    {
        self.listeners.extend(subscriber.listener().map(|l| (l, deadline)));
        self
    }

    /// Also wakes for each header with its values.
    #[must_use]
    pub fn headed<H: Message + Default, T: Value>(mut self, subscriber: &'a HeadedSubscriber<H, T>) -> Self {
        self.listeners.extend(subscriber.listener().map(|l| (l, None)));
        self
    }

    /// Also wakes for each image of a view that was opened waking.
    #[must_use]
    pub fn frames(mut self, subscriber: &'a FrameSubscriber) -> Self {
        self.listeners.extend(subscriber.listener().map(|l| (l, None)));
        self
    }

    /// Also wakes while there is something to be read from `descriptor`: the step reads it all.
    #[must_use]
    pub fn readable(mut self, descriptor: BorrowedFd<'a>) -> Self {
        // Not owned: it is closed by who opened it, and borrowed for as long as this waits.
        let found = FileDescriptor::non_owning_new(descriptor.as_raw_fd());
        self.descriptors
            .extend(found.map(|found| Descriptor(found, PhantomData)));
        self
    }

    /// Also wakes for each request.
    #[must_use]
    pub fn request(mut self, server: &'a CommandServer) -> Self {
        self.listeners.push((server.listener(), None));
        self
    }

    /// Calls `step` each time something happened, until it breaks. The process handles its own signals: a signal only
    /// wakes it.
    ///
    /// # Errors
    /// [`BusError::Transfer`] where the wait itself fails; what `step` breaks with is passed on.
    pub fn run<B>(self, mut step: impl FnMut() -> ControlFlow<B>) -> Result<B, BusError> {
        let fail = |e: String| BusError::Transfer {
            topic: "wake".to_owned(),
            what: "waiting",
            why: e,
        };
        let waitset = WaitSetBuilder::new()
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Ipc>()
            .map_err(|e| fail(format!("{e:?}")))?;
        let mut guards = Vec::new();
        for (listener, deadline) in &self.listeners {
            guards.push(
                match deadline {
                    Some(deadline) => waitset.attach_deadline(*listener, *deadline),
                    None => waitset.attach_notification(*listener),
                }
                .map_err(|e| fail(format!("{e:?}")))?,
            );
        }
        for descriptor in &self.descriptors {
            let guard = waitset.attach_notification(descriptor);
            guards.push(guard.map_err(|e| fail(format!("{e:?}")))?);
        }
        loop {
            if let ControlFlow::Break(result) = step() {
                return Ok(result);
            }
            if guards.is_empty() {
                std::thread::sleep(self.tick);
                continue;
            }
            let woken = waitset
                .wait_and_process_once_with_timeout(|_| CallbackProgression::Continue, self.tick)
                .map_err(|e| fail(format!("{e:?}")))?;
            if woken == WaitSetRunResult::TerminationRequest {
                // Not reachable with signal handling disabled; the step decides in any case.
                continue;
            }
            for (listener, _) in &self.listeners {
                // Several notifications may have merged into one: the step drains its ports, so they need no counting.
                let _ = listener.try_wait(|_| {});
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Read, Write};
    use std::os::fd::AsFd;
    use std::os::unix::net::UnixStream;

    #[test]
    fn what_becomes_readable_wakes_and_what_is_not_read_wakes_again() {
        let (mut near, mut far) = UnixStream::pair().unwrap();
        far.write_all(b"ab").unwrap();
        // A wait that did not look at it would last an hour.
        let waits = Waits::every(Duration::from_secs(3600));
        let socket = near.try_clone().unwrap();
        let mut turns = 0;
        let read = waits.readable(socket.as_fd()).run(|| {
            turns += 1;
            let mut byte = [0];
            match turns {
                1 => ControlFlow::Continue(()),
                2 => {
                    near.read_exact(&mut byte).unwrap();
                    ControlFlow::Continue(())
                }
                _ => {
                    near.read_exact(&mut byte).unwrap();
                    ControlFlow::Break(byte[0])
                }
            }
        });
        assert_eq!((read.unwrap(), turns), (b'b', 3));
    }
}
