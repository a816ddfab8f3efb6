//! Rendered images: pixels behind their stamp.

use std::rc::Rc;

use iceoryx2::port::ReceiveError;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::Publisher as IoxPublisher;
use iceoryx2::port::subscriber::Subscriber as IoxSubscriber;
use iceoryx2::port::update_connections::UpdateConnections as _;
use iceoryx2::sample::Sample;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use super::places::take_place;
use super::{limited, listener, notifier, open_error, service_name, transfer_error};
use crate::clock::Clock;
use crate::message::{Ages, FrameHeader, FrameStamp, FrameState};
use crate::node::{Ipc, patiently};
use crate::topic::{Topic, VIEW_FRAME};
use crate::{Bus, BusError};

pub(super) fn service(bus: &Bus, topic: &Topic, name: &str) -> Result<PortFactory<Ipc, [u8], FrameHeader>, BusError> {
    let builder = bus
        .node
        .service_builder(&service_name(name)?)
        .publish_subscribe::<[u8]>()
        .user_header::<FrameHeader>();
    limited(builder, topic)
        .open_or_create()
        .map_err(open_error(name, "join"))
}

/// The renderer's end of one view.
#[derive(Debug)]
pub struct FramePublisher {
    port: IoxPublisher<Ipc, [u8], FrameHeader>,
    notifier: Option<Notifier<Ipc>>,
    name: String,
}

impl FramePublisher {
    /// Becomes the publisher of the view named `view` on `topic` (live or held), with images of up to `bytes`.
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn open(bus: &Bus, topic: &Topic, view: &str, bytes: usize) -> Result<Self, BusError> {
        let name = topic.of(view);
        patiently(bus, || {
            let port = service(bus, topic, &name)?
                .publisher_builder()
                .initial_max_slice_len(bytes)
                .create()
                .map_err(open_error(&name, "publish"))?;
            Ok(Self {
                port,
                notifier: notifier(bus, topic, &name)?,
                name: name.clone(),
            })
        })
    }

    /// Publishes an image and wakes who waits for it; `rgba` holds `width * height * 4` bytes. Stamps the moment at which it is handed over, and
    /// returns the stamp as sent; `None`, and nothing is sent, where that moment is later than `latest_ns`.
    ///
    /// # Errors
    /// [`BusError::Transfer`].
    pub fn send(
        &self,
        mut header: FrameHeader,
        rgba: &[u8],
        clock: &Clock,
        latest_ns: i64,
    ) -> Result<Option<FrameStamp>, BusError> {
        let sample = self
            .port
            .loan_slice_uninit(rgba.len())
            .map_err(transfer_error(&self.name, "taking memory"))?;
        let mut sample = sample.write_from_slice(rgba);
        header.stamp.t_framed_ns = clock.now_ns();
        if header.stamp.t_framed_ns > latest_ns {
            return Ok(None);
        }
        *sample.user_header_mut() = header;
        sample.send().map_err(transfer_error(&self.name, "publishing"))?;
        if let Some(notifier) = &self.notifier {
            // A viewer that died a moment ago makes this fail; the others were woken.
            let _ = notifier.notify();
        }
        Ok(Some(header.stamp))
    }

    /// Gives late joiners the last image, also while nothing new is drawn.
    pub fn serve_late_joiners(&self) {
        let _ = self.port.update_connections();
    }
}

/// A viewer's end of one view.
#[derive(Debug)]
pub struct FrameSubscriber {
    port: Rc<IoxSubscriber<Ipc, [u8], FrameHeader>>,
    listener: Option<Listener<Ipc>>,
    name: String,
}

/// An image in shared memory. Not drawn over for as long as this is held.
#[derive(Debug)]
pub struct Frame {
    sample: Sample<Ipc, [u8], FrameHeader>,
    /// A publisher takes back what it lent to a subscriber that has gone, though the mapping stays.
    _port: Rc<IoxSubscriber<Ipc, [u8], FrameHeader>>,
}

/// The pixels of an image together with what they may claim at the moment they were asked for.
#[derive(Debug, Clone, Copy)]
pub struct Shown<'a> {
    /// What the image may claim; `None` for a code that is not known. Where it differs from the stamp's own state, the words
    /// on the image are no longer true, and whoever shows it must cover them.
    pub state: Option<FrameState>,
    /// RGBA, row by row from the top.
    pub rgba: &'a [u8],
}

impl FrameSubscriber {
    /// Subscribes to the view named `view` on `topic` (live or held).
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn open(bus: &Bus, topic: &Topic, view: &str) -> Result<Self, BusError> {
        let name = topic.of(view);
        patiently(bus, || {
            let service = service(bus, topic, &name)?;
            let port = take_place((bus, &service), (&name, "subscribe"), |service| {
                service.subscriber_builder().buffer_size(1).history_request(1).create()
            })?;
            Ok(Self {
                port: Rc::new(port),
                listener: None,
                name: name.clone(),
            })
        })
    }

    /// The same for live images, and woken by each of them: see [`crate::wake`].
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn open_waking(bus: &Bus, view: &str) -> Result<Self, BusError> {
        Self::open_waking_on(bus, &VIEW_FRAME, view)
    }

    /// The same on another topic that wakes.
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn open_waking_on(bus: &Bus, topic: &Topic, view: &str) -> Result<Self, BusError> {
        let mut subscriber = Self::open(bus, topic, view)?;
        subscriber.listener = Some(listener(bus, topic, &subscriber.name)?);
        Ok(subscriber)
    }

    pub(crate) fn listener(&self) -> Option<&Listener<Ipc>> {
        self.listener.as_ref()
    }

    /// The newest image since the last call.
    ///
    /// # Errors
    /// [`BusError::Transfer`], also where as many images are held as may be borrowed.
    pub fn newest(&self) -> Result<Option<Frame>, BusError> {
        let mut newest = None;
        loop {
            let sample = match self.port.receive() {
                Ok(Some(sample)) => sample,
                Ok(None) => break,
                // One came while another was taken, and there is no room for both: it is had with the next call.
                Err(ReceiveError::ExceedsMaxBorrows) if newest.is_some() => break,
                Err(error) => return Err(transfer_error(&self.name, "receiving")(error)),
            };
            newest = Some(Frame {
                sample,
                _port: Rc::clone(&self.port),
            });
        }
        Ok(newest.filter(Frame::is_whole))
    }
}

impl Frame {
    fn is_whole(&self) -> bool {
        let header = self.header();
        // Sides of 2^31 pixels would make 2^64 bytes.
        let bytes = (u64::from(header.width) * u64::from(header.height)).checked_mul(4);
        bytes == Some(self.sample.payload().len() as u64)
    }

    /// Size and stamp.
    pub fn header(&self) -> &FrameHeader {
        self.sample.user_header()
    }

    /// The pixels, with what they may claim at `now_ns` on the session's clock: an image grows old on the screen too, and for
    /// ever where its renderer has died.
    pub fn shown(&self, now_ns: i64, ages: Ages) -> Shown<'_> {
        Shown {
            state: self.header().stamp.state_at(now_ns, ages),
            rgba: self.sample.payload(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock::monotonic_ns;
    use crate::run::RunContext;
    use crate::wake::Waits;
    use iceoryx2::prelude::ZeroCopySend;
    use std::ops::ControlFlow;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::time::Duration;

    /// One image on the bus of a run of its own: its stamp as sent and as it came, and when it was sent at the earliest and at the latest.
    fn sent(
        header: FrameHeader,
        rgba: &[u8],
        latest_ns: impl Fn(i64) -> i64,
    ) -> (Option<FrameStamp>, Option<FrameStamp>, [i64; 2]) {
        let folder = tempfile::Builder::new().prefix("tc").tempdir_in("/tmp").unwrap();
        let run = RunContext::new(folder.path(), monotonic_ns()).unwrap();
        let bus = Bus::join(&run).unwrap();
        let publisher = FramePublisher::open(&bus, &VIEW_FRAME, "v", 8).unwrap();
        let subscriber = FrameSubscriber::open(&bus, &VIEW_FRAME, "v").unwrap();
        let before = bus.clock().now_ns();
        let stamp = publisher.send(header, rgba, bus.clock(), latest_ns(before)).unwrap();
        let after = bus.clock().now_ns();
        let came = subscriber.newest().unwrap().map(|frame| frame.header().stamp);
        drop((publisher, subscriber, bus));
        run.sweep();
        (stamp, came, [before, after])
    }

    /// A window that held a set and two more ended where an image came between the taking of another and the look for a newer one.
    #[test]
    fn an_image_that_comes_while_another_is_taken_is_had_with_the_next_call() {
        let folder = tempfile::Builder::new().prefix("tc").tempdir_in("/tmp").unwrap();
        let run = RunContext::new(folder.path(), monotonic_ns()).unwrap();
        run.store().unwrap();
        let bus = Bus::join(&run).unwrap();
        let subscriber = FrameSubscriber::open(&bus, &VIEW_FRAME, "v").unwrap();
        let ended = AtomicBool::new(false);
        std::thread::scope(|threads| {
            threads.spawn(|| {
                let bus = Bus::join(&run).unwrap();
                let publisher = FramePublisher::open(&bus, &VIEW_FRAME, "v", 4).unwrap();
                let header = FrameHeader {
                    width: 1,
                    height: 1,
                    ..FrameHeader::default()
                };
                while !ended.load(Ordering::Relaxed) {
                    publisher.send(header, &[0; 4], bus.clock(), i64::MAX).unwrap();
                }
            });
            let mut held: std::collections::VecDeque<Frame> = Default::default();
            let (mut taken, mut failed) = (0, None);
            while taken < 20_000 && failed.is_none() {
                match subscriber.newest() {
                    Ok(frame) => {
                        taken += usize::from(frame.is_some());
                        held.extend(frame);
                        // One less than may be borrowed, as whoever gathers holds.
                        held.drain(..held.len().saturating_sub(VIEW_FRAME.borrowed - 1));
                    }
                    Err(error) => failed = Some(error),
                }
            }
            ended.store(true, Ordering::Relaxed);
            assert!(failed.is_none(), "{failed:?}");
        });
        drop((subscriber, bus));
        run.sweep();
    }

    #[test]
    fn a_viewer_is_woken_by_an_image_and_holds_a_set_while_the_next_one_comes() {
        let folder = tempfile::Builder::new().prefix("tc").tempdir_in("/tmp").unwrap();
        let run = RunContext::new(folder.path(), monotonic_ns()).unwrap();
        let bus = Bus::join(&run).unwrap();
        let publisher = FramePublisher::open(&bus, &VIEW_FRAME, "v", 8).unwrap();
        let subscriber = FrameSubscriber::open_waking(&bus, "v").unwrap();
        let mut held = Vec::new();
        for seq in 0..5 {
            let mut header = header(WHOLE);
            header.stamp.seq = seq;
            publisher.send(header, &[seq as u8; 8], bus.clock(), i64::MAX).unwrap();
            let wait = Waits::every(Duration::from_secs(60)).frames(&subscriber);
            let mut turns = 0;
            let frame = wait.run(|| {
                turns += 1;
                // The first turn comes before any wait: only what woke it counts.
                match (turns > 1).then(|| subscriber.newest().unwrap()).flatten() {
                    Some(frame) => ControlFlow::Break(frame),
                    None => ControlFlow::Continue(()),
                }
            });
            held.push(frame.unwrap());
            // As many as a set that is shown and two that gather.
            if held.len() > 3 {
                held.remove(0);
            }
        }
        let pixels: Vec<u8> = held.iter().map(|frame| frame.shown(0, ages()).rgba[0]).collect();
        assert_eq!(pixels, [2, 3, 4]);
        drop((held, publisher, subscriber, bus));
        run.sweep();
    }

    /// As long as the header of the version before, under its name.
    #[derive(Debug, Default, Clone, Copy, ZeroCopySend)]
    #[repr(C)]
    #[type_name("trocar/FrameHeader/2")]
    struct HeaderBefore {
        stamp: FrameStamp,
        size: [u32; 2],
    }

    #[test]
    fn a_renderer_of_another_version_is_refused_with_the_name_of_the_view() {
        let folder = tempfile::Builder::new().prefix("tc").tempdir_in("/tmp").unwrap();
        let run = RunContext::new(folder.path(), monotonic_ns()).unwrap();
        let bus = Bus::join(&run).unwrap();
        let publisher = FramePublisher::open(&bus, &VIEW_FRAME, "v", 8).unwrap();
        let builder = bus.node.service_builder(&service_name("view/v").unwrap());
        let builder = builder.publish_subscribe::<[u8]>().user_header::<HeaderBefore>();
        let before = limited(builder, &VIEW_FRAME)
            .open()
            .map_err(open_error("view/v", "join"));
        let words = before.unwrap_err().to_string();
        assert!(
            words.contains("view/v") && words.contains("IncompatibleTypes"),
            "{words}"
        );
        drop((publisher, bus));
        run.sweep();
    }

    fn ages() -> Ages {
        Ages {
            stale_ns: 1,
            lost_ns: 2,
        }
    }

    const WHOLE: [u32; 2] = [2, 1];

    fn header([width, height]: [u32; 2]) -> FrameHeader {
        FrameHeader {
            width,
            height,
            ..FrameHeader::default()
        }
    }

    #[test]
    fn an_image_that_is_handed_over_too_late_is_not_sent() {
        let (stamp, came, _) = sent(header(WHOLE), &[7; 8], |now| now - 1);
        assert_eq!((stamp, came), (None, None));
    }

    #[test]
    fn an_image_bears_the_moment_at_which_it_was_handed_over() {
        let (stamp, came, [before, after]) = sent(header(WHOLE), &[7; 8], |_| i64::MAX);
        assert_eq!(stamp, came);
        assert!((before..=after).contains(&came.unwrap().t_framed_ns));
    }

    #[test]
    fn an_image_whose_pixels_are_not_those_of_its_header_does_not_come() {
        let eight = &[7; 8][..];
        let cases = [
            ([2, 2], eight),
            ([1, 1], eight),
            ([0, 0], eight),
            ([u32::MAX; 2], eight),
            ([1 << 31; 2], &[]),
        ];
        for (size, rgba) in cases {
            let (stamp, came, _) = sent(header(size), rgba, |_| i64::MAX);
            assert!(stamp.is_some() && came.is_none(), "{size:?}");
        }
    }
}
