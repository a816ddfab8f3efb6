//! A guest that gathers the images of all views of a run, as a viewer does, and counts.

use std::ops::ControlFlow;
use std::path::Path;
use std::time::Duration;

use bus::Bus;
use bus::gather::{Gather, PoseId, Set};
use bus::message::FrameHeader;
use bus::port::FrameSubscriber;
use bus::run::RunContext;
use bus::wake::Waits;

/// A screen's time from one picture to the next.
const PICTURE_NS: i64 = 16_666_667;
/// The loop looks at least this often; images wake it besides.
const TICK: Duration = Duration::from_millis(4);

/// What a viewer would have shown.
#[derive(Debug, Default)]
pub struct Counts {
    /// Pictures in which all views show one pose.
    pub one: u32,
    /// Pictures in which they do not.
    pub mixed: u32,
    /// Different poses that all views showed.
    pub sets: u32,
    /// How long, s.
    pub seconds: f64,
    /// Ages of the poses of sets in the moments they were shown, ms.
    pub ages_ms: Vec<f64>,
    /// Images of each view.
    pub images: Vec<u32>,
}

/// Counts for `seconds` in the run of this folder; `stale_ns` is the scene's limit.
pub fn count(run: &Path, views: &[String], stale_ns: i64, seconds: f64) -> Counts {
    let bus = Bus::join(&RunContext::load(run).unwrap()).unwrap();
    let subscribers: Vec<_> = views
        .iter()
        .map(|view| FrameSubscriber::open_waking(&bus, view).unwrap())
        .collect();
    let mut gather = Gather::new(views.len());
    let mut counts = Counts {
        images: vec![0; views.len()],
        seconds,
        ..Counts::default()
    };
    let began = bus.clock().now_ns();
    let (mut next, mut shown) = (began, None);
    let mut waits = Waits::every(TICK);
    for subscriber in &subscribers {
        waits = waits.frames(subscriber);
    }
    waits
        .run(|| {
            for (view, subscriber) in subscribers.iter().enumerate() {
                if let Some(frame) = subscriber.newest().unwrap() {
                    let FrameHeader { stamp, .. } = *frame.header();
                    gather.put(view, PoseId::of(&stamp), frame);
                    counts.images[view] += 1;
                }
            }
            let now = bus.clock().now_ns();
            if now >= next {
                next = (next + PICTURE_NS).max(now);
                match gather.decide(now, stale_ns) {
                    Some(Set::One(pose)) => {
                        counts.one += 1;
                        counts.sets += u32::from(shown.replace(pose) != Some(pose));
                        counts.ages_ms.push((now - pose.t_capture_ns) as f64 / 1e6);
                    }
                    _ => counts.mixed += 1,
                }
            }
            match now - began > (seconds * 1e9) as i64 {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        })
        .unwrap();
    counts.ages_ms.sort_by(f64::total_cmp);
    counts
}

impl Counts {
    /// A row of a table.
    pub fn row(&self) -> String {
        let all = f64::from((self.one + self.mixed).max(1));
        let age = |part: f64| {
            let place = (part * (self.ages_ms.len().max(1) - 1) as f64) as usize;
            self.ages_ms.get(place).copied().unwrap_or(f64::NAN)
        };
        let per_s = |count: u32| f64::from(count) / self.seconds;
        let images: Vec<String> = self
            .images
            .iter()
            .map(|&count| format!("{:.0}", per_s(count)))
            .collect();
        format!(
            "{:.1} % | {:.1} | {:.0} / {:.0} | {}",
            100.0 * f64::from(self.one) / all,
            per_s(self.sets),
            age(0.5),
            age(0.99),
            images.join(" ")
        )
    }
}
